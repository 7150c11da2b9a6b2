use std::collections::VecDeque;

use serde_json::{Value, json};

use super::form::Forms;
use super::*;
use crate::animation::{TimedHook, TimedHookKind};
use crate::entity::{AttackReport, Child, CollisionRecord, CollisionReport, HouseAccess, Weenie};
use crate::frame::state::{FrameEvent, Outcome, Step};
use crate::math::{CellId, Frame, Position, Quat, Vec3};
use crate::motion::{
    Action, Command, DistanceSample, MotionInterp, MoveToManager, MoveToNode, MovementManager,
};
use crate::physics::body::EntityId;
use crate::physics::managers::{
    ConstraintManager, InterpolationManager, InterpolationNode, NodeKind, PositionManager,
    StickyManager, TargetInfo, TargetManager, TargetStatus, Voyeur,
};
use crate::world::{MemorySource, Random};

/// A not-a-number with a payload, negative and signalling.
const ODD_NAN: f32 = f32::from_bits(0xFF80_1234);

/// When this fails, a form has changed: raise [`VERSION`], so that keyframes of before are refused with a clear message, and accept the new
/// list of forms under the new version's name.
#[test]
fn the_forms_belong_to_the_version() {
    let mut forms = Forms::new();
    whole::describe(&mut forms);
    frames::describe(&mut forms);
    windows::describe(&mut forms);
    let text: String = forms
        .iter()
        .map(|(name, definition)| format!("{name}{definition}\n"))
        .collect();
    insta::assert_snapshot!(format!("forms_of_version_{VERSION}"), text);
}

fn position(x: f32) -> Position {
    let rotation = Quat::new(0.5, -0.0, ODD_NAN, 0.25);
    Position {
        cell: CellId(0xA9B4_0001),
        frame: Frame::new(Vec3::new(x, -0.0, f32::INFINITY), rotation),
    }
}

fn movement(now: f64) -> MovementManager {
    let mut interp = MotionInterp::default();
    interp.raw.actions.add(Action {
        command: Command::READY,
        speed: -0.0,
        stamp: 7,
        autonomous: true,
    });
    interp.pending = VecDeque::from([crate::motion::PendingMotion {
        context_id: 3,
        command: Command::WALK_FORWARD,
        forbids_jump: true,
    }]);
    let mut move_to = MoveToManager::new(now);
    move_to.nodes = VecDeque::from([MoveToNode::Turn(90.0), MoveToNode::Move]);
    move_to.previous = DistanceSample {
        distance: ODD_NAN,
        time: -1.5,
    };
    MovementManager {
        interp: Some(interp),
        move_to: Some(move_to),
    }
}

fn position_manager() -> PositionManager {
    PositionManager {
        interpolation: Some(InterpolationManager {
            queue: VecDeque::from([InterpolationNode {
                kind: NodeKind::Position,
                position: position(1.0),
                velocity: Vec3::NEG_ONE,
            }]),
            blip_to: Some(position(2.0)),
            ..InterpolationManager::default()
        }),
        sticky: Some(StickyManager {
            target_id: 9,
            timeout: 12.5,
            ..StickyManager::default()
        }),
        constraint: Some(ConstraintManager {
            constrained: true,
            max: 5.0,
            ..ConstraintManager::default()
        }),
    }
}

fn target_manager() -> TargetManager {
    TargetManager {
        target: Some(TargetInfo {
            status: TargetStatus::Teleported,
            target_position: position(3.0),
            ..TargetInfo::default()
        }),
        voyeurs: vec![Voyeur {
            object_id: 4,
            radius: 0.5,
            quantum: 1.0,
            last_sent_position: position(4.0),
        }],
        last_update: 8.0,
    }
}

/// A world without land in which one entity has something of everything, and another one is gone.
fn world() -> World {
    let mut world = World::new(Profile::ace(), 100.25);
    world.random = Random::Seeded(0x0123_4567_89AB_CDEF);
    let mut entity = world.entities.create(0x5000_0001, 100.25);
    let id = entity.id;
    entity.body.position = position(0.1);
    entity.body.scale = ODD_NAN;
    entity.kin.velocity = Vec3::new(-0.0, ODD_NAN, f32::MIN_POSITIVE / 4.0);
    entity.kin.update_time = f64::from_bits(0x7FF0_0000_0000_0001);
    entity.movement = Some(Box::new(movement(100.25)));
    entity.position_manager = Some(Box::new(position_manager()));
    entity.target_manager = Some(Box::new(target_manager()));
    entity.weenie = Some(Weenie {
        house: Some(HouseAccess {
            open: false,
            guests: vec![1, 2],
        }),
        run_rate: Some(1.5),
        ..Weenie::default()
    });
    entity.children.push(Child {
        object: EntityId(1),
        frame: Frame::IDENTITY,
        part: Child::NO_PART,
        location: -1,
    });
    entity.collision_table.push(CollisionRecord {
        guid: 5,
        touched: 99.0,
        ethereal: true,
    });
    entity.hooks.push(TimedHook {
        kind: TimedHookKind::PartLuminosity(2),
        created: 1.0,
        duration: 2.0,
        start: 0.0,
        end: 1.0,
    });
    entity.events.push(FrameEvent::MotionDone(0x4100_0003));
    entity.steps.push(Step {
        dt: 0.03,
        outcome: Outcome::Slid,
    });
    let attack = AttackReport {
        guid: 6,
        quadrant: 0x21,
        part: AttackReport::WHOLE,
    };
    entity.reports.push(CollisionReport::Attack(attack));
    entity.timestamps.0 = [1, 2, 3, 4, 5, 6, 7, 8, 65535];
    world.entities.put(entity);
    world.entities.register(id, 0x5000_0001);
    let gone = world.entities.create(0x5000_0002, 1.0).id;
    world.lost.insert(CellId(0xA9B4_0101), id);
    world.doomed.insert(gone, 50.0);
    world.local_player = Some(id);
    world.static_animations.push(id);
    world
}

