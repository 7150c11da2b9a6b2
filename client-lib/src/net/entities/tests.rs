//! Invariants 3 to 8 and 15 of `spec/10-messages.md`, 15, and cases of 16, on the synthetic world.

use std::path::PathBuf;
use std::sync::Arc;

use proptest::prelude::*;

use super::*;
use crate::dat::{DatSet, Strictness};
use crate::net::messages::common::{List, Text, WirePosition};
use crate::net::messages::movement::MovementData;
use crate::net::messages::physics_desc::PhysicsFields;
use crate::profile::Profile;

const PLAYER: u32 = 0x5000_0001;
const OTHER: u32 = 0x8000_0001;
const ITEM: u32 = 0x8000_0002;

struct Rig {
    world: World,
    entities: GameEntities,
}

fn place(x: f32) -> WirePosition {
    WirePosition {
        cell: 0xA9B4_0012,
        origin: [x, 36.0, 20.0],
        rotation: [1.0, 0.0, 0.0, 0.0],
    }
}

fn object(guid: u32, instance: u16) -> m::ObjectDescription {
    let mut o = m::ObjectDescription {
        guid,
        ..m::ObjectDescription::default()
    };
    o.physics.state = 0x0040_0C08;
    o.physics.fields = PhysicsFields {
        position: Some(place(60.0)),
        setup: Some(0x0200_0001),
        motion_table: Some(0x0900_0001),
        ..PhysicsFields::default()
    };
    o.physics.timestamps[8] = instance;
    o.weenie.name = Text::new("Somebody");
    o.weenie.object_bits = if guid == PLAYER { 0x18 } else { 0x10 };
    o
}

fn create(o: m::ObjectDescription) -> PlainServerMessage {
    PlainServerMessage::CreateObject(Box::new(o))
}

fn position(guid: u32, x: f32, stamps: [u16; 4]) -> PlainServerMessage {
    let [instance, position, teleport, force] = stamps;
    let stamps = PositionStamps {
        instance,
        position,
        teleport,
        force,
    };
    PlainServerMessage::UpdatePosition(m::UpdatePosition {
        guid,
        position: PositionPack::new(place(x), true, stamps),
    })
}

fn motion(guid: u32, stamps: [u16; 2], autonomous: u8) -> PlainServerMessage {
    PlainServerMessage::UpdateMotion(m::UpdateMotion {
        guid,
        instance: 1,
        movement: SequencedMovement {
            movement: stamps[0],
            server_control: stamps[1],
            autonomous,
            data: MovementData::default(),
        },
    })
}

impl Rig {
    fn new() -> Self {
        let folder =
            PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../golden-traces/worlds/testbed");
        let dats =
            DatSet::open(folder, Strictness::Strict).expect("the world is part of the repository");
        let mut rig = Self {
            world: World::with_source(Profile::retail(), 0.0, Arc::new(dats)),
            entities: GameEntities::new(),
        };
        let guid = m::Guid { guid: PLAYER };
        assert_eq!(
            rig.send(PlainServerMessage::PlayerCreate(guid)),
            Verdict::Applied
        );
        assert_eq!(rig.send(create(object(PLAYER, 1))), Verdict::Applied);
        assert_eq!(rig.send(create(object(OTHER, 1))), Verdict::Applied);
        rig.entities.notices.clear();
        rig
    }

    fn send(&mut self, message: PlainServerMessage) -> Verdict {
        // Over the wire and back: what is applied is what a server can send.
        let bytes = ServerMessage::Plain(message).to_bytes();
        let parsed = ServerMessage::parse(&bytes).expect("a valid message");
        self.entities.apply(&parsed.message, &mut self.world)
    }

    fn entity(&self, guid: u32) -> &Entity {
        let id = self.entities.get(guid).expect("known").id;
        self.world.entity(id).expect("there")
    }

    fn x(&self, guid: u32) -> f32 {
        self.entity(guid).body.position.frame.origin.x
    }
}

#[test]
fn creation() {
    let rig = Rig::new();
    assert_eq!(rig.entities.iter().len(), 2);
    assert_eq!(
        rig.world.local_player,
        rig.entities.get(PLAYER).map(|e| e.id)
    );
    let other = rig.entity(OTHER);
    assert!(other.body.cell.is_some());
    assert_eq!(other.timestamps.0[8], 1);
    assert!(rig.entity(PLAYER).body.weenie.player && !other.body.weenie.player);
}

