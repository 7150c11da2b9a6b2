//! Results as JSON and as tables.

use std::{collections::BTreeMap, fmt::Write};

use serde::Serialize;

use super::{RunResult, SELF, baseline::Baseline};
use crate::{
    compare::Class,
    gate::{Document, Verdict},
};

/// Schema of the JSON document.
pub const SCHEMA: &str = "ac-conform-run/1";

/// How many divergences the human report lists before it says how many more there are.
const LISTED: usize = 40;

/// Sums over all results.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Totals {
    /// Results.
    pub results: usize,
    /// Of these, exact in every frame.
    pub exact: usize,
    /// Of these, with small numeric differences only.
    pub within_tolerance: usize,
    /// Of these, with larger ones.
    pub diverged: usize,
    /// Divergences that the baseline knows.
    pub known_divergences: usize,
    /// Divergences that it does not know.
    pub new_divergences: usize,
    /// Entries of the baseline that did not diverge any more.
    pub fixed: usize,
    /// Frames compared.
    pub frames_compared: u64,
    /// Of these exact.
    pub frames_exact: u64,
    /// Frames whose expectation is not finite: nothing is known about them.
    pub frames_undefined_in_oracle: u64,
    /// Stage records that the client cannot run alone; they are not among the frames above.
    pub stage_records_not_run: u64,
}

impl Totals {
    /// Sums up.
    pub fn of(results: &[RunResult], baseline: &Baseline) -> Self {
        let mut totals = Self {
            results: results.len(),
            fixed: baseline.fixed(results).count(),
            ..Self::default()
        };
        for result in results {
            *match result.class {
                Class::Exact => &mut totals.exact,
                Class::WithinTolerance => &mut totals.within_tolerance,
                Class::Diverged => &mut totals.diverged,
            } += 1;
            if result.first_divergence.is_some() {
                *match baseline.accepts(result) {
                    Some(_) => &mut totals.known_divergences,
                    None => &mut totals.new_divergences,
                } += 1;
            }
            totals.frames_compared += result.frames_compared;
            totals.frames_exact += result.frames_exact;
            totals.frames_undefined_in_oracle += result.undefined;
            totals.stage_records_not_run += result.not_run;
        }
        totals
    }
}

/// The JSON document, one result per line.
///
/// # Errors
/// Never in practice: results are plain data.
pub fn json(results: &[RunResult], totals: &Totals) -> serde_json::Result<String> {
    let mut text = format!("{{\"schema\":\"{SCHEMA}\",\"results\":[");
    for (index, result) in results.iter().enumerate() {
        text.push_str(if index == 0 { "\n" } else { ",\n" });
        text.push_str(&serde_json::to_string(result)?);
    }
    text.push_str("\n],\"totals\":");
    text.push_str(&serde_json::to_string(totals)?);
    text.push_str("}\n");
    Ok(text)
}

/// One row of the table: an area, an oracle, a profile and a mode.
#[derive(Clone, Debug, Default)]
struct Row {
    scenes: BTreeMap<String, bool>,
    frames: u64,
    exact: u64,
    class: Option<Class>,
    origin: f64,
}

/// The table, and every result that is not simply exact, under the name of its verdict.
pub fn human(document: &Document, baseline: &Baseline) -> String {
    let results = &document.results[..];
    let totals = Totals::of(results, baseline);
    let mut text = table(results);
    divergences(&mut text, document, baseline);
    tolerated(&mut text, results);
    for known in baseline.fixed(results) {
        let _ = writeln!(
            text,
            "fixed: {} {} {}{} no longer diverges; take it out of the baseline",
            known.scene,
            known.oracle,
            known.mode,
            known
                .guid
                .as_ref()
                .map(|guid| format!(" {guid}"))
                .unwrap_or_default()
        );
    }
    if results
        .iter()
        .any(|result| result.oracle == SELF && result.first_divergence.is_some())
    {
        text += "oracle self is this library as it was: `ac-conform bless` shows the change, and takes it in if it is wanted\n";
    }
    if totals.frames_undefined_in_oracle > 0 {
        let _ = writeln!(
            text,
            "undefined in the oracle: {} frames expect a value that is not finite; that it is met says nothing about retail",
            totals.frames_undefined_in_oracle
        );
    }
    if totals.stage_records_not_run > 0 {
        let _ = writeln!(
            text,
            "not run: {} stage records of stages that the client cannot run alone",
            totals.stage_records_not_run
        );
    }
    let _ = writeln!(
        text,
        "{} of {} results exact; {} of {} frames and stage records exact",
        totals.exact, totals.results, totals.frames_exact, totals.frames_compared,
    );
    text
}

