//! Drives the client library from scenes, deterministically.
//!
//! [`simulation`] is the seam: what the replayer and the conformance harness need of a client, and nothing else. [`client`]
//! puts the client library behind it. [`replay`] runs a scene and writes what it produced as a trace, [`checkpoints`] what went
//! into and came out of each stage on the way, and [`keyframes`] all state from time to time, so that a later frame can be
//! reached without running what is before.

pub mod checkpoints;
pub mod cli;
pub mod client;
pub mod dat_cmd;
pub mod keyframes;
pub mod packets;
pub mod plan_cmd;
pub mod replay;
pub mod simulation;

pub use simulation::{Simulation, SimulationError, Simulator};
