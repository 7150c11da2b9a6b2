//! Which cells a set of spheres or parts touches (`spec/03-cells.md`, sections 9 to 12).
//!
//! All functions are read-only. What they find not loaded is noted in [`Missing`], and the list means nothing then. The order of a list is the
//! order of collision tests, so every step keeps the order of the specification.

use arrayvec::ArrayVec;

use super::CellHandle;
use super::cell::{BuildingPortal, CellRef, EnvCell, LandCellRef, PortalTarget};
use super::cell_list_memo::CellListMemo;
use super::landscape::{Landscape, Missing};
use super::room_volume::Quick;
use super::terrain::CELLS;
use crate::animation::{PartArray, PhysicsPart};
use crate::math::{
    BoundingBox, CELL_LENGTH, CellId, EPSILON, Frame, LandCoord, Plane, Position, Quat, Sidedness,
    Sphere, Vec3, block_offset, floor,
};
use crate::physics::body::Body;
use crate::physics::collision::BoundingType;
use crate::physics::state::PhysicsState;
use crate::physics::transition::{CellArray, Transition};
use crate::profile::{
    BuildingPortals, DoNotLoad, DummySphere, MissingCells, PartBoxes, PortalNeighbours, Profile,
};

/// Cylspheres of an object that count for its cell list.
const MAX_CYL_SPHERES: usize = 10;
/// A list holds at most within this distance, m.
const LONGEST_HOLD: f32 = 10.0;
/// Portal index that means "no portal leads back".
const NO_PORTAL: u16 = 0xFFFF;
/// Cells to each side of a part that its box can add. Shapes are smaller than a block (8 cells); this bounds what a damaged one can cost.
const MAX_PART_CELLS: i32 = 32;

/// Spheres at a place: what a cell list is made of.
#[derive(Debug, Clone, Copy)]
pub struct SpheresAt<'a> {
    /// Start cell, and the landblock that the centres are relative to.
    pub position: &'a Position,
    /// In block coordinates of `position`.
    pub spheres: &'a [Sphere],
    /// The list is a transition's.
    pub is_path: bool,
    /// Whether the cell of the first sphere's centre is looked for. If that is an indoor cell, the list is not restricted to what the start
    /// cell sees.
    pub want_current: bool,
}

/// What a cell list answers beside the list.
#[derive(Debug, Clone, Copy, Default)]
pub struct CellListOutcome {
    /// The cell that contains the first sphere's centre; `None` inside if no cell does, `None` outside if it was not looked for: nobody
    /// asked, there are no spheres, or the start cell is not there.
    pub current: Option<Option<CellHandle>>,
    /// Some touched cell is indoor.
    pub hits_interior_cell: bool,
    /// What must be loaded first.
    pub missing: Missing,
    /// No sphere that moves less far than this, m, makes another list; 0 where nothing is known about that.
    pub holds_within: f32,
}

/// The list under construction, and what goes with it.
struct Builder<'a> {
    land: &'a Landscape,
    profile: &'a Profile,
    array: &'a mut CellArray,
    outcome: CellListOutcome,
    /// The outdoor cells of the spheres are in the list: adding them again would change nothing.
    has_outside: bool,
}

impl Landscape {
    /// Cells that spheres touch, in test order (9.1).
    pub fn find_cell_list(
        &self,
        at: SpheresAt<'_>,
        array: &mut CellArray,
        profile: &Profile,
    ) -> CellListOutcome {
        array.start(profile);
        if let Some(outcome) = self.single_outdoor_cell(at, array) {
            return outcome;
        }
        let mut list = Builder {
            land: self,
            profile,
            array,
            outcome: CellListOutcome {
                holds_within: LONGEST_HOLD,
                ..CellListOutcome::default()
            },
            has_outside: false,
        };
        list.find(at);
        list.outcome
    }

