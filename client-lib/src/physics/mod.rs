//! Physics: object state, integration, collision response, and the swept-sphere transition.
//!
//! One tick of an object is in [`update`]: time and quanta, then per quantum root motion, managers, the [`integrator`], hooks, the
//! [`transition`], and the [commit](contacts) of its result.

pub mod attachment;
pub mod attack;
pub mod body;
pub mod collision;
mod commit;
pub mod contacts;
#[cfg(test)]
mod contacts_tests;
mod frames;
#[doc(hidden)]
pub mod fuzzing;
#[cfg(test)]
mod fuzzing_tests;
mod hooks;
pub mod integrator;
#[cfg(test)]
mod integrator_tests;
pub mod lifecycle;
pub mod maintenance;
pub mod managers;
mod membership;
mod movement;
pub mod network;
mod other_updates;
pub mod placement;
#[cfg(test)]
mod rest_tests;
mod special_objects;
pub mod state;
mod state_change;
mod still;
#[cfg(test)]
mod tests;
pub mod transition;
mod transition_setup;
pub mod update;
