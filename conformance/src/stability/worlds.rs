//! The worlds that generated scenes run on, made in memory.

use std::sync::{Arc, LazyLock};

use ac_client::dat::{
    AnimFrame, DatError, DatSet, MotionData, MotionTable, StoredFrame, TerrainWord,
    worldgen::{Axis, Rect, Room, RoomId, SetupBuilder, Side, WorldBuilder, block, prism, ramp},
};
use ac_client::math::Vec3;

const STYLE: u32 = 0x8000_003D;
const READY: u32 = 0x4100_0003;
const WALK: u32 = 0x4500_0005;
const RUN: u32 = 0x4400_0007;
const BACK: u32 = 0x4500_0006;
const TURN_RIGHT: u32 = 0x6500_000D;
const TURN_LEFT: u32 = 0x6500_000E;
const SIDE_RIGHT: u32 = 0x6500_000F;
const SIDE_LEFT: u32 = 0x6500_0010;

/// A world with everything that scenes need, and where it is.
#[derive(Debug, Clone)]
pub struct Playground {
    /// The world.
    pub source: Arc<DatSet>,
    /// The home block: level ground at 0 m with the obstacles named in [`spots`].
    pub home: u32,
    /// A block of slopes, ridges and cliffs.
    pub hills: u32,
    /// A block of rooms below the ground.
    pub rooms: u32,
    /// A block of houses; two of them stand in one cell, one at the eastern border.
    pub town: u32,
    /// A block whose eastern half is water; the block east of it is all water.
    pub shore: u32,
    /// Setup of a ball of radius 0.3 m.
    pub ball: u32,
    /// Setup of a walker of two spheres, 1.8 m high, that steps up 0.6 m.
    pub walker: u32,
    /// Setup of a ball whose radius is below the epsilon of collisions.
    pub speck: u32,
    /// Setup without spheres.
    pub ghost: u32,
    /// Setup of a crate of 2 m with a physics tree.
    pub crate_: u32,
    /// Setup of a cylinder, radius 1 m, 3 m high.
    pub pillar: u32,
    /// Setup of a sphere, radius 1.5 m.
    pub boulder: u32,
    /// Setup of a walker that steps up more than two of its radii.
    pub stilts: u32,
    /// Motion table of the walker.
    pub table: u32,
    /// Motion table without motions.
    pub empty_table: u32,
}

/// Places on the home block, landblock coordinates in metres.
pub mod spots {
    /// Open ground: nothing within 8 m.
    pub const OPEN: [f32; 3] = [30.0, 100.0, 0.0];
    /// x of a thin wall from y = 40 to 80, 6 m high, 5 cm thick.
    pub const WALL_X: f32 = 100.0;
    /// A point 2 m west of the middle of the wall.
    pub const WALL: [f32; 3] = [98.0, 60.0, 0.0];
    /// Inner corner of two walls (west and south of it is free).
    pub const CORNER: [f32; 3] = [150.0, 60.0, 0.0];
    /// Tip of a wedge of 20 degrees that opens to the west.
    pub const WEDGE: [f32; 3] = [160.0, 140.0, 0.0];
    /// West edges of steps, with their heights, m; each 4 m wide around y = 20.
    pub const STEPS: [(f32, f32); 6] = [
        (12.0, 0.3),
        (36.0, 0.59),
        (60.0, 0.6),
        (84.0, 0.61),
        (108.0, 1.0),
        (132.0, 1.3),
    ];
    /// West feet of ramps around y = 180, with rise over run: below, at and above the walkable limit.
    pub const RAMPS: [(f32, f32); 4] = [(12.0, 0.5), (48.0, 1.12), (84.0, 1.13), (120.0, 4.0)];
    /// Middle of a slab 1.7 m above the ground, 8 m wide.
    pub const CEILING: [f32; 3] = [60.0, 140.0, 0.0];
    /// Tip of a spike, 2 m above the ground.
    pub const SPIKE: [f32; 3] = [30.0, 140.0, 2.0];
    /// Middle of a crevice between two blocks 2 m high and 0.4 m apart.
    pub const CREVICE: [f32; 3] = [100.0, 140.0, 0.0];
}

