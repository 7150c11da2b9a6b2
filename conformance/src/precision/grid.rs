//! Settings: what a client may choose, one axis at a time around the oracle's own.

use ac_client::{frame::Fidelity, profile::Profile};
use ac_replayer::client::PlanChoice;
use serde::Serialize;

/// Shortest and longest quantum of the grid, and those between, as parts of a second.
const QUANTA: [u32; 9] = [960, 480, 240, 120, 60, 30, 20, 10, 5];
/// Frames per second.
const RATES: [u32; 5] = [15, 30, 60, 120, 240];
/// Remote entities are updated in every so many frames.
const REMOTE: [u32; 3] = [2, 4, 8];
/// Quanta that every profile is run with.
const PROFILE_QUANTA: [Option<u32>; 4] = [None, Some(240), Some(30), Some(10)];

/// What a setting changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// Nothing: the oracle's own constants and frames.
    Own,
    /// All quanta have one length.
    Quantum,
    /// Frames come at another rate.
    FrameRate,
    /// As the frame rate, and every frame is one quantum.
    FrameQuantum,
    /// Remote entities are updated less often.
    Remote,
    /// Another profile, with its own constants or quanta of one length.
    Profile,
    /// A scene plan says how much of the world there is. Without one records are opened when they are first asked for.
    Plan,
}

impl Axis {
    /// The name in tables and plots.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Own => "own",
            Self::Quantum => "quantum",
            Self::FrameRate => "frame rate",
            Self::FrameQuantum => "frame rate, one quantum per frame",
            Self::Remote => "remote updates",
            Self::Profile => "profile",
            Self::Plan => "scene plan",
        }
    }
}

/// One point of the grid.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Setting {
    /// What it changes.
    pub axis: Axis,
    /// Its name, unique in a grid.
    pub name: String,
    /// The profile.
    pub profile: &'static str,
    /// Quanta per second, where they have one length.
    pub quanta_per_second: Option<u32>,
    /// Frames per second; `None`: those of the scene.
    pub frame_rate: Option<u32>,
    /// Remote entities are updated in every so many frames.
    pub remote_every: u32,
    /// How much of a scene's work is done.
    pub plan: Option<PlanUse>,
}

/// A plan that is the same for every scene by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PlanUse {
    /// The whole window of landblocks around the first tracked entity, as a client loads it.
    Full,
    /// What the planner cannot show to be without effect.
    Auto,
}

impl PlanUse {
    /// The choice of the replayer.
    pub fn choice(self) -> PlanChoice {
        match self {
            Self::Full => PlanChoice::Full,
            Self::Auto => PlanChoice::Auto,
        }
    }
}

impl Setting {
    /// The oracle's own constants and the scene's own frames.
    pub fn own(profile: &'static str) -> Self {
        Self {
            axis: Axis::Own,
            name: "own".into(),
            profile,
            quanta_per_second: None,
            frame_rate: None,
            remote_every: 1,
            plan: None,
        }
    }

    /// Quanta of one length at the scene's own frames.
    pub fn quanta(profile: &'static str, per_second: u32) -> Self {
        Self {
            axis: Axis::Quantum,
            name: format!("q 1/{per_second}"),
            quanta_per_second: Some(per_second),
            ..Self::own(profile)
        }
    }

    /// The knobs of the client.
    pub fn fidelity(&self) -> Fidelity {
        let knobs = Fidelity {
            remote_update_every: self.remote_every,
            frame_rate: self.frame_rate.map(f64::from),
            ..Fidelity::RETAIL
        };
        match self.quanta_per_second {
            Some(per_second) => knobs.with_quantum(1.0 / f64::from(per_second)),
            None => knobs,
        }
    }

    /// The profile with its limits of a quantum.
    pub fn profile(&self) -> Profile {
        Profile::named(self.profile).unwrap_or_default()
    }
}

/// The whole grid around the own setting of a profile.
pub fn full(profile: &'static str) -> Vec<Setting> {
    let own = Setting::own(profile);
    let mut grid = vec![own.clone()];
    grid.extend(QUANTA.map(|per_second| Setting::quanta(profile, per_second)));
    for rate in RATES {
        grid.push(Setting {
            axis: Axis::FrameRate,
            name: format!("{rate} Hz"),
            frame_rate: Some(rate),
            ..own.clone()
        });
        grid.push(Setting {
            axis: Axis::FrameQuantum,
            name: format!("{rate} Hz, q 1/{rate}"),
            frame_rate: Some(rate),
            quanta_per_second: Some(rate),
            ..own.clone()
        });
    }
    grid.extend(REMOTE.map(|every| Setting {
        axis: Axis::Remote,
        name: format!("remote 1/{every}"),
        remote_every: every,
        ..own.clone()
    }));
    for other in PROFILES.into_iter().filter(|name| *name != profile) {
        grid.extend(PROFILE_QUANTA.map(|quanta| Setting {
            axis: Axis::Profile,
            name: quanta.map_or(other.into(), |per_second| {
                format!("{other}, q 1/{per_second}")
            }),
            quanta_per_second: quanta,
            ..Setting::own(other)
        }));
    }
    let plans = [("plan auto", PlanUse::Auto), ("plan full", PlanUse::Full)];
    grid.extend(plans.map(|(name, plan)| Setting {
        axis: Axis::Plan,
        name: name.into(),
        plan: Some(plan),
        ..own.clone()
    }));
    grid
}

/// A few points of the grid: seconds instead of minutes.
pub fn quick(profile: &'static str) -> Vec<Setting> {
    const KEPT: [&str; 9] = [
        "own",
        "q 1/240",
        "q 1/120",
        "q 1/60",
        "q 1/30",
        "q 1/10",
        "30 Hz",
        "remote 1/4",
        "plan auto",
    ];
    let mut grid = full(profile);
    grid.retain(|setting| KEPT.contains(&&*setting.name));
    grid
}

/// Every profile that has a name.
pub const PROFILES: [&str; 4] = ["retail", "ace", "gdle", "gdle-repaired"];

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn names_are_unique_and_every_axis_is_there() {
        let grid = full("gdle-repaired");
        let names: BTreeSet<&str> = grid.iter().map(|setting| &*setting.name).collect();
        assert_eq!(names.len(), grid.len());
        let axes: BTreeSet<Axis> = grid.iter().map(|setting| setting.axis).collect();
        assert_eq!(axes.len(), 7);
        for name in PROFILES {
            assert!(Profile::named(name).is_some(), "{name}");
            assert!(grid.iter().any(|setting| setting.profile == name), "{name}");
        }
        assert_eq!(quick("gdle-repaired").len(), 9);
    }

    #[test]
    fn the_own_setting_turns_no_knob() {
        assert_eq!(Setting::own("ace").fidelity(), Fidelity::RETAIL);
    }
}
