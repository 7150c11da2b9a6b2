//! Messages (`spec/10-messages.md`, 16): sent as bytes, applied to a world, and the world goes on for a while.

use std::sync::Arc;

use ac_client::{
    frame::{NoHost, Pipeline},
    net::{
        entities::{Dropped, GameEntities, Verdict},
        messages::{
            PlainServerMessage, ServerMessage,
            common::{List, Text, WirePosition},
            movement::{MovementData, SequencedMovement},
            object as m,
            physics_desc::PhysicsFields,
            position::{PositionPack, PositionStamps},
        },
    },
    profile::Profile,
    world::World,
};

use super::{
    super::{
        trial::Trial,
        worlds::{self, Playground},
    },
    cases,
};

cases! { "10";
    1 "stamps that wrap" => stamp_wrap;
    2 "newer teleport stamp with an older position stamp" => teleport_old_position;
    3 "force and teleport both newer" => force_and_teleport;
    4 "position for an object without cell" => no_cell;
    5 "quaternions left out, of other length, −0" => quaternions;
    6 "movement data of length 0, 4, too long, too short" => movement_lengths;
    7 "interpreted word of all ones" => all_ones;
    8 "action stamps around their wrap" => action_stamps;
    9 "move-to unknown, self, elsewhere, without limits" => move_to_object;
    10 "sticky to nobody" => sticky;
    11 "creation of the player, again, older" => creation;
    12 "parents: self and cycles" => parent_cycles;
    13 "children that are unknown" => unknown_children;
    14 "parent and position both" => parent_and_position;
    15 "state words in mid-air" => states;
    16 "vectors beyond the limit, not a number" => vectors;
    17 "scale, friction, elasticity out of range" => materials;
    18 "delete the player, delete targets" => deletes;
    19 "teleports twice" => teleports;
    20 "player descriptions" => player_description;
    21 "strings without end" => strings;
    22 "chat with wrong byte counts" => chat;
    23 "several movements in one frame" => several_movements;
}

const PLAYER: u32 = 0x5000_0001;
const OTHER: u32 = 0x8000_0001;
const ITEM: u32 = 0x8000_0002;

/// A player and somebody else, as a server describes them.
struct Rig {
    play: &'static Playground,
    world: World,
    entities: GameEntities,
    pipeline: Pipeline,
    now: f64,
}

fn rig(t: &mut Trial) -> Option<Rig> {
    let play = match worlds::play() {
        Ok(play) => play,
        Err(error) => {
            t.promise(false, || error.to_string());
            return None;
        }
    };
    let mut rig = Rig {
        play,
        world: World::with_source(Profile::retail(), 0.0, Arc::clone(&play.source) as _),
        entities: GameEntities::new(),
        pipeline: Pipeline::default(),
        now: 0.0,
    };
    let player = rig.send(PlainServerMessage::PlayerCreate(m::Guid { guid: PLAYER }));
    let made = [PLAYER, OTHER].map(|guid| rig.create(guid, 1, |_| ()));
    t.same(
        "the rig",
        (player, made),
        (Some(Verdict::Applied), [Some(Verdict::Applied); 2]),
    );
    Some(rig)
}

impl Rig {
    /// Over the wire and back; `None` for what the reader refuses.
    fn send(&mut self, message: PlainServerMessage) -> Option<Verdict> {
        self.bytes(&ServerMessage::Plain(message).to_bytes())
    }

    fn bytes(&mut self, bytes: &[u8]) -> Option<Verdict> {
        let parsed = ServerMessage::parse(bytes).ok()?;
        Some(self.entities.apply(&parsed.message, &mut self.world))
    }

    fn place(&self, x: f32) -> WirePosition {
        WirePosition {
            cell: self.play.home | 0x0D,
            origin: [x, 100.0, 0.0],
            rotation: [1.0, 0.0, 0.0, 0.0],
        }
    }

