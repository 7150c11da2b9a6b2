//! Worlds and scenes drawn by chance.

use std::sync::Arc;

use ac_client::dat::worldgen::{Face, Rect, Room, SetupBuilder, Side, WorldBuilder, block, yaw};
use ac_client::dat::{
    AnimFrame, AnimationHook, DatSet, HookAction, HookDirection, MotionData, MotionTable,
    StoredFrame, TerrainWord,
};
use ac_client::math::Vec3;
use ac_golden_traces::Scene;
use ac_golden_traces::scene::{
    Action, EntityKind, EntitySpec, FrameRun, HoldKey, MoveParams, OffsetSpec, PositionSpec,
    ScriptStep,
};
use proptest::prelude::*;

/// South-western block of the drawn ones, and how far the others are from it, along both sides: neighbours, and some that the window of
/// landblocks does not hold at the same time.
const CORNER: (u8, u8) = (0x40, 0x50);
const OFFSETS: [u8; SIDE as usize] = [0, 1, 6, 13];
const SIDE: u8 = 4;
const START: f64 = 1000.0;
const STYLE: u32 = 0x8000_003D;
const READY: u32 = 0x4100_0003;
const WALK: u32 = 0x4500_0005;

/// A place on the map: block, and metres in it.
#[derive(Debug, Clone, Copy)]
pub struct Spot {
    block: (u8, u8),
    at: (f32, f32),
}

/// What the landscape of a drawn world is made of.
#[derive(Debug, Clone)]
pub struct Land {
    slope: (u8, u8),
    wet: bool,
    /// Model by number, place, degrees.
    statics: Vec<(u8, Spot, f32)>,
    /// Blocks with a dungeon of two rooms and something in them.
    dungeons: Vec<(u8, u8)>,
}

/// The block of drawn numbers.
fn block_at((x, y): (u8, u8)) -> (u8, u8) {
    let offset = |n: u8| OFFSETS[usize::from(n)];
    (CORNER.0 + offset(x), CORNER.1 + offset(y))
}

/// An entity: kind by number, place, height, velocity.
#[derive(Debug, Clone, Copy)]
pub struct Thing {
    kind: u8,
    spot: Spot,
    indoors: bool,
    height: f32,
    push: (f32, f32),
}

/// A step: frame, entity by number, what by number, and its arguments.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    frame: u32,
    who: u8,
    what: u8,
    other: u8,
    spot: Spot,
    number: f32,
}

/// All of a drawn scene.
#[derive(Debug, Clone)]
pub struct Drawn {
    pub land: Land,
    pub things: Vec<Thing>,
    pub tracked: u8,
    pub steps: Vec<Step>,
    pub frames: Vec<(u8, u8)>,
}

fn spot() -> impl Strategy<Value = Spot> {
    // Borders are where it matters.
    let at = || prop_oneof![0.5_f32..191.5, 0.5_f32..6.0, 186.0_f32..191.5];
    ((0..SIDE, 0..SIDE), (at(), at())).prop_map(|(block, at)| Spot { block, at })
}

fn land() -> impl Strategy<Value = Land> {
    let statics = prop::collection::vec((0_u8..6, spot(), 0.0_f32..360.0), 0..24);
    let dungeons = prop::collection::vec((0..SIDE, 0..SIDE), 0..3);
    ((0_u8..4, 0_u8..4), any::<bool>(), statics, dungeons).prop_map(
        |(slope, wet, statics, dungeons)| Land {
            slope,
            wet,
            statics,
            dungeons,
        },
    )
}

fn thing() -> impl Strategy<Value = Thing> {
    let push = (-20.0_f32..20.0, -20.0_f32..20.0);
    (
        0_u8..8,
        spot(),
        prop::bool::weighted(0.1),
        0.0_f32..12.0,
        push,
    )
        .prop_map(|(kind, spot, indoors, height, push)| Thing {
            kind,
            spot,
            indoors,
            height,
            push,
        })
}

