//! Steering of the move-to manager, once per quantum (`spec/08-motion.md`, 11.10 to 11.12).

use super::constants::{AUX_TURN_BAND, TARGET_QUANTUM_MIN_CHANGE, TARGET_QUANTUM_MIN_SPEED};
use super::heading::{fold, heading_diff, heading_greater};
use super::params::desired_heading;
use super::{Command, MotionError, MoveToManager, MoveToNode, MovementFlags, MovementParameters};
use crate::entity::Entity;
use crate::math::EPSILON;
use crate::physics::state::TransientState;
use crate::profile::MoveToArrival;
use crate::world::World;

impl MoveToManager {
    /// Parameters of the motions that the manager asks for, before the hold key.
    pub(super) fn own_motion_params(&self, world: &World) -> MovementParameters {
        let mut params =
            MovementParameters::new(&world.profile).with(MovementFlags::CANCEL_MOVETO, false);
        params.speed = self.params.speed;
        params
    }

    /// Whether the walk at the head is over at this distance.
    fn has_arrived(&self, distance: f32) -> bool {
        if self.moving_away {
            distance >= self.params.min_distance
        } else {
            distance <= self.params.distance_to_object
        }
    }
}

impl Entity {
    /// Serves the leg that is at the head now. Contact is enough: the ground need not be walkable.
    pub(super) fn move_to_use_time(&mut self, world: &mut World) {
        if !self.kin.transient.contains(TransientState::CONTACT) {
            return;
        }
        let Some(m) = self.move_to() else {
            return;
        };
        let waits = m.top_level_object_id != 0 && m.is_active() && !m.initialized;
        match m.nodes.front() {
            _ if waits => {}
            Some(MoveToNode::Move) => self.handle_move_to_position(world),
            Some(&MoveToNode::Turn(heading)) => self.handle_turn_to_heading(heading, world),
            None => {}
        }
    }

    /// 11.10.
    fn handle_move_to_position(&mut self, world: &mut World) {
        let Some(m) = self.move_to() else {
            return;
        };
        let mut params = m.own_motion_params(world);
        params.hold_key = m.params.hold_key;
        self.steer(&mut params, world);
        let distance = self.move_to_distance(world);
        self.judge_progress(distance, &mut params, world);
        self.adapt_target_quantum(distance, world);
    }

    /// Turns towards the target while walking when the bearing is off by more than 20° (`D19`).
    fn steer(&mut self, params: &mut MovementParameters, world: &mut World) {
        if self.motions_pending() {
            self.stop_aux_turn(params, world);
            return;
        }
        let own_position = &self.body.position;
        let Some(m) = self.move_to() else {
            return;
        };
        let bearing = own_position.heading_to(&m.current_target_position, &world.profile);
        let mut wanted = desired_heading(m.current_command, m.moving_away) + bearing;
        if wanted >= 360.0 {
            wanted -= 360.0;
        }
        let d = fold(wanted - self.heading(world));
        if d <= AUX_TURN_BAND || d >= 360.0 - AUX_TURN_BAND {
            let turning = m.aux_command != Command::NONE;
            if turning && world.profile.move_to_arrival == MoveToArrival::Snaps {
                self.set_heading(wanted, world);
            }
            self.stop_aux_turn(params, world);
            return;
        }
        let turn = if d >= 180.0 {
            Command::TURN_LEFT
        } else {
            Command::TURN_RIGHT
        };
        if turn != m.aux_command {
            // A refusal is not looked at; an opposite turn is not stopped first.
            let _ = self.move_to_do_motion(turn, params, world);
            if let Some(m) = self.move_to_mut() {
                m.aux_command = turn;
            }
        }
    }

    fn stop_aux_turn(&mut self, params: &mut MovementParameters, world: &mut World) {
        let Some(m) = self.move_to_mut() else {
            return;
        };
        let turn = m.aux_command;
        if turn != Command::NONE {
            self.move_to_stop_motion(turn, params, world);
            if let Some(m) = self.move_to_mut() {
                m.aux_command = Command::NONE;
            }
        }
    }

