//! No byte of any file that the recorder makes holds a secret: not as it is, and not after decompression.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::common::{PASSWORD, contains, every_byte, record};
use ac_recorder::format::WriterOptions;
use ac_recorder::proxy::ProxyConfig;
use ac_recorder::secrets::SecretPolicy;

const ACCOUNTS: [&str; 2] = ["FirstAccount", "SecondAccount"];

fn check(path: &Path) {
    let all = every_byte(path);
    for secret in ACCOUNTS.into_iter().chain([PASSWORD]) {
        assert!(!contains(&all, secret), "{secret} in {}", path.display());
    }
}

/// Runs the program; hands out what it said and its exit code.
fn run(args: &[&str], paths: &[&Path]) -> (String, i32) {
    let output = Command::new(env!("CARGO_BIN_EXE_ac-record"))
        .args(args)
        .args(paths)
        .output()
        .expect("built");
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8(said).expect("text");
    for secret in ACCOUNTS.into_iter().chain([PASSWORD]) {
        assert!(!contains(said.as_bytes(), secret), "{secret} in {said}");
    }
    (said, output.status.code().expect("an exit code"))
}

async fn recorded(output: &Path, options: WriterOptions, rotate: bool) -> Vec<PathBuf> {
    let report = record(|listen, server| {
        let mut config = ProxyConfig::new(listen, server, output.into());
        config.disk.options = options;
        config.disk.flush = Duration::from_millis(10);
        if rotate {
            config.disk.rotation.every = Some(Duration::from_millis(50));
        }
        config
    })
    .await;
    if options.secrets != SecretPolicy::Keep {
        assert!(report.disk.leaks.is_empty() && report.disk.unchecked.is_empty());
        assert!(report.disk.secrets >= 3);
    }
    report.disk.files
}

#[tokio::test]
async fn every_byte_is_free_of_secrets() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    for (i, (compress, hide_length, rotate)) in [
        (true, false, false),
        (false, false, true),
        (false, true, false),
        (true, true, true),
    ]
    .into_iter()
    .enumerate()
    {
        let options = WriterOptions {
            secrets: SecretPolicy::Redact { hide_length },
            compress,
        };
        let files = recorded(&at(&format!("{i}.mcap")), options, rotate).await;
        assert!(!rotate || files.len() > 2);
        for file in &files {
            check(file);
        }
        let recovered = at(&format!("{i}-recovered.mcap"));
        let (_, code) = run(&["recover", "-o"], &[&recovered, &files[0]]);
        assert_eq!(code, 0);
        check(&recovered);
        let json = at(&format!("{i}.jsonl"));
        run(&["export", "-o"], &[&json, &files[0]]);
        let json = std::fs::read(json).expect("written");
        assert!(!contains(&json, "hush"));
        run(&["info"], &[&files[0]]);
        run(&["ls"], &[&files[0]]);
        let all: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
        let (said, code) = run(&["verify"], &all);
        assert_eq!(code, 0, "{said}");
    }
}

#[tokio::test]
async fn kept_secrets_are_marked_and_can_be_redacted_later() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let options = WriterOptions {
        secrets: SecretPolicy::Keep,
        compress: true,
    };
    let kept = at("kept.mcap");
    recorded(&kept, options, false).await;
    assert!(contains(&every_byte(&kept), PASSWORD));
    let (said, _) = run(&["info"], &[&kept]);
    assert!(said.contains("SECRETS ARE IN THIS FILE"), "{said}");
    for (name, arguments) in [
        ("clean.mcap", &["redact", "-o"][..]),
        ("short.mcap", &["redact", "--hide-length", "-o"]),
        ("recovered.mcap", &["recover", "-o"]),
    ] {
        let clean = at(name);
        let (said, code) = run(arguments, &[&clean, &kept]);
        assert_eq!(code, 0, "{said}");
        check(&clean);
        let (said, _) = run(&["info"], &[&clean]);
        assert!(said.contains("secrets redacted"), "{said}");
        let (said, code) = run(&["verify"], &[&clean]);
        assert_eq!(code, 0, "{said}");
    }
    // Further words, such as names.
    let words = at("words.txt");
    std::fs::write(&words, "Welcome\n").expect("a folder");
    let clean = at("words.mcap");
    let (_, code) = run(
        &["redact", "--words"],
        &[&words, Path::new("-o"), &clean, &kept],
    );
    assert_eq!(code, 0);
    assert!(!contains(&every_byte(&clean), "welcome"));
}
