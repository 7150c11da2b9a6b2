//! The HTML report in a browser. Without Chromium the test says so and passes: `scripts/install-browser.sh` installs it.

use ac_client::frame::{FrameState, state::Fields};
use ac_conformance::{
    compare::{Comparison, policy::Policy},
    gate::Document,
    report_html::{Series, page},
    run::{Mode, RunResult, baseline::Baseline},
};
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
    open_with(browser, folder, fragment, &["--dump-dom"])
}

fn open_with(browser: &Path, folder: &Path, fragment: &str, more: &[&str]) -> (String, String) {
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
        ])
        .args(more)
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

/// A report of 200 scenes with 500 frames each; some diverge.
fn large_report() -> String {
    let frame = |frame: i32, x: f32| FrameState {
        has: Fields::ORIGIN,
        frame,
        cell: 0xA9B4_0001 + (frame as u32 / 100),
        origin: [x, x * 0.5, (x * 0.1).sin()],
        ..FrameState::default()
    };
    let mut document = Document::default();
    for number in 0..200 {
        let scene = format!("area{}/scene-{number:03}", number % 14);
        let differs = number % 10 == 3;
        let mut comparison = Comparison::default();
        let mut series = Series::new(&scene, "gdle", Mode::Free, 1);
        for at in -1..500 {
            let expected = frame(at, at as f32 * 0.04);
            let off = if differs && at > 250 {
                0.01 * (at - 250) as f32
            } else {
                0.0
            };
            let actual = frame(at, at as f32 * 0.04 + off);
            let exact_before = comparison.frames_exact;
            comparison.frame(&expected, Some(&actual));
            series.frame(
                &expected,
                Some(&actual),
                comparison.frames_exact > exact_before,
            );
        }
        document.results.push(RunResult {
            area: scene.split('/').next().unwrap().into(),
            scene,
            oracle: "gdle".into(),
            profile: "gdle".into(),
            mode: Mode::Free,
            guid: "0x1".into(),
            frames_compared: comparison.frames_compared,
            frames_exact: comparison.frames_exact,
            class: comparison.class(),
            first_divergence: comparison.first_divergence,
            max_error: comparison.max_error,
            undefined: 0,
            tolerated: Default::default(),
            not_run: 0,
            stages: Default::default(),
        });
        document.series.push(series);
    }
    page(&document, &Policy::default(), &Baseline::default())
}

/// A script of a test behind the page's own: what it finds goes into attributes of the page.
fn with_script(page: &str, script: &str) -> String {
    page.replace("</body>", &format!("<script>{script}</script></body>"))
}

/// The value of an attribute of the page's root.
fn attribute<'a>(dom: &'a str, name: &str) -> &'a str {
    let start = format!("{name}=\"");
    let place = dom
        .find(&start)
        .unwrap_or_else(|| panic!("no {name}: {}", &dom[..300.min(dom.len())]));
    let rest = &dom[place + start.len()..];
    &rest[..rest.find('"').unwrap()]
}

const KEYS: &str = r##"(async () => {
  const log = [], wait = () => new Promise((done) => setTimeout(done, 50));
  const press = async (key) => {
    (document.activeElement ?? document.body).dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
    await wait();
  };
  const at = () => document.activeElement?.textContent || document.activeElement?.id || "";
  const opened = () => document.getElementById("detail").hidden ? "list" : document.querySelector("#detail h1").textContent;
  const note = (what) => log.push(what);
  await press("/"); note(at());
  await press("Escape"); note(document.activeElement === document.body ? "left" : at());
  await press("ArrowDown"); note(at());
  await press("ArrowDown"); note(at());
  await press("ArrowUp"); note(at());
  // Enter on a link is the browser's own: a click.
  document.activeElement.click(); await wait(); note(opened());
  await press("]"); note(opened());
  await press("]"); note(opened());
  await press("["); note(opened());
  await press("Escape"); note(opened()); note(at());
  document.documentElement.dataset.keys = log.join("|");
})();"##;

const COLOURS: &str = r#"(() => {
  const probe = document.createElement("span"); document.body.append(probe);
  const numbers = (text) => text.match(/[\d.]+/g).slice(0, 3).map(Number);
  const light = (text) => { const [r, g, b] = numbers(text).map((c) => c / 255).map((c) => c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
  const ground = getComputedStyle(document.body).backgroundColor;
  const ratio = (colour) => { const [a, b] = [light(colour), light(ground)].sort((x, y) => y - x); return (a + 0.05) / (b + 0.05); };
  const worst = Math.min(...["--text", "--muted", "--accent", "--ok", "--warn", "--bad", "--expected", "--actual"].map((name) => { probe.style.color = "var(" + name + ")"; return ratio(getComputedStyle(probe).color); }));
  document.documentElement.dataset.ground = light(ground).toFixed(3);
  document.documentElement.dataset.contrast = worst.toFixed(2);
})();"#;

#[test]
fn keys_work_and_a_large_report_opens_fast() {
    let Some(browser) = browser() else {
        eprintln!("skipped: no Chromium found; scripts/install-browser.sh installs it");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("index.html");
    let report = large_report();
    std::fs::write(&file, with_script(&report, KEYS)).unwrap();
    let waits = ["--virtual-time-budget=20000", "--dump-dom"];
    let (dom, log) = open_with(&browser, folder.path(), "verdict=new", &waits);
    assert!(!log.contains("CONSOLE"), "{log}");
    let (first, second, third) = ("area3/scene-003", "area13/scene-013", "area9/scene-023");
    let expected = [
        "f-filter", "left", first, second, first, first, second, third, second, "list", second,
    ];
    assert_eq!(attribute(&dom, "data-keys"), expected.join("|"));
    // Whatever else the machine does: the fastest of three.
    std::fs::write(&file, &report).unwrap();
    let ready = (0..3).map(|_| {
        let (dom, _) = open(&browser, folder.path(), "");
        attribute(&dom, "data-ready").parse::<u32>().unwrap()
    });
    let fastest = ready.min().unwrap();
    assert!(fastest < 2000, "{fastest} ms");
}

#[test]
fn light_and_dark_are_both_readable() {
    let Some(browser) = browser() else {
        eprintln!("skipped: no Chromium found; scripts/install-browser.sh installs it");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("index.html"),
        with_script(&large_report(), COLOURS),
    )
    .unwrap();
    let mut grounds = Vec::new();
    let mut pictures = Vec::new();
    for scheme in [1, 0] {
        let scheme = format!("--blink-settings=preferredColorScheme={scheme}");
        let (dom, log) = open_with(&browser, folder.path(), "", &[&scheme, "--dump-dom"]);
        assert!(!log.contains("CONSOLE"), "{log}");
        grounds.push(attribute(&dom, "data-ground").parse::<f64>().unwrap());
        let contrast: f64 = attribute(&dom, "data-contrast").parse().unwrap();
        assert!(contrast >= 4.5, "{contrast} on {grounds:?}");
        let picture = folder.path().join("page.png");
        let shot = format!("--screenshot={}", picture.display());
        open_with(
            &browser,
            folder.path(),
            "",
            &[&scheme, &shot, "--window-size=1200,900"],
        );
        pictures.push(std::fs::read(&picture).unwrap());
    }
    assert!(grounds[0] > 0.8 && grounds[1] < 0.1, "{grounds:?}");
    assert!(pictures.iter().all(|picture| picture.len() > 20_000));
    assert_ne!(pictures[0], pictures[1]);
}
