//! Terrain contact (`spec/05-transition.md`, 7.4): what an outdoor cell asks with the first sphere and the triangle under its lowest point.

use super::object_info::is_valid_walkable;
use super::state::{Transition, TransitionState};
use crate::math::{CellId, EPSILON, Plane, Sphere, Vec3};
use crate::profile::Width;

/// The terrain triangle under a mover.
#[derive(Debug, Clone, Copy)]
pub struct TerrainContact {
    /// Its plane, block coordinates of `cell_id`.
    pub plane: Plane,
    /// Water: the plane is not extended.
    pub is_water: bool,
    /// How far below the plane the mover stands, m.
    pub water_depth: f32,
    /// The outdoor cell.
    pub cell_id: CellId,
}

impl Transition<'_> {
    /// Rests the mover's first `sphere` (block coordinates of the terrain's cell) on a terrain triangle (`validate_walkable`).
    ///
    /// The push is purely vertical whatever the slope: terrain never slides a sphere by itself. Answers
    /// [`TransitionState::Collided`] only while probing for ground or when a step down would have to lift the mover too far.
    pub fn validate_walkable(
        &mut self,
        sphere: &Sphere,
        terrain: &TerrainContact,
    ) -> TransitionState {
        if self.object.is_viewer() {
            return self.viewer_over_terrain(sphere, terrain);
        }
        let Plane { n, d } = terrain.plane;
        let low = sphere.center - Vec3::new(0.0, 0.0, sphere.radius);
        let distance = low.dot(n) + d + terrain.water_depth;
        let may = self.path.step_down
            || !self.object.on_walkable()
            || is_valid_walkable(n, self.profile());
        if distance > EPSILON {
            return TransitionState::Ok;
        }
        if distance >= -EPSILON {
            if may {
                self.touch_terrain(terrain);
            }
            self.note_airborne_terrain_hit(n);
            return TransitionState::Ok;
        }
        if self.path.check_walkable {
            return TransitionState::Collided;
        }
        if !may {
            self.note_airborne_terrain_hit(n);
            return self.too_steep();
        }
        self.lift_out_of_terrain(distance / n.z, terrain)
    }

    /// Penetrating ground too steep to walk, while walking: a step down and `cliff_slide` follow.
    ///
    /// `T-03`: profile `ace` answers Adjusted although nothing moved, so that the step is taken back.
    fn too_steep(&self) -> TransitionState {
        if self.profile().steep_penetration_adjusts {
            TransitionState::Adjusted
        } else {
            TransitionState::Ok
        }
    }

    /// Raises the mover by `-z` metres onto the triangle, if a step down allows that much.
    fn lift_out_of_terrain(&mut self, z: f32, terrain: &TerrainContact) -> TransitionState {
        self.touch_terrain(terrain);
        if self.path.step_down {
            // A contact plane that was refused stays.
            let Some(w) = self.walk_interp_after(z) else {
                return TransitionState::Collided;
            };
            self.path.walk_interp = w;
        }
        self.add_offset_to_check_pos(Vec3::new(0.0, 0.0, -z));
        self.note_airborne_terrain_hit(terrain.plane.n);
        TransitionState::Adjusted
    }

    /// Share of the step down that is left after a lift of `-z` metres; `None` if it is not in (-0.1, walk_interp), NaN being in.
    fn walk_interp_after(&self, z: f32) -> Option<f32> {
        let (amount, interp) = (self.path.step_down_amt, self.path.walk_interp);
        match self.profile().walk_interp_width {
            Width::F32 => {
                let w = (1.0 - (-1.0 / (amount * interp)) * z) * interp;
                let refused = w >= interp || w < -0.1;
                (!refused).then_some(w)
            }
            Width::F64 => {
                let (z, wide) = (f64::from(z), f64::from(interp));
                let w = (1.0 - (-1.0 / f64::from(amount * interp)) * z) * wide;
                let refused = w >= wide || w < -0.1;
                (!refused).then_some(w as f32)
            }
        }
    }

    fn touch_terrain(&mut self, terrain: &TerrainContact) {
        self.info.set_contact_plane(terrain.plane, terrain.is_water);
        self.info.contact_plane.cell_id = terrain.cell_id;
    }

    /// A mover that was in the air (and is not being lowered) has hit the environment.
    fn note_airborne_terrain_hit(&mut self, normal: Vec3) {
        if !self.object.in_contact() && !self.path.step_down {
            self.set_collision_normal(normal);
            self.info.collided_with_environment = true;
        }
    }

    /// The camera stops where its sphere touches the terrain.
    ///
    /// `T-04`: the references let it through only if it also began indoors, which divides by zero over flat ground.
    fn viewer_over_terrain(
        &mut self,
        sphere: &Sphere,
        terrain: &TerrainContact,
    ) -> TransitionState {
        let Plane { n, d } = terrain.plane;
        let distance = n.dot(sphere.center) + d - sphere.radius;
        let began_indoors = self.path.begin_pos.is_some_and(|p| p.cell.is_indoor());
        let counts = began_indoors || !self.profile().viewer_needs_indoor_start;
        if distance > -EPSILON && counts {
            return TransitionState::Ok;
        }
        let way = sphere.center - self.path.global_curr_center[0];
        let t = distance / way.dot(n);
        if began_indoors && (t <= 0.0 || t > 1.0) {
            return TransitionState::Ok;
        }
        self.add_offset_to_check_pos(way * -t);
        self.set_collision_normal(n);
        self.info.collided_with_environment = true;
        TransitionState::Adjusted
    }
}
