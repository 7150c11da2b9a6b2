//! Beginning a transition (`spec/05-transition.md`, 6.2 to 6.8).

use super::slots::LeftFields;
use super::state::{CollisionInfo, InsertType, ObjectInfo, Transition};
use crate::math::vector::normalize_check_small;
use crate::math::{CellId, Plane, Position, Sphere, Vec3};
use crate::profile::{LastKnownCell, Profile};
use crate::world::CellHandle;

impl CollisionInfo {
    /// Forgets what was touched: flags, objects and counters. Planes, water flags and the last known cell id stay (9, `init`).
    pub fn reset(&mut self) {
        self.contact_plane.valid = false;
        self.contact_plane.cell_id = CellId::NONE;
        self.last_known_contact_plane.valid = false;
        self.sliding_normal_valid = false;
        self.collision_normal_valid = false;
        self.collide_object.clear();
        self.last_collided_object = None;
        self.collided_with_environment = false;
        self.frames_stationary_fall = 0;
    }

    /// The mover touches `plane` (block coordinates of `cell`), and did before (`init_contact_plane`).
    pub fn init_contact_plane(&mut self, cell: CellId, plane: Plane, is_water: bool) {
        self.set_contact_plane(plane, is_water);
        self.contact_plane.cell_id = cell;
        self.last_known_contact_plane = self.contact_plane;
    }

    /// The mover is leaving `plane` (`init_last_known_contact_plane`).
    ///
    /// `T-14`: the cell id goes into the contact plane's field; the last known one keeps its stale value, except in profile `ace`.
    pub fn init_last_known_contact_plane(
        &mut self,
        cell: CellId,
        plane: Plane,
        is_water: bool,
        profile: &Profile,
    ) {
        self.last_known_contact_plane.valid = true;
        self.last_known_contact_plane.plane = plane;
        self.last_known_contact_plane.is_water = is_water;
        match profile.last_known_cell {
            LastKnownCell::Right => self.last_known_contact_plane.cell_id = cell,
            LastKnownCell::StaleZero | LastKnownCell::StaleSlot => {
                self.contact_plane.cell_id = cell;
            }
        }
    }

    /// The mover slides along a wall with this normal; too short a vector becomes zero and is still valid.
    pub fn init_sliding_normal(&mut self, normal: Vec3) {
        self.sliding_normal_valid = true;
        self.sliding_normal = normalize_check_small(normal).unwrap_or(Vec3::ZERO);
    }
}

impl<'w> Transition<'w> {
    /// Gives the fields that `init` leaves alone what the slot's last use left in them, as far as the profile has that (`T-14`, `T-25`).
    ///
    /// Of the fields that the specification marks "left", only these can be seen before they are written.
    pub(super) fn take_left_fields(&mut self, left: &LeftFields) {
        let profile = self.profile();
        if profile.left_fields_from_slot {
            self.info.contact_plane.plane = left.contact_plane;
            self.info.contact_plane.is_water = left.contact_plane_is_water;
            self.info.last_known_contact_plane.plane = left.last_known_contact_plane;
            self.info.last_known_contact_plane.is_water = left.last_known_contact_plane_is_water;
            self.info.sliding_normal = left.sliding_normal;
            self.info.collision_normal = left.collision_normal;
        }
        if profile.last_known_cell == LastKnownCell::StaleSlot {
            self.info.last_known_contact_plane.cell_id = left.last_known_cell_id;
        }
    }

    /// Names the mover (6.3).
    pub fn init_object(&mut self, mover: &ObjectInfo) {
        self.object = *mover;
        self.object.velocity_killed = false;
    }

    /// Takes the first two spheres, given in the object's own frame, times `scale` (6.4).
    pub fn init_sphere(&mut self, spheres: &[Sphere], scale: f32) {
        self.path.num_sphere = spheres.len().min(2);
        for (to, from) in self.path.local_sphere.iter_mut().zip(spheres) {
            *to = from.scaled(scale);
        }
        let Sphere { center, radius } = self.path.local_sphere[0];
        self.path.local_low_point = Vec3::new(center.x, center.y, center.z - radius);
    }

    /// Sets the path: a movement from `begin` to `end`, or without `begin` a placement at `end` (6.5).
    pub fn init_path(
        &mut self,
        begin_cell: Option<CellHandle>,
        begin: Option<Position>,
        end: Position,
    ) {
        let profile = self.profile();
        let path = &mut self.path;
        path.begin_cell = begin_cell;
        path.begin_pos = begin;
        path.end_pos = end;
        (path.curr_pos, path.insert_type) = match begin {
            Some(begin) => (begin, InsertType::Transition),
            None => (end, InsertType::Placement),
        };
        path.curr_cell = begin_cell;
        path.cache_global_curr_center(profile);
    }
}
