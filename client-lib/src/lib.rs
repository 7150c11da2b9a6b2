//! Client library: the retail client's per-frame update stages, reproduced in `f32` and in the retail order.
//!
//! Everything is plain data and pure steps: a [`world::World`](crate) owns all state, entities are handles, and each stage of a
//! frame is a named function whose inputs and outputs a probe can see.
#![forbid(unsafe_code)]

pub mod frame;
