//! From a scene to its plan: what the planner has to know of it, and the index of its world.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ac_client::dat::DatSet;
use ac_client::frame::Plan;
use ac_client::frame::plan::{EntityOutline, Outputs, PlanError, SceneOutline, WorldIndex};
use ac_client::math::{Position, Vec3};
use ac_client::physics::state::PhysicsState;
use ac_client::profile::Profile;
use ac_client::world::WorldSource;
use ac_golden_traces::Scene;
use ac_golden_traces::scene::{Action, EntityKind, EntitySpec, MoveParams};

use super::entity::position;

/// How much of a scene's work is done.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum PlanChoice {
    /// Records are opened when they are first asked for, as the oracles do; every entity is advanced in every frame.
    #[default]
    OnDemand,
    /// Everything that a client does: the window of landblocks around the first tracked entity is loaded, with all rooms, and moves with it.
    Full,
    /// What the planner cannot show to be without effect.
    Auto,
    /// A plan that somebody wrote.
    Given {
        /// The plan.
        plan: Arc<Plan>,
        /// It is carried out even if it leaves out what may change results.
        forced: bool,
    },
}

/// Why a plan file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PlanFileError {
    /// It cannot be read.
    #[error("cannot read the plan {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is no plan.
    #[error("{} is no plan: {reason}\nwrite one with `ac-replay plan SCENE --format toml`", path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// What is wrong, where.
        reason: String,
    },
    /// Something in it is wrong.
    #[error("{}: {source}", path.display())]
    Plan {
        /// The file.
        path: PathBuf,
        /// What.
        source: PlanError,
    },
}

impl PlanChoice {
    /// The choice of a command line: `full`, `auto`, or the path of a plan (`*.json`, else TOML); nothing is [`PlanChoice::OnDemand`].
    ///
    /// # Errors
    /// When the file is no plan.
    pub fn parse(text: Option<&str>, forced: bool) -> Result<Self, PlanFileError> {
        let path = match text {
            None => return Ok(Self::OnDemand),
            Some("full") => return Ok(Self::Full),
            Some("auto") => return Ok(Self::Auto),
            Some(path) => PathBuf::from(path),
        };
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(source) => return Err(PlanFileError::Io { path, source }),
        };
        let plan: Result<Plan, String> = if path.extension().is_some_and(|e| e == "json") {
            serde_json::from_str(&text).map_err(|error| error.to_string())
        } else {
            toml::from_str(&text).map_err(|error| error.to_string())
        };
        let plan = match plan {
            Ok(plan) => plan,
            Err(reason) => return Err(PlanFileError::Text { path, reason }),
        };
        match plan.checked() {
            Ok(plan) => Ok(Self::Given {
                plan: Arc::new(plan),
                forced,
            }),
            Err(source) => Err(PlanFileError::Plan { path, source }),
        }
    }

    /// The plan for a scene; `None` for [`PlanChoice::OnDemand`].
    ///
    /// # Errors
    /// A given plan that leaves out what may change results, unless it is forced.
    pub fn plan_for(
        &self,
        scene: &SceneOutline,
        source: &DatSet,
        index: &WorldIndex,
        profile: &Profile,
    ) -> Result<Option<Arc<Plan>>, PlanError> {
        let auto = || Plan::auto(scene, source, index, profile, false);
        Ok(match self {
            Self::OnDemand => None,
            Self::Full => Some(Arc::new(Plan::full())),
            Self::Auto => Some(Arc::new(auto())),
            Self::Given { plan, forced } => {
                if !forced {
                    if !plan.scene.is_empty() && plan.scene != scene.name {
                        return Err(PlanError::OtherScene(plan.scene.clone()));
                    }
                    plan.check_against(&auto())?;
                }
                Some(Arc::clone(plan))
            }
        })
    }
}

/// What a planner has to know of a scene.
pub fn outline(scene: &Scene, outputs: Outputs) -> SceneOutline {
    let mut outline = SceneOutline {
        name: scene.name.clone(),
        entities: Vec::new(),
        places: Vec::new(),
        rate: 1.0,
        duration: scene
            .frames
            .iter()
            .map(|run| run.dt * f64::from(run.count))
            .sum(),
        load_point: scene
            .track
            .first()
            .or_else(|| scene.entities.first().map(|e| &e.guid))
            .copied(),
        outputs,
    };
    let created = scene.script.iter().filter_map(|step| match &step.action {
        Action::Create { entity } => Some(entity),
        _ => None,
    });
    let named = Named::of(scene);
    let mut counts: BTreeMap<u32, u32> = BTreeMap::new();
    for spec in scene.entities.iter().chain(created) {
        *counts.entry(spec.guid).or_default() += 1;
        outline.entities.push(entity(spec, scene, &named));
    }
    for entity in &mut outline.entities {
        entity.duplicate = counts.get(&entity.guid).is_some_and(|&count| count > 1);
    }
    for step in &scene.script {
        let (place, rate) = place_and_rate(&step.action);
        outline.places.extend(place.map(|place| (step.guid, place)));
        outline.rate = outline.rate.max(rate.abs());
    }
    outline
}