fn step() -> impl Strategy<Value = Step> {
    (
        0_u32..60,
        any::<u8>(),
        0_u8..20,
        any::<u8>(),
        spot(),
        -2.0_f32..2.0,
    )
        .prop_map(|(frame, who, what, other, spot, number)| Step {
            frame,
            who,
            what,
            other,
            spot,
            number,
        })
}

/// Any world and scene.
pub fn drawn() -> impl Strategy<Value = Drawn> {
    let things = prop::collection::vec(thing(), 1..14);
    let steps = prop::collection::vec(step(), 0..10);
    let frames = prop::collection::vec((0_u8..8, 1_u8..40), 1..4);
    (land(), things, 1_u8..4, steps, frames).prop_map(|(land, things, tracked, steps, frames)| {
        Drawn {
            land,
            things,
            tracked,
            steps,
            frames,
        }
    })
}

fn part(z: f32, hooks: Vec<AnimationHook>) -> AnimFrame {
    let frame = StoredFrame {
        origin: Vec3::Z * z,
        rotation: yaw(0.0),
    };
    AnimFrame {
        parts: vec![frame],
        hooks,
    }
}

fn hook(action: HookAction) -> AnimationHook {
    AnimationHook {
        direction: HookDirection::BOTH,
        action,
    }
}

fn cube(half: f32, height: f32) -> Vec<Face> {
    block(Vec3::new(-half, -half, 0.0), Vec3::new(half, half, height))
}

/// Setups 0x02000001 to 0x02000008 and motion table 0x09000001.
fn kinds(world: &mut WorldBuilder) {
    let solid = world.solid(&cube(1.0, 2.0));
    let wide = world.solid(&cube(7.0, 1.0));
    let drawn = world.shape(&[], &cube(0.5, 1.0));
    // 1 a walker, 2 a crate, 3 something wide, 4 a post, 5 a ball, 6 a lift, 7 a banner, 8 a door that becomes passable.
    world.setup(SetupBuilder::humanoid(drawn, 1.8, 0.48));
    world.setup(SetupBuilder::of_shape(solid));
    world.setup(SetupBuilder::of_shape(wide));
    let post = SetupBuilder::new()
        .part(drawn, StoredFrame::IDENTITY)
        .cyl_sphere(Vec3::ZERO, 0.6, 3.0);
    world.setup(post.size(3.0, 0.6));
    let ball = SetupBuilder::new()
        .part(drawn, StoredFrame::IDENTITY)
        .sphere(Vec3::Z * 0.4, 0.4);
    world.setup(ball.size(0.8, 0.4));
    let up = world.animation(
        1,
        (0..40).map(|n| (part(if n < 20 { 0.0 } else { 1.5 }, Vec::new()), None)),
    );
    world.setup(SetupBuilder::of_shape(solid).animation(up));
    let waves = world.animation(1, (0..7).map(|n| (part(n as f32 * 0.1, Vec::new()), None)));
    let banner = SetupBuilder::new()
        .part(drawn, StoredFrame::IDENTITY)
        .size(2.0, 0.3);
    world.setup(banner.animation(waves));
    let opens = (0..30).map(|n| {
        let hooks = match n {
            10 => vec![hook(HookAction::Ethereal { value: 1 })],
            20 => vec![hook(HookAction::Ethereal { value: 0 })],
            _ => Vec::new(),
        };
        (part(0.0, hooks), None)
    });
    let opens = world.animation(1, opens);
    let door = SetupBuilder::new()
        .part(drawn, StoredFrame::IDENTITY)
        .cyl_sphere(Vec3::ZERO, 1.5, 3.0);
    world.setup(door.size(3.0, 1.5).animation(opens));
    motions(world);
}

fn motions(world: &mut WorldBuilder) {
    let breath = world.animation(
        1,
        (0..12).map(|n| {
            let hooks = if n == 5 {
                vec![hook(HookAction::Sound { wave: 0x0A00_0001 })]
            } else {
                Vec::new()
            };
            (part(n as f32 * 0.01, hooks), None)
        }),
    );
    let stride = world.animation(
        1,
        (0..10).map(|n| (part(n as f32 * 0.02, Vec::new()), None)),
    );
    let bow = world.animation(1, (0..6).map(|_| (part(0.0, Vec::new()), None)));
    let table = MotionTable::new(0, STYLE)
        .with_style(STYLE, READY)
        .with_cycle(STYLE, READY, MotionData::playing(breath, 0, -1, 30.0))
        .with_cycle(
            STYLE,
            WALK,
            MotionData::playing(stride, 0, -1, 30.0).with_velocity(Vec3::new(0.0, 3.0, 0.0)),
        )
        .with_link(STYLE, READY, WALK, MotionData::playing(bow, 0, -1, 30.0));
    world.motion_table(table);
}

