//! Body of the fuzz target `world` in `fuzz/`. It is here so that a deterministic smoke of the very same body runs with the tests.
//!
//! The bytes are a recipe: a small world (terrain, rooms, static objects), a handful of entities, and what happens to them. Whatever it says,
//! nothing panics, every frame ends, and finite numbers stay finite.

use std::sync::Arc;

use crate::dat::worldgen::{
    Rect, Room, SetupBuilder, Side, WorldBuilder, block, prism, ramp, rectangle, yaw,
};
use crate::dat::{DatSet, StoredFrame, TerrainWord};
use crate::entity::{Child, Entity, Weenie};
use crate::frame::pipeline::{NoHost, Pipeline};
use crate::math::{CellId, Frame, Position, Vec3};
use crate::motion::MovementParameters;
use crate::physics::attachment::Attachment;
use crate::physics::body::{EntityId, WeenieFlags};
use crate::physics::placement::{PlacementFlags, SetPosition};
use crate::physics::state::TransientState;
use crate::profile::Profile;
use crate::world::{Random, World};

/// Block of the world.
const BLOCK: u32 = 0x1020_0000;
/// Longest recipe, in actions.
const MAX_ACTIONS: usize = 48;

/// A recipe; it goes on with zeros when it is used up.
pub(crate) struct Recipe<'a>(pub(crate) &'a [u8]);

impl Recipe<'_> {
    pub(crate) fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else {
            return 0;
        };
        self.0 = rest;
        first
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        usize::from(self.byte()) % n.max(1)
    }

    /// A number in [-1, 1] with 16 bits.
    pub(crate) fn unit(&mut self) -> f32 {
        f32::from(i16::from_le_bytes([self.byte(), self.byte()])) / 32768.0
    }

    pub(crate) fn vector(&mut self, reach: f32) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * reach
    }

    pub(crate) fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }

    pub(crate) fn ended(&self) -> bool {
        self.0.is_empty()
    }
}

/// Places of a landblock: on the ground somewhere, indoors, or off to a strange cell.
fn place(recipe: &mut Recipe<'_>) -> Position {
    let kind = recipe.below(16);
    let around = recipe.vector(1.0);
    let (cell, origin) = match kind {
        0 | 1 => (
            0x0100 + u32::from(recipe.byte() % 4),
            Vec3::new(96.0, 96.0, -49.0) + around * Vec3::new(5.0, 12.0, 3.0),
        ),
        2 => (
            u32::from(recipe.byte()) << 8 | u32::from(recipe.byte()),
            around * 300.0,
        ),
        3 => (1, Vec3::new(96.0, 96.0, 6.0) + around * 250.0),
        _ => {
            let at = Vec3::new(60.0, 60.0, 4.0) + around * Vec3::new(40.0, 40.0, 6.0);
            let cell = 1 + ((at.x / 24.0) as u32) * 8 + (at.y / 24.0) as u32;
            (cell, at)
        }
    };
    let mut place = Position::new(
        CellId(BLOCK | cell & 0xFFFF),
        origin,
        yaw(recipe.unit() * 180.0),
    );
    if kind == 4 {
        place.cell.0 = 0xFEFE_0000 | place.cell.0 & 0xFFFF;
    }
    place
}

/// Setups of [`build`], in order.
const SETUPS: usize = 9;

fn add_setups(world: &mut WorldBuilder) -> Vec<u32> {
    let v = Vec3::new;
    let cube = world.solid(&block(v(-1.0, -1.0, 0.0), v(1.0, 1.0, 2.0)));
    let slope = world.solid(&ramp(6.0, 3.0, 2.0));
    let roof = world.solid(&prism(
        &[[-2.0, 0.0], [2.0, 0.0], [0.0, 3.0]],
        crate::dat::worldgen::Axis::Y,
        -2.0,
        2.0,
    ));
    let square = Rect {
        u: [-3.0, 3.0],
        v: [-3.0, 3.0],
    };
    let plate = world.solid(&[rectangle(crate::dat::worldgen::Axis::Z, 1.0, square, true)]);
    let setups = [
        SetupBuilder::humanoid(cube, 1.8, 0.48),
        SetupBuilder::new().sphere(v(0.0, 0.0, 0.1), 0.1),
        SetupBuilder::of_shape(cube),
        SetupBuilder::of_shape(slope),
        SetupBuilder::of_shape(roof),
        SetupBuilder::of_shape(plate),
        SetupBuilder::new()
            .cyl_sphere(Vec3::ZERO, 0.6, 2.0)
            .size(2.0, 0.6),
        SetupBuilder::new()
            .sphere(v(0.0, 0.0, 0.7), 0.7)
            .steps(0.4, 0.4),
        // No collision shape at all.
        SetupBuilder::new().part(cube, StoredFrame::IDENTITY),
    ];
    setups.map(|s| world.setup(s)).to_vec()
}

