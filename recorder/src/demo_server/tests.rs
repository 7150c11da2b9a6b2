//! Sessions in virtual time: what the client ends up knowing, and what the server's simulation did.

use ac_client::net::client::Happening;
use ac_client::net::session::ClientState;

use super::sessions::{GoldenSession, SESSIONS};

#[test]
fn every_golden_session_ends_well() {
    for golden in SESSIONS {
        let mut session = golden.start().expect("a session");
        let mut worst = 0.0f32;
        while !session.is_over() {
            let done: Result<(), core::convert::Infallible> = session.step(|_, _, _, _| Ok(()));
            let Ok(()) = done;
            if let Some(s) = session.sample() {
                worst = worst.max(s.client.distance(&s.server));
            }
        }
        eprintln!("{}: {:.2} worst {worst} {:?} {:?}", golden.name, session.now(), session.server.stats(), session.client.stage.stats);
        for note in &session.client.stage.notes { eprintln!("note {note:?}"); }
        while let Some(n) = session.server.poll_note() { eprintln!("{n:?}"); }
        for (t, h) in &session.happenings {
            match h {
                Happening::Message(m, v) => eprintln!("{t:.2} {} {v:?}", m.name()),
                h => eprintln!("{t:.2} {h:?}"),
            }
        }
        assert_eq!(session.client.state(), ClientState::Closed, "{}", golden.name);
    }
}

#[test]
fn print_sizes() {
    let dir = std::env::temp_dir().join("ac-sessions");
    eprintln!("{}", super::sessions::write_all(&dir).expect("written"));
    let _: Option<GoldenSession> = None;
}

#[test]
fn debug_teleport() {
    let golden = SESSIONS[std::env::var("N").unwrap().parse::<usize>().unwrap()];
    let mut session = golden.start().expect("a session");
    while !session.is_over() {
        let done: Result<(), core::convert::Infallible> = session.step(|_, _, _, _| Ok(()));
        let Ok(()) = done;
        for (t, h) in session.happenings.drain(..) {
            if let Happening::Message(m, v) = h { eprintln!("{t:.2} {} {v:?}", m.name()); }
        }
        if let Some(s) = session.sample() {
            eprintln!("{:.2} client {:08X} {:?} server {:08X} {:?}", s.time, s.client.cell.0, s.client.frame.origin, s.server.cell.0, s.server.frame.origin);
        }
        while let Some(n) = session.server.poll_note() { eprintln!("{n:?}"); }
    }
}
