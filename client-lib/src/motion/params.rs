//! Parameters of a movement (`spec/08-motion.md`, section 5).

use bitflags::bitflags;

use super::wire::{Reader, WireError, put_f32, put_u32};
use super::{Command, HoldKey};
use crate::math::EPSILON;
use crate::profile::{MoveToDefaults, Profile};

bitflags! {
    /// Flag word of [`MovementParameters`], as on the wire.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub struct MovementFlags: u32 {
        /// A move-to may walk.
        const CAN_WALK = 0x0_0001;
        /// A move-to may run.
        const CAN_RUN = 0x0_0002;
        /// Not read.
        const CAN_SIDESTEP = 0x0_0004;
        /// Not read.
        const CAN_WALK_BACKWARDS = 0x0_0008;
        /// A move-to runs at any distance.
        const CAN_CHARGE = 0x0_0010;
        /// Not read.
        const FAIL_WALK = 0x0_0020;
        /// A move-to ends with a turn to the desired heading.
        const USE_FINAL_HEADING = 0x0_0040;
        /// A move-to an object ends stuck to it.
        const STICKY = 0x0_0080;
        /// Keep a distance.
        const MOVE_AWAY = 0x0_0100;
        /// Come near.
        const MOVE_TOWARDS = 0x0_0200;
        /// Distances are those of the upright cylinders, not of the origins.
        const USE_SPHERES = 0x0_0400;
        /// The hold key becomes the current one.
        const SET_HOLD_KEY = 0x0_0800;
        /// The local input asked for it.
        const AUTONOMOUS = 0x0_1000;
        /// The raw state takes the motion.
        const MODIFY_RAW_STATE = 0x0_2000;
        /// The interpreted state takes the motion.
        const MODIFY_INTERPRETED_STATE = 0x0_4000;
        /// A running move-to ends.
        const CANCEL_MOVETO = 0x0_8000;
        /// Turns stop everything else first.
        const STOP_COMPLETELY = 0x1_0000;
        /// No jump until the motion's transition has been played.
        const DISABLE_JUMP_DURING_LINK = 0x2_0000;
        /// Bits without a name are kept.
        const _ = !0;
    }
}

impl Default for MovementFlags {
    fn default() -> Self {
        Self::from_bits_retain(0x1_EE0F)
    }
}

/// How a movement is to be carried out. Distances in m, headings in compass degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovementParameters {
    /// Switches.
    pub flags: MovementFlags,
    /// A move-to has arrived at this distance.
    pub distance_to_object: f32,
    /// Moving away ends at this distance.
    pub min_distance: f32,
    /// Final heading of a move-to, goal of a turn.
    pub desired_heading: f32,
    /// Factor of the animation's rate; 1 is natural.
    pub speed: f32,
    /// A move-to that has gone farther than this from its start fails.
    pub fail_distance: f32,
    /// A move-to that has farther to go than this runs.
    pub walk_run_threshold: f32,
    /// Returned with the reports about this movement.
    pub context_id: u32,
    /// Walk/run modifier for this motion.
    pub hold_key: HoldKey,
    /// Serial number of an action.
    pub action_stamp: u32,
}

impl Default for MovementParameters {
    fn default() -> Self {
        Self {
            flags: MovementFlags::default(),
            distance_to_object: 0.6,
            min_distance: 0.0,
            desired_heading: 0.0,
            speed: 1.0,
            fail_distance: f32::MAX,
            walk_run_threshold: 15.0,
            context_id: 0,
            hold_key: HoldKey::Invalid,
            action_stamp: 0,
        }
    }
}

/// What a move-to does at its present distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Approach {
    /// Walking forward or backwards; [`Command::NONE`] when there is nothing to do.
    pub command: Command,
    /// Walk or run, never Invalid.
    pub hold_key: HoldKey,
    /// The distance is to grow.
    pub moving_away: bool,
}

impl MovementParameters {
    /// The defaults of a profile (`D2`).
    pub fn new(profile: &Profile) -> Self {
        let mut params = Self::default();
        if profile.move_to_defaults == MoveToDefaults::Ace {
            params.flags |= MovementFlags::CAN_CHARGE;
            params.walk_run_threshold = 1.0;
        }
        params
    }

