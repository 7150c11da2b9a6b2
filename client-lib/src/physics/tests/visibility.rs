//! Objects that lose their cell and find it again, and those that are out of sight for too long (03 8.17 to 8.19; 06 G3, G7).

use super::*;
use crate::frame::Host;
use crate::physics::attachment::Attachment;
use crate::physics::fuzzing::check_membership;
use crate::physics::placement::{PlacementFlags, SetPosition};
use crate::physics::state::TransientState;
use crate::world::Streaming;

/// Middle of the nine blocks, and its eastern neighbour: from there the western column is out of reach.
const HOME: CellId = CellId(0x1020_0013);
const EAST: CellId = CellId(0x1120_0013);
/// In the western column.
const WEST: u32 = 0x0F20_0001;

/// A world of which only what streaming brings is there, centred on the middle.
fn streamed() -> (World, Streaming) {
    let mut world = world();
    world.land.set_window_only(true);
    let mut streaming = Streaming::with_radius(1);
    streaming.follow(HOME, &mut world);
    assert_eq!(world.land.blocks().count(), 9);
    (world, streaming)
}

fn is_active(world: &World, id: EntityId) -> bool {
    let entity = world.entity(id).expect("there");
    entity.kin.transient.contains(TransientState::ACTIVE)
}

/// Whether an object waits for its cell: no cell, no shadows, not active, its place kept.
fn waits(world: &World, id: EntityId) -> bool {
    let body = &world.entity(id).expect("there").body;
    let out = body.cell.is_none() && body.shadows.is_empty() && !is_active(world, id);
    out && world.lost.contains(id)
}

#[test]
fn an_object_waits_for_its_cell_and_comes_back() {
    let (mut world, mut streaming) = streamed();
    let id = walker(&mut world, in_cell(WEST, 10.0, 10.0, 0.0));
    frame(&mut world, 100.05);
    let before = world.entity(id).expect("there").body.clone();
    assert!(world.entity(id).expect("there").is_completely_visible());
    streaming.follow(EAST, &mut world);
    assert!(waits(&world, id));
    let place = world.entity(id).expect("there").body.position;
    assert_eq!(place, before.position);
    frame(&mut world, 110.0);
    assert!(waits(&world, id), "its cell is not there");
    streaming.follow(HOME, &mut world);
    let body = &world.entity(id).expect("there").body;
    assert_eq!(
        (body.position, body.cell.is_some()),
        (before.position, true)
    );
    let cells =
        |body: &crate::physics::body::Body| body.shadows.iter().map(|s| s.id).collect::<Vec<_>>();
    assert_eq!(cells(body), cells(&before));
    assert!(!world.lost.contains(id));
    check_membership(&world, id);
    // It stands where it stood, and time goes on from its return.
    frame(&mut world, 110.1);
    assert_eq!(
        world.entity(id).expect("there").body.position,
        before.position
    );
    frame(&mut world, 200.0);
    assert!(world.entity(id).is_some(), "no longer due for deletion");
}

/// G7: an object that comes back begins anew.
#[test]
fn a_return_sets_the_time_back() {
    let (mut world, mut streaming) = streamed();
    let id = walker(&mut world, in_cell(WEST, 10.0, 10.0, 0.0));
    streaming.follow(EAST, &mut world);
    frame(&mut world, 120.0);
    streaming.follow(HOME, &mut world);
    streaming.follow(EAST, &mut world);
    frame(&mut world, 144.9);
    assert!(waits(&world, id));
    frame(&mut world, 145.0);
    assert!(world.entity(id).is_none());
}

/// G7: 25 s out of sight, then the client deletes the object without a message; a child goes with its carrier.
#[test]
fn what_is_out_of_sight_for_long_is_deleted() {
    let (mut world, mut streaming) = streamed();
    let id = walker(&mut world, in_cell(WEST, 10.0, 10.0, 0.0));
    let child = object(&mut world, WALKER, 0x408, None);
    world.with_entity(child, |e, w| {
        let to = Attachment::Part {
            part: crate::entity::Child::NO_PART,
            frame: crate::math::Frame::IDENTITY,
        };
        assert!(e.set_parent(id, to, w));
    });
    let near = walker(&mut world, at(40.0, 40.0, 0.0));
    frame(&mut world, 101.0);
    streaming.follow(EAST, &mut world);
    // Lost once more, it keeps its time.
    frame(&mut world, 110.0);
    world.with_entity(id, |e, w| e.leave_visibility(w));
    frame(&mut world, 125.9);
    assert!([id, child].iter().all(|&e| world.entity(e).is_some()));
    frame(&mut world, 126.0);
    assert!([id, child].iter().all(|&e| world.entity(e).is_none()));
    assert!(!world.entities.is_registered(id) && !world.lost.contains(id));
    assert!(world.entity(near).is_some());
}

/// A host whose objects end otherwise keeps them.
#[test]
fn a_host_may_keep_what_is_out_of_sight() {
    struct Keeper(Vec<EntityId>);
    impl Host for Keeper {
        fn out_of_sight(&mut self, id: EntityId, _: &mut World) {
            self.0.push(id);
        }
    }
    let (mut world, mut streaming) = streamed();
    let id = walker(&mut world, in_cell(WEST, 10.0, 10.0, 0.0));
    // The player is never due.
    let player = walker(&mut world, in_cell(WEST, 14.0, 10.0, 0.0));
    world.local_player = Some(player);
    streaming.follow(EAST, &mut world);
    let mut keeper = Keeper(Vec::new());
    for now in [120.0, 125.0, 130.0] {
        Pipeline::default().run_frame(&mut world, now, &mut keeper);
    }
    assert_eq!(keeper.0, [id]);
    assert!(waits(&world, id) && waits(&world, player));
    streaming.follow(HOME, &mut world);
    assert!(world.entity(id).expect("there").body.cell.is_some());
}

