//! Cell lists, loading, shadows.

use proptest::prelude::*;

use super::*;
use crate::dat::worldgen::{WorldBuilder, block, shape};
use crate::dat::{DegradeInfo, DegradeLevel, GfxObjFlags};
use crate::math::{LandCoord, block_offset};
use crate::physics::body::{EntityId, ObjectRef};
use crate::profile::{
    BuildingPortals, DoNotLoad, EnvCellStatics, ListRemoval, MissingCells, PartBoxes,
};
use crate::world::{CellRef, MemorySource, PortalTarget, StaticKind};

const HOUSE: u32 = 0xA9B4_0100;

#[test]
fn one_two_or_four_outdoor_cells() {
    let mut world = testbed(Profile::retail());
    let place = at(0xA9B4_0012, 60.0, 36.0, 20.0);
    let one = list(&mut world, &place, &[sphere(60.0, 36.0, 20.5, 0.5)]);
    assert_eq!(one, (vec![0xA9B4_0012], 0xA9B4_0012));
    let edge = list(&mut world, &place, &[sphere(71.8, 36.0, 20.5, 0.5)]);
    assert_eq!(edge, (vec![0xA9B4_0012, 0xA9B4_001A], 0xA9B4_0012));
    let corner = list(&mut world, &place, &[sphere(71.8, 24.2, 20.5, 0.5)]);
    let expected = vec![0xA9B4_0012, 0xA9B4_001A, 0xA9B4_0019, 0xA9B4_0011];
    assert_eq!(corner, (expected, 0xA9B4_0012));
}

#[test]
fn on_a_border_the_last_cell_in_the_list_is_current() {
    let mut world = testbed(Profile::retail());
    let place = at(0xA9B4_0012, 60.0, 24.0, 20.0);
    let (cells, current) = list(&mut world, &place, &[sphere(60.0, 24.0, 20.5, 0.5)]);
    assert_eq!(cells, [0xA9B4_0012, 0xA9B4_0011]);
    assert_eq!(current, 0xA9B4_0011);
}

#[test]
fn a_block_corner_touches_four_blocks() {
    let mut world = testbed(Profile::retail());
    let place = at(0xA9B4_0001, 0.25, 0.25, 20.0);
    let (cells, current) = list(&mut world, &place, &[sphere(0.25, 0.25, 20.5, 0.5)]);
    assert_eq!(cells, [0xA9B4_0001, 0xA8B4_0039, 0xA8B3_0040, 0xA9B3_0008]);
    assert_eq!(current, 0xA9B4_0001);
}

#[test]
fn radius_equal_to_the_distance_adds_nothing() {
    let mut world = testbed(Profile::retail());
    let place = at(0xA9B4_0012, 60.0, 36.0, 20.0);
    let (cells, _) = list(&mut world, &place, &[sphere(71.5, 36.0, 20.5, 0.5)]);
    assert_eq!(cells.len(), 1);
}

#[test]
fn off_the_map_nothing_is_added_and_missing_blocks_are_entered_without_a_cell() {
    let mut world = testbed(Profile::retail());
    let corner = at(0x0000_0001, 0.1, 0.1, 10.0);
    let (cells, _) = list(&mut world, &corner, &[sphere(0.1, 0.1, 10.0, 0.5)]);
    assert_eq!(cells, [0x0000_0001]);

    let last = at(0x0202_0001, 0.1, 0.1, 10.0);
    let (cells, _) = list(&mut world, &last, &[sphere(191.9, 100.0, 10.0, 0.5)]);
    assert_eq!(
        cells,
        [0x0202_003D, 0x0302_0005],
        "block 0x0302 has no record"
    );

    let mut world = testbed(Profile::ace());
    let (cells, _) = list(&mut world, &last, &[sphere(191.9, 100.0, 10.0, 0.5)]);
    assert_eq!(cells, [0x0202_003D], "C-06");
}

