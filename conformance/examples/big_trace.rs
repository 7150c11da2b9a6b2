//! What comparing a very long trace costs: states per second and memory, as one JSON line for `target/comparing.jsonl`.
//!
//! ```sh
//! cargo run --release -p ac-conformance --example big_trace -- write big.mcap 2
//! cargo run --release -p ac-conformance --example big_trace -- compare big.mcap > target/comparing.jsonl
//! rm big.mcap
//! ```
//!
//! `write` puts the expected records of the bundled traces into one trace: four entities, each of which lives through all scenes one after
//! another, again and again with other last bits of the positions, until the file has that size. `compare` reads it from its start, one
//! thread, and compares every record with one that the client could have produced, as `ac-conform run` does.

use std::{
    collections::BTreeMap,
    fs::File,
    io::{BufWriter, Seek, Write},
    path::Path,
    time::Instant,
};

use ac_client::frame::{FrameState, FrameStates};
use ac_conformance::compare::Comparison;
use ac_golden_traces::{
    Scene, corpus,
    expect::{EXPECT_SCHEMA, Header},
    trace::{
        ChannelKind, Compression, FormatVersion, TraceEvent, TraceInfo, TraceReader, TraceWriter,
    },
};

type Failure = Box<dyn std::error::Error>;

/// Entities of the long trace.
const PER_FRAME: usize = 4;
/// Seconds of a frame.
const DT: f64 = 1.0 / 30.0;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["write", path, gigabytes] => {
            write(Path::new(path), (gigabytes.parse::<f64>()? * 1e9) as u64)
        }
        ["compare", path] => compare(Path::new(path)),
        _ => Err("usage: big_trace write FILE GIGABYTES | compare FILE".into()),
    }
}

/// Expected records of all bundled traces, one entity after another, its frames in order.
fn bundled() -> Result<Vec<FrameState>, Failure> {
    let mut records = Vec::new();
    let mut states = FrameStates::new();
    for path in corpus::find(&corpus::bundled().join("traces"), &[".mcap"])? {
        let mut reader = TraceReader::open(&path)?;
        reader.select(|kind| matches!(kind, ChannelKind::Expect(_)));
        let mut lives: BTreeMap<(String, u32), Vec<FrameState>> = BTreeMap::new();
        while let Some(event) = reader.next_event(&mut states)? {
            let TraceEvent::States { kind, .. } = event else {
                continue;
            };
            for state in states.iter() {
                let life = lives.entry((kind.topic(), state.guid)).or_default();
                life.push(state.clone());
            }
        }
        records.extend(lives.into_values().flatten());
    }
    Ok(records)
}

/// The records of a frame: the next one of each entity's lives.
fn fill(states: &mut FrameStates, records: &[FrameState], frame: i32, time: f64) {
    states.clear();
    for place in 0..PER_FRAME {
        let at = frame.cast_unsigned() as usize + place * records.len() / PER_FRAME;
        let round = at / records.len();
        let from = &records[at % records.len()];
        let to = states.push(frame, time, from.guid);
        to.copy_from(from);
        (to.frame, to.time) = (frame, time);
        // Numbers near zero and special ones stay what they are.
        if to.origin[0].abs() > 1e-3 && to.origin[0].is_finite() {
            let bits = to.origin[0].to_bits() ^ (round as u32 & 0x3FF);
            to.origin[0] = f32::from_bits(bits);
        }
    }
}

fn write(path: &Path, size: u64) -> Result<(), Failure> {
    let records = bundled()?;
    let text = format!(
        r#"{{"schema":"ac-scene/1","name":"big/trace","summary":"All bundled records, again and again.","world":"testbed","start_time":0,"frames":[{{"dt":{DT},"count":99999999}}],"track":["0x1"]}}"#
    );
    let scene = Scene::parse(text.as_bytes(), path)?;
    let info = TraceInfo {
        version: FormatVersion::CURRENT,
        scene: scene.name.clone(),
        producer: "big_trace".into(),
        profile: String::new(),
        world: Default::default(),
    };
    let mut file = File::create(path)?;
    let out = BufWriter::with_capacity(1 << 20, file.try_clone()?);
    let mut writer = TraceWriter::new(out, &info, text.as_bytes(), Compression::Fast)?;
    let header = Header {
        schema: EXPECT_SCHEMA.into(),
        scene: scene.name.clone(),
        oracle: "big".into(),
        oracle_version: "1".into(),
        notes: Vec::new(),
    };
    let kind = ChannelKind::Expect(header.oracle.clone());
    writer.add_channel(kind.clone(), Some(&header))?;
    let mut states = FrameStates::new();
    for (frame, time) in (0_i32..).zip(scene.times()) {
        fill(&mut states, &records, frame, time);
        writer.write_states(&kind, frame, time, &states)?;
        if frame % 1024 == 0 && file.stream_position()? >= size {
            break;
        }
    }
    writer.finish()?.flush()?;
    Ok(())
}

fn compare(path: &Path) -> Result<(), Failure> {
    let records = bundled()?;
    let bytes = std::fs::metadata(path)?.len();
    let start = Instant::now();
    let mut reader = TraceReader::open(path)?;
    reader.select(|kind| matches!(kind, ChannelKind::Expect(_)));
    let (mut states, mut produced) = (FrameStates::new(), FrameStates::new());
    let mut comparison = Comparison::default();
    while let Some(event) = reader.next_event(&mut states)? {
        let TraceEvent::States { frame, time, .. } = event else {
            continue;
        };
        fill(&mut produced, &records, frame, time);
        for (expected, actual) in states.iter().zip(produced.iter()) {
            comparison.frame(expected, Some(actual));
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    let compared = comparison.frames_compared;
    if comparison.first_divergence.is_some() {
        return Err(format!("{:?}", comparison.first_divergence).into());
    }
    println!(
        "{{\"case\":\"long trace\",\"states\":{compared},\"file_bytes\":{bytes},\"seconds\":{seconds:.3},\"peak_bytes\":{}}}",
        peak_memory().unwrap_or(0)
    );
    Ok(())
}

/// The most memory that this process had, bytes, where the system says.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kilobytes << 10)
}
