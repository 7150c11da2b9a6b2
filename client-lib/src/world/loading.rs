//! Loading blocks and indoor cells with their static objects, in the order in which they are first needed
//! (`spec/02-terrain.md`, 12; `spec/03-cells.md`, 7 and 14).
//!
//! Placing a static object asks for the cells it reaches, and some of those may have to be loaded first, with their own static objects. The
//! references do that by recursion; here a stack of tasks does the same in the same order, so that no file can exhaust the call stack.

use std::sync::Arc;

use super::cell::{BuildingPortal, CellBase, CellPortal, EnvCell, LandCell, PortalTarget};
use super::landscape::{Demand, LandBlock, Landscape, Missing};
use super::room_volume::RoomVolume;
use super::statics::{StaticKind, StaticObject, frame_of};
use super::terrain::scenery::{SceneryPlacement, scenery};
use super::terrain::{CELLS, TerrainBlock, TerrainVertices};
use super::{CellHandle, World};
use crate::dat;
use crate::math::{BLOCK_LENGTH, CellId, Frame, Plane, Position, Vec3};
use crate::physics::body::{ObjectRef, StaticId};
use crate::physics::collision::CellShape;
use crate::physics::state::PhysicsState;
use crate::physics::transition::CellArray;
use crate::profile::{EnvCellStatics, Profile};

/// Part of a loading that is under way.
enum Task {
    /// Static objects of a block: those of the info record, then scenery.
    Block(BlockTask),
    /// Indoor cells visible from one, which are loaded before its own static objects (`C-33`).
    Connected { cell: CellHandle, next: usize },
    /// Static objects of an indoor cell.
    Room {
        cell: CellHandle,
        next: usize,
        pending: Option<Pending>,
    },
}

struct BlockTask {
    block: CellId,
    next: usize,
    /// Made when the objects of the info record are done.
    scenery: Option<Vec<SceneryPlacement>>,
    pending: Option<Pending>,
}

/// A static object that is in its cell but has no shadows yet.
struct Pending {
    object: StaticId,
    /// Scale to be set afterwards.
    scale: Option<f32>,
}

/// How a task goes on.
enum Step {
    Again,
    Done,
    Needs(Demand),
}

impl World {
    /// Cell of an id, loaded if necessary with what it brings along; `None` if there is none.
    pub fn visible_cell(&mut self, id: CellId) -> Option<CellHandle> {
        self.with_loading(|land, _, missing| land.visible(id, false, missing))
    }

    /// Runs a read-only computation, again and again, until nothing it looks up has to be loaded.
    pub fn with_loading<T>(
        &mut self,
        mut compute: impl FnMut(&Landscape, &Profile, &mut Missing) -> T,
    ) -> T {
        loop {
            let mut missing = Missing::default();
            let result = compute(&self.land, &self.profile, &mut missing);
            match missing.0 {
                None => return result,
                Some(demand) => self.load(demand),
            }
        }
    }

    /// Loads what a transition found missing; `false` if it was not missing. What does not exist is not missing a second time.
    pub fn load_for_transition(&mut self, id: CellId) -> bool {
        let mut missing = Missing::default();
        self.land.visible(id, false, &mut missing);
        missing.0.map(|demand| self.load(demand)).is_some()
    }

    /// Loads the cell of a position. What a move from there reaches beyond it is loaded when a lookup finds it missing: loading ahead would
    /// change the order in which static objects come to be, and with it the order of collision tests.
    pub fn ensure_loaded_around(&mut self, position: &Position) {
        self.visible_cell(position.cell);
    }

    /// Loads one block or indoor cell and what its static objects reach. Afterwards the demand is met: what cannot be had counts as absent.
    pub fn load(&mut self, demand: Demand) {
        if self.plan.is_some() {
            self.load_planned(demand);
        } else {
            self.load_alone(demand);
        }
    }

