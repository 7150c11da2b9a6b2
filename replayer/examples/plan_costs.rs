//! What plans save: time and bytes of the dat files, with everything done (`full`) and with what the planner keeps (`auto`).
//!
//! `cargo run --release -p ac-replayer --example plan_costs > target/plan-costs.jsonl` writes JSON lines `{class, plan, scenes, frames,
//! same, seconds, records, bytes, late_entities, ticks_left_out}`, and `{class, plan: "index", seconds, bytes}` for what is measured once
//! per world and kept in a file. Worlds are made under `target/plan-costs/`; every run opens its files anew.

use std::path::{Path, PathBuf};
use std::time::Instant;

use ac_client::dat::worldgen::{SetupBuilder, WorldBuilder, block};
use ac_client::dat::{MotionData, MotionTable, StoredFrame};
use ac_client::frame::{FrameState, FrameStates};
use ac_client::math::Vec3;
use ac_client::profile::Profile;
use ac_golden_traces::scene::{
    Action, EntityKind, EntitySpec, FrameRun, HoldKey, PositionSpec, ScriptStep,
};
use ac_golden_traces::{Scene, corpus, trace::TraceReader};
use ac_replayer::Simulation;
use ac_replayer::client::{ClientSimulator, PlanChoice, planning};

const STYLE: u32 = 0x8000_003D;
const READY: u32 = 0x4100_0003;
const WALK: u32 = 0x4500_0005;
/// Who moves.
const WALKER: u32 = 0x5000_0001;
/// Objects of a large world.
const OBJECTS: u32 = 10_000;
/// Kinds of static objects.
const MODELS: u32 = 200;
/// Runs of which the fastest counts.
const REPEATS: u32 = 3;

/// Static objects, all within the window of landblocks around the walker.
fn town(world: &mut WorldBuilder) {
    let models: Vec<u32> = (0..MODELS)
        .map(|n| {
            let height = 1.0 + n as f32 * 0.02;
            let shape = world.solid(&block(
                Vec3::new(-1.0, -1.0, 0.0),
                Vec3::new(1.0, 1.0, height),
            ));
            world.setup(SetupBuilder::of_shape(shape))
        })
        .collect();
    for n in 0..OBJECTS {
        let block = n % 121;
        let (x, y) = (95 + (block / 11) as u8, 95 + (block % 11) as u8);
        let place = n / 121;
        // Kinds differ from block to block, as towns do; nothing stands in the street that is walked.
        let model = models[((block * 7 + place % 9) % MODELS) as usize];
        let at = Vec3::new(
            12.0 + (place % 9) as f32 * 20.0,
            12.0 + (place / 9) as f32 * 18.0,
            0.0,
        );
        world.block(x, y).object(model, at, n as f32);
    }
}

/// Flat land for one object in each of a hundred by a hundred blocks.
fn plain(world: &mut WorldBuilder) {
    for x in 0..100 {
        for y in 0..100 {
            world.block(50 + x, 50 + y);
        }
    }
}

fn spec(number: u32, kind: EntityKind, position: PositionSpec) -> EntitySpec {
    let creature = kind != EntityKind::Object;
    EntitySpec {
        guid: WALKER + number,
        kind,
        setup: if creature { 0x0200_0001 } else { 0x0200_0002 },
        motion_table: if creature { 0x0900_0001 } else { 0 },
        scale: 1.0,
        position,
        state: if creature { 0x0040_0C08 } else { 0x8 },
        velocity: [0.0; 3],
        omega: [0.0; 3],
        elasticity: 0.05,
        friction: 0.95,
        run_rate: 1.5,
        jump_velocity: 0.0,
        parent: None,
    }
}

fn at(block: (u32, u32), x: f32, y: f32) -> PositionSpec {
    let low = (x / 24.0) as u32 * 8 + (y / 24.0) as u32 + 1;
    PositionSpec {
        cell: block.0 << 24 | block.1 << 16 | low,
        origin: [x, y, 0.0],
        rotation: [1.0, 0.0, 0.0, 0.0],
    }
}

