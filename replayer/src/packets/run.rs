//! A session as it is replayed, frame by frame.

use std::sync::Arc;

use ac_client::dat::DatSet;
use ac_client::frame::state::Fields;
use ac_client::frame::{FrameState, FrameStates, NoHost, NoProbe, Pipeline};
use ac_client::math::Position;
use ac_client::motion::{Command, RawMotionState};
use ac_client::net::entities::Notice;
use ac_client::net::messages::common::WirePosition;
use ac_client::net::messages::{ClientMessage, GameAction};
use ac_client::net::stage::{NetworkStage, StageStats};
use ac_client::physics::body::EntityId;
use ac_client::profile::Profile;
use ac_client::world::{World, WorldSource};
use ac_golden_traces::Scene;
use serde_json::Value;

use super::{DatagramStats, Session};
use crate::simulation::{Simulation, SimulationError};

/// Positions that the recorded client reported, and what the library predicted at those moments.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reports {
    /// Reports with a position.
    pub count: u64,
    /// Of these the same, bit for bit, cell included.
    pub exact: u64,
    /// Largest distance, m.
    pub largest: f32,
    /// Frame of the first that was not exact.
    pub first_other: Option<u32>,
}

/// What a replay has met.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ReplayStats {
    /// Of the datagrams.
    pub datagrams: DatagramStats,
    /// Of the server's messages.
    pub stage: StageStats,
    /// Messages of the client that cannot be read.
    pub unreadable_from_client: u64,
    /// The client's own positions.
    pub reports: Reports,
}

/// A session that is being replayed.
#[derive(Debug)]
pub struct PacketRun {
    /// What the client knows of the world.
    pub world: World,
    /// Messages to objects.
    pub stage: NetworkStage,
    session: Arc<Session>,
    scene: Scene,
    pipeline: Pipeline,
    /// Clock after each frame's advance, s.
    times: Vec<f64>,
    next: usize,
    /// Which tracked entities have been there.
    seen: Vec<bool>,
    controlled_by_server: bool,
    last_action: u32,
    stats: ReplayStats,
}

impl PacketRun {
    /// A session before its first frame. The scene says when the frames are and whom to record.
    pub fn new(
        scene: &Scene,
        session: Arc<Session>,
        source: Arc<DatSet>,
        profile: &Profile,
    ) -> Self {
        let map: Arc<dyn WorldSource> = source;
        let stats = ReplayStats {
            datagrams: session.stats,
            ..ReplayStats::default()
        };
        Self {
            world: World::with_source(profile.clone(), scene.start_time, map),
            stage: NetworkStage::new(),
            pipeline: Pipeline::default(),
            times: scene.times().collect(),
            next: 0,
            seen: vec![false; scene.track.len()],
            controlled_by_server: true,
            last_action: 0,
            stats,
            session,
            scene: scene.clone(),
        }
    }

    /// What was met so far.
    pub const fn stats(&self) -> ReplayStats {
        ReplayStats {
            stage: self.stage.stats,
            ..self.stats
        }
    }

    /// GUID of the local player, once it is named.
    pub const fn player(&self) -> Option<u32> {
        self.stage.entities.player()
    }

    /// Runs a frame: messages, the recorded client's input, everything else.
    pub fn run_frame(&mut self, frame: u32) {
        let Some(&now) = self.times.get(frame as usize) else {
            return;
        };
        for (_, entity) in self.stage.entities.iter() {
            if let Some(entity) = self.world.entity_mut(entity.id) {
                entity.begin_frame();
            }
        }
        self.world.clock.now = now;
        let elapsed = now - self.times.first().copied().unwrap_or(now);
        let due = (elapsed * 1e9).round() as u64;
        let session = Arc::clone(&self.session);
        let first = self.next;
        self.next += session.deliveries[first..]
            .iter()
            .take_while(|delivery| delivery.time <= due)
            .count();
        let deliveries = &session.deliveries[first..self.next];
        // The messages of a frame come before its input, as in the client that was recorded.
        for delivery in deliveries.iter().filter(|d| !d.to_server) {
            // What cannot be read is counted by the stage.
            let _ = self.stage.deliver(&delivery.bytes, &mut self.world);
            self.take_notices();
        }
        self.stage.end_of_frame(&mut self.world);
        for delivery in deliveries.iter().filter(|d| d.to_server) {
            match ClientMessage::parse(&delivery.bytes) {
                Ok(parsed) => self.act(&parsed.message, frame),
                Err(_) => self.stats.unreadable_from_client += 1,
            }
        }
        self.pipeline
            .entity_tick(&mut self.world, &mut NoHost, &mut NoProbe);
    }

