//! Physics: object state, integration, collision response, and the swept-sphere transition.

pub mod body;
pub mod collision;
pub mod managers;
pub mod state;
pub mod transition;
