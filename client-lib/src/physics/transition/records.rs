//! Operations on the records of a transition that the collision primitives need (`spec/04-collision-primitives.md`, 4.4;
//! `spec/05-transition.md`, sections 8 and 9), and the slide along a surface normal (04, 8.9 variant A).
//!
//! "Block coordinates" are metres local to the landblock of the named position. No operation here fails or allocates.

use super::state::{
    CellArray, CollisionInfo, ContactPlane, InsertType, ObjectInfo, ObjectInfoState, Progress,
    SpherePath, Transition, TransitionState,
};
use crate::math::vector::normalize_check_small;
use crate::math::{CellId, EPSILON, Frame, Plane, Position, Sphere, Vec3, block_offset};
use crate::physics::collision::Polygon;
use crate::physics::state::PhysicsState;
use crate::profile::{Profile, Width};
use crate::world::World;

impl ContactPlane {
    /// What nobody has set: not valid, zero plane, no cell.
    pub const NONE: Self = Self {
        valid: false,
        plane: Plane::ZERO,
        cell_id: CellId::NONE,
        is_water: false,
    };
}

impl ObjectInfo {
    /// No mover.
    pub const NONE: Self = Self {
        object: None,
        guid: 0,
        state: ObjectInfoState::empty(),
        physics_state: PhysicsState::empty(),
        scale: 0.0,
        step_up_height: 0.0,
        step_down_height: 0.0,
        ethereal: false,
        step_down: false,
        target_id: 0,
        creature: false,
        bypasses_restrictions: false,
        barrier_passed: false,
        velocity_killed: false,
    };

    /// Asks the caller to set the mover's velocity to zero after the transition (05, 7.2).
    pub fn kill_velocity(&mut self) {
        self.velocity_killed = true;
    }
}

impl Default for SpherePath<'_> {
    /// The path of a fresh transition: every field zero, no cell, sliding placements allowed (05, 5.2).
    fn default() -> Self {
        Self::FRESH
    }
}

impl SpherePath<'_> {
    /// See [`SpherePath::default`]. One constant, so that beginning a transition is one copy.
    const FRESH: Self = {
        let sphere = Sphere::new(Vec3::ZERO, 0.0);
        let position = Position {
            cell: CellId::NONE,
            frame: Frame::IDENTITY,
        };
        Self {
            num_sphere: 0,
            local_sphere: [sphere; 2],
            local_low_point: Vec3::ZERO,
            global_sphere: [sphere; 2],
            global_low_point: Vec3::ZERO,
            localspace_sphere: [sphere; 2],
            localspace_low_point: Vec3::ZERO,
            localspace_curr_center: [Vec3::ZERO; 2],
            global_curr_center: [Vec3::ZERO; 2],
            localspace_pos: position,
            localspace_z: Vec3::ZERO,
            begin_cell: None,
            begin_pos: None,
            end_pos: position,
            curr_cell: None,
            curr_pos: position,
            check_cell: None,
            check_pos: position,
            global_offset: Vec3::ZERO,
            step_up: false,
            step_up_normal: Vec3::ZERO,
            collide: false,
            insert_type: InsertType::Transition,
            backup: InsertType::Transition,
            step_down: false,
            step_down_amt: 0.0,
            walk_interp: 0.0,
            backup_cell: None,
            backup_check_pos: position,
            obstruction_ethereal: false,
            hits_interior_cell: false,
            bldg_check: false,
            walkable_allowance: 0.0,
            check_walkable: false,
            walkable: None,
            walkable_check_pos: sphere,
            walkable_up: Vec3::ZERO,
            walkable_pos: position,
            walkable_scale: 0.0,
            cell_array_valid: false,
            neg_poly_hit: false,
            neg_step_up: false,
            neg_collision_normal: Vec3::ZERO,
            placement_allows_sliding: true,
        }
    };
}