    /// As [`World::load`], without what a plan has put off.
    pub(crate) fn load_alone(&mut self, demand: Demand) {
        let mut cells = std::mem::take(&mut self.loading_cells);
        let mut tasks = Vec::new();
        let mut brought = vec![demand.cell];
        tasks.extend(self.begin(demand));
        while let Some(task) = tasks.last_mut() {
            let step = match task {
                Task::Block(task) => self.block_step(task, &mut cells),
                Task::Room {
                    cell,
                    next,
                    pending,
                } => self.room_step(*cell, next, pending, &mut cells),
                Task::Connected { cell, next } => {
                    let (cell, step) = (*cell, self.connected_step(*cell, next));
                    if matches!(step, Step::Done) {
                        *task = Task::Room {
                            cell,
                            next: 0,
                            pending: None,
                        };
                        Step::Again
                    } else {
                        step
                    }
                }
            };
            match step {
                Step::Again => {}
                Step::Done => {
                    tasks.pop();
                }
                Step::Needs(demand) => {
                    brought.push(demand.cell);
                    tasks.extend(self.begin(demand));
                }
            }
        }
        self.loading_cells = cells;
        for cell in brought {
            self.relink_shadows(cell);
        }
    }

    /// Brings the block or cell itself; what is left to do is the answer.
    fn begin(&mut self, demand: Demand) -> Option<Task> {
        if demand.cell.is_indoor() {
            self.begin_room(demand)
        } else {
            self.begin_block(demand.cell)
        }
    }
}

/// Blocks.
impl World {
    fn begin_block(&mut self, id: CellId) -> Option<Task> {
        let id = id.with_low(0xFFFF);
        let Some(block) = self.make_block(id) else {
            self.land.mark_block_absent(id);
            return None;
        };
        self.land.insert_block(block);
        self.lost.arrive(id);
        self.init_buildings(id);
        Some(Task::Block(BlockTask {
            block: id,
            next: 0,
            scenery: None,
            pending: None,
        }))
    }

    /// A block with its terrain and outdoor cells, nothing in them; `id` has the cell part 0xFFFF. `None` if it has no record.
    pub(crate) fn make_block(&mut self, id: CellId) -> Option<LandBlock> {
        let source = Arc::clone(&self.land.source);
        let record = self.resources.found(source.landblock(id));
        let record = record.filter(|_| id.block_coord().is_some())?;
        let info = (record.has_info != 0)
            .then(|| self.resources.found(source.landblock_info(id)))
            .flatten();
        let terrain = TerrainBlock::new(
            id,
            TerrainVertices {
                heights: record.heights,
                words: record.terrain.map(|word| word.0),
            },
            &self.land.heights,
            &self.profile,
        );
        Some(LandBlock {
            id,
            terrain,
            cells: (0..CELLS as u32).map(|i| land_cell(id, i)).collect(),
            buildings: Vec::new(),
            statics: Vec::new(),
            info_statics: 0,
            stab_list: Vec::new(),
            info,
        })
    }

    /// The outdoor cell of a record's frame in its own block (12.3), with the frame that the object takes.
    fn place_in_block(&self, block: CellId, frame: Frame) -> Option<(CellHandle, Frame)> {
        let (id, origin) = block.adjust_to_outside(frame.origin, &self.profile);
        let cell = self.land.loaded(id).filter(|_| id.same_block(block))?;
        let mut frame = frame;
        // 02:B10: one reference keeps the adjusted place.
        if self.profile.dat_object_adjusted {
            frame.origin = origin;
        }
        Some((cell, frame))
    }

    fn init_buildings(&mut self, block: CellId) {
        let Some(info) = self.land.block(block).and_then(|b| b.info.clone()) else {
            return;
        };
        for record in &info.buildings {
            let made = StaticObject::make(
                record.model,
                StaticKind::Building,
                &mut self.resources,
                &self.profile,
            );
            let place = self.place_in_block(block, frame_of(&record.frame));
            if let (Some(object), Some((cell, frame))) = (made, place) {
                self.add_building(block, record, object, cell, frame);
            }
        }
    }

