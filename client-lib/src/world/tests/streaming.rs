//! Streaming around the load point (03 15 to 17; invariant 19 of 19.1).

use std::collections::BTreeSet;

use proptest::prelude::*;

use super::super::Streaming;
use super::*;
use crate::physics::body::ObjectRef;

/// The block with the house, and around it.
const HOUSE: CellId = CellId(0xA9B4_0001);

fn streamed(points: &[CellId]) -> (World, Streaming) {
    let mut world = testbed(Profile::retail());
    world.land.set_window_only(true);
    let mut streaming = Streaming::with_radius(2);
    for &point in points {
        streaming.follow(point, &mut world);
    }
    (world, streaming)
}

/// What is loaded: blocks, rooms, and per cell which models (by place) throw shadows there.
type Loaded = (BTreeSet<u32>, BTreeSet<u32>, BTreeSet<(u32, u32, [u32; 7])>);

fn loaded_state(world: &World) -> Loaded {
    let blocks: BTreeSet<u32> = world.land.blocks().map(|b| b.id.0).collect();
    let mut rooms = BTreeSet::new();
    let mut shadows = BTreeSet::new();
    for block in world.land.blocks() {
        let lands = (1..=64).filter_map(|low| world.land.loaded(block.id.with_low(low)));
        for cell in world.land.loaded_rooms(block.id).chain(lands) {
            let id = world.cell_id(cell);
            if id.is_indoor() {
                rooms.insert(id.0);
            }
            let Some(cell) = world.land.cell(cell) else {
                continue;
            };
            for object in &cell.base().shadows {
                if let ObjectRef::Static(object) = *object {
                    let object = world.land.static_object(object).expect("it is in a list");
                    let frame = object.body.position.frame.bits();
                    shadows.insert((id.0, object.model, frame));
                }
            }
        }
    }
    (blocks, rooms, shadows)
}

#[test]
fn the_house_is_there_with_its_rooms_while_it_is_near() {
    let (mut world, mut streaming) = streamed(&[HOUSE]);
    let (blocks, rooms, shadows) = loaded_state(&world);
    assert!(blocks.len() <= 9 && blocks.contains(&0xA9B4_FFFF));
    assert!(!rooms.is_empty() && !shadows.is_empty());
    let kept: BTreeSet<u32> = streaming.visible_rooms().map(|c| c.0).collect();
    assert!(rooms.is_subset(&kept));
    let block = world.land.block(HOUSE).expect("loaded");
    assert!(block.stab_list.iter().all(|cell| kept.contains(&cell.0)));
    // One block on, it is a neighbour; two on, it is gone.
    streaming.follow(CellId(0xAAB4_0001), &mut world);
    assert!(world.land.block(HOUSE).is_some());
    let plan = streaming.follow(CellId(0xABB4_0001), &mut world);
    assert!(world.land.block(HOUSE).is_none());
    assert_eq!(world.land.loaded_rooms(HOUSE).count(), 0);
    assert!(plan.leave.iter().all(|b| b.block_x() == 0xA8));
    // The same place again: nothing to do.
    assert_eq!(
        streaming.follow(CellId(0xABB4_0002), &mut world),
        Default::default()
    );
    streaming.follow(CellId::NONE, &mut world);
    assert_eq!(loaded_state(&world), Loaded::default());
}

/// What nobody loaded is not there, and is not asked for.
#[test]
fn lookups_of_a_window_load_nothing() {
    let (mut world, _) = streamed(&[HOUSE]);
    let before = loaded_state(&world);
    let outside = CellId(0xACB4_0001);
    assert!(world.visible_cell(outside).is_none());
    assert!(!world.land.is_missing(outside));
    // A sphere over the border of what is loaded: the cells beyond are entered without a cell.
    let (ids, current) = list(
        &mut world,
        &at(0xAAB4_003C, 191.9, 84.0, 0.0),
        &[sphere(191.9, 84.0, 0.0, 0.5)],
    );
    assert!(ids.contains(&0xABB4_0004) && current == 0xAAB4_003C);
    assert_eq!(loaded_state(&world), before);
}

fn place() -> impl Strategy<Value = CellId> {
    (
        0xA7_u32..0xAC,
        0xB2_u32..0xB7,
        prop_oneof![Just(1_u32), Just(0x100), Just(0x102)],
    )
        .prop_map(|(x, y, low)| CellId(x << 24 | y << 16 | low))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// 19.1, 19: whatever way the load point went, the same is loaded as if it had begun where it is, and every static object has the same
    /// shadows.
    #[test]
    fn the_way_leaves_no_trace(points in prop::collection::vec(place(), 1..6)) {
        let (moved, a) = streamed(&points);
        let (fresh, b) = streamed(&points[points.len() - 1..]);
        prop_assert_eq!(a.window(), b.window());
        let (moved, fresh) = (loaded_state(&moved), loaded_state(&fresh));
        prop_assert_eq!(moved.0, fresh.0);
        prop_assert_eq!(moved.1, fresh.1);
        prop_assert_eq!(moved.2, fresh.2);
    }
}
