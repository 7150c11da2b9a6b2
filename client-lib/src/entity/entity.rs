//! [`Entity`]: one dynamic object and everything it owns (`spec/06-physics-object.md`, A5).
//!
//! Plain data. What others collide with is [`Body`]; what the simulation of every step reads and writes is [`Kinetics`]; the rest is
//! created on demand. Lengths are metres, velocities m/s and rad/s in world axes.

use super::weenie::{CollisionReport, Weenie};
use crate::animation::{PartArray, TimedHook};
use crate::frame::state::{FrameEvent, Step};
use crate::math::{CellId, Frame, Plane, Position, Vec3};
use crate::motion::MovementManager;
use crate::physics::body::{Body, EntityId, ObjectRef, WeenieFlags};
use crate::physics::managers::{PositionManager, TargetManager};
use crate::physics::state::{PhysicsState, TransientState};

/// State that every simulation step reads and writes: one or two cache lines.
#[derive(Debug, Clone, Copy)]
pub struct Kinetics {
    /// Transient state word.
    pub transient: TransientState,
    /// World axes, m/s.
    pub velocity: Vec3,
    /// World axes, m/s²; derived from contact and gravity (B7).
    pub acceleration: Vec3,
    /// World axes, rad/s.
    pub omega: Vec3,
    /// Displacement of the last step divided by its quantum, m/s.
    pub cached_velocity: Vec3,
    /// Fraction of the speed lost per second on walkable ground, 0..1.
    pub friction: f32,
    /// Bounce factor, 0..0.1.
    pub elasticity: f32,
    /// Last contact plane, in the block coordinates of `contact_plane_cell_id`; stale without CONTACT.
    pub contact_plane: Plane,
    /// Cell of that plane.
    pub contact_plane_cell_id: CellId,
    /// Normal of the wall slid along; stale without SLIDING.
    pub sliding_normal: Vec3,
    /// End of the simulated time, s on the frame clock. Old while the object [rests](super::Entities): read it through
    /// [`World::entity_mut`](crate::world::World::entity_mut).
    pub update_time: f64,
    /// The last movement came from the local input.
    pub last_move_was_autonomous: bool,
    /// Set by `set_velocity`, cleared at each step; no rule reads it.
    pub jumped_this_frame: bool,
    /// Touches the environment (C8).
    pub colliding_with_environment: bool,
}

impl Kinetics {
    /// Initial values of a new object whose clock starts at `now` (A5).
    pub const fn new(now: f64) -> Self {
        Self {
            transient: TransientState::empty(),
            velocity: Vec3::ZERO,
            acceleration: Vec3::ZERO,
            omega: Vec3::ZERO,
            cached_velocity: Vec3::ZERO,
            friction: 0.95,
            elasticity: 0.05,
            contact_plane: Plane {
                n: Vec3::ZERO,
                d: 0.0,
            },
            contact_plane_cell_id: CellId::NONE,
            sliding_normal: Vec3::ZERO,
            update_time: now,
            last_move_was_autonomous: false,
            jumped_this_frame: false,
            colliding_with_environment: false,
        }
    }
}

/// An attached object (D4).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Child {
    /// Who is carried.
    pub object: EntityId,
    /// Place in the space of the part, or of the parent without one.
    pub frame: Frame,
    /// Part index; [`Child::NO_PART`] for none.
    pub part: u32,
    /// Holding location id, 0 for none.
    pub location: i32,
}

impl Child {
    /// Part index that means "no part": the parent's own frame counts.
    pub const NO_PART: u32 = u32::MAX;
}

/// A remembered contact (C8).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CollisionRecord {
    /// The object touched.
    pub guid: u32,
    /// When, s.
    pub touched: f64,
    /// It was ethereal.
    pub ethereal: bool,
}

/// Remembered contacts in insertion order, one per GUID.
pub type CollisionTable = Vec<CollisionRecord>;

/// The nine counters that order network messages (A4.5).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Timestamps(pub [u16; 9]);

