//! The game-logic companion of an object: the questions the client asks it, as plain answers (`spec/06-physics-object.md`, A8).

use crate::math::Vec3;
use crate::motion::Character;

/// What an object's game-logic companion answers. The yes/no questions of the collision code are in
/// [`WeenieFlags`](crate::physics::body::WeenieFlags).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Weenie {
    /// Answer to `InqRunRate`; `None` = does not answer.
    pub run_rate: Option<f32>,
    /// Answer to `InqJumpVelocity` for extent 1, m/s; scaled by the extent. `None` = does not answer.
    pub jump_velocity: Option<f32>,
    /// Answer to `CanJump`.
    pub can_jump: bool,
    /// Answer to `JumpStaminaCost`; `None` = does not answer.
    pub jump_stamina_cost: Option<i32>,
    /// Answers these four by the formulas of a character instead.
    pub character: Option<Character>,
    /// Is a corpse: placed without a collision test.
    pub corpse: bool,
    /// Answer to `InqCollisionProfile`.
    pub profile: Option<CollisionProfile>,
    /// The object is a house that bars its cells.
    pub house: Option<HouseAccess>,
    /// Collision callbacks are kept in [`Entity::reports`](super::Entity::reports) for the host, which empties the list.
    pub collects_reports: bool,
}

/// Answer to `InqCollisionProfile`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CollisionProfile {
    /// Weenie class id.
    pub wcid: u32,
    /// Item type word.
    pub item_type: u32,
    /// Creature 0x1, Player 0x2, Attackable 0x4, Door 0x40.
    pub flags: u32,
}

/// Who may enter the cells of a house (`spec/03-cells.md`, 13.6).
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct HouseAccess {
    /// There is no owner, or the house is open.
    pub open: bool,
    /// GUIDs of those who may enter.
    pub guests: Vec<u32>,
}

impl Weenie {
    /// Whether a mover may enter the cells that this object bars.
    pub fn admits(&self, guid: u32) -> bool {
        self.house
            .as_ref()
            .is_some_and(|house| house.open || house.guests.contains(&guid))
    }
}

/// A touch, as told to a weenie.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ObjectReport {
    /// The other party.
    pub guid: u32,
    /// Velocity of the mover relative to what it hit, m/s.
    pub velocity: Vec3,
    /// The other party's profile, with Missile 0x8, Contact 0x10 and MyContact 0x20 in `flags`; `None` if its weenie has none.
    pub profile: Option<CollisionProfile>,
}

/// The hit of a missile or of an attack of an animation, as told to a weenie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AttackReport {
    /// The other party.
    pub guid: u32,
    /// Where it was hit: High 0x1, Medium 0x2, Low 0x4, Left 0x8, Right 0x10, Front 0x20, Back 0x40.
    pub quadrant: u32,
    /// The attacking part; [`AttackReport::WHOLE`] for a missile.
    pub part: u32,
}

impl AttackReport {
    /// Part number of an attacker that hits with its whole body.
    pub const WHOLE: u32 = u32::MAX;
}

/// A touch of the environment, as told to a weenie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvironmentReport {
    /// Own velocity at that time, m/s.
    pub velocity: Vec3,
    /// The object was in contact before the step.
    pub my_contact: bool,
}

/// A callback of C8.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CollisionReport {
    /// `DoCollision` with an object profile.
    Object(ObjectReport),
    /// `DoCollision` with an attack profile.
    Attack(AttackReport),
    /// `DoCollision` with an environment profile.
    Environment(EnvironmentReport),
    /// `DoCollisionEnd`: the contact with this GUID ended.
    End(u32),
}
