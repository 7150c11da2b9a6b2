//! What is asked of git, through its command line.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use super::BisectError;

/// A repository.
#[derive(Clone, Debug)]
pub struct Git {
    folder: PathBuf,
}

/// One commit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Commit {
    /// Its full id.
    pub id: String,
    /// First line of its message.
    pub subject: String,
}

impl Commit {
    /// The id as people write it.
    pub fn short(&self) -> &str {
        self.id.get(..10).unwrap_or(&self.id)
    }
}

impl Git {
    /// The repository that a folder is in.
    ///
    /// # Errors
    /// When it is in none.
    pub fn of(folder: &Path) -> Result<Self, BisectError> {
        let here = Self {
            folder: folder.into(),
        };
        let top = here.run(&["rev-parse", "--show-toplevel"])?;
        Ok(Self {
            folder: top.trim().into(),
        })
    }

    /// Its top folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    fn run(&self, arguments: &[&str]) -> Result<String, BisectError> {
        let output = Command::new("git")
            .arg("-C")
            .arg(&self.folder)
            .args(arguments)
            // Inside a hook these would point somewhere else.
            .env_remove("GIT_DIR")
            .env_remove("GIT_WORK_TREE")
            .env_remove("GIT_INDEX_FILE")
            .output()
            .map_err(|source| BisectError::Start {
                program: "git".into(),
                source,
            })?;
        if !output.status.success() {
            return Err(BisectError::Git {
                command: arguments.join(" "),
                said: String::from_utf8_lossy(&output.stderr).trim().to_owned(),
            });
        }
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    }

    /// The commit that a name means.
    ///
    /// # Errors
    /// When there is none of this name.
    pub fn commit(&self, name: &str) -> Result<Commit, BisectError> {
        let name = format!("{name}^{{commit}}");
        let id = self.run(&[
            "rev-parse",
            "--verify",
            "--quiet",
            "--end-of-options",
            &name,
        ]);
        let id = id.map_err(|_| {
            BisectError::Question(format!(
                "`{}` is no commit of {}",
                name.trim_end_matches("^{commit}"),
                self.folder.display()
            ))
        })?;
        let id = id.trim().to_owned();
        let subject = self.run(&["log", "-1", "--format=%s", &id])?;
        Ok(Commit {
            id,
            subject: subject.trim().into(),
        })
    }

    /// Whether one commit is in the history of the other.
    ///
    /// # Errors
    /// When git cannot be run.
    pub fn is_ancestor(&self, older: &str, newer: &str) -> Result<bool, BisectError> {
        match self.run(&["merge-base", "--is-ancestor", older, newer]) {
            Ok(_) => Ok(true),
            Err(BisectError::Git { said, .. }) if said.is_empty() => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// The commits that are in the history of `bad` and of none of `good`, `bad` among them, those first that halve them best.
    ///
    /// # Errors
    /// When git refuses.
    pub fn between(&self, good: &[String], bad: &str) -> Result<Vec<String>, BisectError> {
        let mut arguments = vec!["rev-list", "--bisect-all", bad, "--not"];
        arguments.extend(good.iter().map(String::as_str));
        let text = self.run(&arguments)?;
        let ids = text.lines().filter_map(|line| line.split(' ').next());
        Ok(ids.map(str::to_owned).collect())
    }

    /// The first parent of a commit.
    ///
    /// # Errors
    /// When it has none.
    pub fn parent(&self, id: &str) -> Result<Commit, BisectError> {
        self.commit(&format!("{id}^"))
    }

    /// Puts a commit into the worktree `tree`, which is made if it is not there.
    ///
    /// # Errors
    /// When git refuses.
    pub fn check_out(&self, tree: &Path, id: &str) -> Result<(), BisectError> {
        if !tree.join(".git").exists() {
            if let Some(parent) = tree.parent() {
                std::fs::create_dir_all(parent).map_err(BisectError::io(parent))?;
            }
            let tree = tree.display().to_string();
            self.run(&["worktree", "prune"])?;
            self.run(&["worktree", "add", "--detach", "--force", &tree, id])?;
            return Ok(());
        }
        let inside = Self {
            folder: tree.into(),
        };
        inside.run(&["checkout", "--quiet", "--detach", "--force", id])?;
        inside.run(&["clean", "-q", "-f", "-d"])?;
        Ok(())
    }
}
