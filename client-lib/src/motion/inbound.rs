//! Movements that the server sends: reading them and carrying them out (`spec/08-motion.md`, section 15).
//!
//! Whether an event is to be carried out at all is decided before (`Entity::accept_movement`, which also sets the object's autonomous flag).

use super::ground::stamp_is_newer;
use super::wire::{Reader, WireError};
use super::{
    Command, InterpretedMotionState, MovementFlags, MovementParameters, RawMotionState, code_of,
};
use crate::entity::Entity;
use crate::math::{CellId, Position, Quat, Vec3};
use crate::world::World;

/// The eight bytes before the movement of an event (0xF74C); a description has none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MovementHeader {
    /// Movement sequence.
    pub movement_stamp: u16,
    /// Server-control sequence.
    pub server_control_stamp: u16,
    /// The movement came from the object's own input.
    pub autonomous: bool,
}

/// A movement as sent.
#[derive(Debug, Clone, PartialEq)]
pub struct MovementUpdate {
    /// Stance.
    pub style: Command,
    /// The object charges a jump from a standstill (flag 2; looked at with a state only).
    pub standing_longjump: bool,
    /// What it does.
    pub kind: UpdateKind,
}

/// What a [`MovementUpdate`] says.
#[derive(Debug, Clone, PartialEq)]
pub enum UpdateKind {
    /// Type 0: a motion state, and perhaps a GUID to stick to.
    State(InterpretedMotionState, Option<u32>),
    /// Type 6: walk to an object, which was seen at a place.
    MoveToObject {
        /// Target.
        guid: u32,
        /// Where it was, without rotation.
        origin: Position,
        /// How.
        params: MovementParameters,
        /// Run rate of the mover.
        run_rate: f32,
    },
    /// Type 7: walk to a place.
    MoveToPosition {
        /// The place, without rotation.
        origin: Position,
        /// How.
        params: MovementParameters,
        /// Run rate of the mover.
        run_rate: f32,
    },
    /// Type 8: turn to an object.
    TurnToObject {
        /// Target.
        guid: u32,
        /// Its heading when it was seen, degrees.
        heading: f32,
        /// How.
        params: MovementParameters,
    },
    /// Type 9: turn to the desired heading.
    TurnToHeading(MovementParameters),
}

const STICKS: u8 = 1;
const STANDING_LONGJUMP: u8 = 2;

impl MovementHeader {
    /// Reads the header of an event.
    ///
    /// # Errors
    /// The message ends early.
    pub fn unpack(reader: &mut Reader<'_>) -> Result<Self, WireError> {
        let header = Self {
            movement_stamp: reader.u16()?,
            server_control_stamp: reader.u16()?,
            autonomous: reader.u8()? != 0,
        };
        reader.align();
        Ok(header)
    }
}

impl MovementUpdate {
    /// Reads a movement, after the header if there is one.
    ///
    /// # Errors
    /// The message ends early, or its type has no payload.
    pub fn unpack(reader: &mut Reader<'_>) -> Result<Self, WireError> {
        let at = reader.offset();
        let (kind, flags) = (reader.u8()?, reader.u8()?);
        let style = Command::from_index(reader.u16()?);
        let kind = match kind {
            0 => {
                let state = InterpretedMotionState::unpack(reader)?;
                let sticks = flags & STICKS != 0;
                let guid = if sticks { Some(reader.u32()?) } else { None };
                UpdateKind::State(state, guid)
            }
            6 => UpdateKind::MoveToObject {
                guid: reader.u32()?,
                origin: unpack_origin(reader)?,
                params: MovementParameters::unpack_move(reader)?,
                run_rate: reader.f32()?,
            },
            7 => UpdateKind::MoveToPosition {
                origin: unpack_origin(reader)?,
                params: MovementParameters::unpack_move(reader)?,
                run_rate: reader.f32()?,
            },
            8 => UpdateKind::TurnToObject {
                guid: reader.u32()?,
                heading: reader.f32()?,
                params: MovementParameters::unpack_turn(reader)?,
            },
            9 => UpdateKind::TurnToHeading(MovementParameters::unpack_turn(reader)?),
            value => return Err(WireError::MovementType { at, value }),
        };
        Ok(Self {
            style,
            standing_longjump: flags & STANDING_LONGJUMP != 0,
            kind,
        })
    }
}

fn unpack_origin(reader: &mut Reader<'_>) -> Result<Position, WireError> {
    let cell = CellId(reader.u32()?);
    let origin = Vec3::new(reader.f32()?, reader.f32()?, reader.f32()?);
    Ok(Position::new(cell, origin, Quat::IDENTITY))
}