    /// Arrival and failure, tested only while there is progress (11.10, step 4; `D20`).
    fn judge_progress(
        &mut self,
        distance: f32,
        params: &mut MovementParameters,
        world: &mut World,
    ) {
        let now = world.clock.now;
        let idle = !self.is_interpolating() && !self.motions_pending();
        let snaps = world.profile.move_to_arrival == MoveToArrival::Snaps;
        let Some(m) = self.move_to_mut() else {
            return;
        };
        if !m.check_progress(distance, now) {
            m.fail_progress_count = m.fail_progress_count.wrapping_add(u32::from(idle));
            return;
        }
        m.fail_progress_count = 0;
        let mut arrived = m.has_arrived(distance);
        if snaps && !m.params.has(MovementFlags::USE_SPHERES) {
            arrived |= distance < 1.0 && m.previous.distance < distance;
            m.previous.distance = distance;
            m.previous.time = now;
        }
        if arrived {
            self.finish_move_node(params, world);
        } else {
            let (start, limit) = (m.starting_position, m.params.fail_distance);
            if start.distance(&self.body.position) > limit {
                self.cancel_moveto_with(MotionError::TooFar, world);
            }
        }
    }

    fn finish_move_node(&mut self, params: &mut MovementParameters, world: &mut World) {
        let Some(m) = self.move_to_mut() else {
            return;
        };
        m.nodes.pop_front();
        let command = m.current_command;
        self.move_to_stop_motion(command, params, world);
        if let Some(m) = self.move_to_mut() {
            m.current_command = Command::NONE;
        }
        self.stop_aux_turn(params, world);
        self.begin_next_node(world);
    }

    /// Has the target look as far ahead as the walk will take (11.10, step 5).
    fn adapt_target_quantum(&mut self, distance: f32, world: &mut World) {
        let tracks = self
            .move_to()
            .is_some_and(|m| m.top_level_object_id != 0 && m.is_active());
        let speed = self.kin.cached_velocity.length();
        if !tracks || speed <= TARGET_QUANTUM_MIN_SPEED || speed.is_nan() {
            return;
        }
        let time = f64::from(distance / speed);
        if (time - self.target_quantum()).abs() > TARGET_QUANTUM_MIN_CHANGE {
            self.set_target_quantum(time, world);
        }
    }

    /// 11.12.
    fn handle_turn_to_heading(&mut self, goal: f32, world: &mut World) {
        let Some(m) = self.move_to() else {
            return;
        };
        let turn = m.current_command;
        if !turn.is_turn() {
            self.begin_turn(goal, world);
            return;
        }
        let heading = self.heading(world);
        if heading_greater(heading, goal, turn) {
            self.finish_turn_node(goal, turn, world);
            return;
        }
        let idle = !self.is_interpolating() && !self.motions_pending();
        if let Some(m) = self.move_to_mut() {
            let d = heading_diff(heading, m.previous_heading, turn, &world.profile);
            m.previous_heading = heading;
            if d > EPSILON && d < 180.0 {
                m.fail_progress_count = 0;
            } else {
                m.fail_progress_count = m.fail_progress_count.wrapping_add(u32::from(idle));
            }
        }
    }

    fn finish_turn_node(&mut self, goal: f32, turn: Command, world: &mut World) {
        if let Some(m) = self.move_to_mut() {
            m.fail_progress_count = 0;
        }
        self.set_heading(goal, world);
        let Some(m) = self.move_to_mut() else {
            return;
        };
        m.nodes.pop_front();
        let key = m.params.hold_key;
        let mut params =
            MovementParameters::new(&world.profile).with(MovementFlags::CANCEL_MOVETO, false);
        params.hold_key = key;
        self.move_to_stop_motion(turn, &mut params, world);
        if let Some(m) = self.move_to_mut() {
            m.current_command = Command::NONE;
        }
        self.begin_next_node(world);
    }
}
