//! The report for people: one HTML file with every result and, per entity, plots of what was expected and what came out.
//!
//! The file needs nothing beside it: style, script and data are in it, and its content policy forbids any request. Data is JSON
//! in `<script type="application/json">` blocks, one for the table and one per scene, oracle and entity; a block is parsed
//! when its entity is looked at. Plots have at most [`POINTS`] points per series; divergence cards carry the exact values.
//! The script only ever sets text, so no string of a trace can become markup.

mod encode;
mod plot;
pub mod precision_page;
pub mod series;
mod spec_links;
pub mod stability_page;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use serde_json::{Value, json};

pub use encode::POINTS;
pub use series::Series;

use crate::{
    compare::{Divergence, error, policy::Policy},
    gate::{Document, Verdict, output::counts},
    run::{RunResult, baseline::Baseline, report::Totals},
};

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Name of the file in the folder of the report.
pub const FILE: &str = "index.html";

/// The report could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot be written", path.display())]
pub struct ReportError {
    path: PathBuf,
    #[source]
    source: std::io::Error,
}

/// Writes `index.html` into the folder, which is made if it is not there. The answer is the path of the file.
///
/// # Errors
/// When the folder or the file cannot be written.
pub fn write(
    folder: &Path,
    document: &Document,
    policy: &Policy,
    baseline: &Baseline,
) -> Result<PathBuf, ReportError> {
    let path = folder.join(FILE);
    let text = page(document, policy, baseline);
    let text = plot::with_links(folder, FILE, &text);
    fs::create_dir_all(folder)
        .and_then(|()| fs::write(&path, text))
        .map_err(|source| ReportError {
            path: path.clone(),
            source,
        })?;
    Ok(path)
}

/// Writes a page of its own into the folder, beside the report if there is one. The answer is the path of the file.
fn write_page(folder: &Path, file: &str, text: &str) -> Result<PathBuf, ReportError> {
    let path = folder.join(file);
    let text = plot::with_links(folder, file, text);
    fs::create_dir_all(folder)
        .and_then(|()| fs::write(&path, text))
        .map_err(|source| ReportError {
            path: path.clone(),
            source,
        })?;
    Ok(path)
}

/// The text of the report.
pub fn page(document: &Document, policy: &Policy, baseline: &Baseline) -> String {
    let mut groups: BTreeMap<(&str, &str, String), Vec<&Series>> = BTreeMap::new();
    for series in &document.series {
        let guid = format!("0x{:X}", series.guid);
        groups
            .entry((&series.scene, &series.oracle, guid))
            .or_default()
            .push(series);
    }
    let rows: Vec<Value> = document
        .judged(baseline)
        .map(|(result, verdict)| {
            let key = (&*result.scene, &*result.oracle, result.guid.clone());
            let detail = groups.range(..&key).count();
            row(
                result,
                verdict,
                baseline,
                groups.contains_key(&key).then_some(detail),
            )
        })
        .collect();
    let data = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "outcomes": series::BY_SEVERITY.map(|outcome| outcome.name()),
        "verdicts": Verdict::ALL.map(Verdict::name),
        "totals": Totals::of(&document.results, baseline),
        "counts": counts(document, baseline),
        "errors": document.errors,
        "flaky": document.flaky.iter().map(|flake| json!([flake.scene, flake.what])).collect::<Vec<_>>(),
        "skipped": document.skipped.iter().map(|skip| json!([skip.scene, skip.reason])).collect::<Vec<_>>(),
        "rules": rules(document, policy),
        "results": rows,
    });
    let mut blocks = block("data", &data);
    for (index, group) in groups.values().enumerate() {
        blocks.push_str(&block(&format!("d{index}"), &encode::group(group)));
    }
    PAGE.split_inclusive("-->")
        .map(|part| match part {
            _ if part.ends_with("<!--STYLE-->") => part.replace("<!--STYLE-->", STYLE),
            _ if part.ends_with("<!--DATA-->") => part.replace("<!--DATA-->", &blocks),
            _ if part.ends_with("<!--SCRIPT-->") => part.replace("<!--SCRIPT-->", SCRIPT),
            _ => part.to_owned(),
        })
        .collect()
}

/// A block of data. `<` is escaped, so that no string ends the block or opens a comment.
fn block(id: &str, data: &Value) -> String {
    let text = data.to_string().replace('<', "\\u003c");
    format!("<script type=\"application/json\" id=\"{id}\">{text}</script>\n")
}

/// The rules of the policy: for which scenes and oracles, what and why, and how many differences passed by each.
fn rules(document: &Document, policy: &Policy) -> Vec<Value> {
    let used = |title: &String| -> u64 {
        let of = document.results.iter();
        of.filter_map(|result| result.tolerated.get(title)).sum()
    };
    let rules = policy.rules.iter();
    rules
        .map(|rule| json!([rule.scope(), rule.title(), used(&rule.title())]))
        .collect()
}

/// One result as the script reads it: an array, because names would be most of the file.
fn row(result: &RunResult, verdict: Verdict, baseline: &Baseline, detail: Option<usize>) -> Value {
    let errors: Vec<Value> = result
        .max_error
        .iter()
        .map(|(field, max)| json!([field, max.abs, max.ulp.to_string(), max.frame, max.unit]))
        .collect();
    let stages: Vec<Value> = result
        .stages
        .iter()
        .map(|(stage, count)| json!([stage, count.compared, count.exact, count.not_run]))
        .collect();
    json!([
        result.scene,
        result.area,
        result.oracle,
        result.profile,
        result.mode.name(),
        result.guid,
        verdict as usize,
        baseline.accepts(result).map(|known| &known.reason),
        result.frames_compared,
        result.frames_exact,
        result.first_divergence.as_ref().map(divergence),
        errors,
        stages,
        detail,
        result.undefined,
        result.tolerated.iter().collect::<Vec<_>>(),
    ])
}

/// Values are text here: a double of the script would round some of them, and NaN has none.
fn divergence(first: &Divergence) -> Value {
    let error = error::between_values(&first.expected, &first.actual);
    json!([
        first.frame,
        first.stage,
        first.field,
        first.expected.to_string(),
        first.actual.to_string(),
        error.map(|error| error.ulp.to_string()),
        error.map(|error| error.abs),
        spec_links::section(first.stage.as_deref(), &first.field),
    ])
}

#[cfg(test)]
mod tests;
