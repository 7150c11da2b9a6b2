//! Setups that no file holds (`spec/07-animation.md`, 5).

use crate::dat::{AnimFrame, Setup, StoredFrame};
use crate::physics::collision::GfxShape;

/// The setup of an object that is one shape: no collision spheres, and one pose under key 0 with the part in its place.
pub(crate) fn simple_setup(shape: &GfxShape) -> Setup {
    let mut setup = Setup::empty(0);
    setup.parts = vec![shape.id];
    if let Some(sphere) = shape.physics_sphere().or(shape.drawing_sphere) {
        setup.sorting_sphere = sphere;
    }
    let pose = AnimFrame {
        parts: vec![StoredFrame::IDENTITY],
        hooks: Vec::new(),
    };
    setup.placements = std::iter::once((0, pose)).collect();
    setup
}