    fn take_notices(&mut self) {
        for notice in self.stage.entities.notices.drain(..) {
            match notice {
                Notice::Player(_) => {
                    self.controlled_by_server = true;
                    self.last_action = 0;
                }
                Notice::LostControl => self.controlled_by_server = true,
                Notice::ForcedPosition | Notice::PortalSpace | Notice::Autonomy(_) => {}
            }
        }
        self.stage.notes.clear();
    }

    /// What the recorded client did.
    fn act(&mut self, message: &ClientMessage, frame: u32) {
        let ClientMessage::Action { action, .. } = message else {
            return;
        };
        let Some(id) = self.world.local_player else {
            return;
        };
        match action {
            GameAction::LoginComplete(()) => self.stage.entities.leave_portal_space(),
            GameAction::AutonomousPosition(report) => self.compare(&report.position, frame, id),
            // While the server moves the player only a key that is pressed takes over; on arrival from portal space the resting state is sent.
            GameAction::MoveToState(report)
                if self.controlled_by_server && is_at_rest(report.state.state()) =>
            {
                self.compare(&report.position, frame, id);
            }
            GameAction::MoveToState(report) => {
                self.take_control(id);
                let last_action = &mut self.last_action;
                let (state, longjump) = (report.state.state(), report.bits & 2 != 0);
                self.world.with_entity(id, |player, world| {
                    player.apply_raw_state(state, longjump, last_action, world);
                });
                self.compare(&report.position, frame, id);
            }
            GameAction::Jump(jump) => {
                self.take_control(id);
                self.world.with_entity(id, |player, world| {
                    if let Some(interp) = player.interp_mut() {
                        interp.standing_longjump = false;
                    }
                    // One that the library refuses shows in the reports.
                    let _ = player.jump(jump.extent, world);
                });
                self.compare(&jump.position, frame, id);
            }
            _ => {}
        }
    }

    /// The first input after the server has moved the player (`spec/08-motion.md`, 13.8).
    fn take_control(&mut self, id: EntityId) {
        if !core::mem::take(&mut self.controlled_by_server) {
            return;
        }
        self.world.with_entity(id, |player, world| {
            player.kin.last_move_was_autonomous = true;
            player.stop_completely(world);
            player.stop_interpolating();
        });
    }

    fn compare(&mut self, reported: &WirePosition, frame: u32, id: EntityId) {
        let Some(player) = self.world.entity(id) else {
            return;
        };
        let (here, there) = (player.body.position, reported.to_position());
        let reports = &mut self.stats.reports;
        reports.count += 1;
        if same_bits(&here, &there) {
            reports.exact += 1;
            return;
        }
        reports.first_other.get_or_insert(frame);
        reports.largest = reports.largest.max(here.distance(&there));
    }

    fn write_records(&mut self, frame: i32, out: &mut FrameStates) {
        out.clear();
        let time = self.world.clock.now;
        for (&guid, seen) in self.scene.track.iter().zip(&mut self.seen) {
            let record = out.push(frame, time, guid);
            let known = self.stage.entities.get(guid);
            match known.and_then(|known| self.world.entity(known.id)) {
                Some(entity) => {
                    *seen = true;
                    entity.frame_state(frame, time, record);
                }
                None if *seen => record.gone(frame, time, guid, &[]),
                None => not_yet(record),
            }
        }
    }
}

/// Nothing is wanted.
fn is_at_rest(state: &RawMotionState) -> bool {
    state.forward.command == Command::READY
        && state.sidestep.command == Command::NONE
        && state.turn.command == Command::NONE
        && state.actions.is_empty()
}

/// The record of an entity that has not been described.
fn not_yet(record: &mut FrameState) {
    record.has = Fields::empty();
    record.anim = None;
}

fn same_bits(a: &Position, b: &Position) -> bool {
    let numbers = |p: &Position| {
        let ([x, y, z], q) = (p.frame.origin.to_array(), p.frame.rotation());
        [x, y, z, q.w, q.x, q.y, q.z].map(f32::to_bits)
    };
    a.cell == b.cell && numbers(a) == numbers(b)
}

impl Simulation for PacketRun {
    fn frame_minus_one(&mut self, out: &mut FrameStates) -> Result<(), SimulationError> {
        self.write_records(-1, out);
        Ok(())
    }

    fn step(&mut self, frame: u32, out: &mut FrameStates) -> Result<(), SimulationError> {
        self.run_frame(frame);
        self.write_records(i32::try_from(frame).unwrap_or(i32::MAX), out);
        Ok(())
    }

    fn load_state(&mut self, expected: &FrameState) -> Result<(), SimulationError> {
        let known = self.stage.entities.get(expected.guid).map(|known| known.id);
        if let Some(id) = known {
            self.world.with_entity(id, |entity, world| {
                entity.load_frame_state(expected, world);
            });
        }
        Ok(())
    }

    fn run_stage(
        &mut self,
        _records: &[Value],
        _index: usize,
    ) -> Result<Option<Value>, SimulationError> {
        Ok(None)
    }
}
