//! Plans leave results alone: scenes and worlds drawn by chance give the same bits with everything done and with what the planner keeps.

mod worlds;

use std::cell::Cell;
use std::sync::Arc;

use ac_client::dat::DatSet;
use ac_client::frame::plan::{Extended, Omission, Outputs, Part, PlanError, WorldIndex};
use ac_client::frame::{FrameState, FrameStates, Plan};
use ac_client::profile::Profile;
use ac_client::world::WorldSource;
use ac_golden_traces::{Scene, corpus, trace::TraceReader};
use ac_replayer::client::{ClientSimulator, PlanChoice, ScenePlan, SceneRun, planning};
use ac_replayer::{Simulation, SimulationError};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, TestRunner};
use worlds::Drawn;

/// Starts a scene under a plan.
fn start(
    scene: &Scene,
    set: &Arc<DatSet>,
    profile: &Profile,
    choice: &PlanChoice,
    index: WorldIndex,
) -> SceneRun {
    let index = Arc::new(index);
    let outline = planning::outline(scene, Outputs::default());
    let plan = choice.plan_for(&outline, set, &index, profile);
    let plan = plan.expect("it is no given plan").map(|plan| ScenePlan {
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

/// Runs a drawn scene with everything done, and with what the planner keeps; answers the first difference, and what had to be made up for.
fn compare(
    drawn: &Drawn,
    profile: &Profile,
    index: impl Fn(&Arc<DatSet>) -> WorldIndex,
) -> (Option<String>, Extended) {
    let (scene, set) = (drawn.scene(), drawn.land.build());
    let mut full = start(&scene, &set, profile, &PlanChoice::Full, index(&set));
    let mut auto = start(&scene, &set, profile, &PlanChoice::Auto, index(&set));
    let (expected, produced) = (run(&mut full), run(&mut auto));
    let mut difference = first_difference(&expected, &produced);
    let extended = auto.extended();
    // What nobody asked for is the same, too, once it is brought up to date.
    auto.settle();
    for spec in &scene.entities {
        let pair = (last_state(&full, spec.guid), last_state(&auto, spec.guid));
        if let (Some(expected), Some(produced)) = pair
            && !expected.same_bits(&produced)
        {
            difference.get_or_insert(format!("{expected:?}\n{produced:?}"));
        }
    }
    if full.world.clock != auto.world.clock {
        difference.get_or_insert(format!("{:?} {:?}", full.world.clock, auto.world.clock));
    }
    (difference, extended)
}

fn measured(set: &Arc<DatSet>, profile: &Profile) -> WorldIndex {
    planning::measure_index(set, profile).expect("the files are well formed")
}

fn profiles() -> impl Strategy<Value = &'static str> {
    prop::sample::select(Profile::NAMES.to_vec())
}

#[test]
fn what_the_planner_leaves_out_changes_nothing() {
    let (entities, awakenings, ticks) = (Cell::new(0), Cell::new(0), Cell::new(0));
    let mut runner = TestRunner::new(Config::default());
    let result = runner.run(&(worlds::drawn(), profiles()), |(drawn, profile)| {
        let profile = Profile::named(profile).expect("a preset");
        let (difference, extended) = compare(&drawn, &profile, |set| measured(set, &profile));
        prop_assert_eq!(difference, None);
        entities.set(entities.get() + extended.entities);
        awakenings.set(awakenings.get() + extended.awakenings);
        ticks.set(ticks.get() + extended.frames_put_off);
        Ok(())
    });
    result.unwrap_or_else(|failure| panic!("{failure}"));
    // All of it has been tried.
    let tried = [entities.get(), awakenings.get(), ticks.get()];
    assert!(tried.iter().all(|&count| count > 0), "{tried:?}");
}

/// The drawn worlds can tell: if what belongs together is not loaded together, results change.
#[test]
fn without_the_groups_of_the_world_a_difference_shows() {
    let profile = Profile::retail();
    let mut runner = TestRunner::deterministic();
    let strategy = worlds::drawn();
    let differs = |runner: &mut TestRunner| {
        let drawn = strategy
            .new_tree(runner)
            .expect("nothing is rejected")
            .current();
        let alone = |set: &Arc<DatSet>| {
            let source: Arc<dyn WorldSource> = Arc::clone(set) as _;
            WorldIndex::measure(&source, &profile, Vec::new())
        };
        compare(&drawn, &profile, alone).0.is_some()
    };
    assert!(
        (0..400).any(|_| differs(&mut runner)),
        "the worlds are too tame"
    );
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

/// Leaving out the ticks of those whose states are wanted is refused, and changes the states when it is forced.
#[test]
fn a_wrong_plan_is_refused_and_shows_when_it_is_forced() {
    let scene = bundled("lifecycle/many");
    let profile = Profile::retail();
    let guid = scene.track[0];
    let idle = vec![omission(Part::IdleTicks, &scene.track)];
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
        "scene `lifecycle/many`: the plan cannot be used: left_out, `idle-ticks`: {guid:#010X} can change results"
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