#[test]
fn a_second_sphere_off_the_map_ends_the_list() {
    let mut world = testbed(Profile::retail());
    let corner = at(0x0000_0001, 1.0, 1.0, 10.0);
    let spheres = [
        sphere(1.0, 1.0, 10.0, 0.5),
        sphere(-1.0, 1.0, 10.0, 0.5),
        sphere(30.0, 1.0, 10.0, 0.5),
    ];
    assert_eq!(list(&mut world, &corner, &spheres).0, [0x0000_0001]);
}

#[test]
fn no_cell_and_no_spheres() {
    let mut world = testbed(Profile::retail());
    let nowhere = at(0, 10.0, 10.0, 10.0);
    assert_eq!(
        list(&mut world, &nowhere, &[sphere(1.0, 1.0, 1.0, 1.0)]),
        (vec![], 0)
    );
    let place = at(0xA9B4_0012, 60.0, 36.0, 20.0);
    assert_eq!(list(&mut world, &place, &[]).0, [0xA9B4_0012]);
}

#[test]
fn through_the_front_door() {
    let mut world = testbed(Profile::retail());
    // In front of the door at y = 102, in the cell of the house.
    let outside = at(0xA9B4_0025, 103.0, 101.0, 20.0);
    let (cells, current) = list(&mut world, &outside, &[sphere(103.0, 101.8, 20.5, 0.48)]);
    assert_eq!((cells[0], current), (0xA9B4_0025, 0xA9B4_0025));
    assert!(cells.contains(&HOUSE));
    // Inside, touching the plane of the exit portal.
    let inside = at(HOUSE, 103.0, 102.3, 20.0);
    let (cells, current) = list(&mut world, &inside, &[sphere(103.0, 102.3, 20.5, 0.48)]);
    assert_eq!((cells[0], current), (HOUSE, HOUSE));
    assert!(cells.contains(&0xA9B4_0025));
}

#[test]
fn adjust_position_finds_rooms_and_the_open() {
    let mut world = testbed(Profile::retail());
    let mut place = at(HOUSE, 108.0, 108.0, 20.0);
    let head = Vec3::new(0.0, 0.0, 0.5);
    let found = world.adjust_position(&mut place, head, true);
    assert_eq!(found.map(|c| world.cell_id(c).0), Some(HOUSE));
    // The id is of the house, the place is outside: the hall sees the open.
    let mut place = at(HOUSE, 103.0, 98.0, 20.0);
    let found = world.adjust_position(&mut place, head, true);
    assert_eq!(found.map(|c| world.cell_id(c).0), Some(0xA9B4_0025));
    // A dungeon room does not.
    let mut place = at(0x0D01_0100, 40.0, 40.0, 100.0);
    assert_eq!(world.adjust_position(&mut place, head, true), None);
    let mut place = at(0xA9B4_0050, 10.0, 10.0, 20.0);
    assert_eq!(
        world.adjust_position(&mut place, head, true),
        None,
        "no such cell number"
    );
    let mut place = at(0xA9B4_FFFF, 10.0, 10.0, 20.0);
    assert_eq!(world.adjust_position(&mut place, head, true), None);
}

#[test]
fn statics_have_shadows_in_the_cells_they_touch() {
    let mut world = testbed(Profile::retail());
    loaded(&mut world, 0xA8B4_0001);
    let block = world.land.block(CellId(0xA8B4_0001)).unwrap();
    assert_eq!(block.info_statics, block.statics.len());
    let shadows = |i: usize| -> Vec<u32> {
        let body = world.land.static_body(block.statics[i]).unwrap();
        body.shadows.iter().map(|s| s.id.0).collect()
    };
    assert_eq!(shadows(0), [0xA8B4_000A], "crate in the middle of a cell");
    assert_eq!(
        shadows(2),
        [0xA8B4_000D, 0xA8B4_0004, 0xA8B4_0005, 0xA8B4_000C],
        "crate on a corner: its own cell, then columns from the west"
    );
    for &id in &block.statics {
        check_shadows(&world, ObjectRef::Static(id));
    }
}