impl Default for CollisionInfo {
    /// Nothing was touched.
    fn default() -> Self {
        Self {
            contact_plane: ContactPlane::NONE,
            last_known_contact_plane: ContactPlane::NONE,
            sliding_normal_valid: false,
            sliding_normal: Vec3::ZERO,
            collision_normal_valid: false,
            collision_normal: Vec3::ZERO,
            collide_object: Vec::new(),
            last_collided_object: None,
            collided_with_environment: false,
            frames_stationary_fall: 0,
        }
    }
}

impl CollisionInfo {
    /// Makes `plane` (block coordinates of the check position) the contact plane. The cell id stays: the callers that know it set it.
    pub fn set_contact_plane(&mut self, plane: Plane, is_water: bool) {
        self.contact_plane.valid = true;
        self.contact_plane.plane = plane;
        self.contact_plane.is_water = is_water;
    }

    /// Nothing is touched: the plane and its cell stay where they are.
    pub fn void_contact_plane(&mut self) {
        self.contact_plane.valid = false;
        self.contact_plane.is_water = false;
    }

    /// Stores the normal of an obstacle, block coordinates; a vector shorter than ε becomes zero and is still valid.
    ///
    /// `T-01`: profile `ace` stores the vector as it comes.
    pub fn set_collision_normal(&mut self, normal: Vec3, profile: &Profile) {
        self.collision_normal_valid = true;
        self.collision_normal = match normalize_check_small(normal) {
            None => Vec3::ZERO,
            Some(unit) if profile.collision_normal_normalized => unit,
            Some(_) => normal,
        };
    }

    /// Stores the horizontal part of the normal of a wall to slide along; too small a part becomes zero and is still valid.
    ///
    /// `T-02`: profile `ace` tests the length of the whole vector and does not normalise.
    pub fn set_sliding_normal(&mut self, normal: Vec3, profile: &Profile) {
        self.sliding_normal_valid = true;
        let level = Vec3::new(normal.x, normal.y, 0.0);
        self.sliding_normal = if profile.sliding_normal_normalized {
            normalize_check_small(level).unwrap_or(Vec3::ZERO)
        } else {
            normalize_check_small(normal).map_or(Vec3::ZERO, |_| level)
        };
    }

    /// Normal that a slide takes for the ground: of the contact plane, else of the last known one whether or not that is valid.
    pub fn ground_normal(&self) -> Vec3 {
        if self.contact_plane.valid {
            self.contact_plane.plane.n
        } else {
            self.last_known_contact_plane.plane.n
        }
    }
}

impl<'w> SpherePath<'w> {
    /// Computes where the mover's spheres are at the current position (`cache_global_curr_center`).
    pub fn cache_global_curr_center(&mut self, profile: &Profile) {
        for i in 0..self.num_sphere {
            self.global_curr_center[i] = self
                .curr_pos
                .frame
                .local_to_global(self.local_sphere[i].center, profile);
        }
    }

    /// Computes where the mover's spheres are at the check position (`cache_global_sphere` without an offset).
    pub fn cache_global_sphere(&mut self, profile: &Profile) {
        let frame = &self.check_pos.frame;
        for i in 0..self.num_sphere {
            self.global_sphere[i] = Sphere {
                center: frame.local_to_global(self.local_sphere[i].center, profile),
                radius: self.local_sphere[i].radius,
            };
        }
        self.global_low_point = frame.local_to_global(self.local_low_point, profile);
    }

    /// Moves the spheres at the check position by `offset` (m), without moving the check position (`cache_global_sphere` with an offset).
    pub fn shift_global_sphere(&mut self, offset: Vec3) {
        for i in 0..self.num_sphere {
            self.global_sphere[i].center += offset;
        }
        self.global_low_point += offset;
    }

    /// Moves the check position and its spheres by `offset` (m). What is cached in the obstacle's space stays.
    pub fn add_offset_to_check_pos(&mut self, offset: Vec3) {
        self.cell_array_valid = false;
        self.check_pos.frame.origin += offset;
        self.shift_global_sphere(offset);
    }

