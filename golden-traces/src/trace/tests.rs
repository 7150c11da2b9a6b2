use std::{io::Cursor, path::Path};

use ac_client::frame::{FrameState, FrameStates, state::Fields};

use super::{
    ChannelKind, Compression, FormatVersion, TraceEvent, TraceInfo, TraceReader, TraceWriter,
};
use crate::{GoldenError, Scene, expect::Header};

const SCENE: &str = r#"{"schema":"ac-scene/1","name":"a/b","summary":"s","world":"w","features":[],"start_time":1000,
    "frames":[{"dt":0.5,"count":2},{"dt":0.25,"count":1}],"track":["0x1"],
    "entities":[],"script":[{"frame":1,"guid":"0x1","do":"jump","extent":0.30000001192092896}]}"#;

fn write(version: FormatVersion, compression: Compression) -> Vec<u8> {
    let scene = Scene::parse(SCENE.as_bytes(), Path::new("b.scene.json")).unwrap();
    let info = TraceInfo {
        version,
        scene: scene.name.clone(),
        producer: "test".into(),
        profile: String::new(),
        world: [("client_portal.dat".to_owned(), "00".to_owned())].into(),
    };
    let header = Header {
        schema: "ac-expect/1".into(),
        scene: "a/b".into(),
        oracle: "o".into(),
        oracle_version: "1".into(),
        notes: vec!["n".into()],
    };
    let mut writer = TraceWriter::new(
        Cursor::new(Vec::new()),
        &info,
        SCENE.as_bytes(),
        compression,
    )
    .unwrap();
    writer.add_channel(ChannelKind::Clock, None).unwrap();
    writer.add_channel(ChannelKind::Script, None).unwrap();
    let kind = ChannelKind::Expect("o".into());
    writer.add_channel(kind.clone(), Some(&header)).unwrap();
    for (frame, time) in scene.times().enumerate() {
        writer.write_inputs(&scene, frame as u32, time).unwrap();
        let state = FrameState {
            guid: 1,
            cell: 7,
            has: Fields::ORIGIN,
            origin: [0.1, -0.0, f32::NAN],
            ..FrameState::default()
        };
        writer
            .write_states(&kind, frame as i32, time, &[state])
            .unwrap();
    }
    writer.finish().unwrap().into_inner()
}

fn read(bytes: &[u8]) -> Result<Vec<String>, GoldenError> {
    let mut reader = TraceReader::new(bytes, Path::new("b.mcap"))?;
    let mut states = FrameStates::new();
    let mut seen = Vec::new();
    while let Some(event) = reader.next_event(&mut states)? {
        seen.push(match event {
            TraceEvent::Clock(run) => format!("clock {} {} {}", run.frame, run.dt, run.count),
            TraceEvent::Script(step) => format!("script {} {:?}", step.frame, step.action),
            TraceEvent::States { kind, frame, time } => {
                format!("{} {frame} {time} {:?}", kind.topic(), states[0].origin)
            }
            TraceEvent::Stages { oracle, message } => format!("stages {oracle} {}", message.frame),
        });
    }
    seen.push(format!(
        "{:?}",
        reader
            .header(&ChannelKind::Expect("o".into()))
            .map(|header| &header.notes)
    ));
    Ok(seen)
}

