//! The part of the page about numbers: stability and precision, from what `ac-conform stability` and `ac-conform precision` wrote.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write,
    fs,
    path::Path,
};

use serde_json::Value;

use super::{heading, row};
use crate::{
    precision::{
        output::{duration, length},
        summary::Order,
    },
    stability::{generators::SECTIONS, trial::Verdict},
};

/// The two documents, where they were written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Numerics {
    /// `target/stability.json`.
    pub stability: Option<Value>,
    /// `target/precision.json`.
    pub precision: Option<Value>,
}

/// The documents under a build folder. What is not there or cannot be read is left out.
pub fn numerics_in(target: &Path) -> Numerics {
    let read = |name: &str| serde_json::from_slice(&fs::read(target.join(name)).ok()?).ok();
    Numerics {
        stability: read("stability.json"),
        precision: read("precision.json"),
    }
}

pub(super) fn section(text: &mut String, numerics: &Numerics) {
    if let Some(document) = &numerics.stability {
        stability(text, document);
    }
    if let Some(document) = &numerics.precision {
        precision(text, document);
    }
}

fn stability(text: &mut String, document: &Value) {
    text.push_str("## Numerical stability\n\nStiff and extreme cases that the specification lists (`ac-conform stability --output target/stability.json`). *As retail*: a rule is violated, \
                   and a frame of an oracle's trace or a section of the specification shows that retail does the same.\n\n");
    let verdicts = [
        Verdict::Holds,
        Verdict::AsRetail,
        Verdict::NoCode,
        Verdict::Ours,
    ];
    let mut counts: BTreeMap<(String, String), usize> = BTreeMap::new();
    for case in array(document, "/cases") {
        let section = string(case, "/id").chars().take(2).collect();
        *counts
            .entry((section, string(case, "/verdict")))
            .or_default() += 1;
    }
    let kebab = |verdict: Verdict| verdict.name().replace(' ', "-");
    heading(
        text,
        "section",
        &["listed", "hold", "as retail", "no code here", "ours"],
    );
    let mut sums = [0; 5];
    for (section, name) in SECTIONS {
        let of = verdicts.map(|v| {
            counts
                .get(&(section.to_owned(), kebab(v)))
                .copied()
                .unwrap_or(0)
        });
        let numbers = [of.iter().sum(), of[0], of[1], of[2], of[3]];
        for (sum, number) in sums.iter_mut().zip(numbers) {
            *sum += number;
        }
        row(
            text,
            &format!("{section} {name}"),
            numbers.map(|n| n.to_string()),
        );
    }
    row(text, "**all**", sums.map(|n| n.to_string()));
    let total = |path: &str| document.pointer(path).and_then(Value::as_u64).unwrap_or(0);
    let _ = writeln!(
        text,
        "\nRules over {} scenes: {} hold all of them in every frame, {} violate one as retail does, {} are ours. Small changes at the start of {} scenes: {} contractive, {} neutral, {} growing, {} discontinuous; {} part when the clock is off by rounding: a quantum, or a frame of an animation with its root motion, comes a frame earlier or later.\n",
        array(document, "/scenes").len(),
        total("/totals/scenes/holds"),
        total("/totals/scenes/as retail"),
        total("/totals/scenes/ours"),
        array(document, "/ensembles").len(),
        total("/totals/ensembles/contractive"),
        total("/totals/ensembles/neutral"),
        total("/totals/ensembles/growing"),
        total("/totals/ensembles/discontinuous"),
        total("/totals/parted_by_the_clock"),
    );
}

