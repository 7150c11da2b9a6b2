//! The client library behind the seam of [`crate::simulation`].

use std::path::PathBuf;

use ac_client::profile::Profile;
use ac_golden_traces::Scene;

use crate::simulation::{Simulation, SimulationError, Simulator};

/// Starts the client library on the worlds of a folder.
#[derive(Debug)]
pub struct ClientSimulator {
    worlds: PathBuf,
}

impl ClientSimulator {
    /// `worlds` holds one folder per world, with `client_portal.dat` and `client_cell_1.dat`.
    pub fn new(worlds: PathBuf) -> Self {
        Self { worlds }
    }
}

impl Simulator for ClientSimulator {
    fn start(
        &self,
        scene: &Scene,
        _profile: &Profile,
    ) -> Result<Box<dyn Simulation>, SimulationError> {
        let folder = self.worlds.join(&scene.world);
        if !folder.is_dir() {
            return Err(SimulationError::World {
                world: scene.world.clone(),
                reason: format!(
                    "{} is no folder; name that of the worlds with --worlds",
                    folder.display()
                ),
            });
        }
        Err(SimulationError::Scene {
            scene: scene.name.clone(),
            reason: "the entity tick is not part of this build".into(),
        })
    }
}
