//! The clock of a recording: wall-clock time that never steps.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// A monotonic clock that was set once.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    start: Instant,
    epoch: u64,
}

impl Default for Clock {
    fn default() -> Self {
        Self::new()
    }
}

impl Clock {
    /// A clock that agrees with the system's now.
    pub fn new() -> Self {
        let epoch = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default();
        Self {
            start: Instant::now(),
            epoch: epoch.as_nanos() as u64,
        }
    }

    /// Seconds since it was set.
    pub fn now(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Time since it was set.
    pub fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    /// ns since 1970; steps of the system's clock do not show.
    pub fn stamp(&self) -> u64 {
        self.epoch + self.start.elapsed().as_nanos() as u64
    }
}
