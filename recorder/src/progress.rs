//! Progress of long work, on standard error and only on a terminal.

use std::io::Read;
use std::path::Path;

use indicatif::{ProgressBar, ProgressStyle};

/// A source of bytes that shows how much of it was read.
pub struct Progress<R> {
    source: R,
    bar: ProgressBar,
}

impl<R: Read> Progress<R> {
    /// A source of about `length` bytes; `what` is shown in front.
    pub fn new(what: &Path, length: u64, source: R) -> Self {
        // Hidden where standard error is no terminal.
        let bar = ProgressBar::new(length);
        let template = "{prefix} {bar:30} {bytes}/{total_bytes} {bytes_per_sec} {eta}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_prefix(what.display().to_string());
        Self { source, bar }
    }
}

impl<R: Read> Read for Progress<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let n = self.source.read(buffer)?;
        self.bar.inc(n as u64);
        Ok(n)
    }
}

impl<R> Drop for Progress<R> {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
