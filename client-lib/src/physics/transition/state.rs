//! Records of a transition (`spec/05-transition.md`, section 5). Field names are those of the specification.

use bitflags::bitflags;

use crate::math::{CellId, Plane, Position, Sphere, Vec3};
use crate::physics::body::ObjectRef;
use crate::physics::collision::Polygon;
use crate::world::{CellHandle, CellListMemo, World};

/// What one test or insertion answers (4.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum TransitionState {
    /// No test was made.
    Invalid = 0,
    /// Nothing in the way.
    Ok = 1,
    /// Blocked; nothing was moved.
    Collided = 2,
    /// The check position was moved out of or onto a surface: test again.
    Adjusted = 3,
    /// The check position was moved along a surface: test again, the contact plane is void.
    Slid = 4,
}

/// What an insertion is for (4.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum InsertType {
    /// Normal movement: surfaces push, lift, slide.
    Transition = 0,
    /// Solid test only.
    Placement = 1,
    /// First placement: BSPs push the spheres out.
    InitialPlacement = 2,
}

bitflags! {
    /// Bits of [`ObjectInfo::state`] (4.3).
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub struct ObjectInfoState: u32 {
        /// Touches ground or a surface.
        const CONTACT = 0x0001;
        /// That surface is walkable.
        const ON_WALKABLE = 0x0002;
        /// Camera probe.
        const IS_VIEWER = 0x0004;
        /// Stops at the first hit.
        const PATH_CLIPPED = 0x0008;
        /// Takes the final orientation at once.
        const FREE_ROTATE = 0x0010;
        /// Exact time-of-impact clipping.
        const PERFECT_CLIP = 0x0040;
        /// PK rule exemption.
        const IS_IMPENETRABLE = 0x0080;
        /// Is a player.
        const IS_PLAYER = 0x0100;
        /// Does not walk off edges.
        const EDGE_SLIDE = 0x0200;
        /// Creatures are touched, not obstacles.
        const IGNORE_CREATURES = 0x0400;
        /// Is a player killer.
        const IS_PK = 0x0800;
        /// Is a player-killer lite.
        const IS_PK_LITE = 0x1000;
        /// Bits without a name are kept.
        const _ = !0;
    }
}

/// The mover, as the transition sees it (5.1).
#[derive(Debug, Clone, Copy)]
pub struct ObjectInfo {
    /// The moving object; `None` in tests of single primitives.
    pub object: Option<ObjectRef>,
    /// Its GUID (0 without one).
    pub guid: u32,
    /// Bits of 4.3.
    pub state: ObjectInfoState,
    /// Physics state of the mover.
    pub physics_state: crate::physics::state::PhysicsState,
    /// Object scale.
    pub scale: f32,
    /// Step-up height, m.
    pub step_up_height: f32,
    /// Step-down height, m.
    pub step_down_height: f32,
    /// The mover is ethereal.
    pub ethereal: bool,
    /// The mover may be lowered onto the ground: not a missile.
    pub step_down: bool,
    /// The missile's target GUID, 0 = none.
    pub target_id: u32,
    /// The mover has a weenie that is a creature.
    pub creature: bool,
    /// The mover's weenie may enter barred house cells.
    pub bypasses_restrictions: bool,
    /// A house barrier has let the mover pass in this transition (`C-15`, profile `ace`).
    pub barrier_passed: bool,
    /// `kill_velocity` was called: the caller sets the mover's velocity to zero (7.2).
    pub velocity_killed: bool,
}

/// A plane with what goes with it in collision info (5.3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactPlane {
    /// Whether the other fields mean something.
    pub valid: bool,
    /// In block coordinates of `cell_id`.
    pub plane: Plane,
    /// Cell whose block the plane is in.
    pub cell_id: CellId,
    /// "Do not extend this plane": water, and planes tangent to spheres and cylinders.
    pub is_water: bool,
}