#[test]
fn incarnations() {
    let mut rig = Rig::new();
    let first = rig.entities.get(OTHER).map(|e| e.id);
    let state = |instance, stamp| {
        PlainServerMessage::SetState(m::SetState {
            guid: OTHER,
            state: 0,
            instance,
            stamp,
        })
    };
    let dropped = Verdict::Dropped;
    assert_eq!(rig.send(state(0, 1)), dropped(Dropped::EarlierIncarnation));
    // It waits for its incarnation.
    assert_eq!(rig.send(state(2, 1)), Verdict::Kept);
    assert_eq!(rig.send(state(1, 1)), Verdict::Applied);
    assert_eq!(rig.send(state(1, 1)), dropped(Dropped::Old(Stamp::State)));
    assert_eq!(
        rig.send(create(object(OTHER, 0))),
        dropped(Dropped::EarlierIncarnation)
    );
    assert_eq!(rig.send(create(object(OTHER, 2))), Verdict::Applied);
    assert_eq!(
        (
            rig.entity(OTHER).timestamps.0[2],
            rig.entities.waiting().len()
        ),
        (1, 0)
    );
    assert_ne!(rig.entities.get(OTHER).map(|e| e.id), first);
    assert!(rig.world.entity(first.expect("was known")).is_none());
    assert_eq!(rig.send(state(1, 9)), dropped(Dropped::EarlierIncarnation));
}

#[test]
fn deletion() {
    let mut rig = Rig::new();
    let delete =
        |guid, instance| PlainServerMessage::DeleteObject(m::DeleteObject { guid, instance });
    assert_eq!(
        rig.send(delete(PLAYER, 1)),
        Verdict::Dropped(Dropped::LocalPlayer)
    );
    assert_eq!(
        rig.send(delete(OTHER, 0)),
        Verdict::Dropped(Dropped::EarlierIncarnation)
    );
    assert_eq!(rig.send(delete(OTHER, 1)), Verdict::Applied);
    assert!(rig.world.entity_of_guid(OTHER).is_none());
    let unknown = Verdict::Dropped(Dropped::Unknown);
    assert_eq!(rig.send(position(OTHER, 70.0, [1, 9, 0, 0])), Verdict::Kept);
    assert_eq!(rig.send(delete(OTHER, 1)), unknown);
    // The same incarnation in sight again: its description has the newer place.
    let mut again = object(OTHER, 1);
    again.physics.timestamps[0] = 10;
    assert_eq!(rig.send(create(again)), Verdict::Applied);
    assert_eq!(
        (rig.x(OTHER), rig.entity(OTHER).timestamps.0[0]),
        (60.0, 10)
    );
}

#[test]
fn others_follow_positions() {
    let mut rig = Rig::new();
    // A newer teleport stamp places at once.
    assert_eq!(
        rig.send(position(OTHER, 70.0, [1, 1, 1, 0])),
        Verdict::Applied
    );
    assert_eq!(rig.x(OTHER), 70.0);
    let old = |stamp| Verdict::Dropped(Dropped::Old(stamp));
    assert_eq!(
        rig.send(position(OTHER, 75.0, [1, 1, 2, 0])),
        old(Stamp::Position)
    );
    assert_eq!(
        rig.send(position(OTHER, 75.0, [1, 2, 0, 0])),
        old(Stamp::Teleport)
    );
    assert_eq!(rig.x(OTHER), 70.0);
    // The position stamp advanced although the message was dropped by its teleport stamp.
    assert_eq!(rig.entity(OTHER).timestamps.0[0], 2);
}

#[test]
fn the_player_moves_itself() {
    let mut rig = Rig::new();
    assert_eq!(
        rig.send(position(PLAYER, 70.0, [1, 1, 0, 0])),
        Verdict::Applied
    );
    assert_eq!((rig.x(PLAYER), rig.entities.notices.len()), (60.0, 0));
    assert_eq!(
        rig.send(position(PLAYER, 64.0, [1, 2, 0, 1])),
        Verdict::Applied
    );
    assert_eq!(rig.x(PLAYER), 64.0);
    assert_eq!(rig.entities.notices, [Notice::ForcedPosition]);
    assert_eq!(rig.entity(PLAYER).timestamps.0[6], 1);
    rig.entities.notices.clear();
    let teleport = |stamp| PlainServerMessage::PlayerTeleport(m::PlayerTeleport { stamp });
    assert_eq!(rig.send(teleport(1)), Verdict::Applied);
    assert_eq!(rig.send(teleport(1)), Verdict::Applied);
    assert_eq!(rig.entity(PLAYER).timestamps.0[4], 0);
    assert_eq!(
        rig.send(position(PLAYER, 66.0, [1, 3, 1, 1])),
        Verdict::Applied
    );
    assert_eq!(
        (rig.x(PLAYER), rig.entity(PLAYER).timestamps.0[4]),
        (66.0, 1)
    );
    assert_eq!(rig.entities.notices, [Notice::PortalSpace]);
    assert!(rig.entities.in_portal_space());
    rig.entities.leave_portal_space();
    assert_eq!(
        rig.send(teleport(0)),
        Verdict::Dropped(Dropped::Old(Stamp::Teleport))
    );
}

