//! Worked examples, hard cases and invariants of `spec/10-messages.md`, 10, 15 and 16.

use proptest::prelude::*;

use super::common::*;
use super::movement::{MovementData, RawState, SequencedMovement};
use super::player_description::*;
use super::position::PositionPack;
use super::weenie_desc::{WeenieDesc, WeenieFields};
use super::wire::*;
use super::*;
use crate::motion::wire::WireError;
use crate::motion::{Command, UpdateKind};

fn hex(text: &str) -> Vec<u8> {
    text.split_ascii_whitespace()
        .map(|b| u8::from_str_radix(b, 16).expect("hexadecimal"))
        .collect()
}

const UPDATE_POSITION: &str = "48 F7 00 00 01 00 00 50 34 00 00 00 19 00 B4 A9
    00 00 A8 42 00 00 E8 40 00 00 BC 42 F3 04 35 3F F3 04 35 BF 05 00 02 01 01 00 00 00";
const UPDATE_POSITION_FULL: &str = "48 F7 00 00 01 00 00 50 07 00 00 00 19 00 B4 A9
    00 00 A8 42 00 00 E8 40 00 00 BC 42 F3 04 35 3F 00 00 00 00 00 00 00 00 F3 04 35 BF 00 00 00 00
    00 00 80 40 00 00 00 00 65 00 00 00 05 00 03 01 01 00 00 00";
const UPDATE_MOTION: &str = "4C F7 00 00 01 00 00 50 05 00 21 00 03 00 01 00
    00 00 3D 00 87 00 00 00 3D 00 07 00 00 00 20 40 87 00 05 80 00 00 80 3F";
const UPDATE_MOTION_MOVE: &str = "4C F7 00 00 02 40 9B 7A 01 00 10 00 11 00 00 00
    06 00 3C 00 01 00 00 50 19 00 B4 A9 00 00 A8 42 00 00 E8 40 00 00 BC 42 1F EE 01 00 9A 99 19 3F
    00 00 00 00 FF FF 7F 7F 00 00 80 3F 00 00 70 41 00 00 00 00 00 00 C0 3F";
const MOVE_TO_STATE: &str = "B1 F7 00 00 12 00 00 00 1C F6 00 00 0D 00 00 00
    02 00 00 00 05 00 00 45 02 00 00 00 19 00 B4 A9 00 00 A8 42 00 00 E8 40 00 00 BC 42 F3 04 35 3F
    00 00 00 00 00 00 00 00 F3 04 35 BF 05 00 03 00 01 00 00 00 01 00 00 00";
const AUTONOMOUS_POSITION: &str = "B1 F7 00 00 13 00 00 00 53 F7 00 00 19 00 B4 A9
    00 00 A8 42 00 00 E8 40 00 00 BC 42 F3 04 35 3F 00 00 00 00 00 00 00 00 F3 04 35 BF 05 00 03 00
    01 00 00 00 01 00 00 00";
const JUMP: &str = "B1 F7 00 00 14 00 00 00 1B F6 00 00 00 00 00 3F
    00 00 00 00 00 00 80 40 00 00 F0 40 19 00 B4 A9 00 00 A8 42 00 00 E8 40 00 00 BC 42 F3 04 35 3F
    00 00 00 00 00 00 00 00 F3 04 35 BF 05 00 03 00 01 00 00 00";
const CREATE_DOOR: &str = "45 F7 00 00 01 40 9B 7A 11 00 00 00 03 80 01 00
    08 00 01 00 0C 00 00 00 00 00 3D 00 03 00 00 00 3D 00 0C 00 00 00 00 00 00 01 B4 A9 00 00 48 41
    00 00 50 C0 00 00 00 00 00 00 80 3F 00 00 00 00 00 00 00 00 00 00 00 00 16 00 00 09 B4 01 00 02
    00 00 01 00 00 00 00 00 00 00 01 00 00 00 00 00 01 00 00 00 30 00 00 00 04 00 44 6F 6F 72 00 00
    9C 01 17 13 80 00 00 00 14 10 00 00 20 00 00 00 00 00 00 40";

fn server(bytes: &[u8]) -> ServerMessage {
    let parsed = ServerMessage::parse(bytes).expect("a valid message");
    assert!(parsed.extra.is_empty(), "{:?}", parsed.extra);
    assert_eq!(parsed.message.to_bytes(), bytes);
    parsed.message
}

fn plain(text: &str) -> PlainServerMessage {
    match server(&hex(text)) {
        ServerMessage::Plain(message) => message,
        other => panic!("not a plain message: {other:?}"),
    }
}