fn build(recipe: &mut Recipe<'_>) -> Option<(DatSet, Vec<u32>)> {
    let mut world = WorldBuilder::new();
    let setups = add_setups(&mut world);
    let door = Rect {
        u: [-1.0, 1.0],
        v: [0.0, 2.5],
    };
    let (low, high) = (Vec3::new(-4.0, -4.0, 0.0), Vec3::new(4.0, 4.0, 3.0));
    let rooms = world.environment(&[
        Room::new(low, high).doorway(Side::North, door),
        Room::new(low, high)
            .doorway(Side::South, door)
            .doorway(Side::North, door),
        Room::new(low, high).doorway(Side::South, door),
    ]);
    let home = world.block(0x10, 0x20);
    let (relief, step) = (recipe.below(4), recipe.byte());
    home.heights(|x, y| match relief {
        0 => 0,
        1 => (x as u8).wrapping_mul(step) % 12,
        2 => ((x * y) as u8).wrapping_mul(step) % 40,
        _ => (x as u8 ^ y as u8).wrapping_mul(step),
    });
    let wet = recipe.byte();
    home.terrain(|x, y| TerrainWord::new(0, ((x as u8 + y as u8) & wet) % 32, 0));
    for _ in 0..recipe.below(8) {
        let model = recipe.pick(&setups);
        let at = Vec3::new(60.0, 60.0, 2.0) + recipe.vector(1.0) * Vec3::new(30.0, 30.0, 4.0);
        home.object(model, at, recipe.unit() * 180.0);
    }
    let at = |y: f32| StoredFrame::at(Vec3::new(96.0, y, -50.0));
    let a = home.room(rooms, 0, at(96.0), 1);
    let b = home.room(rooms, 1, at(104.0), 2);
    let c = home.room(rooms, 2, at(112.0), 1);
    home.connect((a, 0), (b, 0)).connect((b, 1), (c, 0));
    Some((world.surround().build().ok()?, setups))
}

/// State words worth trying: solid, BSP, missile, ethereal, ignoring, hidden, frozen, sledding, static, inelastic.
const STATES: [u32; 12] = [
    0x0040_0408,
    0x0001_0408,
    0x0000_0748,
    0x0000_040C,
    0x0000_0418,
    0x0000_4418,
    0x0100_0408,
    0x0080_0408,
    0x0000_0409,
    0x0002_0408,
    0x0040_0008,
    0x0001_0409,
];

fn create(world: &mut World, setup: u32, guid: u32, recipe: &mut Recipe<'_>) -> Option<EntityId> {
    let id = world.make_object(setup, guid, true).ok()?;
    world.entities.register(id, guid);
    let kind = recipe.byte();
    world.with_entity(id, |entity, world| {
        entity.body.weenie = WeenieFlags {
            present: true,
            player: kind & 1 != 0,
            creature: kind & 2 != 0,
            ..WeenieFlags::default()
        };
        entity.weenie = Some(Weenie {
            run_rate: Some(1.0),
            jump_velocity: Some(5.0),
            can_jump: true,
            ..Weenie::default()
        });
        entity.set_state(recipe.pick(&STATES), world);
        entity.set_scale_static(recipe.pick(&[1.0, 1.0, 0.5, 2.0, 1.5, 100.0]));
        let velocity = recipe.vector(60.0);
        entity.set_velocity(velocity, world);
        entity.enter_world_at(&place(recipe), kind & 4 != 0, world);
    });
    Some(id)
}

fn act(entity: &mut Entity, others: &[EntityId], recipe: &mut Recipe<'_>, world: &mut World) {
    let other = recipe.pick(others);
    let guid = world.entity(other).map_or(entity.guid(), Entity::guid);
    match recipe.below(18) {
        0 | 1 => entity.set_velocity(recipe.vector(60.0), world),
        2 => entity.set_velocity(recipe.vector(8.0), world),
        3 => entity.set_state(recipe.pick(&STATES), world),
        4 => {
            let flags = recipe.pick(&[0x1012, 0x1002, 0x112, 0x212, 0x22, 0x302]);
            let to = SetPosition {
                range_x: 3.0,
                range_y: 3.0,
                tries: 4,
                ..SetPosition::new(place(recipe), PlacementFlags::from_bits_retain(flags))
            };
            // A carried object is moved by its parent alone; a placement does not ask.
            if entity.body.parent.is_none() {
                entity.set_position(&to, world);
            }
        }
        5 => entity.interpolate_to(&place(recipe), recipe.byte() & 1 != 0, world),
        6 => entity.stick_to_object(guid, world),
        7 => {
            let to = entity.body.position;
            let (start, max) = (recipe.unit() * 10.0, recipe.unit() * 10.0);
            entity.constrain_to(&to, start, max, world);
        }
        8 => {
            let frame = Frame::new(recipe.vector(2.0), yaw(recipe.unit() * 180.0));
            let part = recipe.pick(&[Child::NO_PART, 0, 1]);
            entity.set_parent(other, Attachment::Part { part, frame }, world);
        }
        9 => entity.unset_parent(world),
        10 => entity.leave_world(world),
        11 => {
            // Entering is for objects that are outside; one that is in the world would keep its cell when refused.
            let (slide, to) = (recipe.byte() & 1 != 0, place(recipe));
            if entity.body.cell.is_none() {
                entity.enter_world_at(&to, slide, world);
            }
        }
        12 => entity.set_heading(recipe.unit() * 720.0, world),
        13 => entity.kin.omega = recipe.vector(40.0),
        14 => {
            let params = MovementParameters::new(&world.profile);
            entity.move_to_position(&place(recipe), &params, world);
        }
        15 => {
            let params = MovementParameters::new(&world.profile);
            entity.move_to_object(guid, &params, world);
        }
        16 => {
            // A refused jump changes nothing.
            let _ = entity.jump(recipe.unit().abs(), world);
        }
        _ => entity.unparent_children(world),
    }
}

