//! The state of one entity after one frame: what a trace records and a comparison looks at.
//!
//! A [`FrameState`] is the in-memory form of one line of an expected-state trace (`spec/scene-format.md`, "Expected-state
//! trace"). The simulation writes one per tracked entity and frame, the trace format stores it, the comparison puts the
//! produced one beside the expected one. It is plain data: reused from frame to frame it does not allocate.
//!
//! Two kinds of "nothing" differ here. A field can be *absent* (the source cannot supply it, a comparison leaves it out): its
//! bit in [`FrameState::has`] is clear. Or it can be *null* (there is no contact plane): its bit is set and the value is `None`.
//!
//! Units: metres, seconds, m/s, m/s², rad/s. Positions are landblock-local, velocities in world space.

use bitflags::bitflags;

bitflags! {
    /// Which fields of a record are present.
    ///
    /// The bits of the parts of `contact_plane`, `anim` and `motion` count only while that value is not null.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub struct Fields: u32 {
        /// [`FrameState::origin`].
        const ORIGIN = 1 << 0;
        /// [`FrameState::rotation`].
        const ROTATION = 1 << 1;
        /// [`FrameState::velocity`].
        const VELOCITY = 1 << 2;
        /// [`FrameState::acceleration`].
        const ACCELERATION = 1 << 3;
        /// [`FrameState::omega`].
        const OMEGA = 1 << 4;
        /// [`FrameState::state`].
        const STATE = 1 << 5;
        /// [`FrameState::transient`].
        const TRANSIENT = 1 << 6;
        /// [`FrameState::contact_plane`], null included.
        const CONTACT_PLANE = 1 << 7;
        /// [`FrameState::sliding_normal`], null included.
        const SLIDING_NORMAL = 1 << 8;
        /// [`FrameState::anim`], null included.
        const ANIM = 1 << 9;
        /// [`FrameState::motion`], null included.
        const MOTION = 1 << 10;
        /// [`FrameState::steps`].
        const STEPS = 1 << 11;
        /// [`FrameState::collisions`].
        const COLLISIONS = 1 << 12;
        /// [`FrameState::events`].
        const EVENTS = 1 << 13;
        /// [`ContactPlane::n`].
        const PLANE_N = 1 << 14;
        /// [`ContactPlane::d`].
        const PLANE_D = 1 << 15;
        /// [`ContactPlane::cell`].
        const PLANE_CELL = 1 << 16;
        /// [`AnimState::frame_number`].
        const ANIM_FRAME_NUMBER = 1 << 17;
        /// [`AnimState::id`].
        const ANIM_ID = 1 << 18;
        /// [`AnimState::first_cyclic`].
        const ANIM_FIRST_CYCLIC = 1 << 19;
        /// [`AnimState::queue`].
        const ANIM_QUEUE = 1 << 20;
        /// [`AnimState::velocity`].
        const ANIM_VELOCITY = 1 << 21;
        /// [`AnimState::omega`].
        const ANIM_OMEGA = 1 << 22;
        /// [`MotionState::style`].
        const MOTION_STYLE = 1 << 23;
        /// [`MotionState::substate`].
        const MOTION_SUBSTATE = 1 << 24;
        /// [`MotionState::substate_speed`].
        const MOTION_SUBSTATE_SPEED = 1 << 25;
        /// [`MotionState::forward`].
        const MOTION_FORWARD = 1 << 26;
        /// [`MotionState::forward_speed`].
        const MOTION_FORWARD_SPEED = 1 << 27;
        /// [`MotionState::sidestep`].
        const MOTION_SIDESTEP = 1 << 28;
        /// [`MotionState::sidestep_speed`].
        const MOTION_SIDESTEP_SPEED = 1 << 29;
        /// [`MotionState::turn`].
        const MOTION_TURN = 1 << 30;
        /// [`MotionState::turn_speed`].
        const MOTION_TURN_SPEED = 1 << 31;

        /// All parts of a contact plane.
        const PLANE_PARTS = 0b111 << 14;
        /// All parts of the animation state.
        const ANIM_PARTS = 0b11_1111 << 17;
        /// The motion-table half of the motion state.
        const MOTION_TABLE_PARTS = 0b111 << 23;
        /// The interpreted half of the motion state: absent without a motion interpreter.
        const MOTION_INTERPRETED_PARTS = 0b11_1111 << 26;
        /// All parts of the motion state.
        const MOTION_PARTS = Self::MOTION_TABLE_PARTS.bits() | Self::MOTION_INTERPRETED_PARTS.bits();
        /// What the short record of an entity that is gone carries beside its cell.
        const GONE = Self::EVENTS.bits();
    }
}