/// GUIDs by what the script does with them.
#[derive(Default)]
struct Named {
    acts: Vec<u32>,
    carries: Vec<u32>,
    state_changes: Vec<u32>,
}

impl Named {
    fn of(scene: &Scene) -> Self {
        let mut named = Self::default();
        named
            .carries
            .extend(scene.entities.iter().filter_map(|e| e.parent));
        for step in &scene.script {
            named.acts.push(step.guid);
            match &step.action {
                Action::SetParent { parent, .. } => named.carries.push(*parent),
                Action::Create { entity } => named.carries.extend(entity.parent),
                Action::SetState { .. } => named.state_changes.push(step.guid),
                Action::MoveToObject { target, .. }
                | Action::TurnToObject { target, .. }
                | Action::StickTo { target, .. } => named.acts.push(*target),
                _ => {}
            }
        }
        named.acts.extend(&named.carries);
        for list in [
            &mut named.acts,
            &mut named.carries,
            &mut named.state_changes,
        ] {
            list.sort_unstable();
        }
        named
    }
}

fn entity(spec: &EntitySpec, scene: &Scene, named: &Named) -> EntityOutline {
    let is = |list: &[u32]| list.binary_search(&spec.guid).is_ok();
    EntityOutline {
        guid: spec.guid,
        setup: spec.setup,
        motion_table: spec.motion_table,
        position: position(&spec.position),
        state: PhysicsState::from_bits_retain(spec.state),
        velocity: Vec3::from(spec.velocity),
        omega: Vec3::from(spec.omega),
        scale: spec.scale,
        run_rate: spec.run_rate,
        is_object: spec.kind == EntityKind::Object,
        tracked: scene.track.contains(&spec.guid),
        acts: is(&named.acts) || spec.parent.is_some(),
        carries: is(&named.carries),
        state_changes: is(&named.state_changes)
            || PhysicsState::from_bits_retain(spec.state).contains(PhysicsState::HAS_PHYSICS_BSP),
        duplicate: false,
    }
}

/// Where a step sends its entity, and the speed it asks for.
fn place_and_rate(action: &Action) -> (Option<Position>, f32) {
    let of = |params: &MoveParams| params.speed.unwrap_or(1.0);
    match action {
        Action::SetPosition { position: to, .. }
        | Action::InterpolateTo { position: to, .. }
        | Action::ConstrainTo { position: to, .. } => (Some(position(to)), 1.0),
        Action::MoveToPosition {
            position: to,
            params,
        } => (Some(position(to)), of(params)),
        Action::MoveToObject { params, .. }
        | Action::TurnToHeading { params, .. }
        | Action::TurnToObject { params, .. } => (None, of(params)),
        Action::DoMotion { speed, .. } | Action::DoInterpretedMotion { speed, .. } => {
            (None, *speed)
        }
        _ => (None, 1.0),
    }
}

/// Name of an index's file in the folder of its world.
pub fn index_file(profile: &str) -> String {
    format!("plan-index.{profile}.json")
}

/// What tells the files of a world from others without reading them: their sizes and times of change.
pub fn identity(folder: &Path) -> Option<String> {
    let file = |name: &str| {
        let about = std::fs::metadata(folder.join(name)).ok()?;
        let changed = about
            .modified()
            .ok()?
            .duration_since(std::time::UNIX_EPOCH)
            .ok()?;
        Some(format!("{name}:{}:{}", about.len(), changed.as_nanos()))
    };
    Some(format!(
        "{} {}",
        file(ac_client::dat::CELL_FILE)?,
        file(ac_client::dat::PORTAL_FILE)?
    ))
}

/// The stored index of a world, if there is one for these files and this profile.
pub fn stored_index(folder: &Path, profile: &str) -> Option<WorldIndex> {
    let text = std::fs::read(folder.join(index_file(profile))).ok()?;
    let index = WorldIndex::from_json(&text).ok()?;
    let fits = index.profile == profile && Some(&index.world) == identity(folder).as_ref();
    fits.then_some(index)
}

/// Measures the index of opened files. They are read from beginning to end.
///
/// # Errors
/// When the directory of the cell file cannot be read.
pub fn measure_index(
    set: &Arc<DatSet>,
    profile: &Profile,
) -> Result<WorldIndex, ac_client::dat::DatError> {
    let ids = set.cell().ids()?;
    let source: Arc<dyn WorldSource> = Arc::clone(set) as _;
    Ok(WorldIndex::measure(&source, profile, ids))
}
