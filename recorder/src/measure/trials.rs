//! Kills a running proxy at random moments, as a power cut or `kill -9` would, and counts what recovery does not bring back.
//!
//! A datagram counts as lost when its echo had come back more than the flush bound before the kill, and it is in no recovered file.

use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::{Duration, Instant};

use serde::Serialize;

use super::echo::{EchoServer, Packets, log_in, pair, sequence};
use super::{Scratch, write_lines};
use crate::cli::FOUND;
use crate::error::RecordError;
use crate::format::read;
use crate::sockets;

/// Arguments of `ac-record kill-trials`.
#[derive(clap::Args)]
pub struct TrialArgs {
    /// Number of kills.
    #[arg(long, default_value_t = 200)]
    trials: u32,
    /// Trials at once.
    #[arg(long, default_value_t = 4)]
    jobs: u32,
    /// Latest kill, seconds after the start.
    #[arg(long, default_value_t = 2.5)]
    latest: f64,
    /// Longest time that a datagram may be only in memory, seconds.
    #[arg(long, default_value_t = 1.0)]
    bound: f64,
    /// Start of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Where the numbers go, as lines of JSON.
    #[arg(long, default_value = "target/recorder-kill.jsonl")]
    lines: PathBuf,
}

#[derive(Debug, Default, Clone, Serialize)]
struct Totals {
    trials: u32,
    /// Trials after which every file was recovered.
    recovered: u32,
    /// Datagrams passed on before the kills.
    passed: u64,
    /// Datagrams in the recovered files.
    in_files: u64,
    /// Datagrams that are missing although they were older than the bound.
    lost_beyond_bound: u64,
    bound_s: f64,
    /// Files that were left, rotated ones included.
    files: u64,
    problems: Vec<String>,
}

/// Runs the trials.
///
/// # Errors
/// The echo server, the program itself or a file cannot be started or opened.
pub fn run(args: &TrialArgs) -> Result<(String, u8), RecordError> {
    let scratch = Scratch::new("kill")?;
    let server = EchoServer::start()?;
    let program = std::env::current_exe().map_err(|source| RecordError::File {
        path: "ac-record".into(),
        source,
    })?;
    let (next, totals) = (AtomicU32::new(0), Mutex::new(Totals::default()));
    std::thread::scope(|scope| {
        for _ in 0..args.jobs.max(1) {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= args.trials {
                        return;
                    }
                    let trial = Trial {
                        program: &program,
                        folder: scratch.0.join(number.to_string()),
                        server: server.address,
                        rotate: number % 2 == 1,
                        kill_after: Duration::from_secs_f64(
                            args.latest * random(args.seed, u64::from(number)),
                        ),
                        bound: Duration::from_secs_f64(args.bound),
                    };
                    let one = trial.run();
                    if let Ok(mut all) = totals.lock() {
                        all.add(one);
                    }
                }
            });
        }
    });
    let mut totals = totals.into_inner().unwrap_or_default();
    totals.bound_s = args.bound;
    write_lines(&args.lines, std::slice::from_ref(&totals))?;
    let mut text = format!(
        "{} kills: {} recovered; {} datagrams passed on, {} in {} files, {} lost beyond {} s\n",
        totals.trials,
        totals.recovered,
        totals.passed,
        totals.in_files,
        totals.files,
        totals.lost_beyond_bound,
        totals.bound_s
    );
    for problem in &totals.problems {
        text += problem;
        text.push('\n');
    }
    let good = totals.recovered == totals.trials && totals.lost_beyond_bound == 0;
    Ok((text, if good { 0 } else { FOUND }))
}

