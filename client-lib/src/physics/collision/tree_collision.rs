//! What a tree of collision polygons does to a mover (`spec/04-collision-primitives.md`, section 11).
//!
//! The caller has expressed the mover's spheres in the tree's space with
//! [`cache_localspace_sphere`](crate::physics::transition::SpherePath::cache_localspace_sphere).

use super::LANDING_Z;
use super::physics_tree::{PhysicsTree, PolygonIndex, SolidSearch, TouchedPolygon, WalkableSearch};
use super::polygon::PlacementSolidity;
use crate::math::{Sphere, Vec3};
use crate::physics::transition::{InsertType, ObjectInfoState, Transition, TransitionState};

/// Rounds of the search for a free place.
const PLACEMENT_ROUNDS: usize = 20;

/// A vector of the tree's space in block coordinates, without scale.
fn to_global(t: &Transition<'_>, v: Vec3) -> Vec3 {
    t.path
        .localspace_pos
        .frame
        .local_to_global_vec(v, t.profile())
}

impl PhysicsTree {
    /// Tests the tree against the mover (11.1). `scale` is the uniform scale of the tree's owner.
    ///
    /// May move the check position, write walk interp, allowance, contact plane, walkable polygon, collision normal, collide state and the
    /// negative hit, and try a step up.
    pub fn find_collisions<'w>(&'w self, t: &mut Transition<'w>, scale: f32) -> TransitionState {
        if t.path.insert_type == InsertType::Placement || t.path.obstruction_ethereal {
            return self.placement_test(t);
        }
        if t.path.check_walkable {
            return self.check_walkable(t);
        }
        if t.path.step_down {
            return self.step_sphere_down(t, scale);
        }
        if t.path.collide {
            return self.land(t, scale);
        }
        if t.object.state.contains(ObjectInfoState::CONTACT) {
            return self.respond_in_contact(t);
        }
        if t.object.state.contains(ObjectInfoState::PATH_CLIPPED) {
            return self.stop(t);
        }
        self.respond_in_air(t)
    }

    /// Movement of the mover's first sphere in the tree's space; it stands for both spheres.
    fn movement(t: &Transition<'_>) -> Vec3 {
        t.path.localspace_sphere[0].center - t.path.localspace_curr_center[0]
    }

    /// Whether the centre of a sphere counts as solid. A building's inside is solid only as long as no interior cell is touched.
    fn center_check(t: &Transition<'_>) -> bool {
        !(t.path.bldg_check && t.path.hits_interior_cell)
    }

    fn placement_test(&self, t: &Transition<'_>) -> TransitionState {
        let center_check = Self::center_check(t);
        let solid = t.path.localspace_sphere[..t.path.num_sphere.clamp(1, 2)]
            .iter()
            .any(|sphere| self.sphere_intersects_solid(sphere, center_check, t.profile()));
        if solid {
            TransitionState::Collided
        } else {
            TransitionState::Ok
        }
    }

    /// Collided when there is walkable ground under the first sphere (11.2).
    fn check_walkable(&self, t: &Transition<'_>) -> TransitionState {
        let sphere = &t.path.localspace_sphere[0];
        if self.hits_walkable(
            sphere,
            t.path.localspace_z,
            t.path.walkable_allowance,
            t.profile(),
        ) {
            TransitionState::Collided
        } else {
            TransitionState::Ok
        }
    }

    /// The polygon that mover sphere `index` touches, and whether the movement goes against it.
    fn touched_by(&self, t: &Transition<'_>, index: usize) -> (Option<PolygonIndex>, bool) {
        let mut touched = TouchedPolygon::default();
        let hit = self.sphere_intersects_poly(
            &t.path.localspace_sphere[index],
            Self::movement(t),
            &mut touched,
            t.profile(),
        );
        (touched.polygon, hit)
    }

    /// Normal of a polygon in block coordinates.
    fn global_normal(&self, t: &Transition<'_>, index: PolygonIndex) -> Vec3 {
        self.polygon(index)
            .map_or(Vec3::ZERO, |polygon| to_global(t, polygon.plane.n))
    }

    /// Looks for ground along `movement` with a copy of the first sphere; walk interp is lowered even if a later polygon replaces the result.
    fn search_ground(&self, t: &mut Transition<'_>, movement: Vec3) -> WalkableSearch {
        let mut search = WalkableSearch {
            sphere: t.path.localspace_sphere[0],
            movement,
            up: t.path.localspace_z,
            walkable_allowance: t.path.walkable_allowance,
            walk_interp: t.path.walk_interp,
            found: None,
        };
        self.find_walkable(&mut search, t.profile());
        t.path.walk_interp = search.walk_interp;
        search
    }

    /// Makes the polygon that was found the ground. Quirk: the plane's distance, which includes the owner's place, is multiplied by the scale.
    fn stand_on<'w>(&'w self, t: &mut Transition<'w>, search: &WalkableSearch, scale: f32) {
        let Some(polygon) = search.found.and_then(|index| self.polygon(index)) else {
            return;
        };
        let localspace_pos = t.path.localspace_pos;
        let mut plane =
            polygon
                .plane
                .local_to_global(&t.path.check_pos, &localspace_pos, t.profile());
        plane.d *= scale;
        t.set_contact_plane(plane, false);
        t.info.contact_plane.cell_id = t.path.check_pos.cell;
        let up = t.path.localspace_z;
        t.path
            .set_walkable(search.sphere, polygon, up, localspace_pos, scale);
    }

    /// Lowers the mover onto the ground (11.3).
    fn step_sphere_down<'w>(&'w self, t: &mut Transition<'w>, scale: f32) -> TransitionState {
        let drop = -(t.path.step_down_amt * t.path.walk_interp);
        let movement = t.path.localspace_z * drop * (1.0 / scale);
        let search = self.search_ground(t, movement);
        if search.found.is_none() {
            return TransitionState::Ok;
        }
        let turned = to_global(t, search.sphere.center - t.path.localspace_sphere[0].center);
        // `04:B1`.
        let offset = if t.profile().bsp_step_down_scaled {
            turned * scale
        } else {
            turned
        };
        // The cell array stays valid here, unlike in any other move of the check position.
        t.path.check_pos.frame.origin += offset;
        t.path.shift_global_sphere(offset);
        self.stand_on(t, &search, scale);
        TransitionState::Adjusted
    }

    /// Landing retry: takes the mover back along its way onto the ground (11.5).
    fn land<'w>(&'w self, t: &mut Transition<'w>, scale: f32) -> TransitionState {
        let search = self.search_ground(t, Self::movement(t));
        if search.found.is_none() {
            return TransitionState::Ok;
        }
        let turned = to_global(t, search.sphere.center - t.path.localspace_sphere[0].center);
        t.add_offset_to_check_pos(turned * scale);
        self.stand_on(t, &search, scale);
        TransitionState::Adjusted
    }

    /// A mover on the ground runs into polygons (11.4). A mover with one sphere never notes a negative hit.
    fn respond_in_contact(&self, t: &mut Transition<'_>) -> TransitionState {
        let (lower, hit) = self.touched_by(t, 0);
        if let (Some(index), true) = (lower, hit) {
            let normal = self.global_normal(t, index);
            return if t.step_up(normal) {
                TransitionState::Ok
            } else {
                t.step_up_slide()
            };
        }
        if t.path.num_sphere > 1 {
            let (upper, hit) = self.touched_by(t, 1);
            match (upper, lower) {
                (Some(index), _) if hit => return self.slide(t, index),
                (Some(index), _) => {
                    let normal = self.global_normal(t, index);
                    t.path.set_neg_poly_hit(false, normal);
                }
                (None, Some(index)) => {
                    let normal = self.global_normal(t, index);
                    t.path.set_neg_poly_hit(true, normal);
                }
                (None, None) => {}
            }
        }
        TransitionState::Ok
    }

    /// Slides along a polygon (11.9): always the first sphere, whichever one hit.
    fn slide(&self, t: &mut Transition<'_>, index: PolygonIndex) -> TransitionState {
        let mut normal = self.global_normal(t, index);
        let center = t.path.global_sphere[0].center;
        let current = t.path.global_curr_center[0];
        t.slide_sphere(center, &mut normal, current)
    }

    /// A path-clipped mover stops at what it touches (rule 6). `04:B2` for the second sphere.
    fn stop(&self, t: &mut Transition<'_>) -> TransitionState {
        if let (Some(index), _) = self.touched_by(t, 0) {
            return self.collide_with_point(t, index);
        }
        if t.profile().path_clipped_second_sphere
            && t.path.num_sphere > 1
            && let (Some(index), _) = self.touched_by(t, 1)
        {
            let normal = self.global_normal(t, index);
            t.set_collision_normal(normal);
            return TransitionState::Collided;
        }
        TransitionState::Ok
    }

    /// Stops at a polygon (11.7). An exact clip would need the search of 11.8, which fails in every reference.
    fn collide_with_point(&self, t: &mut Transition<'_>, index: PolygonIndex) -> TransitionState {
        if !t.object.state.contains(ObjectInfoState::PERFECT_CLIP) {
            let normal = self.global_normal(t, index);
            t.set_collision_normal(normal);
        }
        TransitionState::Collided
    }

    /// An airborne mover hits something (rule 7): the landing is decided later, nothing moves.
    fn respond_in_air(&self, t: &mut Transition<'_>) -> TransitionState {
        if let (Some(index), _) = self.touched_by(t, 0) {
            let normal = self.global_normal(t, index);
            t.path.walkable_allowance = LANDING_Z;
            t.set_collide(normal);
            return TransitionState::Adjusted;
        }
        if t.path.num_sphere > 1
            && let (Some(index), _) = self.touched_by(t, 1)
        {
            let normal = self.global_normal(t, index);
            t.set_collision_normal(normal);
            return TransitionState::Collided;
        }
        TransitionState::Ok
    }

    /// Pushes the mover out of solid matter (11.10): Ok where it is, Adjusted elsewhere, Collided after 20 rounds.
    ///
    /// Quirk: the shift is not multiplied by the owner's scale.
    pub fn placement_insert(&self, t: &mut Transition<'_>) -> TransitionState {
        let center_check = Self::center_check(t);
        let mut search = SolidSearch::default();
        let mut spheres = t.path.localspace_sphere;
        let count = t.path.num_sphere.clamp(1, 2);
        let mut radius = spheres[0].radius;
        for round in 0..PLACEMENT_ROUNDS {
            search.center_solid = false;
            let stuck = (0..count).find(|&i| {
                self.sphere_intersects_solid_poly(
                    &spheres[i],
                    radius,
                    &mut search,
                    center_check,
                    t.profile(),
                )
            });
            match (stuck, search.hit.and_then(|index| self.polygon(index))) {
                (None, _) => return accept_placement(t, &spheres[0], round),
                (Some(struck), Some(polygon)) => {
                    let solidity = PlacementSolidity {
                        center_solid: search.center_solid,
                        solid_check: center_check,
                    };
                    let center = spheres[struck].center;
                    let shift = polygon.placement_offset(center, radius, solidity, t.profile());
                    for sphere in &mut spheres {
                        sphere.center += shift;
                    }
                }
                // In solid matter, but no polygon is known: look further around.
                (Some(_), None) => radius *= 2.0,
            }
        }
        TransitionState::Collided
    }
}

fn accept_placement(t: &mut Transition<'_>, placed: &Sphere, round: usize) -> TransitionState {
    if round == 0 {
        return TransitionState::Ok;
    }
    let offset = to_global(t, placed.center - t.path.localspace_sphere[0].center);
    t.add_offset_to_check_pos(offset);
    TransitionState::Adjusted
}
