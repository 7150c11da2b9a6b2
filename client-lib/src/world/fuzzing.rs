//! Body of the fuzz target `cells` in `fuzz/`. It is here so that a deterministic smoke of the very same body runs with the tests.
//!
//! The bytes are a recipe: a block with a few small rooms, any of which may be damaged (no volume, a volume that is deeper than trees may be
//! or goes in circles, collapsed or infinite corners, portals without a polygon, to nowhere, to themselves), a building whose openings lead
//! anywhere, and what then happens around them. Whatever it says, nothing panics, every search ends, and what is found is consistent.

use std::sync::Arc;

use super::{MemorySource, SpheresAt, Streaming, World};
use crate::dat::worldgen::{Rect, Room, Side, block, shape, yaw};
use crate::dat::{BspTag, MAX_DEPTH};
use crate::dat::{
    Building, BuildingPortal, CellBsp, CellInner, CellNode, CellPortal, CellStruct, EnvCell,
    EnvCellFlags, Environment, KeyedList, Landblock, LandblockInfo, LandblockInfoMask, NodeId,
    PhysicsBsp, PolygonSet, PortalFlags, Setup, Stab, StoredFrame, TerrainWord, VERTICES,
    VertexArray,
};
use crate::frame::pipeline::{NoHost, Pipeline};
use crate::math::{CellId, Plane, Position, Sphere, Vec3};
use crate::physics::body::EntityId;
use crate::physics::fuzzing::{Recipe, check_membership};
use crate::physics::placement::{PlacementFlags, SetPosition};
use crate::physics::transition::CellArray;
use crate::profile::{DoNotLoad, Profile};

const BLOCK: u32 = 0x1020_0000;
const SHELL: u32 = 0x0100_0001;
const BALL: u32 = 0x0200_0001;
const CRATE: u32 = 0x0200_0002;
const ENVIRONMENT: u32 = 0x0D00_0001;
/// Most rooms of a block.
const MAX_ROOMS: usize = 6;
/// Most things that happen.
const MAX_ACTIONS: usize = 32;

/// A cell tree of `depth` planes that all face up; with `cycle` the last one leads back to the second.
fn chain(depth: usize, cycle: bool) -> CellBsp {
    let mut tree = CellBsp::default();
    for n in 0..depth {
        let last = n + 1 == depth;
        tree.nodes.push(CellNode::Inner(CellInner {
            tag: BspTag::BPnn,
            plane: Plane::from_normal_and_point(Vec3::Z, Vec3::Z * -5.0),
            positive: NodeId::new(if last { usize::from(cycle) } else { n + 1 }),
            negative: None,
        }));
    }
    tree
}

/// The corners of a structure, each moved to where `to` says.
fn bent(vertices: &VertexArray, to: impl Fn(Vec3) -> Vec3) -> VertexArray {
    let mut bent = VertexArray::default();
    for vertex in vertices.vertices() {
        bent.push(to(vertex.position), vertex.normal, &[]);
    }
    bent
}

fn structure(recipe: &mut Recipe<'_>) -> CellStruct {
    let door = Rect {
        u: [-1.0, 1.0],
        v: [0.0, 2.5],
    };
    let half = 1.0 + 3.0 * recipe.unit().abs();
    let mut room = Room::new(Vec3::new(-half, -half, 0.0), Vec3::new(half, half, 3.0));
    for _ in 0..recipe.below(4) {
        room = room.doorway(recipe.pick(&Side::ALL), door);
    }
    let mut made = room.structure();
    match recipe.below(14) {
        0 => made.vertices = bent(&made.vertices, |_| Vec3::ONE),
        1 => made.vertices = bent(&made.vertices, |p| p * f32::INFINITY),
        2 => made.vertices = bent(&made.vertices, |p| p.with_x(f32::NAN)),
        3 => made.physics_bsp = PhysicsBsp::default(),
        4 => made.cell_bsp = CellBsp::default(),
        5 => made.cell_bsp = chain(MAX_DEPTH + 1 + recipe.below(600), false),
        6 => made.cell_bsp = chain(2 + recipe.below(20), true),
        7 => made.polygons = PolygonSet::default(),
        8 => made.cell_bsp = chain(1, false),
        _ => {}
    }
    made
}

fn low(recipe: &mut Recipe<'_>) -> u16 {
    match recipe.below(12) {
        0 => 0xFFFF,
        1 => 0x01F0,
        2 => 0,
        3 => 0x0041,
        _ => 0x0100 + recipe.below(MAX_ROOMS) as u16,
    }
}

fn lows(recipe: &mut Recipe<'_>) -> Vec<u16> {
    (0..recipe.below(5)).map(|_| low(recipe)).collect()
}

/// A place near the rooms; now and then one that is no place.
fn frame(recipe: &mut Recipe<'_>) -> StoredFrame {
    let mut frame = StoredFrame::at(Vec3::new(96.0, 96.0, 0.0) + recipe.vector(8.0));
    frame.rotation = yaw(recipe.unit() * 180.0);
    match recipe.below(24) {
        0 => frame.origin.x = f32::NAN,
        1 => frame.origin *= 1e30,
        2 => frame.rotation = crate::math::Quat::new(0.0, 0.0, 0.0, 0.0),
        _ => {}
    }
    frame
}

