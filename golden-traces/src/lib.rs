//! Scenes, expected states and the trace format that holds them: one definition for everyone.
//!
//! - [`scene`]: scene files.
//! - [`record`]: the state of an entity after a frame, as JSON.
//! - [`expect`]: the JSON Lines files of the oracles.
//! - [`trace`]: the trace files.
//! - [`import`]: makes them of scenes and JSON Lines files.
//! - [`pictures`]: the same as pictures for viewers.
//! - [`corpus`]: where all of these lie on disk.

pub mod corpus;
pub mod expect;
pub mod import;
pub mod number;
pub mod pictures;
pub mod record;
pub mod scene;
pub mod trace;

mod error;

pub use error::GoldenError;
pub use scene::Scene;
