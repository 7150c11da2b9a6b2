//! The search for the first commit whose verdict is not that of the good one.
//!
//! Git orders the commits that are left so that the first halves them best, in histories with merges too. A commit that cannot be built
//! says nothing; the next best is taken. When only such commits are left beside a bad one, the answer is all of them.

use super::{
    BisectError,
    git::{Commit, Git},
    state::{Known, State},
    verdict::Verdict,
};

/// What a search found.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The first commit with another verdict.
    pub first_bad: Commit,
    /// Commits that cannot be built and may be it instead, nearest first.
    pub or: Vec<Commit>,
    /// Verdict of the good commit.
    pub good: Verdict,
    /// Verdict of `first_bad`.
    pub bad: Verdict,
    /// Commits that were in question at the start.
    pub commits: usize,
    /// Of these, built and asked, the bad one included.
    pub asked: usize,
    /// Of these, not to be built.
    pub unbuildable: usize,
}

/// What the search needs to know of a commit.
pub type Judge<'a> = dyn FnMut(&Commit) -> Result<Known, BisectError> + 'a;

/// Searches. `judge` is asked for commits that `state` does not know; `save` is called with every answer; `said` hears each step.
///
/// # Errors
/// When an end cannot be judged, both have the same verdict, or one is not in the history of the other.
pub fn search(
    git: &Git,
    state: &mut State,
    judge: &mut Judge<'_>,
    save: &dyn Fn(&State) -> Result<(), BisectError>,
    said: &dyn Fn(&str),
) -> Result<Found, BisectError> {
    let ends = [state.asked.good.clone(), state.asked.bad.clone()];
    let [good, bad] = [git.commit(&ends[0])?, git.commit(&ends[1])?];
    if !git.is_ancestor(&good.id, &bad.id)? {
        return Err(BisectError::Question(format!(
            "{} is not in the history of {}: name a good commit that is older than the bad one",
            good.short(),
            bad.short()
        )));
    }
    let mut of = |commit: &Commit, state: &mut State| -> Result<Known, BisectError> {
        if let Some(known) = state.commits.get(&commit.id) {
            return Ok(known.clone());
        }
        let known = judge(commit)?;
        state.commits.insert(commit.id.clone(), known.clone());
        save(state)?;
        Ok(known)
    };
    let good_verdict = end(&good, of(&good, state)?)?;
    said(&format!("good {}: {}", good.short(), good_verdict.line()));
    let mut bad_verdict = end(&bad, of(&bad, state)?)?;
    said(&format!("bad  {}: {}", bad.short(), bad_verdict.line()));
    if bad_verdict.is_like(&good_verdict) {
        return Err(BisectError::Question(format!(
            "both ends have the same verdict: {}",
            good_verdict.line()
        )));
    }
    let fails_matter = matches!(bad_verdict, Verdict::Fails(_));
    let mut goods = vec![good.id.clone()];
    let mut first_bad = bad;
    let commits = git.between(&goods, &first_bad.id)?.len();
    let (mut asked, mut unbuildable) = (1, 0);
    loop {
        let left = git.between(&goods, &first_bad.id)?;
        let said_nothing = |id: &String| match state.commits.get(id) {
            Some(Known::Unbuildable) => true,
            Some(Known::Judged(Verdict::Fails(_))) => !fails_matter,
            _ => false,
        };
        let next = left
            .iter()
            .find(|id| **id != first_bad.id && !said_nothing(id));
        let Some(next) = next else {
            let or = left.iter().filter(|id| **id != first_bad.id);
            let or = or.map(|id| git.commit(id)).collect::<Result<_, _>>()?;
            return Ok(Found {
                first_bad,
                or,
                good: good_verdict,
                bad: bad_verdict,
                commits,
                asked,
                unbuildable,
            });
        };
        let commit = git.commit(next)?;
        match of(&commit, state)? {
            Known::Unbuildable => {
                unbuildable += 1;
                said(&format!("skip {} cannot be built", commit.short()));
            }
            Known::Judged(Verdict::Fails(reason)) if !fails_matter => {
                asked += 1;
                said(&format!("skip {} does not run: {reason}", commit.short()));
            }
            Known::Judged(verdict) => {
                asked += 1;
                let like = verdict.is_like(&good_verdict);
                let name = if like { "good" } else { "bad " };
                said(&format!("{name} {}: {}", commit.short(), verdict.line()));
                if like {
                    goods.push(commit.id);
                } else {
                    first_bad = commit;
                    bad_verdict = verdict;
                }
            }
        }
    }
}

fn end(commit: &Commit, known: Known) -> Result<Verdict, BisectError> {
    match known {
        Known::Judged(verdict) => Ok(verdict),
        Known::Unbuildable => Err(BisectError::Question(format!(
            "{} cannot be built, so nothing can be said of it; name another commit",
            commit.short()
        ))),
    }
}
