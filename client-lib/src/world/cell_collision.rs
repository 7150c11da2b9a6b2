//! Collision with the contents of one cell (`spec/03-cells.md`, 12.3 and 13).

use super::CellHandle;
use super::cell::{CellBase, CellRef, EnvCell, LandCellRef};
use super::terrain::WaterType;
use crate::math::{CELL_LENGTH, Vec3, block_offset};
use crate::physics::body::{Body, ObjectRef, StaticId};
use crate::physics::collision::PlacedPart;
use crate::physics::state::PhysicsState;
use crate::physics::transition::{
    InsertType, ObjectInfoState, TerrainContact, Transition, TransitionState,
};
use crate::profile::{HouseBarriers, SameObject, ShadowWalk};

impl<'w> Transition<'w> {
    /// Tests the mover against everything in a cell: its geometry, its building, the objects that throw a shadow into it (13.1). The first
    /// outcome that is not Ok; Invalid for a cell that is not there.
    pub fn find_cell_collisions(&mut self, cell: CellHandle) -> TransitionState {
        let world = self.world;
        let Some(cell) = world.land.cell(cell) else {
            return TransitionState::Invalid;
        };
        let mut state = self.find_env_collisions(cell);
        if state == TransitionState::Ok
            && let CellRef::Land(land) = cell
            && let Some(building) = land.cell.building
        {
            state = self.find_building_collisions(building);
        }
        if state == TransitionState::Ok {
            state = self.find_cell_obj_collisions(cell.base());
        }
        state
    }

    /// Tests the mover against the geometry of a cell (13.3, 13.4).
    pub fn find_env_collisions(&mut self, cell: CellRef<'w>) -> TransitionState {
        let state = self.check_entry_restrictions(cell);
        if state != TransitionState::Ok {
            return state;
        }
        match cell {
            CellRef::Land(land) => self.find_terrain_collisions(land),
            CellRef::Env(env) => self.find_room_collisions(env),
        }
    }

    /// Terrain is a height field to the resolver: only the triangle under the lowest point of the first sphere counts (13.3).
    fn find_terrain_collisions(&mut self, land: LandCellRef<'w>) -> TransitionState {
        let id = land.cell.base.id;
        let offset = block_offset(self.path.check_pos.cell, id);
        let low = self.path.global_low_point - offset;
        let terrain = &land.block.terrain;
        let Some((_, triangle)) = terrain.find_terrain_poly(land.index, low) else {
            return TransitionState::Ok;
        };
        let is_missile = self.object.physics_state.contains(PhysicsState::MISSILE);
        let flooded = terrain.block_water() == WaterType::Entire;
        if flooded && !self.object.is_viewer() && !is_missile {
            return TransitionState::Collided;
        }
        let depth = terrain.water_depth(land.index, low, self.profile());
        let mut sphere = self.path.global_sphere[0];
        sphere.center -= offset;
        self.validate_walkable(
            &sphere,
            &TerrainContact {
                plane: triangle.plane,
                is_water: land.water() != WaterType::None,
                water_depth: depth.metres(),
                cell_id: id,
            },
        )
    }

    /// The physics BSP of a room (13.4).
    fn find_room_collisions(&mut self, env: &'w EnvCell) -> TransitionState {
        self.path.obstruction_ethereal = false;
        let tree = &env.shape.physics;
        if tree.is_empty() {
            return TransitionState::Ok;
        }
        self.cache_localspace_sphere(&env.position, 1.0);
        let state = if self.path.insert_type == InsertType::InitialPlacement {
            tree.placement_insert(self)
        } else {
            tree.find_collisions(self, 1.0)
        };
        self.note_environment(state);
        state
    }

    /// A blocked mover that was not in contact has collided with the environment.
    fn note_environment(&mut self, state: TransitionState) {
        let in_contact = self.object.state.contains(ObjectInfoState::CONTACT);
        if state != TransitionState::Ok && !in_contact {
            self.info.collided_with_environment = true;
        }
    }

