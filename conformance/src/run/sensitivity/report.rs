//! Sensitivities as JSON and as text.

use std::{collections::BTreeMap, fmt::Write};

use ac_client::profile::{Profile, Switch};
use serde::Serialize;

use super::{SceneSensitivity, differing};

/// Schema of the JSON document.
pub const SCHEMA: &str = "ac-conform-sensitivity/1";

/// How many scenes are sensitive to a switch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SwitchCount {
    /// Name of the switch: its field in [`Profile`].
    pub switch: &'static str,
    /// Identifiers in the specification.
    pub id: &'static str,
    /// Choice of `retail`.
    pub retail_choice: String,
    /// Per oracle that chooses differently: its choice and the number of sensitive scenes.
    pub oracles: BTreeMap<String, OracleCount>,
}

/// The part of a [`SwitchCount`] that is one oracle's.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OracleCount {
    /// Choice of the oracle's profile.
    pub choice: String,
    /// Scenes that change when the switch is set to the choice of `retail`.
    pub scenes: usize,
}

impl SwitchCount {
    /// Whether no scene of any oracle is sensitive to it.
    pub fn is_unseen(&self) -> bool {
        self.oracles.values().all(|count| count.scenes == 0)
    }
}

/// Counts scenes per switch, in the order of the specification's index: every switch in which an oracle that occurs in `scenes`
/// differs from `retail`, those without a sensitive scene too.
pub fn switch_counts(scenes: &[SceneSensitivity]) -> Vec<SwitchCount> {
    let retail = Profile::retail();
    let count = |oracle: &str, switch: &Switch| {
        scenes
            .iter()
            .filter(|scene| scene.oracle == oracle)
            .filter(|scene| scene.sensitive.iter().any(|s| s.switch == switch.field))
            .count()
    };
    let mut oracles: Vec<&str> = scenes.iter().map(|scene| scene.oracle.as_str()).collect();
    oracles.sort_unstable();
    oracles.dedup();
    let mut counts: BTreeMap<&str, BTreeMap<String, OracleCount>> = BTreeMap::new();
    for oracle in oracles {
        let Some(own) = Profile::named(oracle) else {
            continue;
        };
        for switch in differing(&own, &retail) {
            let of_oracle = OracleCount {
                choice: (switch.show)(&own),
                scenes: count(oracle, switch),
            };
            counts
                .entry(switch.field)
                .or_default()
                .insert(oracle.into(), of_oracle);
        }
    }
    Profile::SWITCHES
        .iter()
        .filter_map(|switch| {
            Some(SwitchCount {
                switch: switch.field,
                id: switch.id,
                retail_choice: (switch.show)(&retail),
                oracles: counts.remove(switch.field)?,
            })
        })
        .collect()
}

#[derive(Serialize)]
struct Totals {
    scenes: usize,
    unmet: usize,
    runs: usize,
    changed: usize,
    switches: usize,
    switches_unseen: usize,
}

impl Totals {
    fn of(scenes: &[SceneSensitivity], counts: &[SwitchCount]) -> Self {
        let sum = |each: fn(&SceneSensitivity) -> usize| scenes.iter().map(each).sum();
        Self {
            scenes: scenes.len(),
            unmet: sum(|scene| usize::from(scene.unmet.is_some())),
            runs: sum(|scene| scene.tried),
            changed: sum(|scene| scene.sensitive.len()),
            switches: counts.len(),
            switches_unseen: counts.iter().filter(|count| count.is_unseen()).count(),
        }
    }
}

/// The JSON document, one scene and oracle or one switch per line.
///
/// # Errors
/// Never in practice: results are plain data.
pub fn json(scenes: &[SceneSensitivity]) -> serde_json::Result<String> {
    let counts = switch_counts(scenes);
    let mut text = format!("{{\"schema\":\"{SCHEMA}\",\"scenes\":[");
    lines(&mut text, scenes)?;
    text.push_str("],\"switches\":[");
    lines(&mut text, &counts)?;
    text.push_str("],\"totals\":");
    text.push_str(&serde_json::to_string(&Totals::of(scenes, &counts))?);
    text.push_str("}\n");
    Ok(text)
}

fn lines<T: Serialize>(text: &mut String, items: &[T]) -> serde_json::Result<()> {
    for (index, item) in items.iter().enumerate() {
        text.push_str(if index == 0 { "\n" } else { ",\n" });
        text.push_str(&serde_json::to_string(item)?);
    }
    text.push('\n');
    Ok(())
}

/// Per scene the switches with the first change, then the number of scenes per switch.
pub fn human(scenes: &[SceneSensitivity]) -> String {
    let mut text = String::new();
    for scene in scenes {
        scene_lines(&mut text, scene);
    }
    let counts = switch_counts(scenes);
    count_table(&mut text, &counts);
    let totals = Totals::of(scenes, &counts);
    let _ = writeln!(
        text,
        "{} scenes and oracles ({} not met under the oracle's own profile), {} runs with one switch set: {} changed something; \
         {} of {} switches are seen by no scene (--format json lists them)",
        totals.scenes,
        totals.unmet,
        totals.runs,
        totals.changed,
        totals.switches_unseen,
        totals.switches
    );
    text
}

fn scene_lines(text: &mut String, scene: &SceneSensitivity) {
    let _ = write!(text, "{} {}: ", scene.scene, scene.oracle);
    let place = |change: &super::Change| {
        format!(
            "frame {} {} {}: expected {}, got {}",
            change.divergence.frame,
            change.guid,
            change.divergence.field,
            change.divergence.expected,
            change.divergence.actual
        )
    };
    if let Some(unmet) = &scene.unmet {
        let _ = writeln!(
            text,
            "nothing tried, not met under the oracle's own profile: {}",
            place(unmet)
        );
        return;
    }
    let _ = writeln!(
        text,
        "{} of {} switches",
        scene.sensitive.len(),
        scene.tried
    );
    for sensitive in &scene.sensitive {
        let _ = writeln!(
            text,
            "    {} ({}), {} instead of {}: {}",
            sensitive.switch,
            sensitive.id,
            sensitive.retail_choice,
            sensitive.oracle_choice,
            place(&sensitive.change)
        );
    }
}

/// Scenes per switch and oracle; what no scene sees is left out.
fn count_table(text: &mut String, counts: &[SwitchCount]) {
    let mut oracles: Vec<&String> = counts
        .iter()
        .flat_map(|count| count.oracles.keys())
        .collect();
    oracles.sort_unstable();
    oracles.dedup();
    let _ = write!(text, "\n{:<30} {:<32}", "switch", "specification");
    for oracle in &oracles {
        let _ = write!(text, " {oracle:>13}");
    }
    text.push('\n');
    for count in counts.iter().filter(|count| !count.is_unseen()) {
        let _ = write!(text, "{:<30} {:<32}", count.switch, count.id);
        for oracle in &oracles {
            let scenes = count.oracles.get(*oracle);
            let scenes = scenes.map_or("-".into(), |count| count.scenes.to_string());
            let _ = write!(text, " {scenes:>13}");
        }
        text.push('\n');
    }
}