    /// The list of spheres that are well inside one outdoor cell of their own block in which no building stands: that cell alone. By far the
    /// most frequent list; `None` for every other, with nothing changed.
    fn single_outdoor_cell(
        &self,
        at: SpheresAt<'_>,
        array: &mut CellArray,
    ) -> Option<CellListOutcome> {
        let start = at.position.cell;
        let is_outdoors = start.low().wrapping_sub(1) < CELLS as u32;
        if !is_outdoors || start.block_coord().is_none() || !array.cells.is_empty() {
            return None;
        }
        let (first, rest) = at.spheres.split_first()?;
        let index = inner_cell(first)?;
        if rest.iter().any(|sphere| inner_cell(sphere) != Some(index)) {
            return None;
        }
        let id = start.with_low(index as u32 + 1);
        let handle = self.visible_land_cell(id, &mut Missing::default())?;
        let land = self.land_cell(handle)?;
        if land.cell.building.is_some() {
            return None;
        }
        array.add_cell(id, Some(handle));
        let contains = |point| land.block.terrain.find_terrain_poly(index, point).is_some();
        Some(CellListOutcome {
            current: at
                .want_current
                .then(|| contains(first.center).then_some(handle)),
            ..CellListOutcome::default()
        })
    }

    /// Cells that an object touches where it is (`calc_cross_cells`, 8.9, and `calc_cross_cells_static`, 8.10). Scale is not applied.
    pub fn find_cells_of_body(
        &self,
        body: &Body,
        is_static: bool,
        array: &mut CellArray,
        profile: &Profile,
    ) -> Missing {
        if is_static {
            array.reset_static(profile);
        } else {
            array.reset_dynamic(profile);
        }
        let by_parts = body.state.contains(PhysicsState::HAS_PHYSICS_BSP);
        let cylinders = body
            .part_array
            .as_ref()
            .map_or(&[][..], PartArray::cyl_spheres);
        if by_parts || (is_static && cylinders.is_empty()) {
            return self.find_bbox_cell_list(body, array, profile);
        }
        let to_block = |p: Vec3| body.position.frame.local_to_global(p, profile);
        let mut spheres = ArrayVec::<Sphere, MAX_CYL_SPHERES>::new();
        for cylinder in cylinders.iter().take(MAX_CYL_SPHERES) {
            spheres.push(Sphere::new(to_block(cylinder.low), cylinder.radius));
        }
        if spheres.is_empty() {
            let sphere = sorting_or_dummy_sphere(body, profile);
            spheres.push(Sphere::new(to_block(sphere.center), sphere.radius));
        }
        let at = SpheresAt {
            position: &body.position,
            spheres: &spheres,
            is_path: false,
            want_current: false,
        };
        self.find_cell_list(at, array, profile).missing
    }

    /// Cells that the boxes of an object's parts touch, from its current cell on (8.11).
    fn find_bbox_cell_list(
        &self,
        body: &Body,
        array: &mut CellArray,
        profile: &Profile,
    ) -> Missing {
        let (Some(parts), Some(cell)) = (&body.part_array, body.cell) else {
            return Missing::default();
        };
        array.start(profile);
        array.add_cell(self.cell_id(cell), Some(cell));
        let mut list = Builder {
            land: self,
            profile,
            array,
            outcome: CellListOutcome::default(),
            has_outside: false,
        };
        let mut k = 0;
        while k < list.array.cells.len() {
            match list.array.cells[k].cell.and_then(|c| self.cell(c)) {
                Some(CellRef::Land(land)) => list.transit_land_parts(land, parts),
                Some(CellRef::Env(env)) => list.transit_env_parts(env, parts),
                None => {}
            }
            k += 1;
        }
        list.outcome.missing
    }

    /// Whether a point (m, coordinates of the cell's block) is in a cell (11.3).
    pub fn point_in_cell(&self, cell: CellRef<'_>, point: Vec3, profile: &Profile) -> bool {
        match cell {
            CellRef::Land(land) => land
                .block
                .terrain
                .find_terrain_poly(land.index, point)
                .is_some(),
            CellRef::Env(env) => {
                // C-13: a sealed cell.
                if env.portals.is_empty() && !profile.portalless_cell_contains {
                    return false;
                }
                if let Some(quick) = env.volume.contains(point) {
                    return quick.answer;
                }
                let local = env.position.frame.global_to_local(point, profile);
                env.shape.contains(local)
            }
        }
    }

