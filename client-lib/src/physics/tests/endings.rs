//! Objects that end while something is being done to them or to others (H4: 18), and objects that overlap and become solid (H4: 17).

use super::*;
use crate::frame::Host;
use crate::physics::state::{PhysicsState, TransientState};

fn is_solid(world: &World, id: EntityId) -> bool {
    let state = world.entity(id).expect("there").body.state;
    !state.contains(PhysicsState::ETHEREAL)
}

fn tries(world: &World, id: EntityId) -> bool {
    let transient = world.entity(id).expect("there").kin.transient;
    transient.contains(TransientState::CHECK_ETHEREAL)
}

/// H4, 17: of two that overlap, the one that is passable cannot stop the other from becoming solid; then it tries in every step itself, until
/// there is room.
#[test]
fn of_two_that_overlap_one_waits_for_the_other() {
    let mut world = world();
    let [a, b] = [0, 1].map(|_| object(&mut world, WALKER, 0x0040_040C, Some(at(36.0, 36.0, 0.0))));
    for id in [a, b] {
        world.with_entity(id, |e, w| e.make_movement_manager(true, w));
    }
    assert_eq!(
        world.with_entity(a, |e, w| e.set_ethereal(false, w)),
        Some(true)
    );
    assert_eq!(
        world.with_entity(b, |e, w| e.set_ethereal(false, w)),
        Some(false)
    );
    for n in 1..=5 {
        frame(&mut world, 100.0 + f64::from(n) * 0.1);
        assert!(is_solid(&world, a) && !is_solid(&world, b) && tries(&world, b));
        assert_eq!(world.entity(b).expect("there").steps.len(), n as usize);
    }
    // Toggled once more while the other one waits: nobody is stuck.
    world.with_entity(a, |e, w| e.set_ethereal(true, w));
    assert!(!tries(&world, a));
    frame(&mut world, 100.6);
    assert!(is_solid(&world, b) && !tries(&world, b));
    assert_eq!(
        world.with_entity(a, |e, w| e.set_ethereal(false, w)),
        Some(false)
    );
    world.with_entity(b, |e, w| {
        e.set_position_simple(&at(30.0, 30.0, 0.0), true, w)
    });
    frame(&mut world, 100.7);
    assert!(is_solid(&world, a) && is_solid(&world, b));
}

/// H4, 18: an object that ends in the middle of its own work: it is out of the object table at once, and of cells and shadows when the work is
/// done. A second request changes nothing.
#[test]
fn an_object_ends_in_the_middle_of_its_work() {
    for delete in [false, true] {
        let mut world = world();
        let id = walker(&mut world, at(36.0, 36.0, 0.0));
        let guid = world.entity(id).expect("there").guid();
        let end = |world: &mut World| {
            if delete {
                world.delete_entity(id);
            } else {
                world.destroy_entity(id);
            }
        };
        world.with_entity(id, |e, w| {
            end(w);
            end(w);
            assert_eq!(w.entity_of_guid(guid), None);
            // Whatever it still does is done outside the object table.
            e.set_velocity(Vec3::X, w);
            e.update_object(w, &mut crate::frame::NoProbe);
        });
        assert!(world.entities.table().is_empty());
        assert_eq!(world.entity(id).is_none(), delete);
        if let Some(entity) = world.entity(id) {
            assert!(entity.body.cell.is_none() && entity.body.shadows.is_empty());
        }
        let cell = world.visible_cell(CellId(0x1020_000A)).expect("there");
        let base = world.land.cell(cell).expect("there").base();
        assert!(base.objects.is_empty() && base.shadows.is_empty());
        frame(&mut world, 100.5);
        end(&mut world);
        frame(&mut world, 101.0);
    }
}

/// H4, 18: the callback after the player's update ends others, and the player: who has been visited stays visited, who has not is skipped.
#[test]
fn objects_end_in_the_middle_of_a_tick() {
    struct Reaper(Vec<EntityId>);
    impl Host for Reaper {
        fn player_updated(&mut self, world: &mut World) {
            for id in self.0.drain(..) {
                world.delete_entity(id);
            }
        }
    }
    let mut world = world();
    let before = walker(&mut world, at(30.0, 30.0, 5.0));
    let player = walker(&mut world, at(36.0, 30.0, 5.0));
    let after = walker(&mut world, at(42.0, 30.0, 5.0));
    let last = walker(&mut world, at(46.0, 30.0, 5.0));
    world.local_player = Some(player);
    let mut reaper = Reaper(vec![before, after, player]);
    Pipeline::default().run_frame(&mut world, 100.1, &mut reaper);
    assert!(
        [before, player, after]
            .iter()
            .all(|&id| world.entity(id).is_none())
    );
    assert_eq!(world.entities.table(), [last]);
    assert_eq!(world.local_player, None);
    Pipeline::default().run_frame(&mut world, 100.2, &mut reaper);
    assert!(!world.entity(last).expect("there").steps.is_empty());
}

/// H4, 18: a target that ends while others watch it, in the tick: they hear of it and go on.
#[test]
fn a_watched_object_ends_between_the_updates_of_its_watchers() {
    struct Reaper(Option<EntityId>);
    impl Host for Reaper {
        fn player_updated(&mut self, world: &mut World) {
            if let Some(id) = self.0.take() {
                world.delete_entity(id);
            }
        }
    }
    let mut world = world();
    let player = walker(&mut world, at(30.0, 30.0, 0.0));
    let target = walker(&mut world, at(36.0, 30.0, 0.0));
    let watcher = walker(&mut world, at(40.0, 30.0, 0.0));
    world.local_player = Some(player);
    let guid = world.entity(target).expect("there").guid();
    for id in [player, watcher] {
        world.with_entity(id, |e, w| e.stick_to_object(guid, w));
    }
    let mut reaper = Reaper(Some(target));
    for n in 1..=4 {
        Pipeline::default().run_frame(&mut world, 100.0 + f64::from(n) * 0.1, &mut reaper);
    }
    for id in [player, watcher] {
        let manager = world.entity(id).and_then(|e| e.position_manager.as_ref());
        assert_eq!(manager.map(|m| m.sticky_target()), Some(0));
    }
}