/// A teleport to where nothing is loaded: the player is lost, streaming follows, and the player is back in the same frame.
#[test]
fn streaming_follows_a_player_who_was_teleported() {
    struct Client(Streaming);
    impl Host for Client {
        fn streaming(&mut self, world: &mut World) {
            self.0.follow_player(world);
        }
    }
    let mut world = world();
    world.land.set_window_only(true);
    let mut client = Client(Streaming::with_radius(1));
    client.0.follow(CellId(0x0F1F_0001), &mut world);
    let id = walker(&mut world, in_cell(0x0F1F_0001, 10.0, 10.0, 0.0));
    world.local_player = Some(id);
    let goal = in_cell(0x1121_0001, 12.0, 12.0, 0.0);
    world.with_entity(id, |e, w| {
        e.set_position(&SetPosition::new(goal, PlacementFlags::TELEPORT), w)
    });
    assert!(waits(&world, id));
    Pipeline::default().run_frame(&mut world, 100.05, &mut client);
    let entity = world.entity(id).expect("there");
    assert_eq!(entity.body.position, goal);
    assert!(entity.body.cell.is_some() && is_active(&world, id));
    assert_eq!(client.0.window().load_point(), goal.cell);
    assert!(world.land.block(CellId(0x0F1F_0001)).is_none());
    check_membership(&world, id);
}

/// With everything loaded on demand nobody is lost for lack of a cell that exists, and one without any stays lost.
#[test]
fn on_demand_only_what_has_no_cell_is_lost() {
    let mut world = world();
    let id = walker(&mut world, at(30.0, 30.0, 0.0));
    let nowhere = in_cell(0x1020_0180, 30.0, 30.0, 0.0);
    let go = |world: &mut World, to| {
        let to = SetPosition::new(to, PlacementFlags::SLIDE);
        world.with_entity(id, |e, w| e.set_position(&to, w))
    };
    go(&mut world, nowhere);
    for n in 1..10 {
        frame(&mut world, 100.0 + f64::from(n));
        assert!(waits(&world, id));
    }
    // Loading other cells does not bring it back.
    assert!(world.visible_cell(CellId(0x1020_0100)).is_some());
    frame(&mut world, 110.0);
    assert!(waits(&world, id));
    go(&mut world, in_cell(WEST, 10.0, 10.0, 0.0));
    assert!(!world.lost.contains(id));
    // A block that is unloaded comes back when somebody needs it, and its objects with it.
    world.unload_block(CellId(WEST));
    assert!(waits(&world, id));
    world.visible_cell(CellId(WEST));
    frame(&mut world, 110.1);
    assert!(!waits(&world, id) && is_active(&world, id));
    check_membership(&world, id);
}

/// A block that comes back because another one's static object reaches into it: shadows that were thrown there are back, too.
#[test]
fn shadows_are_linked_again_whoever_needs_the_block() {
    let mut world = WorldBuilder::new();
    let cube = world.solid(&block(Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 2.0)));
    world.setup(SetupBuilder::humanoid(cube, 1.8, 0.48));
    // At the eastern border, so that it reaches into the next block.
    world
        .block(0x11, 0x20)
        .object(cube, Vec3::new(191.5, 36.0, 0.0), 0.0);
    world.block(0x13, 0x20);
    let dats = world.surround().build().expect("the world is well formed");
    let mut world = World::with_source(Profile::retail(), 100.0, Arc::new(dats));
    let id = walker(&mut world, in_cell(0x1320_0002, 0.2, 36.0, 0.0));
    let linked = |world: &World| {
        let shadows = &world.entity(id).expect("there").body.shadows;
        shadows
            .iter()
            .map(|s| (s.id.block(), s.cell.is_some()))
            .collect::<Vec<_>>()
    };
    assert_eq!(linked(&world), [(0x1320, true), (0x1220, true)]);
    for gone in [0x1220_0001, 0x1120_0001] {
        world.unload_block(CellId(gone));
    }
    assert_eq!(linked(&world), [(0x1320, true), (0x1220, false)]);
    world.visible_cell(CellId(0x1120_0001));
    assert!(
        world.land.block(CellId(0x1220_0001)).is_some(),
        "the crate reaches it"
    );
    assert_eq!(linked(&world), [(0x1320, true), (0x1220, true)]);
    check_membership(&world, id);
}

/// 8.19: an indoor cell that goes takes its objects out of sight; they come back with it.
#[test]
fn rooms_come_and_go_with_what_sees_them() {
    let room = in_cell(0x1020_0100, 96.0, 96.0, -50.0);
    let (mut world, mut streaming) = streamed();
    assert_eq!(
        streaming.visible_rooms().count(),
        0,
        "no building shows a room"
    );
    streaming.follow(room.cell, &mut world);
    let rooms: Vec<u32> = streaming.visible_rooms().map(|c| c.0).collect();
    assert_eq!(
        rooms,
        [0x1020_0100, 0x1020_0101],
        "the room and what it sees"
    );
    let id = walker(&mut world, room);
    frame(&mut world, 100.05);
    assert!(world.entity(id).expect("there").body.cell.is_some());
    streaming.follow(HOME, &mut world);
    assert!(waits(&world, id));
    assert!(world.land.loaded(room.cell).is_none());
    streaming.follow(room.cell, &mut world);
    assert_eq!(
        world.entity(id).expect("there").body.position.cell,
        room.cell
    );
    check_membership(&world, id);
    // A room that does not exist, and no place at all.
    streaming.follow(CellId(0x1020_0180), &mut world);
    streaming.follow(CellId::NONE, &mut world);
    assert_eq!(world.land.blocks().count(), 0);
    assert!(waits(&world, id));
}
