//! Plans change nothing: every bundled scene has the same state hashes whatever is left out.

use std::collections::BTreeMap;

use ac_client::profile::Profile;
use ac_conformance::hash::{StateHash, hash_all};
use ac_conformance::run::cases;
use ac_golden_traces::corpus;
use ac_replayer::client::{ClientSimulator, PlanChoice};

/// The hashes of all bundled scenes under a profile and a plan: of the scene, and of its frames.
fn hashes(profile: &str, plan: PlanChoice) -> BTreeMap<String, (StateHash, Vec<StateHash>)> {
    let bundled = corpus::bundled();
    let simulator = ClientSimulator::new(bundled.join("worlds")).with_plan(plan);
    let cases = cases::find(&[bundled.join("traces")], None, None).expect("the traces are there");
    let profile = Profile::named(profile).expect("it is one of the presets");
    let (hashes, errors) = hash_all(&simulator, &cases, &profile, || {});
    assert!(errors.is_empty(), "{errors:?}");
    hashes
        .into_iter()
        .map(|h| (h.scene, (h.hash, h.frames)))
        .collect()
}

#[test]
fn every_bundled_scene_is_the_same_under_every_plan() {
    for profile in ["retail", "ace", "gdle", "gdle-repaired"] {
        let expected = hashes(profile, PlanChoice::OnDemand);
        assert!(expected.len() >= 178, "{} scenes", expected.len());
        for plan in [PlanChoice::Full, PlanChoice::Auto] {
            let name = format!("{plan:?} under {profile}");
            let produced = hashes(profile, plan);
            assert_eq!(produced.len(), expected.len());
            let differs = |(scene, (hash, frames)): (&String, &(StateHash, Vec<StateHash>))| {
                let (other, other_frames) = &produced[scene];
                let first = frames.iter().zip(other_frames).position(|(a, b)| a != b);
                (hash != other)
                    .then(|| format!("{scene}: frame {}", first.map_or(-2, |f| f as i64 - 1)))
            };
            let different: Vec<String> = expected.iter().filter_map(differs).collect();
            assert!(
                different.is_empty(),
                "{name}: {} differ: {different:#?}",
                different.len()
            );
        }
    }
}
