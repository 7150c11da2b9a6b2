//! The writer thread.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::medium::{Sink, Storage};
use super::{DiskConfig, DiskReport, Event};
use crate::clock::Clock;
use crate::counters::{Counters, Counts, add};
use crate::error::RecordError;
use crate::format::{Continuation, PartInfo, RecordingWriter};
use crate::scan::{ScanReport, scan};
use crate::secrets::{SecretPolicy, SharedSecrets, locked};

/// The writer looks so often whether something waits: the relay need not wake it.
const POLL: Duration = Duration::from_millis(5);
/// Time between attempts to begin a file after a failure.
const RETRY: Duration = Duration::from_secs(1);
/// Counters are written so often.
const COUNTS: Duration = Duration::from_secs(1);
/// Numbers of files that are tried before it counts as a failure.
const NAMES: u32 = 1000;

/// Name of a part: the first is as given, the others have a number before the extension.
pub fn part_path(first: &Path, number: u32) -> PathBuf {
    if number <= 1 {
        return first.into();
    }
    let stem = first.file_stem().unwrap_or_default().to_string_lossy();
    let mut name = format!("{stem}-{number:04}");
    if let Some(extension) = first.extension() {
        name = format!("{name}.{}", extension.to_string_lossy());
    }
    first.with_file_name(name)
}

/// There is a file of this name.
fn is_taken(error: &RecordError) -> bool {
    matches!(error, RecordError::File { source, .. } if source.kind() == std::io::ErrorKind::AlreadyExists)
}

enum State {
    Writing(Box<Part>),
    /// Nothing is written; when to try again.
    Failed(Box<Continuation>, Instant),
    /// Only while changing from one to the other.
    Between,
}

struct Part {
    writer: RecordingWriter<Sink>,
    path: PathBuf,
    began: Instant,
    /// Bytes on the disk.
    written: Arc<AtomicU64>,
    /// When the first datagram that is not on the disk arrived.
    oldest: Option<Instant>,
}

type Check = (PathBuf, JoinHandle<Result<ScanReport, RecordError>>);

pub(super) struct DiskWriter {
    config: DiskConfig,
    storage: Box<dyn Storage>,
    clock: Clock,
    counters: Arc<Counters>,
    waiting_bytes: Arc<AtomicUsize>,
    secrets: SharedSecrets,
    state: State,
    number: u32,
    checks: Vec<Check>,
    report: DiskReport,
    counted: (Instant, Counts),
}

impl DiskWriter {
    pub(super) fn begin(
        config: DiskConfig,
        storage: Box<dyn Storage>,
        clock: Clock,
        counters: Arc<Counters>,
        waiting_bytes: Arc<AtomicUsize>,
    ) -> Result<Self, RecordError> {
        let secrets = SharedSecrets::default();
        let start = Continuation::new(secrets.clone());
        let mut this = Self {
            config,
            storage,
            clock,
            counters,
            waiting_bytes,
            secrets,
            state: State::Between,
            number: 1,
            checks: Vec::new(),
            report: DiskReport::default(),
            counted: (Instant::now(), Counts::default()),
        };
        let path = this.config.output.clone();
        match this.open(&path, start) {
            Ok(()) => Ok(this),
            Err(failed) => Err(failed.0),
        }
    }

    /// Begins a file.
    fn open(
        &mut self,
        path: &Path,
        state: Continuation,
    ) -> Result<(), Box<(RecordError, Continuation)>> {
        let medium = match self.storage.create(path) {
            Ok(medium) => medium,
            Err(source) => {
                let path = path.into();
                return Err(Box::new((RecordError::File { path, source }, state)));
            }
        };
        let part = PartInfo {
            number: self.number,
        };
        let sink = Sink::new(medium);
        let written = sink.written();
        let writer = RecordingWriter::part(sink, self.config.options, part, state)
            .inspect_err(|_| self.storage.remove(path))?;
        self.report.files.push(path.into());
        add(&self.counters.files, 1);
        self.state = State::Writing(Box::new(Part {
            writer,
            path: path.into(),
            began: Instant::now(),
            written,
            oldest: None,
        }));
        Ok(())
    }

    /// Begins the next file under the next free name, or waits for better times.
    fn open_next(&mut self, mut state: Continuation) {
        for _ in 0..NAMES {
            self.number += 1;
            let path = part_path(&self.config.output, self.number);
            match self.open(&path, state) {
                Ok(()) => {
                    tracing::info!(file = %path.display(), "recording goes on");
                    return;
                }
                Err(failed) => {
                    let (error, back) = *failed;
                    if !is_taken(&error) {
                        self.number -= 1;
                        self.fail(&error, back);
                        return;
                    }
                    state = back;
                }
            }
        }
        let path = self.config.output.clone();
        let source = std::io::ErrorKind::AlreadyExists.into();
        self.fail(&RecordError::File { path, source }, state);
    }

    fn fail(&mut self, error: &RecordError, state: Continuation) {
        tracing::error!(%error, "NOT RECORDING: the file cannot be written. Datagrams are still passed on");
        self.state = State::Failed(Box::new(state), Instant::now() + RETRY);
    }

    pub(super) fn run(mut self, events: &Receiver<Event>) -> DiskReport {
        loop {
            match events.try_recv() {
                Ok(event) => self.take(event),
                Err(TryRecvError::Empty) => {
                    self.tick();
                    std::thread::sleep(POLL);
                }
                Err(TryRecvError::Disconnected) => break,
            }
        }
        self.end()
    }

