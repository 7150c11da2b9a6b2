//! One frame: its stages in order, and who fills them in (`spec/00-overview.md`, section 3).
//!
//! Network, streaming, input, entity tick, render, plugin. The library owns the entity tick; a [`Host`] (a client, a scene driver, a replayer)
//! fills in the others, each with the world in its hands. The clock advances first and stands still until the next frame.

use super::fidelity::Fidelity;
use super::probe::{NoProbe, Probe};
use crate::physics::body::EntityId;
use crate::world::World;

/// A named stage of a frame, in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FrameStage {
    /// Packets become messages, messages act on objects.
    Network,
    /// Landblocks come and go.
    Streaming,
    /// Keys, mouse, script.
    Input,
    /// Every entity is advanced to the frame's time.
    EntityTick,
    /// The frame is drawn.
    Render,
    /// Plugins run.
    Plugin,
}

impl FrameStage {
    /// Every stage, in order.
    pub const ALL: [Self; 6] = [
        Self::Network,
        Self::Streaming,
        Self::Input,
        Self::EntityTick,
        Self::Render,
        Self::Plugin,
    ];
}

/// What fills in the stages that are not the library's own. Every method may be left out.
pub trait Host {
    /// Packets and messages.
    fn network(&mut self, _world: &mut World) {}
    /// Landblocks around the load point: [`Streaming`](crate::world::Streaming) does it as the client does.
    fn streaming(&mut self, _world: &mut World) {}
    /// An object has been out of sight for 25 s (06 G7): it is deleted, unless the host's objects end otherwise.
    fn out_of_sight(&mut self, id: EntityId, world: &mut World) {
        world.delete_entity(id);
    }
    /// Input and script.
    fn input(&mut self, _world: &mut World) {}
    /// Called directly after the local player was advanced: camera, visibility.
    fn player_updated(&mut self, _world: &mut World) {}
    /// Drawing.
    fn render(&mut self, _world: &mut World) {}
    /// Plugins.
    fn plugin(&mut self, _world: &mut World) {}
}

/// A host that does nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoHost;

impl Host for NoHost {}

/// How often the entity tick runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pacing {
    /// In every frame; each object's own gate decides. Scenes and replays.
    #[default]
    EveryFrame,
    /// At most every 1/30 s, as the live client (`PhysicsEngine::UseTime`, 06 B1).
    EngineGate,
}

/// Runs frames.
#[derive(Debug, Clone, Default)]
pub struct Pipeline {
    /// How often the entity tick runs.
    pub pacing: Pacing,
    /// How finely time is cut; the limits of a quantum are read from the world's profile ([`Fidelity::apply`]).
    pub fidelity: Fidelity,
    /// When it last ran, s; only a limited tick rate looks at it.
    pub(crate) last_tick: Option<f64>,
    /// How many entity ticks have run; only remote entities look at it.
    pub(crate) ticks: u64,
    /// When it last ran, s; only the engine gate looks at it.
    pub(crate) last_update: f64,
    /// The entities of this frame, in order; reused.
    pub(crate) order: Vec<EntityId>,
}

impl Pipeline {
    /// A pipeline of a pacing.
    pub fn new(pacing: Pacing) -> Self {
        Self {
            pacing,
            ..Self::default()
        }
    }

    /// Runs the frame at `now`, s.
    pub fn run_frame(&mut self, world: &mut World, now: f64, host: &mut impl Host) {
        self.run_frame_probed(world, now, host, &mut NoProbe);
    }

    /// Runs the frame at `now`, s, under the eyes of a probe.
    pub fn run_frame_probed<P: Probe>(
        &mut self,
        world: &mut World,
        now: f64,
        host: &mut impl Host,
        probe: &mut P,
    ) {
        world.clock.now = now;
        world.begin_planned_frame();
        host.network(world);
        host.streaming(world);
        self.maintain(world, host);
        host.input(world);
        self.entity_tick(world, host, probe);
        host.render(world);
        host.plugin(world);
    }

    /// Object maintenance, after cells have come and gone (06 G7): what was lost and whose cell was loaded since the frame before re-enters, and
    /// what has been out of sight for too long ends. In this order: an object that comes back in time stays. An object waits for the next
    /// frame if its cell is loaded by somebody's move, so that no update changes what another one of the same frame meets.
    fn maintain(&mut self, world: &mut World, host: &mut impl Host) {
        world.readmit_lost();
        for id in world.due_for_destruction() {
            if world.local_player != Some(id) {
                host.out_of_sight(id, world);
            }
        }
    }

    /// Advances every entity, in order of registration, then the animations of static ones (06 B1).
    pub fn entity_tick<P: Probe>(
        &mut self,
        world: &mut World,
        host: &mut impl Host,
        probe: &mut P,
    ) {
        if self.pacing == Pacing::EngineGate && !self.gate_is_open(world) {
            return;
        }
        if self.fidelity.skips_tick(self.last_tick, world.clock.now) {
            return;
        }
        self.last_tick = Some(world.clock.now);
        self.ticks += 1;
        // What is created meanwhile is first visited in the next frame.
        self.order.clear();
        self.order.extend_from_slice(world.entities.table());
        world.set_in_tick(true);
        for &id in &self.order {
            if !world.entities.is_registered(id) {
                continue;
            }
            if self.fidelity.skips_entity(id, self.ticks, world) {
                continue;
            }
            world.update_entity(id, probe);
            if world.local_player == Some(id) {
                host.player_updated(world);
            }
        }
        world.set_in_tick(false);
        world.animate_statics();
        self.last_update = world.clock.now;
    }

    fn gate_is_open(&mut self, world: &World) -> bool {
        let elapsed = world.clock.now - self.last_update;
        if elapsed < 0.0 {
            self.last_update = world.clock.now;
            return false;
        }
        elapsed >= world.profile.min_quantum
    }
}