/// One dynamic object. Retail: `CPhysicsObj`.
#[derive(Debug, Clone)]
pub struct Entity {
    /// Own handle.
    pub id: EntityId,
    /// Place, shape and state word, as seen by others.
    pub body: Body,
    /// Hot state of the simulation.
    pub kin: Kinetics,
    /// Motion interpreter and move-to (`spec/08`); created on demand.
    pub movement: Option<Box<MovementManager>>,
    /// Interpolation, sticky and constraint (F1); created on demand.
    pub position_manager: Option<Box<PositionManager>>,
    /// Target watching (F5); created on demand.
    pub target_manager: Option<Box<TargetManager>>,
    /// Game-logic companion.
    pub weenie: Option<Weenie>,
    /// Attached objects, in insertion order.
    pub children: Vec<Child>,
    /// Remembered contacts.
    pub collision_table: CollisionTable,
    /// Timed hooks, in order of creation.
    pub hooks: Vec<TimedHook>,
    /// Counters of network messages.
    pub timestamps: Timestamps,
    /// Vector from the local player to this object, m (B3).
    pub player_vector: Vec3,
    /// Its length.
    pub player_distance: f32,
    /// Cosmetic.
    pub translucency: f32,
    /// Cosmetic: least translucency.
    pub translucency_original: f32,
    /// Cosmetic.
    pub default_script: u32,
    /// Cosmetic.
    pub default_script_intensity: f32,
    /// Shown in the interface, outside the world.
    pub examination_object: bool,
    /// Radius of attack cones, m; unused by any reference.
    pub attack_radius: f32,

    /// Nobody needs the places of the parts: they are not computed, unless a part has a physics tree or carries something (plans).
    pub unposed: bool,

    /// Callbacks fired since the driver cleared the list, in order.
    pub events: Vec<FrameEvent>,
    /// Quanta executed since the driver cleared the list.
    pub steps: Vec<Step>,
    /// GUIDs handed to the collision handler since the driver cleared the list, in order of arrival, possibly more than once.
    pub touched: Vec<u32>,
    /// One of those calls had touched the environment.
    pub touched_environment: bool,
    /// Reports to the weenie since the host took them, if the weenie wants them.
    pub reports: Vec<CollisionReport>,
}

impl Entity {
    /// An object without setup, outside the world (`InitObjectBegin`). `now` is the frame clock in s.
    pub fn new(id: EntityId, guid: u32, now: f64) -> Self {
        Self {
            id,
            body: Body {
                guid,
                position: Position::default(),
                cell: None,
                state: PhysicsState::from_bits_retain(Self::DEFAULT_STATE),
                scale: 1.0,
                part_array: None,
                weenie: WeenieFlags::default(),
                target: 0,
                parent: None,
                shadows: Vec::new(),
            },
            kin: Kinetics::new(now),
            movement: None,
            position_manager: None,
            target_manager: None,
            weenie: None,
            children: Vec::new(),
            collision_table: Vec::new(),
            hooks: Vec::new(),
            timestamps: Timestamps::default(),
            player_vector: Vec3::Z,
            player_distance: f32::MAX,
            translucency: 0.0,
            translucency_original: 0.0,
            default_script: 0,
            default_script_intensity: 0.0,
            examination_object: false,
            attack_radius: 0.0,
            unposed: false,
            events: Vec::new(),
            steps: Vec::new(),
            touched: Vec::new(),
            touched_environment: false,
            reports: Vec::new(),
        }
    }

    /// State word of a new object: EDGE_SLIDE, LIGHTING_ON, GRAVITY, REPORT_COLLISIONS.
    pub const DEFAULT_STATE: u32 = 0x0040_0C08;

    /// Instance id.
    pub const fn guid(&self) -> u32 {
        self.body.guid
    }

    /// This object, as shadow lists and collision records name it.
    pub const fn object_ref(&self) -> ObjectRef {
        ObjectRef::Entity(self.id)
    }

    /// Skeleton, sequence and motion table, if there is a setup.
    pub const fn part_array(&self) -> Option<&PartArray> {
        self.body.part_array.as_ref()
    }

    /// Skeleton, sequence and motion table, if there is a setup.
    pub const fn part_array_mut(&mut self) -> Option<&mut PartArray> {
        self.body.part_array.as_mut()
    }
}
