//! Scenes built in a few words, and what a run of one leaves behind.

use std::sync::Arc;

use ac_client::{
    dat::DatSet,
    frame::{FrameState, FrameStates, NoProbe, state::Outcome},
    profile::Profile,
};
use ac_golden_traces::{
    Scene,
    scene::{
        Action, EntityKind, EntitySpec, FrameRun, HoldKey, MoveParams, PositionSpec, SCENE_SCHEMA,
        ScriptStep,
    },
};
use ac_replayer::{SimulationError, client::SceneRun};

use super::{invariants::Watch, worlds::Playground};

/// GUID of the first entity; the others count up.
pub const GUID: u32 = 0x7000_0001;
/// A frame that is one quantum, s.
pub const DT: f64 = 0.04;

/// Command words of the motion table of [`Playground`].
pub const WALK: u32 = 0x4500_0005;
/// Side-step to the right.
pub const SIDE: u32 = 0x6500_000F;
/// Turn to the right.
pub const TURN: u32 = 0x6500_000D;

/// State words: falls and reports collisions; the same and does not fall off edges; neither.
pub const FALLS: u32 = 0x0000_0408;
/// A player or creature.
pub const CREATURE: u32 = 0x0040_0C08;
/// Does not fall.
pub const FLOATS: u32 = 0x0000_0008;
/// A missile that falls.
pub const MISSILE: u32 = 0x0000_0548;

/// A scene on a world in memory.
#[derive(Debug, Clone)]
pub struct Stage {
    /// The scene.
    pub scene: Scene,
    /// Its world.
    pub source: Arc<DatSet>,
    /// Landblock of new entities.
    pub block: u32,
    /// Nothing may leave this box (landblock coordinates), if there is one.
    pub closed: Option<[[f32; 3]; 2]>,
}

impl Stage {
    /// An empty scene on the home block of a playground; its clock starts at 1000 s.
    pub fn new(play: &Playground) -> Self {
        Self {
            scene: Scene {
                schema: SCENE_SCHEMA.into(),
                name: "generated/scene".into(),
                summary: String::new(),
                world: "generated".into(),
                features: Vec::new(),
                start_time: 1000.0,
                frames: Vec::new(),
                entities: Vec::new(),
                script: Vec::new(),
                track: Vec::new(),
            },
            source: Arc::clone(&play.source),
            block: play.home,
            closed: None,
        }
    }

    /// New entities are put into this landblock (`0xXXYY0000`).
    #[must_use]
    pub fn in_block(mut self, block: u32) -> Self {
        self.block = block;
        self
    }

    /// Adds frames.
    #[must_use]
    pub fn frames(mut self, dt: f64, count: u32) -> Self {
        self.scene.frames.push(FrameRun { dt, count });
        self
    }

    /// Adds an entity that the caller describes further.
    #[must_use]
    pub fn entity(
        mut self,
        setup: u32,
        origin: [f32; 3],
        change: impl FnOnce(&mut EntitySpec),
    ) -> Self {
        let mut spec = EntitySpec {
            guid: GUID + self.scene.entities.len() as u32,
            kind: EntityKind::Object,
            setup,
            motion_table: 0,
            scale: 1.0,
            position: place(self.block, origin),
            state: FALLS,
            velocity: [0.0; 3],
            omega: [0.0; 3],
            elasticity: 0.05,
            friction: 0.95,
            run_rate: 1.0,
            jump_velocity: 0.0,
            parent: None,
        };
        change(&mut spec);
        self.scene.track.push(spec.guid);
        self.scene.entities.push(spec);
        self
    }

    /// Adds something that is thrown.
    #[must_use]
    pub fn thrown(self, setup: u32, origin: [f32; 3], velocity: [f32; 3]) -> Self {
        self.entity(setup, origin, |spec| spec.velocity = velocity)
    }

    /// Adds a player that stands and faces a compass heading.
    #[must_use]
    pub fn walker(self, play: &Playground, origin: [f32; 3], heading: f32) -> Self {
        self.entity(play.walker, origin, |spec| {
            spec.kind = EntityKind::Player;
            spec.motion_table = play.table;
            spec.state = CREATURE;
            spec.jump_velocity = 9.0;
            spec.position.rotation = compass(heading);
        })
    }

    /// Adds a step of the script for entity number `index`.
    #[must_use]
    pub fn at(mut self, frame: u32, index: u32, action: Action) -> Self {
        self.scene.script.push(ScriptStep {
            frame,
            guid: GUID + index,
            action,
        });
        self.scene.script.sort_by_key(|step| step.frame);
        self
    }

    /// The first entity walks from a frame on.
    #[must_use]
    pub fn walks(self, frame: u32) -> Self {
        self.at(frame, 0, motion(WALK, 1.0))
    }