/// One record: the state of one entity after one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameState {
    /// Which of the fields below are present. `frame`, `time`, `guid` and `cell` always are.
    pub has: Fields,
    /// 0-based frame index; `-1` is the state after creation, before the first frame.
    pub frame: i32,
    /// Seconds on the clock, after it advanced.
    pub time: f64,
    /// The entity.
    pub guid: u32,
    /// Id of the cell it is in; 0: in no cell, or gone.
    pub cell: u32,
    /// Landblock-local position, metres.
    pub origin: [f32; 3],
    /// Orientation `[w, x, y, z]`.
    pub rotation: [f32; 4],
    /// World-space velocity, m/s.
    pub velocity: [f32; 3],
    /// World-space acceleration, m/s².
    pub acceleration: [f32; 3],
    /// World-space angular velocity, rad/s.
    pub omega: [f32; 3],
    /// Physics state word.
    pub state: u32,
    /// Transient state word.
    pub transient: u32,
    /// Contact plane, while there is contact.
    pub contact_plane: Option<ContactPlane>,
    /// Sliding normal, while sliding.
    pub sliding_normal: Option<[f32; 3]>,
    /// Animation state; null without a part array.
    pub anim: Option<AnimState>,
    /// Motion state; null without a part array and an interpreter.
    pub motion: Option<MotionState>,
    /// One entry per physics quantum run in this frame.
    pub steps: Vec<Step>,
    /// What was handed to the collision handler in this frame; the environment first, then GUIDs ascending.
    pub collisions: Vec<Collision>,
    /// Callbacks fired in this frame, in order.
    pub events: Vec<FrameEvent>,
}

/// A contact plane: points with `n·p + d = 0` in the coordinates of the landblock of `cell`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactPlane {
    /// Normal.
    pub n: [f32; 3],
    /// Distance, metres.
    pub d: f32,
    /// The cell the plane belongs to.
    pub cell: u32,
}

/// What the animation sequence is doing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AnimState {
    /// Position in the playing animation, in animation frames.
    pub frame_number: f64,
    /// DID of the playing animation, 0 for none.
    pub id: u32,
    /// There is a current node and it is the cycle.
    pub first_cyclic: bool,
    /// DIDs of the queued animations in playing order.
    pub queue: Vec<u32>,
    /// Velocity of the sequence, m/s.
    pub velocity: [f32; 3],
    /// Angular velocity of the sequence, rad/s.
    pub omega: [f32; 3],
}

/// Motion table state and interpreted motion state. Commands are full 32-bit motion commands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionState {
    /// Style (stance) of the motion table.
    pub style: u32,
    /// Substate of the motion table.
    pub substate: u32,
    /// Its speed modifier.
    pub substate_speed: f32,
    /// Interpreted forward command.
    pub forward: u32,
    /// Its speed.
    pub forward_speed: f32,
    /// Interpreted side-step command.
    pub sidestep: u32,
    /// Its speed.
    pub sidestep_speed: f32,
    /// Interpreted turn command.
    pub turn: u32,
    /// Its speed.
    pub turn_speed: f32,
}

/// One physics quantum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// Length, seconds.
    pub dt: f32,
    /// How its transition ended.
    pub outcome: Outcome,
}

/// Result of a quantum's transition (`spec/05-transition.md, 10.14`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// No transition was needed or made.
    #[default]
    None,
    /// No valid position: the object stays.
    Failed,
    /// The last sub-step's insertion was accepted as it was.
    Ok,
    /// It collided.
    Collided,
    /// It was adjusted.
    Adjusted,
    /// It slid.
    Slid,
}

impl Outcome {
    /// Every outcome, in declaration order.
    pub const ALL: [Self; 6] = [
        Self::None,
        Self::Failed,
        Self::Ok,
        Self::Collided,
        Self::Adjusted,
        Self::Slid,
    ];

