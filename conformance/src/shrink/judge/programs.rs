//! Two programs that run scenes as `ac-replay run` does.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Duration,
};

use ac_golden_traces::trace::rewrite::Frame;
use globset::GlobMatcher;

use super::{Judge, Shown, Target};
use crate::{
    bisect::{
        locate,
        verdict::{self, Question},
    },
    compare::fields,
    shrink::{Candidate, ShrinkError, candidate::Records, output},
};

/// Two programs: the first is expected, the second is judged.
#[derive(Debug)]
pub struct TwoPrograms {
    /// What is expected.
    pub good: PathBuf,
    /// What is judged.
    pub bad: PathBuf,
    /// Profile of both.
    pub profile: String,
    /// A run that takes longer has failed.
    pub timeout: Duration,
    /// Only differences of fields with this name count.
    pub field: Option<GlobMatcher>,
    /// Folder for the scenes that they run.
    pub scratch: tempfile::TempDir,
    /// The world that is in the folder.
    written: Option<Arc<Records>>,
}

impl TwoPrograms {
    /// Programs that are run in a temporary folder.
    ///
    /// # Errors
    /// When it cannot be made.
    pub fn new(good: &Path, bad: &Path, profile: &str, timeout: Duration) -> std::io::Result<Self> {
        Ok(Self {
            good: good.into(),
            bad: bad.into(),
            profile: profile.into(),
            timeout,
            field: None,
            scratch: tempfile::tempdir()?,
            written: None,
        })
    }

    fn question(&mut self, candidate: &Candidate) -> Result<Question, ShrinkError> {
        let folder = self.scratch.path();
        let worlds = folder.join("worlds");
        let scene = folder.join("candidate.scene.json");
        output::write_scene(&scene, &candidate.scene)?;
        let known = self.written.as_ref();
        if !known.is_some_and(|known| Arc::ptr_eq(known, &candidate.records)) {
            output::write_world(&worlds.join(&candidate.scene.world), &candidate.records)?;
            self.written = Some(Arc::clone(&candidate.records));
        }
        Ok(Question {
            trace: scene,
            worlds,
            profile: self.profile.clone(),
            field: self.field.clone(),
            expected: Default::default(),
            timeout: self.timeout,
        })
    }

    /// Both traces; `None` if one of the programs does not run the candidate.
    fn traces(
        &self,
        question: &Question,
        checkpoints: bool,
    ) -> Result<Option<[PathBuf; 2]>, ShrinkError> {
        let traces = ["good.mcap", "bad.mcap"].map(|name| self.scratch.path().join(name));
        for (program, out) in [&self.good, &self.bad].into_iter().zip(&traces) {
            let ran = question.run(program, &self.profile, checkpoints, out)?;
            if ran.is_err() {
                return Ok(None);
            }
        }
        Ok(Some(traces))
    }
}

impl Judge for TwoPrograms {
    fn judge(
        &mut self,
        candidate: &Candidate,
        target: Option<&Target>,
    ) -> Result<Option<Shown>, ShrinkError> {
        let question = self.question(candidate)?;
        let Some([good, bad]) = self.traces(&question, false)? else {
            return Ok(None);
        };
        let expected = verdict::produced(&good)?;
        let Some(place) = question.first_difference(&expected, &verdict::produced(&bad)?) else {
            return Ok(None);
        };
        let field = fields::without_indices(&place.divergence.field);
        if target.is_some_and(|target| target.field != field) {
            return Ok(None);
        }
        let stage = match self.traces(&question, true)? {
            Some([good, bad]) => locate::locate(&good, &bad)?.stage.map(|stage| stage.stage),
            None => None,
        };
        let shown = Shown { place, stage };
        Ok(target
            .is_none_or(|target| target.is_met(&shown))
            .then_some(shown))
    }

    fn expectation(&mut self, candidate: &Candidate) -> Result<Vec<Frame>, ShrinkError> {
        let question = self.question(candidate)?;
        match self.traces(&question, false)? {
            Some([good, _]) => Ok(verdict::produced(&good)?),
            None => Err(ShrinkError::Nothing(
                "the good program does not run the shrunk scene".into(),
            )),
        }
    }

    fn field(&self) -> Option<&GlobMatcher> {
        self.field.as_ref()
    }
}
