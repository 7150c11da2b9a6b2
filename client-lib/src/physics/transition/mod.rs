//! The transition: takes an object from where it is to where it wants to be, and answers with what it may have
//! (`spec/05-transition.md`).

mod records;
mod state;

pub use state::{
    CellArray, CellArrayEntry, CollisionInfo, ContactPlane, InsertType, ObjectInfo,
    ObjectInfoState, SpherePath, Transition, TransitionState,
};
