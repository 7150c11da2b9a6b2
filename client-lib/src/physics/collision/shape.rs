//! Shapes of parts.

use crate::dat::GfxObj;
use crate::math::{Sphere, Vec3};

/// The collision side of a shape.
#[derive(Debug, Clone, Default)]
pub struct GfxShape {
    /// Own id, 0x01......
    pub id: u32,
    sphere: Option<Sphere>,
    has_physics: bool,
}

impl GfxShape {
    /// From a record.
    pub fn new(record: &GfxObj) -> Self {
        Self {
            id: record.id,
            sphere: record.physics_sphere().or_else(|| record.drawing_sphere()),
            has_physics: record.physics.is_some(),
        }
    }

    /// Whether there is a physics BSP.
    pub fn has_physics_bsp(&self) -> bool {
        self.has_physics
    }

    /// Physics sphere, else drawing sphere, else a zero sphere.
    pub fn bounding_sphere(&self) -> Sphere {
        self.sphere.unwrap_or(Sphere {
            center: Vec3::ZERO,
            radius: 0.0,
        })
    }
}
