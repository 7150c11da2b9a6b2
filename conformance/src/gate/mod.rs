//! The gate: what a run means for a change that wants in.
//!
//! Every result has one [`Verdict`]. *New*, *changed* and *flaky* close the gate; *known* does not, and *fixed* asks to tidy the
//! baseline. A scene with a failure is run again: if the second run or its state hashes say something else, the failure is
//! flaky, which closes the gate too: a deterministic client has no flakes.
//!
//! A [`Document`] is what `--format json` writes and `ac-conform merge` reads: results with everything around them.

mod flakes;
pub mod output;
pub mod partition;

use std::collections::{BTreeMap, BTreeSet};

use ac_replayer::Simulator;
use serde::{Deserialize, Serialize};

use flakes::{failing, flakes};
pub use partition::Shard;

use crate::{
    compare::{Class, policy::Policy},
    hash,
    report_html::Series,
    run::{
        self, Case, Options, RunResult,
        baseline::{Baseline, Known},
        report::{self, Totals},
    },
};

/// What a result means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// The same bits.
    Exact,
    /// A rule of the policy allows what differs.
    WithinTolerance,
    /// The baseline has it.
    Known,
    /// The baseline has an entry for it, but the divergence comes earlier, or in another field of the same frame.
    Changed,
    /// The baseline has no entry for it.
    New,
    /// Running it twice gave two answers.
    Flaky,
}

impl Verdict {
    /// Every verdict, from the best to the worst.
    pub const ALL: [Self; 6] = [
        Self::Exact,
        Self::WithinTolerance,
        Self::Known,
        Self::Changed,
        Self::New,
        Self::Flaky,
    ];

    /// Its name in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::WithinTolerance => "within tolerance",
            Self::Known => "known",
            Self::Changed => "changed",
            Self::New => "new",
            Self::Flaky => "flaky",
        }
    }

    /// Whether it closes the gate.
    pub const fn fails(self) -> bool {
        matches!(self, Self::Changed | Self::New | Self::Flaky)
    }
}

/// A scene whose second run gave another answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Flake {
    /// The scene.
    pub scene: String,
    /// What the two runs said.
    pub what: String,
}

/// A scene that was not run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Skipped {
    /// The scene.
    pub scene: String,
    /// Why.
    pub reason: String,
}

/// A run with everything around it.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct Document {
    /// [`report::SCHEMA`].
    pub schema: String,
    /// By scene, oracle, mode, entity.
    pub results: Vec<RunResult>,
    /// The part of a sharded run that this is.
    #[serde(default)]
    pub shard: Option<Shard>,
    /// Scenes that are flaky.
    #[serde(default)]
    pub flaky: Vec<Flake>,
    /// Scenes that the policy skips.
    #[serde(default)]
    pub skipped: Vec<Skipped>,
    /// What could not run.
    #[serde(default)]
    pub errors: Vec<String>,
    /// What a report draws, if it was asked for; not in the JSON.
    #[serde(skip)]
    pub series: Vec<Series>,
}

/// Why documents cannot be merged.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    /// Not a document of this program.
    #[error("{name}: schema `{schema}` is not `{}`", report::SCHEMA)]
    Schema {
        /// The file.
        name: String,
        /// What it says.
        schema: String,
    },
    /// Parts of different runs.
    #[error("{name}: shard {shard} does not belong to a run cut like {other}")]
    Cut {
        /// The file.
        name: String,
        /// Its shard.
        shard: String,
        /// That of the first.
        other: String,
    },
    /// A part is not there.
    #[error("shard {shard} is missing")]
    Missing {
        /// The part.
        shard: String,
    },
    /// The same thing twice.
    #[error("{name}: {what} is in another document too")]
    Twice {
        /// The file.
        name: String,
        /// A shard or a result.
        what: String,
    },
}

impl Document {
    /// Runs the cases of a shard that the policy does not skip, and those with failures twice.
    pub fn run(
        simulator: &dyn Simulator,
        cases: &[Case],
        options: &Options,
        policy: &Policy,
        shard: Option<Shard>,
        done: impl Fn(&Case, &[RunResult]) + Sync,
    ) -> Self {
        let mut document = Self {
            schema: report::SCHEMA.into(),
            shard,
            ..Self::default()
        };
        let cases = document.select(cases, policy);
        let paths: Vec<Case> = cases.iter().map(|(_, case)| case.clone()).collect();
        let outcome = run::run_with(simulator, &paths, options, policy, done);
        let mut again: BTreeMap<String, Vec<Case>> = BTreeMap::new();
        for (scene, case) in cases {
            if failing(&outcome, &scene).next().is_some() {
                again.entry(scene).or_default().push(case);
            }
        }
        document.flaky = flakes(simulator, &again, options, policy, &outcome);
        document.errors = outcome.errors.iter().map(ToString::to_string).collect();
        document.results = outcome.results;
        document.series = outcome.series;
        document
    }

