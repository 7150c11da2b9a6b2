//! Results as tables for people and as JSON.

use std::{collections::BTreeMap, fmt::Write};

use serde_json::{Value, json};

use super::{
    ensemble::{self, Class, Ensemble},
    invariants::Violation,
    lab::Report,
    trial::Verdict,
};
use crate::precision::output::length;

/// Schema of the JSON document.
pub const SCHEMA: &str = "ac-conform-stability/1";

/// Everything as one JSON document.
pub fn document(report: &Report) -> Value {
    json!({
        "schema": SCHEMA,
        "totals": totals(report),
        "cases": report.cases,
        "scenes": report.scenes,
        "ensembles": report.ensembles,
    })
}

/// How many cases and scenes have which verdict, and how scenes take small changes.
pub fn totals(report: &Report) -> Value {
    let count = |verdicts: &mut dyn Iterator<Item = Verdict>| {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for verdict in verdicts {
            *counts.entry(verdict.name()).or_default() += 1;
        }
        counts
    };
    json!({
        "listed": report.cases.len(),
        "cases": count(&mut report.cases.iter().map(|case| case.verdict)),
        "scenes": count(&mut report.scenes.iter().map(|scene| scene.verdict)),
        "ensembles": ensemble::counts(&report.ensembles),
        "parted_by_the_clock": report.ensembles.iter().filter(|e| e.clock == Class::Discontinuous).count(),
        "ours": report.ours(),
    })
}

/// A line per case and scene; violations below theirs.
pub fn human(report: &Report) -> String {
    let mut text = String::new();
    for case in &report.cases {
        let _ = writeln!(
            text,
            "{:<6} {:<9} {:>7} checks  {}",
            case.id,
            case.verdict.name(),
            case.checks,
            case.title
        );
        violations(&mut text, &case.violations);
        if let Some(note) = &case.note {
            let _ = writeln!(text, "       {note}");
        }
    }
    for scene in report.scenes.iter().filter(|s| s.verdict != Verdict::Holds) {
        let _ = writeln!(text, "{:<9} {}", scene.verdict.name(), scene.scene);
        violations(&mut text, &scene.violations);
    }
    ensembles(&mut text, &report.ensembles);
    let _ = writeln!(text, "\n{}", sentence(report));
    text
}

fn violations(text: &mut String, violations: &[Violation]) {
    for violation in violations {
        let frame = violation
            .frame
            .map_or(String::new(), |frame| format!(", frame {frame}"));
        let _ = writeln!(
            text,
            "       {}{frame}: {} [{}]",
            violation.invariant.name(),
            violation.detail,
            violation.retail.as_deref().unwrap_or("OURS")
        );
    }
}

fn ensembles(text: &mut String, ensembles: &[Ensemble]) {
    if ensembles.is_empty() {
        return;
    }
    let _ = writeln!(
        text,
        "\n{:<34} {:<14} {:>10} {:>10} {:>8}  parted by",
        "scene", "small changes", "start", "largest", "a frame"
    );
    for ensemble in ensembles {
        let Some(member) = ensemble.members.iter().find(|m| m.class == ensemble.class) else {
            continue;
        };
        let event = member.event.as_ref().map_or(String::new(), |event| {
            format!(
                "{} in frame {} ({})",
                event.kind,
                event.frame,
                member.change.name()
            )
        });
        let _ = writeln!(
            text,
            "{:<34} {:<14} {:>10} {:>10} {:>8}  {event}",
            ensemble.scene,
            ensemble.class.name(),
            length(member.start),
            length(member.max),
            member.growth.map_or("–".into(), |g| format!("×{g:.3}")),
        );
    }
}

/// The result in a sentence.
pub fn sentence(report: &Report) -> String {
    let of = |verdict: Verdict| report.cases.iter().filter(|c| c.verdict == verdict).count();
    let class = |class: Class| report.ensembles.iter().filter(|e| e.class == class).count();
    format!(
        "{} listed cases: {} hold, {} as retail, {} without code here, {} ours; {} scenes under the rules, {} ours; of {} ensembles {} contractive, {} neutral, {} growing, {} discontinuous; {} part when the clock is off by rounding",
        report.cases.len(),
        of(Verdict::Holds),
        of(Verdict::AsRetail),
        of(Verdict::NoCode),
        of(Verdict::Ours),
        report.scenes.len(),
        report
            .scenes
            .iter()
            .filter(|s| s.verdict == Verdict::Ours)
            .count(),
        report.ensembles.len(),
        class(Class::Contractive),
        class(Class::Neutral),
        class(Class::Growing),
        class(Class::Discontinuous),
        report
            .ensembles
            .iter()
            .filter(|e| e.clock == Class::Discontinuous)
            .count(),
    )
}
