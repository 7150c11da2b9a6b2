//! What a run costs: time, and instructions where valgrind is present.

use std::{
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::Instant,
};

use ac_client::frame::NoProbe;
use ac_golden_traces::Scene;
use ac_replayer::{SimulationError, client::SceneRun};

use super::{
    grid::Setting,
    track::{Ground, start},
};

/// Runs all frames. Never inlined: valgrind counts what happens in here and nothing else.
#[inline(never)]
pub fn counted_frames(run: &mut SceneRun, frames: u32) {
    for frame in 0..frames {
        run.run_frame(frame, &mut NoProbe);
    }
}

/// Nanoseconds for all frames of a scene; setting it up does not count.
///
/// # Errors
/// When the scene cannot be set up.
pub fn time(scene: &Scene, ground: Ground<'_>, setting: &Setting) -> Result<f64, SimulationError> {
    let mut run = start(scene, ground, setting)?;
    let begin = Instant::now();
    counted_frames(&mut run, scene.frame_count());
    Ok(begin.elapsed().as_nanos() as f64)
}

/// The median; `None` of nothing.
pub fn median(mut numbers: Vec<f64>) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    let middle = numbers.len() / 2;
    match numbers.len() {
        0 => None,
        n if n % 2 == 1 => Some(numbers[middle]),
        _ => Some(f64::midpoint(numbers[middle - 1], numbers[middle])),
    }
}

/// Where valgrind is, if it is installed.
pub fn valgrind() -> Option<PathBuf> {
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders)
        .map(|folder| folder.join("valgrind"))
        .find(|path| path.is_file())
}

/// Instructions of each call of [`counted_frames`] in a run of this program with `arguments`, in order. `None` when valgrind fails.
pub fn instructions(valgrind: &Path, arguments: &[String]) -> Option<Vec<u64>> {
    let folder = std::env::temp_dir().join(format!("ac-conform-count-{}", std::process::id()));
    std::fs::create_dir_all(&folder).ok()?;
    let counted = run_counted(valgrind, arguments, &folder);
    let _ = std::fs::remove_dir_all(&folder);
    counted
}

fn run_counted(valgrind: &Path, arguments: &[String], folder: &Path) -> Option<Vec<u64>> {
    let status = Command::new(valgrind)
        .args(["--tool=callgrind", "--collect-atstart=no"])
        .arg("--toggle-collect=*counted_frames*")
        .arg("--dump-after=*counted_frames*")
        .arg(format!(
            "--callgrind-out-file={}",
            folder.join("out").display()
        ))
        .arg(std::env::current_exe().ok()?)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .ok()?;
    if !status.success() {
        return None;
    }
    // One file per dump, numbered from 1; what came after the last dump is in `out` itself.
    let mut counts = Vec::new();
    for number in 1.. {
        let Ok(text) = std::fs::read_to_string(folder.join(format!("out.{number}"))) else {
            break;
        };
        let line = text.lines().find_map(|line| {
            line.strip_prefix("summary:")
                .or(line.strip_prefix("totals:"))
        })?;
        counts.push(line.split_whitespace().next()?.parse().ok()?);
    }
    Some(counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians() {
        assert_eq!(median(vec![]), None);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![4.0, 1.0]), Some(2.5));
    }
}
