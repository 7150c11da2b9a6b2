//! Beginning and ending an activity of the move-to manager (`spec/08-motion.md`, 11.1 to 11.8, 11.14, 11.16).
//!
//! The chain is re-entrant: asking for a target reports its place before it returns, and ending an activity stops every motion, which asks
//! for the end of the activity again. So no borrow is held across a call, and every step looks at the manager anew.

use super::constants::TARGET_RADIUS;
use super::heading::heading_diff;
use super::movement_manager::{MoveTarget, Movement};
use super::{
    Command, MotionError, MotionResult, MoveToKind, MoveToNode, MovementFlags, MovementParameters,
};
use crate::entity::Entity;
use crate::math::{EPSILON, Position};
use crate::physics::managers::{TargetInfo, TargetStatus};
use crate::profile::MoveToHeading;
use crate::world::World;

impl Entity {
    /// Starts an activity in place of the running one (11.1).
    pub(super) fn begin_move_to(&mut self, movement: &Movement, world: &mut World) {
        self.cancel_moveto(world);
        self.unstick_from_object(world);
        match movement {
            Movement::MoveToObject(target, params) => {
                self.begin_move_to_object(target, params, world);
            }
            Movement::MoveToPosition(position, params) => {
                self.begin_move_to_position(position, params, world);
            }
            Movement::TurnToObject(target, params) => {
                self.begin_turn_to_object(target, params, world);
            }
            Movement::TurnToHeading(params) => self.begin_turn_to_heading(params, world),
            _ => {}
        }
    }

    /// 11.2.
    fn begin_move_to_object(
        &mut self,
        target: &MoveTarget,
        params: &MovementParameters,
        world: &mut World,
    ) {
        self.stop_completely(world);
        let own = self.body.position;
        let Some(m) = self.move_to_mut() else {
            return;
        };
        m.starting_position = own;
        m.sought_object_id = target.object_id;
        m.sought_object_radius = target.radius;
        m.sought_object_height = target.height;
        m.top_level_object_id = target.top_level_id;
        m.kind = MoveToKind::Object;
        m.params = *params;
        m.initialized = false;
        self.track_or_stop(target.top_level_id, world);
    }

    /// Asks for reports of the target; moving to oneself ends at once and silently.
    fn track_or_stop(&mut self, top_level_id: u32, world: &mut World) {
        if top_level_id == self.guid() {
            self.clean_up_move_to(world);
            self.stop_completely(world);
        } else {
            self.set_target(0, top_level_id, TARGET_RADIUS, 0.0, world);
        }
    }

    /// Makes the nodes when the target has first been heard of (11.3).
    fn move_to_object_internal(&mut self, info: &TargetInfo, world: &mut World) {
        let bearing = self
            .body
            .position
            .heading_to(&info.interpolated_position, &world.profile);
        if let Some(m) = self.move_to_mut() {
            m.sought_position = info.interpolated_position;
            m.current_target_position = info.target_position;
        }
        let distance = self.move_to_distance(world);
        let Some(m) = self.move_to_mut() else {
            return;
        };
        if m.params.approach(distance, &world.profile).command != Command::NONE {
            m.nodes.push_back(MoveToNode::Turn(bearing));
            m.nodes.push_back(MoveToNode::Move);
        }
        if m.params.has(MovementFlags::USE_FINAL_HEADING) {
            let mut heading = bearing + m.params.desired_heading;
            if heading >= 360.0 {
                heading -= 360.0;
            }
            m.nodes.push_back(MoveToNode::Turn(heading));
        }
        m.initialized = true;
        self.begin_next_node(world);
    }

    /// 11.4 (`D17`). The distance is taken with the flags of the activity before.
    fn begin_move_to_position(
        &mut self,
        position: &Position,
        params: &MovementParameters,
        world: &mut World,
    ) {
        self.stop_completely(world);
        if let Some(m) = self.move_to_mut() {
            m.current_target_position = *position;
            m.sought_object_radius = 0.0;
        }
        let distance = self.move_to_distance(world);
        let own = self.body.position;
        let bearing = own.heading_to(position, &world.profile);
        let Some(m) = self.move_to_mut() else {
            return;
        };
        if params.approach(distance, &world.profile).command != Command::NONE {
            m.nodes.push_back(MoveToNode::Turn(bearing));
            m.nodes.push_back(MoveToNode::Move);
        }
        let asks = match world.profile.move_to_heading {
            MoveToHeading::NewParameters => params,
            MoveToHeading::OldParameters => &m.params,
        };
        if asks.has(MovementFlags::USE_FINAL_HEADING) {
            m.nodes.push_back(MoveToNode::Turn(params.desired_heading));
        }
        m.sought_position = *position;
        m.starting_position = own;
        m.kind = MoveToKind::Position;
        m.params = params.with(MovementFlags::STICKY, false);
        self.begin_next_node(world);
    }

