//! A few kills of a running proxy; `ac-record kill-trials` makes many.

use std::process::Command;

use ac_recorder::format::read;

#[test]
fn a_kill_loses_nothing_older_than_the_bound() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new(env!("CARGO_BIN_EXE_ac-record"))
        .args(["kill-trials", "--trials", "5", "--jobs", "5", "--lines"])
        .arg(folder.path().join("kill.jsonl"))
        .output()
        .expect("built");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}");
    assert!(said.starts_with("5 kills: 5 recovered"), "{said}");
}

/// SIGTERM and Ctrl-C end the file as it should be.
#[cfg(unix)]
#[tokio::test]
async fn a_signal_ends_the_file() {
    use crate::common::{Server, client, free_pair};
    for signal in ["-TERM", "-INT"] {
        let folder = tempfile::tempdir().expect("a folder");
        let output = folder.path().join("session.mcap");
        let server = Server::start().await;
        let listen = free_pair().await;
        let proxy = Command::new(env!("CARGO_BIN_EXE_ac-record"))
            .args(["proxy", "--listen", &listen.to_string()])
            .args(["--server", &server.address.to_string(), "-o"])
            .arg(&output)
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::null())
            .spawn()
            .expect("built");
        client(listen, "FirstAccount").await;
        let id = proxy.id().to_string();
        let sent = Command::new("kill").args([signal, &id]).status();
        assert!(sent.expect("a shell command").success());
        let said = tokio::task::spawn_blocking(move || proxy.wait_with_output());
        let said = said.await.expect("no panic").expect("ended");
        server.stop().await;
        assert_eq!(said.status.code(), Some(0));
        let text = String::from_utf8(said.stdout).expect("text");
        assert!(text.contains("self-check: none of"), "{text}");
        let recording = read(&output).expect("a recording");
        assert_eq!(recording.damage, None);
        assert!(recording.packets.len() > 5);
    }
}
