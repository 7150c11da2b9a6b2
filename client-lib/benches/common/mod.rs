//! Worlds whose tick is measured, set up as scenes do it: benches, the allocation test and the cost table share them.

#![allow(dead_code, reason = "each user of this module needs a part of it")]

use std::sync::{Arc, LazyLock};

use ac_client::dat::{DatSet, Strictness};
use ac_client::entity::Weenie;
use ac_client::frame::{NoHost, Pipeline};
use ac_client::math::{CellId, Position, Quat, Vec3};
use ac_client::motion::{Command, HoldKey, Movement, MovementParameters};
use ac_client::physics::body::{EntityId, WeenieFlags};
use ac_client::profile::Profile;
use ac_client::world::{World, WorldSource};

/// Length of a frame, s: above the gate of the tick, so that every frame is one quantum.
pub const FRAME: f64 = 0.04;

const FORWARD: Command = Command(0x4500_0005);
const READY: Command = Command(0x4100_0003);
const START: f64 = 1000.0;

/// Flat ground, rolling ground, and a room of a dungeon.
const FLAT: CellId = CellId(0xA9B4_0012);
const ROLLING: CellId = CellId(0xABB6_0025);
const ROOM: CellId = CellId(0x0D01_0100);

/// Setup, motion table and state of an entity.
#[derive(Clone, Copy)]
pub struct Kind {
    setup: u32,
    table: u32,
    state: u32,
    player: bool,
    creature: bool,
    friction: f32,
}

/// A humanoid player.
pub const PLAYER: Kind = Kind {
    setup: 0x0200_0001,
    table: 0x0900_0001,
    state: 0x0040_0C08,
    player: true,
    creature: true,
    friction: 0.95,
};
/// A small creature.
pub const CREATURE: Kind = Kind {
    setup: 0x0200_0002,
    table: 0x0900_0002,
    player: false,
    ..PLAYER
};
/// A ball without motion table.
pub const BALL: Kind = Kind {
    setup: 0x0200_000D,
    table: 0,
    state: 0x0000_0408,
    player: false,
    creature: false,
    friction: 0.95,
};

/// The files of the test world, opened once.
static FILES: LazyLock<Arc<DatSet>> = LazyLock::new(|| {
    let folder = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../golden-traces/worlds/testbed"
    );
    Arc::new(DatSet::open(folder, Strictness::Lenient).expect("the test world opens"))
});

/// A world that is ticked frame by frame.
pub struct Case {
    /// The world.
    pub world: World,
    pipeline: Pipeline,
    frame: u32,
    next_guid: u32,
    /// Those that move: they turn, and their records of a frame are cleared.
    pub moving: Vec<EntityId>,
    /// Every so many frames (0: never) they turn by `turn` degrees.
    turn_every: u32,
    turn: f32,
    heading: f32,
    /// Turning is by velocity, not by heading.
    slides: bool,
}

impl Case {
    fn new() -> Self {
        let source: Arc<dyn WorldSource> = Arc::<DatSet>::clone(&FILES);
        Self {
            world: World::with_source(Profile::retail(), START, source),
            pipeline: Pipeline::default(),
            frame: 0,
            next_guid: 0,
            moving: Vec::new(),
            turn_every: 0,
            turn: 0.0,
            heading: 0.0,
            slides: false,
        }
    }

    /// One entity at a place where there is room.
    pub fn add(&mut self, kind: Kind, cell: CellId, origin: Vec3) -> EntityId {
        self.try_add(kind, cell, origin).expect("there is room")
    }

    /// One entity at a place, if there is room.
    fn try_add(&mut self, kind: Kind, cell: CellId, origin: Vec3) -> Option<EntityId> {
        let world = &mut self.world;
        let guid = 0x5000_0001 + self.next_guid;
        self.next_guid += 1;
        let id = world
            .make_object(kind.setup, guid, true)
            .expect("the setup is there");
        world.entities.register(id, guid);
        let entered = world.with_entity(id, |entity, world| {
            entity.body.weenie = WeenieFlags {
                present: true,
                player: kind.player,
                creature: kind.creature,
                ..WeenieFlags::default()
            };
            entity.weenie = Some(Weenie {
                run_rate: Some(1.5),
                jump_velocity: Some(9.0),
                can_jump: true,
                jump_stamina_cost: Some(0),
                ..Weenie::default()
            });
            if kind.table != 0 {
                entity.set_motion_table(kind.table, world);
            }
            entity.set_state(kind.state, world);
            entity.kin.friction = kind.friction;
            let place = Position::new(cell, origin, Quat::IDENTITY);
            entity.enter_world_at(&place, true, world)
        });
        if entered != Some(true) {
            world.forget(id);
            world.entities.remove(id);
            return None;
        }
        Some(id)
    }

    /// Starts a motion: of the local input for a hold key, else of the server.
    pub fn perform(&mut self, id: EntityId, command: Command, hold: Option<HoldKey>) {
        let mut parameters = MovementParameters {
            speed: 1.0,
            ..MovementParameters::new(&self.world.profile)
        };
        let movement = match hold {
            Some(hold) => {
                parameters.hold_key = hold;
                Movement::Raw(command, parameters)
            }
            None => Movement::Interpreted(command, parameters),
        };
        self.world.with_entity(id, |entity, world| {
            entity.kin.last_move_was_autonomous = hold.is_some();
            entity
                .perform_movement(&movement, world)
                .expect("the motion is allowed");
        });
    }

