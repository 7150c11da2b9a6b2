//! Numbered differences that no trace shows, or whose other side no reconstruction runs: both sides of the switch at work.

use super::*;
use crate::entity::Child;
use crate::math::Frame;
use crate::physics::attachment::Attachment;
use crate::physics::body::ObjectRef;
use crate::physics::managers::TargetStatus;
use crate::physics::placement::{PlacementFlags, SetPosition};
use crate::physics::state::PhysicsState;
use crate::profile::{ChildRemoval, DestroyOrder, IndoorBlip, Remainder, SameObject};

fn retail(change: impl FnOnce(&mut Profile)) -> Profile {
    let mut profile = Profile::retail();
    change(&mut profile);
    profile
}

/// Two rooms of a block that do not see each other; neither has an opening.
fn sealed_rooms(profile: Profile) -> World {
    let mut world = WorldBuilder::new();
    let cube = world.solid(&block(Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 2.0)));
    world.setup(SetupBuilder::humanoid(cube, 1.8, 0.48));
    let room = Room::new(Vec3::new(-40.0, -40.0, 0.0), Vec3::new(40.0, 40.0, 3.0));
    let rooms = world.environment(&[room]);
    let home = world.block(0x10, 0x20);
    for z in [-50.0, -80.0] {
        home.room(rooms, 0, StoredFrame::at(Vec3::new(96.0, 96.0, z)), 0);
    }
    let dats = world.surround().build().expect("the world is well formed");
    World::with_source(profile, 100.0, Arc::new(dats))
}

/// Cell in which a walker ends that is placed in the lower room under the number of the upper one.
fn placed_in_the_wrong_room(profile: Profile) -> Option<u32> {
    let mut world = sealed_rooms(profile);
    let id = object(&mut world, WALKER, 0x0040_0408, None);
    let to = in_cell(0x1020_0100, 96.0, 96.0, -80.0);
    world.with_entity(id, |e, w| {
        e.set_position(&SetPosition::new(to, PlacementFlags::SLIDE), w)
    });
    let body = &world.entity(id)?.body;
    body.cell.map(|_| body.position.cell.0)
}

/// `C-25`: a wrong number indoors loses the object, or the whole block is searched.
#[test]
fn a_wrong_room_is_lost_or_searched_for() {
    assert_eq!(placed_in_the_wrong_room(Profile::retail()), None);
    let searching = retail(|p| p.search_block_for_cell = true);
    assert_eq!(placed_in_the_wrong_room(searching), Some(0x1020_0101));
}

/// `C-13`: a room without openings holds its points, or none.
#[test]
fn a_sealed_room_holds_somebody_or_nobody() {
    let place = in_cell(0x1020_0100, 96.0, 96.0, -50.0);
    for (contains, profile) in [(true, Profile::retail()), (false, Profile::gdle())] {
        let mut world = sealed_rooms(profile);
        let id = object(&mut world, WALKER, 0x0040_0408, None);
        world.with_entity(id, |e, w| e.enter_world_at(&place, true, w));
        let cell = world.entity(id).expect("there").body.cell;
        assert_eq!(cell.is_some(), contains);
    }
}

/// `O-42`: how far an indoor position may be to be followed, by who it is and by profile.
#[test]
fn indoor_positions_are_followed_or_jumped_to() {
    let follows = |rule: IndoorBlip, local: bool, player: bool, way: f32| {
        let mut world = sealed_rooms(retail(|p| p.indoor_blip = rule));
        let id = walker(&mut world, in_cell(0x1020_0100, 96.0, 96.0, -50.0));
        world.local_player = local.then_some(id);
        let to = in_cell(0x1020_0100, 96.0 + way, 96.0, -50.0);
        world.with_entity(id, |e, w| {
            e.body.weenie.player = player;
            e.interpolate_to(&to, false, w);
        });
        let manager = world.entity(id).and_then(|e| e.position_manager.as_ref());
        let interpolation = manager.and_then(|m| m.interpolation.as_ref());
        interpolation.is_some_and(|i| i.node_fail_counter == 0)
    };
    use IndoorBlip::{All20, LocalPlayer25, Players25};
    for (rule, local, player, far) in [
        (LocalPlayer25, true, true, true),
        (LocalPlayer25, false, true, false),
        (Players25, false, true, true),
        (Players25, false, false, false),
        (All20, true, true, false),
    ] {
        assert!(follows(rule, local, player, 19.9), "{rule:?}");
        assert_eq!(follows(rule, local, player, 24.9), far, "{rule:?}");
        assert!(!follows(rule, local, player, 25.1), "{rule:?}");
    }
}