    /// The indoor cell that contains a point (m, block coordinates): `start`, else one of its stab list if `search`, else one of its portal
    /// neighbours (11.4).
    pub fn find_visible_child_cell(
        &self,
        start: CellHandle,
        point: Vec3,
        search: bool,
        profile: &Profile,
        missing: &mut Missing,
    ) -> Option<CellHandle> {
        let env = self.env_cell(start)?;
        if self.point_in_cell(CellRef::Env(env), point, profile) {
            return Some(start);
        }
        let mut contains = |id: CellId| {
            let handle = self.visible(id, !search, missing)?;
            self.point_in_cell(self.cell(handle)?, point, profile)
                .then_some(handle)
        };
        if search {
            return env.stab_list.iter().find_map(|&id| contains(id));
        }
        env.portals.iter().find_map(|portal| match portal.target {
            PortalTarget::Cell(id) if neighbour_counts(env, id, profile) => contains(id),
            _ => None,
        })
    }
}

impl Transition<'_> {
    /// Lists the cells that the mover's spheres touch at the check position (9.2, last form). `current` takes the one that contains the first
    /// centre; it stays as it is if there is no start cell.
    pub fn find_cell_list(&mut self, current: Option<&mut Option<CellHandle>>) {
        let count = self.path.num_sphere.min(self.path.global_sphere.len());
        let at = SpheresAt {
            position: &self.path.check_pos,
            spheres: &self.path.global_sphere[..count],
            is_path: true,
            want_current: current.is_some(),
        };
        let world = self.world;
        let profile = &world.profile;
        let known = self.list_memo.and_then(|memo| memo.answer(at));
        let outcome = known.unwrap_or_else(|| {
            let outcome = world.land.find_cell_list(at, &mut self.cells, profile);
            // C-01: entries stay, and the next list is another.
            self.list_memo = CellListMemo::new(at, outcome).filter(|_| profile.cell_array_emptied);
            outcome
        });
        self.path.hits_interior_cell |= outcome.hits_interior_cell;
        self.note_missing(outcome.missing);
        if let (Some(current), Some(found)) = (current, outcome.current) {
            *current = found;
        }
    }

    /// Notes the first thing that was not loaded.
    pub(super) fn note_missing(&mut self, missing: Missing) {
        if self.missing.is_none() {
            self.missing = missing.0.map(|demand| demand.cell);
        }
    }
}

/// A list holds no farther than the answers it depends on, and an exact one holds nowhere else.
#[inline]
fn note_hold(outcome: &mut CellListOutcome, quick: Option<Quick>) {
    let hold = quick.map_or(0.0, |quick| quick.holds_within);
    if hold < outcome.holds_within {
        outcome.holds_within = hold;
    }
}

/// The outdoor cell (0..64) of its block that a sphere (block coordinates) is well inside of, farther from the border than rounding can tell.
#[inline]
fn inner_cell(sphere: &Sphere) -> Option<usize> {
    const MARGIN: f32 = 0.01;
    let border = sphere.radius.abs() + MARGIN;
    let column = |v: f32| {
        let column = (v * (1.0 / CELL_LENGTH)) as u32;
        let within = v - column as f32 * CELL_LENGTH;
        (within > border && within < CELL_LENGTH - border && column < 8).then_some(column as usize)
    };
    Some(column(sphere.center.x)? * 8 + column(sphere.center.y)?)
}

/// Sorting sphere of an object, or what stands for it where there is no skeleton (`T-29`).
fn sorting_or_dummy_sphere(body: &Body, profile: &Profile) -> Sphere {
    match (&body.part_array, profile.dummy_sphere) {
        (Some(parts), _) => parts.sorting_sphere(),
        (None, DummySphere::ZeroInMoves) => Sphere::new(Vec3::ZERO, 0.0),
        (None, DummySphere::Unscaled | DummySphere::ScaledInCheck) => {
            Sphere::new(Vec3::new(0.0, 0.0, 0.1), 0.1)
        }
    }
}

/// Whether a portal neighbour can be found at all (`C-11`).
fn neighbour_counts(env: &EnvCell, id: CellId, profile: &Profile) -> bool {
    match profile.portal_neighbours {
        PortalNeighbours::Loadable => true,
        PortalNeighbours::VisibleList => env.stab_list.contains(&id),
    }
}

