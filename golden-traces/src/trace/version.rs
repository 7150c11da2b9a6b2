//! The version of the trace format, and the rule for old and new readers and files.
//!
//! A version is `MAJOR.MINOR`. This program writes [`FormatVersion::CURRENT`].
//!
//! | file | what a reader does |
//! |---|---|
//! | same version | reads it; a field it does not know is an error |
//! | same major, newer minor | reads it; channels and fields it does not know are skipped |
//! | same major, older minor | reads it; what that version did not have is absent |
//! | newer major | refuses: update the program |
//! | older major, not below [`FormatVersion::OLDEST_MAJOR`] | reads it |
//! | older major than that | refuses: write the file again |
//!
//! So a writer may add a channel or a field with a new minor version. Removing or re-interpreting one takes a new major.

use std::{fmt, path::Path, str::FromStr};

use crate::{GoldenError, record::Unknown};

/// A version of the trace format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FormatVersion {
    /// Changes when an old reader would misread the file.
    pub major: u32,
    /// Changes when something is added.
    pub minor: u32,
}

impl FormatVersion {
    /// What this program writes.
    pub const CURRENT: Self = Self { major: 1, minor: 0 };
    /// The oldest major version that this program still reads.
    pub const OLDEST_MAJOR: u32 = 1;

    /// Applies the rule of this module: how to treat unknown fields, or why the file is refused.
    ///
    /// # Errors
    /// When the major version is not one that this program reads.
    pub fn accept(self, path: &Path) -> Result<Unknown, GoldenError> {
        let refuse = |advice| {
            Err(GoldenError::Version {
                path: path.into(),
                found: self.to_string(),
                known: format!("{}.x to {}.x", Self::OLDEST_MAJOR, Self::CURRENT.major),
                advice,
            })
        };
        if self.major > Self::CURRENT.major {
            return refuse("use a newer version of this program");
        }
        if self.major < Self::OLDEST_MAJOR {
            return refuse("write the trace again from its scene");
        }
        Ok(if self > Self::CURRENT {
            Unknown::Skip
        } else {
            Unknown::Refuse
        })
    }
}

impl fmt::Display for FormatVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

impl FromStr for FormatVersion {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let bad = || format!("`{text}` is no version like `1.0`");
        let (major, minor) = text.split_once('.').ok_or_else(bad)?;
        Ok(Self {
            major: major.parse().map_err(|_| bad())?,
            minor: minor.parse().map_err(|_| bad())?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn accept(text: &str) -> Result<Unknown, String> {
        text.parse::<FormatVersion>()
            .unwrap()
            .accept(Path::new("x.mcap"))
            .map_err(|error| error.to_string())
    }

    #[test]
    fn the_rule() {
        assert_eq!(accept("1.0"), Ok(Unknown::Refuse));
        assert_eq!(accept("1.7"), Ok(Unknown::Skip));
        insta::assert_snapshot!(accept("2.0").unwrap_err(), @"x.mcap: trace format 2.0 cannot be read by this program, which reads 1.x to 1.x; use a newer version of this program");
        insta::assert_snapshot!(accept("0.9").unwrap_err(), @"x.mcap: trace format 0.9 cannot be read by this program, which reads 1.x to 1.x; write the trace again from its scene");
        assert!("1".parse::<FormatVersion>().is_err());
    }
}