/// `O-03`: what is left of a frame's time waits, or is lost.
#[test]
fn the_rest_of_the_time_is_kept_or_dropped() {
    for (remainder, waits) in [(Remainder::Kept, true), (Remainder::Dropped, false)] {
        let mut world = world_of(retail(|p| p.remainder = remainder));
        let id = walker(&mut world, at(30.0, 30.0, 0.0));
        world.with_entity(id, |e, w| e.make_movement_manager(true, w));
        frame(&mut world, 100.21);
        let clock = world.entity(id).expect("there").kin.update_time;
        assert_eq!(clock < 100.205, waits);
        // The rest of 0.01 s, or not, in the step after.
        world.entity_mut(id).expect("there").steps.clear();
        frame(&mut world, 100.26);
        let dt = world.entity(id).expect("there").steps[0].dt;
        assert!((dt - if waits { 0.06 } else { 0.05 }).abs() < 1e-6);
    }
}

/// `O-31`: a state word is stored, or only the lights follow it.
#[test]
fn a_state_word_is_stored_or_not() {
    for stored in [true, false] {
        let mut world = world_of(retail(|p| p.state_word_stored = stored));
        let id = object(&mut world, WALKER, 0x0040_0C08, None);
        world.with_entity(id, |e, w| e.set_state(0x0000_0044, w));
        let state = world.entity(id).expect("there").body.state;
        assert_eq!(state.contains(PhysicsState::MISSILE), stored);
        assert!(!state.contains(PhysicsState::LIGHTING_ON), "in both");
    }
}

/// `O-16`: whether frame or cell is set first in a commit makes no difference to the object itself.
#[test]
fn frame_and_cell_in_either_order_end_the_same() {
    let run = |first: bool| {
        let mut world = world_of(retail(|p| p.frame_before_cell = first));
        let id = walker(&mut world, at(47.0, 36.0, 0.0));
        let child = object(&mut world, WALKER, 0x408, None);
        let to = Attachment::Part {
            part: 0,
            frame: Frame::from_origin(Vec3::X),
        };
        world.with_entity(child, |e, w| e.set_parent(id, to, w));
        for n in 1..=8 {
            world.with_entity(id, |e, w| e.set_velocity(Vec3::new(6.0, 2.0, 0.0), w));
            frame(&mut world, 100.0 + f64::from(n) * 0.1);
        }
        let at = world.entity(id).expect("there").body.position;
        assert_ne!(at.cell, CellId(0x1020_000A), "it went on to another cell");
        (bits(&world, id), bits(&world, child))
    };
    assert_eq!(run(true), run(false));
}

/// `O-08`: a way of more than a block in one step, here by an animation, is tried, or ends the step: nothing of it is listed.
#[test]
fn a_way_of_more_than_a_block() {
    for (limited, steps) in [(false, 1), (true, 0)] {
        let profile = retail(|p| p.block_limit = limited);
        let (mut world, id) = small_moves::creeping(profile, 300.0);
        frame(&mut world, 100.05);
        assert_eq!(world.entity(id).expect("there").steps.len(), steps);
    }
}

/// `C-31`: objects are told apart by what they are, or by their GUID, and then one without a GUID passes through all scenery.
#[test]
fn an_object_without_guid_and_the_scenery() {
    for (same, stopped) in [(SameObject::Identity, true), (SameObject::Guid, false)] {
        let mut world = world_of(retail(|p| p.same_object = same));
        let id = world.make_object(WALKER, 0, true).expect("a setup");
        world.entities.register(id, 0);
        let start = at(60.0, 57.0, 0.0);
        world.with_entity(id, |e, w| {
            e.set_state(0x0040_0408, w);
            assert!(e.enter_world_at(&start, true, w));
        });
        for n in 1..=16 {
            world.with_entity(id, |e, w| e.set_velocity(Vec3::Y * 5.0, w));
            frame(&mut world, 100.0 + f64::from(n) * 0.1);
        }
        let y = world
            .entity(id)
            .expect("there")
            .body
            .position
            .frame
            .origin
            .y;
        assert_eq!(y < 58.6, stopped, "{y}");
    }
}

