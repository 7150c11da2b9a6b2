//! Builds of commits, made once and kept.

use std::{
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::Instant,
};

use super::{
    BisectError,
    git::{Commit, Git},
};

/// Makes builds in a folder of its own: `tree` is the worktree, `target` what cargo keeps between builds, `builds/COMMIT` the finished
/// programs.
#[derive(Clone, Debug)]
pub struct Builder {
    /// The repository.
    pub git: Git,
    /// The folder.
    pub folder: PathBuf,
    /// Run by `sh -c` in the worktree, with `CARGO_TARGET_DIR` set.
    pub command: String,
    /// The program that it makes, under `CARGO_TARGET_DIR`.
    pub program: PathBuf,
    /// `CARGO_TARGET_DIR`, if it is not `target` in the folder.
    pub target: Option<PathBuf>,
}

/// What came of building a commit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Built {
    /// A program.
    Program(PathBuf),
    /// It could not be built; the file says why.
    Failed(PathBuf),
}

impl Builder {
    /// The program of a commit, built if that was not done before. `said` hears how long it took.
    ///
    /// # Errors
    /// When the commit cannot be checked out or the shell not be started. A build that fails is no error.
    pub fn build(&self, commit: &Commit, said: &dyn Fn(&str)) -> Result<Built, BisectError> {
        let folder = self.folder.join("builds").join(&commit.id);
        let program = folder.join(self.program.file_name().unwrap_or("program".as_ref()));
        if program.is_file() {
            return Ok(Built::Program(program));
        }
        fs::create_dir_all(&folder).map_err(BisectError::io(&folder))?;
        let log = folder.join("build.log");
        let tree = self.folder.join("tree");
        self.git.check_out(&tree, &commit.id)?;
        let start = Instant::now();
        let target = self.target();
        let made = target.join(&self.program);
        // A program that an earlier commit left there is not of this one.
        remove(&made)?;
        let built = self.run(&tree, &target, &log)? && made.is_file();
        said(&format!(
            "{} {} in {:.0} s",
            commit.short(),
            if built { "built" } else { "cannot be built" },
            start.elapsed().as_secs_f64()
        ));
        if !built {
            return Ok(Built::Failed(log));
        }
        // Copied beside and renamed: what is there is whole.
        let draft = folder.join("draft");
        fs::copy(&made, &draft).map_err(BisectError::io(&made))?;
        fs::rename(&draft, &program).map_err(BisectError::io(&program))?;
        Ok(Built::Program(program))
    }

    fn target(&self) -> PathBuf {
        self.target
            .clone()
            .unwrap_or_else(|| self.folder.join("target"))
    }

    fn run(&self, tree: &Path, target: &Path, log: &Path) -> Result<bool, BisectError> {
        let out = File::create(log).map_err(BisectError::io(log))?;
        let errors = out.try_clone().map_err(BisectError::io(log))?;
        let status = Command::new("sh")
            .args(["-c", &self.command])
            .current_dir(tree)
            .env("CARGO_TARGET_DIR", target)
            .stdin(Stdio::null())
            .stdout(out)
            .stderr(errors)
            .status()
            .map_err(|source| BisectError::Start {
                program: "sh".into(),
                source,
            })?;
        Ok(status.success())
    }
}

fn remove(path: &Path) -> Result<(), BisectError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(BisectError::io(path)(error))
        }
        _ => Ok(()),
    }
}