/// Invariants 10 to 12 of `spec/03-cells.md`, 19.1, for one object.
fn check_shadows(world: &World, object: ObjectRef) {
    let body = world.body(object).unwrap();
    let home = world.land.cell(body.cell.unwrap()).unwrap();
    assert_eq!(
        home.base().objects.iter().filter(|&&o| o == object).count(),
        1
    );
    for entry in &body.shadows {
        let Some(cell) = entry.cell.and_then(|c| world.land.cell(c)) else {
            continue;
        };
        assert_eq!(cell.id(), entry.id);
        assert_eq!(
            cell.base().shadows.iter().filter(|&&o| o == object).count(),
            1
        );
    }
}

#[test]
fn buildings_know_their_cell_and_their_rooms() {
    let mut world = testbed(Profile::retail());
    let cell = loaded(&mut world, 0xA9B4_0025);
    let land = world.land.land_cell(cell).unwrap();
    let building = world
        .land
        .static_object(land.cell.building.unwrap())
        .unwrap();
    assert_eq!(building.kind, StaticKind::Building);
    assert_eq!(building.portals[0].other_cell, CellId(HOUSE));
    assert!(
        land.cell.base.objects.is_empty(),
        "a building is in no object list"
    );
    let stab = &land.block.stab_list;
    assert!(
        building
            .portals
            .iter()
            .flat_map(|p| &p.stab_list)
            .all(|id| stab.contains(id))
    );
    let mut unique = stab.clone();
    unique.sort();
    unique.dedup();
    assert_eq!(unique.len(), stab.len());
}

/// 8.3: who is in a room of the building is found from the cell that the building stands in, through the portals between the rooms, and only
/// in rooms that are loaded.
#[test]
fn who_is_in_a_building_is_found_from_outside() {
    let mut world = testbed(Profile::retail());
    let cell = loaded(&mut world, 0xA9B4_0025);
    let entity = world.entities.create(7, 0.0);
    let id = entity.id;
    world.entities.put(entity);
    let front = loaded(&mut world, HOUSE);
    let portals = &world.land.env_cell(front).expect("a room").portals;
    let next = portals.iter().find_map(|portal| match portal.target {
        PortalTarget::Cell(next) => Some(next),
        PortalTarget::Outside => None,
    });
    let next = next.expect("the house has more rooms");
    for room in [CellId(HOUSE), next] {
        let room = loaded(&mut world, room.0);
        assert_eq!(world.object_in_cell(cell, 7), None);
        world.land.add_object(room, ObjectRef::Entity(id));
        assert_eq!(world.object_in_cell(cell, 7), Some(id));
        world.land.remove_object(room, ObjectRef::Entity(id));
    }
    let elsewhere = loaded(&mut world, 0xA9B4_0001);
    assert_eq!(world.object_in_cell(elsewhere, 7), None);
    // Rooms that are not there hold nobody.
    world.unload_room(CellId(HOUSE));
    assert_eq!(world.object_in_cell(cell, 7), None);
}

/// 10.4: a part that always faces the viewer reaches as far as its sphere around the place of the part, not as its box.
#[test]
fn parts_that_face_the_viewer_reach_as_far_as_their_sphere() {
    let shadows = |mode: Option<u32>, profile: Profile| {
        let mut world = WorldBuilder::new();
        let faces = block(Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 2.0));
        let mut record = shape(0x0100_0001, &faces, &faces);
        if let Some(mode) = mode {
            record.flags |= GfxObjFlags::DEGRADE;
            record.degrade = 0x1100_0001;
            let level = DegradeLevel {
                shape: 0x0100_0001,
                mode,
                min_distance: 0.0,
                ideal_distance: 0.0,
                max_distance: 100.0,
            };
            world.add(&DegradeInfo {
                id: 0x1100_0001,
                levels: vec![level],
            });
        }
        world.add(&record);
        // The box ends 0.3 m before the border at x = 48; the sphere of the tree reaches beyond.
        world
            .block(0x10, 0x20)
            .object(0x0100_0001, Vec3::new(49.3, 60.0, 0.0), 0.0);
        let dats = world.surround().build().expect("the world is well formed");
        let mut world = World::with_source(profile, 0.0, Arc::new(dats));
        let cell = loaded(&mut world, 0x1020_0013);
        let land = world.land.land_cell(cell).expect("a cell");
        let body = world
            .land
            .static_body(land.block.statics[0])
            .expect("a static object");
        body.shadows.iter().map(|s| s.id.low()).collect::<Vec<_>>()
    };
    let retail = Profile::retail;
    assert_eq!(shadows(None, retail()), [0x13]);
    assert_eq!(shadows(Some(1), retail()), [0x13], "drawn as it is");
    assert_eq!(shadows(Some(2), retail()), [0x13, 0x0B]);
    assert_eq!(shadows(Some(2), Profile::gdle()), [0x13, 0x0B]);
    assert_eq!(
        shadows(Some(2), Profile::ace()),
        [0x13],
        "C-08: without this rule"
    );
}