/// A number from 0 to 1 (splitmix64).
fn random(seed: u64, index: u64) -> f64 {
    let mut z = seed
        .wrapping_mul(0xD134_2543_DE82_EF95)
        .wrapping_add(index.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

impl Totals {
    fn add(&mut self, one: Self) {
        self.trials += 1;
        self.recovered += u32::from(one.problems.is_empty());
        self.passed += one.passed;
        self.in_files += one.in_files;
        self.lost_beyond_bound += one.lost_beyond_bound;
        self.files += one.files;
        self.problems.extend(one.problems);
    }
}

struct Trial<'a> {
    program: &'a Path,
    folder: PathBuf,
    server: SocketAddr,
    rotate: bool,
    kill_after: Duration,
    bound: Duration,
}

/// What the client saw: sequences that came back, and when.
type Seen = Vec<(u32, Instant)>;

impl Trial<'_> {
    fn run(&self) -> Totals {
        match self.attempt() {
            Ok(totals) => totals,
            Err(error) => Totals {
                problems: vec![format!("trial could not run: {error}")],
                ..Totals::default()
            },
        }
    }

    fn attempt(&self) -> Result<Totals, RecordError> {
        let failed = |path: &Path| {
            let path = path.to_path_buf();
            move |source| RecordError::File { path, source }
        };
        std::fs::create_dir_all(&self.folder).map_err(failed(&self.folder))?;
        let listen = {
            let (first, _second) = pair()?;
            first.local_addr().map_err(failed(&self.folder))?
        };
        let mut proxy = self.start(listen).map_err(failed(self.program))?;
        let stop = AtomicBool::new(false);
        let (seen, killed) = std::thread::scope(|scope| {
            let client = scope.spawn(|| play(listen, &stop));
            std::thread::sleep(self.kill_after);
            let killed = Instant::now();
            // SIGKILL where there are signals.
            let _ = proxy.kill();
            let _ = proxy.wait();
            stop.store(true, Ordering::Relaxed);
            (client.join().unwrap_or_default(), killed)
        });
        Ok(self.judge(&seen, killed))
    }

    fn start(&self, listen: SocketAddr) -> std::io::Result<Child> {
        let mut command = Command::new(self.program);
        command
            .arg("proxy")
            .args(["--listen", &listen.to_string()])
            .args(["--server", &self.server.to_string()])
            .arg("-o")
            .arg(self.folder.join("session.mcap"))
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        if self.rotate {
            command.args(["--rotate-every", "300ms"]);
        }
        command.spawn()
    }

    /// Recovers every file that was left, and compares.
    fn judge(&self, seen: &Seen, killed: Instant) -> Totals {
        let mut totals = Totals {
            passed: seen.len() as u64,
            ..Totals::default()
        };
        let (mut to_server, mut to_client) = (BTreeSet::new(), BTreeSet::new());
        for path in files(&self.folder) {
            totals.files += 1;
            match self.recovered(&path) {
                Ok(packets) => {
                    totals.in_files += packets.len() as u64;
                    for (to_the_server, sequence) in packets {
                        let set = if to_the_server {
                            &mut to_server
                        } else {
                            &mut to_client
                        };
                        set.insert(sequence);
                    }
                }
                Err(problem) => totals.problems.push(problem),
            }
        }
        for (sequence, when) in seen {
            let due = killed.saturating_duration_since(*when) > self.bound;
            if due && !(to_server.contains(sequence) && to_client.contains(sequence)) {
                totals.lost_beyond_bound += 1;
            }
        }
        totals
    }

    /// Direction and sequence of the datagrams that recovery brings back.
    fn recovered(&self, path: &Path) -> Result<Vec<(bool, u32)>, String> {
        let output = path.with_extension("recovered");
        let run = Command::new(self.program)
            .arg("recover")
            .arg(path)
            .arg("-o")
            .arg(&output)
            .output()
            .map_err(|e| e.to_string())?;
        if !matches!(run.status.code(), Some(0 | 1)) {
            return Err(format!(
                "{}: {}",
                path.display(),
                String::from_utf8_lossy(&run.stderr)
            ));
        }
        let recording = read(&output).map_err(|e| e.to_string())?;
        if let Some(damage) = recording.damage {
            return Err(format!("{}: recovered, but {damage}", path.display()));
        }
        Ok(recording
            .packets
            .iter()
            .filter_map(|p| Some((p.stream.to_server, sequence(&p.bytes)?)))
            .collect())
    }
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<_> = entries
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "mcap"))
        .collect();
    files.sort();
    files
}

/// Logs in and sends a packet about every millisecond.
fn play(to: SocketAddr, stop: &AtomicBool) -> Seen {
    let mut seen = Seen::new();
    let Ok(socket) = sockets::bind_blocking(([127, 0, 0, 1], 0).into()) else {
        return seen;
    };
    while !log_in(&socket, to, Instant::now() + Duration::from_millis(100)) {
        if stop.load(Ordering::Relaxed) {
            return seen;
        }
    }
    let _ = socket.set_read_timeout(Some(Duration::from_millis(1)));
    let (mut packets, mut buffer) = (Packets::default(), [0; 2048]);
    for number in 2.. {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        let _ = socket.send_to(packets.packet(number), to);
        if let Ok((n, _)) = socket.recv_from(&mut buffer)
            && let Some(sequence) = sequence(&buffer[..n])
        {
            seen.push((sequence, Instant::now()));
            std::thread::sleep(Duration::from_micros(700));
        }
    }
    seen
}
