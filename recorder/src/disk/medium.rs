//! Where bytes go: files, or something else in tests.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Something that bytes are appended to.
pub trait Medium: Send {
    /// Appends bytes.
    ///
    /// # Errors
    /// Not all of them could be appended; how many were is not known.
    fn append(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Cuts everything after `length` bytes off.
    ///
    /// # Errors
    /// It cannot be done.
    fn truncate(&mut self, length: u64) -> io::Result<()>;

    /// Asks for everything to be on the disk.
    ///
    /// # Errors
    /// It cannot be done.
    fn sync(&mut self) -> io::Result<()>;
}

impl Medium for File {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.write_all(bytes)
    }

    fn truncate(&mut self, length: u64) -> io::Result<()> {
        self.set_len(length)?;
        self.seek(SeekFrom::Start(length)).map(drop)
    }

    fn sync(&mut self) -> io::Result<()> {
        self.sync_all()
    }
}

/// Where files are made.
pub trait Storage: Send {
    /// Makes a new file; one that is there is not touched.
    ///
    /// # Errors
    /// It cannot be made.
    fn create(&mut self, path: &Path) -> io::Result<Box<dyn Medium>>;

    /// Removes a file that nothing was written to.
    fn remove(&mut self, path: &Path);
}

/// The file system.
#[derive(Debug, Clone, Copy, Default)]
pub struct Files;

impl Storage for Files {
    fn create(&mut self, path: &Path) -> io::Result<Box<dyn Medium>> {
        Ok(Box::new(File::create_new(path)?))
    }

    fn remove(&mut self, path: &Path) {
        // Only what this program has just made, and only while it is empty.
        let empty = File::open(path)
            .and_then(|mut f| f.read(&mut [0]))
            .is_ok_and(|n| n == 0);
        if empty {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Collects bytes and appends them in one piece when it is flushed. What could not be appended is gone, and so is its beginning.
pub(super) struct Sink {
    medium: Box<dyn Medium>,
    buffer: Vec<u8>,
    /// Bytes appended; shared, for the sink is inside of others.
    written: Arc<AtomicU64>,
}

impl Sink {
    pub(super) fn new(medium: Box<dyn Medium>) -> Self {
        Self {
            medium,
            buffer: Vec::new(),
            written: Arc::default(),
        }
    }

    /// Bytes appended, to look at later.
    pub(super) fn written(&self) -> Arc<AtomicU64> {
        self.written.clone()
    }

    fn length(&self) -> u64 {
        self.written.load(Ordering::Relaxed)
    }

    pub(super) fn sync(&mut self) -> io::Result<()> {
        self.flush()?;
        self.medium.sync()
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.buffer.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.buffer.is_empty() {
            return Ok(());
        }
        let result = self.medium.append(&self.buffer);
        match &result {
            Ok(()) => drop(
                self.written
                    .fetch_add(self.buffer.len() as u64, Ordering::Relaxed),
            ),
            // A whole chunk or nothing. If even this fails, recovery leaves the rest out.
            Err(_) => drop(self.medium.truncate(self.length())),
        }
        self.buffer.clear();
        result
    }
}

impl Seek for Sink {
    /// Only tells where it is.
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) => Ok(self.length() + self.buffer.len() as u64),
            _ => Err(io::ErrorKind::Unsupported.into()),
        }
    }
}
