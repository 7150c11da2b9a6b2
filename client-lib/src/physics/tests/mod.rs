//! Objects in a small world: invariants and hard cases of `spec/06-physics-object.md`, H2 to H4.

mod attachment;
mod attack;
mod choices;
mod clock;
mod endings;
mod limits;
mod managers;
mod membership;
mod missiles;
mod placement;
mod small_moves;
mod special;
mod statics;
mod visibility;

use std::sync::{Arc, OnceLock};

use crate::dat::worldgen::{Rect, Room, SetupBuilder, Side, WorldBuilder, block};
use crate::dat::{DatSet, StoredFrame};
use crate::frame::pipeline::{NoHost, Pipeline};
use crate::math::{CellId, Position, Quat, Vec3};
use crate::physics::body::EntityId;
use crate::profile::Profile;
use crate::world::World;

/// A walker of two spheres.
pub const WALKER: u32 = 0x0200_0001;
/// A crate of 2 m with a physics tree.
pub const CRATE: u32 = 0x0200_0002;
/// A ball of 0.1 m.
pub const ARROW_SETUP: u32 = 0x0200_0003;
/// Flat land at height 0 in nine blocks, a crate at (60, 60) of the middle one, and two joined rooms at 50 m below.
fn dats() -> Arc<DatSet> {
    static DATS: OnceLock<Arc<DatSet>> = OnceLock::new();
    Arc::clone(DATS.get_or_init(|| {
        let mut world = WorldBuilder::new();
        let cube = world.solid(&block(Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 2.0)));
        world.setup(SetupBuilder::humanoid(cube, 1.8, 0.48));
        let solid = world.setup(SetupBuilder::of_shape(cube));
        world.setup(
            SetupBuilder::of_shape(cube)
                .sphere(Vec3::ZERO, 0.1)
                .size(0.2, 0.1),
        );
        let door = Rect {
            u: [-1.0, 1.0],
            v: [0.0, 2.5],
        };
        let room = Room::new(Vec3::new(-4.0, -4.0, 0.0), Vec3::new(4.0, 4.0, 3.0));
        let rooms = world.environment(&[
            room.clone().doorway(Side::North, door),
            room.doorway(Side::South, door),
        ]);
        let home = world.block(0x10, 0x20);
        home.object(solid, Vec3::new(60.0, 60.0, 0.0), 0.0);
        let at = |y: f32| StoredFrame::at(Vec3::new(96.0, y, -50.0));
        let a = home.room(rooms, 0, at(96.0), 1);
        let b = home.room(rooms, 1, at(104.0), 1);
        home.connect((a, 0), (b, 0));
        Arc::new(world.surround().build().expect("the world is well formed"))
    }))
}

fn world_of(profile: Profile) -> World {
    World::with_source(profile, 100.0, dats())
}

fn world() -> World {
    world_of(Profile::retail())
}

/// A place of the middle block; the cell is that of the place outdoors.
fn at(x: f32, y: f32, z: f32) -> Position {
    let low = 1 + (x / 24.0) as u32 * 8 + (y / 24.0) as u32;
    in_cell(0x1020_0000 | low, x, y, z)
}

fn in_cell(cell: u32, x: f32, y: f32, z: f32) -> Position {
    Position::new(CellId(cell), Vec3::new(x, y, z), Quat::IDENTITY)
}

/// An object of a setup with a state word, registered, and placed if there is a place.
fn object(world: &mut World, setup: u32, state: u32, place: Option<Position>) -> EntityId {
    let guid = 0x8000_0001 + world.entities.table().len() as u32;
    let id = world.make_object(setup, guid, true).expect("a setup");
    world.entities.register(id, guid);
    world.with_entity(id, |e, w| {
        e.set_state(state, w);
        if let Some(place) = place {
            assert!(e.enter_world_at(&place, true, w), "there is room");
        }
    });
    id
}

fn walker(world: &mut World, place: Position) -> EntityId {
    object(world, WALKER, 0x0040_0408, Some(place))
}

fn frame(world: &mut World, now: f64) {
    Pipeline::default().run_frame(world, now, &mut NoHost);
}

/// Everything of an object that a step can change, as bits.
fn bits(world: &World, id: EntityId) -> ([u32; 7], Vec<u32>, u64) {
    let e = world.entity(id).expect("there");
    let k = &e.kin;
    let mut words = vec![
        e.body.position.cell.0,
        k.transient.bits(),
        e.body.state.bits(),
    ];
    let vectors = [k.velocity, k.acceleration, k.omega, k.cached_velocity];
    words.extend(vectors.iter().flat_map(|v| v.to_array().map(f32::to_bits)));
    let shadows = e.body.shadows.iter().map(|s| s.id.0);
    words.extend(shadows);
    (e.body.position.frame.bits(), words, k.update_time.to_bits())
}
