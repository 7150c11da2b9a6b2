//! Scenes whose solution is known in closed form, on worlds made in memory.

use std::sync::Arc;

use ac_client::dat::{
    DatError, DatSet,
    worldgen::{SetupBuilder, WorldBuilder, block},
};
use ac_client::math::Vec3;
use ac_golden_traces::{
    Scene,
    scene::{EntityKind, EntitySpec, FrameRun, PositionSpec, SCENE_SCHEMA},
};

use super::reference::{Forces, Motion};

/// The entity of every such scene.
pub const GUID: u32 = 0x7000_0001;

/// Gravity, m/s².
const GRAVITY: f64 = -9.8;
/// Friction of the slider, and what one second leaves of its velocity.
const FRICTION: f32 = 0.2;
/// The state word of something that falls, and of something that does not.
const FALLS: u32 = 0x0000_0408;
const FLOATS: u32 = 0x0000_0008;

/// A scene and what really happens in it.
#[derive(Debug, Clone)]
pub struct Analytic {
    /// The scene, of area `analytic`.
    pub scene: Scene,
    /// Its world.
    pub source: Arc<DatSet>,
    /// Where the entity starts.
    pub start: Motion,
    /// What acts on it from then on.
    pub forces: Forces,
    /// Its error is an angle, not a distance.
    pub turns: bool,
}

/// All of them: free flight, constant friction, constant omega.
///
/// # Errors
/// When the generator cannot write its world.
pub fn all() -> Result<Vec<Analytic>, DatError> {
    let mut world = WorldBuilder::new();
    let shape = world.solid(&block(Vec3::new(-0.3, -0.3, 0.0), Vec3::new(0.3, 0.3, 0.6)));
    let ball = SetupBuilder::new()
        .part(shape, ac_client::dat::StoredFrame::IDENTITY)
        .sphere(Vec3::new(0.0, 0.0, 0.3), 0.3)
        .size(0.6, 0.3)
        .steps(0.2, 0.2);
    let setup = world.setup(ball);
    world.block(0x20, 0x20);
    let source = Arc::new(world.surround().build()?);
    let case = |name: &str, summary: &str, z: f32, state, velocity: [f32; 3], omega: [f32; 3]| {
        let origin = [60.0, 84.0, z];
        let entity = EntitySpec {
            position: position(origin),
            velocity,
            omega,
            friction: FRICTION,
            ..thing(setup, state)
        };
        Analytic {
            scene: scene(name, summary, entity),
            source: Arc::clone(&source),
            start: Motion {
                place: [
                    f64::from(origin[0]) + 32.0 * 192.0,
                    f64::from(origin[1]) + 32.0 * 192.0,
                    f64::from(z),
                ],
                velocity: velocity.map(f64::from),
                rotation: [1.0, 0.0, 0.0, 0.0],
            },
            forces: Forces {
                omega: omega.map(f64::from),
                ..Forces::NONE
            },
            turns: false,
        }
    };
    let mut flight = case(
        "analytic/free-flight",
        "Thrown over nothing: constant acceleration.",
        100.0,
        FALLS,
        // Never faster than the limit of 50 m/s, never slower than the rest rule.
        [6.0, 2.0, 40.0],
        [0.0; 3],
    );
    flight.forces.acceleration = [0.0, 0.0, GRAVITY];
    let mut slide = case(
        "analytic/friction",
        "Slides on level ground: constant friction.",
        0.0,
        FALLS,
        [8.0, 5.0, 0.0],
        [0.0; 3],
    );
    slide.forces.kept = Some(1.0 - f64::from(FRICTION));
    let mut spin = case(
        "analytic/omega",
        "Turns in mid-air: constant omega.",
        300.0,
        FLOATS,
        [1.0, 0.0, 0.0],
        [0.3, -0.2, 0.9],
    );
    spin.turns = true;
    Ok(vec![flight, slide, spin])
}

fn position(origin: [f32; 3]) -> PositionSpec {
    // Columns of 24 m, eight to a column of cells, numbered from 1.
    let cell = (origin[0] / 24.0) as u32 * 8 + (origin[1] / 24.0) as u32 + 1;
    PositionSpec {
        cell: 0x2020_0000 | cell,
        origin,
        rotation: [1.0, 0.0, 0.0, 0.0],
    }
}

/// An object without a motion table.
fn thing(setup: u32, state: u32) -> EntitySpec {
    EntitySpec {
        guid: GUID,
        kind: EntityKind::Object,
        setup,
        motion_table: 0,
        scale: 1.0,
        position: position([0.0; 3]),
        state,
        velocity: [0.0; 3],
        omega: [0.0; 3],
        elasticity: 0.05,
        friction: 0.95,
        run_rate: 1.0,
        jump_velocity: 0.0,
        parent: None,
    }
}

fn scene(name: &str, summary: &str, entity: EntitySpec) -> Scene {
    Scene {
        schema: SCENE_SCHEMA.into(),
        name: name.into(),
        summary: summary.into(),
        world: "generated".into(),
        features: Vec::new(),
        start_time: 1000.0,
        frames: vec![FrameRun {
            dt: 1.0 / 60.0,
            count: 540,
        }],
        entities: vec![entity],
        script: Vec::new(),
        track: vec![GUID],
    }
}