/// Places on the block of rooms.
pub mod halls {
    /// Floor of the rooms, m.
    pub const FLOOR: f32 = -50.0;
    /// Half of the side of the closed room, m.
    pub const HALF: f32 = 4.0;
    /// Middle of the closed room's floor.
    pub const CLOSED: [f32; 3] = [40.0, 40.0, FLOOR];
    /// Low word of the closed room.
    pub const CLOSED_CELL: u32 = 0x0100;
    /// Middle of the first of eight thin rooms in a row to the north, each 0.3 m long.
    pub const ROW: [f32; 3] = [100.0, 100.0, FLOOR];
    /// Low word of the room before the thin ones.
    pub const ROW_CELL: u32 = 0x0101;
    /// How many rooms the row has, both end rooms included.
    pub const ROW_LENGTH: u32 = 10;
    /// Middle of a room that overlaps the next one in space; its low word follows the row's.
    pub const TRICK: [f32; 3] = [40.0, 120.0, FLOOR];
    /// Low word of that room.
    pub const TRICK_CELL: u32 = ROW_CELL + ROW_LENGTH;
}

/// Places on the block of houses.
pub mod houses {
    /// Middles of the floors of the houses, 6 m square, with a door of 2 m in the south; rooms are numbered in this order.
    pub const AT: [[f32; 3]; 3] = [[56.0, 52.0, 0.0], [65.0, 66.0, 0.0], [188.0, 60.0, 0.0]];
}

static PLAY: LazyLock<Result<Playground, DatError>> = LazyLock::new(|| playground(0x20, 0x20));
static MOVED: LazyLock<Result<Playground, DatError>> = LazyLock::new(|| playground(0x90, 0x51));

/// The playground; made once.
///
/// # Errors
/// When the generator cannot write it.
pub fn play() -> Result<&'static Playground, &'static DatError> {
    PLAY.as_ref()
}

/// The same playground elsewhere on the map.
///
/// # Errors
/// When the generator cannot write it.
pub fn moved() -> Result<&'static Playground, &'static DatError> {
    MOVED.as_ref()
}

/// Builds the playground with its home block at (x, y).
fn playground(x: u8, y: u8) -> Result<Playground, DatError> {
    let mut world = WorldBuilder::new();
    let body = world.solid(&block(Vec3::new(-0.3, -0.3, 0.0), Vec3::new(0.3, 0.3, 0.6)));
    let ball = |radius: f32| {
        SetupBuilder::new()
            .part(body, StoredFrame::IDENTITY)
            .sphere(Vec3::new(0.0, 0.0, radius), radius)
            .size(2.0 * radius, radius)
            .steps(0.2, 0.2)
    };
    let table = walker_table(&mut world);
    let empty_table = world.motion_table(MotionTable::new(0, STYLE).with_style(STYLE, READY));
    let crate_shape = world.solid(&block(Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 2.0)));
    let shape = || SetupBuilder::new().part(body, StoredFrame::IDENTITY);
    let (ball_setup, speck) = (world.setup(ball(0.3)), world.setup(ball(5e-5)));
    let walker = world.setup(SetupBuilder::humanoid(body, 1.8, 0.4).motion_table(table));
    let stilts = world.setup(
        SetupBuilder::humanoid(body, 1.8, 0.4)
            .steps(1.2, 1.5)
            .motion_table(table),
    );
    let ghost = world.setup(shape());
    let crate_ = world.setup(SetupBuilder::of_shape(crate_shape).size(2.0, 1.5));
    let pillar = world.setup(shape().cyl_sphere(Vec3::ZERO, 1.0, 3.0).size(3.0, 1.0));
    let boulder = world.setup(shape().sphere(Vec3::new(0.0, 0.0, 1.5), 1.5).size(3.0, 1.5));
    obstacles(&mut world, x, y);
    hills(&mut world, x + 4, y);
    rooms(&mut world, x + 8, y);
    town(&mut world, x + 12, y);
    shore(&mut world, x + 16, y);
    for (cx, cy) in [(0, 0), (0, 0xFE), (0xFE, 0), (0xFE, 0xFE)] {
        world.block(cx, cy);
    }
    let id = |x: u8, y: u8| u32::from(x) << 24 | u32::from(y) << 16;
    Ok(Playground {
        source: Arc::new(world.surround().build()?),
        home: id(x, y),
        hills: id(x + 4, y),
        rooms: id(x + 8, y),
        town: id(x + 12, y),
        shore: id(x + 16, y),
        ball: ball_setup,
        walker,
        speck,
        ghost,
        crate_,
        pillar,
        boulder,
        stilts,
        table,
        empty_table,
    })
}