    fn create(
        &mut self,
        guid: u32,
        instance: u16,
        change: impl FnOnce(&mut m::ObjectDescription),
    ) -> Option<Verdict> {
        let mut o = m::ObjectDescription {
            guid,
            ..m::ObjectDescription::default()
        };
        o.physics.state = 0x0040_0C08;
        o.physics.fields = PhysicsFields {
            position: Some(self.place(if guid == PLAYER { 30.0 } else { 40.0 })),
            setup: Some(self.play.walker),
            motion_table: Some(self.play.table),
            ..PhysicsFields::default()
        };
        o.physics.timestamps[8] = instance;
        o.weenie.name = Text::new("Somebody");
        o.weenie.object_bits = if guid == PLAYER { 0x18 } else { 0x10 };
        change(&mut o);
        self.send(PlainServerMessage::CreateObject(Box::new(o)))
    }

    fn position(&mut self, guid: u32, place: WirePosition, stamps: [u16; 4]) -> Option<Verdict> {
        let [instance, position, teleport, force] = stamps;
        let stamps = PositionStamps {
            instance,
            position,
            teleport,
            force,
        };
        self.send(PlainServerMessage::UpdatePosition(m::UpdatePosition {
            guid,
            position: PositionPack::new(place, true, stamps).with_all_components(),
        }))
    }

    fn motion(&mut self, guid: u32, stamp: u16, bytes: &[u8]) -> Option<Verdict> {
        self.send(PlainServerMessage::UpdateMotion(m::UpdateMotion {
            guid,
            instance: 1,
            movement: SequencedMovement {
                movement: stamp,
                server_control: stamp,
                autonomous: 0,
                data: MovementData::from_window(bytes),
            },
        }))
    }

    fn vector(&mut self, guid: u32, velocity: [f32; 3], stamp: u16) -> Option<Verdict> {
        self.send(PlainServerMessage::VectorUpdate(m::VectorUpdate {
            guid,
            velocity,
            omega: [0.0; 3],
            instance: 1,
            stamp,
        }))
    }

    /// The world goes on; everybody stays a number and keeps the speed limit.
    fn goes_on(&mut self, t: &mut Trial) {
        for _ in 0..40 {
            self.now += 0.04;
            self.pipeline
                .run_frame(&mut self.world, self.now, &mut NoHost);
        }
        for (guid, known) in self.entities.iter() {
            let Some(entity) = self.world.entity(known.id) else {
                continue;
            };
            let (origin, velocity) = (entity.body.position.frame.origin, entity.kin.velocity);
            t.promise(origin.is_finite() && velocity.is_finite(), || {
                format!("{guid:#X} at {origin}, {velocity} m/s")
            });
            t.promise(velocity.length() < 52.0, || {
                format!("{guid:#X} has {velocity} m/s")
            });
        }
    }

    fn x(&self, guid: u32) -> f32 {
        let known = self
            .entities
            .get(guid)
            .and_then(|known| self.world.entity(known.id));
        known.map_or(f32::NAN, |entity| entity.body.position.frame.origin.x)
    }
}

fn stamp_wrap(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    for (stamp, applied) in [
        (0x7FFF, true),
        (0x8001, true),
        (65_535, true),
        (0, true),
        (0, false),
        (65_535, false),
        (32_767, true),
    ] {
        let place = rig.place(41.0);
        let verdict = rig.position(OTHER, place, [1, stamp, 0, 0]);
        t.promise((verdict == Some(Verdict::Applied)) == applied, || {
            format!("stamp {stamp}: {verdict:?}")
        });
    }
    rig.goes_on(t);
}

fn teleport_old_position(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    let (near, far) = (rig.place(41.0), rig.place(90.0));
    rig.position(OTHER, near, [1, 10, 0, 0]);
    let verdict = rig.position(OTHER, far, [1, 5, 1, 0]);
    t.promise(
        matches!(verdict, Some(Verdict::Dropped(Dropped::Old(_)))),
        || format!("{verdict:?}"),
    );
    rig.goes_on(t);
    t.promise(rig.x(OTHER) < 50.0, || format!("it is at {}", rig.x(OTHER)));
}

