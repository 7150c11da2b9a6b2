//! Part arrays (5 and 6).

use std::sync::Arc;

use crate::animation::fixtures::*;
use crate::animation::{PartArray, PartArrayError};
use crate::dat::{AnimFrame, Animation, Setup, StoredFrame};
use crate::math::{CellId, Frame, Quat, Sphere, Vec3};
use crate::physics::collision::GfxShape;
use crate::profile::{DefaultAnimation, MissingTables, Profile};

const SHAPE: u32 = 0x0100_0001;
const SETUP: u32 = 0x0200_0001;
const IDLE: u32 = 0x0300_0001;

fn pose(x: f32) -> AnimFrame {
    AnimFrame {
        parts: vec![
            StoredFrame::at(Vec3::new(x, 0.0, 0.0)),
            StoredFrame::at(Vec3::new(0.0, x, 0.0)),
        ],
        hooks: Vec::new(),
    }
}

/// Two parts, placements 0 and 0x65, an animation that moves the parts.
fn shelf() -> Shelf {
    let mut setup = Setup::empty(SETUP);
    setup.parts = vec![SHAPE, SHAPE];
    setup.scales = vec![Vec3::ONE, Vec3::splat(2.0)];
    setup.placements = [(0, pose(1.0)), (0x65, pose(2.0))].into_iter().collect();
    setup.height = 1.5;
    setup.radius = 0.5;
    setup.step_up_height = 0.4;
    let sphere = Sphere {
        center: Vec3::ZERO,
        radius: 3.0,
    };
    setup.selection_sphere = sphere;
    let mut idle = Animation::new(IDLE, 2);
    idle.push(pose(5.0), None);
    idle.push(pose(6.0), None);
    let shape = GfxShape {
        id: SHAPE,
        drawing_sphere: Some(sphere),
        ..GfxShape::default()
    };
    Shelf {
        animations: vec![Arc::new(idle)],
        setups: vec![Arc::new(setup)],
        shapes: vec![(SHAPE, Arc::new(shape))],
        ..Shelf::default()
    }
}

fn origins(array: &PartArray) -> Vec<[f32; 3]> {
    let origin = |p: &crate::animation::PhysicsPart| p.position.frame.origin.to_array();
    array.existing_parts().map(origin).collect()
}

#[test]
fn a_new_array_shows_its_resting_placement() {
    let profile = Profile::retail();
    let mut array = PartArray::with_setup(SETUP, &mut shelf(), &profile).unwrap();
    let at = Frame::from_origin(Vec3::new(10.0, 20.0, 30.0));
    array.update_parts(&at, &profile);
    assert_eq!(origins(&array), [[12.0, 20.0, 30.0], [10.0, 22.0, 30.0]]);
    assert!(array.set_placement_frame(7));
    assert_eq!(array.sequence.placement.id, 0);
    array.update_parts(&at, &profile);
    assert_eq!(origins(&array), [[11.0, 20.0, 30.0], [10.0, 21.0, 30.0]]);
    array.set_cell_id(CellId(0xA9B4_0001));
    assert!(
        array
            .existing_parts()
            .all(|p| p.position.cell.0 == 0xA9B4_0001)
    );
}

#[test]
fn scale_moves_parts_and_sizes_them() {
    let profile = Profile::retail();
    let mut array = PartArray::with_setup(SETUP, &mut shelf(), &profile).unwrap();
    array.set_scale(Vec3::new(1.0, 3.0, 2.0));
    array.update_parts(&Frame::IDENTITY, &profile);
    assert_eq!(origins(&array), [[2.0, 0.0, 0.0], [0.0, 6.0, 0.0]]);
    let scales: Vec<_> = array.existing_parts().map(|p| p.scale).collect();
    assert_eq!(scales, [Vec3::new(1.0, 3.0, 2.0), Vec3::new(2.0, 6.0, 4.0)]);
    assert_eq!((array.height(), array.radius()), (3.0, 1.0));
    assert_eq!(
        (array.step_up_height(), array.step_down_height()),
        (0.8, 0.0)
    );
    assert_eq!(array.selection_sphere().unwrap().radius, 6.0);
}

#[test]
fn the_current_animation_frame_is_the_pose() {
    let profile = Profile::retail();
    let mut source = shelf();
    let mut array = PartArray::with_setup(SETUP, &mut source, &profile).unwrap();
    array
        .sequence
        .append_animation(&whole(IDLE, 10.0), &mut source, &profile);
    array.set_placement_frame(0);
    let turned = Frame::new(Vec3::ZERO, Quat::new(0.0, 0.0, 0.0, 1.0));
    array.update_parts(&turned, &profile);
    assert_eq!(origins(&array), [[-5.0, 0.0, 0.0], [0.0, -5.0, 0.0]]);
    array.update(0.1, None, &profile).unwrap();
    array.update_parts(&Frame::IDENTITY, &profile);
    let once = origins(&array);
    assert_eq!(once, [[6.0, 0.0, 0.0], [0.0, 6.0, 0.0]]);
    array.update_parts(&Frame::IDENTITY, &profile);
    assert_eq!(origins(&array), once);
}

