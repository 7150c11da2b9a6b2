//! One frame: its stages in order, and who fills them in (`spec/00-overview.md`, section 3).
//!
//! Network, streaming, input, entity tick, render, plugin. The library owns the entity tick; a [`Host`] (a client, a scene driver, a replayer)
//! fills in the others, each with the world in its hands. The clock advances first and stands still until the next frame.

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
    /// Landblocks around the load point.
    fn streaming(&mut self, _world: &mut World) {}
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
    /// When it last ran, s; only the engine gate looks at it.
    last_update: f64,
    /// The entities of this frame, in order; reused.
    order: Vec<EntityId>,
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
        host.input(world);
        self.entity_tick(world, host, probe);
        host.render(world);
        host.plugin(world);
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
        // What is created meanwhile is first visited in the next frame.
        self.order.clear();
        self.order.extend_from_slice(world.entities.table());
        world.set_in_tick(true);
        for &id in &self.order {
            if !world.entities.is_registered(id) {
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