fn action(text: &str, length: usize) -> GameAction {
    let bytes = hex(text);
    assert_eq!(bytes.len(), length);
    let parsed = ClientMessage::parse(&bytes).expect("a valid message");
    assert!(parsed.extra.is_empty());
    assert_eq!(parsed.message.to_bytes(), bytes);
    match parsed.message {
        ClientMessage::Action { action, .. } => action,
        other => panic!("not an action: {other:?}"),
    }
}

/// The place of all examples.
fn place() -> WirePosition {
    let h = f32::from_bits(0x3F35_04F3);
    WirePosition {
        cell: 0xA9B4_0019,
        origin: [84.0, 7.25, 94.0],
        rotation: [h, 0.0, 0.0, -h],
    }
}

#[test]
fn position_updates() {
    let PlainServerMessage::UpdatePosition(m) = plain(UPDATE_POSITION) else {
        panic!("not a position");
    };
    assert_eq!((m.guid, m.position.position), (0x5000_0001, place()));
    assert!(m.position.contact());
    let s = m.position.stamps;
    assert_eq!(
        (s.instance, s.position, s.teleport, s.force),
        (5, 0x102, 1, 0)
    );
    assert_eq!(PositionPack::new(place(), true, s), m.position);

    let PlainServerMessage::UpdatePosition(m) = plain(UPDATE_POSITION_FULL) else {
        panic!("not a position");
    };
    assert_eq!(m.position.velocity, Some([0.0, 4.0, 0.0]));
    assert_eq!(m.position.placement, Some(0x65));
    assert_eq!(m.position.position, place());
}

#[test]
fn movement_updates() {
    let PlainServerMessage::UpdateMotion(m) = plain(UPDATE_MOTION) else {
        panic!("not a movement");
    };
    let q = &m.movement;
    assert_eq!((q.movement, q.server_control, q.autonomous), (0x21, 3, 1));
    let update = q.data.update().expect("readable");
    assert_eq!(update.style, Command::NON_COMBAT);
    let UpdateKind::State(state, None) = &update.kind else {
        panic!("not a state: {update:?}");
    };
    assert_eq!(
        (state.forward_command, state.forward_speed),
        (Command::RUN_FORWARD, 2.5)
    );
    let actions: Vec<_> = state
        .actions
        .iter()
        .map(|a| (a.stamp, a.autonomous))
        .collect();
    assert_eq!(actions, [(5, true)]);

    let PlainServerMessage::UpdateMotion(m) = plain(UPDATE_MOTION_MOVE) else {
        panic!("not a movement");
    };
    let update = m.movement.data.update().expect("readable");
    let UpdateKind::MoveToObject {
        guid,
        params,
        run_rate,
        ..
    } = &update.kind
    else {
        panic!("not a move: {update:?}");
    };
    assert_eq!(
        (*guid, params.flags.bits(), *run_rate),
        (0x5000_0001, 0x1EE1F, 1.5)
    );
    // An example without redundant fields is what the writer writes.
    assert_eq!(
        MovementData::new(update.clone()).bytes(),
        &hex(UPDATE_MOTION_MOVE)[16..]
    );
}

#[test]
fn actions() {
    let GameAction::MoveToState(m) = action(MOVE_TO_STATE, 72) else {
        panic!("not a state");
    };
    assert_eq!((m.position, m.bits), (place(), 1));
    assert_eq!(m.state.state().forward.command, Command::WALK_FORWARD);
    assert_eq!(RawState::new(m.state.state().clone()), m.state);
    let s = m.stamps;
    assert_eq!(
        (s.instance, s.server_control, s.teleport, s.force),
        (5, 3, 1, 0)
    );
    let GameAction::AutonomousPosition(m) = action(AUTONOMOUS_POSITION, 56) else {
        panic!("not a position");
    };
    assert_eq!((m.position, m.contact), (place(), 1));
    let GameAction::Jump(m) = action(JUMP, 68) else {
        panic!("not a jump");
    };
    assert_eq!((m.extent, m.velocity), (0.5, [0.0, 4.0, 7.5]));
}

