//! Setups, part arrays, sequences, motion tables and hooks (`spec/07-animation.md`).

mod part_array;

pub use part_array::PartArray;
