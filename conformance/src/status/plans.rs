//! The part of the page about plans: what is saved by leaving out what no state needs.

use serde::Deserialize;
use std::fmt::Write;

use super::{heading, row, share};

/// What a class of scenes costs under a plan, as the example `plan_costs` of the replayer prints it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct PlanCost {
    /// Class of scenes.
    pub class: String,
    /// `full`, `auto`, or `index`: what is measured once per world.
    pub plan: String,
    /// Scenes of the class.
    #[serde(default)]
    pub scenes: u64,
    /// Scenes with the same states under both plans.
    #[serde(default)]
    pub same: u64,
    /// Time, all scenes together.
    pub seconds: f64,
    /// Bytes read from the dat files, and of the stored index.
    pub bytes: u64,
}

/// Costs from JSON Lines, in their order.
///
/// # Errors
/// When a line is no such record.
pub fn plan_costs(text: &[u8]) -> serde_json::Result<Vec<PlanCost>> {
    serde_json::Deserializer::from_slice(text)
        .into_iter()
        .collect()
}

pub(super) fn section(text: &mut String, costs: &[PlanCost]) {
    if costs.is_empty() {
        return;
    }
    text.push_str(
        "## Plans\n\nEverything that a client does (`full`) beside what can change the states that are asked for (`auto`), `docs/plans.md` \
         (`cargo run --release -p ac-replayer --example plan_costs`). *Same*: scenes whose states have the same bits.\n\n",
    );
    let columns = [
        "same",
        "time, full",
        "auto",
        "ratio",
        "dat bytes, full",
        "auto",
        "ratio",
    ];
    heading(text, "scenes", &columns);
    let of = |class: &str, plan: &str| costs.iter().find(|c| c.class == class && c.plan == plan);
    for full in costs.iter().filter(|c| c.plan == "full") {
        let Some(auto) = of(&full.class, "auto") else {
            continue;
        };
        let cells = [
            share(auto.same, auto.scenes),
            format!("{:.3} s", full.seconds),
            format!("{:.3} s", auto.seconds),
            format!("{:.1}", full.seconds / auto.seconds),
            full.bytes.to_string(),
            auto.bytes.to_string(),
            format!("{:.1}", full.bytes as f64 / auto.bytes as f64),
        ];
        row(text, &full.class, cells);
    }
    text.push('\n');
    let once: Vec<String> = costs
        .iter()
        .filter(|c| c.plan == "index")
        .map(|c| format!("{}: {:.2} s, {} bytes", c.class, c.seconds, c.bytes))
        .collect();
    if !once.is_empty() {
        let _ = writeln!(
            text,
            "Once per world, and then kept in a file: which landblocks and rooms belong together ({}).\n",
            once.join("; ")
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_class_is_a_row_and_the_index_a_note() {
        let lines = br#"{"class":"town","plan":"index","seconds":0.5,"bytes":1000}
{"class":"town","plan":"full","scenes":1,"same":1,"frames":500,"seconds":1.0,"records":9,"bytes":5000}
{"class":"town","plan":"auto","scenes":1,"same":1,"frames":500,"seconds":0.1,"records":2,"bytes":250}"#;
        let mut text = String::new();
        section(&mut text, &plan_costs(lines).unwrap());
        assert!(
            text.contains("| town | 1/1 | 1.000 s | 0.100 s | 10.0 | 5000 | 250 | 20.0 |"),
            "{text}"
        );
        assert!(text.contains("town: 0.50 s, 1000 bytes"), "{text}");
        let mut nothing = String::new();
        section(&mut nothing, &[]);
        assert!(nothing.is_empty());
    }
}
