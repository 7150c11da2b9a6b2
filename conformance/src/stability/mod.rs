//! Stability: what small changes grow to, and what stiff and extreme cases do to the rules that must hold.
//!
//! - [`ensemble`]: a scene is run again with its start moved by a few units in the last place up to a millimetre, and with frames that much longer;
//!   the distance between the runs tells whether the scene forgets, keeps or amplifies a change, or decides differently.
//! - [`generators`]: every stiff or extreme case that the specification lists, built as a scene on a [world](worlds) made in memory or as calls of
//!   the functions it is about.
//! - [`invariants`]: what must hold in every frame of every scene.
//!
//! A violation that retail shares is told from one of ours by evidence: a frame of an oracle's trace that shows it, or the section of the
//! specification that says so.

pub mod ensemble;
pub mod generators;
pub mod invariants;
pub mod lab;
pub mod output;
pub mod stage;
pub mod trial;
pub mod worlds;

pub use invariants::{Invariant, Violation};
pub use trial::{Case, CaseResult, Trial, Verdict};

#[cfg(test)]
mod tests;
