//! The client library behind the [seam](crate::simulation): worlds from dat files, scenes run frame by frame.

mod entity;
mod scene;
mod script;
mod stages;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use ac_client::dat::{DatSet, Strictness};
use ac_client::profile::Profile;
use ac_golden_traces::Scene;

pub use scene::SceneRun;
pub use script::params as move_parameters;

use crate::simulation::{Simulation, SimulationError, Simulator};

/// Runs scenes with the client library. The worlds' files are opened once and shared.
#[derive(Debug)]
pub struct ClientSimulator {
    /// Folder whose subfolders are the worlds.
    worlds: PathBuf,
    opened: Mutex<BTreeMap<String, Arc<DatSet>>>,
}

impl ClientSimulator {
    /// A simulator for the worlds in a folder.
    pub fn new(worlds: impl Into<PathBuf>) -> Self {
        Self {
            worlds: worlds.into(),
            opened: Mutex::default(),
        }
    }

    /// The dat files of a world.
    ///
    /// # Errors
    /// When they cannot be opened.
    pub fn world(&self, name: &str) -> Result<Arc<DatSet>, SimulationError> {
        let mut opened = self.opened.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(set) = opened.get(name) {
            return Ok(Arc::clone(set));
        }
        let set = DatSet::open(self.worlds.join(name), Strictness::Lenient).map_err(|error| {
            SimulationError::World {
                world: name.to_owned(),
                reason: error.to_string(),
            }
        })?;
        let set = Arc::new(set);
        opened.insert(name.to_owned(), Arc::clone(&set));
        Ok(set)
    }
}

impl Simulator for ClientSimulator {
    fn start(
        &self,
        scene: &Scene,
        profile: &Profile,
    ) -> Result<Box<dyn Simulation>, SimulationError> {
        let source = self.world(&scene.world)?;
        Ok(Box::new(SceneRun::new(scene, source, profile)?))
    }
}