/// A walker in the middle of the map, and one entity of a kind in every block of the plain.
fn scene(class: &str, others: Option<EntityKind>) -> Scene {
    let mut entities = vec![spec(0, EntityKind::Player, at((100, 100), 22.0, 60.0))];
    if let Some(kind) = others {
        let place = |n: u32| at((50 + n / 100, 50 + n % 100), 96.0, 96.0);
        entities.extend((0..OBJECTS).map(|n| spec(n + 1, kind, place(n))));
    }
    Scene {
        schema: "ac-scene/1".into(),
        name: format!("plans/{class}"),
        summary: String::new(),
        world: class.into(),
        features: Vec::new(),
        start_time: 1000.0,
        frames: vec![FrameRun {
            dt: 0.04,
            count: 500,
        }],
        entities,
        script: vec![ScriptStep {
            frame: 1,
            guid: WALKER,
            action: Action::DoMotion {
                command: WALK,
                speed: 1.0,
                hold_key: HoldKey::Run,
            },
        }],
        track: vec![WALKER],
    }
}

/// The kinds that every class has: 0x02000001 walks, 0x02000002 is a stone.
fn common() -> WorldBuilder {
    let mut world = WorldBuilder::new();
    let body = world.shape(
        &[],
        &block(Vec3::new(-0.3, -0.3, 0.0), Vec3::new(0.3, 0.3, 1.8)),
    );
    world.setup(SetupBuilder::humanoid(body, 1.8, 0.48));
    let stone = SetupBuilder::new()
        .part(body, StoredFrame::IDENTITY)
        .cyl_sphere(Vec3::ZERO, 0.5, 1.0);
    world.setup(stone.size(1.0, 0.5));
    let pose = |n: u32| {
        let origin = Vec3::Z * (n as f32 * 0.01);
        let parts = vec![StoredFrame::at(origin)];
        (
            ac_client::dat::AnimFrame {
                parts,
                hooks: Vec::new(),
            },
            None,
        )
    };
    let breath = world.animation(1, (0..12).map(pose));
    let stride = world.animation(1, (0..10).map(pose));
    let walking = MotionData::playing(stride, 0, -1, 30.0).with_velocity(Vec3::new(0.0, 3.0, 0.0));
    let table = MotionTable::new(0, STYLE)
        .with_style(STYLE, READY)
        .with_cycle(STYLE, READY, MotionData::playing(breath, 0, -1, 30.0))
        .with_cycle(STYLE, WALK, walking);
    world.motion_table(table);
    world
}

/// A run's costs.
struct Cost {
    seconds: f64,
    records: u64,
    bytes: u64,
    late: u64,
    ticks: u64,
    states: Vec<FrameState>,
}

/// Runs a scene to its end on newly opened files.
fn run(worlds: &Path, scene: &Scene, plan: &PlanChoice) -> Cost {
    let profile = Profile::retail();
    let mut best: Option<Cost> = None;
    for _ in 0..REPEATS {
        let start = Instant::now();
        let simulator = ClientSimulator::new(worlds).with_plan(plan.clone());
        let mut run = simulator.run(scene, &profile).expect("the scene starts");
        let mut states = FrameStates::new();
        let mut kept = Vec::new();
        run.frame_minus_one(&mut states).expect("it runs");
        for frame in 0..scene.frame_count() {
            states.clear();
            run.step(frame, &mut states).expect("it runs");
            kept.extend(states.iter().cloned());
        }
        let seconds = start.elapsed().as_secs_f64();
        let set = simulator.world(&scene.world).expect("it is open");
        let (portal, cell) = set.counts();
        let cost = Cost {
            seconds,
            records: portal.records + cell.records,
            bytes: portal.file_bytes + cell.file_bytes,
            late: run.extended().entities,
            ticks: run.extended().frames_put_off,
            states: kept,
        };
        best = Some(match best {
            Some(best) if best.seconds <= cost.seconds => best,
            _ => cost,
        });
    }
    best.expect("it ran at least once")
}

fn line(
    class: &str,
    plan: &str,
    scenes: usize,
    same: usize,
    frames: u64,
    costs: &[&Cost],
    extra: u64,
) {
    let sum = |of: fn(&Cost) -> u64| costs.iter().map(|cost| of(cost)).sum::<u64>();
    let line = serde_json::json!({
        "class": class,
        "plan": plan,
        "scenes": scenes,
        "same": same,
        "frames": frames,
        "seconds": costs.iter().map(|cost| cost.seconds).sum::<f64>(),
        "records": sum(|c| c.records),
        "bytes": sum(|c| c.bytes) + extra,
        "late_entities": sum(|c| c.late),
        "ticks_left_out": sum(|c| c.ticks),
    });
    println!("{line}");
}

