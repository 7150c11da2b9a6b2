//! A judged run for those who read it: JUnit XML for the CI system, annotations and a step summary for GitHub, lines for people.

use std::fmt::Write;

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use super::{Document, Verdict};
use crate::run::{RunResult, baseline::Baseline, report};

/// GitHub shows at most ten annotations of a kind per step.
const ANNOTATIONS: usize = 10;
/// Rows of a list in the step summary.
const ROWS: usize = 50;

/// Where a result first differs, on one line.
fn place(result: &RunResult) -> String {
    match &result.first_divergence {
        None => String::new(),
        Some(divergence) => format!(
            "frame {}{} {}: expected {}, got {}",
            divergence.frame,
            divergence
                .stage
                .as_ref()
                .map(|stage| format!(", stage {stage},"))
                .unwrap_or_default(),
            divergence.field,
            divergence.expected,
            divergence.actual
        ),
    }
}

fn title(result: &RunResult) -> String {
    format!(
        "{} {} {} {}",
        result.scene,
        result.oracle,
        result.mode.name(),
        result.guid
    )
}

/// Verdicts with how often they came, worst first.
pub fn counts(document: &Document, baseline: &Baseline) -> Vec<(&'static str, usize)> {
    let of = |wanted| {
        document
            .judged(baseline)
            .filter(|(_, verdict)| *verdict == wanted)
            .count()
    };
    vec![
        ("new", of(Verdict::New)),
        ("changed", of(Verdict::Changed)),
        ("flaky", of(Verdict::Flaky)),
        ("could not run", document.errors.len()),
        ("fixed", document.fixed(baseline).count()),
        ("known", of(Verdict::Known)),
        ("within tolerance", of(Verdict::WithinTolerance)),
        ("skipped", document.skipped.len()),
        ("exact", of(Verdict::Exact)),
    ]
}

/// Everything that a person reads: the table, each result that is not exact under its verdict, what was skipped, and how many
/// there are of each.
pub fn human(document: &Document, baseline: &Baseline) -> String {
    let mut text = report::human(document, baseline);
    if let Some(shard) = document.shard {
        let _ = writeln!(text, "shard {shard}");
    }
    for skipped in &document.skipped {
        let _ = writeln!(text, "skipped: {}: {}", skipped.scene, skipped.reason);
    }
    let counts = counts(document, baseline);
    let counts: Vec<_> = counts
        .iter()
        .map(|(name, count)| format!("{count} {name}"))
        .collect();
    let _ = writeln!(text, "gate: {}", counts.join(", "));
    text
}

/// JUnit XML: a suite per area, a case per scene, oracle, mode and entity.
///
/// # Errors
/// When the text cannot be made.
pub fn junit(
    document: &Document,
    baseline: &Baseline,
) -> Result<String, quick_junit::SerializeError> {
    let mut report = Report::new("ac-conform");
    let mut suites: std::collections::BTreeMap<&str, TestSuite> = Default::default();
    let suite = |area: &str| TestSuite::new(area.to_owned());
    for (result, verdict) in document.judged(baseline) {
        suites
            .entry(&result.area)
            .or_insert_with(|| suite(&result.area))
            .add_test_case(case(result, verdict, baseline));
    }
    for skipped in &document.skipped {
        let mut status = TestCaseStatus::skipped();
        status.set_message(skipped.reason.clone());
        let name = skipped.scene.split('/').next().unwrap_or_default();
        suites
            .entry(name)
            .or_insert_with(|| suite(name))
            .add_test_case(TestCase::new(skipped.scene.clone(), status));
    }
    for (index, error) in document.errors.iter().enumerate() {
        let mut status = TestCaseStatus::non_success(NonSuccessKind::Error);
        status.set_type("could not run").set_message(error.clone());
        suites
            .entry("could not run")
            .or_insert_with(|| suite("could not run"))
            .add_test_case(TestCase::new(format!("error {}", index + 1), status));
    }
    report.add_test_suites(suites.into_values());
    report.to_string()
}