#[test]
fn restrictions_come_from_the_table() {
    let mut world = testbed(Profile::retail());
    let cell = loaded(&mut world, 0xABB3_0040);
    assert_eq!(
        world.land.cell(cell).unwrap().base().restriction,
        0x7AB3_0001
    );
}

#[test]
fn rooms_are_loaded_with_what_they_see_only_where_a_profile_does() {
    let mut one = testbed(Profile::retail());
    loaded(&mut one, 0x0D01_0100);
    let mut all = testbed(Profile {
        env_cell_statics: EnvCellStatics::ConnectedSet,
        ..Profile::retail()
    });
    loaded(&mut all, 0x0D01_0100);
    let count = |world: &World| world.land.loaded_rooms(CellId(0x0D01_0100)).count();
    assert!(count(&one) <= count(&all) && count(&all) > 1);
    let made = |world: &World, h| world.land.env_cell(h).unwrap().statics_made;
    assert!(
        all.land
            .loaded_rooms(CellId(0x0D01_0100))
            .all(|h| made(&all, h))
    );
}

#[test]
fn a_lookup_does_not_load_and_says_what_is_missing() {
    let mut world = testbed(Profile::retail());
    let id = CellId(0xA9B4_0012);
    assert!(world.land.is_missing(id) && world.land.loaded(id).is_none());
    assert!(world.load_for_transition(id));
    assert!(!world.load_for_transition(id));
    for absent in [0x5050_0001, 0xA9B4_0999, 0xFF00_0001] {
        world.load_for_transition(CellId(absent));
        assert!(!world.land.is_missing(CellId(absent)), "{absent:X}");
        assert!(world.land.loaded(CellId(absent)).is_none());
    }
}

#[test]
fn results_do_not_depend_on_what_was_loaded_before() {
    let place = at(0xA9B4_0025, 103.0, 101.0, 20.0);
    let spheres = [sphere(103.0, 101.8, 20.5, 0.48)];
    let mut fresh = testbed(Profile::retail());
    let expected = list(&mut fresh, &place, &spheres);
    let mut used = testbed(Profile::retail());
    for cell in [HOUSE, 0xA9B4_0001, 0xA8B4_0001, 0x0D01_0100] {
        used.load_for_transition(CellId(cell));
    }
    assert_eq!(list(&mut used, &place, &spheres), expected);
}

#[test]
fn a_released_block_comes_back_the_same() {
    let mut world = testbed(Profile::retail());
    let shadows = |world: &mut World| -> Vec<(u32, usize)> {
        let mut all = Vec::new();
        for low in 1..=64 {
            let cell = loaded(world, 0xA8B4_0000 | low);
            all.push((low, world.land.cell(cell).unwrap().base().shadows.len()));
        }
        all
    };
    let before = shadows(&mut world);
    assert!(before.iter().any(|&(_, n)| n > 0));
    let mut lost: Vec<EntityId> = Vec::new();
    world.release_block(CellId(0xA8B4_0001), &mut lost);
    assert!(lost.is_empty() && world.land.block(CellId(0xA8B4_0001)).is_none());
    assert_eq!(shadows(&mut world), before);
}