    /// Whether a flag is set.
    pub const fn has(&self, flag: MovementFlags) -> bool {
        self.flags.intersects(flag)
    }

    /// The same with one flag set or cleared.
    #[must_use]
    pub fn with(mut self, flag: MovementFlags, on: bool) -> Self {
        self.flags.set(flag, on);
        self
    }

    /// What to do at distance `dist` (m). The heading to the target plays no role (5.3; `D2` for can_charge).
    pub fn approach(&self, dist: f32, profile: &Profile) -> Approach {
        let towards = self.has(MovementFlags::MOVE_TOWARDS);
        let away = self.has(MovementFlags::MOVE_AWAY);
        let too_far = dist > self.distance_to_object;
        let (command, moving_away) = match (towards, away) {
            (true, true) if too_far => (Command::WALK_FORWARD, false),
            (true, true) if dist - self.min_distance < EPSILON => (Command::WALK_BACKWARDS, true),
            (false, true) if dist < self.min_distance => (Command::WALK_FORWARD, true),
            (true | false, false) if too_far => (Command::WALK_FORWARD, false),
            _ => (Command::NONE, false),
        };
        Approach {
            command,
            hold_key: HoldKey::running(self.runs(dist, profile)),
            moving_away,
        }
    }

    fn runs(&self, dist: f32, profile: &Profile) -> bool {
        let charges = self.has(MovementFlags::CAN_CHARGE)
            && profile.move_to_defaults == MoveToDefaults::Retail;
        charges
            || self.has(MovementFlags::CAN_RUN)
                && (!self.has(MovementFlags::CAN_WALK)
                    || dist - self.distance_to_object > self.walk_run_threshold)
    }

    /// Reads the wire form of move-to types 6 and 7 (28 bytes); the other fields take their defaults.
    pub fn unpack_move(reader: &mut Reader<'_>) -> Result<Self, WireError> {
        Ok(Self {
            flags: MovementFlags::from_bits_retain(reader.u32()?),
            distance_to_object: reader.f32()?,
            min_distance: reader.f32()?,
            fail_distance: reader.f32()?,
            speed: reader.f32()?,
            walk_run_threshold: reader.f32()?,
            desired_heading: reader.f32()?,
            ..Self::default()
        })
    }

    /// Reads the wire form of turn types 8 and 9 (12 bytes); the other fields take their defaults.
    pub fn unpack_turn(reader: &mut Reader<'_>) -> Result<Self, WireError> {
        Ok(Self {
            flags: MovementFlags::from_bits_retain(reader.u32()?),
            speed: reader.f32()?,
            desired_heading: reader.f32()?,
            ..Self::default()
        })
    }

    /// Appends the wire form of types 6 and 7.
    pub fn pack_move(&self, message: &mut Vec<u8>) {
        put_u32(message, self.flags.bits());
        for field in [
            self.distance_to_object,
            self.min_distance,
            self.fail_distance,
            self.speed,
            self.walk_run_threshold,
            self.desired_heading,
        ] {
            put_f32(message, field);
        }
    }

    /// Appends the wire form of types 8 and 9.
    pub fn pack_turn(&self, message: &mut Vec<u8>) {
        put_u32(message, self.flags.bits());
        put_f32(message, self.speed);
        put_f32(message, self.desired_heading);
    }
}