    /// The name used in traces.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Failed => "failed",
            Self::Ok => "ok",
            Self::Collided => "collided",
            Self::Adjusted => "adjusted",
            Self::Slid => "slid",
        }
    }

    /// The outcome of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|outcome| outcome.name() == name)
    }
}

/// Something an entity collided with. The environment sorts first, then objects by GUID: the order of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Collision {
    /// Terrain, a wall, a dat object.
    Environment,
    /// The entity with this GUID.
    Object(u32),
}

/// A callback that fired.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FrameEvent {
    /// The movement manager was told that the entity landed.
    HitGround,
    /// The movement manager was told that the entity left the ground.
    LeaveGround,
    /// A motion ended; the full command.
    MotionDone(u32),
    /// An animation hook of this type is about to run (`spec/07-animation.md, 9.1`).
    AnimHook(u32),
}

impl std::fmt::Display for FrameEvent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::HitGround => f.write_str("hit_ground"),
            Self::LeaveGround => f.write_str("leave_ground"),
            Self::MotionDone(motion) => write!(f, "motion_done:{motion:#X}"),
            Self::AnimHook(kind) => write!(f, "anim_hook:{kind}"),
        }
    }
}

impl FrameEvent {
    /// Reads the form that [`Display`](std::fmt::Display) writes.
    pub fn parse(text: &str) -> Option<Self> {
        match text {
            "hit_ground" => return Some(Self::HitGround),
            "leave_ground" => return Some(Self::LeaveGround),
            _ => {}
        }
        if let Some(motion) = text.strip_prefix("motion_done:") {
            return parse_hex(motion).map(Self::MotionDone);
        }
        let kind = text.strip_prefix("anim_hook:")?;
        (!kind.starts_with('+'))
            .then(|| kind.parse().ok().map(Self::AnimHook))
            .flatten()
    }
}

/// Reads an id in the hexadecimal form of traces: `0x` and 1 to 8 digits.
pub fn parse_hex(text: &str) -> Option<u32> {
    let digits = text
        .strip_prefix("0x")
        .or_else(|| text.strip_prefix("0X"))?;
    if digits.is_empty() || digits.len() > 8 || digits.starts_with('+') {
        return None;
    }
    u32::from_str_radix(digits, 16).ok()
}

impl FrameState {
    /// Makes this the empty record of an entity in a frame: no field present. Keeps the lists' memory for reuse,
    /// except that of `anim`, which the writer refills in place.
    pub fn reset(&mut self, frame: i32, time: f64, guid: u32) {
        self.has = Fields::empty();
        self.frame = frame;
        self.time = time;
        self.guid = guid;
        self.cell = 0;
        self.contact_plane = None;
        self.sliding_normal = None;
        self.motion = None;
        self.steps.clear();
        self.collisions.clear();
        self.events.clear();
        if let Some(anim) = &mut self.anim {
            anim.queue.clear();
        }
    }

    /// The short record of an entity that is gone: only its events.
    pub fn gone(&mut self, frame: i32, time: f64, guid: u32, events: &[FrameEvent]) {
        self.reset(frame, time, guid);
        self.anim = None;
        self.has = Fields::GONE;
        self.events.extend_from_slice(events);
    }

    /// Makes this a copy of another record, reusing memory.
    pub fn copy_from(&mut self, other: &Self) {
        let Self {
            has,
            frame,
            time,
            guid,
            cell,
            origin,
            rotation,
            velocity,
            acceleration,
            omega,
            ..
        } = *other;
        self.reset(frame, time, guid);
        self.has = has;
        self.cell = cell;
        self.origin = origin;
        self.rotation = rotation;
        self.velocity = velocity;
        self.acceleration = acceleration;
        self.omega = omega;
        self.state = other.state;
        self.transient = other.transient;
        self.contact_plane = other.contact_plane;
        self.sliding_normal = other.sliding_normal;
        self.motion = other.motion;
        match (&mut self.anim, &other.anim) {
            (Some(anim), Some(from)) => {
                let mut queue = std::mem::take(&mut anim.queue);
                queue.clear();
                queue.extend_from_slice(&from.queue);
                *anim = AnimState { queue, ..*from };
            }
            (anim, from) => *anim = from.clone(),
        }
        self.steps.extend_from_slice(&other.steps);
        self.collisions.extend_from_slice(&other.collisions);
        self.events.extend_from_slice(&other.events);
    }