#[test]
fn a_door_is_created() {
    let PlainServerMessage::CreateObject(door) = plain(CREATE_DOOR) else {
        panic!("not an object");
    };
    let p = &door.physics;
    assert_eq!((door.guid, p.state), (0x7A9B_4001, 0x10008));
    assert_eq!(p.timestamps, [0, 1, 0, 0, 0, 1, 0, 0, 1]);
    assert_eq!(p.fields.motion_table, Some(0x0900_0016));
    assert_eq!(p.fields.setup, Some(0x0200_01B4));
    assert_eq!(
        p.fields.position.map(|p| p.origin),
        Some([12.5, -3.25, 0.0])
    );
    let w = &door.weenie;
    assert_eq!((w.name.to_str().as_ref(), w.class.0), ("Door", 412));
    assert_eq!(
        (w.icon.0, w.item_type, w.object_bits),
        (0x0600_1317, 0x80, 0x1014)
    );
    assert_eq!(
        (w.fields.usable, w.fields.use_radius),
        (Some(0x20), Some(2.0))
    );
}

#[test]
fn movement_windows_of_any_length() {
    // Case 6: the field after the window starts at the same place whatever the window holds.
    let bytes = hex(CREATE_DOOR);
    for n in [0usize, 4, 8, 12, 16, 40] {
        let mut changed = bytes[..20].to_vec();
        changed.extend((n as u32).to_le_bytes());
        let mut window = bytes[24..36].to_vec();
        window.resize(n, 0);
        changed.extend(window);
        changed.extend(if n == 0 { &bytes[40..] } else { &bytes[36..] });
        let ServerMessage::Plain(PlainServerMessage::CreateObject(door)) = server(&changed) else {
            panic!("not an object");
        };
        assert_eq!(door.physics.fields.motion_table, Some(0x0900_0016));
        let physics_desc::Motion::Movement { data, .. } = &door.physics.motion else {
            panic!("no movement");
        };
        let readable = data.as_ref().map(|(d, _)| d.update().is_ok());
        assert_eq!(readable, if n == 0 { None } else { Some(n >= 12) });
    }
}

#[test]
fn movements_without_payload_are_kept() {
    let mut bytes = hex(UPDATE_MOTION);
    bytes[16] = 3;
    let parsed = ServerMessage::parse(&bytes).expect("kept");
    assert_eq!(parsed.extra, &bytes[20..]);
    let ServerMessage::Plain(PlainServerMessage::UpdateMotion(m)) = parsed.message else {
        panic!("not a movement");
    };
    let error = WireError::MovementType { at: 16, value: 3 };
    assert_eq!(m.movement.data.update(), Err(error));
}

#[test]
fn all_fields_and_31_actions() {
    let mut bytes = hex(UPDATE_MOTION)[..20].to_vec();
    bytes.extend([0xFF; 4]);
    bytes.extend([0u8; 20 + 31 * 8]);
    let ServerMessage::Plain(PlainServerMessage::UpdateMotion(m)) = server(&bytes) else {
        panic!("not a movement");
    };
    assert!(m.movement.data.has_unknown_bits());
    let Ok(UpdateKind::State(state, _)) = m.movement.data.update().map(|u| &u.kind) else {
        panic!("not a state");
    };
    assert_eq!(state.actions.len(), 31);
}

#[test]
fn errors_say_where() {
    let bytes = hex(UPDATE_POSITION);
    let error = ServerMessage::parse(&bytes[..30]).expect_err("too short");
    assert_eq!(
        error.to_string(),
        "message UpdatePosition: at offset 28: 4 bytes wanted, 2 are left"
    );
    let mut door = hex(CREATE_DOOR);
    door[8] = 0x12;
    let error = ServerMessage::parse(&door).expect_err("no marker");
    assert_eq!(error.error.offset, 8);
    door[8] = 0x11;
    door[15] = 0x80;
    let error = ServerMessage::parse(&door).expect_err("unknown bits");
    assert_eq!(error.error.problem, Problem::UnknownFlags(0x8000_0000));
}

#[test]
fn what_is_unknown_is_kept_and_named() {
    let bytes = hex("78 56 34 12 01 02 03");
    let message = server(&bytes);
    assert_eq!(message.name(), "unknown 0x12345678");
    assert_eq!(names::action_name(0x0065), "admin 0x0065");
    assert_eq!(names::event_name(0x0202), "Trade: accept");
    assert_eq!(
        names::opcode_name(0xF7D9, Direction::ToServer),
        "CharacterRestore"
    );
    assert_eq!(
        names::opcode_name(0xF752, Direction::ToServer),
        "AutonomyLevel"
    );
    assert_eq!(names::opcode_name(0x02BD, Direction::ToClient), "Tell");
    assert_eq!(message_name(&hex(JUMP), Direction::ToServer), "Jump");
    assert_eq!(message_name(&[1], Direction::ToServer), "no opcode");
}

