//! Drives the client library from scenes, deterministically.
//!
//! [`simulation`] is the seam: what the replayer and the conformance harness need of a client, and nothing else. [`client`]
//! puts the client library behind it.

pub mod client;
pub mod simulation;

pub use simulation::{Simulation, SimulationError, Simulator};