#[test]
fn a_mesh_is_one_part_in_place() {
    let profile = Profile::retail();
    let mut array = PartArray::mesh(SHAPE, &mut shelf()).unwrap();
    array.update_parts(&Frame::from_origin(Vec3::Z), &profile);
    assert_eq!(origins(&array), [[0.0, 0.0, 1.0]]);
    assert_eq!((array.setup_id(), array.data_id()), (0, SHAPE));
    assert_eq!(array.sorting_sphere().radius, 3.0);
    assert!(!array.has_physics_bsp());
    assert_eq!(
        PartArray::mesh(0, &mut shelf()).err(),
        Some(PartArrayError::NullId)
    );
}

#[test]
fn particles_have_slots_and_no_pose() {
    let array = PartArray::particle(4).unwrap();
    assert_eq!(array.parts.len(), 4);
    assert!(array.pose().is_none());
    assert!(PartArray::particle(0).is_err());
    assert!(PartArray::particle(usize::MAX).is_err());
}

#[test]
fn what_is_missing_is_an_error() {
    let profile = Profile::retail();
    let mut source = shelf();
    let missing = PartArray::with_setup(0x0200_0002, &mut source, &profile).err();
    assert_eq!(missing, Some(PartArrayError::MissingSetup(0x0200_0002)));
    let mut empty = Profile::retail();
    empty.missing_tables = MissingTables::Empty;
    let missing = PartArray::with_setup(0x0200_0002, &mut source, &empty).err();
    assert_eq!(missing, Some(PartArrayError::NoParts(0)));
    source.shapes.clear();
    let missing = PartArray::with_setup(SETUP, &mut source, &profile).err();
    assert_eq!(
        missing,
        Some(PartArrayError::MissingShape {
            part: 0,
            shape: SHAPE
        })
    );
}

#[test]
fn the_default_animation_plays_by_profile() {
    let mut source = shelf();
    let mut setup = (*source.setups[0]).clone();
    setup.default_animation = IDLE;
    source.setups = vec![Arc::new(setup)];
    let mut rate = |profile: Profile| {
        let array = PartArray::with_setup(SETUP, &mut source, &profile).unwrap();
        let node = array.sequence.current_node().unwrap().clone();
        (node.low, node.high, node.rate)
    };
    assert_eq!(rate(Profile::retail()), (0, 1, 30.0));
    let mut first = Profile::retail();
    first.default_animation = DefaultAnimation::FirstFrame;
    assert_eq!(rate(first), (0, 0, 0.0));
}

#[test]
fn parts_are_replaced_one_by_one() {
    let profile = Profile::retail();
    let mut source = shelf();
    let mut array = PartArray::with_setup(SETUP, &mut source, &profile).unwrap();
    let other = GfxShape {
        id: 0x0100_0002,
        ..GfxShape::default()
    };
    source.shapes.push((other.id, Arc::new(other)));
    assert!(array.set_parts([(1, 0x0100_0002)], &mut source));
    assert!(!array.set_parts([(0, 0x0100_0009), (9, SHAPE), (0, 0)], &mut source));
    let ids: Vec<_> = array.existing_parts().map(|p| p.shape.id).collect();
    assert_eq!(ids, [SHAPE, 0x0100_0002]);
}

#[test]
fn a_motion_table_is_assigned_once() {
    let profile = Profile::retail();
    let mut source = shelf();
    source.tables.push(table(TableParts {
        cycles: vec![(NON_COMBAT, READY, motion(&[(IDLE, 10.0)]))],
        ..TableParts::default()
    }));
    let mut array = PartArray::with_setup(SETUP, &mut source, &profile).unwrap();
    assert_eq!(array.motion_table_id(), 0);
    array.set_motion_table(TABLE, &mut source, &profile);
    array.initialize_motion_tables(&mut source, &profile);
    assert!(array.has_animations());
    array.set_motion_table(TABLE, &mut source, &profile);
    assert_eq!(array.motion_table.as_ref().unwrap().state.style, NON_COMBAT);
    array.set_motion_table(0, &mut source, &profile);
    assert!(array.motion_table.is_none());
    assert!(array.has_animations());
    // A table that does not exist refuses everything.
    array.set_motion_table(0x0900_0009, &mut source, &profile);
    assert_eq!(array.motion_table_id(), 0);
    assert!(array.motion_table.is_some());
}