    fn add_building(
        &mut self,
        block: CellId,
        record: &dat::Building,
        mut object: StaticObject,
        cell: CellHandle,
        frame: Frame,
    ) {
        let position = Position {
            cell: self.land.cell_id(cell),
            frame,
        };
        object.place(position, &self.profile);
        if self.profile.dat_object_adjusted {
            force_first_part(&mut object, &position);
        }
        object.body.cell = Some(cell);
        object.portals = record
            .portals
            .iter()
            .map(|p| building_portal(block, p))
            .collect();
        object.leaf_count = record.leaf_count;
        let stabs: Vec<CellId> = object
            .portals
            .iter()
            .flat_map(|p| p.stab_list.iter().copied())
            .collect();
        let id = self.land.insert_static(object);
        // C-17: the first building of a cell, or the last.
        let last_wins = self.profile.dat_object_adjusted;
        if let Some(cell) = self.land.land_cell_mut(cell)
            && (cell.building.is_none() || last_wins)
        {
            cell.building = Some(id);
        }
        if let Some(block) = self.land.block_mut(block) {
            block.buildings.push(id);
            for stab in stabs {
                if !block.stab_list.contains(&stab) {
                    block.stab_list.push(stab);
                }
            }
        }
    }

    fn block_step(&mut self, task: &mut BlockTask, cells: &mut CellArray) -> Step {
        if let Some(step) = self.pending_step(&mut task.pending, cells) {
            return step;
        }
        let Some(block) = self.land.block(task.block) else {
            return Step::Done;
        };
        let at = task.next;
        task.next += 1;
        let Some(placements) = &task.scenery else {
            let stab = block.info.as_ref().and_then(|i| i.statics.get(at)).copied();
            match stab {
                Some(stab) => {
                    let frame = frame_of(&stab.frame);
                    task.pending = self.make_block_static(
                        task.block,
                        stab.model,
                        StaticKind::Landblock,
                        frame,
                    );
                }
                None => {
                    self.end_info_statics(task.block);
                    task.scenery = Some(self.make_scenery(task.block));
                    task.next = 0;
                }
            }
            return Step::Again;
        };
        let Some(placement) = placements.get(at) else {
            return Step::Done;
        };
        let (model, frame) = (placement.model, placement.frame);
        let scale = placement.scale;
        task.pending = self
            .make_block_static(task.block, model, StaticKind::Scenery, frame)
            .map(|pending| Pending {
                scale: Some(scale),
                ..pending
            });
        Step::Again
    }

    fn make_block_static(
        &mut self,
        block: CellId,
        model: u32,
        kind: StaticKind,
        frame: Frame,
    ) -> Option<Pending> {
        let object = StaticObject::make(model, kind, &mut self.resources, &self.profile)?;
        if kind == StaticKind::Scenery && !is_within_block(&object, &frame, &self.profile) {
            return None;
        }
        let (cell, frame) = match kind {
            StaticKind::Scenery => {
                let (id, _) = block.adjust_to_outside(frame.origin, &self.profile);
                (self.land.loaded(id)?, frame)
            }
            _ => self.place_in_block(block, frame)?,
        };
        let object = self.enter_static(object, cell, frame);
        self.land.block_mut(block)?.statics.push(object);
        Some(Pending {
            object,
            scale: None,
        })
    }

    /// Restrictions of the houses (12.5 step 3).
    fn end_info_statics(&mut self, block: CellId) {
        let Some(block) = self.land.block_mut(block) else {
            return;
        };
        block.info_statics = block.statics.len();
        if let Some(info) = block.info.clone() {
            for cell in &mut block.cells {
                if let Some(&guid) = info.restrictions.get(cell.base.id.0) {
                    cell.base.restriction = guid;
                }
            }
        }
    }

    fn make_scenery(&mut self, block: CellId) -> Vec<SceneryPlacement> {
        let region = self.land.source.region();
        let (Some(region), Some(block), true) =
            (region, self.land.block(block), self.profile.scenery)
        else {
            return Vec::new();
        };
        let (source, resources) = (&self.land.source, &mut self.resources);
        scenery(
            &block.terrain,
            &region,
            |id| resources.found(source.scene(id)),
            |cell| block.cells.get(cell).is_some_and(|c| c.building.is_some()),
            &self.profile,
        )
    }
}

