//! Snapshots: everything that changes in a [`World`], as plain data that outlives the program that took it.
//!
//! A snapshot is taken between two frames and restored into a new world over the same dat files and profile. The restored world goes on bit
//! for bit like the one it was taken of. It is not an image of memory: each type of the library has a *form*, a plain serde type whose fields
//! are written out one by one, and [`VERSION`] counts the changes of these forms. What the dat files say is not stored but named by its id
//! (shapes, setups, animations, motion tables, terrain, rooms), and made again from the files.
//!
//! The conversions take their types apart without `..`: a field that is added to the library does not compile until it is decided here whether
//! it is state (stored) or follows from something else (named, with the reason). Numbers keep their bits: minus zero, infinities and every
//! not-a-number.
//!
//! Forms are read from strangers: restoring checks every index that the library would trust and bounds the memory that it takes.
//!
//! | file | forms of |
//! |---|---|
//! | `leaf` | numbers, ids, flags, vectors, positions, lists |
//! | `frames` | what a frame left behind, the pipeline |
//! | `animations` | part arrays, sequences, motion tables, hooks |
//! | `motions` | interpreter, motion states, move-to |
//! | `objects` | entities, bodies, managers, the object table |
//! | `map` | loaded blocks, rooms, static objects |
//! | `whole` | the world |
//! | `windows` | the window of landblocks that a client keeps around its player |

mod animations;
mod form;
mod frames;
mod leaf;
mod map;
mod motions;
mod objects;
mod whole;
mod windows;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::frame::Pipeline;
use crate::profile::Profile;
use crate::world::{Resources, Streaming, World, WorldSource};

/// Version of the forms. Raise it whenever a form changes: a reader refuses every other version. The test `the_forms_belong_to_the_version`
/// knows all forms of the present one.
pub const VERSION: u32 = 1;

/// Elements of lists that one snapshot may have in all: bounds what restoring can take.
const MAX_ELEMENTS: usize = 4 << 20;

/// Why a snapshot cannot be restored.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SnapshotError {
    /// It names a record of the dat files that is not there or cannot be read.
    #[error(
        "the dat files have no {kind} 0x{id:08X}, which the snapshot names: it was taken over other files"
    )]
    MissingRecord {
        /// What kind of record.
        kind: &'static str,
        /// Its id.
        id: u32,
    },
    /// It says something that no world can be in.
    #[error("the snapshot contradicts itself: {0}")]
    Inconsistent(String),
    /// The world runs under a plan, which has put a part of it off.
    #[error("a world under a plan is not all there: run it without a plan")]
    Planned,
    /// It has more elements than any world.
    #[error("the snapshot has more than {MAX_ELEMENTS} elements")]
    TooLarge,
}

/// All state of a world.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(transparent)]
pub struct WorldSnapshot(whole::WorldForm);

/// All state of a streaming window.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(transparent)]
pub struct StreamingSnapshot(windows::StreamingForm);

/// All state of a pipeline.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PipelineSnapshot(frames::PipelineForm);

impl WorldSnapshot {
    /// Takes a snapshot. No entity may be taken out, that is, the world is between two frames.
    ///
    /// # Errors
    /// A world under a [plan](World::set_plan): a part of its state is put off.
    pub fn of(world: &World) -> Result<Self, SnapshotError> {
        Ok(Self(whole::store(world)?))
    }

    /// Makes the world again over the files and under the profile that it had. What has to be read of the files is read now.
    ///
    /// # Errors
    /// A record that is missing, or a snapshot that contradicts itself: one that was not taken of a world, or over other files.
    pub fn restore(
        self,
        source: Arc<dyn WorldSource>,
        profile: Profile,
    ) -> Result<World, SnapshotError> {
        whole::restore(self.0, source, profile)
    }
}

impl StreamingSnapshot {
    /// Takes a snapshot.
    pub fn of(streaming: &Streaming) -> Self {
        Self(windows::store(streaming))
    }

    /// Makes the window again; what it shows is loaded in the world that belongs to it.
    ///
    /// # Errors
    /// A window that no client can have.
    pub fn restore(self) -> Result<Streaming, SnapshotError> {
        windows::restore(self.0)
    }
}

impl PipelineSnapshot {
    /// Takes a snapshot.
    pub fn of(pipeline: &Pipeline) -> Self {
        Self(frames::store(pipeline))
    }

    /// Makes the pipeline again.
    pub fn restore(self) -> Pipeline {
        frames::restore(self.0)
    }
}

/// What restoring needs beside the forms.
struct Restorer<'a> {
    resources: &'a mut Resources,
    profile: &'a Profile,
    /// Elements of lists so far.
    elements: &'a mut usize,
}

impl Restorer<'_> {
    /// Counts the elements of a list.
    fn spend(&mut self, elements: usize) -> Result<(), SnapshotError> {
        *self.elements = self.elements.saturating_add(elements);
        if *self.elements > MAX_ELEMENTS {
            return Err(SnapshotError::TooLarge);
        }
        Ok(())
    }
}

fn inconsistent(what: impl Into<String>) -> SnapshotError {
    SnapshotError::Inconsistent(what.into())
}

#[cfg(test)]
mod tests;
