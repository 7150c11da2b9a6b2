//! One part of an object (`spec/07-animation.md`, 4; retail `CPhysicsPart`).

use std::sync::Arc;

use crate::math::{Position, Vec3};
use crate::physics::collision::{GfxShape, PlacedPart};

/// A shape and where it is.
#[derive(Debug, Clone)]
pub struct PhysicsPart {
    /// Full-detail shape; it carries the physics BSP.
    pub shape: Arc<GfxShape>,
    /// Scale of the shape. Collision uses the z component for all axes.
    pub scale: Vec3,
    /// Where the part is; the origin is local to the landblock of the object.
    pub position: Position,
    /// Not drawn. Cosmetic.
    pub no_draw: bool,
    /// 0 opaque to 1 invisible. Cosmetic.
    pub translucency: f32,
}

impl PhysicsPart {
    /// A part of natural size at no place yet.
    pub fn new(shape: Arc<GfxShape>) -> Self {
        Self {
            shape,
            scale: Vec3::ONE,
            position: Position::default(),
            no_draw: false,
            translucency: 0.0,
        }
    }

    /// Whether the part can be collided with.
    pub fn has_physics_bsp(&self) -> bool {
        self.shape.physics.is_some()
    }

    /// The part as the collision tests take it.
    pub fn placed(&self) -> PlacedPart<'_> {
        PlacedPart {
            shape: Some(&self.shape),
            position: &self.position,
            scale: self.scale,
        }
    }

    /// Sets the translucency; fully translucent parts are not drawn, all others are. Cosmetic.
    pub fn set_translucency(&mut self, translucency: f32) {
        self.no_draw = translucency == 1.0;
        if !self.no_draw {
            self.translucency = translucency;
        }
    }
}
