//! The transport's hash (`spec/09`, 6.1).

/// Hash of a byte string: its length shifted left by 16, plus its little-endian words, plus one to three remaining bytes placed from the top.
pub fn hash32(bytes: &[u8]) -> u32 {
    let mut words = bytes.chunks_exact(4);
    let start = (bytes.len() as u32) << 16;
    let sum = words.by_ref().fold(start, |h, w| {
        h.wrapping_add(u32::from_le_bytes([w[0], w[1], w[2], w[3]]))
    });
    words
        .remainder()
        .iter()
        .zip([24, 16, 8])
        .fold(sum, |h, (&b, shift)| h.wrapping_add(u32::from(b) << shift))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::hash32;

    #[test]
    fn examples_of_the_specification() {
        assert_eq!(hash32(&[]), 0);
        assert_eq!(hash32(&[1]), 0x0101_0000);
        assert_eq!(hash32(&[1, 2, 3, 4]), 0x0407_0201);
        assert_eq!(hash32(&[1, 2, 3, 4, 5]), 0x0908_0201);
        assert_eq!(hash32(&[1, 2, 3, 4, 5, 6, 7]), 0x0910_0901);
        assert_eq!(hash32(&[0x00, 0x10, 0x00, 0x00, 0x3C, 0x00]), 0x3C06_1000);
    }

    proptest! {
        #[test]
        fn hashes_of_whole_words_add(mut a: Vec<u8>, b: Vec<u8>) {
            a.truncate(a.len() / 4 * 4);
            let joined = [a.as_slice(), b.as_slice()].concat();
            prop_assert_eq!(hash32(&joined), hash32(&a).wrapping_add(hash32(&b)));
        }

        #[test]
        fn a_word_that_grows_moves_the_hash_as_much(mut bytes: Vec<u8>, at: prop::sample::Index, d: u32) {
            prop_assume!(bytes.len() >= 4);
            let i = at.index(bytes.len() / 4) * 4;
            let before = hash32(&bytes);
            let word = u32::from_le_bytes([bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]]);
            bytes[i..i + 4].copy_from_slice(&word.wrapping_add(d).to_le_bytes());
            prop_assert_eq!(hash32(&bytes), before.wrapping_add(d));
        }
    }
}