fn force_and_teleport(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    for guid in [PLAYER, OTHER] {
        let far = rig.place(90.0);
        let verdict = rig.position(guid, far, [1, 3, 3, 3]);
        t.promise(verdict.is_some(), || "not read".into());
        rig.goes_on(t);
    }
}

fn no_cell(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    rig.create(ITEM, 1, |o| o.physics.fields.position = None);
    let place = rig.place(50.0);
    let verdict = rig.position(ITEM, place, [1, 1, 0, 0]);
    t.same(
        "position of an object without cell",
        verdict,
        Some(Verdict::Applied),
    );
    t.promise((rig.x(ITEM) - 50.0).abs() < 0.5, || {
        format!("it is at {}", rig.x(ITEM))
    });
    let nowhere = WirePosition {
        cell: 0x7777_0001,
        ..rig.place(50.0)
    };
    rig.position(ITEM, nowhere, [1, 2, 0, 0]);
    rig.goes_on(t);
}

fn quaternions(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    let rotations = [
        [0.0, 0.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0, 0.0],
        [0.5, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, -0.0],
        [f32::NAN, 0.0, 0.0, 1.0],
        [1e30, 1e30, 0.0, 0.0],
    ];
    for (i, rotation) in (1..).zip(rotations) {
        let place = WirePosition {
            rotation,
            ..rig.place(41.0)
        };
        rig.position(OTHER, place, [1, i, 0, 0]);
        rig.goes_on(t);
    }
}

/// A state of type 0: a walk forward with a speed.
fn walking(speed: f32) -> Vec<u8> {
    let mut bytes = vec![0, 0, 0x3D, 0x00];
    bytes.extend(0x06_u32.to_le_bytes());
    bytes.extend(5_u16.to_le_bytes());
    bytes.extend([0, 0]);
    bytes.extend(speed.to_le_bytes());
    bytes
}

fn movement_lengths(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    let whole = walking(1.0);
    let mut long = whole.clone();
    long.extend([9; 40]);
    for (stamp, bytes) in (1..).zip((0..=whole.len()).map(|n| whole[..n].to_vec()).chain([long])) {
        let verdict = rig.motion(OTHER, stamp, &bytes);
        t.promise(verdict != Some(Verdict::Other), || {
            format!("{} bytes: {verdict:?}", bytes.len())
        });
    }
    rig.goes_on(t);
}

fn all_ones(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    for filler in [0_u8, 0xFF, 0x41] {
        let mut bytes = vec![0, 0xFF, 0x3D, 0x00, 0xFF, 0xFF, 0xFF, 0xFF];
        bytes.extend([filler; 400]);
        rig.motion(OTHER, u16::from(filler) + 1, &bytes);
        rig.goes_on(t);
    }
}

fn action_stamps(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    // One action with its stamp: the count is in bits 7 to 11 of the word.
    for (i, stamp) in (1..).zip([0x7FFE_u16, 0x7FFF, 0, 1, 1, 0x3FFF, 0x4000, 0x7FFF]) {
        let mut bytes = vec![0, 0, 0x3D, 0x00];
        bytes.extend((1_u32 << 7).to_le_bytes());
        bytes.extend(0x0087_u16.to_le_bytes());
        bytes.extend(stamp.to_le_bytes());
        bytes.extend(1.0_f32.to_le_bytes());
        rig.motion(OTHER, i, &bytes);
    }
    rig.goes_on(t);
}

