//! Sessions in virtual time.

use ac_client::net::session::ClientState;

use super::sessions::SESSIONS;

#[test]
fn every_golden_session_ends_with_a_log_off() {
    for golden in SESSIONS {
        let mut session = golden.start().expect("a session");
        session.run();
        assert_eq!(
            session.client.state(),
            ClientState::Closed,
            "{}",
            golden.name
        );
    }
}
