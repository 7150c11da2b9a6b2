//! Tests of terrain, landscape, cell lists and collisions on the synthetic worlds.

mod cells;
mod collision;
mod streaming;
mod terrain;

use std::path::PathBuf;
use std::sync::Arc;

use super::{CellHandle, World};
use crate::dat::{DatSet, Strictness};
use crate::math::{CellId, Position, Quat, Sphere, Vec3};
use crate::physics::transition::CellArray;
use crate::profile::Profile;

/// The synthetic world `testbed`.
pub(super) fn testbed(profile: Profile) -> World {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../golden-traces/worlds/testbed");
    let dats =
        DatSet::open(folder, Strictness::Strict).expect("the world is part of the repository");
    World::with_source(profile, 0.0, Arc::new(dats))
}

pub(super) fn at(cell: u32, x: f32, y: f32, z: f32) -> Position {
    Position::new(CellId(cell), Vec3::new(x, y, z), Quat::IDENTITY)
}

pub(super) fn sphere(x: f32, y: f32, z: f32, radius: f32) -> Sphere {
    Sphere::new(Vec3::new(x, y, z), radius)
}

pub(super) fn loaded(world: &mut World, cell: u32) -> CellHandle {
    world.visible_cell(CellId(cell)).expect("the cell exists")
}

/// Cell list of spheres at a position: ids in order, and the current cell's id.
pub(super) fn list(world: &mut World, position: &Position, spheres: &[Sphere]) -> (Vec<u32>, u32) {
    let mut array = CellArray::default();
    let current = list_into(world, position, spheres, &mut array);
    (array.entries().map(|e| e.id.0).collect(), current)
}

pub(super) fn list_into(
    world: &mut World,
    position: &Position,
    spheres: &[Sphere],
    array: &mut CellArray,
) -> u32 {
    let current = world.with_loading(|land, profile, missing| {
        let at = super::SpheresAt {
            position,
            spheres,
            is_path: true,
            want_current: true,
        };
        let outcome = land.find_cell_list(at, array, profile);
        *missing = outcome.missing;
        outcome.current
    });
    let handle = current.flatten();
    handle.map_or(0, |h| world.cell_id(h).0)
}
