//! The planner: what of a scene can be left out, and why.

use std::collections::{BTreeMap, BTreeSet};

use super::bounds::{Bounds, Travel, blocks_around};
use super::index::WorldIndex;
use super::{LatentPlace, Omission, PLAN_SCHEMA, Part, Plan};
use crate::math::{CellId, Position, Vec3};
use crate::physics::state::PhysicsState;
use crate::profile::{LastKnownCell, Profile};
use crate::world::WorldSource;
use crate::world::window::LandscapeWindow;

/// An entity of a scene, as far as a plan must know it.
#[derive(Debug, Clone, PartialEq)]
pub struct EntityOutline {
    /// Its GUID.
    pub guid: u32,
    /// Id of its setup.
    pub setup: u32,
    /// Id of its motion table; 0 for none.
    pub motion_table: u32,
    /// Where it enters the world.
    pub position: Position,
    /// State word.
    pub state: PhysicsState,
    /// m/s, world axes.
    pub velocity: Vec3,
    /// rad/s, world axes.
    pub omega: Vec3,
    /// Scale.
    pub scale: f32,
    /// What the run-rate callback answers.
    pub run_rate: f32,
    /// It is no player, creature or missile.
    pub is_object: bool,
    /// Its states are wanted.
    pub tracked: bool,
    /// A script step names it, as the one who acts or as target, or it is created by one, or has a parent.
    pub acts: bool,
    /// It is, or may become, somebody's parent.
    pub carries: bool,
    /// Some script step may set its state word.
    pub state_changes: bool,
    /// Another entity has the same GUID.
    pub duplicate: bool,
}

/// What of a scene is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Outputs {
    /// Checkpoints of every stage of every entity's tick.
    pub checkpoints: bool,
}

/// A scene, as far as a plan must know it.
#[derive(Debug, Clone, Default)]
pub struct SceneOutline {
    /// Name of the scene.
    pub name: String,
    /// Entities in the order of their creation.
    pub entities: Vec<EntityOutline>,
    /// Where script steps put entities or send them: GUID and place.
    pub places: Vec<(u32, Position)>,
    /// Largest speed that a script step asks for.
    pub rate: f32,
    /// Length of the scene, s.
    pub duration: f64,
    /// GUID of the entity that the window of landblocks follows.
    pub load_point: Option<u32>,
    /// What is wanted.
    pub outputs: Outputs,
}

impl SceneOutline {
    /// The last entity that no step names: it is always created in its turn, and all whose creation can wait come before it.
    pub fn anchor(&self) -> Option<u32> {
        self.entities.iter().rfind(|e| !e.acts).map(|e| e.guid)
    }

    fn load_point_entity(&self) -> Option<&EntityOutline> {
        let guid = self.load_point?;
        self.entities.iter().find(|e| e.guid == guid)
    }

    /// Blocks of the window around the load point at the start.
    fn window(&self) -> Vec<CellId> {
        let mut window = LandscapeWindow::default();
        self.load_point_entity()
            .map(|e| window.update_load_point(e.position.cell).enter)
            .unwrap_or_default()
    }
}

impl Plan {
    /// What can be left out of a scene without a change in any wanted bit. `index` is that of the world and the profile.
    ///
    /// Without `survey`, the lists of landblocks and rooms, which only inform, are left empty: then no record is opened but setups and
    /// shapes of entities that might be put off.
    pub fn auto(
        scene: &SceneOutline,
        source: &dyn WorldSource,
        index: &WorldIndex,
        profile: &Profile,
        survey: bool,
    ) -> Self {
        let mut planner = Planner {
            scene,
            index,
            profile,
            bounds: Bounds::new(source),
            source,
            left_out: Vec::new(),
        };
        planner.stages();
        if survey {
            planner.landblocks();
        }
        planner.statics();
        planner.entities();
        planner.ticks();
        planner.poses();
        Self {
            schema: PLAN_SCHEMA.into(),
            scene: scene.name.clone(),
            left_out: planner.left_out,
        }
    }
}

