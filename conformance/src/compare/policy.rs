//! What may differ, how far, and why.
//!
//! The default is strict: the same bits, nothing else. A *policy file* (TOML) widens that for named fields of named scenes.
//! Every rule carries its reason, and every report that a rule had a part in prints it:
//!
//! ```toml
//! [[tolerance]]
//! scene = "jump/*"        # glob over the scene's name; left out: every scene
//! oracle = "ace"          # glob; left out: every oracle
//! field = "velocity"      # glob over the field's name without indices (`contact_plane.n`; in mode stage `integrate.velocity`)
//! ulp = 4                 # or abs = 0.001, rel = 1e-6, angle = 0.001, distance = 0.001, exact = true, any = true
//! reason = "…"
//!
//! [[skip]]
//! scene = "extreme/*"
//! reason = "…"
//! ```
//!
//! The first rule that names a difference decides. A field that is missing, or null where a value is expected, is never within a
//! bound, nor is a number that is not finite.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use globset::{Glob, GlobMatcher};
use serde::Deserialize;
use serde_json::Value;

use super::{error::Error, fields::Difference};
use crate::vectors::json;

/// How far a field may be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// Not at all: takes fields out of a wider rule that follows.
    Exact,
    /// So many floats.
    Ulp(u64),
    /// So much in the field's unit.
    Abs(f64),
    /// So much of the larger magnitude of the two.
    Rel(f64),
    /// `rotation` only: radians between the two orientations; q and -q are the same orientation.
    Angle(f64),
    /// `origin` only: metres between the two points, across landblock borders.
    Distance(f64),
    /// Anything that is there: for ids that follow from a tolerated number, like `cell` beside a border.
    Any,
}

impl std::fmt::Display for Bound {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Exact => f.write_str("exact"),
            Self::Ulp(bound) => write!(f, "{bound} ulp"),
            Self::Abs(bound) => write!(f, "abs {bound:e}"),
            Self::Rel(bound) => write!(f, "rel {bound:e}"),
            Self::Angle(bound) => write!(f, "angle {bound:e} rad"),
            Self::Distance(bound) => write!(f, "distance {bound:e} m"),
            Self::Any => f.write_str("any value"),
        }
    }
}

/// One rule.
#[derive(Clone, Debug)]
pub struct Rule {
    names: Names,
    /// As in the file, for reports.
    pub field: String,
    fields: GlobMatcher,
    /// How far.
    pub bound: Bound,
    /// Why.
    pub reason: String,
}

impl Rule {
    /// Which scenes, areas and oracles it is for, as in the file.
    pub fn scope(&self) -> String {
        let names = [
            ("scene", &self.names.scene),
            ("area", &self.names.area),
            ("oracle", &self.names.oracle),
        ];
        let named: Vec<String> = names
            .into_iter()
            .filter(|(_, glob)| glob.glob().glob() != "**")
            .map(|(name, glob)| format!("{name} {}", glob.glob().glob()))
            .collect();
        match named.is_empty() {
            true => "every scene".into(),
            false => named.join(", "),
        }
    }

    /// The rule as a report names it.
    pub fn title(&self) -> String {
        format!("{} within {}: {}", self.field, self.bound, self.reason)
    }
}

/// A scene that is not run.
#[derive(Clone, Debug)]
pub struct Skip {
    names: Names,
    /// Why.
    pub reason: String,
}

/// Which scenes and oracles a rule is for.
#[derive(Clone, Debug)]
struct Names {
    scene: GlobMatcher,
    area: GlobMatcher,
    oracle: GlobMatcher,
}

impl Names {
    fn scene(&self, scene: &str) -> bool {
        let area = scene.split('/').next().unwrap_or("");
        self.scene.is_match(scene) && self.area.is_match(area)
    }
}

/// A policy file.
#[derive(Clone, Debug, Default)]
pub struct Policy {
    /// Tolerances, in order.
    pub rules: Vec<Arc<Rule>>,
    /// Scenes that are not run.
    pub skips: Vec<Skip>,
}

/// Why a policy cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PolicyError {
    /// Reading failed.
    #[error("{}: cannot be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        #[source]
        source: std::io::Error,
    },
    /// It is no policy.
    #[error("{}: {reason}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

