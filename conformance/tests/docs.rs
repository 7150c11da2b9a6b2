//! The pages under `docs/` keep what they promise: commands in blocks marked `sh run` run, workflow files are YAML and name only
//! options that exist, links lead somewhere.

#![cfg(unix)]

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use ac_golden_traces::corpus;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("..")
        .canonicalize()
        .unwrap()
}

fn pages() -> Vec<PathBuf> {
    let mut pages = corpus::find(&root().join("docs"), &[".md"]).unwrap();
    pages.push(root().join("README.md"));
    pages
}

/// The blocks of a page that are marked to be run, one after the other.
fn runnable(text: &str) -> String {
    let mut script = String::new();
    let mut inside = false;
    for line in text.lines() {
        match (inside, line.trim()) {
            (false, "```sh run") => inside = true,
            (true, "```") => inside = false,
            (true, _) => script += &format!("{line}\n"),
            _ => {}
        }
    }
    assert!(!inside, "a block does not end");
    script
}

/// `ac-replay` beside this test's `ac-conform`; built if nobody did that yet.
fn replay() -> PathBuf {
    let conform = Path::new(env!("CARGO_BIN_EXE_ac-conform"));
    let path = conform.with_file_name("ac-replay");
    if !path.is_file() {
        let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
        let mut build = Command::new(cargo);
        build.args(["build", "-p", "ac-replayer", "--bin", "ac-replay"]);
        if conform
            .parent()
            .is_some_and(|folder| folder.ends_with("release"))
        {
            build.arg("--release");
        }
        assert!(build.current_dir(root()).status().unwrap().success());
    }
    path
}

/// A folder with the programs and the bundled files. What a page may change is a copy.
fn workplace() -> tempfile::TempDir {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::create_dir_all(path("bin")).unwrap();
    symlink(env!("CARGO_BIN_EXE_ac-conform"), path("bin/ac-conform")).unwrap();
    symlink(replay(), path("bin/ac-replay")).unwrap();
    fs::create_dir(path("golden-traces")).unwrap();
    let bundled = corpus::bundled();
    for name in ["traces", "worlds", "vectors", "hashes.txt", "index.json"] {
        symlink(bundled.join(name), path("golden-traces").join(name)).unwrap();
    }
    let own = bundled.join("self");
    for file in corpus::find(&own, &[corpus::TRACE_SUFFIX]).unwrap() {
        let to = path("golden-traces/self").join(file.strip_prefix(&own).unwrap());
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::copy(&file, &to).unwrap();
    }
    folder
}

#[test]
fn commands_in_the_pages_run() {
    let mut pages_with_commands = Vec::new();
    for page in pages() {
        let script = runnable(&fs::read_to_string(&page).unwrap());
        let name = page.file_name().unwrap().to_string_lossy().into_owned();
        if script.is_empty() {
            continue;
        }
        let folder = workplace();
        let programs = folder.path().join("bin");
        let path = std::env::var("PATH").unwrap_or_default();
        let output = Command::new("sh")
            .args(["-e", "-c", &script])
            .current_dir(folder.path())
            .env("PATH", format!("{}:{path}", programs.display()))
            .env("NO_COLOR", "1")
            .env_remove("GITHUB_STEP_SUMMARY")
            .output()
            .unwrap();
        assert!(
            output.status.success(),
            "{name}: {}\n{script}\n{}\n{}",
            output.status,
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        );
        pages_with_commands.push(name);
    }
    for wanted in [
        "bisecting.md",
        "ci.md",
        "reading-a-report.md",
        "writing-scenes.md",
    ] {
        assert!(
            pages_with_commands.iter().any(|name| name == wanted),
            "{wanted}"
        );
    }
}

#[test]
fn workflow_files_are_yaml_with_options_that_exist() {
    let files = corpus::find(&root().join("docs/ci"), &[".yml"]).unwrap();
    assert_eq!(files.len(), 3);
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        let name = file.display();
        let documents = yaml_rust2::YamlLoader::load_from_str(&text);
        let documents = documents.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(documents.len(), 1, "{name}");
        assert!(documents[0].as_hash().is_some(), "{name}");
        for line in text
            .lines()
            .filter(|line| !line.trim_start().starts_with('#'))
        {
            commands(line).into_iter().for_each(|(command, options)| {
                let help = Command::new(env!("CARGO_BIN_EXE_ac-conform"))
                    .args([command.as_str(), "--help"])
                    .output()
                    .unwrap();
                assert!(
                    help.status.success(),
                    "{name}: no command is called `{command}`"
                );
                let help = String::from_utf8_lossy(&help.stdout).into_owned();
                for option in options {
                    assert!(
                        help.contains(&option),
                        "{name}: `{command}` has no {option}"
                    );
                }
            });
        }
    }
}

/// Commands of `ac-conform` in a line, with their options.
fn commands(line: &str) -> Vec<(String, Vec<String>)> {
    let mut found: Vec<(String, Vec<String>)> = Vec::new();
    let mut words = line.split_whitespace().peekable();
    let mut open = false;
    while let Some(word) = words.next() {
        let starts = word.ends_with("ac-conform") || word == "ac-conformance";
        if starts {
            // `cargo run -p ac-conformance -- hash`; a build names no command.
            words.next_if(|next| *next == "--");
            if let Some(command) = words.next_if(|next| next.chars().all(char::is_alphabetic)) {
                found.push((command.into(), Vec::new()));
                open = true;
            }
        } else if ["||", "&&", ">", "|", ";"].contains(&word) {
            open = false;
        } else if let Some((_, options)) = found.last_mut()
            && open
            && word.starts_with("--")
        {
            options.push(word.split('=').next().unwrap_or(word).into());
        }
    }
    found
}

#[test]
fn links_lead_somewhere() {
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        let folder = page.parent().unwrap();
        for link in text.split("](").skip(1) {
            let link = link.split(')').next().unwrap();
            let file = link.split('#').next().unwrap();
            if file.is_empty() || file.contains("://") {
                continue;
            }
            assert!(folder.join(file).exists(), "{}: {link}", page.display());
        }
    }
}

#[test]
fn blocks_are_found() {
    let text = "a\n```sh\nno\n```\n```sh run\nyes\n```\n";
    assert_eq!(runnable(text), "yes\n");
    let line = "- target/release/ac-conform run --shard \"x\" --format json > out --not || code=$?";
    assert_eq!(
        commands(line),
        [(
            "run".to_owned(),
            vec!["--shard".to_owned(), "--format".to_owned()]
        )]
    );
    assert!(commands("cargo build --release -p ac-conformance").is_empty());
}