/// Heading (degrees, relative to the target's bearing) that a mover by `command` keeps (5.4).
pub fn desired_heading(command: Command, moving_away: bool) -> f32 {
    match (command, moving_away) {
        (Command::WALK_FORWARD | Command::RUN_FORWARD, true) => 180.0,
        (Command::WALK_BACKWARDS, false) => 180.0,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn with_flags(set: MovementFlags, clear: MovementFlags) -> MovementParameters {
        let mut params = MovementParameters::default();
        params.flags = params.flags.difference(clear).union(set);
        params
    }

    #[test]
    fn defaults() {
        let retail = MovementParameters::new(&Profile::retail());
        assert_eq!(retail.flags.bits(), 0x1EE0F);
        assert_eq!(retail.walk_run_threshold, 15.0);
        assert_eq!(retail.distance_to_object.to_bits(), 0x3F19_999A);
        let mut profile = Profile::retail();
        profile.move_to_defaults = MoveToDefaults::Ace;
        let ace = MovementParameters::new(&profile);
        assert_eq!((ace.flags.bits(), ace.walk_run_threshold), (0x1EE1F, 1.0));
        assert_eq!(ace.approach(2.0, &profile).hold_key, HoldKey::Run);
        assert_eq!(ace.approach(1.0, &profile).hold_key, HoldKey::None);
        assert_eq!(ace.approach(1.0, &Profile::retail()).hold_key, HoldKey::Run);
    }

    #[test]
    fn towards_and_away_is_two_sided() {
        let p = Profile::retail();
        let mut params = with_flags(MovementFlags::MOVE_AWAY, MovementFlags::empty());
        params.min_distance = 0.3;
        let at = |dist| {
            let a = params.approach(dist, &p);
            (a.command, a.moving_away)
        };
        assert_eq!(at(0.7), (Command::WALK_FORWARD, false));
        assert_eq!(at(0.6), (Command::NONE, false));
        assert_eq!(at(0.3001), (Command::WALK_BACKWARDS, true));
        assert_eq!(at(0.31), (Command::NONE, false));
        params.flags.remove(MovementFlags::MOVE_TOWARDS);
        let a = params.approach(0.29, &p);
        assert_eq!((a.command, a.moving_away), (Command::WALK_FORWARD, true));
        assert_eq!(params.approach(0.3, &p).command, Command::NONE);
        params.flags.remove(MovementFlags::MOVE_AWAY);
        assert_eq!(params.approach(0.7, &p).command, Command::WALK_FORWARD);
        assert_eq!(params.approach(f32::NAN, &p).command, Command::NONE);
    }

    #[test]
    fn headings_relative_to_the_bearing() {
        for (command, toward, away) in [
            (Command::WALK_FORWARD, 0.0, 180.0),
            (Command::RUN_FORWARD, 0.0, 180.0),
            (Command::WALK_BACKWARDS, 180.0, 0.0),
            (Command::READY, 0.0, 0.0),
        ] {
            assert_eq!(desired_heading(command, false), toward);
            assert_eq!(desired_heading(command, true), away);
        }
    }

    proptest! {
        #[test]
        fn approach_invariants(flags: u32, dist: f32, near: f32, min: f32) {
            let params = MovementParameters {
                flags: MovementFlags::from_bits_retain(flags), distance_to_object: near, min_distance: min,
                ..MovementParameters::default()
            };
            let a = params.approach(dist, &Profile::retail());
            prop_assert!(!a.moving_away || params.has(MovementFlags::MOVE_AWAY));
            prop_assert_ne!(a.hold_key, HoldKey::Invalid);
        }

        #[test]
        fn wire_forms_survive(flags: u32, fields: [u32; 6]) {
            let [a, b, c, d, e, f] = fields.map(f32::from_bits);
            let params = MovementParameters {
                flags: MovementFlags::from_bits_retain(flags), distance_to_object: a, min_distance: b, fail_distance: c,
                speed: d, walk_run_threshold: e, desired_heading: f, ..MovementParameters::default()
            };
            let (mut message, mut again) = (Vec::new(), Vec::new());
            params.pack_move(&mut message);
            prop_assert_eq!(message.len(), 28);
            MovementParameters::unpack_move(&mut Reader::new(&message)).unwrap().pack_move(&mut again);
            prop_assert_eq!(&message, &again);
            message.clear();
            params.pack_turn(&mut message);
            prop_assert_eq!(message.len(), 12);
            let back = MovementParameters::unpack_turn(&mut Reader::new(&message)).unwrap();
            prop_assert_eq!((back.flags, back.speed.to_bits(), back.desired_heading.to_bits()),
                (params.flags, params.speed.to_bits(), params.desired_heading.to_bits()));
            prop_assert!(MovementParameters::unpack_move(&mut Reader::new(&message)).is_err());
        }
    }
}