impl SceneOutline {
    /// Places of the entities whose creation a plan puts off, by GUID. One that cannot be bounded, which only a forced plan names, has its
    /// own block.
    pub fn latent_places(
        &self,
        plan: &Plan,
        source: &dyn WorldSource,
    ) -> BTreeMap<u32, LatentPlace> {
        let mut bounds = Bounds::new(source);
        let omitted = plan.ids(Part::Entities);
        let late = self
            .entities
            .iter()
            .filter(|e| omitted.binary_search(&e.guid).is_ok());
        let place = |entity: &EntityOutline| {
            let own = || LatentPlace {
                guid: entity.guid,
                blocks: BTreeSet::from([entity.position.cell.block()]),
            };
            (entity.guid, bounds.latent_place(entity).unwrap_or_else(own))
        };
        late.map(place).collect()
    }
}

impl Bounds<'_> {
    fn latent_place(&mut self, entity: &EntityOutline) -> Option<LatentPlace> {
        let distance = self.touch(entity)?;
        Some(LatentPlace {
            guid: entity.guid,
            blocks: blocks_around(&entity.position, distance).collect(),
        })
    }
}

struct Planner<'a> {
    scene: &'a SceneOutline,
    index: &'a WorldIndex,
    profile: &'a Profile,
    bounds: Bounds<'a>,
    source: &'a dyn WorldSource,
    left_out: Vec<Omission>,
}