fn move_to_object(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    let mut stamp = 0;
    for target in [OTHER, PLAYER, 0x7777_7777, 0] {
        for (fail, rate) in [
            (f32::MAX, 1.0_f32),
            (10.0, 0.0),
            (10.0, -1.0),
            (f32::NAN, f32::NAN),
        ] {
            for cell in [rig.play.home | 0x0D, rig.play.hills | 1, 0] {
                stamp += 1;
                let mut bytes = vec![6, 0, 0x3D, 0x00];
                bytes.extend(target.to_le_bytes());
                bytes.extend(cell.to_le_bytes());
                for number in [35.0_f32, 100.0, 0.0] {
                    bytes.extend(number.to_le_bytes());
                }
                bytes.extend(0x0001_EE0F_u32.to_le_bytes());
                for number in [0.6_f32, 0.0, fail, 1.0, 15.0, 0.0, rate] {
                    bytes.extend(number.to_le_bytes());
                }
                rig.motion(OTHER, stamp, &bytes);
                rig.goes_on(t);
            }
        }
    }
}

fn sticky(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    for (stamp, options) in (1..).zip([1_u8, 3, 0xFF]) {
        for kind in [0_u8, 6, 7, 8, 9] {
            let mut bytes = vec![kind, options, 0x3D, 0x00, 0, 0, 0, 0];
            bytes.extend(0x7777_7777_u32.to_le_bytes());
            bytes.extend([0; 48]);
            rig.motion(OTHER, stamp * 8 + u16::from(kind), &bytes);
        }
        rig.goes_on(t);
    }
}

fn creation(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    for instance in [1, 1, 2, 0, 0x8001, 2] {
        for guid in [PLAYER, OTHER] {
            rig.create(guid, instance, |_| ());
        }
        rig.goes_on(t);
    }
    t.same("objects", rig.entities.iter().len(), 2);
    // Before PlayerCreate, and without it.
    rig.entities = GameEntities::new();
    rig.create(PLAYER, 9, |_| ());
    rig.goes_on(t);
}

fn parent_cycles(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    rig.create(ITEM, 1, |_| ());
    let hold = |parent, child, stamp| {
        PlainServerMessage::ParentEvent(m::ParentEvent {
            parent,
            child,
            location: 1,
            placement: 1,
            parent_instance: 1,
            child_position: stamp,
        })
    };
    let own = rig.send(hold(OTHER, OTHER, 1));
    t.promise(own != Some(Verdict::Applied), || {
        "an object holds itself".into()
    });
    rig.send(hold(OTHER, ITEM, 2));
    let back = rig.send(hold(ITEM, OTHER, 3));
    t.promise(back != Some(Verdict::Applied), || {
        "two objects hold each other".into()
    });
    rig.goes_on(t);
}

fn unknown_children(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    rig.create(ITEM, 1, |o| {
        o.physics.fields.children = Some(List(vec![(0x7777_7777, 1), (0x7777_7778, 0), (ITEM, 1)]))
    });
    rig.goes_on(t);
    t.same("objects", rig.entities.iter().len(), 3);
}

fn parent_and_position(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    for parent in [OTHER, 0x7777_7777] {
        rig.create(ITEM, 1, |o| o.physics.fields.parent = Some((parent, 1)));
        rig.goes_on(t);
    }
}

fn states(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    rig.vector(OTHER, [1.0, 0.0, 12.0], 1);
    for (stamp, state) in (1..).zip([
        0x0000_0808_u32,
        0x0000_4408,
        0x0100_0408,
        0x0000_0409,
        0xFFFF_FFFF,
        0x0040_0C08,
    ]) {
        rig.send(PlainServerMessage::SetState(m::SetState {
            guid: OTHER,
            state,
            instance: 1,
            stamp,
        }));
        rig.goes_on(t);
    }
}

fn vectors(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    for (stamp, velocity) in (1..).zip([
        [400.0, 0.0, 0.0],
        [0.0, 0.0, f32::MAX],
        [f32::NAN, 0.0, 0.0],
        [0.0, f32::INFINITY, 0.0],
    ]) {
        let verdict = rig.vector(OTHER, velocity, stamp);
        let finite = velocity.iter().all(|c| c.is_finite());
        t.promise(finite || verdict != Some(Verdict::Applied), || {
            format!("{velocity:?}: {verdict:?}")
        });
        rig.goes_on(t);
    }
}