    /// Advances the world by one frame.
    pub fn step(&mut self) {
        self.frame += 1;
        for &id in &self.moving {
            self.world.entities.begin_frame(id);
        }
        if self.turn_every != 0 && self.frame.is_multiple_of(self.turn_every) {
            self.turn_all();
        }
        let now = START + f64::from(self.frame) * FRAME;
        self.pipeline.run_frame(&mut self.world, now, &mut NoHost);
    }

    fn turn_all(&mut self) {
        self.heading = (self.heading + self.turn) % 360.0;
        let spread = 360.0 / self.moving.len() as f32;
        for (i, &id) in self.moving.iter().enumerate() {
            let heading = (self.heading + spread * i as f32) % 360.0;
            let slides = self.slides;
            self.world.with_entity(id, |entity, world| {
                if slides {
                    entity.set_velocity(-entity.kin.velocity, world);
                } else {
                    entity.set_heading(heading, world);
                }
            });
        }
    }

    /// Runs many frames.
    pub fn run(&mut self, frames: u32) {
        for _ in 0..frames {
            self.step();
        }
    }
}

/// An object that has come to rest.
pub fn resting() -> Case {
    let mut case = Case::new();
    let id = case.add(BALL, FLAT, Vec3::new(60.0, 24.0, 20.0));
    case.moving.push(id);
    case
}

/// An object that slides to and fro on the ground without friction.
pub fn sliding() -> Case {
    let mut case = Case::new();
    let kind = Kind {
        friction: 0.0,
        ..BALL
    };
    let id = case.add(kind, FLAT, Vec3::new(60.0, 24.0, 20.0));
    case.run(20);
    case.world.with_entity(id, |entity, world| {
        entity.set_velocity(Vec3::new(0.0, 4.0, 0.0), world);
    });
    case.moving.push(id);
    case.turn_every = 100;
    case.slides = true;
    case
}

/// Creatures that stand and breathe, `count` of them.
pub fn idle_npcs(count: usize) -> Case {
    let mut case = Case::new();
    for i in 0..count {
        let at = Vec3::new(
            10.0 + 2.0 * (i % 40) as f32,
            10.0 + 2.0 * (i / 40) as f32,
            20.0,
        );
        let id = case.add(CREATURE, cell_of(at), at);
        case.perform(id, READY, None);
        case.moving.push(id);
    }
    case
}

/// A player that walks to and fro on flat ground.
pub fn walking() -> Case {
    let mut case = Case::new();
    let id = case.add(PLAYER, FLAT, Vec3::new(60.0, 24.0, 20.0));
    case.perform(id, FORWARD, Some(HoldKey::None));
    case.moving.push(id);
    (case.turn_every, case.turn) = (100, 180.0);
    case
}

/// A player that runs to and fro on rolling ground.
pub fn running_on_slopes() -> Case {
    let mut case = Case::new();
    let id = case.add(PLAYER, ROLLING, Vec3::new(96.0, 96.0, 16.0));
    case.perform(id, FORWARD, Some(HoldKey::Run));
    case.moving.push(id);
    (case.turn_every, case.turn) = (100, 135.0);
    case
}

/// A player that runs in squares in a room of a dungeon.
pub fn running_in_a_room() -> Case {
    let mut case = Case::new();
    let id = case.add(PLAYER, ROOM, Vec3::new(40.0, -42.0, -12.0));
    case.perform(id, FORWARD, Some(HoldKey::Run));
    case.moving.push(id);
    (case.turn_every, case.turn) = (20, 90.0);
    case
}

/// A player that runs along a wall, obliquely into it.
pub fn against_a_wall() -> Case {
    let mut case = running_in_a_room();
    case.turn_every = 0;
    let id = case.moving[0];
    case.world
        .with_entity(id, |entity, world| entity.set_heading(30.0, world));
    case
}

/// Creatures that run about in a narrow place.
pub fn crowd(count: usize) -> Case {
    let mut case = Case::new();
    for i in 0..count {
        let at = Vec3::new(
            60.0 + 1.5 * (i % 8) as f32,
            60.0 + 1.5 * (i / 8) as f32,
            20.0,
        );
        let id = case.add(CREATURE, cell_of(at), at);
        case.perform(id, FORWARD, Some(HoldKey::Run));
        case.moving.push(id);
    }
    (case.turn_every, case.turn) = (25, 97.0);
    case
}

/// Objects at rest, `count` of them, and far from them players that walk, `walkers` of them.
pub fn mostly_idle(count: usize, walkers: usize) -> Case {
    let mut case = Case::new();
    for i in 0..count {
        let at = Vec3::new(
            2.0 + 1.5 * (i % 125) as f32,
            74.0 + 1.4 * (i / 125) as f32,
            20.0,
        );
        // Something stands in some of the places.
        case.try_add(BALL, cell_of(at), at);
    }
    for i in 0..walkers {
        let at = Vec3::new(20.0 + 5.0 * i as f32, 24.0, 20.0);
        let id = case.add(PLAYER, cell_of(at), at);
        case.perform(id, FORWARD, Some(HoldKey::None));
        case.moving.push(id);
    }
    (case.turn_every, case.turn) = (100, 180.0);
    case
}

/// Cell of the flat block at a place in it.
fn cell_of(at: Vec3) -> CellId {
    let (x, y) = ((at.x / 24.0) as u32, (at.y / 24.0) as u32);
    CellId(FLAT.0 & 0xFFFF_0000 | (x * 8 + y + 1))
}