    /// The cases of this shard, by scene name; skipped ones are noted.
    fn select(&mut self, cases: &[Case], policy: &Policy) -> Vec<(String, Case)> {
        // A file that cannot be read goes by its name, and says so when it is run.
        let name = |case: &Case| match hash::scene_of(case) {
            Ok(scene) => scene.name,
            Err(_) => case
                .path()
                .file_name()
                .map(|name| name.to_string_lossy().into_owned())
                .unwrap_or_default(),
        };
        let mut named: Vec<_> = cases
            .iter()
            .map(|case| (name(case), case.clone()))
            .collect();
        named.sort();
        // A scene may be in two traces, the oracles' and the library's own: it is still one scene.
        let mut scenes: Vec<String> = named.iter().map(|(scene, _)| scene.clone()).collect();
        scenes.dedup();
        let mut kept = BTreeSet::new();
        for (place, scene) in scenes.into_iter().enumerate() {
            if self.shard.is_some_and(|shard| !shard.has(place, &scene)) {
                continue;
            }
            match policy.skips(&scene) {
                None => drop(kept.insert(scene)),
                Some(skip) => self.skipped.push(Skipped {
                    reason: skip.reason.clone(),
                    scene,
                }),
            }
        }
        named.retain(|(scene, _)| kept.contains(scene));
        named
    }

    /// What a result means against a baseline.
    pub fn verdict(&self, result: &RunResult, baseline: &Baseline) -> Verdict {
        if result.first_divergence.is_none() {
            return match result.class {
                Class::WithinTolerance => Verdict::WithinTolerance,
                _ => Verdict::Exact,
            };
        }
        if self.flaky.iter().any(|flake| flake.scene == result.scene) {
            Verdict::Flaky
        } else if baseline.accepts(result).is_some() {
            Verdict::Known
        } else if baseline.known.iter().any(|known| known.names(result)) {
            Verdict::Changed
        } else {
            Verdict::New
        }
    }

    /// Results with their verdicts.
    pub fn judged<'a>(
        &'a self,
        baseline: &'a Baseline,
    ) -> impl Iterator<Item = (&'a RunResult, Verdict)> {
        self.results
            .iter()
            .map(|result| (result, self.verdict(result, baseline)))
    }

    /// Whether something closes the gate.
    pub fn fails(&self, baseline: &Baseline) -> bool {
        !self.flaky.is_empty() || self.judged(baseline).any(|(_, verdict)| verdict.fails())
    }

    /// Entries of the baseline that did not diverge any more.
    pub fn fixed<'a>(&'a self, baseline: &'a Baseline) -> impl Iterator<Item = &'a Known> {
        baseline.fixed(&self.results)
    }

    /// The JSON text: that of [`report::json`], with what is around the results where there is any.
    ///
    /// # Errors
    /// Never in practice: it is plain data.
    pub fn json(&self, baseline: &Baseline) -> serde_json::Result<String> {
        let mut text = report::json(&self.results, &Totals::of(&self.results, baseline))?;
        // Reopens the document.
        text.truncate(text.trim_end().len().saturating_sub(1));
        if let Some(shard) = self.shard {
            text += &format!(",\n\"shard\":{}", serde_json::to_string(&shard)?);
        }
        for (name, list) in [
            ("flaky", serde_json::to_string(&self.flaky)?),
            ("skipped", serde_json::to_string(&self.skipped)?),
            ("errors", serde_json::to_string(&self.errors)?),
        ] {
            if list != "[]" {
                text += &format!(",\n\"{name}\":{list}");
            }
        }
        text.push_str("}\n");
        Ok(text)
    }

    /// Puts the parts of a run together. What is missing or doubled is an error: a gate must not pass on half a run.
    ///
    /// # Errors
    /// When the parts are not those of one run.
    pub fn merge(parts: Vec<(String, Self)>) -> Result<Self, MergeError> {
        let mut shards: Vec<Shard> = Vec::new();
        let mut seen = BTreeSet::new();
        let mut merged = Self {
            schema: report::SCHEMA.into(),
            ..Self::default()
        };
        for (name, mut part) in parts {
            if part.schema != report::SCHEMA {
                let schema = part.schema;
                return Err(MergeError::Schema { name, schema });
            }
            if let Some(shard) = part.shard {
                check_shard(&name, shard, &shards)?;
                shards.push(shard);
            }
            for result in &mut part.results {
                if result.first_divergence.is_some() {
                    result.class = Class::Diverged;
                }
                let what = format!(
                    "{} {} {} {}",
                    result.scene,
                    result.oracle,
                    result.mode.name(),
                    result.guid
                );
                if !seen.insert(what.clone()) {
                    return Err(MergeError::Twice { name, what });
                }
            }
            merged.results.append(&mut part.results);
            merged.flaky.append(&mut part.flaky);
            merged.skipped.append(&mut part.skipped);
            merged.errors.append(&mut part.errors);
        }
        if let Some(first) = shards.first().copied() {
            let all = (1..=first.total).map(|index| Shard { index, ..first });
            if let Some(missing) = all.into_iter().find(|shard| !shards.contains(shard)) {
                let shard = missing.to_string();
                return Err(MergeError::Missing { shard });
            }
        }
        merged
            .results
            .sort_by(|a, b| (&a.scene, &a.oracle, a.mode).cmp(&(&b.scene, &b.oracle, b.mode)));
        Ok(merged)
    }
}

fn check_shard(name: &str, shard: Shard, before: &[Shard]) -> Result<(), MergeError> {
    let name = name.to_owned();
    if before.contains(&shard) {
        let what = format!("shard {shard}");
        return Err(MergeError::Twice { name, what });
    }
    match before.first() {
        Some(first) if (first.cut, first.total) != (shard.cut, shard.total) => {
            Err(MergeError::Cut {
                name,
                shard: shard.to_string(),
                other: first.to_string(),
            })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