impl Land {
    /// The world, in memory.
    pub fn build(&self) -> Arc<DatSet> {
        let mut world = WorldBuilder::new();
        kinds(&mut world);
        let door = Rect {
            u: [-1.0, 1.0],
            v: [0.0, 2.5],
        };
        let room = Room::new(Vec3::new(-4.0, -4.0, 0.0), Vec3::new(4.0, 4.0, 3.0));
        let rooms = world.environment(&[
            room.clone().doorway(Side::North, door),
            room.doorway(Side::South, door),
        ]);
        let (a, b) = self.slope;
        for x in 0..SIDE {
            for y in 0..SIDE {
                let at = block_at((x, y));
                let home = world.block(at.0, at.1);
                home.heights(|i, j| {
                    let (i, j) = (usize::from(x) * 8 + i, usize::from(y) * 8 + j);
                    ((i * usize::from(a) + j * usize::from(b)) % 5) as u8
                });
                if self.wet && (x + y) % 2 == 0 {
                    home.terrain(|i, _| TerrainWord(if i < 4 { 17 << 2 } else { 0 }));
                }
            }
        }
        for &(x, y) in &self.dungeons {
            let at = block_at((x, y));
            let home = world.block(at.0, at.1);
            let at = |y: f32| StoredFrame::at(Vec3::new(96.0, y, -50.0));
            let south = home.room(rooms, 0, at(96.0), 1);
            let north = home.room(rooms, 1, at(104.0), 1);
            home.connect((south, 0), (north, 0));
            home.room_object(south, 0x0200_0002, Vec3::new(96.0, 99.0, -50.0), 0.0);
            home.room_object(north, 0x0200_0006, Vec3::new(95.0, 101.5, -50.0), 0.0);
        }
        for &(model, spot, degrees) in &self.statics {
            let model = 0x0200_0002 + u32::from(model);
            let model = if model == 0x0200_0005 {
                0x0200_0008
            } else {
                model
            };
            let at = block_at(spot.block);
            let home = world.block(at.0, at.1);
            home.object(model, Vec3::new(spot.at.0, spot.at.1, 4.0), degrees);
        }
        Arc::new(world.surround().build().expect("the world is well formed"))
    }
}

impl Spot {
    fn position(self, height: f32) -> PositionSpec {
        let (x, y) = block_at(self.block);
        let (x, y) = (u32::from(x), u32::from(y));
        let low = (self.at.0 / 24.0) as u32 * 8 + (self.at.1 / 24.0) as u32 + 1;
        PositionSpec {
            cell: x << 24 | y << 16 | low,
            origin: [self.at.0, self.at.1, height],
            rotation: [1.0, 0.0, 0.0, 0.0],
        }
    }

    fn room(self) -> PositionSpec {
        let outside = self.position(0.0);
        PositionSpec {
            cell: outside.cell & 0xFFFF_0000 | 0x0100,
            origin: [96.0, 96.0, -49.9],
            ..outside
        }
    }
}

fn guid(number: usize) -> u32 {
    0x5000_0001 + number as u32
}

