use std::{collections::BTreeMap, io::Cursor, num::NonZeroU32, path::Path};

use ac_client::{
    frame::{FrameState, FrameStates},
    profile::Profile,
};
use ac_golden_traces::{
    corpus,
    trace::{FormatVersion, SeekableTrace, TraceInfo, TraceReader},
};
use proptest::prelude::*;

use super::{
    Identity, KeyframeError, KeyframeHeader, Versions, decode, encode, frame_of, fuzzing, name_of,
};
use crate::{Simulator, client::ClientSimulator};

fn identity() -> Identity {
    let info = TraceInfo {
        version: FormatVersion::CURRENT,
        scene: "a/b".into(),
        producer: String::new(),
        profile: "gdle".into(),
        world: BTreeMap::from([("client_cell_1.dat".to_owned(), "00".to_owned())]),
    };
    Identity::new(&info, b"the scene", &Profile::gdle())
}

#[test]
fn names_are_canonical() {
    assert_eq!(frame_of(&name_of(119)), Some(119));
    for other in [
        "keyframe/",
        "keyframe/007",
        "keyframe/+7",
        "scene.json",
        "keyframe/x",
    ] {
        assert_eq!(frame_of(other), None, "{other}");
    }
}

#[test]
fn what_is_written_is_read() {
    let snapshot: Vec<u8> = (0..10_000_u32)
        .flat_map(|i| (i % 97).to_le_bytes())
        .collect();
    let header = KeyframeHeader::new(29, &identity(), &snapshot);
    let bytes = encode(&header, &snapshot).unwrap();
    assert!(bytes.len() < snapshot.len() / 4, "it is compressed");
    let (again, same) = decode(&bytes).unwrap();
    assert!(again == header && same == snapshot);
    identity().accept(&again).unwrap();
}

/// A keyframe with something else in its header.
fn changed(change: impl FnOnce(&mut KeyframeHeader)) -> String {
    let snapshot = b"state".to_vec();
    let mut header = KeyframeHeader::new(29, &identity(), &snapshot);
    change(&mut header);
    let bytes = encode(&header, &snapshot).unwrap();
    let refused = decode(&bytes).and_then(|(header, _)| identity().accept(&header));
    refused.expect_err("it is refused").to_string()
}

#[test]
fn other_versions_are_refused() {
    let newer = changed(|h| h.versions.world = Versions::CURRENT.world + 1);
    insta::assert_snapshot!(newer.replace(&format!("version {}", Versions::CURRENT.world + 1), "version NEXT").replace(&format!("reads {}", Versions::CURRENT.world), "reads THIS"), @"the keyframe has version NEXT of its world form, this program reads THIS; write the trace again with `ac-replay run --keyframes`, or run it from the start with `--from-start`");
    assert!(changed(|h| h.versions.scene = 0).contains("version 0 of its scene form"));
    assert!(changed(|h| h.versions.keyframe = 0).contains("version 0 of its keyframe format"));
    insta::assert_snapshot!(changed(|h| h.format = "else".into()), @"not a keyframe: its header says `else`");
}

#[test]
fn keyframes_of_other_runs_are_refused() {
    insta::assert_snapshot!(changed(|h| h.identity.scene = "c/d".into()), @"the keyframe belongs to another scene: it has `c/d`, this is `a/b`");
    insta::assert_snapshot!(changed(|h| h.identity.scene_hash = "1".into()).split(": ").next().unwrap(), @"the keyframe belongs to another scene file");
    insta::assert_snapshot!(changed(|h| h.identity.profile = "ace".into()), @"the keyframe belongs to another profile: it has `ace`, this is `gdle`");
    insta::assert_snapshot!(changed(|h| h.identity.profile_hash = "1".into()).split(": ").next().unwrap(), @"the keyframe belongs to another form of profile gdle");
    let world = |hash: &str| BTreeMap::from([("client_cell_1.dat".to_owned(), hash.to_owned())]);
    insta::assert_snapshot!(changed(|h| h.identity.world = world("11")), @"the keyframe belongs to another world (client_cell_1.dat): it has `11`, this is `00`");
    insta::assert_snapshot!(changed(|h| h.identity.world.clear()), @"the keyframe belongs to another world (client_cell_1.dat): it has `no such file`, this is `00`");
}

#[test]
fn damage_is_noticed() {
    let snapshot: Vec<u8> = (0..999_u32).flat_map(u32::to_le_bytes).collect();
    let bytes = encode(&KeyframeHeader::new(0, &identity(), &snapshot), &snapshot).unwrap();
    assert!(decode(&bytes[..bytes.len() - 1]).is_err());
    let end = bytes.iter().position(|b| *b == b'\n').unwrap();
    assert!(decode(&bytes[..end]).is_err(), "no state");
    let mut flipped = bytes.clone();
    *flipped.last_mut().unwrap() ^= 1;
    assert!(decode(&flipped).is_err());
    // A small file that says, and unpacks to, a lot.
    let zeros = vec![0; 1 << 20];
    let mut header = KeyframeHeader::new(0, &identity(), &zeros);
    header.length = 10;
    let error = decode(&encode(&header, &zeros).unwrap()).unwrap_err();
    assert!(matches!(error, KeyframeError::Damaged(_)), "{error}");
    header.length = super::MAX_SNAPSHOT + 1;
    let error = decode(&encode(&header, &zeros).unwrap()).unwrap_err();
    assert!(matches!(error, KeyframeError::Format(_)), "{error}");
}

