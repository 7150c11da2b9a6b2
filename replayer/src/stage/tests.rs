//! Recorded stages of the profile `gdle-repaired`.

use std::path::Path;
use std::sync::Arc;

use ac_client::dat::{DatSet, Strictness};
use ac_client::profile::Profile;
use ac_client::world::World;
use serde_json::{Value, json};

use super::{StageError, run_adjust_stage, run_animation_stage};

const GUID: u32 = 0x5000_0001;

fn testbed() -> World {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../golden-traces/worlds/testbed");
    let dats = DatSet::open(folder, Strictness::Strict).expect("the world is in the repository");
    World::with_source(Profile::gdle_repaired(), 0.0, Arc::new(dats))
}

/// The end of a link: the cycle's first frame moves the object, and an animation is done.
fn link_ends() -> (Value, Value) {
    let identity = json!([1.0, 0.0, 0.0, 0.0]);
    let cycle = json!({"anim": "0x3000002", "low": 0, "high": 19, "framerate": 30.0});
    let velocity = json!([0.0, 3.119_999_885_559_082, 0.0]);
    let input = json!({
        "quantum": 0.039_999_999_105_930_33, "scale": 1.0, "transient": "0x83",
        "sequence": [{"anim": "0x3000007", "low": 0, "high": 4, "framerate": 30.0}, cycle],
        "current": 0, "first_cyclic": 1, "frame_number": 4.799_999_892_711_639,
        "velocity": velocity, "omega": [0.0, 0.0, 0.0],
    });
    let output = json!({
        "offset": {"origin": [0.0, 0.104_000_002_145_767_21, 0.0], "rotation": identity},
        "sequence": [cycle], "current": 0, "first_cyclic": 0, "frame_number": 0.999_999_865_889_549_4,
        "velocity": velocity, "omega": [0.0, 0.0, 0.0], "hooks": [4],
    });
    (input, output)
}

#[test]
fn animation_answers_what_was_recorded() {
    let (mut input, output) = link_ends();
    let mut world = testbed();
    assert_eq!(run_animation_stage(&mut world, &input).unwrap(), output);
    input["sequence"][1]["anim"] = json!("0x3FFFFFF");
    assert!(matches!(
        run_animation_stage(&mut world, &input),
        Err(StageError::NoSuchAnimation {
            animation: 0x03FF_FFFF,
            ..
        })
    ));
    input["quantum"] = json!("soon");
    assert!(matches!(
        run_animation_stage(&mut world, &input),
        Err(StageError::Malformed { .. })
    ));
}

#[test]
fn adjust_answers_what_was_recorded() {
    let mut world = testbed();
    let identity = json!([1.0, 0.0, 0.0, 0.0]);
    let place = |x: f64, y: f64| json!({"cell": "0xA9B40012", "origin": [x, y, 20.0], "rotation": identity});
    let interpolation = |counter: u32, progress: f64| {
        json!({
            "queue": [place(60.200_000_762_939_45, 25.0)], "keep_heading": false, "frame_counter": counter,
            "original_distance": 999_999.0, "progress_quantum": progress, "fails": 0, "blip": null,
        })
    };
    let quantum = 0.039_999_999_105_930_33;
    let input = json!({
        "quantum": quantum, "transient": "0x83", "speed_rate": 6.0,
        "offset": {"origin": [0.0, 0.208_000_004_291_534_42, 0.0], "rotation": identity},
        "position": place(60.0, 24.719_997_406_005_86),
        "interpolation": interpolation(0, 0.0), "sticky": null, "constraint": null, "target_now": null,
    });
    let unknown = run_adjust_stage(&mut world, GUID, &input);
    assert!(matches!(
        unknown,
        Err(StageError::NoSuchEntity { guid: GUID, .. })
    ));
    let entity = world.entities.create(GUID, 0.0);
    world.entities.register(entity.id, GUID);
    world.entities.put(entity);
    let output = run_adjust_stage(&mut world, GUID, &input).unwrap();
    assert_eq!(
        output,
        json!({
            "offset": {"origin": [0.200_000_762_939_453_12, 0.280_002_593_994_140_6, 0.0], "rotation": identity},
            "acted": ["interpolation"],
            "interpolation": interpolation(1, quantum), "sticky": null, "constraint": null,
        })
    );
}