/// The file as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    tolerance: Vec<RawRule>,
    #[serde(default)]
    skip: Vec<RawSkip>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRule {
    scene: Option<String>,
    area: Option<String>,
    oracle: Option<String>,
    field: String,
    exact: Option<bool>,
    ulp: Option<u64>,
    abs: Option<f64>,
    rel: Option<f64>,
    angle: Option<f64>,
    distance: Option<f64>,
    any: Option<bool>,
    reason: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSkip {
    scene: Option<String>,
    area: Option<String>,
    reason: String,
}

fn glob(text: Option<&str>) -> Result<GlobMatcher, String> {
    Glob::new(text.unwrap_or("**"))
        .map(|glob| glob.compile_matcher())
        .map_err(|error| error.to_string())
}

fn names(scene: Option<&str>, area: Option<&str>, oracle: Option<&str>) -> Result<Names, String> {
    Ok(Names {
        scene: glob(scene)?,
        area: glob(area)?,
        oracle: glob(oracle)?,
    })
}

fn reason(text: String) -> Result<String, String> {
    if text.trim().is_empty() {
        return Err("a reason is empty: say why".into());
    }
    Ok(text)
}

impl RawRule {
    fn bound(&self) -> Result<Bound, String> {
        let bounds: Vec<Bound> = [
            self.exact.filter(|on| *on).map(|_| Bound::Exact),
            self.ulp.map(Bound::Ulp),
            self.abs.map(Bound::Abs),
            self.rel.map(Bound::Rel),
            self.angle.map(Bound::Angle),
            self.distance.map(Bound::Distance),
            self.any.filter(|on| *on).map(|_| Bound::Any),
        ]
        .into_iter()
        .flatten()
        .collect();
        let [bound] = bounds[..] else {
            let reason = "needs exactly one of exact, ulp, abs, rel, angle, distance, any";
            return Err(format!("tolerance of `{}` {reason}", self.field));
        };
        match bound {
            Bound::Abs(x) | Bound::Rel(x) | Bound::Angle(x) | Bound::Distance(x)
                if !(x >= 0.0 && x.is_finite()) =>
            {
                Err(format!("tolerance of `{}`: {x} is no bound", self.field))
            }
            Bound::Angle(_) if self.field != "rotation" => Err(format!(
                "tolerance of `{}`: angle is for field `rotation`",
                self.field
            )),
            Bound::Distance(_) if self.field != "origin" => Err(format!(
                "tolerance of `{}`: distance is for field `origin`",
                self.field
            )),
            _ => Ok(bound),
        }
    }

    fn rule(self) -> Result<Rule, String> {
        Ok(Rule {
            bound: self.bound()?,
            names: names(
                self.scene.as_deref(),
                self.area.as_deref(),
                self.oracle.as_deref(),
            )?,
            fields: glob(Some(&self.field))?,
            field: self.field,
            reason: reason(self.reason)?,
        })
    }
}

impl Policy {
    /// Reads a policy file.
    ///
    /// # Errors
    /// When it cannot be read or is not as described in [the module](self).
    pub fn open(path: &Path) -> Result<Self, PolicyError> {
        let text = std::fs::read_to_string(path).map_err(|source| PolicyError::Io {
            path: path.into(),
            source,
        })?;
        Self::parse(&text).map_err(|reason| PolicyError::Parse {
            path: path.into(),
            reason,
        })
    }

    /// Reads the text of a policy file.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str) -> Result<Self, String> {
        let file: File = toml::from_str(text).map_err(|error| error.to_string())?;
        let rules = file.tolerance.into_iter();
        let skips = file.skip.into_iter();
        Ok(Self {
            rules: rules
                .map(|rule| rule.rule().map(Arc::new))
                .collect::<Result<_, _>>()?,
            skips: skips
                .map(|skip| {
                    Ok(Skip {
                        names: names(skip.scene.as_deref(), skip.area.as_deref(), None)?,
                        reason: reason(skip.reason)?,
                    })
                })
                .collect::<Result<_, String>>()?,
        })
    }

    /// The rules for a scene and an oracle.
    pub fn rules_for(&self, scene: &str, oracle: &str) -> Vec<Arc<Rule>> {
        let named =
            |rule: &&Arc<Rule>| rule.names.scene(scene) && rule.names.oracle.is_match(oracle);
        self.rules.iter().filter(named).cloned().collect()
    }

    /// Why a scene is not run; `None`: it is.
    pub fn skips(&self, scene: &str) -> Option<&Skip> {
        self.skips.iter().find(|skip| skip.names.scene(scene))
    }
}

/// The first rule that names a field.
pub(super) fn rule_of<'a>(rules: &'a [Arc<Rule>], field: &str) -> Option<&'a Rule> {
    rules
        .iter()
        .find(|rule| rule.fields.is_match(field))
        .map(|rule| &**rule)
}

impl Bound {
    /// Whether a number, or with [`Bound::Any`] anything, is within the bound. Bounds of whole vectors never are: they are
    /// measured elsewhere.
    pub(super) fn holds(self, error: Option<Error>, values: impl Fn() -> (Value, Value)) -> bool {
        if self == Self::Any {
            let (expected, actual) = values();
            // What presence and records are reported as; no id or name of a value is called so.
            let absent = |value: &Value| {
                value.is_null()
                    || ["missing", "present", "gone", "there"]
                        .contains(&value.as_str().unwrap_or(""))
            };
            return !absent(&expected) && !absent(&actual);
        }
        let Some(error) = error.filter(|error| error.abs.is_finite()) else {
            return false;
        };
        match self {
            Self::Ulp(bound) => error.ulp <= bound,
            Self::Abs(bound) => error.abs <= bound,
            Self::Rel(bound) => {
                let (expected, actual) = values();
                let magnitude = |value| json::f64(value).map_or(0.0, f64::abs);
                error.abs <= bound * magnitude(&expected).max(magnitude(&actual))
            }
            Self::Exact | Self::Angle(_) | Self::Distance(_) | Self::Any => false,
        }
    }

    /// Whether a difference is within the bound.
    pub(super) fn tolerates(self, difference: &Difference<'_>) -> bool {
        self.holds(difference.error, || (difference.values)())
    }
}

/// Radians between two orientations `[w, x, y, z]`, in 0 to π: the angle of the rotation that leads from one to the other. q and
/// -q are the same. Not-a-number if one of them is not finite or zero.
pub fn angle(a: [f32; 4], b: [f32; 4]) -> f64 {
    let [aw, ax, ay, az] = a.map(f64::from);
    let [bw, bx, by, bz] = b.map(f64::from);
    // Vector and scalar part of conj(a)·b: exact near zero, where an arc cosine of the dot product is not.
    let x = aw * bx - ax * bw - ay * bz + az * by;
    let y = aw * by - ay * bw - az * bx + ax * bz;
    let z = aw * bz - az * bw - ax * by + ay * bx;
    let w = aw * bw + ax * bx + ay * by + az * bz;
    let length = (x * x + y * y + z * z).sqrt();
    if length == 0.0 && w == 0.0 {
        return f64::NAN;
    }
    2.0 * length.atan2(w.abs())
}
