//! placeholder

pub mod stage;