    /// Whether every field is present and equal to the other's, floating-point numbers bit for bit.
    pub fn same_bits(&self, other: &Self) -> bool {
        self.has == other.has
            && self.frame == other.frame
            && self.time.to_bits() == other.time.to_bits()
            && self.guid == other.guid
            && self.fields_same_bits(other, self.has)
    }

    /// Whether the cell and the fields named by `mask` have the same bits. Presence is not looked at.
    ///
    /// This is the inner loop of a comparison: no branch on text, no allocation.
    pub fn fields_same_bits(&self, other: &Self, mask: Fields) -> bool {
        self.cell == other.cell
            && (!mask.contains(Fields::ORIGIN) || bits3(self.origin) == bits3(other.origin))
            && (!mask.contains(Fields::ROTATION)
                || self.rotation.map(f32::to_bits) == other.rotation.map(f32::to_bits))
            && (!mask.contains(Fields::VELOCITY) || bits3(self.velocity) == bits3(other.velocity))
            && (!mask.contains(Fields::ACCELERATION)
                || bits3(self.acceleration) == bits3(other.acceleration))
            && (!mask.contains(Fields::OMEGA) || bits3(self.omega) == bits3(other.omega))
            && (!mask.contains(Fields::STATE) || self.state == other.state)
            && (!mask.contains(Fields::TRANSIENT) || self.transient == other.transient)
            && (!mask.contains(Fields::CONTACT_PLANE) || self.plane_same_bits(other, mask))
            && (!mask.contains(Fields::SLIDING_NORMAL)
                || self.sliding_normal.map(bits3) == other.sliding_normal.map(bits3))
            && (!mask.contains(Fields::ANIM) || self.anim_same_bits(other, mask))
            && (!mask.contains(Fields::MOTION) || self.motion_same_bits(other, mask))
            && (!mask.contains(Fields::STEPS) || same_steps(&self.steps, &other.steps))
            && (!mask.contains(Fields::COLLISIONS) || self.collisions == other.collisions)
            && (!mask.contains(Fields::EVENTS) || self.events == other.events)
    }

    fn plane_same_bits(&self, other: &Self, mask: Fields) -> bool {
        match (&self.contact_plane, &other.contact_plane) {
            (None, None) => true,
            (Some(a), Some(b)) => {
                (!mask.contains(Fields::PLANE_N) || bits3(a.n) == bits3(b.n))
                    && (!mask.contains(Fields::PLANE_D) || a.d.to_bits() == b.d.to_bits())
                    && (!mask.contains(Fields::PLANE_CELL) || a.cell == b.cell)
            }
            _ => false,
        }
    }

    fn anim_same_bits(&self, other: &Self, mask: Fields) -> bool {
        match (&self.anim, &other.anim) {
            (None, None) => true,
            (Some(a), Some(b)) => {
                (!mask.contains(Fields::ANIM_FRAME_NUMBER)
                    || a.frame_number.to_bits() == b.frame_number.to_bits())
                    && (!mask.contains(Fields::ANIM_ID) || a.id == b.id)
                    && (!mask.contains(Fields::ANIM_FIRST_CYCLIC)
                        || a.first_cyclic == b.first_cyclic)
                    && (!mask.contains(Fields::ANIM_QUEUE) || a.queue == b.queue)
                    && (!mask.contains(Fields::ANIM_VELOCITY)
                        || bits3(a.velocity) == bits3(b.velocity))
                    && (!mask.contains(Fields::ANIM_OMEGA) || bits3(a.omega) == bits3(b.omega))
            }
            _ => false,
        }
    }