fn materials(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    let mut instance = 0;
    for scale in [0.0_f32, -1.0, 1e30, f32::NAN, 0.1, 10.0] {
        for (friction, elasticity) in [(2.0_f32, -1.0_f32), (-1.0, 5.0), (f32::NAN, f32::NAN)] {
            instance += 1;
            rig.create(ITEM, instance, |o| {
                o.physics.fields.scale = Some(scale);
                o.physics.fields.friction = Some(friction);
                o.physics.fields.elasticity = Some(elasticity);
                o.physics.fields.velocity = Some([3.0, 1.0, 5.0]);
            });
            rig.goes_on(t);
        }
    }
}

fn deletes(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    let delete =
        |guid, instance| PlainServerMessage::DeleteObject(m::DeleteObject { guid, instance });
    let player = rig.send(delete(PLAYER, 1));
    t.same(
        "deleting the player",
        player,
        Some(Verdict::Dropped(Dropped::LocalPlayer)),
    );
    let mut chase = vec![8, 0, 0x3D, 0x00];
    chase.extend(OTHER.to_le_bytes());
    chase.extend([0; 24]);
    rig.motion(PLAYER, 1, &chase);
    t.same(
        "deleting the target",
        rig.send(delete(OTHER, 1)),
        Some(Verdict::Applied),
    );
    rig.goes_on(t);
    t.promise(rig.send(delete(OTHER, 1)) != Some(Verdict::Applied), || {
        "deleted twice".into()
    });
    rig.goes_on(t);
}

fn teleports(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    let far = rig.place(90.0);
    rig.position(PLAYER, far, [1, 1, 1, 0]);
    for stamp in [1, 1, 2] {
        rig.send(PlainServerMessage::PlayerTeleport(m::PlayerTeleport {
            stamp,
        }));
        rig.goes_on(t);
    }
    let near = rig.place(30.0);
    rig.position(PLAYER, near, [1, 2, 2, 0]);
    rig.goes_on(t);
}

/// A game event around a body.
fn event(code: u32, body: &[u8]) -> Vec<u8> {
    let mut bytes = 0xF7B0_u32.to_le_bytes().to_vec();
    for word in [PLAYER, 1, code] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(body);
    bytes
}

fn player_description(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    for length in [0_usize, 4, 16, 400, 30_000] {
        for filler in [0_u8, 0xFF, 0x11] {
            // Read or refused, never worse.
            let _ = rig.bytes(&event(0x0013, &vec![filler; length]));
        }
    }
    rig.goes_on(t);
}

fn strings(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    for length in [65_535_u16, 300, 3] {
        for body in [0_usize, 2, 299, 70_000] {
            let mut bytes = 0xF7E0_u32.to_le_bytes().to_vec();
            bytes.extend(length.to_le_bytes());
            bytes.extend(std::iter::repeat_n(0_u8, body));
            let parsed = ServerMessage::parse(&bytes);
            t.promise(parsed.is_err() || body >= usize::from(length), || {
                format!("a string of {length} in {body} bytes is read")
            });
        }
    }
    rig.goes_on(t);
}

fn chat(t: &mut Trial) {
    for first in [0_u32, 8, 24, 0xFFFF_FFFF] {
        for second in [0_u32, 16, 32, 0x7FFF_FFFF] {
            let mut bytes = 0xF7DE_u32.to_le_bytes().to_vec();
            for word in [first, 1, 1, 0, 0, 0, 0, second] {
                bytes.extend(word.to_le_bytes());
            }
            bytes.extend([0; 24]);
            let _ = ServerMessage::parse(&bytes);
        }
    }
    t.promise(true, String::new);
}

fn several_movements(t: &mut Trial) {
    let Some(mut rig) = rig(t) else { return };
    for (stamp, speed) in (1..).zip([1.0_f32, -1.0, 0.0, 2.0, f32::NAN, 1.5]) {
        rig.motion(OTHER, stamp, &walking(speed));
    }
    rig.goes_on(t);
}
