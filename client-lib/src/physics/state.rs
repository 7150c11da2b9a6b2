//! State words of a physics object (`spec/06-physics-object.md`, A4).

use bitflags::bitflags;

bitflags! {
    /// Physics state, as on the wire. Undefined bits are preserved.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    pub struct PhysicsState: u32 {
        /// Scenery of the dat files; never becomes active.
        const STATIC = 0x0000_0001;
        /// Passable, but reported.
        const ETHEREAL = 0x0000_0004;
        /// Collision callbacks of this object's weenie are made.
        const REPORT_COLLISIONS = 0x0000_0008;
        /// The other party's callbacks about this object are suppressed.
        const IGNORE_COLLISIONS = 0x0000_0010;
        /// Not drawn.
        const NODRAW = 0x0000_0020;
        /// A projectile: path clipped, exempt from many collisions.
        const MISSILE = 0x0000_0040;
        /// No effect in any reference.
        const PUSHABLE = 0x0000_0080;
        /// The heading follows the displacement of each step.
        const ALIGN_PATH = 0x0000_0100;
        /// Not read; path clipping comes from MISSILE.
        const PATH_CLIPPED = 0x0000_0200;
        /// Falls.
        const GRAVITY = 0x0000_0400;
        /// Lights are on.
        const LIGHTING_ON = 0x0000_0800;
        /// Emits particles.
        const PARTICLE_EMITTER = 0x0000_1000;
        /// Neither animated nor integrated.
        const HIDDEN = 0x0000_4000;
        /// Plays its default script on collision.
        const SCRIPTED_COLLISION = 0x0000_8000;
        /// Collides by the physics BSP of its parts.
        const HAS_PHYSICS_BSP = 0x0001_0000;
        /// Velocity becomes 0 on a bounce.
        const INELASTIC = 0x0002_0000;
        /// Static animation.
        const HAS_DEFAULT_ANIM = 0x0004_0000;
        /// Has a default script.
        const HAS_DEFAULT_SCRIPT = 0x0008_0000;
        /// Cosmetic.
        const CLOAKED = 0x0010_0000;
        /// Hitting it is reported as an environment collision.
        const REPORT_COLLISIONS_AS_ENVIRONMENT = 0x0020_0000;
        /// Does not walk off edges.
        const EDGE_SLIDE = 0x0040_0000;
        /// Sleds.
        const SLEDDING = 0x0080_0000;
        /// Updates do nothing.
        const FROZEN = 0x0100_0000;
        /// Bits without a name are kept.
        const _ = !0;
    }
}

bitflags! {
    /// Transient state: never on the wire.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    pub struct TransientState: u32 {
        /// Touches a contact plane.
        const CONTACT = 0x001;
        /// That plane is walkable.
        const ON_WALKABLE = 0x002;
        /// The sliding normal is valid for the next transition.
        const SLIDING = 0x004;
        /// The contact plane is water.
        const WATER_CONTACT = 0x008;
        /// The last transition made no progress, once.
        const STATIONARY_FALL = 0x010;
        /// Twice.
        const STATIONARY_STOP = 0x020;
        /// Three times.
        const STATIONARY_STUCK = 0x040;
        /// Steps do work.
        const ACTIVE = 0x080;
        /// Tries to become solid at each step.
        const CHECK_ETHEREAL = 0x100;
        /// Bits without a name are kept.
        const _ = !0;
    }
}
