//! Movements on the wire (`spec/10-messages.md`, 4.4 and 4.5). The layouts themselves are the motion layer's.

use super::wire::{ReadError, Reader, Wire, Writer};
use crate::math::Position;
use crate::motion::wire::{Reader as MotionReader, WireError};
use crate::motion::{Command, MovementUpdate, RawMotionState, UpdateKind};

/// A movement, as sent and as read. The bytes are kept: senders write fields that equal their defaults or leave them out.
#[derive(Debug, Clone, PartialEq)]
pub struct MovementData {
    bytes: Vec<u8>,
    update: Result<MovementUpdate, WireError>,
}

const STICKS: u8 = 1;
const STANDING_LONGJUMP: u8 = 2;

impl MovementData {
    /// The movement, or why the bytes are none; such a movement has no effect (14.6).
    pub const fn update(&self) -> Result<&MovementUpdate, WireError> {
        match &self.update {
            Ok(update) => Ok(update),
            Err(error) => Err(*error),
        }
    }

    /// The movement's bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Bytes of a description's window, read as far as they go.
    pub fn from_window(bytes: &[u8]) -> Self {
        Self {
            bytes: bytes.to_vec(),
            update: MovementUpdate::unpack(&mut MotionReader::new(bytes)),
        }
    }

    /// A movement to send.
    pub fn new(update: MovementUpdate) -> Self {
        let mut bytes = Vec::new();
        pack(&update, &mut bytes);
        Self {
            bytes,
            update: Ok(update),
        }
    }

    /// Whether bits are set that no layout knows (14.7).
    pub fn has_unknown_bits(&self) -> bool {
        let options = self.bytes.get(1).is_some_and(|&options| options > 3);
        let state = self.bytes.first() == Some(&0)
            && self
                .bytes
                .get(4..8)
                .is_some_and(|b| b[1] & 0xF0 != 0 || b[2] != 0 || b[3] != 0);
        options || state
    }

    /// Whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        let Ok(update) = &self.update else {
            return false;
        };
        let place = |p: &Position| p.frame.origin.is_finite();
        match &update.kind {
            UpdateKind::State(s, _) => {
                [s.forward_speed, s.sidestep_speed, s.turn_speed]
                    .iter()
                    .all(|v| v.is_finite())
                    && s.actions.iter().all(|a| a.speed.is_finite())
            }
            UpdateKind::MoveToObject {
                origin,
                params,
                run_rate,
                ..
            }
            | UpdateKind::MoveToPosition {
                origin,
                params,
                run_rate,
            } => {
                place(origin)
                    && [
                        params.speed,
                        params.desired_heading,
                        params.distance_to_object,
                        *run_rate,
                    ]
                    .iter()
                    .all(|v| v.is_finite())
            }
            UpdateKind::TurnToObject {
                heading, params, ..
            } => [*heading, params.speed, params.desired_heading]
                .iter()
                .all(|v| v.is_finite()),
            UpdateKind::TurnToHeading(params) => {
                params.speed.is_finite() && params.desired_heading.is_finite()
            }
        }
    }
}

fn put_f32(bytes: &mut Vec<u8>, value: f32) {
    bytes.extend(value.to_le_bytes());
}

fn put_origin(bytes: &mut Vec<u8>, origin: &Position) {
    bytes.extend(origin.cell.0.to_le_bytes());
    for value in origin.frame.origin.to_array() {
        put_f32(bytes, value);
    }
}

fn pack(update: &MovementUpdate, bytes: &mut Vec<u8>) {
    let (kind, sticks) = match &update.kind {
        UpdateKind::State(_, guid) => (0, guid.is_some()),
        UpdateKind::MoveToObject { .. } => (6, false),
        UpdateKind::MoveToPosition { .. } => (7, false),
        UpdateKind::TurnToObject { .. } => (8, false),
        UpdateKind::TurnToHeading(_) => (9, false),
    };
    let mut options = if sticks { STICKS } else { 0 };
    if update.standing_longjump {
        options |= STANDING_LONGJUMP;
    }
    bytes.extend([kind, options]);
    bytes.extend(update.style.index().to_le_bytes());
    match &update.kind {
        UpdateKind::State(state, guid) => {
            state.pack(bytes);
            bytes.extend(guid.iter().flat_map(|g| g.to_le_bytes()));
        }
        UpdateKind::MoveToObject {
            guid,
            origin,
            params,
            run_rate,
        } => {
            bytes.extend(guid.to_le_bytes());
            put_origin(bytes, origin);
            params.pack_move(bytes);
            put_f32(bytes, *run_rate);
        }
        UpdateKind::MoveToPosition {
            origin,
            params,
            run_rate,
        } => {
            put_origin(bytes, origin);
            params.pack_move(bytes);
            put_f32(bytes, *run_rate);
        }
        UpdateKind::TurnToObject {
            guid,
            heading,
            params,
        } => {
            bytes.extend(guid.to_le_bytes());
            put_f32(bytes, *heading);
            params.pack_turn(bytes);
        }
        UpdateKind::TurnToHeading(params) => params.pack_turn(bytes),
    }
}

impl Default for MovementData {
    /// Standing, in peace.
    fn default() -> Self {
        Self::new(MovementUpdate {
            style: Command::NON_COMBAT,
            standing_longjump: false,
            kind: UpdateKind::State(Default::default(), None),
        })
    }
}

impl Wire for MovementData {
    const MIN: usize = 4;

    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let start = r.offset();
        let update = match r.motion(MovementUpdate::unpack) {
            Ok(update) => Ok(update),
            // Types without payload are kept, without effect; what follows them is extra.
            Err(ReadError {
                problem: super::wire::Problem::Motion(error @ WireError::MovementType { .. }),
                ..
            }) => {
                r.bytes(4)?;
                Err(error)
            }
            Err(error) => return Err(error),
        };
        Ok(Self {
            bytes: r.since(start).to_vec(),
            update,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.put(&self.bytes);
    }
}

super::wire::wire_struct! {
    /// A movement of an event: two stamps before it order it.
    pub struct SequencedMovement {
        /// Movement stamp.
        movement: u16,
        /// Server-control stamp.
        server_control: u16,
        /// The movement came from the object's own input.
        autonomous: u8 => align,
        /// The movement.
        data: MovementData,
    }
}

/// A raw motion state, as sent and as read.
#[derive(Debug, Clone, PartialEq)]
pub struct RawState {
    bytes: Vec<u8>,
    state: RawMotionState,
}

impl RawState {
    /// A state to send.
    pub fn new(state: RawMotionState) -> Self {
        let mut bytes = Vec::new();
        state.pack(&mut bytes);
        Self { bytes, state }
    }

    /// The state.
    pub const fn state(&self) -> &RawMotionState {
        &self.state
    }

    /// Whether bits are set that no layout knows (14.7).
    pub fn has_unknown_bits(&self) -> bool {
        self.bytes
            .get(2..4)
            .is_some_and(|high| high.iter().any(|&b| b != 0))
    }
}

impl Default for RawState {
    fn default() -> Self {
        Self::new(RawMotionState::default())
    }
}

impl Wire for RawState {
    const MIN: usize = 4;

    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let start = r.offset();
        let state = r.motion(RawMotionState::unpack)?;
        Ok(Self {
            bytes: r.since(start).to_vec(),
            state,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.put(&self.bytes);
    }
}
