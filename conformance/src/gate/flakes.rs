//! Failures that are not the same twice.

use std::collections::{BTreeMap, BTreeSet};

use ac_client::profile::Profile;
use ac_replayer::Simulator;

use super::Flake;
use crate::{
    compare::policy::Policy,
    hash,
    run::{self, Case, Options, Outcome, RunResult},
};

/// Divergences of a scene.
pub(super) fn failing<'a>(
    outcome: &'a Outcome,
    scene: &'a str,
) -> impl Iterator<Item = &'a RunResult> {
    outcome
        .results
        .iter()
        .filter(move |result| result.scene == scene && result.first_divergence.is_some())
}

/// Runs scenes with failures again, and hashes them twice under every profile with a failure.
pub(super) fn flakes(
    simulator: &dyn Simulator,
    again: &BTreeMap<String, Vec<Case>>,
    options: &Options,
    policy: &Policy,
    first: &Outcome,
) -> Vec<Flake> {
    let mut flakes = Vec::new();
    for (scene, cases) in again {
        let second = run::run_with(simulator, cases, options, policy, |_, _| ());
        let before = first.results.iter().filter(|result| result.scene == *scene);
        if !second.results.iter().eq(before) {
            let what = "the second run gave other results".into();
            flakes.push(Flake {
                scene: scene.clone(),
                what,
            });
            continue;
        }
        let Some(case) = cases.first() else { continue };
        let profiles: BTreeSet<&str> = failing(first, scene)
            .map(|result| result.profile.as_str())
            .collect();
        for name in profiles {
            let Some(profile) = Profile::named(name) else {
                continue;
            };
            let hash = || hash::hash_case(simulator, case, &profile).ok();
            if let (Some(a), Some(b)) = (hash(), hash())
                && a.hash != b.hash
            {
                let what = format!(
                    "two runs under {name} have the state hashes {} and {}",
                    a.hash, b.hash
                );
                flakes.push(Flake {
                    scene: scene.clone(),
                    what,
                });
            }
        }
    }
    flakes
}