impl Entity {
    /// Carries out what the input of another program wants: a server, or a replay, that has got a MoveToState (14.5).
    ///
    /// The raw state is replaced, but for the actions that wait; of the message's actions those newer than `last_action` (15 bits count) are
    /// done, and it advances. A running move-to ends.
    pub fn apply_raw_state(
        &mut self,
        state: &RawMotionState,
        standing_longjump: bool,
        last_action: &mut u32,
        world: &mut World,
    ) {
        self.kin.last_move_was_autonomous = true;
        self.cancel_moveto(world);
        let interp = self.get_interp(world);
        let waiting = core::mem::take(&mut interp.raw.actions);
        interp.raw = state.clone();
        interp.raw.actions = waiting;
        interp.standing_longjump = standing_longjump;
        self.apply_raw_movement(true, world);
        for action in state.actions.iter() {
            if !stamp_is_newer(action.stamp, *last_action) {
                continue;
            }
            *last_action = action.stamp;
            let mut params =
                MovementParameters::new(&world.profile).with(MovementFlags::AUTONOMOUS, true);
            params.action_stamp = action.stamp;
            params.speed = action.speed;
            // A refused action is lost, as it is where the input is.
            let _ = self.do_motion(action.command, &params, world);
        }
    }

    /// Carries a movement of the server out (`unpack_movement`). Manager and interpreter are made if missing.
    pub fn apply_movement_update(&mut self, update: &MovementUpdate, world: &mut World) {
        let style = self.get_interp(world).interpreted.style;
        self.cancel_moveto(world);
        self.unstick_from_object(world);
        if update.style != style {
            let params = MovementParameters::new(&world.profile);
            let refused = self.interp_do_motion(update.style, &params, world);
            tracing::trace!(style = ?update.style, code = code_of(refused), "stance from the server");
        }
        match &update.kind {
            UpdateKind::State(state, guid) => {
                self.move_to_interpreted_state(state, world);
                if let Some(guid) = guid {
                    self.stick_to_object(*guid, world);
                }
                if let Some(interp) = self.interp_mut() {
                    interp.standing_longjump = update.standing_longjump;
                }
            }
            UpdateKind::MoveToObject {
                guid,
                origin,
                params,
                run_rate,
            } => {
                self.set_my_run_rate(*run_rate);
                if !self.move_to_object(*guid, params, world) {
                    self.move_to_position(origin, params, world);
                }
            }
            UpdateKind::MoveToPosition {
                origin,
                params,
                run_rate,
            } => {
                self.set_my_run_rate(*run_rate);
                self.move_to_position(origin, params, world);
            }
            UpdateKind::TurnToObject {
                guid,
                heading,
                params,
            } => {
                if !self.turn_to_object(*guid, params, world) {
                    let params = MovementParameters {
                        desired_heading: *heading,
                        ..*params
                    };
                    self.turn_to_heading(&params, world);
                }
            }
            UpdateKind::TurnToHeading(params) => self.turn_to_heading(params, world),
        }
    }

    fn set_my_run_rate(&mut self, rate: f32) {
        if let Some(interp) = self.interp_mut() {
            interp.my_run_rate = rate;
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::motion::wire::put_f32;

    #[test]
    fn an_event_with_a_state_and_a_guid() {
        let mut message = vec![7, 0, 9, 0, 1, 0, 0, 0, 0, 3, 0x3E, 0];
        let state = InterpretedMotionState {
            forward_command: Command::RUN_FORWARD,
            forward_speed: 2.0,
            ..InterpretedMotionState::default()
        };
        state.pack(&mut message);
        message.extend([0x78, 0x56, 0x34, 0x12]);
        let mut reader = Reader::new(&message);
        let header = MovementHeader::unpack(&mut reader).unwrap();
        assert_eq!(
            (
                header.movement_stamp,
                header.server_control_stamp,
                header.autonomous
            ),
            (7, 9, true)
        );
        let update = MovementUpdate::unpack(&mut reader).unwrap();
        assert_eq!(update.style, Command(0x8000_003E));
        assert!(update.standing_longjump);
        assert_eq!(update.kind, UpdateKind::State(state, Some(0x1234_5678)));
        assert_eq!(reader.offset(), message.len());
    }

    #[test]
    fn move_to_types() {
        let params = MovementParameters {
            distance_to_object: 2.0,
            desired_heading: 90.0,
            ..MovementParameters::default()
        };
        let mut message = vec![7, 0, 0x3D, 0, 0x19, 0, 0xB4, 0xA9];
        for number in [1.0, 2.0, 3.0] {
            put_f32(&mut message, number);
        }
        params.pack_move(&mut message);
        put_f32(&mut message, 2.5);
        let update = MovementUpdate::unpack(&mut Reader::new(&message)).unwrap();
        let UpdateKind::MoveToPosition {
            origin,
            params: read,
            run_rate,
        } = update.kind
        else {
            panic!("not a move to a position: {update:?}");
        };
        assert_eq!(
            (origin.cell, origin.frame.origin.z),
            (CellId(0xA9B4_0019), 3.0)
        );
        assert_eq!((read, run_rate), (params, 2.5));
        message[0] = 5;
        assert_eq!(
            MovementUpdate::unpack(&mut Reader::new(&message)),
            Err(WireError::MovementType { at: 0, value: 5 })
        );
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_refused(kind in 0u8..10, rest: Vec<u8>) {
            let mut message = vec![kind];
            message.extend(rest);
            let _ = MovementUpdate::unpack(&mut Reader::new(&message));
            let _ = MovementHeader::unpack(&mut Reader::new(&message));
        }
    }
}