    /// 11.5. The desired heading goes to a place that the first report overwrites, so it is lost: the turn ends facing the target.
    fn begin_turn_to_object(
        &mut self,
        target: &MoveTarget,
        params: &MovementParameters,
        world: &mut World,
    ) {
        if params.has(MovementFlags::STOP_COMPLETELY) {
            self.stop_completely(world);
        }
        let Some(m) = self.move_to_mut() else {
            return;
        };
        m.kind = MoveToKind::TurnToObject;
        m.sought_object_id = target.object_id;
        m.current_target_position
            .frame
            .set_heading(params.desired_heading, &world.profile);
        m.top_level_object_id = target.top_level_id;
        m.params = *params;
        m.initialized = false;
        self.track_or_stop(target.top_level_id, world);
    }

    /// 11.6.
    fn turn_to_object_internal(&mut self, info: &TargetInfo, world: &mut World) {
        let profile = &world.profile;
        let bearing = self
            .body
            .position
            .heading_to(&info.target_position, profile);
        let Some(m) = self.move_to_mut() else {
            return;
        };
        m.current_target_position = info.target_position;
        let goal = (bearing + m.sought_position.frame.heading(profile)) % 360.0;
        m.sought_position.frame.set_heading(goal, profile);
        m.nodes.push_back(MoveToNode::Turn(goal));
        m.initialized = true;
        self.begin_next_node(world);
    }

    /// 11.7. The turn itself begins with the next quantum.
    fn begin_turn_to_heading(&mut self, params: &MovementParameters, world: &mut World) {
        if params.has(MovementFlags::STOP_COMPLETELY) {
            self.stop_completely(world);
        }
        let Some(m) = self.move_to_mut() else {
            return;
        };
        m.params = params.with(MovementFlags::STICKY, false);
        m.sought_position
            .frame
            .set_heading(params.desired_heading, &world.profile);
        m.kind = MoveToKind::TurnToHeading;
        m.nodes.push_back(MoveToNode::Turn(params.desired_heading));
    }

    /// Starts the leg at the head, or ends the activity with success when none is left (11.8).
    pub(super) fn begin_next_node(&mut self, world: &mut World) {
        let Some(m) = self.move_to() else {
            return;
        };
        match m.nodes.front() {
            Some(MoveToNode::Move) => self.begin_move_forward(world),
            Some(&MoveToNode::Turn(heading)) => self.begin_turn(heading, world),
            None => {
                let sticks = m.params.has(MovementFlags::STICKY);
                let (radius, height) = (m.sought_object_radius, m.sought_object_height);
                let target = m.top_level_object_id;
                self.end_move_to(world);
                if sticks {
                    self.stick_to(target, radius, height, world);
                }
            }
        }
    }

    /// Removes the leg at the head and goes on with the next.
    pub(super) fn next_node(&mut self, world: &mut World) {
        if let Some(m) = self.move_to_mut() {
            m.nodes.pop_front();
        }
        self.begin_next_node(world);
    }

    fn begin_move_forward(&mut self, world: &mut World) {
        let distance = self.move_to_distance(world);
        let Some(m) = self.move_to() else {
            return;
        };
        let approach = m.params.approach(distance, &world.profile);
        if approach.command == Command::NONE {
            self.next_node(world);
            return;
        }
        let mut params = m.own_motion_params(world);
        params.hold_key = approach.hold_key;
        if let Err(error) = self.move_to_do_motion(approach.command, &mut params, world) {
            self.cancel_moveto_with(error, world);
            return;
        }
        let now = world.clock.now;
        if let Some(m) = self.move_to_mut() {
            m.current_command = approach.command;
            m.moving_away = approach.moving_away;
            m.params.hold_key = approach.hold_key;
            m.restart_progress(distance, now);
        }
    }