fn case(result: &RunResult, verdict: Verdict, baseline: &Baseline) -> TestCase {
    let mut status = if verdict.fails() {
        TestCaseStatus::non_success(NonSuccessKind::Failure)
    } else {
        TestCaseStatus::success()
    };
    if verdict.fails() {
        status.set_type(verdict.name()).set_message(place(result));
    }
    let mut case = TestCase::new(title(result), status);
    case.set_classname(result.scene.clone());
    if let Some(known) = baseline.accepts(result).filter(|_| !verdict.fails()) {
        case.set_system_out(format!("known: {}\n{}", known.reason, place(result)));
    }
    if !result.tolerated.is_empty() {
        let rules: Vec<&str> = result.tolerated.keys().map(String::as_str).collect();
        case.set_system_out(format!("within tolerance: {}", rules.join("\n")));
    }
    case
}

/// GitHub workflow commands: errors for what closes the gate, warnings for what asks to tidy up.
pub fn annotations(document: &Document, baseline: &Baseline) -> String {
    let mut errors: Vec<(String, String)> = Vec::new();
    for error in &document.errors {
        errors.push(("could not run".into(), error.clone()));
    }
    for flake in &document.flaky {
        errors.push((format!("flaky: {}", flake.scene), flake.what.clone()));
    }
    for (result, verdict) in document.judged(baseline) {
        if matches!(verdict, Verdict::New | Verdict::Changed) {
            errors.push((
                format!("{}: {}", verdict.name(), title(result)),
                place(result),
            ));
        }
    }
    let warnings: Vec<_> = document
        .fixed(baseline)
        .map(|known| {
            let what = format!("fixed: {} {} {}", known.scene, known.oracle, known.mode);
            (what, "take it out of the baseline".to_owned())
        })
        .collect();
    let mut text = String::new();
    for (kind, list) in [("error", errors), ("warning", warnings)] {
        // The last one says how many are left out.
        let shown = if list.len() > ANNOTATIONS {
            ANNOTATIONS - 1
        } else {
            list.len()
        };
        for (title, message) in &list[..shown] {
            let (title, message) = (property(title), data(message));
            let _ = writeln!(text, "::{kind} title={title}::{message}");
        }
        if list.len() > shown {
            let more = list.len() - shown;
            let _ = writeln!(text, "::{kind} title=ac-conform::and {more} more");
        }
    }
    text
}

/// Escapes the message of a workflow command.
fn data(text: &str) -> String {
    text.replace('%', "%25")
        .replace('\r', "%0D")
        .replace('\n', "%0A")
}

/// Escapes a property of a workflow command.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

/// Markdown for the summary of a CI step.
pub fn summary(document: &Document, baseline: &Baseline) -> String {
    let closed = document.fails(baseline) || !document.errors.is_empty();
    let shard = document
        .shard
        .map(|shard| format!(", shard {shard}"))
        .unwrap_or_default();
    let verdict = if closed { "failed" } else { "passed" };
    let mut text = format!("### Conformance: {verdict}{shard}\n\n| class | count |\n|---|---:|\n");
    for (name, count) in counts(document, baseline) {
        let _ = writeln!(text, "| {name} | {count} |");
    }
    let mut rows: Vec<[String; 3]> = Vec::new();
    for error in &document.errors {
        rows.push(["could not run".into(), String::new(), error.clone()]);
    }
    for flake in &document.flaky {
        rows.push(["flaky".into(), flake.scene.clone(), flake.what.clone()]);
    }
    for (result, verdict) in document.judged(baseline) {
        if matches!(verdict, Verdict::New | Verdict::Changed) {
            rows.push([verdict.name().into(), title(result), place(result)]);
        }
    }
    for known in document.fixed(baseline) {
        let what = format!("{} {} {}", known.scene, known.oracle, known.mode);
        rows.push(["fixed".into(), what, known.reason.clone()]);
    }
    for skipped in &document.skipped {
        rows.push([
            "skipped".into(),
            skipped.scene.clone(),
            skipped.reason.clone(),
        ]);
    }
    if !rows.is_empty() {
        text += "\n| class | what | where, or why |\n|---|---|---|\n";
    }
    for row in rows.iter().take(ROWS) {
        let row = row
            .each_ref()
            .map(|cell| cell.replace('|', "\\|").replace('\n', " "));
        let _ = writeln!(text, "| {} |", row.join(" | "));
    }
    if rows.len() > ROWS {
        let _ = writeln!(text, "\n… and {} more", rows.len() - ROWS);
    }
    text
}