    fn take(&mut self, event: Event) {
        match event {
            Event::Datagram {
                stream,
                number,
                received,
                forwarded,
                bytes,
            } => {
                self.waiting_bytes.fetch_sub(bytes.len(), Ordering::Relaxed);
                let State::Writing(part) = &mut self.state else {
                    add(&self.counters.unwritten_failed, 1);
                    self.tick();
                    return;
                };
                part.writer.continuation().set_number(number);
                part.oldest.get_or_insert_with(Instant::now);
                add(&self.counters.recorded, 1);
                let (waiting, before) = (part.writer.waiting(), part.writer.totals().1);
                let result = part
                    .writer
                    .write_forwarded(stream, received, forwarded, &bytes);
                let hidden = part.writer.totals().1 - before;
                add(&self.counters.secret_bytes, hidden as u64);
                let due = part.writer.waiting() == 0 || part.is_due(self.config.flush);
                match result {
                    Ok(()) if due => self.tick(),
                    Ok(()) => {}
                    Err(error) => self.give_up(&error, waiting + 1),
                }
            }
            Event::Forget(client) => match &mut self.state {
                State::Writing(part) => part.writer.continuation().forget(client),
                State::Failed(state, _) => state.forget(client),
                State::Between => {}
            },
        }
    }

    /// What is due by time or size.
    fn tick(&mut self) {
        if let State::Failed(_, when) = self.state
            && Instant::now() >= when
        {
            if let State::Failed(state, _) = std::mem::replace(&mut self.state, State::Between) {
                self.open_next(*state);
            }
            return;
        }
        let State::Writing(part) = &mut self.state else {
            return;
        };
        let mut result = Ok(());
        if self.counted.0.elapsed() >= COUNTS {
            let counts = self.counters.counts();
            if counts != self.counted.1 {
                result = part.writer.write_counts(self.clock.stamp(), &counts);
                part.oldest.get_or_insert_with(Instant::now);
            }
            self.counted = (Instant::now(), counts);
        }
        if part.writer.waiting() == 0 {
            // The chunk was closed because it was large enough, or holds counters only.
            part.oldest = part.oldest.filter(|o| o.elapsed() < self.config.flush);
        }
        if result.is_ok() && part.is_due(self.config.flush) {
            result = part.writer.flush();
            part.oldest = None;
        }
        let rotation = self.config.rotation;
        let rotate = rotation.every.is_some_and(|t| part.began.elapsed() >= t)
            || rotation
                .size
                .is_some_and(|n| part.written.load(Ordering::Relaxed) >= n);
        match result {
            Ok(()) if rotate => self.rotate(),
            Ok(()) => {}
            Err(error) => {
                let lost = part.writer.waiting();
                self.give_up(&error, lost);
            }
        }
    }

    /// After a failure: the datagrams that are not on the disk are counted.
    fn give_up(&mut self, error: &RecordError, lost: u32) {
        let State::Writing(part) = std::mem::replace(&mut self.state, State::Between) else {
            return;
        };
        let lost = u64::from(lost);
        add(&self.counters.unwritten_failed, lost);
        self.counters.recorded.fetch_sub(lost, Ordering::Relaxed);
        let (_, state) = part.writer.abandon();
        self.fail(error, state);
    }

    /// Ends the file; what goes on comes back.
    fn close(&mut self) -> Option<Continuation> {
        let State::Writing(part) = &mut self.state else {
            return None;
        };
        if let Err(error) = part.writer.flush() {
            let lost = part.writer.waiting();
            self.give_up(&error, lost);
            return None;
        }
        let State::Writing(part) = std::mem::replace(&mut self.state, State::Between) else {
            return None;
        };
        let counts = self.counters.counts();
        let (mut sink, state, result) = part.writer.finish_part(Some(&counts));
        let result = result.map_err(|e| e.to_string());
        if let Err(error) = result.and_then(|()| sink.sync().map_err(|e| e.to_string())) {
            tracing::error!(%error, file = %part.path.display(), "the file could not be ended; `ac-record recover` reads what is there");
        }
        self.check(part.path);
        Some(state)
    }

    fn rotate(&mut self) {
        if let Some(state) = self.close() {
            self.open_next(state);
        }
    }

    /// Searches a file for secrets, on another thread.
    fn check(&mut self, path: PathBuf) {
        if self.config.options.secrets == SecretPolicy::Keep {
            return;
        }
        self.take_checks(false);
        let searcher = locked(&self.secrets).searcher();
        let own = path.clone();
        self.checks
            .push((path, std::thread::spawn(move || scan(&own, &searcher))));
    }

    /// Takes the results of checks that are done, or of all of them.
    fn take_checks(&mut self, all: bool) {
        let done = |check: &mut Check| all || check.1.is_finished();
        for (path, check) in self.checks.extract_if(.., done) {
            let result = check.join();
            match result {
                Ok(Ok(found)) if found.is_clean() => {}
                Ok(Ok(found)) => {
                    tracing::error!(file = %path.display(), "SECRET FOUND: do not share this file");
                    let places = found.in_file + found.in_records;
                    self.report.leaks.push((path, places));
                }
                Ok(Err(error)) => self.report.unchecked.push((path, error.to_string())),
                Err(_) => {
                    let why = "the check ended early".to_owned();
                    self.report.unchecked.push((path, why));
                }
            }
        }
    }

    fn end(mut self) -> DiskReport {
        self.close();
        self.take_checks(true);
        let secrets = locked(&self.secrets);
        DiskReport {
            secrets: secrets.len(),
            too_many_secrets: secrets.overflowed(),
            ..self.report
        }
    }
}

impl Part {
    fn is_due(&self, flush: Duration) -> bool {
        self.oldest.is_some_and(|oldest| oldest.elapsed() >= flush)
    }
}