#[test]
fn removal_keeps_the_order_that_the_profile_says() {
    let mut world = testbed(Profile::retail());
    let cell = loaded(&mut world, 0xA9B4_0012);
    let objects: Vec<ObjectRef> = (0..4).map(|i| ObjectRef::Entity(EntityId(i))).collect();
    let mut ordered = Profile::retail();
    ordered.list_removal = ListRemoval::SlotsReused;
    for (profile, expected) in [(Profile::retail(), [0, 3, 2]), (ordered, [0, 2, 3])] {
        for &o in &objects {
            world.land.add_shadow(cell, o);
        }
        world.land.remove_shadow(cell, objects[1], &profile);
        let left = &world.land.cell(cell).unwrap().base().shadows;
        assert_eq!(left[..], expected.map(|i| objects[i]));
        for &o in &objects {
            world.land.remove_shadow(cell, o, &profile);
        }
    }
}

#[test]
fn entering_and_leaving_restores_the_object_list() {
    let mut world = testbed(Profile::retail());
    let cell = loaded(&mut world, 0xA9B4_0012);
    let object = ObjectRef::Entity(EntityId(7));
    world.land.add_object(cell, object);
    world.land.remove_object(cell, object);
    assert!(world.land.cell(cell).unwrap().base().objects.is_empty());
    world.land.remove_object(cell, object);
}

fn ids(array: &CellArray) -> Vec<u32> {
    array.entries().map(|e| e.id.0).collect()
}

#[test]
fn arrays_keep_old_cells_where_a_profile_never_empties_them() {
    let (a, b) = (
        at(0xA9B4_0012, 60.0, 36.0, 20.0),
        at(0xA9B4_0001, 5.0, 5.0, 20.0),
    );
    for (profile, expected) in [
        (Profile::retail(), vec![0xA9B4_0001]),
        (
            Profile {
                cell_array_emptied: false,
                ..Profile::retail()
            },
            vec![0xA9B4_0012, 0xA9B4_0001],
        ),
    ] {
        let mut world = testbed(profile);
        let mut array = CellArray::default();
        list_into(&mut world, &a, &[sphere(60.0, 36.0, 20.0, 0.5)], &mut array);
        list_into(&mut world, &b, &[sphere(5.0, 5.0, 20.0, 0.5)], &mut array);
        assert_eq!(ids(&array), expected);
    }
}

#[test]
fn the_filter_of_unseen_cells_by_profile() {
    // In the doorway, counted as indoors; the centre is outside, so no indoor cell ends the search.
    let place = at(HOUSE, 103.0, 101.9, 20.0);
    let spheres = [sphere(103.0, 101.9, 20.5, 0.48)];
    let run = |do_not_load, asked| {
        let mut world = testbed(Profile {
            do_not_load,
            ..Profile::retail()
        });
        let mut array = CellArray {
            do_not_load_cells: asked,
            ..CellArray::default()
        };
        list_into(&mut world, &place, &spheres, &mut array);
        ids(&array)
    };
    let all = run(DoNotLoad::Statics, false);
    assert!(all.iter().any(|id| id & 0xFFFF < 0x100) && all[0] == HOUSE);
    assert!(
        run(DoNotLoad::Statics, true)
            .iter()
            .all(|id| id & 0xFFFF >= 0x100)
    );
    assert!(
        run(DoNotLoad::StartsIndoors, false)
            .iter()
            .all(|id| id & 0xFFFF >= 0x100)
    );
    assert_eq!(run(DoNotLoad::OwnEntry, false), all);
    let own = run(DoNotLoad::OwnEntry, true);
    assert!(
        own.iter().any(|id| id & 0xFFFF < 0x100),
        "only the own entry is looked at"
    );
}

