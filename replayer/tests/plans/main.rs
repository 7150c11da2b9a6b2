//! Plans leave results alone: scenes and worlds drawn by chance give the same bits with everything done and with what the planner keeps.

mod worlds;

use std::sync::Arc;

use ac_client::dat::DatSet;
use ac_client::frame::plan::{Omission, Outputs, Part, PlanError};
use ac_client::frame::{FrameState, FrameStates, Plan};
use ac_client::profile::Profile;
use ac_golden_traces::{Scene, corpus, trace::TraceReader};
use ac_replayer::client::{ClientSimulator, PlanChoice, ScenePlan, SceneRun, planning};
use ac_replayer::{Simulation, SimulationError};
use proptest::prelude::*;

/// Starts a scene under a plan.
fn start(scene: &Scene, set: &Arc<DatSet>, profile: &Profile, choice: &PlanChoice) -> SceneRun {
    let index = Arc::new(planning::measure_index(set, profile).expect("the files are well formed"));
    let outline = planning::outline(scene, Outputs::default());
    let plan = choice
        .plan_for(&outline, set, &index, profile)
        .expect("it is no given plan");
    let plan = plan.map(|plan| ScenePlan {
        plan,
        index,
        outline,
    });
    SceneRun::planned(scene, Arc::clone(set), profile, plan).expect("the scene starts")
}

/// The records of all frames of the tracked entities.
fn run(run: &mut SceneRun) -> Vec<Vec<FrameState>> {
    let mut states = FrameStates::new();
    run.frame_minus_one(&mut states).expect("it runs");
    let mut frames = vec![states.to_vec()];
    for frame in 0..run.scene().frame_count() {
        states.clear();
        run.step(frame, &mut states).expect("it runs");
        frames.push(states.to_vec());
    }
    frames
}

fn first_difference(a: &[Vec<FrameState>], b: &[Vec<FrameState>]) -> Option<String> {
    a.iter()
        .flatten()
        .zip(b.iter().flatten())
        .find(|(a, b)| !a.same_bits(b))
        .map(|(a, b)| format!("{a:?}\n{b:?}"))
}

/// What an entity is like after the last frame, whoever asks for it.
fn last_state(run: &SceneRun, guid: u32) -> Option<FrameState> {
    let entity = run.world.entity(run.object(guid)?)?;
    let mut state = FrameState::default();
    entity.frame_state(0, 0.0, &mut state);
    Some(state)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn what_the_planner_leaves_out_changes_nothing(drawn in worlds::drawn(), profile in prop::sample::select(Profile::NAMES.to_vec())) {
        let (scene, set) = (drawn.scene(), drawn.land.build());
        let profile = Profile::named(profile).expect("a preset");
        let mut full = start(&scene, &set, &profile, &PlanChoice::Full);
        let mut auto = start(&scene, &set, &profile, &PlanChoice::Auto);
        let (expected, produced) = (run(&mut full), run(&mut auto));
        prop_assert_eq!(first_difference(&expected, &produced), None);
        // What nobody asked for is the same, too, once it is brought up to date.
        auto.settle();
        for spec in &scene.entities {
            let (Some(expected), Some(produced)) = (last_state(&full, spec.guid), last_state(&auto, spec.guid)) else {
                continue;
            };
            prop_assert!(expected.same_bits(&produced), "{expected:?}\n{produced:?}");
        }
        prop_assert_eq!(full.world.clock, auto.world.clock);
    }
}

fn bundled(name: &str) -> Scene {
    let path = corpus::bundled()
        .join("traces")
        .join(format!("{name}.mcap"));
    TraceReader::open(&path)
        .expect("a bundled trace")
        .scene()
        .clone()
}

fn omission(part: Part, ids: &[u32]) -> Omission {
    Omission {
        part,
        ids: ids.to_vec(),
        because: "somebody thought so".into(),
        source: String::new(),
    }
}

fn given(omissions: Vec<Omission>, forced: bool) -> ClientSimulator {
    let plan = Plan {
        left_out: omissions,
        ..Plan::full()
    };
    let plan = Arc::new(plan.checked().expect("nothing stands there twice"));
    ClientSimulator::new(corpus::bundled().join("worlds"))
        .with_plan(PlanChoice::Given { plan, forced })
}

/// Leaving out the ticks of the only one whose states are wanted is refused, and changes the states when it is forced.
#[test]
fn a_wrong_plan_is_refused_and_shows_when_it_is_forced() {
    let scene = bundled("clock/late-start");
    let profile = Profile::retail();
    let guid = scene.track[0];
    let idle = vec![omission(Part::IdleTicks, &[guid])];
    let error = given(idle.clone(), false)
        .run(&scene, &profile)
        .map(|_| ())
        .unwrap_err();
    let SimulationError::Plan { reason, .. } = &error else {
        panic!("{error}");
    };
    assert_eq!(
        *reason,
        PlanError::Id {
            part: Part::IdleTicks,
            id: guid
        }
    );
    let expected = format!(
        "scene `clock/late-start`: the plan cannot be used: left_out, `idle-ticks`: {guid:#010X} can change results"
    );
    assert_eq!(error.to_string(), expected);

    let mut on_demand = given(Vec::new(), false)
        .run(&scene, &profile)
        .expect("it starts");
    let mut forced = given(idle, true).run(&scene, &profile).expect("it starts");
    let (on_demand, forced) = (run(&mut on_demand), run(&mut forced));
    assert!(
        first_difference(&on_demand, &forced).is_some(),
        "the wrong plan was not seen"
    );
}

#[test]
fn a_part_of_the_planners_plan_can_be_given() {
    let scene = bundled("clock/late-start");
    let plan = vec![
        omission(Part::Streaming, &[]),
        omission(Part::StaticAnimations, &[]),
    ];
    let profile = Profile::retail();
    let mut run_given = given(plan, false).run(&scene, &profile).expect("it starts");
    let mut run_full = given(Vec::new(), false)
        .run(&scene, &profile)
        .expect("it starts");
    assert_eq!(
        first_difference(&run(&mut run_given), &run(&mut run_full)),
        None
    );
}

#[test]
fn a_plan_for_another_scene_is_refused() {
    let plan = Plan {
        scene: "terrain/walk-flat".into(),
        ..Plan::full()
    };
    let choice = PlanChoice::Given {
        plan: Arc::new(plan),
        forced: false,
    };
    let simulator = ClientSimulator::new(corpus::bundled().join("worlds")).with_plan(choice);
    let error = simulator
        .run(&bundled("clock/late-start"), &Profile::retail())
        .map(|_| ())
        .unwrap_err();
    assert!(
        error
            .to_string()
            .ends_with("it was made for scene `terrain/walk-flat`"),
        "{error}"
    );
}