impl Planner<'_> {
    fn add(&mut self, part: Part, ids: impl IntoIterator<Item = u32>, because: &str, source: &str) {
        let mut ids: Vec<u32> = ids.into_iter().collect();
        ids.sort_unstable();
        ids.dedup();
        if part.has_ids() && ids.is_empty() {
            return;
        }
        self.left_out.push(Omission {
            part,
            ids,
            because: because.into(),
            source: source.into(),
        });
    }

    fn stages(&mut self) {
        self.add(
            Part::Network,
            [],
            "the script's steps stand for the messages",
            "spec/09-network.md, 18; spec/10-messages.md, 17",
        );
        self.add(
            Part::Streaming,
            [],
            "no result depends on the window: a block or room is loaded, with all that reaches into it, when a lookup first meets it",
            "spec/02-terrain.md, 22; spec/03-cells.md, 19.3",
        );
        self.add(
            Part::Render,
            [],
            "no picture is wanted: surfaces, textures, palettes and detail levels are never opened",
            "spec/12-rendering.md, 25; spec/11-dat-files.md, 17",
        );
        self.add(
            Part::Lighting,
            [],
            "no physics value depends on light",
            "spec/02-terrain.md, 22",
        );
        self.add(
            Part::Plugin,
            [],
            "a scene loads no plugin",
            "spec/00-overview.md, 3",
        );
        self.add(
            Part::CosmeticHooks,
            [],
            "only their type is recorded; hooks that change state, scale or rotation, and AnimationDone, run",
            "spec/07-animation.md, 17; spec/06-physics-object.md, H5",
        );
    }

    /// What every entity can reach.
    fn travels(&mut self) -> Vec<Travel> {
        let (scene, rate) = (self.scene, self.scene.rate);
        let travel = |entity: &EntityOutline| {
            let given = scene.places.iter().filter(|(guid, _)| *guid == entity.guid);
            let mut places = vec![entity.position];
            places.extend(given.map(|(_, place)| *place));
            let touch = self.bounds.touch(entity).unwrap_or(192.0);
            let speed = self.bounds.top_speed(entity, rate);
            Travel {
                places,
                distance: speed * scene.duration as f32 + touch,
            }
        };
        scene.entities.iter().map(travel).collect()
    }

    fn landblocks(&mut self) {
        let reached: BTreeSet<u16> = self.travels().iter().flat_map(Travel::blocks).collect();
        let with_groups: BTreeSet<u16> = reached
            .iter()
            .flat_map(|&block| self.group_of_block(block))
            .collect();
        let beyond: Vec<CellId> = self
            .scene
            .window()
            .into_iter()
            .filter(|block| !with_groups.contains(&block.block()))
            .filter(|block| self.source.has_cell_record(block.0))
            .collect();
        let rooms: Vec<u32> = beyond
            .iter()
            .filter(|b| self.has_rooms(**b))
            .map(|b| b.0)
            .collect();
        self.add(
            Part::Landblocks,
            beyond.iter().map(|block| block.0),
            "farther from every place than the fastest entity gets in the scene's time, and no static object there reaches into a nearer block",
            "spec/02-terrain.md, 22; spec/11-dat-files.md, 17",
        );
        self.add(
            Part::Rooms,
            rooms,
            "in landblocks that nobody reaches: no portal leads there from a room or building that is reached",
            "spec/03-cells.md, 19.3; spec/11-dat-files.md, 17",
        );
    }

    /// The block and those it shares static objects with.
    fn group_of_block(&self, block: u16) -> Vec<u16> {
        let group = self.index.group(u32::from(block) << 16 | 0xFFFF);
        let mut blocks = vec![block];
        blocks.extend(group.unwrap_or_default().iter().map(|&m| CellId(m).block()));
        blocks
    }

    fn has_rooms(&self, block: CellId) -> bool {
        let info = self.source.landblock_info(block).ok().flatten();
        info.is_some_and(|info| info.room_count > 0)
    }

    fn statics(&mut self) {
        let region = self.source.region();
        let barren = region.is_none_or(|r| r.scene_types.iter().all(|t| t.scenes.is_empty()));
        if !self.profile.scenery || barren {
            let because = if barren {
                "every scene list of the world is empty"
            } else {
                "the profile has no scenery"
            };
            self.add(Part::Scenery, [], because, "spec/02-terrain.md, 22");
        }
        self.add(
            Part::Water,
            [],
            "of blocks without a vertex of types 16 to 20: all depths are 0",
            "spec/02-terrain.md, 22",
        );
        self.add(
            Part::StaticAnimations,
            [],
            "of objects without a physics tree whose hooks change nothing: they are only drawn",
            "spec/07-animation.md, 17",
        );
    }

    /// Entities whose creation can wait.
    fn entities(&mut self) {
        let remembers = self.profile.left_fields_from_slot
            || self.profile.last_known_cell == LastKnownCell::StaleSlot;
        if self.scene.outputs.checkpoints || remembers {
            // T-14, T-25: a placement leaves something behind that the next transition of anybody finds.
            return;
        }
        let last = self.scene.anchor();
        let scene = self.scene;
        let ids: Vec<u32> = scene
            .entities
            .iter()
            .filter(|e| Some(e.guid) != last && self.can_wait(e))
            .map(|e| e.guid)
            .collect();
        self.add(
            Part::Entities,
            ids,
            "nothing moves them and no step names them; they are created when somebody comes into their landblock",
            "spec/06-physics-object.md, H5; spec/08-motion.md, 19",
        );
    }

    fn can_wait(&mut self, entity: &EntityOutline) -> bool {
        let alone =
            !entity.tracked && !entity.carries && !entity.duplicate && !entity.state_changes;
        let cell = entity.position.cell;
        let outdoors = !cell.is_indoor() && cell.block_coord().is_some();
        let is_static = entity.state.contains(PhysicsState::STATIC);
        let sound = alone && outdoors && !is_static && entity.is_object && entity.stays();
        let place = sound.then(|| self.bounds.latent_place(entity)).flatten();
        place.is_some_and(|place| !self.wakes_animations(&place))
    }

    /// Whether the entity's creation, which loads its blocks, starts an animation there that no window starts.
    fn wakes_animations(&self, place: &LatentPlace) -> bool {
        let window = self.scene.window();
        let animated = self
            .index
            .animated()
            .iter()
            .map(|&member| CellId(member).block());
        let outside: BTreeSet<u16> = animated
            .filter(|&block| !window.iter().any(|b| b.block() == block))
            .collect();
        if outside.is_empty() {
            return false;
        }
        let touched = |&block: &u16| {
            let near = self.group_of_block(block);
            near.iter().any(|block| outside.contains(block))
        };
        place.blocks.iter().any(touched)
    }

    fn ticks(&mut self) {
        if self.scene.outputs.checkpoints {
            return;
        }
        let scene = self.scene;
        let idle = scene.entities.iter().filter(|e| !e.tracked && !e.duplicate);
        self.add(
            Part::IdleTicks,
            idle.map(|e| e.guid),
            "while they stand, play no root motion and no hook that changes state: the ticks run when somebody takes hold of them",
            "spec/07-animation.md, 17; spec/06-physics-object.md, H5",
        );
    }

    fn poses(&mut self) {
        if self.scene.outputs.checkpoints {
            return;
        }
        let scene = self.scene;
        let unseen = scene
            .entities
            .iter()
            .filter(|e| !e.carries && !e.duplicate && !e.state_changes);
        let ids: Vec<u32> = unseen.map(|e| e.guid).collect();
        self.add(
            Part::Poses,
            ids,
            "unless a part has a physics tree: no child is attached to a part, nothing is drawn, and the pose never feeds back",
            "spec/07-animation.md, 17",
        );
    }
}
