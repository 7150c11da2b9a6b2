//! Error against run time: what each choice of fidelity costs, and what it buys.
//!
//! A scene is run under a [`grid`] of settings: quanta of one length, frame rates, fewer updates of remote entities, other profiles, the scene
//! plan. Each run has a cost (time and instructions per simulated second, [`cost`]) and three errors ([`track`]): what is shown against the
//! oracle's trace, the path against a converged reference, and, for [scenes with a solution](cases), the path against the truth. A
//! [summary] draws the conclusions: order of convergence, Pareto front, the cheapest setting that is good enough.
//!
//! The converged reference of a scene is the client at the shortest quantum; how far it can be trusted is told by half as many quanta. Smooth
//! phases have a better one: [`mod@reference`] integrates them in f64 and extrapolates.

pub mod cases;
pub mod cost;
pub mod grid;
pub mod lab;
pub mod output;
pub mod reference;
pub mod resample;
pub mod smooth;
pub mod summary;
pub mod track;

pub use grid::Setting;
pub use lab::{Options, SceneLab, Subject, run};

#[cfg(test)]
mod tests;
