//! At which times the frames of a replay are.

use std::path::Path;
use std::str::FromStr;

use ac_golden_traces::scene::FrameRun;

use super::{PacketsError, Session};

/// Frames of a replay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrameClock {
    /// This many per second, from the session's first datagram on.
    Fixed(f64),
    /// At every time at which a datagram was recorded; longer pauses are filled with equal frames of at most 1/30 s.
    Recorded,
}

/// Most frames of a replay.
pub const MAX_FRAMES: u32 = 5_000_000;
/// Longest frame of [`FrameClock::Recorded`], ns.
const LONGEST: u64 = 1_000_000_000 / 30;

impl Default for FrameClock {
    fn default() -> Self {
        Self::Fixed(30.0)
    }
}

impl FromStr for FrameClock {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "recorded" {
            return Ok(Self::Recorded);
        }
        let rate = text.strip_prefix("fixed:").and_then(|hz| hz.parse().ok());
        match rate {
            Some(hz) if (0.1..=1000.0).contains(&hz) => Ok(Self::Fixed(hz)),
            _ => Err(format!(
                "`{text}` is no frame clock; `fixed:HZ` (0.1 to 1000 frames per second) or `recorded`"
            )),
        }
    }
}

impl FrameClock {
    /// The frames of a session, as a scene names them. The first is at its first datagram.
    ///
    /// # Errors
    /// When they are too many.
    pub fn frames(self, session: &Session, path: &Path) -> Result<Vec<FrameRun>, PacketsError> {
        let too_long = || PacketsError::TooLong {
            path: path.into(),
            seconds: session.seconds(),
            limit: MAX_FRAMES,
        };
        match self {
            Self::Fixed(hz) => {
                let count = (session.seconds() * hz).ceil() + 1.0;
                if count > f64::from(MAX_FRAMES) {
                    return Err(too_long());
                }
                Ok(vec![FrameRun {
                    dt: 1.0 / hz,
                    count: count as u32,
                }])
            }
            Self::Recorded => recorded(&session.arrivals).ok_or_else(too_long),
        }
    }
}

fn recorded(arrivals: &[u64]) -> Option<Vec<FrameRun>> {
    let mut runs: Vec<FrameRun> = vec![FrameRun {
        dt: LONGEST as f64 / 1e9,
        count: 1,
    }];
    let mut total = 1u64;
    for pair in arrivals.windows(2) {
        let gap = pair[1].saturating_sub(pair[0]);
        if gap == 0 {
            continue;
        }
        let count = gap.div_ceil(LONGEST);
        total += count;
        if total > u64::from(MAX_FRAMES) {
            return None;
        }
        let dt = gap as f64 / 1e9 / count as f64;
        match runs.last_mut() {
            Some(last) if last.dt == dt => last.count += count as u32,
            _ => runs.push(FrameRun {
                dt,
                count: count as u32,
            }),
        }
    }
    Some(runs)
}