impl Thing {
    fn spec(self, number: usize) -> EntitySpec {
        const GRAVITY: u32 = 0x408;
        const NOTHING: u32 = 0x8;
        let (setup, table, kind, state) = match self.kind {
            0 => (1, 1, EntityKind::Player, 0x0040_0C08),
            1 => (1, 1, EntityKind::Creature, 0x0040_0408),
            2 => (5, 0, EntityKind::Object, GRAVITY),
            3 => (5, 0, EntityKind::Missile, GRAVITY | 0x40),
            4 => (2, 0, EntityKind::Object, NOTHING),
            5 => (4, 0, EntityKind::Object, NOTHING),
            6 => (7, 0, EntityKind::Object, NOTHING),
            _ => (3, 0, EntityKind::Object, NOTHING),
        };
        let moves = matches!(self.kind, 2 | 3);
        EntitySpec {
            guid: guid(number),
            kind,
            setup: 0x0200_0000 | setup,
            motion_table: if table == 0 { 0 } else { 0x0900_0000 | table },
            scale: 1.0,
            position: if self.indoors {
                self.spot.room()
            } else {
                self.spot.position(8.0 + self.height)
            },
            state,
            velocity: if moves {
                [self.push.0, self.push.1, 2.0]
            } else {
                [0.0; 3]
            },
            omega: [0.0; 3],
            elasticity: 0.05,
            friction: 0.5,
            run_rate: 1.5,
            jump_velocity: 8.0,
            parent: None,
        }
    }
}

impl Drawn {
    /// The scene.
    pub fn scene(&self) -> Scene {
        let entities: Vec<_> = self
            .things
            .iter()
            .enumerate()
            .map(|(n, t)| t.spec(n))
            .collect();
        let track = (0..entities.len().min(usize::from(self.tracked)))
            .map(guid)
            .collect();
        let mut script: Vec<_> = self
            .steps
            .iter()
            .enumerate()
            .map(|(n, s)| self.step(n, *s))
            .collect();
        script.sort_by_key(|step| step.frame);
        let frames = self.frames.iter().map(|&(dt, count)| FrameRun {
            dt: [0.04, 0.02, 0.1, 0.25, 0.5, 0.0, 0.0001, 2.5][usize::from(dt)],
            count: u32::from(count),
        });
        Scene {
            schema: "ac-scene/1".into(),
            name: "drawn/scene".into(),
            summary: String::new(),
            world: "drawn".into(),
            features: Vec::new(),
            start_time: START,
            frames: frames.collect(),
            entities,
            script,
            track,
        }
    }

    fn step(&self, number: usize, step: Step) -> ScriptStep {
        let count = self.things.len();
        let (who, other) = (
            usize::from(step.who) % count,
            usize::from(step.other) % count,
        );
        let position = step.spot.position(10.0);
        let params = MoveParams::default();
        let (velocity, target) = ([step.number * 6.0, 5.0, step.number], guid(other));
        let mut of = guid(who);
        let action = match step.what {
            0 | 1 => Action::SetPosition {
                position,
                flags: 0x1012,
            },
            2 => Action::SetPosition {
                position: step.spot.room(),
                flags: 0x1012,
            },
            3 | 4 => Action::SetVelocity { velocity },
            5 | 6 => Action::DoMotion {
                command: WALK,
                speed: 1.0,
                hold_key: HoldKey::Run,
            },
            7 => Action::StopCompletely,
            8 => Action::MoveToPosition { position, params },
            9 => Action::MoveToObject { target, params },
            10 => Action::InterpolateTo {
                position,
                keep_heading: false,
            },
            11 => Action::Destroy,
            12 | 13 => {
                of = guid(count + number);
                let thing = Thing {
                    kind: step.other % 8,
                    spot: step.spot,
                    indoors: false,
                    height: 2.0,
                    push: (step.number, 3.0),
                };
                Action::Create {
                    entity: thing.spec(count + number),
                }
            }
            14 => Action::SetState {
                state: if step.number > 0.0 { 0xC } else { 0x8 },
            },
            15 => Action::StickTo {
                target,
                radius: 0.5,
                height: 1.8,
            },
            16 => Action::SetParent {
                parent: target,
                part: 0,
                offset: OffsetSpec {
                    origin: [0.0, 0.0, 1.0],
                    rotation: [1.0, 0.0, 0.0, 0.0],
                },
            },
            17 => Action::UnsetParent,
            18 => Action::Jump { extent: 0.8 },
            _ => Action::SetHeading {
                heading: 100.0 * step.number,
            },
        };
        ScriptStep {
            frame: step.frame,
            guid: of,
            action,
        }
    }
}
