//! The part of the page about time: benchmarks, the cost of a tick, and what it was measured on.

use std::{fs, path::Path};

use ac_golden_traces::corpus;
use serde::Deserialize;
use serde_json::Value;

use super::{heading, row};

/// A benchmark's result.
#[derive(Clone, Debug, PartialEq)]
pub struct Bench {
    /// Group and function.
    pub name: String,
    /// Nanoseconds per iteration, median.
    pub median: f64,
    /// Elements per iteration, if it counts them.
    pub elements: Option<u64>,
}

/// Cost of one tick of one object, as the example `tick_costs` of the client library prints it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Cost {
    /// What is ticked.
    pub case: String,
    /// Nanoseconds.
    pub ns: f64,
    /// Instructions, where they were counted.
    #[serde(default)]
    pub instructions: Option<f64>,
    /// Allocations.
    pub allocations: f64,
}

/// Processors and their model, as far as the system says: `2 processors, AMD EPYC`.
pub fn machine() -> String {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info
        .lines()
        .filter_map(|line| line.split_once(':'))
        .find(|(key, _)| key.trim() == "model name")
        .map_or(std::env::consts::ARCH, |(_, model)| model.trim());
    let plural = if threads == 1 { "" } else { "s" };
    format!("{threads} processor{plural}, {model}")
}

/// Results that `cargo bench` left under `target/criterion`, by name. What cannot be read is left out.
pub fn benches_in(target: &Path) -> Vec<Bench> {
    let files = corpus::find(
        &target.join("criterion"),
        &["new/estimates.json", "new\\estimates.json"],
    )
    .unwrap_or_default();
    let mut benches: Vec<Bench> = files.iter().filter_map(|file| bench(file)).collect();
    benches.sort_by(|a, b| a.name.cmp(&b.name));
    benches
}

fn bench(estimates: &Path) -> Option<Bench> {
    let read = |path: &Path| serde_json::from_slice::<Value>(&fs::read(path).ok()?).ok();
    let about = read(&estimates.with_file_name("benchmark.json"))?;
    Some(Bench {
        name: about.get("full_id")?.as_str()?.into(),
        median: read(estimates)?
            .pointer("/median/point_estimate")?
            .as_f64()?,
        elements: about
            .pointer("/throughput/Elements")
            .and_then(Value::as_u64),
    })
}

/// Costs from JSON Lines, in their order.
///
/// # Errors
/// When a line is no such record.
pub fn costs(text: &[u8]) -> serde_json::Result<Vec<Cost>> {
    serde_json::Deserializer::from_slice(text)
        .into_iter()
        .collect()
}

pub(super) fn section(text: &mut String, benches: &[Bench], costs: &[Cost]) {
    if !costs.is_empty() {
        text.push_str("## Cost of a tick\n\nOne entity, one frame, after everything has settled (`cargo run --release -p ac-client --example tick_costs`).\n\n");
        heading(text, "case", &["time", "instructions", "allocations"]);
        for cost in costs {
            let instructions = cost
                .instructions
                .map_or("–".into(), |count| format!("{count:.0}"));
            let cells = [
                duration(cost.ns),
                instructions,
                format!("{}", cost.allocations),
            ];
            row(text, &cost.case, cells);
        }
        text.push('\n');
    }
    if !benches.is_empty() {
        text.push_str("## Benchmarks\n\nMedians of `cargo bench`, one thread.\n\n");
        heading(text, "benchmark", &["time", "per second"]);
        for bench in benches {
            let rate = bench.elements.map_or("–".into(), |elements| {
                format!("{:.2e}", elements as f64 * 1e9 / bench.median)
            });
            row(text, &bench.name, [duration(bench.median), rate]);
        }
    }
}

fn duration(nanoseconds: f64) -> String {
    match nanoseconds {
        ns if ns < 1e3 => format!("{ns:.1} ns"),
        ns if ns < 1e6 => format!("{:.2} µs", ns / 1e3),
        ns if ns < 1e9 => format!("{:.2} ms", ns / 1e6),
        ns => format!("{:.2} s", ns / 1e9),
    }
}