fn precision(text: &mut String, document: &Value) {
    text.push_str("## Error against run time\n\nConvergence over the quantum on scenes whose solution is known, and the cheapest setting that stays within 1 cm over 10 s in every scene of a class \
                   (`ac-conform precision --output target/precision.json`; [precision.md](precision.md)).\n\n");
    heading(
        text,
        "scene",
        &["order of convergence", "error at retail's own quanta"],
    );
    for scene in array(document, "/scenes")
        .iter()
        .filter(|scene| string(scene, "/class") == "analytic")
    {
        let own = array(scene, "/rows")
            .first()
            .and_then(|row| row.pointer("/solution/max"))
            .and_then(Value::as_f64);
        let turns = scene.pointer("/turns").and_then(Value::as_bool) == Some(true);
        let unit = |error: f64| {
            if turns {
                format!("{error:.1e} rad")
            } else {
                length(error)
            }
        };
        row(
            text,
            &string(scene, "/scene"),
            [order(scene), own.map_or("–".into(), unit)],
        );
    }
    text.push('\n');
    heading(
        text,
        "class",
        &[
            "against",
            "setting",
            "largest error",
            "run time per simulated second",
            "scenes",
        ],
    );
    for found in array(document, "/recommendations") {
        let number = |path: &str| found.pointer(path).and_then(Value::as_f64);
        let setting = found
            .pointer("/setting")
            .and_then(Value::as_str)
            .unwrap_or("none");
        let cells = [
            string(found, "/against"),
            setting.to_owned(),
            number("/error").map_or("–".into(), length),
            number("/ns_per_second").map_or("–".into(), duration),
            format!(
                "{}/{}",
                number("/good").unwrap_or(0.0),
                number("/scenes").unwrap_or(0.0)
            ),
        ];
        row(text, &string(found, "/class"), cells);
    }
    let scenes = array(document, "/scenes");
    let classes: BTreeSet<String> = scenes.iter().map(|s| string(s, "/class")).collect();
    let hanging = |scene: &&Value| scene.pointer("/hangs").and_then(Value::as_bool) == Some(true);
    let _ = writeln!(
        text,
        "\nRun times: {} build, {}. {} scenes in {} classes, each class with plots (`--report DIR`). {} scenes converge to nothing: with short quanta something hangs in the air, because the rest rule takes away what gravity gives.\n",
        string(document, "/build"),
        string(document, "/machine"),
        scenes.len(),
        classes.len(),
        scenes.iter().filter(hanging).count(),
    );
}

fn order(scene: &Value) -> String {
    let power = scene.pointer("/order/order").and_then(Value::as_f64);
    match (string(scene, "/order/kind").as_str(), power) {
        ("exact", _) => crate::precision::output::order_text(Order::Exact),
        (_, Some(power)) => format!("{power:.2}"),
        _ => "–".into(),
    }
}

fn array<'a>(value: &'a Value, path: &str) -> &'a [Value] {
    value
        .pointer(path)
        .and_then(Value::as_array)
        .map_or(&[], Vec::as_slice)
}

fn string(value: &Value, path: &str) -> String {
    value
        .pointer(path)
        .and_then(Value::as_str)
        .unwrap_or_default()
        .to_owned()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn documents_become_tables() {
        let numerics = Numerics {
            stability: Some(json!({
                "totals": {"scenes": {"holds": 3}, "ensembles": {"neutral": 2}},
                "cases": [{"id": "05/01", "verdict": "holds"}, {"id": "05/02", "verdict": "as-retail"}],
                "scenes": [1, 2, 3],
                "ensembles": [1, 2],
            })),
            precision: Some(json!({
                "scenes": [{"scene": "analytic/friction", "class": "analytic", "turns": false,
                    "order": {"kind": "power", "order": 0.992}, "rows": [{"solution": {"max": 0.2}}]}],
                "recommendations": [{"class": "bounce", "against": "oracle", "setting": "own", "error": 0.0, "ns_per_second": 17_500.0, "good": 6, "scenes": 6}],
            })),
        };
        let mut text = String::new();
        section(&mut text, &numerics);
        assert!(
            text.contains("| 05 Transition | 2 | 1 | 1 | 0 | 0 |"),
            "{text}"
        );
        assert!(text.contains("| **all** | 2 | 1 | 1 | 0 | 0 |"), "{text}");
        assert!(
            text.contains("| analytic/friction | 0.99 | 200.00 mm |"),
            "{text}"
        );
        assert!(
            text.contains("| bounce | oracle | own | 0 | 17.5 µs | 6/6 |"),
            "{text}"
        );
        let mut nothing = String::new();
        section(&mut nothing, &Numerics::default());
        assert_eq!(nothing, "");
    }
}