#[test]
fn movements() {
    let mut rig = Rig::new();
    assert_eq!(
        rig.send(motion(PLAYER, [1, 0], 1)),
        Verdict::Dropped(Dropped::Echo)
    );
    assert!(rig.entities.notices.is_empty());
    assert_eq!(rig.send(motion(PLAYER, [2, 1], 0)), Verdict::Applied);
    assert_eq!(rig.entities.notices, [Notice::LostControl]);
    assert_eq!(rig.send(motion(OTHER, [1, 5], 0)), Verdict::Applied);
    let old = |stamp| Verdict::Dropped(Dropped::Old(stamp));
    assert_eq!(rig.send(motion(OTHER, [1, 6], 0)), old(Stamp::Movement));
    assert_eq!(
        rig.send(motion(OTHER, [2, 4], 0)),
        old(Stamp::ServerControl)
    );
    assert_eq!(rig.entity(OTHER).timestamps.0[1], 2);
}

#[test]
fn carried_things() {
    let mut rig = Rig::new();
    let mut item = object(ITEM, 1);
    item.physics.fields.setup = Some(0x0200_0008);
    item.physics.fields.motion_table = None;
    assert_eq!(rig.send(create(item)), Verdict::Applied);
    let pickup = PlainServerMessage::PickupEvent(m::PickupEvent {
        guid: ITEM,
        instance: 1,
        position: 1,
    });
    assert_eq!(rig.send(pickup.clone()), Verdict::Applied);
    assert!(rig.entity(ITEM).body.cell.is_none());
    assert_eq!(
        rig.send(pickup),
        Verdict::Dropped(Dropped::Old(Stamp::Position))
    );
    let parent = |parent, child, child_position| {
        PlainServerMessage::ParentEvent(m::ParentEvent {
            parent,
            child,
            location: 1,
            placement: 0,
            parent_instance: 1,
            child_position,
        })
    };
    assert_eq!(rig.send(parent(0x1234, ITEM, 2)), Verdict::Kept);
    assert_eq!(
        rig.send(parent(ITEM, ITEM, 2)),
        Verdict::Dropped(Dropped::NotAttachable)
    );
    let remove = PlainServerMessage::InventoryRemoveObject(m::Guid { guid: ITEM });
    assert_eq!(rig.send(remove), Verdict::Applied);
    assert!(rig.entities.get(ITEM).is_none());
}

#[test]
fn descriptions_of_known_objects_go_by_groups() {
    let mut rig = Rig::new();
    let mut o = object(OTHER, 1);
    o.weenie.name = Text::new("Somebody else");
    o.physics.state = 0x408;
    o.physics.fields.children = Some(List(vec![(0x1234, 0)]));
    assert_eq!(rig.send(create(o.clone())), Verdict::Applied);
    let state = rig.entity(OTHER).body.state.bits();
    assert_ne!(state, 0x408);
    let name = rig.entities.get(OTHER).map(|e| e.weenie.name.clone());
    assert_eq!(name, Some(Text::new("Somebody else")));
    o.physics.timestamps[2] = 1;
    let update = PlainServerMessage::UpdateObject(Box::new(o));
    assert_eq!(rig.send(update), Verdict::Applied);
    assert_eq!(rig.entity(OTHER).body.state.bits(), 0x408);
}