/// Ready, walk, run, back, turns and side-steps; everything moves by velocity.
fn walker_table(world: &mut WorldBuilder) -> u32 {
    let pose = || {
        (
            AnimFrame {
                parts: vec![StoredFrame::IDENTITY],
                hooks: Vec::new(),
            },
            None,
        )
    };
    let stand = world.animation(1, (0..4).map(|_| pose()));
    let step = world.animation(1, (0..12).map(|_| pose()));
    let moving = |velocity: Vec3| MotionData::playing(step, 0, -1, 30.0).with_velocity(velocity);
    let turning =
        |turn: f32| MotionData::playing(step, 0, -1, 30.0).with_omega(Vec3::new(0.0, 0.0, turn));
    let still = || MotionData::playing(stand, 0, -1, 10.0);
    let link = || MotionData::playing(step, 0, 3, 30.0);
    let table = MotionTable::new(0, STYLE)
        .with_style(STYLE, READY)
        .with_cycle(STYLE, READY, still())
        .with_cycle(STYLE, WALK, moving(Vec3::new(0.0, 3.12, 0.0)))
        .with_cycle(STYLE, RUN, moving(Vec3::new(0.0, 4.0, 0.0)))
        .with_cycle(STYLE, BACK, moving(Vec3::new(0.0, -2.0, 0.0)))
        .with_modifier(TURN_RIGHT, turning(-1.5))
        .with_modifier(TURN_LEFT, turning(1.5))
        .with_modifier(SIDE_RIGHT, moving(Vec3::new(1.25, 0.0, 0.0)))
        .with_modifier(SIDE_LEFT, moving(Vec3::new(-1.25, 0.0, 0.0)))
        .with_cycle(STYLE, TURN_RIGHT, turning(-1.5))
        .with_cycle(STYLE, TURN_LEFT, turning(1.5))
        .with_cycle(STYLE, SIDE_RIGHT, moving(Vec3::new(1.25, 0.0, 0.0)))
        .with_cycle(STYLE, SIDE_LEFT, moving(Vec3::new(-1.25, 0.0, 0.0)))
        .with_link(STYLE, READY, WALK, link())
        .with_link(STYLE, WALK, READY, link());
    world.motion_table(table)
}

fn obstacles(world: &mut WorldBuilder, x: u8, y: u8) {
    use spots::*;
    let boxed = |world: &mut WorldBuilder, low: [f32; 3], high: [f32; 3]| {
        world.solid(&block(low.into(), high.into()))
    };
    let wall = boxed(world, [-0.025, -20.0, 0.0], [0.025, 20.0, 6.0]);
    let long = boxed(world, [-10.0, -0.25, 0.0], [10.0, 0.25, 4.0]);
    let slab = boxed(world, [-4.0, -4.0, 0.0], [4.0, 4.0, 0.5]);
    let bank = boxed(world, [-4.0, -2.0, 0.0], [4.0, 0.0, 2.0]);
    let steps: Vec<u32> = STEPS
        .iter()
        .map(|(_, height)| boxed(world, [0.0, -2.0, 0.0], [4.0, 2.0, *height]))
        .collect();
    let ramps: Vec<u32> = RAMPS
        .iter()
        .map(|(_, rise)| world.solid(&ramp(8.0, 6.0, 8.0 * rise)))
        .collect();
    let spike = world.solid(&prism(
        &[[-0.3, 0.0], [0.3, 0.0], [0.0, 2.0]],
        Axis::Y,
        -0.3,
        0.3,
    ));
    let home = world.block(x, y);
    home.object(wall, Vec3::new(WALL_X, 60.0, 0.0), 0.0);
    // North and east of the corner.
    home.object(
        long,
        Vec3::new(CORNER[0] - 9.75, CORNER[1] + 0.25, 0.0),
        0.0,
    );
    home.object(
        long,
        Vec3::new(CORNER[0] + 0.25, CORNER[1] - 9.75, 0.0),
        90.0,
    );
    for turn in [10.0_f32, -10.0] {
        let (s, c) = turn.to_radians().sin_cos();
        home.object(
            long,
            Vec3::new(WEDGE[0] - 10.0 * c, WEDGE[1] - 10.0 * s, 0.0),
            turn,
        );
    }
    for ((at, _), model) in STEPS.iter().zip(steps) {
        home.object(model, Vec3::new(*at, 20.0, 0.0), 0.0);
    }
    for ((at, _), model) in RAMPS.iter().zip(ramps) {
        home.object(model, Vec3::new(*at, 176.0, 0.0), 0.0);
    }
    home.object(slab, Vec3::new(CEILING[0], CEILING[1], 1.7), 0.0);
    home.object(spike, Vec3::new(SPIKE[0], SPIKE[1], 0.0), 0.0);
    home.object(bank, Vec3::new(CREVICE[0], CREVICE[1] - 0.2, 0.0), 0.0);
    home.object(bank, Vec3::new(CREVICE[0], CREVICE[1] + 2.2, 0.0), 0.0);
}

