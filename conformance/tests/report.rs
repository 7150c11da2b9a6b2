//! The HTML report in a browser. Without Chromium the test says so and passes: `scripts/install-browser.sh` installs it.

use std::{
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::{Duration, Instant},
};

/// How long a browser may take: a busy machine starts it slowly.
const PATIENCE: Duration = Duration::from_secs(120);

fn browser() -> Option<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders)
        .flat_map(|folder| names.map(|name| folder.join(name)))
        .find(|path| path.is_file())
}

/// The page as the browser has it once its script is done, and what the browser logged.
fn open(browser: &Path, folder: &Path, fragment: &str) -> (String, String) {
    let (dom, log) = (folder.join("dom.html"), folder.join("log.txt"));
    let profile = tempfile::tempdir().unwrap();
    let mut child = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            "--disable-dev-shm-usage",
            "--enable-logging=stderr",
            "--dump-dom",
        ])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{}/index.html#{fragment}", folder.display()))
        .stdin(Stdio::null())
        .stdout(std::fs::File::create(&dom).unwrap())
        .stderr(std::fs::File::create(&log).unwrap())
        .spawn()
        .expect("the browser starts");
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if start.elapsed() > PATIENCE {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("the browser did not finish within {PATIENCE:?}");
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    let log = String::from_utf8_lossy(&std::fs::read(log).unwrap()).into_owned();
    assert!(status.success(), "{log}");
    (std::fs::read_to_string(dom).unwrap(), log)
}

fn rows(dom: &str) -> usize {
    dom.matches("<tr data-index=").count()
}

#[test]
fn the_report_works_in_a_browser() {
    let Some(browser) = browser() else {
        eprintln!("skipped: no Chromium found; scripts/install-browser.sh installs it");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let traces = Path::new(env!("CARGO_MANIFEST_DIR")).join("../golden-traces/traces");
    let run = Command::new(env!("CARGO_BIN_EXE_ac-conform"))
        .arg("run")
        .args([traces.join("bounce/drop.mcap"), traces.join("terrain")])
        // Another profile than the oracle's, so that something diverges.
        .args(["--oracle", "ace", "--mode", "free", "--profile", "retail"])
        .arg("--report")
        .arg(folder.path())
        .output()
        .expect("the program starts");
    assert!(run.stderr.starts_with(b"report: "), "{run:?}");

    let (all, log) = open(&browser, folder.path(), "");
    assert!(!log.contains("CONSOLE"), "{log}");
    assert!(all.contains("data-ready="), "the script did not finish");
    assert!(!all.contains("data-error="), "the script failed");

    let (filtered, log) = open(&browser, folder.path(), "filter=bounce&sort=-frames");
    assert!(!log.contains("CONSOLE"), "{log}");
    assert!((1..rows(&all)).contains(&rows(&filtered)));
    assert!(filtered.contains("aria-sort=\"descending\""));

    let (detail, log) = open(
        &browser,
        folder.path(),
        "open=bounce/drop%7Cace%7Cfree%7C0x70000001",
    );
    assert!(!log.contains("CONSOLE"), "{log}");
    assert!(detail.contains("From above") && detail.contains("Outcomes and cells"));
    assert!(
        !detail.contains("NaN"),
        "a plot has a coordinate that is no number"
    );
}
