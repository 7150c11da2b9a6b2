//! A bad network, from a seed: loss, duplication, reordering, delay, corruption.
//!
//! A [`FaultLink`] is one direction of a connection in virtual time. Which datagrams suffer depends on the seed and their order alone, so a
//! session over it can be repeated.

use std::collections::BTreeMap;

/// How bad a link is. Probabilities are per datagram, 0..=1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Faults {
    /// A datagram vanishes.
    pub loss: f64,
    /// It arrives twice.
    pub duplicate: f64,
    /// It is held back so that later ones overtake it.
    pub reorder: f64,
    /// A bit of it is flipped, or it is cut off.
    pub corrupt: f64,
    /// Time every datagram takes, s.
    pub delay: f64,
    /// Random time on top, up to this, s. With more than the time between two datagrams they overtake each other.
    pub jitter: f64,
}

impl Faults {
    /// A link that only takes time.
    pub const fn delay(seconds: f64) -> Self {
        Self {
            loss: 0.0,
            duplicate: 0.0,
            reorder: 0.0,
            corrupt: 0.0,
            delay: seconds,
            jitter: 0.0,
        }
    }

    /// The first number that is no probability or no time, by name.
    pub fn invalid(&self) -> Option<&'static str> {
        let chances = [
            ("loss", self.loss),
            ("duplicate", self.duplicate),
            ("reorder", self.reorder),
            ("corrupt", self.corrupt),
        ];
        let times = [("delay", self.delay), ("jitter", self.jitter)];
        let bad_chance = chances.iter().find(|(_, p)| !(0.0..=1.0).contains(p));
        let bad_time = times.iter().find(|(_, t)| !(0.0..=60.0).contains(t));
        bad_chance.or(bad_time).map(|(name, _)| *name)
    }
}

/// What a link has done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs, reason = "the names say it")]
pub struct FaultCounts {
    pub sent: u64,
    pub lost: u64,
    pub duplicated: u64,
    pub reordered: u64,
    pub corrupted: u64,
}

/// How long a reordered datagram is held back, s.
const HELD_BACK: f64 = 0.25;

/// One direction of a bad network.
#[derive(Debug, Clone)]
pub struct FaultLink<T> {
    faults: Faults,
    random: SplitMix,
    /// By arrival in nanoseconds and order of sending.
    under_way: BTreeMap<(u64, u64), (T, Vec<u8>)>,
    order: u64,
    counts: FaultCounts,
}

impl<T: Clone> FaultLink<T> {
    /// A link whose faults follow from a seed.
    pub const fn new(faults: Faults, seed: u64) -> Self {
        Self {
            faults,
            random: SplitMix(seed),
            under_way: BTreeMap::new(),
            order: 0,
            counts: FaultCounts {
                sent: 0,
                lost: 0,
                duplicated: 0,
                reordered: 0,
                corrupted: 0,
            },
        }
    }

    /// What the link has done.
    pub const fn counts(&self) -> &FaultCounts {
        &self.counts
    }

    /// Makes the link better or worse from now on.
    pub const fn set_faults(&mut self, faults: Faults) {
        self.faults = faults;
    }

    /// Takes a datagram at `now` (s). `way` comes out with it: a port, an address.
    pub fn send(&mut self, way: T, datagram: &[u8], now: f64) {
        self.counts.sent += 1;
        // Every datagram draws the same numbers, whatever happens to it.
        let f = self.faults;
        let draws: [bool; 4] =
            [f.loss, f.duplicate, f.reorder, f.corrupt].map(|p| self.random.chance(p));
        let [lost, twice, late, bad] = draws;
        let extra = self.random.unit() * f.jitter;
        let damage = self.random.next();
        if lost {
            self.counts.lost += 1;
            return;
        }
        let mut bytes = datagram.to_vec();
        if bad {
            self.counts.corrupted += 1;
            corrupt(&mut bytes, damage);
        }
        let mut at = now + f.delay + extra;
        if late {
            self.counts.reordered += 1;
            at += HELD_BACK;
        }
        if twice {
            self.counts.duplicated += 1;
            self.put(at + HELD_BACK / 2.0, way.clone(), bytes.clone());
        }
        self.put(at, way, bytes);
    }

