//! The search on histories made of nothing but a file with a word, judged by that word.

use std::{
    cell::RefCell,
    collections::BTreeMap,
    path::{Path, PathBuf},
    process::Command,
};

use super::{
    BisectError,
    git::{Commit, Git},
    search::{Found, search},
    state::{Asked, Known, State},
    verdict::{Place, Verdict},
};
use crate::compare::Divergence;

/// A repository whose commits are made one after the other.
struct Repository {
    folder: tempfile::TempDir,
}

impl Repository {
    fn new() -> Self {
        let repository = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        repository.git(&["init", "-q", "-b", "main"]);
        repository
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn git(&self, arguments: &[&str]) -> String {
        let output = Command::new("git")
            .arg("-C")
            .arg(self.path())
            .args(["-c", "user.name=Test", "-c", "user.email=test@example.com"])
            .args(["-c", "commit.gpgsign=false"])
            .args(arguments)
            .env_remove("GIT_DIR")
            .env_remove("GIT_WORK_TREE")
            .env_remove("GIT_INDEX_FILE")
            .output()
            .unwrap();
        assert!(output.status.success(), "{arguments:?}: {output:?}");
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    /// A commit in which the file has this word; its id.
    fn commit(&self, word: &str, subject: &str) -> String {
        std::fs::write(self.path().join("word"), word).unwrap();
        self.git(&["add", "-A"]);
        self.git(&["commit", "-q", "--allow-empty", "-m", subject]);
        self.git(&["rev-parse", "HEAD"])
    }

    fn word(&self, commit: &Commit) -> String {
        self.git(&["show", &format!("{}:word", commit.id)])
    }
}

fn verdict(word: &str) -> Known {
    let place = |frame: i32| Place {
        guid: "0x1".into(),
        divergence: Divergence {
            frame,
            stage: None,
            field: "origin[0]".into(),
            expected: 1.0.into(),
            actual: 2.0.into(),
        },
    };
    match word {
        "broken" => Known::Unbuildable,
        "hangs" => Known::Judged(Verdict::Fails("not done after 1 s".into())),
        "fine" => Known::Judged(Verdict::Runs([("self".into(), None)].into())),
        frame => Known::Judged(Verdict::Runs(
            [("self".into(), Some(place(frame.parse().unwrap())))].into(),
        )),
    }
}

fn asked(good: &str, bad: &str) -> Asked {
    Asked {
        trace: "t".into(),
        trace_blake3: "0".into(),
        good: good.into(),
        bad: bad.into(),
        field: None,
        oracle: None,
        profile: "retail".into(),
        build: "b".into(),
    }
}

/// Searches and answers what was found, the words that were asked for, and what is known afterwards.
fn find(
    repository: &Repository,
    mut state: State,
) -> (Result<Found, BisectError>, Vec<String>, State) {
    let git = Git::of(repository.path()).unwrap();
    let words = RefCell::new(Vec::new());
    let saved = RefCell::new(0);
    let found = search(
        &git,
        &mut state,
        &mut |commit| {
            let word = repository.word(commit);
            words.borrow_mut().push(word.clone());
            Ok(verdict(&word))
        },
        &|_| {
            *saved.borrow_mut() += 1;
            Ok(())
        },
        &|_| (),
    );
    let words = words.into_inner();
    assert_eq!(saved.into_inner(), words.len(), "every answer is saved");
    (found, words, state)
}

/// Commits with these words, and their ids.
fn line(words: &[&str]) -> (Repository, Vec<String>) {
    let repository = Repository::new();
    let ids = (0..)
        .zip(words)
        .map(|(number, word)| repository.commit(word, &format!("commit {number}")))
        .collect();
    (repository, ids)
}

#[test]
fn the_first_commit_with_another_verdict_is_found_in_few_steps() {
    let words: Vec<&str> = (0..64).map(|n| if n < 41 { "fine" } else { "7" }).collect();
    let (repository, ids) = line(&words);
    let (found, asked_for, _) = find(&repository, State::new(asked(&ids[0], &ids[63])));
    let found = found.unwrap();
    assert_eq!(found.first_bad.id, ids[41]);
    assert_eq!(found.first_bad.subject, "commit 41");
    assert_eq!(found.commits, 63);
    assert!(asked_for.len() <= 9, "{}", asked_for.len());
}

#[test]
fn what_cannot_be_built_is_gone_around() {
    let (repository, ids) = line(&["fine", "fine", "broken", "broken", "7", "7", "8"]);
    let (found, ..) = find(&repository, State::new(asked(&ids[0], &ids[6])));
    let found = found.unwrap();
    // Both broken ones lie between the last good commit and the first bad one.
    assert_eq!(found.first_bad.id, ids[4]);
    let or: Vec<_> = found.or.iter().map(|commit| &commit.id).collect();
    assert_eq!(or.len(), 2);
    assert!(or.contains(&&ids[2]) && or.contains(&&ids[3]));
    // Broken ones elsewhere do not matter.
    let (repository, ids) = line(&["fine", "broken", "fine", "7", "broken", "7"]);
    let (found, ..) = find(&repository, State::new(asked(&ids[0], &ids[5])));
    let found = found.unwrap();
    assert_eq!((&found.first_bad.id, found.or.len()), (&ids[3], 0));
}

#[test]
fn a_run_that_fails_counts_only_if_that_is_what_is_looked_for() {
    let (repository, ids) = line(&["fine", "hangs", "fine", "hangs", "7"]);
    let (found, ..) = find(&repository, State::new(asked(&ids[0], &ids[4])));
    let found = found.unwrap();
    assert_eq!(found.first_bad.id, ids[4]);
    assert_eq!(found.or.len(), 1);
    let (repository, ids) = line(&["fine", "fine", "hangs", "hangs"]);
    let (found, ..) = find(&repository, State::new(asked(&ids[0], &ids[3])));
    assert_eq!(found.unwrap().first_bad.id, ids[2]);
}

#[test]
fn a_merged_branch_is_searched_too() {
    let repository = Repository::new();
    let good = repository.commit("fine", "start");
    repository.git(&["checkout", "-q", "-b", "side"]);
    repository.commit("fine", "side, still good");
    let culprit = repository.commit("7", "side, the culprit");
    repository.commit("7", "side, after it");
    repository.git(&["checkout", "-q", "main"]);
    repository.git(&["commit", "-q", "--allow-empty", "-m", "main goes on"]);
    repository.git(&["merge", "-q", "--no-ff", "-m", "merge", "side"]);
    let bad = repository.git(&["rev-parse", "HEAD"]);
    let (found, ..) = find(&repository, State::new(asked(&good, &bad)));
    assert_eq!(found.unwrap().first_bad.id, culprit);
}

#[test]
fn an_interrupted_search_asks_nothing_twice() {
    let words: Vec<&str> = (0..32).map(|n| if n < 9 { "fine" } else { "7" }).collect();
    let (repository, ids) = line(&words);
    let question = asked(&ids[0], &ids[31]);
    let (found, all, state) = find(&repository, State::new(question.clone()));
    let first_bad = found.unwrap().first_bad;
    assert_eq!(first_bad.id, ids[9]);
    // The file remembers everything ...
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sub/state.json");
    state.save(&file).unwrap();
    let known = State::open(&file, question.clone()).unwrap();
    assert_eq!(known, state);
    let (found, again, _) = find(&repository, known.clone());
    assert_eq!(
        (found.unwrap().first_bad.id, again.len()),
        (ids[9].clone(), 0)
    );
    // ... or, when it was interrupted, a part.
    let mut part = known;
    let ends = [ids[0].clone(), ids[31].clone()];
    let mut kept = 0;
    part.commits.retain(|id, _| {
        kept += 1;
        ends.contains(id) || kept % 2 == 0
    });
    let before = part.commits.len();
    let (found, rest, _) = find(&repository, part);
    assert_eq!(found.unwrap().first_bad.id, ids[9]);
    assert_eq!(rest.len(), all.len() - before);
    // Another question: nothing is known.
    let other = Asked {
        field: Some("cell".into()),
        ..question
    };
    assert_eq!(
        State::open(&file, other.clone()).unwrap(),
        State::new(other)
    );
}

#[test]
fn what_cannot_be_looked_for_says_why() {
    let (repository, ids) = line(&["fine", "fine", "broken"]);
    let short = |id: &String| id[..10].to_owned();
    let error = |good: &String, bad: &String| {
        let (found, ..) = find(&repository, State::new(asked(good, bad)));
        found.unwrap_err().to_string()
    };
    assert_eq!(
        error(&ids[0], &ids[1]),
        "both ends have the same verdict: self: exact"
    );
    assert_eq!(
        error(&ids[1], &ids[0]),
        format!(
            "{} is not in the history of {}: name a good commit that is older than the bad one",
            short(&ids[1]),
            short(&ids[0])
        )
    );
    assert!(error(&ids[0], &ids[2]).contains("cannot be built, so nothing can be said of it"));
    let git = Git::of(repository.path()).unwrap();
    let nowhere = git.commit("no-such-branch").unwrap_err().to_string();
    assert!(
        nowhere.starts_with("`no-such-branch` is no commit of "),
        "{nowhere}"
    );
}

#[test]
fn verdicts_are_alike_by_frame_entity_and_field_only() {
    let at = |frame: i32, field: &str, actual: f64| {
        let place = Place {
            guid: "0x1".into(),
            divergence: Divergence {
                frame,
                stage: None,
                field: field.into(),
                expected: 1.0.into(),
                actual: actual.into(),
            },
        };
        Verdict::Runs(BTreeMap::from([("gdle".into(), Some(place))]))
    };
    assert!(at(3, "cell", 2.0).is_like(&at(3, "cell", 5.0)));
    assert!(!at(3, "cell", 2.0).is_like(&at(4, "cell", 2.0)));
    assert!(!at(3, "cell", 2.0).is_like(&at(3, "origin[0]", 2.0)));
    let fails = Verdict::Fails("one".into());
    assert!(fails.is_like(&Verdict::Fails("two".into())));
    assert!(!fails.is_like(&at(3, "cell", 2.0)));
    assert_eq!(at(3, "cell", 2.0).line(), "gdle: frame 3 0x1 cell");
}

#[test]
fn a_worktree_has_the_files_of_the_commit_and_nothing_else() {
    let (repository, ids) = line(&["one", "two"]);
    let git = Git::of(repository.path()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let tree: PathBuf = folder.path().join("tree");
    let word = || std::fs::read_to_string(tree.join("word")).unwrap();
    git.check_out(&tree, &ids[0]).unwrap();
    assert_eq!(word(), "one");
    std::fs::write(tree.join("left-over"), "x").unwrap();
    std::fs::write(tree.join("word"), "edited").unwrap();
    git.check_out(&tree, &ids[1]).unwrap();
    assert_eq!(word(), "two");
    assert!(!tree.join("left-over").exists());
    assert_eq!(repository.git(&["status", "--porcelain"]), "");
}