    /// Expresses the mover's spheres, at the current and at the check position, in the space of an obstacle at `pos` with uniform `scale`.
    ///
    /// A scale of zero gives infinities or NaN, which hit nothing. `T-26`: profile `gdle` multiplies the radius in f64.
    pub fn cache_localspace_sphere(&mut self, pos: &Position, scale: f32, profile: &Profile) {
        let inverse = 1.0 / scale;
        // As `Position::local_to_local`, with what is the same for all spheres computed once.
        let from_curr = block_offset(pos.cell, self.curr_pos.cell);
        let from_check = block_offset(pos.cell, self.check_pos.cell);
        let (space, curr, check) = (&pos.frame, &self.curr_pos.frame, &self.check_pos.frame);
        for i in 0..self.num_sphere.min(2) {
            let local = self.local_sphere[i];
            let at_curr = from_curr + curr.local_to_global(local.center, profile);
            let at_check = from_check + check.local_to_global(local.center, profile);
            self.localspace_curr_center[i] = space.global_to_local(at_curr, profile) * inverse;
            let radius = match profile.walk_interp_width {
                Width::F32 => local.radius * inverse,
                Width::F64 => (f64::from(local.radius) * (1.0 / f64::from(scale))) as f32,
            };
            self.localspace_sphere[i] = Sphere {
                center: space.global_to_local(at_check, profile) * inverse,
                radius,
            };
        }
        self.localspace_pos = *pos;
        self.localspace_z = pos.frame.global_to_local_vec(Vec3::Z, profile);
        let foot = &self.localspace_sphere[0];
        self.localspace_low_point = foot.center - self.localspace_z * foot.radius;
    }

    /// Notes an airborne hit on a surface with that normal (block coordinates): the state under test is saved, the landing decided later.
    pub fn set_collide(&mut self, normal: Vec3) {
        self.collide = true;
        self.backup_cell = self.check_cell;
        self.backup_check_pos = self.check_pos;
        self.step_up_normal = normal;
        self.walk_interp = 1.0;
    }

    /// Notes the polygon that carries the mover: `sphere` and `up` in the polygon's space, which is at `pos` with `scale`.
    pub fn set_walkable(
        &mut self,
        sphere: Sphere,
        polygon: Polygon<'w>,
        up: Vec3,
        pos: Position,
        scale: f32,
    ) {
        self.walkable_check_pos = sphere;
        self.walkable = Some(polygon);
        self.walkable_up = up;
        self.walkable_pos = pos;
        self.walkable_scale = scale;
    }

    /// Notes a polygon that was touched although the move does not go against its normal (block coordinates).
    pub fn set_neg_poly_hit(&mut self, step_up: bool, normal: Vec3) {
        self.neg_step_up = step_up;
        self.neg_poly_hit = true;
        self.neg_collision_normal = -normal;
    }

    /// Whether ground with that component of the normal along "up" may be walked on right now. Exactly the allowance may not; NaN may not.
    pub fn is_walkable_allowable(&self, z: f32) -> bool {
        z > self.walkable_allowance
    }

    /// Vector from the current position's landblock to the check position's, m.
    pub fn curr_to_check_block_offset(&self) -> Vec3 {
        block_offset(self.curr_pos.cell, self.check_pos.cell)
    }
}

impl<'w> Transition<'w> {
    /// A transition in which nothing is set yet: no mover, no path, nothing touched.
    pub fn new(world: &'w World) -> Self {
        Self {
            world,
            object: ObjectInfo::NONE,
            path: SpherePath::default(),
            info: CollisionInfo::default(),
            cells: CellArray::default(),
            list_memo: None,
            progress: Progress::default(),
            missing: None,
        }
    }

