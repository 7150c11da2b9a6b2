//! The managers at work on their object: what they need of the world, and what they do to it (part F).

use super::interpolation::{Follow, InterpolateOutcome};
use super::sticky::StickyPull;
use super::target::{Report, TargetInfo, TargetManager, TargetStatus};
use crate::entity::Entity;
use crate::math::{Frame, Position};
use crate::physics::placement::SetPositionError;
use crate::physics::state::TransientState;
use crate::profile::IndoorBlip;
use crate::world::World;

/// Watchers are looked through at this interval, s.
const CHECK_INTERVAL: f64 = 0.5;
/// A target that was never heard of is given up after this time, s.
const TARGET_TIMEOUT: f64 = 10.0;
/// A sticky target tells again after this way, m.
const STICKY_RADIUS: f32 = 0.5;
/// A sticky target predicts its place this far ahead, s.
const STICKY_QUANTUM: f64 = 0.5;

/// Position manager (F1 to F4).
impl Entity {
    /// Changes the offset (own axes, m) of a quantum of `quantum` s: interpolation, then sticky, then constraint (`adjust_offset`).
    pub fn adjust_offset(&mut self, offset: &mut Frame, quantum: f64, world: &mut World) {
        self.follow_interpolation(offset, quantum as f32, world);
        self.pull_to_target(offset, quantum as f32, world);
        let contact = self.kin.transient.contains(TransientState::CONTACT);
        let constraint = self
            .position_manager
            .as_mut()
            .and_then(|m| m.constraint.as_mut());
        if let Some(constraint) = constraint {
            constraint.adjust_offset(offset, contact, &world.profile);
        }
    }

    fn follow_interpolation(&mut self, offset: &mut Frame, quantum: f32, world: &mut World) {
        let contact = self.kin.transient.contains(TransientState::CONTACT);
        let position = self.body.position;
        let Some(manager) = &self.position_manager else {
            return;
        };
        let sticky = manager.sticky_target() != 0;
        let Some(interpolation) = &manager.interpolation else {
            return;
        };
        let max_speed = if interpolation.needs_speed(&position, contact) {
            self.adjusted_max_speed(world)
        } else {
            0.0
        };
        let object = Follow {
            position: &position,
            contact,
            sticky,
            max_speed,
            quantum,
        };
        if let Some(interpolation) = self
            .position_manager
            .as_mut()
            .and_then(|m| m.interpolation.as_mut())
        {
            interpolation.adjust_offset(offset, &object, &world.profile);
        }
    }

    fn pull_to_target(&mut self, offset: &mut Frame, quantum: f32, world: &mut World) {
        let sticky = self.position_manager.as_ref().and_then(|m| m.sticky);
        let Some(sticky) = sticky.filter(|s| s.is_pulling()) else {
            return;
        };
        let max_speed = self.max_speed(world);
        let target_now = self.position_of_guid(sticky.target_id, world);
        let object = StickyPull {
            position: &self.body.position,
            radius: self.radius(),
            target_now: target_now.as_ref(),
            max_speed,
            quantum,
        };
        sticky.adjust_offset(offset, &object, &world.profile);
    }

    /// Place of an object of the object table, this one included.
    fn position_of_guid(&self, guid: u32, world: &World) -> Option<Position> {
        let id = world.entity_of_guid(guid)?;
        if id == self.id {
            return Some(self.body.position);
        }
        world.entity(id).map(|e| e.body.position)
    }

    /// The position manager's work of one quantum (`UseTime`): blips, and the end of sticking.
    pub fn position_manager_use_time(&mut self, world: &mut World) {
        self.interpolation_use_time(world);
        let over = self
            .position_manager
            .as_ref()
            .and_then(|m| m.sticky.as_ref())
            .is_some_and(|s| s.is_over(world.clock.now));
        if over {
            self.unstick_from_object(world);
        }
    }