#[test]
fn a_trace_reads_back() {
    let bytes = write(FormatVersion::CURRENT, Compression::Archive);
    insta::assert_snapshot!(read(&bytes).unwrap().join("\n"), @r#"
    clock 0 0.5 2
    /expect/o 0 1000.5 [0.1, -0.0, NaN]
    script 1 Jump { extent: 0.3 }
    /expect/o 1 1001 [0.1, -0.0, NaN]
    clock 2 0.25 1
    /expect/o 2 1001.25 [0.1, -0.0, NaN]
    Some(["n"])
    "#);
}

#[test]
fn the_same_content_gives_the_same_bytes() {
    for compression in [Compression::Archive, Compression::Fast] {
        assert_eq!(
            write(FormatVersion::CURRENT, compression),
            write(FormatVersion::CURRENT, compression)
        );
    }
}

#[test]
fn newer_minor_is_read_and_newer_major_refused() {
    let newer = FormatVersion {
        minor: FormatVersion::CURRENT.minor + 1,
        ..FormatVersion::CURRENT
    };
    assert!(read(&write(newer, Compression::Fast)).is_ok());
    let newer = FormatVersion {
        major: FormatVersion::CURRENT.major + 1,
        minor: 0,
    };
    assert!(matches!(
        read(&write(newer, Compression::Fast)),
        Err(GoldenError::Version { .. })
    ));
}

#[test]
fn a_cut_or_damaged_file_is_an_error_at_any_place() {
    let bytes = write(FormatVersion::CURRENT, Compression::Fast);
    let whole = read(&bytes).unwrap();
    for end in 0..bytes.len() {
        assert!(
            read(&bytes[..end]).is_err(),
            "cut at {end} of {} went unnoticed",
            bytes.len()
        );
    }
    for place in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x10;
        // Some bytes are outside every checksum (index, padding); a changed result must not pass.
        if let Ok(seen) = read(&damaged) {
            assert_eq!(seen, whole, "damage at {place} went unnoticed");
        }
    }
}

#[test]
fn errors_read_well() {
    let bytes = write(FormatVersion::CURRENT, Compression::Fast);
    insta::assert_snapshot!(read(&bytes[..bytes.len() / 2]).unwrap_err().to_string(), @"b.mcap: the trace is cut off; `mcap recover` can save its whole chunks, or write it again");
    insta::assert_snapshot!(read(b"PK\x03\x04 and so on, long enough").unwrap_err().to_string(), @"b.mcap: not a readable trace: it does not begin and end like an MCAP file");
}

#[test]
fn states_are_replaced_and_the_rest_is_copied() {
    let bytes = write(FormatVersion::CURRENT, Compression::Archive);
    let kind = ChannelKind::Expect("o".into());
    let header = |note: &str| Header {
        schema: "ac-expect/1".into(),
        scene: "a/b".into(),
        oracle: "o".into(),
        oracle_version: "1".into(),
        notes: vec![note.into()],
    };
    let frames = |x: f32| -> Vec<super::rewrite::Frame> {
        let frame = |(frame, time): (i32, f64)| {
            let mut states = FrameStates::new();
            let state = states.push(frame, time, 1);
            state.cell = 7;
            state.has = Fields::ORIGIN;
            state.origin = [x, -0.0, f32::NAN];
            (frame, time, states)
        };
        [(0, 1000.5), (1, 1001.0), (2, 1001.25)].map(frame).to_vec()
    };
    let path = Path::new("b.mcap");
    let replace = |x: f32, note: &str| {
        super::rewrite::replace_states(&bytes, path, &kind, &header(note), &frames(x)).unwrap()
    };
    assert_eq!(replace(0.1, "n"), bytes, "the same states, the same bytes");
    let changed = read(&replace(0.5, "other")).unwrap();
    let before = read(&bytes).unwrap();
    assert_eq!(changed.len(), before.len());
    for (new, old) in changed.iter().zip(&before) {
        if old.starts_with("/expect/o") {
            assert_eq!(*new, old.replace("[0.1,", "[0.5,"));
        } else if !old.starts_with("Some") {
            assert_eq!(new, old);
        }
    }
    assert_eq!(changed.last().unwrap(), "Some([\"other\"])");
    let other = ChannelKind::Expect("nobody".into());
    let error = super::rewrite::replace_states(&bytes, path, &other, &header("n"), &frames(0.1));
    insta::assert_snapshot!(error.unwrap_err(), @"b.mcap: not a readable trace: it has no channel /expect/nobody");
}
