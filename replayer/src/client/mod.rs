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

use crate::packets::{self, PacketRun, Recording, Session};
use crate::simulation::{Simulation, SimulationError, Simulator};

/// Runs scenes with the client library. The worlds' files are opened once and shared.
#[derive(Debug)]
pub struct ClientSimulator {
    /// Folder whose subfolders are the worlds.
    worlds: PathBuf,
    /// Folder of the packet recordings that scenes name.
    packets: PathBuf,
    opened: Mutex<BTreeMap<String, Arc<DatSet>>>,
}

impl ClientSimulator {
    /// A simulator for the worlds in a folder. Packet recordings are looked for in the folder `packets` beside it.
    pub fn new(worlds: impl Into<PathBuf>) -> Self {
        let worlds = worlds.into();
        Self {
            packets: worlds.with_file_name(packets::AREA),
            worlds,
            opened: Mutex::default(),
        }
    }

    /// The session that a scene of the feature `packets` stands for: `packets/NAME.mcap`.
    fn session(&self, scene: &Scene) -> Result<Arc<Session>, SimulationError> {
        let name = scene.name.strip_prefix("packets/").unwrap_or(&scene.name);
        let path = self.packets.join(format!("{name}.mcap"));
        let found = Recording::open(&path).and_then(|r| Session::find(&r, None, &path));
        found.map(Arc::new).map_err(|error| SimulationError::Scene {
            scene: scene.name.clone(),
            reason: error.to_string(),
        })
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
        if scene.features.iter().any(|tag| tag == packets::FEATURE) {
            let session = self.session(scene)?;
            return Ok(Box::new(PacketRun::new(scene, session, source, profile)));
        }
        Ok(Box::new(SceneRun::new(scene, source, profile)?))
    }
}