/// `O-30`: a child that its parent does not know of leaves the list alone, or takes the last one with it.
#[test]
fn detaching_a_child_that_is_not_in_the_list() {
    for (removal, left) in [(ChildRemoval::Exact, 1), (ChildRemoval::AbsentDropsLast, 0)] {
        let mut world = world_of(retail(|p| p.child_removal = removal));
        let parent = walker(&mut world, at(36.0, 36.0, 0.0));
        let [child, stranger] = [0, 1].map(|_| object(&mut world, WALKER, 0x408, None));
        let to = Attachment::Part {
            part: Child::NO_PART,
            frame: Frame::IDENTITY,
        };
        world.with_entity(child, |e, w| assert!(e.set_parent(parent, to, w)));
        world.with_entity(stranger, |e, w| {
            e.body.parent = Some(ObjectRef::Entity(parent));
            e.unset_parent(w);
        });
        assert_eq!(world.entity(parent).expect("there").children.len(), left);
    }
}

/// `O-37`: whoever sticks to a carried object sticks to what carries it; one reference takes the own carrier instead.
#[test]
fn sticking_to_a_carried_object() {
    for own in [false, true] {
        let mut world = world_of(retail(|p| p.stick_to_own_parent = own));
        let [carrier, own_carrier] = [30.0, 42.0].map(|x| walker(&mut world, at(x, 36.0, 0.0)));
        let [target, id] = [0, 1].map(|_| object(&mut world, WALKER, 0x408, None));
        let to = Attachment::Part {
            part: Child::NO_PART,
            frame: Frame::IDENTITY,
        };
        world.with_entity(target, |e, w| assert!(e.set_parent(carrier, to, w)));
        world.with_entity(id, |e, w| assert!(e.set_parent(own_carrier, to, w)));
        let guid = |world: &World, id: EntityId| world.entity(id).expect("there").guid();
        let asked = guid(&world, target);
        world.with_entity(id, |e, w| e.stick_to_object(asked, w));
        let manager = world.entity(id).and_then(|e| e.position_manager.as_ref());
        let expected = guid(&world, if own { own_carrier } else { carrier });
        assert_eq!(manager.map(|m| m.sticky_target()), Some(expected));
    }
}

/// `O-40`: a target that nobody has ever seen is given up after ten seconds, or waited for.
#[test]
fn a_target_that_was_never_seen() {
    for (gives_up, status) in [
        (true, TargetStatus::TimedOut),
        (false, TargetStatus::Undefined),
    ] {
        let mut world = world_of(retail(|p| p.unknown_target_times_out = gives_up));
        let id = walker(&mut world, at(36.0, 36.0, 0.0));
        world.with_entity(id, |e, w| {
            e.make_movement_manager(true, w);
            e.set_target(0, 0x7777_7777, 0.5, 0.0, w);
        });
        let seen = |world: &World| {
            let manager = world.entity(id)?.target_manager.as_ref()?;
            manager.target.map(|t| t.status)
        };
        for n in 1..=11 {
            assert_eq!(seen(&world), Some(TargetStatus::Undefined), "{n}");
            frame(&mut world, 100.0 + f64::from(n));
        }
        assert_eq!(seen(&world), Some(status));
    }
}

/// `O-44`: an object whose shape cannot be had is discarded, or kept without parts.
#[test]
fn an_object_without_a_shape() {
    for (kept, profile) in [(false, Profile::retail()), (true, Profile::ace())] {
        let mut world = world_of(profile);
        let made = world.make_object(0x0200_0099, 1, true);
        assert_eq!(made.is_ok(), kept);
        if let Ok(id) = made {
            let place = at(36.0, 36.0, 0.0);
            let entity = world.entity(id).expect("there");
            assert!(entity.body.part_array.is_none());
            world.entities.register(id, 1);
            world.with_entity(id, |e, w| e.enter_world_at(&place, true, w));
            frame(&mut world, 100.1);
        }
    }
}

/// `O-51`: in either order nothing of the object is left in the world.
#[test]
fn both_orders_of_destroying_leave_nothing() {
    for order in [DestroyOrder::LeaveThenExit, DestroyOrder::ExitThenLeave] {
        let mut world = world_of(retail(|p| p.destroy_order = order));
        let id = walker(&mut world, at(48.1, 48.1, 0.0));
        let watcher = walker(&mut world, at(40.0, 40.0, 0.0));
        let guid = world.entity(id).expect("there").guid();
        world.with_entity(watcher, |e, w| e.stick_to_object(guid, w));
        world.destroy_entity(id);
        let entity = world.entity(id).expect("it exists outside");
        assert!(entity.body.cell.is_none() && entity.body.shadows.is_empty());
        assert!(entity.kin.transient.is_empty());
        assert_eq!(world.entity_of_guid(guid), None);
        let manager = world
            .entity(watcher)
            .and_then(|e| e.position_manager.as_ref());
        assert_eq!(manager.map(|m| m.sticky_target()), Some(0), "{order:?}");
    }
}