    fn motion_same_bits(&self, other: &Self, mask: Fields) -> bool {
        match (&self.motion, &other.motion) {
            (None, None) => true,
            (Some(a), Some(b)) => {
                (!mask.contains(Fields::MOTION_STYLE) || a.style == b.style)
                    && (!mask.contains(Fields::MOTION_SUBSTATE) || a.substate == b.substate)
                    && (!mask.contains(Fields::MOTION_SUBSTATE_SPEED)
                        || a.substate_speed.to_bits() == b.substate_speed.to_bits())
                    && (!mask.contains(Fields::MOTION_FORWARD) || a.forward == b.forward)
                    && (!mask.contains(Fields::MOTION_FORWARD_SPEED)
                        || a.forward_speed.to_bits() == b.forward_speed.to_bits())
                    && (!mask.contains(Fields::MOTION_SIDESTEP) || a.sidestep == b.sidestep)
                    && (!mask.contains(Fields::MOTION_SIDESTEP_SPEED)
                        || a.sidestep_speed.to_bits() == b.sidestep_speed.to_bits())
                    && (!mask.contains(Fields::MOTION_TURN) || a.turn == b.turn)
                    && (!mask.contains(Fields::MOTION_TURN_SPEED)
                        || a.turn_speed.to_bits() == b.turn_speed.to_bits())
            }
            _ => false,
        }
    }
}

/// A list of records that keeps the memory of its records when it is cleared: what a frame writes into.
#[derive(Clone, Debug, Default)]
pub struct FrameStates {
    slots: Vec<FrameState>,
    len: usize,
}

impl FrameStates {
    /// An empty list.
    pub fn new() -> Self {
        Self::default()
    }

    /// Forgets the records, keeps their memory.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Forgets all records but the first `count`, keeps their memory.
    pub fn truncate(&mut self, count: usize) {
        self.len = self.len.min(count);
    }

    /// Appends the empty record of an entity and hands it out for filling in.
    pub fn push(&mut self, frame: i32, time: f64, guid: u32) -> &mut FrameState {
        if self.len == self.slots.len() {
            self.slots.push(FrameState::default());
        }
        self.len += 1;
        let slot = &mut self.slots[self.len - 1];
        slot.reset(frame, time, guid);
        slot
    }

    /// Makes this a copy of another list, reusing memory.
    pub fn copy_from(&mut self, other: &Self) {
        self.clear();
        for state in other.iter() {
            self.push(state.frame, state.time, state.guid)
                .copy_from(state);
        }
    }

    /// The record of an entity.
    pub fn of(&self, guid: u32) -> Option<&FrameState> {
        self.iter().find(|state| state.guid == guid)
    }
}

impl std::ops::Deref for FrameStates {
    type Target = [FrameState];

    fn deref(&self) -> &[FrameState] {
        &self.slots[..self.len]
    }
}

impl std::ops::DerefMut for FrameStates {
    fn deref_mut(&mut self) -> &mut [FrameState] {
        &mut self.slots[..self.len]
    }
}

fn bits3(v: [f32; 3]) -> [u32; 3] {
    v.map(f32::to_bits)
}

fn same_steps(a: &[Step], b: &[Step]) -> bool {
    a.len() == b.len()
        && a.iter()
            .zip(b)
            .all(|(a, b)| a.dt.to_bits() == b.dt.to_bits() && a.outcome == b.outcome)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_read_back() {
        for event in [
            FrameEvent::HitGround,
            FrameEvent::LeaveGround,
            FrameEvent::MotionDone(0x4100_0003),
            FrameEvent::AnimHook(22),
        ] {
            assert_eq!(FrameEvent::parse(&event.to_string()), Some(event));
        }
        assert_eq!(
            FrameEvent::MotionDone(0x8000_003D).to_string(),
            "motion_done:0x8000003D"
        );
        assert_eq!(FrameEvent::parse("motion_done:12"), None);
        assert_eq!(FrameEvent::parse("anim_hook:+1"), None);
    }

    #[test]
    fn sign_of_zero_counts() {
        let a = FrameState {
            has: Fields::ORIGIN,
            ..FrameState::default()
        };
        let b = FrameState {
            origin: [-0.0, 0.0, 0.0],
            ..a.clone()
        };
        assert!(a.same_bits(&a));
        assert!(!a.same_bits(&b));
        assert!(a.fields_same_bits(&b, Fields::empty()));
    }

    #[test]
    fn null_differs_from_absent_and_from_present() {
        let null = FrameState {
            has: Fields::CONTACT_PLANE,
            ..FrameState::default()
        };
        let absent = FrameState::default();
        let plane = FrameState {
            has: Fields::CONTACT_PLANE | Fields::PLANE_PARTS,
            contact_plane: Some(ContactPlane::default()),
            ..FrameState::default()
        };
        assert!(!null.same_bits(&absent));
        assert!(!null.fields_same_bits(&plane, Fields::CONTACT_PLANE));
    }
}