#[test]
fn packed_numbers() {
    for (value, size) in [
        (0, 2),
        (0x7FFF, 2),
        (0x8000, 4),
        (0xFFFF, 4),
        (0x10000, 4),
        (0x3FFF_FFFF, 4),
    ] {
        let mut w = Writer::default();
        PackedU32(value).write(&mut w);
        assert_eq!(w.bytes.len(), size);
        assert_eq!(Reader::new(&w.bytes).get(), Ok(PackedU32(value)));
    }
    assert_eq!(
        Reader::new(&[0, 0]).get::<IconDid>().map(IconDid::get),
        Ok(None)
    );
}

#[test]
fn texts_take_any_bytes() {
    let mut w = Writer::default();
    Text(vec![b'a', 0, 0x80]).write(&mut w);
    assert_eq!(w.bytes, [3, 0, b'a', 0, 0x80, 0, 0, 0]);
    let text: Text = Reader::new(&w.bytes).get().expect("a text");
    assert_eq!(text.to_str(), "a\0€");
    let escape = Reader::new(&[0xFF, 0xFF, 1, 0, 0, 0]).get::<Text>();
    assert_eq!(escape.map_err(|e| e.problem), Err(Problem::TextLength));
    assert!(Reader::new(&[9, 0, 1]).get::<Text>().is_err());
}

#[test]
fn wide_texts_of_every_length_form() {
    for n in [0usize, 1, 127, 128, 0x3FFF, 0x4000, 70_000] {
        let text = WideText(vec![0x41; n]);
        let mut w = Writer::default();
        text.write(&mut w);
        assert_eq!(Reader::new(&w.bytes).get(), Ok(text));
    }
}

#[test]
fn counts_are_checked_before_anything_is_allocated() {
    let mut bytes = hex("B0 F7 00 00 00 00 00 00 00 00 00 00 96 01 00 00 01 00 00 00");
    bytes.extend(u32::MAX.to_le_bytes());
    let error = ServerMessage::parse(&bytes).expect_err("no such count");
    assert!(matches!(
        error.error.problem,
        Problem::Count { entry: 8, .. }
    ));
    assert_eq!(error.error.offset, 24);
}

#[test]
fn public_texts_name_the_key_first() {
    let update = PropertyUpdate {
        sequence: 1,
        guid: Some(2),
        key: 3,
        value: property::PropertyValue::Text(Text::new("ab")),
    };
    let bytes = ServerMessage::Property(update).to_bytes();
    assert_eq!(
        bytes,
        hex("D6 02 00 00 01 03 00 00 00 02 00 00 00 00 00 00 02 00 61 62")
    );
    server(&bytes);
    for opcode in (0x02CD..=0x02EA)
        .chain(0x01D1..=0x01DE)
        .chain(0x02B8..=0x02B9)
    {
        let mut bytes = u32::to_le_bytes(opcode).to_vec();
        bytes.resize(80, 0);
        let parsed = ServerMessage::parse(&bytes).expect("a property");
        let ServerMessage::Property(update) = parsed.message else {
            panic!("not a property");
        };
        assert_eq!(update.opcode(), opcode);
        assert_eq!(
            update.guid.is_some(),
            opcode % 2
                == if opcode == 0x02B9 || opcode == 0x02B8 {
                    1
                } else {
                    0
                }
        );
    }
}

#[test]
fn turbine_chat_with_wrong_counts() {
    let event = chat::ChatEvent {
        room: 7,
        sender: WideText::new("Ann"),
        text: WideText::new("hello"),
        size: 12,
        guid: 1,
        zero: 0,
        kind: 2,
    };
    let mut chat = chat::TurbineChat::new(1, chat::ChatBlob::Event(event));
    chat.header[0] += 8;
    chat.header[8] += 8;
    let message = ServerMessage::Plain(PlainServerMessage::TurbineChat(chat));
    assert_eq!(server(&message.to_bytes()), message);
}

fn description(options: PlayerOptions) -> ServerMessage {
    let inventory = List(vec![ContentProfile {
        guid: 0x8000_0001,
        kind: 1,
    }]);
    let wielded = List(vec![Placement {
        guid: 0x8000_0002,
        location: 2,
        priority: 4,
    }]);
    ServerMessage::Event {
        guid: 0x5000_0001,
        sequence: 1,
        event: GameEvent::PlayerDescription(Box::new(PlayerDescription {
            weenie_type: 10,
            has_health: 1,
            options,
            inventory,
            wielded,
            ..PlayerDescription::default()
        })),
    }
}