/// The state of the fuzz scene after some frames.
fn state_after(frames: u32) -> Vec<u8> {
    let path = corpus::bundled().join(format!("traces/{}.mcap", fuzzing::SCENE));
    let scene = TraceReader::open(&path).unwrap().scene().clone();
    let simulator = ClientSimulator::new(corpus::bundled().join("worlds"));
    let mut simulation = simulator.start(&scene, &Profile::gdle()).unwrap();
    let mut states = FrameStates::new();
    for frame in 0..frames {
        states.clear();
        simulation.step(frame, &mut states).unwrap();
    }
    simulation.snapshot().unwrap().unwrap()
}

#[test]
fn malformed_states_are_errors() {
    let whole = state_after(20);
    fuzzing::snapshot(&whole);
    for length in (0..whole.len()).step_by(whole.len() / 97 + 1) {
        fuzzing::keyframe(&whole[..length]);
    }
    // Every byte of the names and lengths at the front, then some of the numbers.
    let mut random = 1_u64;
    for round in 0..1500 {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let at = (random >> 33) as usize % whole.len();
        let mut damaged = whole.clone();
        damaged[at] ^= 1 << (round % 8);
        fuzzing::snapshot(&damaged);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..512)) {
        fuzzing::keyframe(&bytes);
    }
}

/// Counts what is read.
struct Counting<'a> {
    inner: Cursor<&'a [u8]>,
    read: u64,
}

impl std::io::Read for Counting<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let read = self.inner.read(buffer)?;
        self.read += read as u64;
        Ok(read)
    }
}

impl std::io::Seek for Counting<'_> {
    fn seek(&mut self, to: std::io::SeekFrom) -> std::io::Result<u64> {
        self.inner.seek(to)
    }
}

/// Seeking reads the head, the index, one keyframe and one chunk, however long the trace.
#[test]
fn seeking_does_not_read_the_whole_file() {
    use ac_golden_traces::trace::{ChannelKind, Compression, TraceWriter};

    const FRAMES: u32 = 40_000;
    let text = format!(
        r#"{{"schema":"ac-scene/1","name":"a/b","summary":"s","world":"w","start_time":0,"frames":[{{"dt":0.5,"count":{FRAMES}}}],"track":["0x1"]}}"#
    );
    let scene = ac_golden_traces::Scene::parse(text.as_bytes(), Path::new("b.scene.json")).unwrap();
    let info = TraceInfo {
        version: FormatVersion::CURRENT,
        scene: scene.name.clone(),
        producer: String::new(),
        profile: "gdle".into(),
        world: BTreeMap::new(),
    };
    let out = Cursor::new(Vec::new());
    let mut writer = TraceWriter::new(out, &info, text.as_bytes(), Compression::Fast).unwrap();
    writer.add_channel(ChannelKind::States, None).unwrap();
    let mut noise = 1_u32;
    let every = NonZeroU32::new(5000).unwrap();
    for (frame, time) in (0_i32..).zip(scene.times()) {
        let mut number = || {
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f32::from_bits(noise & 0x3FFF_FFFF)
        };
        let state = FrameState {
            guid: 1,
            has: ac_client::frame::state::Fields::ORIGIN
                | ac_client::frame::state::Fields::VELOCITY,
            origin: [number(), number(), number()],
            velocity: [number(), number(), number()],
            ..FrameState::default()
        };
        writer
            .write_states(&ChannelKind::States, frame, time, &[state])
            .unwrap();
        if (frame.cast_unsigned() + 1).is_multiple_of(every.get()) {
            writer
                .attach(&name_of(frame), super::MEDIA_TYPE, time, &[7; 100_000])
                .unwrap();
        }
    }
    let file = writer.finish().unwrap().into_inner();
    let mut source = Counting {
        inner: Cursor::new(&file),
        read: 0,
    };
    let mut trace = SeekableTrace::new(&mut source, Path::new("b.mcap")).unwrap();
    assert_eq!(
        trace.attachment(&name_of(29_999)).unwrap().unwrap().len(),
        100_000
    );
    assert_eq!(trace.attachment(&name_of(30_000)).unwrap(), None);
    let mut seen = Vec::new();
    trace
        .states(&ChannelKind::States, 31_234..=31_236, |frame, time, _| {
            seen.push((frame, time))
        })
        .unwrap();
    assert_eq!(
        seen,
        [(31_234, 15_617.5), (31_235, 15_618.0), (31_236, 15_618.5)]
    );
    drop(trace);
    assert!(
        source.read * 3 < file.len() as u64,
        "{} of {} bytes were read",
        source.read,
        file.len()
    );
}