#[test]
fn an_indoor_static_of_cylinders_may_lack_a_shadow_in_its_own_cell() {
    // The pillar of the large room, whose cell does not list itself as visible from itself.
    let shadows = |profile| {
        let mut world = testbed(profile);
        let room = loaded(&mut world, 0x0D01_0100);
        let env = world.land.env_cell(room).unwrap();
        assert!(!env.stab_list.contains(&env.base.id));
        let pillar = world.land.static_object(env.statics[0]).unwrap();
        assert_eq!(pillar.model, 0x0200_0006);
        let cells: Vec<u32> = pillar.body.shadows.iter().map(|s| s.id.0).collect();
        cells
    };
    assert_eq!(shadows(Profile::retail()), [0x0D01_0100]);
    assert_eq!(shadows(Profile::gdle()), [0_u32; 0]);
}

#[test]
fn freed_slots_are_reused_in_the_order_of_the_dictionary() {
    let profile = Profile {
        list_removal: ListRemoval::SlotsReused,
        ..Profile::retail()
    };
    let mut array = CellArray::default();
    for id in 1..=4 {
        array.add_cell(CellId(id), None);
    }
    array.filter(&profile, |id| id.0 != 1 && id.0 != 3);
    assert_eq!(ids(&array), [2, 4]);
    for id in 5..=7 {
        array.add_cell(CellId(id), None);
    }
    assert_eq!(ids(&array), [6, 2, 5, 4, 7]);
    array.add_cell(CellId(4), None);
    assert_eq!(ids(&array).len(), 5);
}

#[test]
fn every_profile_lists_cells_of_every_kind() {
    // The values of the part forms: each must load the whole testbed without errors.
    for part_boxes in [PartBoxes::Own, PartBoxes::OwnBlock, PartBoxes::Crossed] {
        for building_portals in [
            BuildingPortals::InsideHalf,
            BuildingPortals::OutsideHalf,
            BuildingPortals::IdPasses,
        ] {
            for missing_cells in [MissingCells::Entered, MissingCells::LeftOut] {
                let profile = Profile {
                    part_boxes,
                    building_portals,
                    missing_cells,
                    ..Profile::retail()
                };
                let mut world = testbed(profile);
                for cell in [
                    0xA8B4_0001,
                    0xA9B4_0100,
                    0xA9B5_0100,
                    0x0D01_0100,
                    0xABB3_0001,
                ] {
                    loaded(&mut world, cell);
                }
                assert!(
                    world.resources.errors().is_empty(),
                    "{:?}",
                    world.resources.errors()
                );
            }
        }
    }
}

#[test]
fn scenery_stands_on_the_ground_inside_its_block() {
    let mut world = testbed(Profile::retail());
    loaded(&mut world, 0xABB3_0001);
    let block = world.land.block(CellId(0xABB3_0001)).unwrap();
    let scenery = &block.statics[block.info_statics..];
    assert!(!scenery.is_empty());
    for &id in scenery {
        let object = world.land.static_object(id).unwrap();
        let origin = object.body.position.frame.origin;
        assert_eq!(object.kind, StaticKind::Scenery);
        assert!((0.0..192.0).contains(&origin.x) && (0.0..192.0).contains(&origin.y));
        assert!(!super::super::terrain::on_road(
            block.terrain.words(),
            origin.x,
            origin.y
        ));
        let z = block.terrain.height_at(origin, &world.profile).unwrap();
        assert!((z - origin.z).abs() < 2e-4);
    }
    let mut bare = testbed(Profile {
        scenery: false,
        ..Profile::retail()
    });
    loaded(&mut bare, 0xABB3_0001);
    assert!(
        bare.land
            .block(CellId(0xABB3_0001))
            .unwrap()
            .statics
            .is_empty()
    );
}

#[test]
fn scenery_does_not_depend_on_load_order() {
    let places = |world: &World| -> Vec<[u32; 7]> {
        let block = world.land.block(CellId(0xABB3_0001)).unwrap();
        let body = |id| world.land.static_body(id).unwrap();
        block
            .statics
            .iter()
            .map(|&id| body(id).position.frame.bits())
            .collect()
    };
    let mut a = testbed(Profile::retail());
    loaded(&mut a, 0xABB3_0001);
    let mut b = testbed(Profile::retail());
    for cell in [0xABB4_0001, 0xABB2_0001, 0xABB3_0040] {
        loaded(&mut b, cell);
    }
    assert_eq!(places(&a), places(&b));
}