#[test]
fn a_player_with_unknown_window_options() {
    let known = [2, 0, 0, 0, 4, 1, 0x8A, 0, 0, 0x10, 1, 2, 3, 4, 5, 0].to_vec();
    let unknown = [2, 0, 0, 0, 4, 1, 0x77, 0, 0, 0x10, 1, 2, 3, 4, 5, 6].to_vec();
    for (mut bytes, guessed) in [(known, false), (unknown, true)] {
        if !guessed {
            bytes.truncate(15);
        }
        let options = PlayerOptions {
            gameplay: Some(GameplayOptions { bytes, guessed }),
            spell_bars: vec![List::default()],
            ..PlayerOptions::default()
        };
        let message = description(options);
        assert_eq!(server(&message.to_bytes()), message);
    }
}

#[test]
fn an_empty_player() {
    for bits in [0, 0x4, 0x10, 0x400] {
        let bars = [(0, 1), (0x4, 5), (0x10, 7), (0x400, 8)];
        let n = bars.iter().find(|b| b.0 == bits).map_or(1, |b| b.1);
        let options = PlayerOptions {
            bits,
            spell_bars: vec![List::default(); n],
            ..PlayerOptions::default()
        };
        let message = description(options);
        assert_eq!(server(&message.to_bytes()), message);
    }
}

#[test]
fn session_messages() {
    let minimal = hex("E6 F7 00 00 01 00 00 00 00 00 00 00");
    let parsed = ClientMessage::parse(&minimal).expect("a response");
    assert_eq!(parsed.message.to_bytes(), minimal);
    let set = session::IntSet {
        covered: 5,
        entries: vec![1, -5],
    };
    let mut w = Writer::default();
    set.write(&mut w);
    assert_eq!(Reader::new(&w.bytes).get(), Ok(set));
    let list = session::CharacterList {
        characters: List(vec![session::CharacterEntry {
            guid: 0x5000_0001,
            name: Text::new("Ann"),
            deletion: 0,
        }]),
        slots: 11,
        account: Text::new("tester"),
        ..session::CharacterList::default()
    };
    let message = ServerMessage::Plain(PlainServerMessage::CharacterList(list));
    assert_eq!(server(&message.to_bytes()), message);
    for bytes in ["DC F7 00 00", "53 F6 00 00", "43 F6 00 00 02 00 00 00"] {
        server(&hex(bytes));
    }
}

fn text() -> impl Strategy<Value = Text> {
    prop::collection::vec(any::<u8>(), 0..20).prop_map(Text)
}

prop_compose! {
    fn weenie()(words in prop::collection::vec(any::<u32>(), 8), name in text(), plural in prop::option::of(text()),
        small: (Option<u8>, Option<u16>, Option<u32>, Option<u8>), house in prop::option::of(prop::collection::vec((any::<u32>(), any::<u32>()), 0..5)),
        class in 0u32..0x8000_0000, icon in 1u32..0x10000, pet: Option<u32>)
        -> WeenieDesc
    {
        let restrictions = house.map(|entries| weenie_desc::HouseRestrictions {
            version: words[0], open: 1, monarch: words[1], guests: Table { buckets: 64, entries },
        });
        let second = if pet.is_some() { 0x400_0000 } else { 0 };
        WeenieDesc {
            name, class: PackedU32(class), icon: PackedDid(0x0600_0000 + icon), item_type: words[2],
            object_bits: words[3] & !0x400_0000 | second, unknown_header: 0,
            fields: WeenieFields {
                plural_name: plural, items_capacity: small.0, burden: small.1, value: small.2, radar_colour: small.3,
                restrictions, pet_owner: pet, icon_overlay: pet.map(|_| PackedDid(0x0600_0000 + icon)),
                ..WeenieFields::default()
            },
        }
    }
}

prop_compose! {
    fn pack()(cell: u32, origin in [-200.0f32..200.0, -200.0f32..200.0, -200.0f32..200.0],
        rotation in prop::array::uniform4(prop_oneof![Just(0.0f32), Just(-0.0), -1.0f32..1.0]),
        velocity in prop::option::of(prop::array::uniform3(-9.0f32..9.0)), placement: Option<u32>, contact: bool, all: bool, s: [u16; 4])
        -> PositionPack
    {
        let stamps = position::PositionStamps { instance: s[0], position: s[1], teleport: s[2], force: s[3] };
        let mut pack = PositionPack::new(WirePosition { cell, origin, rotation }, contact, stamps);
        if all { pack = pack.with_all_components(); }
        pack.velocity = velocity;
        pack.placement = placement;
        pack
    }
}

