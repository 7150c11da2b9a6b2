//! Immutable resources of the world: loaded when first needed, shared ever after.

use std::collections::HashMap;
use std::sync::Arc;

use super::source::{Lookup, MemorySource, WorldSource};
use crate::animation::AnimationSource;
use crate::dat::{Animation, DatError, MotionTable, Setup};
use crate::physics::collision::{CellShape, GfxShape, TreeError};
use crate::profile::Profile;

/// Degrade mode of a shape that is not drawn facing the viewer.
const DRAWN_AS_IT_IS: u32 = 1;
/// Errors that are kept; more only count.
const MAX_ERRORS: usize = 256;

/// Something that could not be loaded and counts as absent.
#[derive(Debug, Clone, thiserror::Error)]
pub enum LoadError {
    /// The file or record is damaged.
    #[error(transparent)]
    Dat(#[from] Arc<DatError>),
    /// The collision geometry of a record is inconsistent.
    #[error("record 0x{id:08X}: {error}")]
    Tree {
        /// The record.
        id: u32,
        /// What is wrong.
        error: TreeError,
    },
}

/// The records of the world with everything that was made of them.
///
/// A record that cannot be read counts as absent, as in a world that lacks it, and is noted in [`Resources::errors`].
#[derive(Debug)]
pub struct Resources {
    source: Arc<dyn WorldSource>,
    /// Planes of shapes depend on the profile's arithmetic.
    profile: Profile,
    shapes: HashMap<u32, Option<Arc<GfxShape>>>,
    rooms: HashMap<(u32, u16), Option<Arc<CellShape>>>,
    errors: Vec<LoadError>,
}

impl Default for Resources {
    fn default() -> Self {
        Self::new(Arc::new(MemorySource::default()), Profile::default())
    }
}

impl Resources {
    /// Resources of a source, made for a profile.
    pub fn new(source: Arc<dyn WorldSource>, profile: Profile) -> Self {
        Self {
            source,
            profile,
            shapes: HashMap::new(),
            rooms: HashMap::new(),
            errors: Vec::new(),
        }
    }

    /// The records.
    pub fn source(&self) -> &Arc<dyn WorldSource> {
        &self.source
    }

    /// What could not be loaded so far, in order, at most 256.
    pub fn errors(&self) -> &[LoadError] {
        &self.errors
    }

    fn note(&mut self, error: LoadError) {
        if self.errors.len() < MAX_ERRORS {
            self.errors.push(error);
        }
    }

    /// The record that a lookup found; one that cannot be read counts as absent and is noted.
    pub fn found<T>(&mut self, lookup: Lookup<T>) -> Option<Arc<T>> {
        lookup.unwrap_or_else(|error| {
            self.note(Arc::new(error).into());
            None
        })
    }

    /// Shape of a kind of room: environment 0x0D...... and key of the structure in it.
    pub fn room_shape(&mut self, environment: u32, key: u16) -> Option<Arc<CellShape>> {
        if let Some(known) = self.rooms.get(&(environment, key)) {
            return known.clone();
        }
        let record = self.found(self.source.environment(environment));
        let shape = record.as_ref().and_then(|r| r.structure(key)).map(|s| {
            CellShape::from_record(s, &self.profile).map_err(|error| LoadError::Tree {
                id: environment,
                error,
            })
        });
        let shape = self.keep(shape);
        self.rooms.insert((environment, key), shape.clone());
        shape
    }

    fn keep<T>(&mut self, made: Option<Result<T, LoadError>>) -> Option<Arc<T>> {
        match made? {
            Ok(shape) => Some(Arc::new(shape)),
            Err(error) => {
                self.note(error);
                None
            }
        }
    }

    /// Level 0 of a shape's degrade info is drawn facing the viewer.
    fn is_always_2d(&mut self, degrade: u32) -> bool {
        degrade != 0
            && self
                .found(self.source.degrade_info(degrade))
                .and_then(|info| info.levels.first().map(|level| level.mode))
                .is_some_and(|mode| mode != DRAWN_AS_IT_IS)
    }
}

impl AnimationSource for Resources {
    fn animation(&mut self, id: u32) -> Option<Arc<Animation>> {
        self.found(self.source.animation(id))
    }

    fn motion_table(&mut self, id: u32) -> Option<Arc<MotionTable>> {
        self.found(self.source.motion_table(id))
    }

    fn setup(&mut self, id: u32) -> Option<Arc<Setup>> {
        self.found(self.source.setup(id))
    }

    fn shape(&mut self, id: u32) -> Option<Arc<GfxShape>> {
        if let Some(known) = self.shapes.get(&id) {
            return known.clone();
        }
        let record = self.found(self.source.gfx_obj(id));
        let always_2d = record
            .as_ref()
            .is_some_and(|r| self.is_always_2d(r.degrade));
        let shape = record.map(|r| {
            GfxShape::from_record(&r, &self.profile)
                .map(|shape| GfxShape { always_2d, ..shape })
                .map_err(|error| LoadError::Tree { id, error })
        });
        let shape = self.keep(shape);
        self.shapes.insert(id, shape.clone());
        shape
    }
}