fn flags(recipe: &mut Recipe<'_>) -> PortalFlags {
    PortalFlags::from_bits_retain(u16::from(recipe.byte() % 8))
}

fn room(index: usize, structures: usize, recipe: &mut Recipe<'_>) -> EnvCell {
    let portal = |recipe: &mut Recipe<'_>| CellPortal {
        flags: flags(recipe),
        polygon: recipe.pick(&[0, 1, 2, 99]),
        other_room: low(recipe),
        other_portal: recipe.pick(&[0, 1, 7, 0xFFFF]),
    };
    let stab = |recipe: &mut Recipe<'_>| Stab {
        model: recipe.pick(&[SHELL, BALL, CRATE, 0x0100_0099, 0]),
        frame: frame(recipe),
    };
    EnvCell {
        id: BLOCK | (0x100 + index as u32),
        flags: EnvCellFlags::from_bits_retain(u32::from(recipe.byte() % 2)),
        surfaces: Vec::new(),
        environment: recipe.pick(&[1, 1, 1, 1, 1, 2]),
        structure: recipe.below(structures + 1) as u16,
        frame: frame(recipe),
        portals: (0..recipe.below(4)).map(|_| portal(recipe)).collect(),
        visible_rooms: lows(recipe),
        statics: (0..recipe.below(3)).map(|_| stab(recipe)).collect(),
        restriction: recipe.pick(&[0, 0, 0, 0x7000_0001]),
    }
}

fn building(recipe: &mut Recipe<'_>) -> Building {
    let portal = |recipe: &mut Recipe<'_>| BuildingPortal {
        flags: flags(recipe),
        room: low(recipe),
        room_portal: recipe.pick(&[0, 1, 7, 0xFFFF]),
        visible_rooms: lows(recipe),
    };
    Building {
        model: recipe.pick(&[SHELL, CRATE, 0x0100_0099]),
        frame: frame(recipe),
        leaf_count: 0,
        portals: (0..recipe.below(4)).map(|_| portal(recipe)).collect(),
    }
}

fn setup(id: u32, part: bool) -> Arc<Setup> {
    let mut setup = Setup::empty(id);
    setup.parts = vec![SHELL];
    if !part {
        setup.spheres = vec![Sphere::new(Vec3::Z * 0.5, 0.5)];
    }
    (setup.height, setup.radius) = (1.0, 0.5);
    (setup.step_up_height, setup.step_down_height) = (0.4, 0.4);
    Arc::new(setup)
}

fn source(recipe: &mut Recipe<'_>) -> MemorySource {
    let mut source = MemorySource::default();
    let faces = block(Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 2.0));
    source
        .gfx_objs
        .insert(SHELL, Arc::new(shape(SHELL, &faces, &faces)));
    for (id, part) in [(BALL, false), (CRATE, true)] {
        source.setups.insert(id, setup(id, part));
    }
    let count = 1 + recipe.below(3);
    let structures = (0..count).map(|_| structure(recipe)).collect();
    let environment = Environment {
        id: ENVIRONMENT,
        structures,
    };
    source
        .environments
        .insert(ENVIRONMENT, Arc::new(environment));
    for index in 0..recipe.below(MAX_ROOMS + 1) {
        let room = room(index, count, recipe);
        source.env_cells.insert(room.id, Arc::new(room));
    }
    if recipe.below(6) != 0 {
        let slope = recipe.byte() % 4;
        let id = BLOCK | 0xFFFF;
        let land = Landblock {
            id,
            has_info: 1,
            terrain: [TerrainWord(0); VERTICES * VERTICES],
            heights: std::array::from_fn(|n| (n as u8 / 9).wrapping_mul(slope)),
        };
        source.landblocks.insert(id, Arc::new(land));
    }
    let info = LandblockInfo {
        id: BLOCK | 0xFFFE,
        room_count: 0,
        statics: Vec::new(),
        buildings: (0..recipe.below(3)).map(|_| building(recipe)).collect(),
        mask: LandblockInfoMask::default(),
        restrictions: KeyedList::new(Vec::new()),
        restriction_buckets: 0,
    };
    source.landblock_infos.insert(info.id, Arc::new(info));
    source
}

/// A place whose cell and origin may not belong together.
fn place(recipe: &mut Recipe<'_>) -> Position {
    let cell = match recipe.below(4) {
        0 => 0x25,
        1 => u32::from(low(recipe)),
        _ => 0x100 + recipe.below(MAX_ROOMS) as u32,
    };
    let mut place = Position::new(
        CellId(BLOCK | cell),
        Vec3::new(96.0, 96.0, 1.0) + recipe.vector(8.0),
        yaw(recipe.unit() * 180.0),
    );
    match recipe.below(20) {
        0 => place.frame.origin.y = f32::NAN,
        1 => place.frame.origin.z = f32::NEG_INFINITY,
        2 => place.cell.0 ^= 0xEFDF_0000,
        _ => {}
    }
    place
}