/// Indoor cells.
impl World {
    fn begin_room(&mut self, demand: Demand) -> Option<Task> {
        let id = demand.cell;
        let cell = match self.land.loaded(id) {
            Some(cell) => cell,
            None => {
                let made = self.make_room(id);
                let cell = self.land.insert_env_cell(id, made)?;
                self.lost.arrive(id);
                cell
            }
        };
        let connected = self.profile.env_cell_statics == EnvCellStatics::ConnectedSet;
        if demand.without_statics && !connected {
            return None;
        }
        let env = self.land.env_cell_mut(cell)?;
        if std::mem::replace(&mut env.statics_made, true) {
            return None;
        }
        Some(if connected {
            Task::Connected { cell, next: 0 }
        } else {
            Task::Room {
                cell,
                next: 0,
                pending: None,
            }
        })
    }

    /// An indoor cell without its static objects. `None` if its record or shape cannot be had.
    pub(crate) fn make_room(&mut self, id: CellId) -> Option<EnvCell> {
        let record = self.resources.found(self.land.source.env_cell(id))?;
        self.make_env_cell(id, record)
    }

    fn make_env_cell(&mut self, id: CellId, record: Arc<dat::EnvCell>) -> Option<EnvCell> {
        let shape = self
            .resources
            .room_shape(record.environment_id(), record.structure)?;
        let portals = record
            .portals
            .iter()
            .map(|p| cell_portal(id, p, &shape))
            .collect();
        let full = |low: &u16| id.with_low(u32::from(*low));
        let frame = frame_of(&record.frame);
        Some(EnvCell {
            base: CellBase {
                id,
                restriction: record.restriction,
                ..CellBase::default()
            },
            position: Position { cell: id, frame },
            volume: RoomVolume::new(&shape.volume, &frame),
            shape,
            portals,
            stab_list: record.visible_rooms.iter().map(full).collect(),
            seen_outside: record.seen_outside(),
            statics_made: false,
            statics: Vec::new(),
            record,
        })
    }

    fn connected_step(&mut self, cell: CellHandle, next: &mut usize) -> Step {
        let Some(env) = self.land.env_cell(cell) else {
            return Step::Done;
        };
        let Some(&visible) = env.stab_list.get(*next) else {
            return Step::Done;
        };
        *next += 1;
        let mut missing = Missing::default();
        self.land.visible(visible, false, &mut missing);
        missing.0.map_or(Step::Again, Step::Needs)
    }

    fn room_step(
        &mut self,
        cell: CellHandle,
        next: &mut usize,
        pending: &mut Option<Pending>,
        cells: &mut CellArray,
    ) -> Step {
        if let Some(step) = self.pending_step(pending, cells) {
            return step;
        }
        let Some(env) = self.land.env_cell(cell) else {
            return Step::Done;
        };
        let Some(stab) = env.record.statics.get(*next).copied() else {
            return Step::Done;
        };
        *next += 1;
        let made = StaticObject::make(
            stab.model,
            StaticKind::Room,
            &mut self.resources,
            &self.profile,
        );
        if let Some(object) = made {
            let object = self.enter_static(object, cell, frame_of(&stab.frame));
            if let Some(env) = self.land.env_cell_mut(cell) {
                env.statics.push(object);
            }
            *pending = Some(Pending {
                object,
                scale: None,
            });
        }
        Step::Again
    }
}

/// Static objects.
impl World {
    /// First half of `add_obj_to_cell` (8.8): the object is at home in the cell and stands at the frame.
    fn enter_static(
        &mut self,
        mut object: StaticObject,
        cell: CellHandle,
        frame: Frame,
    ) -> StaticId {
        let position = Position {
            cell: self.land.cell_id(cell),
            frame,
        };
        object.place(position, &self.profile);
        object.body.cell = Some(cell);
        object.update_time = self.clock.now;
        let animated = object.body.state.contains(PhysicsState::HAS_DEFAULT_ANIM)
            && !self.leaves_still(&object);
        let id = self.land.insert_static(object);
        if animated {
            self.land.animated_statics.push(id);
        }
        self.land.add_object(cell, ObjectRef::Static(id));
        id
    }