    fn interpolation_use_time(&mut self, world: &mut World) {
        let own = self.body.position;
        let interpolation = self
            .position_manager
            .as_mut()
            .and_then(|m| m.interpolation.as_mut());
        let Some(interpolation) = interpolation else {
            return;
        };
        let Some(blip) = interpolation.blip() else {
            if let Some(velocity) = interpolation.complete_head(&own) {
                self.set_velocity(velocity, world);
            }
            return;
        };
        if self.set_position_simple(&blip.target, true, world) != SetPositionError::Ok {
            // Tried again in the next quantum.
            return;
        }
        if let Some(velocity) = blip.velocity {
            self.set_velocity(velocity, world);
        }
        self.stop_interpolating();
    }

    /// Forgets the server positions that wait.
    pub fn stop_interpolating(&mut self) {
        if let Some(interpolation) = self
            .position_manager
            .as_mut()
            .and_then(|m| m.interpolation.as_mut())
        {
            interpolation.stop();
        }
    }

    /// Follows a position of the server (`InterpolateTo`).
    pub fn interpolate_to(&mut self, target: &Position, keep_heading: bool, world: &mut World) {
        let own = self.body.position;
        let blip_distance = self.blip_distance(world);
        let manager = self.make_position_manager(world);
        let outcome = manager
            .interpolation
            .get_or_insert_default()
            .interpolate_to(target, keep_heading, &own, blip_distance, &world.profile);
        if let InterpolateOutcome::Reached(Some(heading)) = outcome {
            self.set_heading(heading, world);
        }
    }

    /// Distance from which a server position is a jump, m (`GetAutonomyBlipDistance`; O-42).
    fn blip_distance(&self, world: &World) -> f32 {
        if !self.body.position.cell.is_indoor() {
            return 100.0;
        }
        let long = match world.profile.indoor_blip {
            IndoorBlip::LocalPlayer25 => world.local_player == Some(self.id),
            IndoorBlip::Players25 => self.body.weenie.player,
            IndoorBlip::All20 => false,
        };
        if long { 25.0 } else { 20.0 }
    }

    /// Slows the object after `start` metres of way and holds it after `max` (`ConstrainTo`).
    pub fn constrain_to(&mut self, place: &Position, start: f32, max: f32, world: &mut World) {
        let own = self.body.position;
        let manager = self.make_position_manager(world);
        manager
            .constraint
            .get_or_insert_default()
            .constrain_to(place, start, max, &own);
    }

    /// Lifts the constraint.
    pub fn unconstrain(&mut self) {
        if let Some(constraint) = self
            .position_manager
            .as_mut()
            .and_then(|m| m.constraint.as_mut())
        {
            constraint.unconstrain();
        }
    }

    /// Sticks to the object of a GUID, whose radius is `radius` m, for a second (`StickTo`). Its height is not used.
    pub fn stick_to(&mut self, guid: u32, radius: f32, _height: f32, world: &mut World) {
        self.make_position_manager(world);
        self.unstick_from_object(world);
        let now = world.clock.now;
        if let Some(manager) = &mut self.position_manager {
            manager
                .sticky
                .get_or_insert_default()
                .set(guid, radius, now);
        }
        self.set_target(0, guid, STICKY_RADIUS, STICKY_QUANTUM, world);
    }

    /// Sticks to the object of a GUID, or to what carries it (`stick_to_object`; O-37). An unknown one changes nothing.
    pub fn stick_to_object(&mut self, guid: u32, world: &mut World) {
        self.make_position_manager(world);
        let Some(target) = world.entity_of_guid(guid).and_then(|id| world.entity(id)) else {
            return;
        };
        let parent = if world.profile.stick_to_own_parent {
            self.parent()
        } else {
            target.parent()
        };
        let target = parent.and_then(|id| world.entity(id)).unwrap_or(target);
        let (guid, radius, height) = (target.guid(), target.radius(), target.height());
        self.stick_to(guid, radius, height, world);
    }

    /// Ends sticking (`UnStick`): the target is forgotten and a move-to ends.
    pub fn unstick_from_object(&mut self, world: &mut World) {
        let had = self
            .position_manager
            .as_mut()
            .and_then(|m| m.sticky.as_mut())
            .is_some_and(|s| s.clear());
        if had {
            self.clear_target(world);
            self.cancel_moveto(world);
        }
    }