/// Path of the mover's spheres (5.2). "Block coordinates" are metres local to the landblock of the named position.
#[derive(Debug, Clone)]
pub struct SpherePath<'w> {
    /// Number of spheres used, 0..=2.
    pub num_sphere: usize,
    /// Object-space spheres, scaled.
    pub local_sphere: [Sphere; 2],
    /// Lowest point of the first.
    pub local_low_point: Vec3,
    /// Spheres at `check_pos`, in its block coordinates.
    pub global_sphere: [Sphere; 2],
    /// `local_low_point` at `check_pos`.
    pub global_low_point: Vec3,
    /// Spheres at `check_pos`, in the space of the part or cell being tested.
    pub localspace_sphere: [Sphere; 2],
    /// Lowest point of the first along `-localspace_z`.
    pub localspace_low_point: Vec3,
    /// Sphere centres at `curr_pos`, same space.
    pub localspace_curr_center: [Vec3; 2],
    /// Sphere centres at `curr_pos`, in its block coordinates.
    pub global_curr_center: [Vec3; 2],
    /// Position of the part or cell being tested.
    pub localspace_pos: Position,
    /// World up in that space.
    pub localspace_z: Vec3,
    /// Start cell.
    pub begin_cell: Option<CellHandle>,
    /// Start; `None` in a placement.
    pub begin_pos: Option<Position>,
    /// Goal.
    pub end_pos: Position,
    /// Cell of the last accepted state.
    pub curr_cell: Option<CellHandle>,
    /// Last accepted state: the result.
    pub curr_pos: Position,
    /// Cell of the state under test.
    pub check_cell: Option<CellHandle>,
    /// State under test.
    pub check_pos: Position,
    /// The step being tried, m, after `adjust_offset`.
    pub global_offset: Vec3,
    /// Inside `step_up`.
    pub step_up: bool,
    /// Normal of the obstacle being climbed or landed on.
    pub step_up_normal: Vec3,
    /// Airborne hit recorded, landing to be decided.
    pub collide: bool,
    /// Mode.
    pub insert_type: InsertType,
    /// Single saved copy of the mode.
    pub backup: InsertType,
    /// Inside `step_down`.
    pub step_down: bool,
    /// Height being stepped down, m.
    pub step_down_amt: f32,
    /// Share of `step_down_amt`, or of the move, still allowed.
    pub walk_interp: f32,
    /// Single saved copy of the cell under test.
    pub backup_cell: Option<CellHandle>,
    /// Single saved copy of the state under test.
    pub backup_check_pos: Position,
    /// The obstacle under test can be passed.
    pub obstruction_ethereal: bool,
    /// Some touched cell is indoor.
    pub hits_interior_cell: bool,
    /// The part under test is a building shell.
    pub bldg_check: bool,
    /// Smallest normal z (in test space) accepted as ground right now.
    pub walkable_allowance: f32,
    /// Inside `check_walkable`.
    pub check_walkable: bool,
    /// Polygon last used as ground.
    pub walkable: Option<Polygon<'w>>,
    /// Sphere on it, in the polygon's space.
    pub walkable_check_pos: Sphere,
    /// Up in that space.
    pub walkable_up: Vec3,
    /// Position of the polygon's space.
    pub walkable_pos: Position,
    /// Scale of that space.
    pub walkable_scale: f32,
    /// Bookkeeping.
    pub cell_array_valid: bool,
    /// A polygon was touched although the move does not go against its normal.
    pub neg_poly_hit: bool,
    /// Handled by stepping up, else by sliding.
    pub neg_step_up: bool,
    /// Minus that polygon's normal, block coordinates.
    pub neg_collision_normal: Vec3,
    /// Placement may search around.
    pub placement_allows_sliding: bool,
}

/// What was touched (5.3).
#[derive(Debug, Clone)]
pub struct CollisionInfo {
    /// Ground or surface touched in this step.
    pub contact_plane: ContactPlane,
    /// Plane of the previous step.
    pub last_known_contact_plane: ContactPlane,
    /// Whether `sliding_normal` means something.
    pub sliding_normal_valid: bool,
    /// Horizontal wall normal to slide along.
    pub sliding_normal: Vec3,
    /// Whether `collision_normal` means something.
    pub collision_normal_valid: bool,
    /// Normal of the last obstacle.
    pub collision_normal: Vec3,
    /// Non-static objects touched, in order, without duplicates.
    pub collide_object: Vec<ObjectRef>,
    /// Last one whose result was not OK.
    pub last_collided_object: Option<ObjectRef>,
    /// Cell geometry, a building or a static object was hit while not in contact.
    pub collided_with_environment: bool,
    /// Steps without progress of a gravity object, 0..=3.
    pub frames_stationary_fall: u32,
}

/// One entry of a [`CellArray`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellArrayEntry {
    /// Full id.
    pub id: CellId,
    /// The cell, if there is one.
    pub cell: Option<CellHandle>,
}

/// Cells touched, in test order (`spec/03-cells.md`, 6.8).
#[derive(Debug, Clone, Default)]
pub struct CellArray {
    /// Ordered, no id twice.
    pub cells: Vec<CellArrayEntry>,
    /// Outdoor cells of the parts were added.
    pub added_outside: bool,
    /// Restrict the result to what the start cell sees.
    pub do_not_load_cells: bool,
    /// Slots that removed entries left, the last one first to be reused (`C-03`, profile `ace`).
    pub free_slots: Vec<u32>,
}

/// How far a transition has got, for traces; nothing in the transition reads it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Progress {
    /// Sub-steps that the path was cut into (10.2).
    pub planned: u32,
    /// Sub-steps inserted and validated.
    pub done: u32,
    /// What the insert of the last sub-step answered, before validation.
    pub last_insert: Option<TransitionState>,
}

/// One transition: what moves, along which path, and what it met. The world is read-only while it runs.
#[derive(Debug, Clone)]
pub struct Transition<'w> {
    /// The world.
    pub world: &'w World,
    /// The mover.
    pub object: ObjectInfo,
    /// Its path.
    pub path: SpherePath<'w>,
    /// What it met.
    pub info: CollisionInfo,
    /// Cells touched.
    pub cells: CellArray,
    /// Where that list is still the right one.
    pub(crate) list_memo: Option<CellListMemo>,
    /// Counters.
    pub progress: Progress,
    /// Something that can be loaded was looked up and is not loaded: the result means nothing, load it and run again.
    pub missing: Option<CellId>,
}
