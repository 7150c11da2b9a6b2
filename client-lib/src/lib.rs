//! Client library: the retail client's per-frame update stages, reproduced in `f32` and in the retail order.
//!
//! Everything is plain data and pure steps: a [`world::World`] owns all state, entities are handles, and each stage of a frame is a named
//! function whose inputs and outputs a probe can see. Behaviour on which the reconstructions of the client disagree is a switch of a
//! [`profile::Profile`].

pub mod animation;
pub mod dat;
pub mod entity;
pub mod frame;
pub mod math;
pub mod motion;
pub mod net;
pub mod physics;
pub mod profile;
pub mod snapshot;
pub mod world;
