//! The disk side of a proxy: a thread that writes, behind a bounded queue, so that no disk ever holds up the relay.
//!
//! - The relay hands datagrams over without waiting. When too many wait, they are counted instead ([`Counts::unwritten_slow`]).
//! - When writing fails (disk full, disk gone), the file is cut back to its last whole chunk, the datagrams after it are counted
//!   ([`Counts::unwritten_failed`]), and a new file is begun as soon as that works again.
//! - A chunk is closed when it is large enough, and at the latest [`DiskConfig::flush`] after its first datagram.
//! - Files are ended and new ones begun by size or time. What is known of secrets and of incomplete messages goes on.
//! - Every file that is ended is searched for the secrets that were seen ([`crate::scan`]).
//!
//! [`Counts::unwritten_slow`]: crate::counters::Counts::unwritten_slow
//! [`Counts::unwritten_failed`]: crate::counters::Counts::unwritten_failed

mod medium;
mod writer;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::clock::Clock;
use crate::counters::{Counters, add};
use crate::error::RecordError;
use crate::format::{Stream, WriterOptions};

pub use medium::{Files, Medium, Storage};
pub use writer::part_path;

/// When a file is ended and the next one begun.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Rotation {
    /// At the first end of a chunk after so many bytes.
    pub size: Option<u64>,
    /// After so much time.
    pub every: Option<Duration>,
}

/// How the disk side is set up.
#[derive(Debug, Clone)]
pub struct DiskConfig {
    /// The first file; the others get a number before the extension.
    pub output: PathBuf,
    /// How files are written.
    pub options: WriterOptions,
    /// When a new file is begun.
    pub rotation: Rotation,
    /// Longest time that a datagram stays in memory only.
    pub flush: Duration,
    /// Datagrams that may wait for the writer.
    pub queue: usize,
    /// Bytes of datagrams that may wait for the writer.
    pub queue_bytes: usize,
}

impl DiskConfig {
    /// The usual set-up for a file.
    pub fn new(output: PathBuf) -> Self {
        Self {
            output,
            options: WriterOptions::default(),
            rotation: Rotation::default(),
            flush: Duration::from_millis(500),
            queue: 1 << 16,
            queue_bytes: 64 << 20,
        }
    }
}

/// What a disk side did.
#[derive(Debug, Default)]
pub struct DiskReport {
    /// Files written, in order.
    pub files: Vec<PathBuf>,
    /// Files in which a secret was found, and the number of places.
    pub leaks: Vec<(PathBuf, usize)>,
    /// Files that could not be searched.
    pub unchecked: Vec<(PathBuf, String)>,
    /// Number of secrets that were searched for.
    pub secrets: usize,
    /// Whether there were more secrets than are remembered.
    pub too_many_secrets: bool,
}

/// What the relay tells the writer.
enum Event {
    Datagram {
        stream: Stream,
        number: u32,
        received: u64,
        forwarded: Option<u64>,
        bytes: Vec<u8>,
    },
    Forget(u32),
}

/// The relay's end of the queue to the writer.
pub struct Disk {
    queue: SyncSender<Event>,
    waiting_bytes: Arc<AtomicUsize>,
    limit_bytes: usize,
    number: AtomicU32,
    counters: Arc<Counters>,
    thread: JoinHandle<DiskReport>,
}

impl Disk {
    /// Begins the first file and starts the writer.
    ///
    /// # Errors
    /// The file cannot be created or written.
    pub fn start(
        config: DiskConfig,
        storage: Box<dyn Storage>,
        clock: Clock,
        counters: Arc<Counters>,
    ) -> Result<Self, RecordError> {
        let (queue, events) = sync_channel(config.queue);
        let waiting_bytes = Arc::new(AtomicUsize::new(0));
        let limit_bytes = config.queue_bytes;
        let writer = writer::DiskWriter::begin(
            config,
            storage,
            clock,
            counters.clone(),
            waiting_bytes.clone(),
        )?;
        let thread = std::thread::Builder::new()
            .name("ac-record writer".into())
            .spawn(move || writer.run(&events))
            .map_err(|source| RecordError::File {
                path: "writer thread".into(),
                source,
            })?;
        Ok(Self {
            queue,
            waiting_bytes,
            limit_bytes,
            number: AtomicU32::new(0),
            counters,
            thread,
        })
    }

    /// Hands a datagram over. Never waits; what finds no room is counted.
    pub fn record(&self, stream: Stream, received: u64, forwarded: Option<u64>, datagram: &[u8]) {
        let number = self.number.fetch_add(1, Ordering::Relaxed);
        let waiting = self
            .waiting_bytes
            .fetch_add(datagram.len(), Ordering::Relaxed);
        let event = || Event::Datagram {
            stream,
            number,
            received,
            forwarded,
            bytes: datagram.to_vec(),
        };
        if waiting > self.limit_bytes || self.queue.try_send(event()).is_err() {
            self.waiting_bytes
                .fetch_sub(datagram.len(), Ordering::Relaxed);
            add(&self.counters.unwritten_slow, 1);
        }
    }

    /// Says that a client will not come back.
    pub fn forget(&self, client: u32) {
        // When there is no room, the writer only remembers the client for longer.
        let _ = self.queue.try_send(Event::Forget(client));
    }

    /// Writes what waits and ends the file.
    pub fn finish(self) -> DiskReport {
        drop(self.queue);
        self.thread.join().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests;