#[test]
fn numbers_that_are_none_have_no_effect() {
    let mut rig = Rig::new();
    let invalid = Verdict::Dropped(Dropped::Invalid);
    assert_eq!(rig.send(position(OTHER, f32::NAN, [1, 5, 5, 5])), invalid);
    let vector = |x| {
        PlainServerMessage::VectorUpdate(m::VectorUpdate {
            guid: OTHER,
            velocity: [x, 0.0, 0.0],
            omega: [0.0; 3],
            instance: 1,
            stamp: 1,
        })
    };
    assert_eq!(rig.send(vector(f32::INFINITY)), invalid);
    let mut lying = PositionPack::new(place(70.0), true, PositionStamps::default());
    lying.position.rotation = [0.0; 4];
    lying.stamps.instance = 1;
    let lying = m::UpdatePosition {
        guid: OTHER,
        position: lying,
    };
    assert_eq!(rig.send(PlainServerMessage::UpdatePosition(lying)), invalid);
    assert_eq!(rig.entity(OTHER).timestamps.0[..8], [0; 8]);
    assert_eq!(rig.send(vector(1.0)), Verdict::Applied);
    assert_eq!(rig.entity(OTHER).kin.velocity.x, 1.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn newer(a: u16, b: u16, shift: u16) {
        prop_assert!(!is_newer(a, a));
        prop_assert!(!(is_newer(a, b) && is_newer(b, a)));
        if a != b {
            prop_assert!(is_newer(a, b) || is_newer(b, a));
        }
        if a.abs_diff(b) != 32768 {
            prop_assert_eq!(is_newer(a, b), is_newer(a.wrapping_add(shift), b.wrapping_add(shift)));
        }
    }

    #[test]
    fn the_newest_position_stands(order in Just((1u16..9).collect::<Vec<_>>()).prop_shuffle(), base: u16) {
        let mut rig = Rig::new();
        let mut other = object(ITEM, 1);
        other.physics.timestamps[0] = base;
        prop_assert_eq!(rig.send(create(other)), Verdict::Applied);
        for &i in &order {
            let x = 60.0 + f32::from(i);
            let stamp = base.wrapping_add(i);
            rig.send(position(ITEM, x, [1, stamp, i, 0]));
            let before = rig.x(ITEM);
            rig.send(position(ITEM, x + 3.0, [1, stamp, i, 0]));
            prop_assert_eq!(rig.x(ITEM), before);
        }
        prop_assert_eq!(rig.entity(ITEM).timestamps.0[0], base.wrapping_add(8));
        prop_assert_eq!(rig.x(ITEM), 68.0);
    }
}

#[test]
fn wrapped_stamps() {
    for (stored, incoming, newer) in [
        (65535, 0, true),
        (0, 32767, true),
        (0, 32768, false),
        (0, 65535, false),
        (32768, 0, true),
    ] {
        assert_eq!(is_newer(stored, incoming), newer, "{stored} {incoming}");
    }
}

#[test]
fn messages_wait_for_their_object_within_bounds() {
    let mut rig = Rig::new();
    for i in 1..=20 {
        let verdict = rig.send(position(ITEM, 60.0 + f32::from(i), [1, i, 1, 0]));
        let kept = verdict == Verdict::Kept;
        assert_eq!(kept, i <= 16, "{verdict:?}");
    }
    for guid in 0..40u32 {
        for i in 1..=16 {
            rig.send(position(0x9000_0000 + guid, 60.0, [1, i, 0, 0]));
        }
    }
    assert_eq!(rig.entities.waiting().len(), 256);
    assert!(rig.entities.waiting().refused() > 0);
    assert_eq!(rig.send(create(object(ITEM, 1))), Verdict::Applied);
    // They are applied in their order, the last one stands.
    assert_eq!((rig.entity(ITEM).timestamps.0[0], rig.x(ITEM)), (16, 76.0));
    assert_eq!(rig.entities.waiting().len(), 240);
}

#[test]
fn an_attachment_waits_for_both() {
    let mut rig = Rig::new();
    let attach = PlainServerMessage::ParentEvent(m::ParentEvent {
        parent: 0x8000_0010,
        child: ITEM,
        location: 1,
        placement: 0x65,
        parent_instance: 1,
        child_position: 1,
    });
    assert_eq!(rig.send(attach), Verdict::Kept);
    let mut item = object(ITEM, 1);
    item.physics.fields.setup = Some(0x0200_0008);
    item.physics.fields.motion_table = None;
    assert_eq!(rig.send(create(item)), Verdict::Applied);
    assert_eq!(
        (rig.entity(ITEM).parent(), rig.entities.waiting().len()),
        (None, 1)
    );
    assert_eq!(rig.send(create(object(0x8000_0010, 1))), Verdict::Applied);
    let parent = rig.entities.get(0x8000_0010).map(|e| e.id);
    assert_eq!(
        (rig.entity(ITEM).parent(), rig.entities.waiting().len()),
        (parent, 0)
    );
}
