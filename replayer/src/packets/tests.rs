//! Recordings that are damaged, and frame clocks. The golden sessions themselves are replayed by the harness.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use ac_client::dat::{DatSet, Strictness};
use ac_client::frame::FrameStates;
use ac_client::profile::Profile;
use ac_golden_traces::corpus;

use super::*;
use crate::Simulation;

fn bytes(name: &str) -> Vec<u8> {
    let path = corpus::bundled().join(format!("packets/{name}.mcap"));
    std::fs::read(path).expect("a bundled session")
}

fn path() -> PathBuf {
    "session.mcap".into()
}

fn session(recording: &Recording) -> Result<Session, PacketsError> {
    Session::find(recording, None, Path::new("session.mcap"))
}

fn replayed(recording: &Recording, clock: FrameClock) -> (Vec<FrameStates>, ReplayStats) {
    let session = session(recording).expect("a session");
    let scene =
        scene_of(&session, "x", "", "testbed", clock, &Tracks::All, &path()).expect("short");
    let folder = corpus::bundled().join("worlds/testbed");
    let source = DatSet::open(folder, Strictness::Lenient).expect("the bundled world");
    let mut run = PacketRun::new(
        &scene,
        Arc::new(session),
        Arc::new(source),
        &Profile::retail(),
    );
    let mut all = Vec::new();
    for frame in 0..scene.frame_count() {
        let mut states = FrameStates::new();
        run.step(frame, &mut states).expect("it goes on");
        all.push(states);
    }
    (all, run.stats())
}

#[test]
fn the_same_recording_gives_the_same_bits() {
    let recording = Recording::parse(&bytes("lossy"), &path()).expect("a recording");
    for clock in [FrameClock::Fixed(25.0), FrameClock::Recorded] {
        let (a, stats) = replayed(&recording, clock);
        let (b, _) = replayed(&recording, clock);
        assert_eq!(format!("{a:?}"), format!("{b:?}"));
        assert!(stats.datagrams.undecodable > 0 && stats.stage.applied > 20);
    }
}

#[test]
fn reports_of_the_recorded_client_are_predicted_exactly() {
    for name in ["walk-corrections", "teleport", "door", "lossy"] {
        let recording = Recording::parse(&bytes(name), &path()).expect("a recording");
        let (_, stats) = replayed(&recording, FrameClock::Fixed(25.0));
        let reports = stats.reports;
        assert!(
            reports.count >= 4 && reports.exact == reports.count,
            "{name}: {reports:?}"
        );
    }
}

#[test]
fn damaged_datagrams_are_counted() {
    let mut recording = Recording::parse(&bytes("create-delete"), &path()).expect("a recording");
    let (_, whole) = replayed(&recording, FrameClock::default());
    let n = recording.datagrams.len();
    for (i, datagram) in recording.datagrams.iter_mut().enumerate().skip(4) {
        match i % 5 {
            0 => datagram.bytes.truncate(datagram.bytes.len() / 2),
            1 => datagram.bytes[10] ^= 0x40,
            _ => {}
        }
    }
    let (_, damaged) = replayed(&recording, FrameClock::default());
    assert_eq!(damaged.datagrams.datagrams, n as u64);
    assert!(damaged.datagrams.undecodable > 0);
    assert!(damaged.stage.messages < whole.stage.messages);
}

#[test]
fn files_that_are_none_say_why() {
    let error = |bytes: &[u8]| {
        Recording::parse(bytes, &path())
            .expect_err("none")
            .to_string()
    };
    assert_eq!(
        error(b""),
        "session.mcap: no packet recording (it has no `ac-packets` metadata)"
    );
    assert_eq!(error(&[7; 100]), error(b""));
    assert!(!is_recording(&bytes("lossy")[..40]));
    let whole = bytes("lossy");
    for length in (0..whole.len()).step_by(97) {
        if let Ok(recording) = Recording::parse(&whole[..length], &path()) {
            assert!(recording.damage.is_some());
            let _ = session(&recording);
        }
    }
    let mut late = Recording::parse(&bytes("create-delete"), &path()).expect("a recording");
    late.datagrams.drain(..3);
    let late = session(&late).expect_err("no login").to_string();
    assert!(
        late.contains("start the recording before the client logs in"),
        "{late}"
    );
    let none = session(&Recording::default())
        .expect_err("nothing")
        .to_string();
    assert_eq!(none, "session.mcap: holds no datagrams");
    let recording = Recording::parse(&whole, &path()).expect("a recording");
    let other = Session::find(&recording, Some(7), &path())
        .expect_err("one client")
        .to_string();
    assert_eq!(other, "session.mcap: has no client 7; it has 0");
}

#[test]
fn clocks() {
    assert_eq!("fixed:30".parse(), Ok(FrameClock::Fixed(30.0)));
    assert_eq!("recorded".parse(), Ok(FrameClock::Recorded));
    for bad in ["", "fixed", "fixed:0", "fixed:nan", "fixed:1e9", "30"] {
        assert!(bad.parse::<FrameClock>().is_err(), "{bad}");
    }
    let recording = Recording::parse(&bytes("lossy"), &path()).expect("a recording");
    let mut session = session(&recording).expect("a session");
    let frames = FrameClock::Recorded
        .frames(&session, &path())
        .expect("short");
    let length: f64 = frames.iter().map(|run| run.dt * f64::from(run.count)).sum();
    assert!((length - session.seconds() - 1.0 / 30.0).abs() < 1e-6);
    assert!(frames.iter().all(|run| run.dt <= 1.0 / 30.0 + 1e-9));
    session.arrivals.push(u64::MAX);
    for clock in [FrameClock::Recorded, FrameClock::Fixed(1000.0)] {
        let error = clock
            .frames(&session, &path())
            .expect_err("for ever")
            .to_string();
        assert!(error.contains("choose a lower rate"), "{error}");
    }
}
