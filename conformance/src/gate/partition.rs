//! Cutting a run into shards that run on different machines.
//!
//! Every machine finds the same scenes and keeps only its part; nothing coordinates them. Shards count from 1: `--shard 2/3` is
//! the second of three. Together the shards of a total are every scene exactly once. There are two ways to cut:
//!
//! - *counted* (`2/3`): scenes in the order of their names are dealt out like cards. The parts have the same size, but
//!   a scene that is added moves those behind it to another shard.
//! - *hashed* (`hash:2/3`): the name alone says where a scene goes. The parts are only about the same size, but a scene
//!   stays in its shard whatever is added or removed: caches stay warm, and a failure is looked for in the same place.
//!
//! A scene is never cut: all its oracles, modes and entities are in the same shard.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};

/// One part of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Shard {
    /// How it is cut.
    pub cut: Cut,
    /// Which part, from 1.
    pub index: u32,
    /// Of how many.
    pub total: u32,
}

/// How a run is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cut {
    /// By position.
    Counted,
    /// By name.
    Hashed,
}

impl Shard {
    /// Whether the scene of this name, at this place in the order of all names, belongs here.
    pub fn has(self, place: usize, scene: &str) -> bool {
        let number = match self.cut {
            Cut::Counted => place as u64,
            Cut::Hashed => {
                let mut bytes = [0; 8];
                bytes.copy_from_slice(&blake3::hash(scene.as_bytes()).as_bytes()[..8]);
                u64::from_le_bytes(bytes)
            }
        };
        number % u64::from(self.total) == u64::from(self.index) - 1
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (cut, numbers) = match text.strip_prefix("hash:") {
            Some(numbers) => (Cut::Hashed, numbers),
            None => (Cut::Counted, text),
        };
        let parsed = numbers
            .split_once('/')
            .and_then(|(index, total)| Some((index.parse().ok()?, total.parse().ok()?)));
        match parsed {
            Some((index, total)) if 1 <= index && index <= total => Ok(Self { cut, index, total }),
            Some((_, total)) => Err(format!("shards of {total} count from 1 to {total}")),
            None => Err("expected i/n or hash:i/n, like 2/3".into()),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cut = match self.cut {
            Cut::Counted => "",
            Cut::Hashed => "hash:",
        };
        write!(f, "{cut}{}/{}", self.index, self.total)
    }
}

impl TryFrom<String> for Shard {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn every_scene_is_in_one_shard(total in 1u32..20, place in 0usize..1000, name in "[a-z]{1,8}/[a-z]{1,8}") {
            for cut in [Cut::Counted, Cut::Hashed] {
                let shards = (1..=total).map(|index| Shard { cut, index, total });
                prop_assert_eq!(shards.filter(|shard| shard.has(place, &name)).count(), 1);
            }
        }
    }

    #[test]
    fn hashed_shards_do_not_look_at_the_place() {
        let shard: Shard = "hash:2/3".parse().unwrap();
        assert_eq!(shard.has(0, "jump/high"), shard.has(1, "jump/high"));
        assert_eq!(shard.to_string(), "hash:2/3");
    }

    #[test]
    fn nonsense_is_refused() {
        let bad = |text: &str| text.parse::<Shard>().unwrap_err();
        insta::assert_snapshot!(bad("0/3"), @"shards of 3 count from 1 to 3");
        insta::assert_snapshot!(bad("4/3"), @"shards of 3 count from 1 to 3");
        insta::assert_snapshot!(bad("1/0"), @"shards of 0 count from 1 to 0");
        insta::assert_snapshot!(bad("third"), @"expected i/n or hash:i/n, like 2/3");
    }
}