#[test]
fn a_world_without_land_has_no_cells() {
    let source = Arc::new(MemorySource::default());
    let mut world = World::with_source(Profile::retail(), 0.0, source);
    let place = at(0xA9B4_0012, 60.0, 36.0, 20.0);
    let (cells, current) = list(&mut world, &place, &[sphere(60.0, 36.0, 20.0, 0.5)]);
    assert_eq!((cells, current), (vec![0xA9B4_0012], 0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn ids_and_coordinates(x in 0..2040_i32, y in 0..2040_i32) {
        let coord = LandCoord { x, y };
        prop_assert_eq!(coord.cell_id().land_coord(), Some(coord));
    }

    #[test]
    fn block_offsets_add_up(a in 0_u32..0xFEFF, b in 0_u32..0xFEFF, c in 0_u32..0xFEFF) {
        let [a, b, c] = [a, b, c].map(|v| CellId(v << 16 | 1));
        prop_assert_eq!(block_offset(a, b), -block_offset(b, a));
        prop_assert_eq!(block_offset(a, c), block_offset(a, b) + block_offset(b, c));
    }

    /// Invariants 5 to 9: outdoors.
    #[test]
    fn outdoor_lists(x in 0.5_f32..191.5, y in 0.5_f32..191.5, r in 0.01_f32..12.0) {
        let mut world = testbed(Profile::retail());
        let place = at(0xA9B6_0001, x, y, 20.0);
        let (cells, current) = list(&mut world, &place, &[sphere(x, y, 20.0, r)]);
        let outdoor = cells.iter().filter(|&&id| id & 0xFFFF < 0x100).count();
        prop_assert!(matches!(outdoor, 1 | 2 | 4), "{:X?}", cells);
        let mut unique = cells.clone();
        unique.sort_unstable();
        unique.dedup();
        prop_assert_eq!(unique.len(), cells.len());
        prop_assert!(cells.contains(&current));
        let handle = world.land.loaded(CellId(current)).unwrap();
        let point = Vec3::new(x, y, 20.0) - block_offset(place.cell, CellId(current));
        let cell: CellRef<'_> = world.land.cell(handle).unwrap();
        prop_assert!(world.land.point_in_cell(cell, point, &world.profile));
        let (wider, _) = list(&mut world, &place, &[sphere(x, y, 20.0, r * 1.5)]);
        prop_assert!(cells.iter().all(|id| wider.contains(id)));
    }

    /// Invariants 5, 6, 8 and 9: in and around the house.
    #[test]
    fn indoor_lists(x in 101.0_f32..115.0, y in 100.0_f32..115.0, z in 20.0_f32..25.0, r in 0.01_f32..2.0) {
        let mut world = testbed(Profile::retail());
        let place = at(HOUSE, x, y, z);
        let (cells, current) = list(&mut world, &place, &[sphere(x, y, z, r)]);
        prop_assert_eq!(cells[0], HOUSE);
        let mut unique = cells.clone();
        unique.sort_unstable();
        unique.dedup();
        prop_assert_eq!(unique.len(), cells.len());
        prop_assert!(current == 0 || cells.contains(&current));
        let (wider, _) = list(&mut world, &place, &[sphere(x, y, z, r * 1.5)]);
        prop_assert!(cells.iter().all(|id| wider.contains(id)));
    }

    /// Invariant 20.
    #[test]
    fn searching_finds_at_least_the_neighbours(x in 10.0_f32..70.0, y in -70.0_f32..-10.0, z in -14.0_f32..0.0) {
        let mut world = testbed(Profile::retail());
        let start = loaded(&mut world, 0x0D01_0100);
        let mut find = |search| world.with_loading(|land, profile, missing| {
            land.find_visible_child_cell(start, Vec3::new(x, y, z), search, profile, missing)
        });
        let (near, far) = (find(false), find(true));
        prop_assert!(near.is_none() || far.is_some());
    }
}