/// Runs a recipe under every profile.
pub fn cells(data: &[u8]) {
    let mut recipe = Recipe(data);
    let source = Arc::new(source(&mut recipe));
    for name in Profile::NAMES {
        let profile = Profile::named(name).unwrap_or_default();
        let world = World::with_source(profile, 100.0, Arc::clone(&source) as _);
        live(&mut Recipe(recipe.0), world);
    }
}

fn live(recipe: &mut Recipe<'_>, mut world: World) {
    let mut streaming = Streaming::with_radius(1);
    let mut ids: Vec<EntityId> = Vec::new();
    let (mut pipeline, mut now) = (Pipeline::default(), 100.0);
    world.land.set_window_only(recipe.below(4) == 0);
    for n in 0..MAX_ACTIONS {
        match recipe.below(8) {
            0 if ids.len() < 4 => ids.extend(create(&mut world, n as u32, recipe)),
            1 => list(&mut world, recipe),
            2 => {
                let mut at = place(recipe);
                let low_point = recipe.vector(1.0);
                let found = world.adjust_position(&mut at, low_point, recipe.byte() & 1 != 0);
                let named = found.is_none_or(|cell| world.cell_id(cell) == at.cell);
                assert!(named, "the position names its cell");
            }
            3 => world.unload_room(place(recipe).cell),
            4 => world.unload_block(CellId(BLOCK)),
            5 => {
                let somewhere = place(recipe).cell;
                let to = recipe.pick(&[CellId(BLOCK | 0x25), CellId::NONE, somewhere]);
                streaming.follow(to, &mut world);
            }
            _ => push(&mut world, &ids, recipe),
        }
        now += recipe.pick(&[0.05, 0.1, 0.3, 3.0]);
        pipeline.run_frame(&mut world, now, &mut NoHost);
        ids.retain(|&id| world.entity(id).is_some());
        for &id in &ids {
            check_membership(&world, id);
        }
        if recipe.ended() {
            break;
        }
    }
}

fn create(world: &mut World, n: u32, recipe: &mut Recipe<'_>) -> Option<EntityId> {
    let guid = 0x8000_0001 + n;
    let setup = recipe.pick(&[BALL, BALL, CRATE]);
    let id = world.make_object(setup, guid, true).ok()?;
    world.entities.register(id, guid);
    let (slide, at) = (recipe.byte() & 1 != 0, place(recipe));
    world.with_entity(id, |e, w| {
        e.set_state(0x0041_0408, w);
        e.enter_world_at(&at, slide, w);
    });
    Some(id)
}

fn push(world: &mut World, ids: &[EntityId], recipe: &mut Recipe<'_>) {
    if ids.is_empty() {
        return;
    }
    let id = recipe.pick(ids);
    let (velocity, to, jumps) = (recipe.vector(30.0), place(recipe), recipe.below(3) == 0);
    world.with_entity(id, |e, w| {
        if jumps {
            e.set_position(&SetPosition::new(to, PlacementFlags::SLIDE), w);
        }
        e.set_velocity(velocity, w);
    });
}

/// A cell list holds no id twice, its cells are what their entries say, and the current cell is one of them (03, 19.1: 5 and 9).
fn list(world: &mut World, recipe: &mut Recipe<'_>) {
    let at = place(recipe);
    let sphere = Sphere::new(at.frame.origin, recipe.unit().abs() * 12.0);
    let mut array = CellArray::default();
    let current = world.with_loading(|land, profile, missing| {
        let at = SpheresAt {
            position: &at,
            spheres: &[sphere],
            is_path: recipe.0.len().is_multiple_of(2),
            want_current: true,
        };
        let outcome = land.find_cell_list(at, &mut array, profile);
        *missing = outcome.missing;
        outcome.current.flatten()
    });
    let entries: Vec<_> = array.entries().collect();
    for (n, entry) in entries.iter().enumerate() {
        assert!(entries[..n].iter().all(|e| e.id != entry.id), "twice");
        let named = entry
            .cell
            .is_none_or(|cell| world.cell_id(cell) == entry.id);
        assert!(named, "the entry names its cell");
    }
    // C-02: one profile takes an outdoor cell out again that it has found to be the current one.
    let filtered = world.profile.do_not_load == DoNotLoad::StartsIndoors;
    let listed = |cell| entries.iter().any(|e| e.cell == Some(cell));
    assert!(
        filtered || current.is_none_or(listed),
        "the current cell is listed"
    );
}

#[cfg(test)]
mod tests {
    use crate::world::Random;

    /// A deterministic smoke of the fuzz target `cells`.
    #[test]
    fn small_cells() {
        let mut random = Random::Seeded(0xCE11);
        for _ in 0..200 {
            let mut byte = || (random.uniform() * 127.5 + 127.5) as u8;
            let recipe: Vec<u8> = (0..700).map(|_| byte()).collect();
            super::cells(&recipe);
        }
    }
}