    /// Whether server positions are being followed.
    pub fn is_interpolating(&self) -> bool {
        self.position_manager
            .as_ref()
            .is_some_and(|m| m.is_interpolating())
    }

    /// Whether the constraint is nearly used up.
    pub fn is_fully_constrained(&self, world: &World) -> bool {
        self.position_manager
            .as_ref()
            .is_some_and(|m| m.is_fully_constrained(&world.profile))
    }
}

/// Target manager (F5).
impl Entity {
    fn report(&self) -> Report<'_> {
        Report {
            guid: self.body.guid,
            position: &self.body.position,
            velocity: self.kin.cached_velocity,
        }
    }

    /// Watches the object of a GUID, which tells its place at once and then whenever it has moved `radius` m, `quantum` s ahead (`SetTarget`).
    pub fn set_target(
        &mut self,
        context_id: u32,
        guid: u32,
        radius: f32,
        quantum: f64,
        world: &mut World,
    ) {
        self.clear_target(world);
        if guid == 0 {
            let info = TargetInfo {
                context_id,
                status: TargetStatus::TimedOut,
                ..TargetInfo::default()
            };
            self.handle_update_target(&info, world);
            return;
        }
        self.target_manager.get_or_insert_default().target = Some(TargetInfo {
            context_id,
            object_id: guid,
            radius,
            quantum,
            last_update_time: world.clock.now,
            ..TargetInfo::default()
        });
        self.ask_target(guid, radius, quantum, world);
    }

    /// Enters this object in the target's list of watchers; a new watcher is told the place at once.
    fn ask_target(&mut self, guid: u32, radius: f32, quantum: f64, world: &mut World) {
        let own = self.body.guid;
        let news = if guid == own {
            self.add_voyeur(own, radius, quantum)
        } else {
            world
                .entity_of_guid(guid)
                .and_then(|id| world.entity_mut(id))
                .and_then(|target| target.add_voyeur(own, radius, quantum))
        };
        if let Some(news) = news {
            self.receive_target_update(&news, world);
        }
    }

    fn add_voyeur(&mut self, guid: u32, radius: f32, quantum: f64) -> Option<TargetInfo> {
        let mut manager = self.target_manager.take().unwrap_or_default();
        let news = manager.add_voyeur(guid, radius, quantum, &self.report());
        self.target_manager = Some(manager);
        news
    }

    /// Stops watching (`ClearTarget`).
    pub fn clear_target(&mut self, world: &mut World) {
        let target = self.target_manager.as_mut().and_then(|m| m.target.take());
        let Some(target) = target else { return };
        let own = self.body.guid;
        let manager = if target.object_id == own {
            self.target_manager.as_mut()
        } else {
            world
                .entity_of_guid(target.object_id)
                .and_then(|id| world.entity_mut(id))
                .and_then(|t| t.target_manager.as_mut())
        };
        if let Some(manager) = manager {
            manager.remove_voyeur(own);
        }
    }

    /// Has the target predict its place `quantum` s ahead (`SetTargetQuantum`; O-40).
    pub fn set_target_quantum(&mut self, quantum: f64, world: &mut World) {
        let keeps_without_target = !world.profile.unknown_target_times_out;
        let own = self.body.guid;
        let Some(target) = self.target_manager.as_mut().and_then(|m| m.target.as_mut()) else {
            return;
        };
        let exists = target.object_id == own || world.entity_of_guid(target.object_id).is_some();
        if exists || keeps_without_target {
            target.quantum = quantum;
        }
        if exists {
            let (guid, radius) = (target.object_id, target.radius);
            // The wire between the two is f32.
            self.ask_target(guid, radius, f64::from(quantum as f32), world);
        }
    }

    /// Quantum of the present target, s; 0 without one.
    pub fn target_quantum(&self) -> f64 {
        self.target_manager
            .as_ref()
            .map_or(0.0, |m| m.target_quantum())
    }

    /// News of a target (`ReceiveUpdate`).
    pub fn receive_target_update(&mut self, update: &TargetInfo, world: &mut World) {
        let own = self.body.position;
        let now = world.clock.now;
        let info = self
            .target_manager
            .as_mut()
            .and_then(|m| m.receive_update(update, &own, now));
        let Some(info) = info else { return };
        self.handle_update_target(&info, world);
        if update.status == TargetStatus::ExitWorld {
            self.clear_target(world);
        }
    }

    /// Hands news of the target on: to move-to, then to sticking (`HandleUpdateTarget`).
    fn handle_update_target(&mut self, info: &TargetInfo, world: &mut World) {
        if info.context_id != 0 {
            return;
        }
        if self.movement.is_some() {
            self.movement_handle_update_target(info, world);
        }
        let sticky = self
            .position_manager
            .as_mut()
            .and_then(|m| m.sticky.as_mut())
            .filter(|s| s.target_id == info.object_id);
        let Some(sticky) = sticky else { return };
        if info.status == TargetStatus::Ok {
            sticky.initialized = true;
            sticky.target_position = info.target_position;
        } else {
            self.unstick_from_object(world);
        }
    }

    /// Looks through the watchers and tells those for whom this object has moved enough (`HandleTargetting`).
    pub fn handle_targetting(&mut self, world: &mut World) {
        let now = world.clock.now;
        // O-20: inside the step, or of the frame.
        let time = world.collision_clock();
        let times_out = world.profile.unknown_target_times_out;
        let Some(manager) = &mut self.target_manager else {
            return;
        };
        if time - manager.last_update < CHECK_INTERVAL {
            return;
        }
        if let Some(target) = &mut manager.target
            && target.status == TargetStatus::Undefined
        {
            if !times_out {
                return;
            }
            if target.last_update_time + TARGET_TIMEOUT < now {
                target.status = TargetStatus::TimedOut;
                let info = *target;
                self.handle_update_target(&info, world);
            }
        }
        self.for_each_voyeur(world, |manager, index, report| {
            let voyeur = manager.voyeurs.get_mut(index)?;
            let ahead = voyeur.due(report)?;
            Some(voyeur.update(ahead, report, TargetStatus::Ok))
        });
        if let Some(manager) = &mut self.target_manager {
            manager.last_update = time;
        }
    }

    /// Tells all watchers what happened (`NotifyVoyeurOfEvent`).
    pub fn notify_voyeurs(&mut self, status: TargetStatus, world: &mut World) {
        self.for_each_voyeur(world, |manager, index, report| {
            let voyeur = manager.voyeurs.get_mut(index)?;
            Some(voyeur.update(*report.position, report, status))
        });
    }

    /// Delivers to every watcher what `news` has for it. The list may change meanwhile.
    fn for_each_voyeur(
        &mut self,
        world: &mut World,
        news: impl Fn(&mut TargetManager, usize, &Report<'_>) -> Option<TargetInfo>,
    ) {
        let mut index = 0;
        while let Some(mut manager) = self.target_manager.take() {
            let voyeur = manager.voyeurs.get(index).map(|v| v.object_id);
            let update = news(&mut manager, index, &self.report());
            self.target_manager = Some(manager);
            let Some(voyeur) = voyeur else { return };
            if let Some(update) = update {
                self.deliver(voyeur, &update, world);
            }
            let still_there = self
                .target_manager
                .as_ref()
                .and_then(|m| m.voyeurs.get(index))
                .is_some_and(|v| v.object_id == voyeur);
            index += usize::from(still_there);
        }
    }

    /// What the watcher does about it may come back to this object, so this object is in the world meanwhile.
    fn deliver(&mut self, voyeur: u32, update: &TargetInfo, world: &mut World) {
        let Some(id) = world.entity_of_guid(voyeur) else {
            return;
        };
        if id == self.id {
            self.receive_target_update(update, world);
            return;
        }
        self.lend(world, |world| {
            world.with_entity(id, |v, world| v.receive_target_update(update, world));
        });
    }
}