proptest! {
    #[test]
    fn position_packs_survive(pack in pack()) {
        let mut w = Writer::default();
        pack.write(&mut w);
        prop_assert_eq!(w.bytes.len() % 4, 0);
        let back: PositionPack = Reader::new(&w.bytes).get().unwrap();
        prop_assert_eq!(&back, &pack);
        let message = PlainServerMessage::UpdatePosition(object::UpdatePosition { guid: 1, position: pack.clone() });
        let bytes = ServerMessage::Plain(message).to_bytes();
        let written = (0..4).filter(|i| bytes[8] & (8 << i) == 0).count();
        let extra = 12 * usize::from(pack.velocity.is_some()) + 4 * usize::from(pack.placement.is_some());
        prop_assert_eq!(w.bytes.len(), 4 + 16 + 4 * written + extra + 8);
    }

    #[test]
    fn game_descriptions_survive(weenie in weenie()) {
        let mut w = Writer::default();
        weenie.write(&mut w);
        prop_assert_eq!(w.bytes.len() % 4, 0);
        let mut r = Reader::new(&w.bytes);
        prop_assert_eq!(r.get::<WeenieDesc>().unwrap(), weenie);
        prop_assert_eq!(r.left(), 0);
    }

    #[test]
    fn any_bytes_are_read_or_refused(opcode in prop::sample::select(OPCODES), kind in 0u32..0x316, rest in prop::collection::vec(any::<u8>(), 0..300)) {
        let mut bytes = opcode.to_le_bytes().to_vec();
        if opcode == GAME_EVENT {
            bytes.extend([0; 8]);
            bytes.extend(kind.to_le_bytes());
        } else if opcode == GAME_ACTION {
            bytes.extend([0; 4]);
            bytes.extend(kind.to_le_bytes());
        }
        bytes.extend(rest);
        if let Ok(parsed) = ServerMessage::parse(&bytes) {
            // What is read is written so that it reads the same.
            let again = parsed.message.to_bytes();
            let back = ServerMessage::parse(&again).unwrap().message;
            prop_assert_eq!(back.to_bytes(), again);
        }
        if let Ok(parsed) = ClientMessage::parse(&bytes) {
            let again = parsed.message.to_bytes();
            let back = ClientMessage::parse(&again).unwrap().message;
            prop_assert_eq!(back.to_bytes(), again);
        }
    }

    #[test]
    fn damaged_messages_are_read_or_refused(which in 0usize..8, at in 0usize..140, byte: u8, cut in 0usize..140) {
        let examples = [UPDATE_POSITION, UPDATE_POSITION_FULL, UPDATE_MOTION, UPDATE_MOTION_MOVE, MOVE_TO_STATE,
            AUTONOMOUS_POSITION, JUMP, CREATE_DOOR];
        let mut bytes = hex(examples[which]);
        let n = bytes.len();
        bytes[at % n] = byte;
        bytes.truncate(n - cut % n);
        let _ = ServerMessage::parse(&bytes);
        let _ = ClientMessage::parse(&bytes);
    }
}

const OPCODES: &[u32] = &[
    0x0024, 0x0197, 0x019E, 0x01D5, 0x01E0, 0x02BB, 0x02BC, 0x02D5, 0x02D6, 0x02DD, 0xF619, 0xF625,
    0xF643, 0xF655, 0xF656, 0xF657, 0xF658, 0xF745, 0xF747, 0xF748, 0xF749, 0xF74C, 0xF74E, 0xF7B0,
    0xF7B0, 0xF7B0, 0xF7B1, 0xF7B1, 0xF7C1, 0xF7DB, 0xF7DC, 0xF7DE, 0xF7E1, 0xF7E2, 0xF7E5, 0xF7E6,
    0xF7E7,
];

#[test]
fn movements_that_are_built_read_back() {
    let movement = SequencedMovement {
        movement: 1,
        server_control: 2,
        autonomous: 0,
        data: MovementData::default(),
    };
    let message = PlainServerMessage::UpdateMotion(object::UpdateMotion {
        guid: 1,
        instance: 1,
        movement,
    });
    let message = ServerMessage::Plain(message);
    assert_eq!(server(&message.to_bytes()), message);
}