    fn put(&mut self, at: f64, way: T, bytes: Vec<u8>) {
        self.order += 1;
        let nanoseconds = (at.max(0.0) * 1e9).round() as u64;
        self.under_way
            .insert((nanoseconds, self.order), (way, bytes));
    }

    /// The next datagram that arrives up to `now` (s): when, in nanoseconds, which way, and what.
    pub fn arrive(&mut self, now: f64) -> Option<(u64, T, Vec<u8>)> {
        let first = self.under_way.first_entry()?;
        let (at, _) = *first.key();
        if at as f64 > (now * 1e9).round() {
            return None;
        }
        let (way, bytes) = first.remove();
        Some((at, way, bytes))
    }

    /// When the next datagram arrives, s.
    pub fn next_arrival(&self) -> Option<f64> {
        self.under_way.keys().next().map(|(at, _)| *at as f64 / 1e9)
    }
}

/// Flips a bit, or cuts the end off.
fn corrupt(bytes: &mut Vec<u8>, damage: u64) {
    if bytes.is_empty() {
        return;
    }
    let at = (damage >> 8) as usize % bytes.len();
    if damage & 7 == 7 {
        bytes.truncate(at);
    } else if let Some(byte) = bytes.get_mut(at) {
        *byte ^= 1 << (damage & 7);
    }
}

/// A small generator of good quality: SplitMix64.
#[derive(Debug, Clone, Copy)]
pub struct SplitMix(pub u64);

impl SplitMix {
    /// The next number.
    pub const fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number in 0..1.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// True with a probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(faults: Faults, seed: u64) -> (Vec<(u64, u32)>, FaultCounts) {
        let mut link = FaultLink::new(faults, seed);
        for i in 0..1000u32 {
            link.send((), &i.to_le_bytes(), f64::from(i) * 0.01);
        }
        let mut got = Vec::new();
        while let Some((at, (), bytes)) = link.arrive(1e9) {
            let mut word = [0; 4];
            let n = bytes.len();
            word[..n].copy_from_slice(&bytes);
            got.push((at, u32::from_le_bytes(word)));
        }
        (got, *link.counts())
    }

    const BAD: Faults = Faults {
        loss: 0.1,
        duplicate: 0.05,
        reorder: 0.1,
        corrupt: 0.05,
        delay: 0.05,
        jitter: 0.0,
    };

    #[test]
    fn a_seed_decides_everything() {
        assert_eq!(run(BAD, 7), run(BAD, 7));
        assert_ne!(run(BAD, 7).0, run(BAD, 8).0);
    }

    #[test]
    fn faults_come_as_often_as_asked() {
        let (got, counts) = run(BAD, 3);
        assert_eq!(got.len() as u64, 1000 - counts.lost + counts.duplicated);
        assert!((60..140).contains(&counts.lost), "{counts:?}");
        assert!((60..140).contains(&counts.reordered), "{counts:?}");
        assert!((20..80).contains(&counts.corrupted), "{counts:?}");
        assert!(got.windows(2).all(|w| w[0].0 <= w[1].0));
        assert!(got.windows(2).any(|w| w[0].1 > w[1].1));
    }

    #[test]
    fn a_good_link_only_takes_time() {
        let (got, counts) = run(Faults::delay(0.5), 1);
        assert_eq!(
            counts,
            FaultCounts {
                sent: 1000,
                ..FaultCounts::default()
            }
        );
        assert!(got.iter().enumerate().all(|(i, (_, n))| i as u32 == *n));
        assert_eq!(got[0].0, 500_000_000);
        assert_eq!(BAD.invalid(), None);
        assert_eq!(
            Faults {
                loss: f64::NAN,
                ..BAD
            }
            .invalid(),
            Some("loss")
        );
        assert_eq!(Faults { delay: -1.0, ..BAD }.invalid(), Some("delay"));
    }
}