    /// Tests the mover against a building's shell: its first part (12.3).
    pub fn find_building_collisions(&mut self, building: StaticId) -> TransitionState {
        let world = self.world;
        let Some(body) = world.land.static_body(building) else {
            return TransitionState::Ok;
        };
        let parts = body.part_array.as_ref().map(|p| &p.parts);
        let Some(Some(part)) = parts.and_then(|p| p.first()) else {
            return TransitionState::Ok;
        };
        let placed = PlacedPart {
            shape: Some(&part.shape),
            position: &part.position,
            scale: part.scale,
        };
        // Inside a shell that touches an indoor cell its solid matter does not count.
        self.path.bldg_check = true;
        let state = placed.find_obj_collisions(self);
        self.path.bldg_check = false;
        self.note_environment(state);
        state
    }

    /// Tests the mover against the objects that throw a shadow into a cell, in the order of its list (13.2).
    pub fn find_cell_obj_collisions(&mut self, cell: &'w CellBase) -> TransitionState {
        if self.path.insert_type == InsertType::InitialPlacement {
            return TransitionState::Ok;
        }
        let count = cell.shadows.len();
        let backwards = self.profile().shadow_walk == ShadowWalk::Backwards;
        for k in 0..count {
            let at = if backwards { count - 1 - k } else { k };
            let state = self.find_shadow_collisions(cell.shadows[at], backwards);
            if state != TransitionState::Ok {
                return state;
            }
        }
        TransitionState::Ok
    }

    fn find_shadow_collisions(
        &mut self,
        object: ObjectRef,
        skips_ethereal: bool,
    ) -> TransitionState {
        // An object that is taken out of the world is the mover.
        let Some(body) = self.world.body(object) else {
            return TransitionState::Ok;
        };
        if self.is_out_of_reach(body) || body.parent.is_some() || self.is_mover(object, body) {
            return TransitionState::Ok;
        }
        let state = self.find_obj_collisions(object, body);
        // C-04: an own addition of one reference.
        let passed = skips_ethereal
            && self.path.insert_type == InsertType::Placement
            && body.state.contains(PhysicsState::ETHEREAL);
        if passed { TransitionState::Ok } else { state }
    }

    /// `C-31`.
    fn is_mover(&self, object: ObjectRef, body: &Body) -> bool {
        match self.profile().same_object {
            SameObject::Identity => self.object.object == Some(object),
            SameObject::Guid => self.object.object == Some(object) || body.guid == self.object.guid,
        }
    }

    /// House barriers (13.6, `C-15`).
    fn check_entry_restrictions(&mut self, cell: CellRef<'w>) -> TransitionState {
        let barriers = self.profile().house_barriers;
        if self.object.object.is_none() && barriers != HouseBarriers::PlayersOnce {
            return TransitionState::Collided;
        }
        let guid = cell.base().restriction;
        let is_player = self.object.state.contains(ObjectInfoState::IS_PLAYER);
        if guid == 0 || !is_player || barriers == HouseBarriers::Absent {
            return TransitionState::Ok;
        }
        let begins_here = self
            .path
            .begin_cell
            .is_some_and(|begin| self.world.land.cell_id(begin) == cell.id());
        let once = barriers == HouseBarriers::PlayersOnce;
        if once && (begins_here || self.object.barrier_passed) {
            return TransitionState::Ok;
        }
        if self.object.bypasses_restrictions || self.house_admits(guid) {
            self.object.barrier_passed = true;
            return TransitionState::Ok;
        }
        if let CellRef::Land(land) = cell {
            let normal = self.barrier_normal(land);
            self.set_collision_normal(normal);
        }
        TransitionState::Collided
    }

    /// Whether the house object with that GUID is there and lets the mover in.
    fn house_admits(&self, house: u32) -> bool {
        let house = self.world.entity_of_guid(house);
        house
            .and_then(|id| self.world.entity(id)?.weenie.as_ref())
            .is_some_and(|weenie| weenie.admits(self.object.guid))
    }

    /// From which side the mover meets a barred outdoor cell (`handle_move_restriction`).
    fn barrier_normal(&self, land: LandCellRef<'_>) -> Vec3 {
        const HALF: f32 = CELL_LENGTH / 2.0;
        let o = land.position().offset_to(&self.path.curr_pos);
        if o.y < -HALF {
            Vec3::NEG_Y
        } else if o.y > HALF {
            Vec3::Y
        } else if o.x < -HALF {
            Vec3::NEG_X
        } else {
            Vec3::X
        }
    }
}
