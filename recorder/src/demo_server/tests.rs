//! Sessions in virtual time: what the client ends up knowing, and what the server's simulation did.

use std::path::PathBuf;
use std::sync::Arc;

use ac_client::dat::{DatSet, Strictness};
use ac_client::net::client::Happening;
use ac_client::net::entities::Verdict;
use ac_client::net::session::ClientState;
use ac_golden_traces::corpus;
use ac_golden_traces::trace::TraceReader;

use super::loopback::{Loopback, LoopbackConfig};
use super::*;
use crate::fault::Faults;
use crate::play::script::Script;

fn golden(name: &str) -> PathBuf {
    corpus::bundled().join(format!("traces/{name}.mcap"))
}

fn scene(name: &str) -> (Scene, Arc<DatSet>) {
    let reader = TraceReader::open(&golden(name)).expect("a bundled trace");
    let scene = reader.scene().clone();
    let folder = corpus::bundled().join("worlds").join(&scene.world);
    let source = DatSet::open(folder, Strictness::Lenient).expect("a bundled world");
    (scene, Arc::new(source))
}

fn config(name: &str, script: &str) -> LoopbackConfig {
    let (scene, source) = scene(name);
    LoopbackConfig {
        server: DemoConfig::new(scene, source),
        script: Script::parse(script).expect("a script"),
        rate: 25,
        faults: Faults::delay(0.05),
        seed: 1,
        limit: 60.0,
        profile: Profile::retail(),
    }
}

#[test]
fn a_session_from_login_to_log_off() {
    let mut session = Loopback::new(&config(
        "lifecycle/create-destroy",
        "forward 1\njump\nsay hello\nwait 4",
    ))
    .expect("a session");
    let mut worst = 0.0f32;
    while !session.is_over() {
        let done: Result<(), core::convert::Infallible> = session.step(|_, _, _, _| Ok(()));
        let Ok(()) = done;
        if let Some(s) = session.sample() {
            worst = worst.max(s.client.distance(&s.server));
        }
    }
    eprintln!(
        "worst {worst} {:?} {:?}",
        session.server.stats(),
        session.client.stage.stats
    );
    for note in &session.client.stage.notes {
        eprintln!("note {note:?}");
    }
    while let Some(n) = session.server.poll_note() {
        eprintln!("{n:?}");
    }
    for (t, h) in &session.happenings {
        match h {
            Happening::Message(m, v) => eprintln!("{t:.2} {} {v:?}", m.name()),
            h => eprintln!("{t:.2} {h:?}"),
        }
    }
    assert_eq!(session.client.state(), ClientState::Closed);
    assert!(
        session.client.stage.notes.is_empty(),
        "{:?}",
        session.client.stage.notes
    );
    let _ = Verdict::Applied;
}
