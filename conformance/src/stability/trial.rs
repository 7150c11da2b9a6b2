//! A case of the specification while it runs, and what came of it.

use std::fmt::Debug;

use ac_client::profile::Profile;
use serde::Serialize;

use super::{
    invariants::{Invariant, Violation, Watch},
    stage::{Run, Stage},
};

/// One stiff or extreme case that the specification lists.
pub struct Case {
    /// Number of the specification's file.
    pub section: &'static str,
    /// Place in the list of its section, from 1.
    pub number: u16,
    /// The case, in few words.
    pub title: &'static str,
    /// Builds it, runs it, and checks what must happen.
    pub run: fn(&mut Trial),
}

impl Case {
    /// `05/14`.
    pub fn id(&self) -> String {
        format!("{}/{:02}", self.section, self.number)
    }
}

/// What came of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Every check holds.
    Holds,
    /// Something does not hold, and retail does the same.
    AsRetail,
    /// Something does not hold, and it is ours.
    Ours,
    /// The library has no code that the case is about.
    NoCode,
}

impl Verdict {
    /// The word for it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::AsRetail => "as retail",
            Self::Ours => "ours",
            Self::NoCode => "no code",
        }
    }
}

/// A case that has run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseResult {
    /// `05/14`.
    pub id: String,
    /// The case, in few words.
    pub title: String,
    /// What came of it.
    pub verdict: Verdict,
    /// Checks made.
    pub checks: u64,
    /// Frames run.
    pub frames: u64,
    /// What does not hold.
    pub violations: Vec<Violation>,
    /// Why there is no code.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// Collects the checks of a case.
#[derive(Debug)]
pub struct Trial {
    /// The profile that scenes run under.
    pub profile: Profile,
    checks: u64,
    frames: u64,
    violations: Vec<Violation>,
    retail: Vec<(Invariant, &'static str)>,
    no_code: Option<&'static str>,
}

impl Trial {
    /// A trial under the normative profile.
    pub fn new() -> Self {
        Self {
            profile: Profile::retail(),
            checks: 0,
            frames: 0,
            violations: Vec::new(),
            retail: Vec::new(),
            no_code: None,
        }
    }

    /// Checks what the specification says must happen.
    pub fn promise(&mut self, holds: bool, what: impl FnOnce() -> String) {
        self.checks += 1;
        if !holds {
            let violation = Violation {
                invariant: Invariant::Promise,
                frame: None,
                detail: what(),
                retail: None,
            };
            self.violations.push(violation);
        }
    }

    /// Checks that two things are equal.
    pub fn same<T: PartialEq + Debug>(&mut self, what: &str, found: T, wanted: T) {
        self.promise(found == wanted, || {
            format!("{what}: found {found:?}, wanted {wanted:?}")
        });
    }

    /// From here on a violation of the invariant is retail's; `why` is the section that says so.
    pub fn as_retail(&mut self, invariant: Invariant, why: &'static str) {
        self.retail.push((invariant, why));
    }

    /// The library has nothing that the case is about.
    pub fn no_code(&mut self, why: &'static str) {
        self.no_code = Some(why);
    }

    /// Runs a scene to its end under the eyes of every invariant.
    pub fn scene(&mut self, stage: &Stage) -> Run {
        let mut watch = Watch::new(stage);
        match stage.run(&self.profile, &mut watch) {
            Ok(run) => {
                self.frames += run.frames();
                let (checks, violations) = watch.finish(&run);
                self.checks += checks;
                self.violations.extend(violations);
                run
            }
            Err(error) => {
                self.promise(false, || format!("the scene does not run: {error}"));
                Run::default()
            }
        }
    }

    /// What came of it.
    pub fn result(mut self, case: &Case) -> CaseResult {
        for violation in &mut self.violations {
            let known = self
                .retail
                .iter()
                .find(|(invariant, _)| *invariant == violation.invariant);
            violation.retail = known.map(|(_, why)| (*why).to_owned());
        }
        let verdict = if self.no_code.is_some() {
            Verdict::NoCode
        } else if self.violations.iter().any(|v| v.retail.is_none()) {
            Verdict::Ours
        } else if self.violations.is_empty() {
            Verdict::Holds
        } else {
            Verdict::AsRetail
        };
        CaseResult {
            id: case.id(),
            title: case.title.into(),
            verdict,
            checks: self.checks,
            frames: self.frames,
            violations: self.violations,
            note: self.no_code.map(Into::into),
        }
    }
}

impl Default for Trial {
    fn default() -> Self {
        Self::new()
    }
}