fn table(results: &[RunResult]) -> String {
    let mut rows: BTreeMap<(&str, &str, &str, &str), Row> = BTreeMap::new();
    for result in results {
        let row = rows
            .entry((
                &result.area,
                &result.oracle,
                &result.profile,
                result.mode.name(),
            ))
            .or_default();
        *row.scenes.entry(result.scene.clone()).or_insert(true) &=
            result.first_divergence.is_none();
        row.frames += result.frames_compared;
        row.exact += result.frames_exact;
        row.class = row.class.max(Some(result.class));
        row.origin = result
            .max_error
            .get("origin")
            .map_or(row.origin, |error| row.origin.max(error.abs));
    }
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{:<10} {:<14} {:<14} {:<7} {:>9} {:>15} {:>12}  verdict",
        "area", "oracle", "profile", "mode", "scenes", "frames", "off by"
    );
    for ((area, oracle, profile, mode), row) in rows {
        let exact = row.scenes.values().filter(|exact| **exact).count();
        let off = if row.origin > 0.0 {
            format!("{:.3e} m", row.origin)
        } else {
            "-".into()
        };
        let _ = writeln!(
            text,
            "{area:<10} {oracle:<14} {profile:<14} {mode:<7} {:>9} {:>15} {off:>12}  {}",
            format!("{exact}/{}", row.scenes.len()),
            format!("{}/{}", row.exact, row.frames),
            row.class.map_or("", verdict)
        );
    }
    text
}

fn verdict(class: Class) -> &'static str {
    match class {
        Class::Exact => "exact",
        Class::WithinTolerance => "within tolerance",
        Class::Diverged => "DIVERGED",
    }
}

/// What passed because a rule of the policy says so, with the rule's reason and the largest errors.
fn tolerated(text: &mut String, results: &[RunResult]) {
    let within: Vec<_> = results
        .iter()
        .filter(|result| result.class == Class::WithinTolerance)
        .collect();
    for result in within.iter().take(LISTED) {
        let _ = writeln!(
            text,
            "within tolerance: {} {} {} {}",
            result.scene,
            result.oracle,
            result.mode.name(),
            result.guid
        );
        for (rule, count) in &result.tolerated {
            let _ = writeln!(text, "       {count} times {rule}");
        }
        errors(text, result);
    }
    if within.len() > LISTED {
        let more = within.len() - LISTED;
        let _ = writeln!(
            text,
            "... and {more} more within tolerance (all are in --format json)"
        );
    }
}

/// The largest error of each field.
fn errors(text: &mut String, result: &RunResult) {
    for (field, error) in &result.max_error {
        let unit = if error.unit.is_empty() { "" } else { " " };
        let _ = writeln!(
            text,
            "       {field}: up to {:.3e}{unit}{}, {} ulp, in frame {}",
            error.abs, error.unit, error.ulp, error.frame
        );
    }
}

/// Every divergence, the worst verdicts first: what closes the gate is never behind what does not.
fn divergences(text: &mut String, document: &Document, baseline: &Baseline) {
    let mut diverged: Vec<_> = document
        .judged(baseline)
        .filter_map(|(result, verdict)| Some((result, result.first_divergence.as_ref()?, verdict)))
        .collect();
    diverged.sort_by_key(|(.., verdict)| std::cmp::Reverse(*verdict));
    for (result, divergence, verdict) in diverged.iter().take(LISTED) {
        let _ = writeln!(
            text,
            "{}: {} {} {} {}: frame {}{} {}: expected {}, got {}",
            verdict.name(),
            result.scene,
            result.oracle,
            result.mode.name(),
            result.guid,
            divergence.frame,
            divergence
                .stage
                .as_ref()
                .map(|stage| format!(", stage {stage},"))
                .unwrap_or_default(),
            divergence.field,
            divergence.expected,
            divergence.actual
        );
        if let Some(known) = baseline.accepts(result) {
            let _ = writeln!(text, "       {}", known.reason);
        }
        if *verdict == Verdict::Changed
            && let Some(known) = baseline.known.iter().find(|known| known.names(result))
        {
            let _ = writeln!(
                text,
                "       the baseline has frame {} {}",
                known.frame, known.field
            );
        }
        for flake in &document.flaky {
            if *verdict == Verdict::Flaky && flake.scene == result.scene {
                let _ = writeln!(text, "       run again: {}", flake.what);
            }
        }
        for (rule, count) in &result.tolerated {
            let _ = writeln!(text, "       tolerated beside that: {count} times {rule}");
        }
        errors(text, result);
    }
    if diverged.len() > LISTED {
        let _ = writeln!(
            text,
            "... and {} more divergences (all are in --format json)",
            diverged.len() - LISTED
        );
    }
}
