//! What a plan is made of, and that nothing is left out that matters.

use std::sync::Arc;

use super::*;
use crate::dat::worldgen::{SetupBuilder, WorldBuilder, block};
use crate::dat::{DatSet, StoredFrame};
use crate::math::{CellId, Position, Quat, Vec3};
use crate::physics::state::PhysicsState;
use crate::profile::Profile;
use crate::world::WorldSource;

const STONE: u32 = 0x0200_0001;

fn dats() -> Arc<DatSet> {
    let mut world = WorldBuilder::new();
    let body = world.shape(&[], &block(Vec3::splat(-0.5), Vec3::splat(0.5)));
    let stone = SetupBuilder::new()
        .part(body, StoredFrame::IDENTITY)
        .cyl_sphere(Vec3::ZERO, 0.5, 1.0)
        .size(1.0, 0.5);
    world.setup(stone);
    for x in 0..30 {
        world.block(40 + x, 50);
    }
    Arc::new(world.surround().build().expect("the world is well formed"))
}

fn entity(guid: u32, block: u32) -> EntityOutline {
    EntityOutline {
        guid,
        setup: STONE,
        motion_table: 0,
        position: Position::new(
            CellId(block << 24 | 50 << 16 | 0x1C),
            Vec3::new(80.0, 80.0, 0.0),
            Quat::IDENTITY,
        ),
        state: PhysicsState::empty(),
        velocity: Vec3::ZERO,
        omega: Vec3::ZERO,
        scale: 1.0,
        run_rate: 1.0,
        is_object: true,
        tracked: false,
        acts: false,
        carries: false,
        state_changes: false,
        duplicate: false,
    }
}

/// A tracked entity that falls, stones beside it, and one of each kind that must not wait.
fn scene() -> SceneOutline {
    let falls = EntityOutline {
        tracked: true,
        state: PhysicsState::GRAVITY,
        ..entity(1, 44)
    };
    let told = EntityOutline {
        acts: true,
        ..entity(3, 46)
    };
    let spins = EntityOutline {
        omega: Vec3::Z,
        ..entity(4, 47)
    };
    SceneOutline {
        name: "test/stones".into(),
        entities: vec![
            falls,
            entity(2, 45),
            told,
            spins,
            entity(5, 48),
            entity(6, 49),
        ],
        rate: 1.0,
        duration: 4.0,
        load_point: Some(1),
        ..SceneOutline::default()
    }
}

fn plan_of(scene: &SceneOutline, profile: &Profile) -> Plan {
    let source: Arc<dyn WorldSource> = dats();
    let index = WorldIndex::measure(&source, profile, Vec::new());
    Plan::auto(scene, source.as_ref(), &index, profile, true)
}

#[test]
fn those_who_cannot_move_and_are_not_asked_for_can_wait() {
    let plan = plan_of(&scene(), &Profile::retail());
    // 6 is the last of those that nobody names: its tick leaves the clock where it is.
    assert_eq!(plan.ids(Part::Entities), [2, 5]);
    assert_eq!(plan.ids(Part::IdleTicks), [2, 3, 4, 5, 6]);
    assert_eq!(plan.ids(Part::Poses), [1, 2, 3, 4, 5, 6]);
    assert!(plan.leaves_out(Part::Streaming));
}

/// T-25: where a placement leaves traces in the pool of transitions, every placement is made in its turn.
#[test]
fn nothing_waits_where_placements_are_remembered() {
    let plan = plan_of(&scene(), &Profile::gdle());
    assert!(plan.ids(Part::Entities).is_empty());
}

#[test]
fn wanted_checkpoints_keep_every_tick() {
    let mut scene = scene();
    scene.outputs.checkpoints = true;
    let plan = plan_of(&scene, &Profile::retail());
    for part in [Part::Entities, Part::IdleTicks, Part::Poses] {
        assert!(!plan.leaves_out(part), "{}", part.name());
    }
}

/// 50 m/s for four seconds from x = 80 m of block 44: blocks 43 to 45 and what lies a little beyond; 39 to 49 are in the window.
#[test]
fn landblocks_beyond_the_fastest_travel_are_listed() {
    let mut scene = scene();
    scene.entities.truncate(1);
    let plan = plan_of(&scene, &Profile::retail());
    let columns: std::collections::BTreeSet<u32> = plan
        .ids(Part::Landblocks)
        .iter()
        .map(|id| id >> 24)
        .collect();
    let expected = [39, 40, 41, 42, 46, 47, 48, 49];
    assert_eq!(columns.into_iter().collect::<Vec<_>>(), expected);
}

#[test]
fn a_plan_survives_writing_and_refuses_what_is_wrong() {
    let plan = plan_of(&scene(), &Profile::retail());
    let text = serde_json::to_string(&plan).expect("it is plain data");
    assert_eq!(
        serde_json::from_str::<Plan>(&text).expect("just written"),
        plan
    );
    assert_eq!(plan.check_against(&plan), Ok(()));

    let mut wrong = plan.clone();
    wrong.left_out.retain(|o| o.part == Part::Entities);
    wrong.left_out[0].ids.push(3);
    let error = wrong.check_against(&plan).unwrap_err();
    assert_eq!(
        error.to_string(),
        "left_out, `entities`: 0x00000003 can change results"
    );
    wrong.left_out.push(wrong.left_out[0].clone());
    assert_eq!(
        wrong.clone().checked(),
        Err(PlanError::Twice(Part::Entities))
    );
    wrong.schema = "ac-plan/9".into();
    assert_eq!(wrong.checked(), Err(PlanError::Schema("ac-plan/9".into())));
}