/// Spheres.
impl Builder<'_> {
    fn find(&mut self, at: SpheresAt<'_>) {
        let start = at.position.cell;
        let start_cell = self.visible(start, false);
        if start.is_indoor() {
            self.outcome.hits_interior_cell = true;
            self.array.add_cell(start, start_cell);
        } else {
            self.add_all_outside_cells(at);
        }
        let Some(start_cell) = start_cell.filter(|_| !at.spheres.is_empty()) else {
            return;
        };
        let mut k = 0;
        while k < self.array.cells.len() {
            match self.array.cells[k].cell.and_then(|c| self.land.cell(c)) {
                Some(CellRef::Land(land)) => {
                    self.outcome.holds_within = 0.0;
                    self.add_all_outside_cells(at);
                    self.transit_building(land, at);
                }
                Some(CellRef::Env(env)) => self.transit_env(env, at),
                None => {}
            }
            k += 1;
        }
        if !(at.want_current && self.find_current(at)) {
            self.filter_unseen(start, start_cell, at.is_path);
        }
    }

    fn visible(&mut self, id: CellId, without_statics: bool) -> Option<CellHandle> {
        self.land
            .visible(id, without_statics, &mut self.outcome.missing)
    }

    fn neighbour(&mut self, env: &EnvCell, id: CellId) -> Option<CellHandle> {
        if !neighbour_counts(env, id, self.profile) {
            return None;
        }
        self.visible(id, self.array.do_not_load_cells)
    }

    /// The cell that contains the first centre: an indoor one ends the search, of the outdoor ones the last wins. Answers whether it was an
    /// indoor one.
    fn find_current(&mut self, at: SpheresAt<'_>) -> bool {
        let mut current = None;
        for entry in self.array.entries() {
            let Some(handle) = entry.cell else { continue };
            let Some(cell) = self.land.cell(handle) else {
                continue;
            };
            let point = at.spheres[0].center - block_offset(at.position.cell, entry.id);
            let quick = match cell {
                CellRef::Env(env) => env.volume.contains(point),
                CellRef::Land(_) => None,
            };
            note_hold(&mut self.outcome, quick);
            if !self.land.point_in_cell(cell, point, self.profile) {
                continue;
            }
            current = Some(handle);
            if cell.is_indoor() {
                self.outcome.hits_interior_cell = true;
                self.outcome.current = Some(current);
                return true;
            }
        }
        self.outcome.current = Some(current);
        false
    }

    /// Restricts the list to what the start cell sees (9.1 step 4.3, `C-02`).
    fn filter_unseen(&mut self, start: CellId, start_cell: CellHandle, is_path: bool) {
        let wanted = match self.profile.do_not_load {
            DoNotLoad::StartsIndoors => is_path || self.array.do_not_load_cells,
            DoNotLoad::Statics | DoNotLoad::OwnEntry => self.array.do_not_load_cells,
        };
        let Some(env) = self.land.env_cell(start_cell).filter(|_| wanted) else {
            return;
        };
        let seen = |id: CellId| env.stab_list.contains(&id);
        match self.profile.do_not_load {
            DoNotLoad::OwnEntry => self
                .array
                .filter(self.profile, |id| id != start || seen(id)),
            DoNotLoad::Statics | DoNotLoad::StartsIndoors => {
                self.array
                    .filter(self.profile, |id| id == start || seen(id));
            }
        }
    }

    /// Outdoor cells that spheres touch (10.1).
    fn add_all_outside_cells(&mut self, at: SpheresAt<'_>) {
        if self.array.added_outside || self.has_outside {
            return;
        }
        self.has_outside = true;
        self.outcome.holds_within = 0.0;
        if at.spheres.is_empty() {
            if let Some(coord) = at.position.outside_cell(self.profile).land_coord() {
                self.add_outside_cell(coord.x, coord.y);
            }
            return;
        }
        for sphere in at.spheres {
            let (id, center) = at
                .position
                .cell
                .adjust_to_outside(sphere.center, self.profile);
            if id.is_none() {
                return;
            }
            let within = |v: f32| v - floor(v / CELL_LENGTH) * CELL_LENGTH;
            let (tx, ty) = (within(center.x), within(center.y));
            if let Some(coord) = id.land_coord() {
                self.add_outside_cell(coord.x, coord.y);
                self.add_cells_beyond_borders(coord, tx, ty, sphere.radius);
            }
        }
    }

    /// Neighbours within the radius (10.3): by the square, not by distance; all comparisons strict.
    fn add_cells_beyond_borders(&mut self, cell: LandCoord, tx: f32, ty: f32, radius: f32) {
        let (low, high) = (radius, CELL_LENGTH - radius);
        let LandCoord { x, y } = cell;
        let (north, south) = (ty > high, ty < low);
        for (reached, x) in [(tx > high, x + 1), (tx < low, x - 1)] {
            if !reached {
                continue;
            }
            self.add_outside_cell(x, y);
            if north {
                self.add_outside_cell(x, y + 1);
            }
            if south {
                self.add_outside_cell(x, y - 1);
            }
        }
        if north {
            self.add_outside_cell(x, y + 1);
        }
        if south {
            self.add_outside_cell(x, y - 1);
        }
    }

    /// Adds the outdoor cell at these global coordinates if it is on the map (10.2, `C-06`).
    fn add_outside_cell(&mut self, x: i32, y: i32) {
        let left_out = self.profile.missing_cells == MissingCells::LeftOut;
        let coord = if left_out {
            // There the coordinates go through an unsigned integer: what lies west or south of the map saturates to 0.
            LandCoord {
                x: x.max(0),
                y: y.max(0),
            }
        } else {
            LandCoord { x, y }
        };
        let id = coord.cell_id();
        if id.is_none() {
            return;
        }
        let cell = self.visible(id, false);
        if cell.is_some() || !left_out {
            self.array.add_cell(id, cell);
        }
    }

    /// Cells behind the portals of an indoor cell (11.1). Centres are taken to be in this cell's block, as in both references.
    fn transit_env(&mut self, env: &EnvCell, at: SpheresAt<'_>) {
        let mut outside = false;
        for portal in &env.portals {
            let distance = |sphere: &Sphere| {
                let local = env
                    .position
                    .frame
                    .global_to_local(sphere.center, self.profile);
                (portal.plane.distance(local), sphere.radius + EPSILON)
            };
            let PortalTarget::Cell(id) = portal.target else {
                // The plane only, not the polygon.
                self.outcome.holds_within = 0.0;
                outside |= at
                    .spheres
                    .iter()
                    .map(distance)
                    .any(|(d, r)| -r < d && d < r);
                continue;
            };
            match self.neighbour(env, id) {
                Some(handle) => {
                    if self.touches_env_cell(handle, at.spheres) {
                        self.array.add_cell(id, Some(handle));
                    }
                }
                None => {
                    self.outcome.holds_within = 0.0;
                    let reached = |(d, r): (f32, f32)| {
                        (d > -r && portal.portal_side) || (d < r && !portal.portal_side)
                    };
                    if at.spheres.iter().map(distance).any(reached) {
                        self.add_missing_neighbour(id);
                    }
                }
            }
        }
        if outside {
            self.add_all_outside_cells(at);
        }
    }

    /// `C-12`.
    fn add_missing_neighbour(&mut self, id: CellId) {
        let id = match self.profile.missing_cells {
            MissingCells::Entered => id,
            MissingCells::LeftOut => CellId(id.low()),
        };
        self.array.add_cell(id, None);
    }

    /// Whether a sphere (block coordinates) reaches into the volume of an indoor cell.
    fn touches_env_cell(&mut self, handle: CellHandle, spheres: &[Sphere]) -> bool {
        let Some(env) = self.land.env_cell(handle) else {
            return false;
        };
        spheres.iter().any(|sphere| {
            let quick = env.volume.touches(sphere.center, sphere.radius);
            note_hold(&mut self.outcome, quick);
            quick.map_or_else(
                || self.sphere_touches_exactly(env, sphere),
                |quick| quick.answer,
            )
        })
    }

    #[inline(never)]
    fn sphere_touches_exactly(&self, env: &EnvCell, sphere: &Sphere) -> bool {
        let center = env
            .position
            .frame
            .global_to_local(sphere.center, self.profile);
        env.shape
            .intersects_sphere(&Sphere::new(center, sphere.radius))
            != BoundingType::Outside
    }

    /// Indoor cells behind the portals of the building of an outdoor cell (12.2). The portal polygon is not looked at.
    fn transit_building(&mut self, land: LandCellRef<'_>, at: SpheresAt<'_>) {
        for portal in self.building_portals(land) {
            let Some(handle) = self.visible(portal.other_cell, self.array.do_not_load_cells) else {
                continue;
            };
            if self.portal_is_invalid(portal) {
                continue;
            }
            if self.touches_env_cell(handle, at.spheres) {
                self.outcome.hits_interior_cell = true;
                self.array.add_cell(portal.other_cell, Some(handle));
            }
        }
    }

    /// `C-09`.
    fn portal_is_invalid(&self, portal: &BuildingPortal) -> bool {
        portal.other_portal == NO_PORTAL
            && self.profile.building_portals != BuildingPortals::IdPasses
    }
}

