//! Sessions in virtual time: what the client ends up knowing.

use ac_client::net::client::Happening;
use ac_client::net::entities::{Dropped, Verdict};
use ac_client::net::messages::{PlainServerMessage as P, ServerMessage};
use ac_client::net::session::ClientState;

use super::loopback::Loopback;
use super::sessions::{GoldenSession, SESSIONS};
use super::*;

fn golden(name: &str) -> GoldenSession {
    *SESSIONS.iter().find(|s| s.name == name).expect("a session")
}

fn finished(name: &str) -> Loopback {
    let mut session = golden(name).start().expect("a session");
    session.run();
    session
}

/// Names of the messages that were applied.
fn applied(session: &Loopback) -> Vec<String> {
    let names = session
        .happenings
        .iter()
        .filter_map(|(_, happening)| match happening {
            Happening::Message(message, Verdict::Applied) => Some(message.name().into_owned()),
            _ => None,
        });
    names.collect()
}

#[test]
fn every_golden_session_ends_with_a_log_off() {
    for golden in SESSIONS {
        let session = finished(golden.name);
        assert_eq!(
            session.client.state(),
            ClientState::Closed,
            "{}",
            golden.name
        );
        let stats = session.client.stage.stats;
        assert_eq!(
            (stats.unreadable, stats.event_gaps),
            (0, 0),
            "{}",
            golden.name
        );
        assert!(session.client.stage.waiting_is_empty(), "{}", golden.name);
        assert!(
            session.client.stage.notes.is_empty(),
            "{:?}",
            session.client.stage.notes
        );
    }
}

#[test]
fn a_session_follows_from_its_configuration() {
    let lossy = golden("lossy");
    assert_eq!(
        lossy.record().expect("a recording"),
        lossy.record().expect("a recording")
    );
}

#[test]
fn a_client_that_runs_too_fast_is_put_right() {
    let session = finished("walk-corrections");
    assert!(session.server.stats().corrections >= 3);
    let own = |m: &ServerMessage| matches!(m, ServerMessage::Plain(P::UpdatePosition(p)) if p.guid == GUEST);
    let forced = session.happenings.iter().filter(
        |(_, happening)| matches!(happening, Happening::Message(m, Verdict::Applied) if own(m)),
    );
    assert!(forced.count() >= 3);
    let echo = Verdict::Dropped(Dropped::Echo);
    let echoes = |h: &Happening| matches!(h, Happening::Message(_, v) if *v == echo);
    assert!(
        session.happenings.iter().any(|(_, h)| echoes(h)),
        "its own motions come back"
    );
}

#[test]
fn a_teleport_goes_through_portal_space() {
    let session = finished("teleport");
    let portals = session
        .happenings
        .iter()
        .filter(|(_, h)| *h == Happening::State(ClientState::PortalSpace))
        .count();
    assert_eq!(portals, 1 + 3, "the login and three teleports");
    let sample = session.sample().expect("both know the player");
    assert_eq!(sample.client.cell.block(), sample.server.cell.block());
    assert_eq!(session.server.stats().corrections, 0);
}

#[test]
fn objects_come_go_and_are_carried() {
    let names = applied(&finished("create-delete"));
    let count = |name: &str| names.iter().filter(|n| n.as_str() == name).count();
    assert_eq!((count("CreateObject"), count("DeleteObject")), (4, 1));
    let names = applied(&finished("wield"));
    assert!(names.iter().any(|n| n == "ParentEvent"), "{names:?}");
}

#[test]
fn a_bad_network_changes_nothing_that_is_known() {
    let mut session = finished("lossy");
    let [up, down] = session.links().map(|link| *link.counts());
    assert!(
        up.lost + down.lost > 3 && up.corrupted + down.corrupted > 0,
        "{up:?} {down:?}"
    );
    let good = GoldenSession {
        faults: crate::fault::Faults::delay(0.05),
        ..golden("lossy")
    };
    let mut good = good.start().expect("a session");
    good.run();
    let objects = |s: &Loopback| {
        let known = s.client.stage.entities.iter();
        known.map(|(guid, _)| guid).collect::<Vec<_>>()
    };
    assert_eq!(objects(&session), objects(&good));
}

#[test]
fn a_player_that_is_not_there_is_an_error() {
    let missing = GoldenSession {
        played: Played::Entity(0x1234),
        ..SESSIONS[0]
    };
    let error = missing.start().expect_err("no such entity").to_string();
    assert_eq!(
        error,
        "the scene `terrain/walk-flat` has no entity 0x1234 at its start"
    );
}