/// Runs the scenes of a class with everything done and with what the planner keeps.
fn compare(class: &str, worlds: &Path, scenes: &[Scene]) {
    let full: Vec<Cost> = scenes
        .iter()
        .map(|scene| run(worlds, scene, &PlanChoice::Full))
        .collect();
    let auto: Vec<Cost> = scenes
        .iter()
        .map(|scene| run(worlds, scene, &PlanChoice::Auto))
        .collect();
    let equal = |(a, b): &(&Cost, &Cost)| {
        a.states.len() == b.states.len()
            && a.states.iter().zip(&b.states).all(|(a, b)| a.same_bits(b))
    };
    let same = full.iter().zip(&auto).filter(equal).count();
    let frames = scenes
        .iter()
        .map(|scene| u64::from(scene.frame_count()))
        .sum();
    let index = |scene: &Scene| {
        let file = worlds
            .join(&scene.world)
            .join(planning::index_file("retail"));
        std::fs::metadata(file).map_or(0, |about| about.len())
    };
    let index: u64 = scenes.iter().map(index).sum();
    line(
        class,
        "full",
        scenes.len(),
        same,
        frames,
        &full.iter().collect::<Vec<_>>(),
        0,
    );
    line(
        class,
        "auto",
        scenes.len(),
        same,
        frames,
        &auto.iter().collect::<Vec<_>>(),
        index,
    );
}

/// Measures the index of a world and stores it beside its files.
fn store_index(class: &str, worlds: &Path, world: &str) {
    let start = Instant::now();
    let simulator = ClientSimulator::new(worlds);
    let set = simulator.world(world).expect("just written");
    let mut index = planning::measure_index(&set, &Profile::retail()).expect("it is readable");
    let seconds = start.elapsed().as_secs_f64();
    let folder = worlds.join(world);
    index.profile = "retail".into();
    index.world = planning::identity(&folder).expect("the files are there");
    let text = index.to_json().expect("it is plain data");
    std::fs::write(folder.join(planning::index_file("retail")), text).expect("it can be written");
    let (portal, cell) = set.counts();
    let bytes = portal.file_bytes + cell.file_bytes;
    println!(
        "{}",
        serde_json::json!({"class": class, "plan": "index", "seconds": seconds, "bytes": bytes})
    );
}

fn large(class: &str, fill: fn(&mut WorldBuilder), others: Option<EntityKind>) {
    let worlds = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../target/plan-costs"));
    let folder = worlds.join(class);
    std::fs::create_dir_all(&folder).expect("target can be written");
    let mut world = common();
    fill(&mut world);
    world
        .surround()
        .save(&folder)
        .expect("the world can be written");
    store_index(class, &worlds, class);
    compare(class, &worlds, &[scene(class, others)]);
    let _ = std::fs::remove_dir_all(&folder);
}

/// The bundled scenes, area by area, on a copy of their worlds with stored indexes.
fn bundled() {
    let bundled = corpus::bundled();
    let worlds = PathBuf::from(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../target/plan-costs/bundled"
    ));
    for world in ["testbed", "testbed2"] {
        let folder = worlds.join(world);
        std::fs::create_dir_all(&folder).expect("target can be written");
        for file in ["client_portal.dat", "client_cell_1.dat"] {
            let from = bundled.join("worlds").join(world).join(file);
            std::fs::copy(from, folder.join(file)).expect("a bundled world");
        }
        store_index(world, &worlds, world);
    }
    let mut areas: std::collections::BTreeMap<String, Vec<Scene>> =
        std::collections::BTreeMap::new();
    for path in corpus::find(&bundled.join("traces"), &[corpus::TRACE_SUFFIX]).expect("the traces")
    {
        let scene = TraceReader::open(&path)
            .expect("a bundled trace")
            .scene()
            .clone();
        areas
            .entry(scene.area().to_owned())
            .or_default()
            .push(scene);
    }
    for (area, scenes) in areas {
        compare(&area, &worlds, &scenes);
    }
    let _ = std::fs::remove_dir_all(&worlds);
}

fn main() {
    large("10 000 static objects", town, None);
    large("10 000 entities that stay", plain, Some(EntityKind::Object));
    large("10 000 idle creatures", plain, Some(EntityKind::Creature));
    bundled();
}