    /// Nothing may leave a box.
    #[must_use]
    pub fn closed(mut self, low: [f32; 3], high: [f32; 3]) -> Self {
        self.closed = Some([low, high]);
        self
    }

    /// The clock starts elsewhere, s.
    #[must_use]
    pub fn starts(mut self, time: f64) -> Self {
        self.scene.start_time = time;
        self
    }

    /// Runs it to its end.
    ///
    /// # Errors
    /// When the scene cannot be set up.
    pub fn run(&self, profile: &Profile, watch: &mut Watch) -> Result<Run, SimulationError> {
        let mut run = SceneRun::new(&self.scene, Arc::clone(&self.source), profile)?;
        let mut left = Run::default();
        let mut states = FrameStates::new();
        run.write_records(-1, &mut states);
        left.take(&states);
        for frame in 0..self.scene.frame_count() {
            run.run_frame(frame, &mut NoProbe);
            run.write_records(i32::try_from(frame).unwrap_or(i32::MAX), &mut states);
            watch.frame(&run, &states);
            left.take(&states);
        }
        left.notes = run.notes().to_vec();
        Ok(left)
    }
}

/// A position in a landblock; the cell is the outdoor one below it.
pub fn place(block: u32, origin: [f32; 3]) -> PositionSpec {
    let column = |c: f32| (c / 24.0).clamp(0.0, 7.0) as u32;
    PositionSpec {
        cell: (block & 0xFFFF_0000) | (column(origin[0]) * 8 + column(origin[1]) + 1),
        origin,
        rotation: [1.0, 0.0, 0.0, 0.0],
    }
}

/// A position in a room.
pub fn indoors(cell: u32, origin: [f32; 3]) -> PositionSpec {
    PositionSpec {
        cell,
        origin,
        rotation: [1.0, 0.0, 0.0, 0.0],
    }
}

/// The rotation of a compass heading, degrees: 0 north, 90 east.
pub fn compass(heading: f32) -> [f32; 4] {
    let half = -heading.to_radians() / 2.0;
    [half.cos(), 0.0, 0.0, half.sin()]
}

/// A motion of the local input.
pub fn motion(command: u32, speed: f32) -> Action {
    Action::DoMotion {
        command,
        speed,
        hold_key: HoldKey::None,
    }
}

/// A move-to with the default parameters.
pub fn move_to(block: u32, origin: [f32; 3]) -> Action {
    Action::MoveToPosition {
        position: place(block, origin),
        params: MoveParams::default(),
    }
}

/// What a run left behind: the states of every tracked entity, frame by frame from -1 on.
#[derive(Debug, Clone, Default)]
pub struct Run {
    /// Per entity, in the order of `track`.
    pub states: Vec<Vec<FrameState>>,
    /// What went otherwise than wanted when entities were made.
    pub notes: Vec<String>,
}

impl Run {
    fn take(&mut self, states: &FrameStates) {
        for (index, state) in states.iter().enumerate() {
            if self.states.len() <= index {
                self.states.push(Vec::new());
            }
            self.states[index].push(state.clone());
        }
    }

    /// Frames run.
    pub fn frames(&self) -> u64 {
        self.states
            .first()
            .map_or(0, |states| states.len().saturating_sub(1) as u64)
    }

    /// The first entity's states.
    pub fn first(&self) -> &[FrameState] {
        self.states.first().map_or(&[], Vec::as_slice)
    }

    /// The last state of an entity.
    pub fn last(&self, index: usize) -> FrameState {
        let states = self.states.get(index).map_or(&[][..], Vec::as_slice);
        states.last().cloned().unwrap_or_default()
    }

    /// The first entity's last place.
    pub fn end(&self) -> [f32; 3] {
        self.last(0).origin
    }

    /// Whether a quantum of the first entity ended so.
    pub fn has(&self, outcome: Outcome) -> bool {
        self.first()
            .iter()
            .flat_map(|state| &state.steps)
            .any(|step| step.outcome == outcome)
    }

    /// Quanta of the first entity.
    pub fn quanta(&self) -> usize {
        self.first().iter().map(|state| state.steps.len()).sum()
    }

    /// The bits of every place and rotation of an entity, for exact comparison.
    pub fn bits(&self, index: usize) -> Vec<[u32; 7]> {
        let states = self.states.get(index).map_or(&[][..], Vec::as_slice);
        states
            .iter()
            .map(|s| {
                let [x, y, z] = s.origin.map(f32::to_bits);
                let [w, i, j, k] = s.rotation.map(f32::to_bits);
                [x, y, z, w, i, j, k]
            })
            .collect()
    }
}
