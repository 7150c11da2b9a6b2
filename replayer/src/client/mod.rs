//! The client library behind the [seam](crate::simulation): worlds from dat files, scenes run frame by frame.

mod entity;
pub mod planning;
mod scene;
mod script;
mod snapshot;
mod stages;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use ac_client::dat::{DatSet, Strictness};
use ac_client::frame::plan::{Outputs, WorldIndex};
use ac_client::profile::Profile;
use ac_golden_traces::Scene;

pub use planning::PlanChoice;
pub use scene::{ScenePlan, SceneRun};
pub use script::params as move_parameters;
pub use snapshot::SCENE_VERSION;
pub(crate) use snapshot::to_json as snapshot_to_json;

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
    plan: PlanChoice,
    outputs: Outputs,
    /// By world and profile.
    indexes: Mutex<BTreeMap<(String, String), Arc<WorldIndex>>>,
}

impl ClientSimulator {
    /// A simulator for the worlds in a folder. Packet recordings are looked for in the folder `packets` beside it.
    pub fn new(worlds: impl Into<PathBuf>) -> Self {
        let worlds = worlds.into();
        Self {
            packets: worlds.with_file_name(packets::AREA),
            worlds,
            opened: Mutex::default(),
            plan: PlanChoice::default(),
            outputs: Outputs::default(),
            indexes: Mutex::default(),
        }
    }

    /// How much of a scene's work is done, for scenes that are started from now on.
    #[must_use]
    pub fn with_plan(self, plan: PlanChoice) -> Self {
        Self { plan, ..self }
    }

    /// What is wanted of scenes beside their states: no plan leaves it out.
    #[must_use]
    pub fn with_outputs(self, outputs: Outputs) -> Self {
        Self { outputs, ..self }
    }

    /// What belongs together in a world under a profile: from the file beside its dat files, else measured once.
    ///
    /// # Errors
    /// When the dat files cannot be opened or their directory cannot be read.
    pub fn index(&self, name: &str, profile: &Profile) -> Result<Arc<WorldIndex>, SimulationError> {
        let profile_name = profile_key(profile);
        let key = (name.to_owned(), profile_name);
        // Kept locked meanwhile: others would measure the same.
        let mut indexes = self.indexes.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(index) = indexes.get(&key) {
            return Ok(Arc::clone(index));
        }
        let stored = planning::stored_index(&self.worlds.join(name), &key.1);
        let index = match stored {
            Some(index) => index,
            None => planning::measure_index(&self.world(name)?, profile).map_err(|error| {
                SimulationError::World {
                    world: name.to_owned(),
                    reason: error.to_string(),
                }
            })?,
        };
        let index = Arc::new(index);
        indexes.insert(key, Arc::clone(&index));
        Ok(index)
    }

    /// Starts a scene under the chosen plan, as [`Simulator::start`] does.
    ///
    /// # Errors
    /// As [`Simulator::start`]; a given plan that leaves out what may change results.
    pub fn run(&self, scene: &Scene, profile: &Profile) -> Result<SceneRun, SimulationError> {
        let source = self.world(&scene.world)?;
        if self.plan == PlanChoice::OnDemand {
            return SceneRun::new(scene, source, profile);
        }
        let index = self.index(&scene.world, profile)?;
        let outline = planning::outline(scene, self.outputs);
        let plan = self
            .plan
            .plan_for(&outline, source.as_ref(), &index, profile);
        let plan = plan.map_err(|reason| SimulationError::Plan {
            scene: scene.name.clone(),
            reason,
        })?;
        let plan = plan.map(|plan| ScenePlan {
            plan,
            index,
            outline,
        });
        SceneRun::planned(scene, source, profile, plan)
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
        if packets::drive(scene) {
            let source = self.world(&scene.world)?;
            let session = self.session(scene)?;
            return Ok(Box::new(PacketRun::new(scene, session, source, profile)));
        }
        Ok(Box::new(self.run(scene, profile)?))
    }

    fn resume(
        &self,
        scene: &Scene,
        profile: &Profile,
        snapshot: &[u8],
    ) -> Result<Box<dyn Simulation>, SimulationError> {
        if packets::drive(scene) {
            return Err(SimulationError::Snapshot {
                reason: "a replay of packets takes no snapshots: start it at its first frame"
                    .into(),
            });
        }
        let source = self.world(&scene.world)?;
        Ok(Box::new(SceneRun::resume(
            scene, source, profile, snapshot,
        )?))
    }
}

/// The name of a profile; all of it if it has none.
fn profile_key(profile: &Profile) -> String {
    let known = |name: &&&str| Profile::named(name).is_some_and(|p| p == *profile);
    let name = Profile::NAMES.iter().find(known);
    name.map_or_else(|| format!("{profile:?}"), |name| (*name).to_owned())
}