/// Runs a recipe under every profile.
pub fn world(data: &[u8]) {
    let mut recipe = Recipe(data);
    let Some((dats, setups)) = build(&mut recipe) else {
        return;
    };
    let dats = Arc::new(dats);
    for name in Profile::NAMES {
        let profile = Profile::named(name).unwrap_or_default();
        live(&mut Recipe(recipe.0), profile, Arc::clone(&dats), &setups);
    }
}

fn live(recipe: &mut Recipe<'_>, profile: Profile, dats: Arc<DatSet>, setups: &[u32]) {
    debug_assert_eq!(setups.len(), SETUPS);
    let mut world = World::with_source(profile, 100.0, dats);
    world.random = Random::Seeded(u64::from(recipe.byte()));
    let mut ids = Vec::new();
    for n in 0..1 + recipe.below(4) {
        let setup = recipe.pick(setups);
        ids.extend(create(&mut world, setup, 0x8000_0001 + n as u32, recipe));
    }
    let Some(&first) = ids.first() else { return };
    if recipe.byte() & 1 != 0 {
        world.local_player = Some(first);
    }
    let (mut pipeline, mut now) = (Pipeline::default(), 100.0);
    for _ in 0..MAX_ACTIONS {
        let id = recipe.pick(&ids);
        world.with_entity(id, |entity, world| act(entity, &ids, recipe, world));
        if recipe.byte() == 0xFF {
            world.destroy_entity(id);
        }
        now += recipe.pick(&[0.05, 0.034, 0.1, 0.25, 0.0, 0.01, 0.7, 2.5]);
        pipeline.run_frame(&mut world, now, &mut NoHost);
        // Some have been out of sight for too long.
        let ends = |id: &EntityId| world.entity(*id).is_some() || world.entities.is_registered(*id);
        ids.retain(ends);
        check(&mut world, &ids);
        if ids.is_empty() {
            break;
        }
        if recipe.ended() {
            break;
        }
    }
}

/// What always holds of the entities of a world (`spec/06-physics-object.md`, H3: 8, 11), and that numbers are numbers.
fn check(world: &mut World, ids: &[EntityId]) {
    for &id in ids {
        let name = world.profile.name;
        let Some(entity) = world.entity_mut(id) else {
            panic!("an entity was not put back");
        };
        let frame = &entity.body.position.frame;
        assert!(
            frame.origin.is_finite() && entity.kin.velocity.is_finite(),
            "{}: {} at {:?}, {:?}",
            name,
            id.0,
            frame.origin,
            entity.kin.velocity
        );
        let transient = entity.kin.transient;
        assert!(
            transient.contains(TransientState::CONTACT)
                || !transient.contains(TransientState::ON_WALKABLE),
            "on walkable ground without contact"
        );
        entity.events.clear();
        entity.steps.clear();
        entity.touched.clear();
        entity.reports.clear();
        check_membership(world, id);
    }
}

/// An object is in the list of its cell once, and each of its shadows is in the list of its cell once (H3, 11). Profile `retail` only: the
/// others' lists can hold an object twice.
pub(crate) fn check_membership(world: &World, id: EntityId) {
    let Some(entity) = world.entity(id) else {
        return;
    };
    if world.profile.name != "retail" {
        return;
    }
    let own = entity.object_ref();
    let body = &entity.body;
    let base = |cell| world.land.cell(cell).map(|c| c.base());
    if let Some(cell) = body.cell {
        let base = base(cell).expect("the cell of an object is loaded");
        assert_eq!(base.objects.iter().filter(|&&o| o == own).count(), 1);
        assert_eq!(body.position.cell, base.id, "cell of the position");
    }
    for shadow in &body.shadows {
        let Some(cell) = shadow.cell else { continue };
        let base = base(cell).expect("cells of shadows are loaded");
        assert_eq!(base.shadows.iter().filter(|&&o| o == own).count(), 1);
    }
}