    /// The behaviour profile.
    pub fn profile(&self) -> &'w Profile {
        &self.world.profile
    }

    /// See [`SpherePath::add_offset_to_check_pos`].
    pub fn add_offset_to_check_pos(&mut self, offset: Vec3) {
        self.path.add_offset_to_check_pos(offset);
    }

    /// See [`SpherePath::cache_localspace_sphere`].
    pub fn cache_localspace_sphere(&mut self, pos: &Position, scale: f32) {
        let profile = self.profile();
        self.path.cache_localspace_sphere(pos, scale, profile);
    }

    /// See [`SpherePath::set_collide`].
    pub fn set_collide(&mut self, normal: Vec3) {
        self.path.set_collide(normal);
    }

    /// See [`CollisionInfo::set_contact_plane`].
    pub fn set_contact_plane(&mut self, plane: Plane, is_water: bool) {
        self.info.set_contact_plane(plane, is_water);
    }

    /// See [`CollisionInfo::set_collision_normal`].
    pub fn set_collision_normal(&mut self, normal: Vec3) {
        let profile = self.profile();
        self.info.set_collision_normal(normal, profile);
    }

    /// See [`CollisionInfo::set_sliding_normal`].
    pub fn set_sliding_normal(&mut self, normal: Vec3) {
        let profile = self.profile();
        self.info.set_sliding_normal(normal, profile);
    }

    /// Slides along the surface of the obstacle that a step up did not overcome (`step_up_slide`).
    pub fn step_up_slide(&mut self) -> TransitionState {
        self.info.void_contact_plane();
        self.path.step_up = false;
        let mut normal = self.path.step_up_normal;
        let result = self.slide_sphere(
            self.path.global_sphere[0].center,
            &mut normal,
            self.path.global_curr_center[0],
        );
        self.path.step_up_normal = normal;
        result
    }

    /// Slides a mover sphere along a surface (`CSphere::slide_sphere`, 04, 8.9 variant A).
    ///
    /// `center` is the sphere's centre at the check position, `curr_center` at the current one, each in its position's block coordinates;
    /// `normal` is the surface's normal in block coordinates, used as given, and may be replaced by the reversed direction of the move.
    /// Writes the collision normal and moves the check position.
    ///
    /// Quirks: a slide shorter than √ε (14.1 mm) along the crease of surface and ground is a collision; a surface that opposes the ground,
    /// a ceiling, answers [`TransitionState::Ok`] without moving anything.
    pub fn slide_sphere(
        &mut self,
        center: Vec3,
        normal: &mut Vec3,
        curr_center: Vec3,
    ) -> TransitionState {
        if *normal == Vec3::ZERO {
            self.add_offset_to_check_pos((curr_center - center) * 0.5);
            return TransitionState::Adjusted;
        }
        self.set_collision_normal(*normal);
        let step = self.path.curr_to_check_block_offset() + (center - curr_center);
        let ground = self.info.ground_normal();
        let crease = normal.cross(ground);
        let crease_squared = crease.length_squared();
        if crease_squared >= EPSILON {
            return self.slide_along_crease(crease, crease_squared, step);
        }
        if normal.dot(ground) >= 0.0 {
            self.add_offset_to_check_pos(-*normal * normal.dot(step));
            return TransitionState::Slid;
        }
        *normal = -step;
        if let Some(unit) = normalize_check_small(*normal) {
            *normal = unit;
            self.set_collision_normal(unit);
        }
        TransitionState::Ok
    }

    /// Replaces the step (m) by its part along a crease.
    pub(crate) fn slide_along_crease(
        &mut self,
        crease: Vec3,
        crease_squared: f32,
        step: Vec3,
    ) -> TransitionState {
        let along = crease * crease.dot(step) * (1.0 / crease_squared);
        if along.length_squared() < EPSILON {
            return TransitionState::Collided;
        }
        self.add_offset_to_check_pos(along - step);
        TransitionState::Slid
    }
}