    /// Second half: the shadows. `None` if nothing is pending.
    fn pending_step(
        &mut self,
        pending: &mut Option<Pending>,
        cells: &mut CellArray,
    ) -> Option<Step> {
        let Pending { object, scale } = pending.as_ref()?;
        let (object, scale) = (*object, *scale);
        let missing = match self.land.static_body(object) {
            Some(body) => self
                .land
                .find_cells_of_body(body, true, cells, &self.profile),
            None => Missing::default(),
        };
        if let Some(demand) = missing.0 {
            return Some(Step::Needs(demand));
        }
        *pending = None;
        self.land
            .replace_static_shadows(object, cells, &self.profile);
        if let (Some(scale), Some(object)) = (scale, self.land.static_object_mut(object)) {
            object.body.scale = scale;
            if let Some(parts) = &mut object.body.part_array {
                parts.set_scale(Vec3::splat(scale));
            }
        }
        Some(Step::Again)
    }
}

fn land_cell(block: CellId, index: u32) -> LandCell {
    LandCell {
        base: CellBase {
            id: block.with_low(index + 1),
            ..CellBase::default()
        },
        building: None,
    }
}

fn building_portal(block: CellId, record: &dat::BuildingPortal) -> BuildingPortal {
    let full = |low: u16| block.with_low(u32::from(low));
    BuildingPortal {
        exact_match: record.flags.contains(dat::PortalFlags::EXACT_MATCH),
        portal_side: record.flags.portal_side(),
        other_cell: full(record.room),
        other_portal: record.room_portal,
        stab_list: record.visible_rooms.iter().map(|&low| full(low)).collect(),
    }
}

/// A portal whose polygon does not exist gets a plane that nothing is near.
fn cell_portal(cell: CellId, record: &dat::CellPortal, shape: &CellShape) -> CellPortal {
    const OUTSIDE: u16 = 0xFFFF;
    const NOWHERE: Plane = Plane {
        n: Vec3::NAN,
        d: f32::NAN,
    };
    let polygon = shape.polygons.get(usize::from(record.polygon));
    CellPortal {
        exact_match: record.flags.contains(dat::PortalFlags::EXACT_MATCH),
        portal_side: record.flags.portal_side(),
        plane: polygon.map_or(NOWHERE, |polygon| polygon.plane),
        target: if record.other_room == OUTSIDE {
            PortalTarget::Outside
        } else {
            PortalTarget::Cell(cell.with_low(u32::from(record.other_room)))
        },
        other_portal: record.other_portal,
    }
}

/// `02:B22`: one reference gives the shell the building's own place, whatever the setup's pose.
fn force_first_part(object: &mut StaticObject, position: &Position) {
    let parts = object.body.part_array.as_mut();
    if let Some(Some(part)) = parts.and_then(|p| p.parts.first_mut()) {
        part.position = *position;
    }
}

/// `obj_within_block` (02, 15.3). The object is not scaled yet.
fn is_within_block(object: &StaticObject, frame: &Frame, profile: &Profile) -> bool {
    let inside = |center: Vec3, r: f32| {
        center.x >= r && center.y >= r && center.x < BLOCK_LENGTH - r && center.y < BLOCK_LENGTH - r
    };
    let Some(parts) = &object.body.part_array else {
        return inside(frame.origin, 0.0);
    };
    let sorting = parts.sorting_sphere();
    let sorted = || {
        inside(
            frame.local_to_global(sorting.center, profile),
            sorting.radius,
        )
    };
    if object.body.state.contains(PhysicsState::HAS_PHYSICS_BSP) {
        sorted()
    } else if !parts.cyl_spheres().is_empty() {
        parts
            .cyl_spheres()
            .iter()
            .all(|c| inside(frame.local_to_global(c.low, profile), c.radius))
    } else if !parts.spheres().is_empty() {
        sorted()
    } else {
        inside(frame.origin, 0.0)
    }
}
