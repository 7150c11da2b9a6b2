//! The receiver's search for key words, with recovery of skipped ones (`spec/09`, 7.3).

use super::isaac::Isaac;

/// Key words that may be skipped and still found.
pub const KEY_WINDOW: usize = 256;

/// Tells whether a key word belongs to a stream, in whatever order packets arrive.
#[derive(Clone, Debug)]
pub struct KeySearch {
    isaac: Isaac,
    current: u32,
    /// Words drawn but not matched, oldest first.
    skipped: Vec<u32>,
}

impl KeySearch {
    /// A search in the stream of a seed.
    pub fn new(seed: u32) -> Self {
        let mut isaac = Isaac::new(seed);
        let current = isaac.next_word();
        Self {
            isaac,
            current,
            skipped: Vec::with_capacity(KEY_WINDOW),
        }
    }

    /// Accepts the key word of one packet; each word is accepted once. A rejected word changes nothing, so junk cannot use up the window.
    pub fn accept(&mut self, word: u32) -> bool {
        if word == self.current {
            self.current = self.isaac.next_word();
            return true;
        }
        if let Some(at) = self.skipped.iter().position(|&w| w == word) {
            self.skipped.remove(at);
            return true;
        }
        self.search_ahead(word)
    }

    fn search_ahead(&mut self, word: u32) -> bool {
        let mut ahead = self.isaac.clone();
        let mut current = self.current;
        let room = KEY_WINDOW - self.skipped.len();
        let before = self.skipped.len();
        for _ in 0..room {
            self.skipped.push(current);
            current = ahead.next_word();
            if current == word {
                self.current = ahead.next_word();
                self.isaac = ahead;
                return true;
            }
        }
        self.skipped.truncate(before);
        false
    }

    /// Words that were skipped and may still come.
    pub fn outstanding(&self) -> usize {
        self.skipped.len()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn words(seed: u32, n: usize) -> Vec<u32> {
        let mut isaac = Isaac::new(seed);
        (0..n).map(|_| isaac.next_word()).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn any_order_within_the_window_is_accepted_once(seed: u32, mut order in Just((0..256).collect::<Vec<usize>>()).prop_shuffle()) {
            let stream = words(seed, 256);
            let mut search = KeySearch::new(seed);
            order.truncate(200);
            for &i in &order {
                prop_assert!(search.accept(stream[i]));
            }
            for &i in &order {
                prop_assert!(!search.accept(stream[i]), "a duplicate was accepted");
            }
        }
    }

    #[test]
    fn the_window_reaches_256_words_ahead() {
        let stream = words(7, 600);
        assert!(KeySearch::new(7).accept(stream[256]));
        assert!(!KeySearch::new(7).accept(stream[257]));
    }

    #[test]
    fn lost_packets_come_back_in_reverse_around_a_forgery() {
        let stream = words(9, 300);
        let mut search = KeySearch::new(9);
        assert!(search.accept(stream[256]));
        assert!(!search.accept(0xDEAD_BEEF) && search.outstanding() == 256);
        for word in stream[..256].iter().rev() {
            assert!(search.accept(*word));
        }
        assert!(search.accept(stream[257]) && search.outstanding() == 0);
    }
}
