//! Plans: what a run leaves out because no result needs it.
//!
//! A client brings in every landblock around its player and advances every object in every frame. A scene asks for the states of a few
//! entities, and most of that work cannot change a bit of them. A [`Plan`] lists what is left out, why, and by which rule of the
//! specification. It is plain data: made by [`Plan::auto`] from the world, the entities, the script and the wanted outputs, or written by a
//! person; [`Plan::full`] leaves nothing out.
//!
//! Nothing is left out for good. What a plan leaves out is *put off* until somebody needs it, and then made up for before the one who
//! needs it can see a difference: a block is loaded with its [group](WorldIndex) when a lookup first meets it, an object is created when its
//! block is loaded, an idle object plays the frames it missed when somebody takes hold of it. So a spawn, a teleport or a fall out of the
//! region that the planner had in mind costs time, never a result. [`ActivePlan`] is the state of a plan while it is carried out.
//!
//! Source: the sections "What a scene can leave out" of `spec/01` to `spec/12`.

mod active;
mod auto;
mod bounds;
mod hex;
mod idle;
mod index;

use serde::{Deserialize, Serialize};

pub use active::{ActivePlan, Extended, Latent, LatentPlace};
pub use auto::{EntityOutline, Outputs, SceneOutline};
pub use bounds::Travel;
pub use index::{INDEX_SCHEMA, WorldIndex};

/// Schema of a plan.
pub const PLAN_SCHEMA: &str = "ac-plan/1";

/// A part of the work that can be left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Part {
    /// The network stage of the frame.
    Network,
    /// The streaming stage of the frame: the window of landblocks around the load point.
    Streaming,
    /// The render stage of the frame, and every record that only drawing opens.
    Render,
    /// The plugin stage of the frame.
    Plugin,
    /// Landblocks, ids 0xXXYYFFFF: their terrain, static objects and scenery.
    Landblocks,
    /// Indoor cells of landblocks, ids 0xXXYYFFFF: the cells, their portals and static objects.
    Rooms,
    /// Scenery: what the scene tables grow.
    Scenery,
    /// Depth of water.
    Water,
    /// Lights.
    Lighting,
    /// Animation of static objects that are only drawn.
    StaticAnimations,
    /// Animation hooks that only draw or sound.
    CosmeticHooks,
    /// Entities, by GUID, until their surroundings are needed.
    Entities,
    /// Ticks of entities, by GUID, while they stand idle.
    IdleTicks,
    /// Places of the parts of entities, by GUID.
    Poses,
}

impl Part {
    /// Whether the omission is a list: of ids or GUIDs.
    pub const fn has_ids(self) -> bool {
        matches!(
            self,
            Self::Landblocks | Self::Rooms | Self::Entities | Self::IdleTicks | Self::Poses
        )
    }

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Network => "network",
            Self::Streaming => "streaming",
            Self::Render => "render",
            Self::Plugin => "plugin",
            Self::Landblocks => "landblocks",
            Self::Rooms => "rooms",
            Self::Scenery => "scenery",
            Self::Water => "water",
            Self::Lighting => "lighting",
            Self::StaticAnimations => "static-animations",
            Self::CosmeticHooks => "cosmetic-hooks",
            Self::Entities => "entities",
            Self::IdleTicks => "idle-ticks",
            Self::Poses => "poses",
        }
    }
}

/// One thing that is left out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Omission {
    /// What.
    pub part: Part,
    /// Which, for parts that are lists; in ascending order.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "hex::list")]
    pub ids: Vec<u32>,
    /// Why no result needs it.
    #[serde(default)]
    pub because: String,
    /// The rule: place in the specification.
    #[serde(default)]
    pub source: String,
}

/// What a run leaves out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// [`PLAN_SCHEMA`].
    pub schema: String,
    /// Name of the scene it was made for.
    #[serde(default)]
    pub scene: String,
    /// What is left out, each part at most once.
    #[serde(default)]
    pub left_out: Vec<Omission>,
}

/// A plan leaves out something that its planner cannot show to be without effect.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// The schema is another.
    #[error("schema `{0}`, this version reads {PLAN_SCHEMA}")]
    Schema(String),
    /// It was made for another scene.
    #[error("it was made for scene `{0}`")]
    OtherScene(String),
    /// A part is named twice.
    #[error("left_out: `{}` stands there twice", .0.name())]
    Twice(Part),
    /// A part that may not be left out of this scene.
    #[error("left_out, `{}`: this part of the scene can change results", .0.name())]
    Part(Part),
    /// A member of a part that may not be left out of this scene.
    #[error("left_out, `{}`: {id:#010X} can change results", part.name())]
    Id {
        /// The part.
        part: Part,
        /// The member.
        id: u32,
    },
}

impl Plan {
    /// The plan that leaves nothing out.
    pub fn full() -> Self {
        Self {
            schema: PLAN_SCHEMA.into(),
            scene: String::new(),
            left_out: Vec::new(),
        }
    }

    /// Whether a part is left out, in whole or for some ids.
    pub fn leaves_out(&self, part: Part) -> bool {
        self.omission(part).is_some()
    }

    /// The ids of a part that are left out, ascending.
    pub fn ids(&self, part: Part) -> &[u32] {
        self.omission(part).map_or(&[], |o| &o.ids)
    }

    fn omission(&self, part: Part) -> Option<&Omission> {
        self.left_out.iter().find(|o| o.part == part)
    }

    /// Sorts what must be sorted, and checks what needs no world: schema, no part twice.
    ///
    /// # Errors
    /// [`PlanError::Schema`] and [`PlanError::Twice`].
    pub fn checked(mut self) -> Result<Self, PlanError> {
        if self.schema != PLAN_SCHEMA {
            return Err(PlanError::Schema(self.schema));
        }
        for omission in &mut self.left_out {
            omission.ids.sort_unstable();
            omission.ids.dedup();
        }
        for (at, Omission { part, .. }) in self.left_out.iter().enumerate() {
            if self.left_out[..at].iter().any(|o| o.part == *part) {
                return Err(PlanError::Twice(*part));
            }
        }
        Ok(self)
    }

    /// Checks that everything this plan leaves out may be left out, as far as `proven`, the planner's own plan of the same scene, can show.
    /// Landblocks and rooms always may: they are loaded when something meets them.
    ///
    /// # Errors
    /// The first entry that `proven` does not leave out.
    pub fn check_against(&self, proven: &Self) -> Result<(), PlanError> {
        for omission in &self.left_out {
            let part = omission.part;
            if matches!(part, Part::Landblocks | Part::Rooms | Part::Streaming) {
                continue;
            }
            if part.has_ids() {
                let allowed = proven.ids(part);
                let refused = omission
                    .ids
                    .iter()
                    .find(|id| allowed.binary_search(id).is_err());
                if let Some(&id) = refused {
                    return Err(PlanError::Id { part, id });
                }
            } else if !proven.leaves_out(part) {
                return Err(PlanError::Part(part));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
