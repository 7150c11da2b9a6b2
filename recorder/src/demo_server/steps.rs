//! The steps of a scene's script in the words of the protocol, and the messages of a frame.

use std::collections::BTreeMap;

use ac_client::math::{CellId, Position, Quat, Vec3};
use ac_client::motion::{Command, UpdateKind};
use ac_client::net::messages::PlainServerMessage as P;
use ac_client::net::messages::object as m;
use ac_client::net::transport::Queue;
use ac_client::physics::network::Stamp;
use ac_golden_traces::scene::{Action, PositionSpec, ScriptStep};
use ac_replayer::client::move_parameters;

use super::DemoServer;
use super::describe;
use super::known::Hints;

impl DemoServer {
    /// Tells what a frame that has just run has changed.
    pub(super) fn tell(&mut self, frame: u32) {
        let mut hints = self.steps_of(frame);
        let player = hints.entry(self.player()).or_default();
        // The last to move the player is either its client or the script.
        self.avatar.autonomous &= !player.scripted;
        player.own = true;
        player.autonomous = self.avatar.autonomous;
        player.thrown |= core::mem::take(&mut self.avatar.jumped);
        let mut out = Vec::new();
        let none = Hints::default();
        for known in &mut self.known {
            let hints = hints.get(&known.guid()).unwrap_or(&none);
            let own = known.id == self.avatar.id;
            if own && hints.teleported {
                // The client enters portal space before it gets the place.
                self.avatar.teleporting = true;
                let stamp = known.stamps[Stamp::Teleport as usize].wrapping_add(1);
                out.push(P::PlayerTeleport(m::PlayerTeleport { stamp }));
            }
            let interval = self.config.position_interval;
            known.tell(&self.run.world, hints, interval, &self.instances, &mut out);
        }
        for message in out {
            self.say(Queue::SMARTBOX, message);
        }
    }

    /// What the script did in a frame, by object. Objects come and go on the way.
    fn steps_of(&mut self, frame: u32) -> BTreeMap<u32, Hints> {
        let mut all: BTreeMap<u32, Hints> = BTreeMap::new();
        while let Some(step) = self.config.scene.script.get(self.next_step) {
            if step.frame > frame {
                break;
            }
            let step = step.clone();
            self.next_step += 1;
            match &step.action {
                Action::Create { entity } => {
                    self.forget(entity.guid);
                    self.introduce(entity);
                }
                Action::Destroy => self.forget(step.guid),
                _ => self.hint(&step, all.entry(step.guid).or_default()),
            }
        }
        all
    }

    /// The client is told that an object is gone.
    fn forget(&mut self, guid: u32) {
        let Some(at) = self.known.iter().position(|known| known.guid() == guid) else {
            return;
        };
        let gone = self.known.remove(at);
        let instance = gone.stamps[Stamp::Instance as usize];
        self.say(
            Queue::SMARTBOX,
            P::DeleteObject(m::DeleteObject { guid, instance }),
        );
    }

    fn hint(&self, step: &ScriptStep, hints: &mut Hints) {
        hints.scripted = true;
        match &step.action {
            Action::DoMotion { command, speed, .. }
            | Action::DoInterpretedMotion { command, speed }
                if Command(*command).is_action() =>
            {
                hints.actions.push((Command(*command), *speed));
            }
            Action::Jump { .. } | Action::SetVelocity { .. } => hints.thrown = true,
            Action::SetPosition { .. } => hints.teleported = true,
            Action::SetHeading { .. } => hints.turned = true,
            Action::StickTo { target, .. } => hints.stick_to = Some(*target),
            Action::MoveToPosition { .. }
            | Action::MoveToObject { .. }
            | Action::TurnToHeading { .. }
            | Action::TurnToObject { .. } => {
                let entity = self.run.object(step.guid);
                if let Some(entity) = entity.and_then(|id| self.run.world.entity(id)) {
                    hints.movement = self
                        .move_to(&step.action, entity)
                        .map(|kind| describe::server_movement(entity, kind));
                }
            }
            _ => {}
        }
    }

    /// A move-to as it travels.
    fn move_to(&self, action: &Action, entity: &ac_client::entity::Entity) -> Option<UpdateKind> {
        let world = &self.run.world;
        let profile = &world.profile;
        let run_rate = entity
            .interp()
            .map_or(1.0, |interp| interp.run_rate(&entity.mover(world)));
        let target_of = |guid: u32| {
            let target = self.run.object(guid).and_then(|id| world.entity(id));
            target.map(|target| (target.body.position, target.heading(world)))
        };
        Some(match action {
            Action::MoveToPosition { position, params } => UpdateKind::MoveToPosition {
                origin: place(position),
                params: move_parameters(params, profile),
                run_rate,
            },
            Action::MoveToObject { target, params } => UpdateKind::MoveToObject {
                guid: *target,
                origin: target_of(*target)?.0,
                params: move_parameters(params, profile),
                run_rate,
            },
            Action::TurnToObject { target, params } => UpdateKind::TurnToObject {
                guid: *target,
                heading: target_of(*target)?.1,
                params: move_parameters(params, profile),
            },
            Action::TurnToHeading { heading, params } => {
                let mut params = move_parameters(params, profile);
                params.desired_heading = *heading;
                UpdateKind::TurnToHeading(params)
            }
            _ => return None,
        })
    }
}

/// A position of a scene; a move-to's has no rotation on the wire.
fn place(spec: &PositionSpec) -> Position {
    Position::new(CellId(spec.cell), Vec3::from(spec.origin), Quat::IDENTITY)
}