/// Columns of vertices: level, a gentle slope, a slope at the limit, a cliff, a ridge.
fn hills(world: &mut WorldBuilder, x: u8, y: u8) {
    const PROFILE: [u8; 9] = [0, 0, 4, 17, 17, 217, 217, 0, 0];
    world.block(x, y).heights(|column, _| PROFILE[column]);
    world.block(x + 1, y).heights(|_, _| 0);
}

fn rooms(world: &mut WorldBuilder, x: u8, y: u8) {
    use halls::*;
    let door = Rect {
        u: [-1.0, 1.0],
        v: [0.0, 2.5],
    };
    let closed = Room::new(Vec3::new(-HALF, -HALF, 0.0), Vec3::new(HALF, HALF, 4.0));
    let end =
        |side| Room::new(Vec3::new(-3.0, -3.0, 0.0), Vec3::new(3.0, 3.0, 3.0)).doorway(side, door);
    let thin = Room::new(Vec3::new(-3.0, -0.15, 0.0), Vec3::new(3.0, 0.15, 3.0))
        .doorway(Side::South, door)
        .doorway(Side::North, door);
    let environment = world.environment(&[closed, end(Side::North), thin, end(Side::South)]);
    let home = world.block(x, y);
    home.room(environment, 0, StoredFrame::at(CLOSED.into()), 0);
    let at = |north: f32| StoredFrame::at(Vec3::new(ROW[0], ROW[1] + north, ROW[2]));
    let mut row: Vec<RoomId> = vec![home.room(environment, 1, at(-3.15), 1)];
    for i in 0..ROW_LENGTH - 2 {
        row.push(home.room(environment, 2, at(i as f32 * 0.3), 2));
    }
    row.push(home.room(environment, 3, at((ROW_LENGTH - 2) as f32 * 0.3 + 2.85), 1));
    for (i, pair) in row.windows(2).enumerate() {
        let out = u16::from(i > 0);
        home.connect((pair[0], out), (pair[1], 0));
    }
    // Two rooms that share space: one door leads into the other, which begins inside the first.
    let trick = world.environment(&[
        Room::new(Vec3::new(-4.0, -4.0, 0.0), Vec3::new(4.0, 4.0, 3.0)).doorway(Side::North, door),
        Room::new(Vec3::new(-4.0, -4.0, 0.0), Vec3::new(4.0, 4.0, 3.0)).doorway(Side::South, door),
    ]);
    let home = world.block(x, y);
    let one = home.room(trick, 0, StoredFrame::at(TRICK.into()), 1);
    let two = home.room(
        trick,
        1,
        StoredFrame::at(Vec3::new(TRICK[0] + 1.0, TRICK[1] + 4.0, TRICK[2])),
        1,
    );
    home.connect((one, 0), (two, 0));
}

/// Houses of one room with an open door, and walls of boxes around it.
fn town(world: &mut WorldBuilder, x: u8, y: u8) {
    let door = Rect {
        u: [-1.0, 1.0],
        v: [0.0, 2.5],
    };
    let room =
        Room::new(Vec3::new(-3.0, -3.0, 0.0), Vec3::new(3.0, 3.0, 3.0)).doorway(Side::South, door);
    let environment = world.environment(&[room]);
    let mut walls = Vec::new();
    for (low, high) in [
        ([-3.3, -3.3, 0.0], [-3.0, 3.3, 3.0]),
        ([3.0, -3.3, 0.0], [3.3, 3.3, 3.0]),
        ([-3.0, 3.0, 0.0], [3.0, 3.3, 3.0]),
        ([-3.0, -3.3, 0.0], [-1.0, -3.0, 3.0]),
        ([1.0, -3.3, 0.0], [3.0, -3.0, 3.0]),
        ([-3.3, -3.3, 3.0], [3.3, 3.3, 3.3]),
    ] {
        walls.extend(block(Vec3::from(low), Vec3::from(high)));
    }
    let shell = world.solid(&walls);
    let home = world.block(x, y);
    for at in houses::AT {
        let frame = StoredFrame::at(at.into());
        let room = home.room(environment, 0, frame, 1);
        home.building(shell, frame, &[(room, 0, &[room])]);
    }
}

/// Water from the middle column on, and a block that is nothing else.
fn shore(world: &mut WorldBuilder, x: u8, y: u8) {
    let (land, water) = (TerrainWord::new(0, 1, 0), TerrainWord::new(0, 20, 0));
    world
        .block(x, y)
        .terrain(|column, _| if column > 3 { water } else { land });
    world.block(x + 1, y).terrain(|_, _| water);
}