fn source() -> Arc<MemorySource> {
    Arc::new(MemorySource::default())
}

fn bytes(world: &World) -> Vec<u8> {
    rmp_serde::to_vec_named(&WorldSnapshot::of(world).unwrap()).unwrap()
}

#[test]
fn everything_comes_back_with_its_bits() {
    let world = world();
    let stored = bytes(&world);
    let snapshot: WorldSnapshot = rmp_serde::from_slice(&stored).unwrap();
    let again = snapshot.restore(source(), Profile::ace()).unwrap();
    assert_eq!(bytes(&again), stored);
    let (a, b) = (world.entities.iter().next(), again.entities.iter().next());
    let (a, b) = (a.unwrap(), b.unwrap());
    assert_eq!(b.kin.velocity.y.to_bits(), ODD_NAN.to_bits());
    assert_eq!(b.kin.velocity.x.to_bits(), (-0.0_f32).to_bits());
    assert_eq!(b.kin.update_time.to_bits(), a.kin.update_time.to_bits());
    let rotation = b.body.position.frame.rotation();
    assert_eq!(rotation.y.to_bits(), ODD_NAN.to_bits());
    assert_eq!(again.random, world.random);
    // Nothing else than what is stored can be told apart.
    assert_eq!(format!("{a:?}"), format!("{b:?}"));
}

#[test]
fn a_pipeline_comes_back() {
    let pipeline = Pipeline {
        last_update: -0.0,
        ..Pipeline::new(crate::frame::Pacing::EngineGate)
    };
    let bytes = rmp_serde::to_vec_named(&PipelineSnapshot::of(&pipeline)).unwrap();
    let again: PipelineSnapshot = rmp_serde::from_slice(&bytes).unwrap();
    assert_eq!(format!("{:?}", again.restore()), format!("{pipeline:?}"));
}

#[test]
fn a_streaming_window_comes_back() {
    let mut streaming = Streaming::with_radius(2);
    let mut world = World::new(Profile::retail(), 0.0);
    streaming.follow(CellId(0x0102_0003), &mut world);
    let form = serde_json::to_value(StreamingSnapshot::of(&streaming)).unwrap();
    let snapshot: StreamingSnapshot = serde_json::from_value(form.clone()).unwrap();
    let again = snapshot.restore().unwrap();
    assert_eq!(format!("{again:?}"), format!("{streaming:?}"));
    let mut wide = form;
    wide["radius"] = json!(i32::MAX);
    let snapshot: StreamingSnapshot = serde_json::from_value(wide).unwrap();
    assert!(snapshot.restore().is_err());
}

/// What restoring says of a snapshot of which something was changed.
fn refused(change: impl FnOnce(&mut Value)) -> String {
    let mut value =
        serde_json::to_value(WorldSnapshot::of(&World::new(Profile::retail(), 0.0)).unwrap())
            .unwrap();
    change(&mut value);
    match serde_json::from_value::<WorldSnapshot>(value) {
        Err(error) => error.to_string(),
        Ok(snapshot) => snapshot
            .restore(source(), Profile::retail())
            .expect_err("it is refused")
            .to_string(),
    }
}

#[test]
fn contradictions_are_refused() {
    insta::assert_snapshot!(refused(|v| v["entities"]["table"] = json!([3])), @"the snapshot contradicts itself: there is no entity 3");
    insta::assert_snapshot!(refused(|v| v["entities"]["registered"] = json!([true])), @"the snapshot contradicts itself: the lists of entities differ in length");
    insta::assert_snapshot!(refused(|v| v["land"]["free_blocks"] = json!([0])), @"the snapshot contradicts itself: slot 0 of the blocks is not free");
    insta::assert_snapshot!(refused(|v| v["land"]["rooms"] = json!([{"block": 1, "rooms": [[257, 0]]}])), @"the snapshot contradicts itself: room 0x00010101 is in no slot");
    insta::assert_snapshot!(refused(|v| v["land"]["rooms"] = json!([{"block": 1, "rooms": [[9, 4294967295_u32], [8, 4294967295_u32]]}])), @"the snapshot contradicts itself: the rooms of a block are not in order");
    insta::assert_snapshot!(refused(|v| v["land"]["absent_blocks"] = json!([7, 7])), @"the snapshot contradicts itself: a block is loaded and absent");
}

#[test]
fn other_files_and_forms_are_refused() {
    let room = json!({"base": {"id": 0x0001_0101, "objects": [], "shadows": [], "restriction": 0}, "statics_made": true, "statics": []});
    insta::assert_snapshot!(refused(|v| v["land"]["env_cells"] = json!([room])), @"the dat files have no room 0x00010101, which the snapshot names: it was taken over other files");
    insta::assert_snapshot!(refused(|v| v["mood"] = json!("good")), @"unknown field `mood`, expected one of `clock`, `land`, `entities`, `slots`, `random`, `local_player`, `culling_enabled`, `static_animations`, `lost`, `doomed`, `touched_cells`, `loading_cells`");
    insta::assert_snapshot!(refused(|v| { v.as_object_mut().unwrap().remove("clock"); }), @"missing field `clock`");
    insta::assert_snapshot!(refused(|v| v["static_animations"] = json!(vec![0; MAX_ELEMENTS + 1])), @"the snapshot has more than 4194304 elements");
}
