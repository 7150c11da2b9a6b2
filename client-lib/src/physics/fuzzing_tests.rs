//! A deterministic smoke of the fuzz target `world`.

use super::fuzzing;
use crate::world::Random;

#[test]
fn small_worlds() {
    let mut random = Random::Seeded(0x5EED);
    for _ in 0..60 {
        let mut byte = || (random.uniform() * 127.5 + 127.5) as u8;
        let recipe: Vec<u8> = (0..400).map(|_| byte()).collect();
        fuzzing::world(&recipe);
    }
}
