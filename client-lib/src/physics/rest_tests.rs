//! Objects at rest: that they are not looked at changes nothing (`spec/06-physics-object.md`, B3).

use proptest::prelude::*;

use crate::frame::{NoHost, NoProbe, Pipeline};
use crate::physics::body::EntityId;
use crate::profile::Profile;
use crate::world::{CellHandle, World};

const START: f64 = 1000.0;

fn world_with_object(profile: Profile) -> (World, EntityId) {
    let mut world = World::new(profile, START);
    let mut entity = world.entities.create(1, START);
    let id = entity.id;
    entity.body.cell = Some(CellHandle(0));
    world.entities.put(entity);
    world.entities.register(id, 1);
    (world, id)
}

fn run_frame(world: &mut World, seconds: f64) {
    let now = world.clock.now + seconds;
    Pipeline::default().run_frame_probed(world, now, &mut NoHost, &mut NoProbe);
}

/// Both clocks of the world and that of the object.
fn clocks(world: &mut World, id: EntityId) -> [u64; 3] {
    let clock = world.clock;
    let own = world.entity_mut(id).map_or(f64::NAN, |e| e.kin.update_time);
    [clock.now, clock.sim_time, own].map(f64::to_bits)
}

proptest! {
    #[test]
    fn clocks_pass_as_if_updated(
        frames in prop::collection::vec(
            prop_oneof![0.0..0.05f64, 0.0..0.5f64, 0.0..3.0f64, Just(0.0), Just(1.0 / 30.0), Just(0.2), Just(1e-4)],
            1..30,
        ),
        profile in prop_oneof![
            Just(Profile::retail()), Just(Profile::ace()), Just(Profile::gdle()),
        ],
    ) {
        let (mut at_rest, id) = world_with_object(profile.clone());
        let (mut touched, same) = world_with_object(profile);
        for seconds in frames {
            run_frame(&mut at_rest, seconds);
            // Whoever may change the object ends its rest: it is updated in full.
            touched.entity_mut(same);
            run_frame(&mut touched, seconds);
            prop_assert_eq!(at_rest.clock.sim_time.to_bits(), touched.clock.sim_time.to_bits());
        }
        prop_assert_eq!(clocks(&mut at_rest, id), clocks(&mut touched, same));
    }
}

#[test]
fn whoever_changes_an_object_ends_its_rest() {
    let (mut world, id) = world_with_object(Profile::retail());
    run_frame(&mut world, 0.04);
    assert!(world.entities.resting_since(id).is_some());
    let entity = world.entity_mut(id).map(|e| e.kin.update_time);
    assert_eq!(entity, Some(world.clock.now));
    assert!(world.entities.resting_since(id).is_none());
    run_frame(&mut world, 0.04);
    assert!(world.with_entity(id, |_, _| ()).is_some());
    assert!(world.entities.resting_since(id).is_none());
}
