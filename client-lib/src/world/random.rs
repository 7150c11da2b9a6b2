//! Chance, injectable: the same seed always gives the same draws.

/// Source of the random draws of placements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Random {
    /// Every draw answers the middle of its range, as in the oracles.
    #[default]
    Middle,
    /// A generator (SplitMix64) in this state.
    Seeded(u64),
}

impl Random {
    /// A number in [−1, 1].
    pub fn uniform(&mut self) -> f32 {
        let Self::Seeded(state) = self else {
            return 0.0;
        };
        *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = *state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        // 24 bits are exact in f32.
        (z >> 40) as f32 * (2.0 / 16_777_215.0) - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_stay_in_range_and_repeat() {
        let draw = |seed| {
            let mut random = Random::Seeded(seed);
            (0..1000).map(|_| random.uniform()).collect::<Vec<_>>()
        };
        assert!(draw(7).iter().all(|x| (-1.0..=1.0).contains(x)));
        assert_eq!(draw(7), draw(7));
        assert_ne!(draw(7), draw(8));
        assert_eq!(Random::Middle.uniform(), 0.0);
    }
}
