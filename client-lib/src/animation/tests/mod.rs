//! Worked examples, invariants and hard cases of `spec/07-animation.md`, sections 14 to 16.

mod hard_cases;
mod invariants;
mod motions;
mod parts;
mod worked;
