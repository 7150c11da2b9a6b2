//! A running scene as bytes: the [snapshot of its world](ac_client::snapshot) and what the scene itself remembers.
//!
//! The bytes are MessagePack with the names of the fields; numbers keep their bits. [`SCENE_VERSION`] counts the changes of the form here,
//! [`ac_client::snapshot::VERSION`] those of the world's.

use std::sync::Arc;

use ac_client::dat::DatSet;
use ac_client::physics::body::EntityId;
use ac_client::profile::Profile;
use ac_client::snapshot::{PipelineSnapshot, WorldSnapshot};
use ac_client::world::WorldSource;
use ac_golden_traces::Scene;
use serde::{Deserialize, Serialize};

use super::SceneRun;
use super::scene::SceneObject;
use crate::simulation::SimulationError;

/// Version of the form of a scene, the world apart.
pub const SCENE_VERSION: u32 = 1;

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneForm {
    pipeline: PipelineSnapshot,
    objects: Vec<ObjectForm>,
    next_step: u64,
    notes: Vec<String>,
    world: WorldSnapshot,
}

/// The newest object that was created under a GUID.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectForm {
    guid: u32,
    entity: u32,
    destroyed: bool,
}

fn bad(reason: impl ToString) -> SimulationError {
    SimulationError::Snapshot {
        reason: reason.to_string(),
    }
}

impl SceneRun {
    /// Everything that changes, as bytes.
    pub(super) fn take_snapshot(&self) -> Result<Vec<u8>, SimulationError> {
        let Self {
            world,
            pipeline,
            objects,
            next_step,
            notes,
            // Given again when the run goes on.
            scene: _,
            source: _,
            // A second run beside stage records, made when one is needed.
            companion: _,
        } = self;
        let objects = objects.iter().map(|(&guid, object)| {
            let SceneObject { id, destroyed } = *object;
            ObjectForm {
                guid,
                entity: id.0,
                destroyed,
            }
        });
        let form = SceneForm {
            pipeline: PipelineSnapshot::of(pipeline),
            objects: objects.collect(),
            next_step: *next_step as u64,
            notes: notes.clone(),
            world: WorldSnapshot::of(world).map_err(bad)?,
        };
        rmp_serde::to_vec_named(&form).map_err(bad)
    }

    /// Goes on from what [`SceneRun::take_snapshot`] has written.
    pub(super) fn resume(
        scene: &Scene,
        source: Arc<DatSet>,
        profile: &Profile,
        snapshot: &[u8],
    ) -> Result<Self, SimulationError> {
        let form = parse(snapshot)?;
        let map: Arc<dyn WorldSource> = Arc::clone(&source) as _;
        let world = form.world.restore(map, profile.clone()).map_err(bad)?;
        let objects = form.objects.into_iter().map(|object| {
            let ObjectForm {
                guid,
                entity,
                destroyed,
            } = object;
            let id = EntityId(entity);
            (guid, SceneObject { id, destroyed })
        });
        Ok(Self {
            world,
            pipeline: form.pipeline.restore(),
            objects: objects.collect(),
            next_step: usize::try_from(form.next_step).map_err(bad)?,
            notes: form.notes,
            scene: scene.clone(),
            source,
            companion: None,
        })
    }
}

fn parse(snapshot: &[u8]) -> Result<SceneForm, SimulationError> {
    let mut rest = snapshot;
    let mut reader = rmp_serde::Deserializer::new(&mut rest);
    let form = SceneForm::deserialize(&mut reader).map_err(bad)?;
    if !rest.is_empty() {
        return Err(bad(format!("{} bytes follow its end", rest.len())));
    }
    Ok(form)
}

/// The bytes of a snapshot as JSON, to be looked at. Not-a-number and infinities, which JSON does not have, become null.
///
/// # Errors
/// When they are no snapshot.
pub(crate) fn to_json(snapshot: &[u8]) -> Result<serde_json::Value, SimulationError> {
    serde_json::to_value(parse(snapshot)?).map_err(bad)
}