    /// Starts turning to the heading of the node at the head, unless motions are pending: then the next quantum tries again (`D18` concerns
    /// objects of a server only).
    pub(super) fn begin_turn(&mut self, heading: f32, world: &mut World) {
        if self.motions_pending() {
            return;
        }
        let own = self.heading(world);
        let d = heading_diff(heading, own, Command::TURN_RIGHT, &world.profile);
        let turn = if d <= 180.0 {
            (d > EPSILON).then_some(Command::TURN_RIGHT)
        } else {
            (d + EPSILON <= 360.0).then_some(Command::TURN_LEFT)
        };
        let Some(turn) = turn else {
            self.next_node(world);
            return;
        };
        let Some(m) = self.move_to() else {
            return;
        };
        let mut params = m.own_motion_params(world);
        params.hold_key = m.params.hold_key;
        if let Err(error) = self.move_to_do_motion(turn, &mut params, world) {
            self.cancel_moveto_with(error, world);
            return;
        }
        if let Some(m) = self.move_to_mut() {
            m.current_command = turn;
            m.previous_heading = d;
        }
    }

    /// Normalises and requests a motion; the speed of `params` is changed with it (11.9).
    pub(super) fn move_to_do_motion(
        &mut self,
        command: Command,
        params: &mut MovementParameters,
        world: &mut World,
    ) -> MotionResult {
        if self.interp().is_none() {
            return Err(MotionError::NoMotionInterpreter);
        }
        let adjusted = self.adjusted(command, params, params.hold_key, world);
        self.interp_do_interpreted_motion(adjusted, params, world)
    }

    /// Normalises a motion and requests its end; the answer is not asked anywhere.
    pub(super) fn move_to_stop_motion(
        &mut self,
        command: Command,
        params: &mut MovementParameters,
        world: &mut World,
    ) {
        if self.interp().is_some() {
            let adjusted = self.adjusted(command, params, params.hold_key, world);
            let _ = self.interp_stop_interpreted_motion(adjusted, params, world);
        }
    }

    /// Distance to the target by the rule of the present parameters, m.
    pub(super) fn move_to_distance(&self, world: &World) -> f32 {
        self.move_to()
            .map_or(f32::MAX, |m| m.distance_from(self, &world.profile))
    }

    /// The running leg begins again: its motion was dropped in the air (11.13).
    pub(super) fn move_to_hit_ground(&mut self, world: &mut World) {
        if self.is_moving_to() {
            self.begin_next_node(world);
        }
    }

    /// News of the target (11.14).
    pub(super) fn move_to_handle_update_target(&mut self, info: &TargetInfo, world: &mut World) {
        let own = self.body.position;
        let (guid, now) = (self.guid(), world.clock.now);
        let Some(m) = self.move_to_mut() else {
            return;
        };
        if info.object_id != m.top_level_object_id {
            return;
        }
        let ok = info.status == TargetStatus::Ok;
        match (m.initialized, ok, m.kind) {
            (true, true, MoveToKind::Object) => {
                m.sought_position = info.interpolated_position;
                m.current_target_position = info.target_position;
                m.restart_progress(f32::MAX, now);
            }
            (true, true, _) => {}
            (true, false, _) => self.cancel_moveto_with(MotionError::ObjectGone, world),
            (false, _, _) if m.top_level_object_id == guid => {
                m.sought_position = own;
                m.current_target_position = own;
                self.end_move_to(world);
            }
            (false, true, MoveToKind::Object) => self.move_to_object_internal(info, world),
            (false, true, MoveToKind::TurnToObject) => self.turn_to_object_internal(info, world),
            (false, true, _) => {}
            (false, false, _) => self.cancel_moveto_with(MotionError::NoObject, world),
        }
    }

    /// Stops the motions of the activity and forgets it; its nodes stay (`CleanUp`, 11.16).
    fn clean_up_move_to(&mut self, world: &mut World) {
        let Some(m) = self.move_to() else {
            return;
        };
        let (current, aux) = (m.current_command, m.aux_command);
        let tracks = m.top_level_object_id != 0 && m.is_active();
        let mut params =
            MovementParameters::new(&world.profile).with(MovementFlags::CANCEL_MOVETO, false);
        params.hold_key = m.params.hold_key;
        for command in [current, aux] {
            if command != Command::NONE {
                self.move_to_stop_motion(command, &mut params, world);
            }
        }
        if tracks {
            self.clear_target(world);
        }
        let now = world.clock.now;
        if let Some(m) = self.move_to_mut() {
            m.reset(now);
        }
    }

    /// `CleanUpAndCallWeenie`; the weenie of a client asks for nothing.
    fn end_move_to(&mut self, world: &mut World) {
        self.clean_up_move_to(world);
        self.stop_completely(world);
    }

    /// Ends a running activity (`CancelMoveTo`). The reason would be for a weenie of a server.
    pub(crate) fn cancel_moveto_with(&mut self, _reason: MotionError, world: &mut World) {
        if let Some(m) = self.move_to_mut()
            && m.is_active()
        {
            m.nodes.clear();
            self.end_move_to(world);
        }
    }
}