/// Parts.
impl<'a> Builder<'a> {
    fn building_portals(&self, cell: LandCellRef<'_>) -> &'a [BuildingPortal] {
        cell.cell
            .building
            .and_then(|id| self.land.static_object(id))
            .map_or(&[], |building| &building.portals)
    }

    fn transit_land_parts(&mut self, land: LandCellRef<'_>, parts: &PartArray) {
        self.add_outside_cells_of_parts(parts);
        for portal in self.building_portals(land) {
            let Some(handle) = self.visible(portal.other_cell, self.array.do_not_load_cells) else {
                continue;
            };
            if self.portal_is_invalid(portal) {
                continue;
            }
            self.transit_building_parts(handle, portal.other_portal, parts);
        }
    }

    /// Outdoor cells that the boxes of parts touch (10.4).
    fn add_outside_cells_of_parts(&mut self, parts: &PartArray) {
        if self.array.added_outside {
            return;
        }
        self.array.added_outside = true;
        let own_block = self.profile.part_boxes == PartBoxes::OwnBlock;
        // Not reset between parts, as in both references: later parts add at least the range of the earlier ones.
        let (mut min, mut max) = ([0, 0], [0, 0]);
        for part in parts.existing_parts() {
            let place = &part.position;
            let (id, center) = place
                .cell
                .adjust_to_outside(place.frame.origin, self.profile);
            let Some(coord) = id.land_coord() else {
                continue;
            };
            if self.visible(id, false).is_none() && !own_block {
                continue;
            }
            let own = [(coord.x & 7), (coord.y & 7)];
            for other in parts.existing_parts() {
                let bounds = self.outdoor_box(part, other, id, center);
                for axis in 0..2 {
                    let cells = |v: f32| (v / CELL_LENGTH).floor() as i32;
                    let bounded = |v: i32| v.clamp(-MAX_PART_CELLS, MAX_PART_CELLS);
                    let low = cells(bounds.min[axis]).saturating_sub(own[axis]);
                    let high = cells(bounds.max[axis]).saturating_sub(own[axis]);
                    min[axis] = min[axis].min(bounded(low));
                    max[axis] = max[axis].max(bounded(high));
                }
            }
            self.add_cell_block(coord, min, max, own_block);
        }
    }

    /// Box of part `other` in block coordinates of the cell of `part` (`C-08`).
    fn outdoor_box(
        &self,
        part: &PhysicsPart,
        other: &PhysicsPart,
        cell: CellId,
        center: Vec3,
    ) -> BoundingBox {
        let kind = self.profile.part_boxes;
        if other.shape.always_2d && kind != PartBoxes::OwnBlock {
            let reach = Vec3::splat(other.shape.bounding_sphere().radius);
            return BoundingBox {
                min: center - reach,
                max: center + reach,
            };
        }
        let bounds = match kind {
            PartBoxes::Own | PartBoxes::OwnBlock => &other.shape.bounds,
            PartBoxes::Crossed => &part.shape.bounds,
        };
        let to = Position {
            cell,
            frame: Frame::new(Vec3::ZERO, Quat::IDENTITY),
        };
        bounds.local_to_global(&other.position, &to, self.profile)
    }

    /// Outdoor cells from `cell + min` to `cell + max`, x outer (10.5).
    fn add_cell_block(&mut self, cell: LandCoord, min: [i32; 2], max: [i32; 2], own_block: bool) {
        for x in cell.x + min[0]..=cell.x + max[0] {
            for y in cell.y + min[1]..=cell.y + max[1] {
                let coord = LandCoord { x, y };
                let elsewhere = x >> 3 != cell.x >> 3 || y >> 3 != cell.y >> 3;
                if coord.in_bounds() && !(own_block && elsewhere) {
                    self.add_outside_cell(x, y);
                }
            }
        }
    }

    /// Cells behind the portals of an indoor cell (11.2).
    fn transit_env_parts(&mut self, env: &EnvCell, parts: &PartArray) {
        let mut outside = false;
        for portal in &env.portals {
            for part in parts.existing_parts() {
                let Some(sphere) = part_sphere(part) else {
                    continue;
                };
                let (distance, reach) = self.portal_distance(env, &portal.plane, part, &sphere);
                let behind = if portal.portal_side {
                    distance < -reach
                } else {
                    distance > reach
                };
                if behind {
                    continue;
                }
                let side = self.box_side(env, &portal.plane, part);
                if matches!(
                    (side, portal.portal_side),
                    (Sidedness::Positive, false) | (Sidedness::Negative, true)
                ) {
                    continue;
                }
                let PortalTarget::Cell(id) = portal.target else {
                    outside = true;
                    break;
                };
                let Some(handle) = self.neighbour(env, id) else {
                    self.add_missing_neighbour(id);
                    break;
                };
                if self.part_touches(handle, part) {
                    self.array.add_cell(id, Some(handle));
                    break;
                }
            }
        }
        if outside {
            self.add_outside_cells_of_parts(parts);
        }
    }

    /// An indoor cell of a building, entered through its portal `index` (12.2).
    fn transit_building_parts(&mut self, handle: CellHandle, index: u16, parts: &PartArray) {
        let Some(env) = self.land.env_cell(handle) else {
            return;
        };
        let Some(portal) = env.portals.get(usize::from(index)) else {
            return;
        };
        for part in parts.existing_parts() {
            let Some(sphere) = part_sphere(part) else {
                continue;
            };
            let (distance, reach) = self.portal_distance(env, &portal.plane, part, &sphere);
            let beyond = if portal.portal_side {
                distance > reach
            } else {
                distance < -reach
            };
            if beyond {
                continue;
            }
            // C-10: which side of the portal is inside.
            let outside_half = self.profile.building_portals == BuildingPortals::OutsideHalf;
            let inside = if portal.portal_side != outside_half {
                Sidedness::Negative
            } else {
                Sidedness::Positive
            };
            let side = self.box_side(env, &portal.plane, part);
            if side != Sidedness::Crossing && side != inside {
                continue;
            }
            if self.part_touches(handle, part) {
                self.array.add_cell(env.base.id, Some(handle));
                self.transit_env_parts(env, parts);
                return;
            }
        }
    }

    /// Distance of a part's sphere from a plane in cell space, and the sphere's reach; the part's scale is not applied.
    fn portal_distance(
        &self,
        env: &EnvCell,
        plane: &Plane,
        part: &PhysicsPart,
        sphere: &Sphere,
    ) -> (f32, f32) {
        let center = env
            .position
            .local_to_local(&part.position, sphere.center, self.profile);
        (plane.distance(center), sphere.radius + EPSILON)
    }

    fn box_side(&self, env: &EnvCell, plane: &Plane, part: &PhysicsPart) -> Sidedness {
        plane.intersect_box(&self.box_in_cell(env, part), self.profile)
    }

    fn box_in_cell(&self, env: &EnvCell, part: &PhysicsPart) -> BoundingBox {
        part.shape
            .bounds
            .local_to_local(&part.position, &env.position, self.profile)
    }

    fn part_touches(&self, handle: CellHandle, part: &PhysicsPart) -> bool {
        self.land
            .env_cell(handle)
            .is_some_and(|env| env.shape.intersects_box(&self.box_in_cell(env, part)))
    }
}

/// Physics sphere of a part, else its drawing sphere.
fn part_sphere(part: &PhysicsPart) -> Option<Sphere> {
    part.shape.physics_sphere().or(part.shape.drawing_sphere)
}
