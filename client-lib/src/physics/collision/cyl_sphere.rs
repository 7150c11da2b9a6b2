//! Upright cylinders as obstacles of a transition (`spec/04-collision-primitives.md`, section 9).
//!
//! The axis is the world's +Z whatever the obstacle's orientation. `ρ` is the horizontal distance of the axes at which mover and obstacle
//! count as touching. Displacements are measured from the middle of the bottom disc.

use super::polygon::{WalkLimit, lowered_walk_interp};
use super::sphere::{LANDING_Z, MoverSphere, land_on_top, set_object_plane};
use crate::dat::CylSphere;
use crate::math::vector::normalize_check_small;
use crate::math::{EPSILON, Plane, Position, Sphere, Vec3};
use crate::physics::transition::{InsertType, ObjectInfoState, Transition, TransitionState};
use crate::profile::{CylinderLanding, CylinderPlane, PerfectClip, Profile};

/// Direction in which a cylinder pushes a sphere away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CylinderNormal {
    /// Towards the sphere's current centre, horizontal and not normalised, or straight up or down.
    pub normal: Vec3,
    /// Whether the side that was hit (shaft, top, bottom) is certain.
    pub definite: bool,
}

/// A mover sphere that touches, or may touch, the cylinder.
#[derive(Debug, Clone, Copy)]
struct Touch {
    mover: MoverSphere,
    /// Number of the mover's sphere.
    index: usize,
    /// From the cylinder's base to the sphere's centre.
    displacement: Vec3,
    /// Touching distance ρ.
    reach: f32,
}

/// Squared horizontal length.
fn level_squared(v: Vec3) -> f32 {
    v.x * v.x + v.y * v.y
}

impl CylSphere {
    /// Touching distance of a mover sphere of that radius (9.4). `04:A5`: profile `gdle` adds the radii first.
    pub fn reach(&self, mover_radius: f32, profile: &Profile) -> f32 {
        if profile.cylinder_rho_sum_first {
            self.radius + mover_radius - EPSILON
        } else {
            self.radius - EPSILON + mover_radius
        }
    }

    /// Whether the height of a sphere's centre above the base is within the cylinder's, grown by the sphere's radius.
    fn within_height(&self, radius: f32, z: f32) -> bool {
        let half = self.height * 0.5;
        radius - EPSILON + half >= (half - z).abs()
    }

    /// Whether a sphere at `displacement` from the base touches (9.1): flat ends, no rounded caps.
    pub fn collides_with_sphere(&self, sphere: &Sphere, displacement: Vec3, reach: f32) -> bool {
        level_squared(displacement) <= reach * reach
            && self.within_height(sphere.radius, displacement.z)
    }

    /// The normal of a collision with mover sphere `index` (9.2). Quirk: the current centre is taken without a block offset.
    pub fn normal_of_collision(
        &self,
        t: &Transition<'_>,
        index: usize,
        displacement: Vec3,
        reach: f32,
    ) -> CylinderNormal {
        let radius = t.path.global_sphere[index].radius;
        let q = t.path.global_curr_center[index] - self.low;
        if reach * reach < level_squared(q) {
            return CylinderNormal {
                normal: Vec3::new(q.x, q.y, 0.0),
                definite: self.within_height(radius, q.z)
                    || (q.z - displacement.z).abs() <= EPSILON,
            };
        }
        let up = displacement.z - q.z <= 0.0;
        CylinderNormal {
            normal: Vec3::new(0.0, 0.0, if up { 1.0 } else { -1.0 }),
            definite: true,
        }
    }

    /// Tests this cylinder of an object at `position` with uniform `scale` against the mover (9.3).
    pub fn intersects_sphere_at(
        &self,
        position: &Position,
        scale: f32,
        t: &mut Transition<'_>,
    ) -> TransitionState {
        let low = t
            .path
            .check_pos
            .landblock_point_of(position, self.low * scale, t.profile());
        let own = Self {
            low,
            radius: self.radius * scale,
            height: self.height * scale,
        };
        if !t.path.collide && own.hits(t, own.first_reach(t)) == [false, false] {
            // Every rule but that of landing asks for a hit.
            return TransitionState::Ok;
        }
        // Only what follows a hit looks at the obstacle's space.
        t.cache_localspace_sphere(position, 1.0);
        own.intersects_sphere(t)
    }

    /// Touching distance of the mover's first sphere.
    fn first_reach(&self, t: &Transition<'_>) -> f32 {
        self.reach(t.path.global_sphere[0].radius, t.profile())
    }

    fn touch(&self, t: &Transition<'_>, index: usize, reach: f32) -> Touch {
        let mover = MoverSphere::of(t, index);
        Touch {
            mover,
            index,
            displacement: mover.sphere.center - self.low,
            reach,
        }
    }

    fn touches(&self, touch: &Touch) -> bool {
        self.collides_with_sphere(&touch.mover.sphere, touch.displacement, touch.reach)
    }

    fn hits(&self, t: &Transition<'_>, reach: f32) -> [bool; 2] {
        [
            self.touches(&self.touch(t, 0, reach)),
            t.path.num_sphere > 1 && self.touches(&self.touch(t, 1, reach)),
        ]
    }

    /// Tests this cylinder, in check space, against the mover (9.4).
    pub fn intersects_sphere(&self, t: &mut Transition<'_>) -> TransitionState {
        let reach = self.first_reach(t);
        let hits = self.hits(t, reach);
        let blocked = if hits[0] || hits[1] {
            TransitionState::Collided
        } else {
            TransitionState::Ok
        };
        if t.path.insert_type == InsertType::Placement || t.path.obstruction_ethereal {
            return blocked;
        }
        if t.path.step_down {
            return self.step_sphere_down(t, reach);
        }
        if t.path.check_walkable {
            return blocked;
        }
        if t.path.collide {
            return match t.profile().cylinder_landing {
                CylinderLanding::FlatTop => self.land_on_flat_top(t, reach, hits),
                CylinderLanding::AsSphere => land_on_top(t, self.low, reach, hits),
            };
        }
        self.respond(t, reach, hits)
    }

    /// The mover runs into the obstacle (rules 4 to 6).
    fn respond(&self, t: &mut Transition<'_>, reach: f32, hits: [bool; 2]) -> TransitionState {
        let lower = self.touch(t, 0, reach);
        let state = t.object.state;
        if state.intersects(ObjectInfoState::CONTACT | ObjectInfoState::ON_WALKABLE) {
            if hits[0] {
                self.step_sphere_up(t, reach)
            } else if hits[1] {
                let mut upper = self.touch(t, 1, reach);
                // `04:C2`.
                if t.profile().cylinder_upper_uses_lower {
                    upper.displacement = lower.displacement;
                }
                self.slide(t, upper)
            } else {
                TransitionState::Ok
            }
        } else if state.contains(ObjectInfoState::PATH_CLIPPED) {
            if hits[0] {
                self.collide_with_point(t, lower)
            } else {
                TransitionState::Ok
            }
        } else if hits[0] {
            self.land_on(t, reach)
        } else if hits[1] {
            let upper = self.touch(t, 1, reach);
            self.collide_with_point(t, upper)
        } else {
            TransitionState::Ok
        }
    }

    fn unit_normal(&self, t: &Transition<'_>, touch: &Touch) -> Option<(Vec3, bool)> {
        let found = self.normal_of_collision(t, touch.index, touch.displacement, touch.reach);
        Some((normalize_check_small(found.normal)?, found.definite))
    }

    /// Landing retry: takes the mover back along its way until it is on the level top (9.4, rule 7).
    fn land_on_flat_top(
        &self,
        t: &mut Transition<'_>,
        reach: f32,
        hits: [bool; 2],
    ) -> TransitionState {
        if !hits[0] && !hits[1] {
            return TransitionState::Ok;
        }
        let Touch {
            mover,
            displacement,
            ..
        } = self.touch(t, 0, reach);
        let back = mover.current - mover.sphere.center - t.path.curr_to_check_block_offset();
        if back.z.abs() < EPSILON {
            return TransitionState::Collided;
        }
        let share = (self.height + mover.sphere.radius - displacement.z) / back.z;
        let offset = back * share;
        if reach * reach < level_squared(offset + displacement) {
            return TransitionState::Ok;
        }
        let profile = t.profile();
        let Some(rest) =
            lowered_walk_interp(share.into(), t.path.walk_interp, WalkLimit::Object, profile)
        else {
            return TransitionState::Collided;
        };
        let mut top = mover.sphere.center + offset;
        top.z -= mover.sphere.radius;
        set_object_plane(t, Plane::from_normal_and_point(Vec3::Z, top));
        t.path.walk_interp = rest;
        t.add_offset_to_check_pos(offset);
        TransitionState::Adjusted
    }

    /// Notes that the mover comes down on the obstacle (9.5); nothing moves, the caller tests again.
    pub fn land_on(&self, t: &mut Transition<'_>, reach: f32) -> TransitionState {
        let Some((normal, _)) = self.unit_normal(t, &self.touch(t, 0, reach)) else {
            return TransitionState::Collided;
        };
        t.set_collide(normal);
        t.path.walkable_allowance = LANDING_Z;
        TransitionState::Adjusted
    }

    /// Slides mover sphere `index` along the obstacle (9.6).
    pub fn slide_sphere(
        &self,
        t: &mut Transition<'_>,
        index: usize,
        reach: f32,
    ) -> TransitionState {
        let touch = self.touch(t, index, reach);
        self.slide(t, touch)
    }

    fn slide(&self, t: &mut Transition<'_>, touch: Touch) -> TransitionState {
        let Some((mut normal, _)) = self.unit_normal(t, &touch) else {
            return TransitionState::Collided;
        };
        t.slide_sphere(touch.mover.sphere.center, &mut normal, touch.mover.current)
    }

    /// Steps the mover up onto the obstacle, or slides it along (9.7).
    ///
    /// Quirk: the normal, in check space already, is turned once more by the obstacle's orientation.
    pub fn step_sphere_up(&self, t: &mut Transition<'_>, reach: f32) -> TransitionState {
        let touch = self.touch(t, 0, reach);
        let rise = touch.mover.sphere.radius + self.height - touch.displacement.z;
        if t.object.step_up_height < rise {
            return self.slide(t, touch);
        }
        let Some((normal, _)) = self.unit_normal(t, &touch) else {
            return TransitionState::Collided;
        };
        let turned = t
            .path
            .localspace_pos
            .frame
            .local_to_global_vec(normal, t.profile());
        if t.step_up(turned) {
            TransitionState::Ok
        } else {
            t.step_up_slide()
        }
    }

    /// Lowers the mover onto the level top (9.8).
    pub fn step_sphere_down(&self, t: &mut Transition<'_>, reach: f32) -> TransitionState {
        let hits = self.hits(t, reach);
        if !hits[0] && !hits[1] {
            return TransitionState::Ok;
        }
        let Touch {
            mover,
            displacement,
            ..
        } = self.touch(t, 0, reach);
        let span = t.path.step_down_amt * t.path.walk_interp;
        if span.abs() < EPSILON {
            return TransitionState::Collided;
        }
        let z = self.height + mover.sphere.radius - displacement.z;
        let profile = t.profile();
        let share = f64::from(z) / f64::from(span);
        let Some(rest) = lowered_walk_interp(share, t.path.walk_interp, WalkLimit::Object, profile)
        else {
            return TransitionState::Collided;
        };
        self.set_top_plane(t, mover.sphere.center.z + (z - mover.sphere.radius));
        t.path.walk_interp = rest;
        t.add_offset_to_check_pos(Vec3::new(0.0, 0.0, z));
        TransitionState::Adjusted
    }

    /// `04:C3`.
    fn set_top_plane(&self, t: &mut Transition<'_>, height: f32) {
        let cell = t.info.contact_plane.cell_id;
        let choice = t.profile().cylinder_step_down_plane;
        let point = match choice {
            CylinderPlane::ThroughZero => Vec3::new(height, 0.0, 0.0),
            CylinderPlane::TopCellSet | CylinderPlane::TopCellUnset => Vec3::new(0.0, 0.0, height),
        };
        set_object_plane(t, Plane::from_normal_and_point(Vec3::Z, point));
        if choice == CylinderPlane::TopCellUnset {
            t.info.contact_plane.cell_id = cell;
        }
    }

    /// Stops at the obstacle (9.9).
    fn collide_with_point(&self, t: &mut Transition<'_>, touch: Touch) -> TransitionState {
        let Some((normal, definite)) = self.unit_normal(t, &touch) else {
            return TransitionState::Collided;
        };
        if !t.object.state.contains(ObjectInfoState::PERFECT_CLIP) {
            t.set_collision_normal(normal);
            return TransitionState::Collided;
        }
        let clip = ExactClip::new(self, t, &touch);
        let found = if !definite {
            clip.uncertain()
        } else if normal.z != 0.0 {
            clip.cap(clip.from_base.z)
                .map(|(_, time)| ClipTime { normal, time })
        } else {
            clip.shaft()
        };
        match found {
            Some(ClipTime { normal, time }) if !is_outside_step(time) => {
                t.set_collision_normal(normal);
                t.add_offset_to_check_pos(clip.offset(time, definite));
                TransitionState::Adjusted
            }
            _ => TransitionState::Collided,
        }
    }
}

/// When and with which normal a path-clipped mover touches the cylinder.
#[derive(Debug, Clone, Copy)]
struct ClipTime {
    normal: Vec3,
    time: f32,
}

/// Whether a time is outside the movement; not a number is not.
fn is_outside_step(time: f32) -> bool {
    let late = time > 1.0;
    time < 0.0 || late
}

/// Exact time-of-impact clipping (9.9, step 3), for cameras. Quirk: the start is that of the mover's first sphere, whichever sphere hit.
struct ExactClip<'a> {
    cylinder: &'a CylSphere,
    /// Sphere that hit, at the check position.
    sphere: Sphere,
    /// Current centre of the first sphere.
    start: Vec3,
    movement: Vec3,
    /// From the base to `start`.
    from_base: Vec3,
    /// ρ + ε.
    reach: f32,
    /// Squared horizontal length of the movement.
    a: f32,
    discriminant: f64,
    /// Minus the horizontal product of movement and `from_base`.
    b: f32,
    /// `04:C4`: profile `ace` takes the movement's z for the height where the side is not certain, and goes the way backwards. What profile
    /// `gdle` does there is undefined and not imitated.
    takes_movement_for_height: bool,
}

impl<'a> ExactClip<'a> {
    fn new(cylinder: &'a CylSphere, t: &Transition<'_>, touch: &Touch) -> Self {
        let start = t.path.global_curr_center[0];
        let sphere = touch.mover.sphere;
        let m = t.path.curr_to_check_block_offset() + (sphere.center - start);
        let q = start - cylinder.low;
        let reach = touch.reach + EPSILON;
        let a = level_squared(m);
        let b = -(m.x * q.x + m.y * q.y);
        let c = f64::from(level_squared(q)) - f64::from(reach * reach);
        Self {
            cylinder,
            sphere,
            start,
            movement: m,
            from_base: q,
            reach,
            a,
            discriminant: f64::from(b) * f64::from(b) - c * f64::from(a),
            b,
            takes_movement_for_height: t.profile().perfect_clip == PerfectClip::Ace,
        }
    }

    fn horizontal_time(&self) -> f32 {
        let (a, b) = (f64::from(self.a), f64::from(self.b));
        let root = f64::from(self.discriminant.sqrt() as f32);
        let time = if b - root < 0.0 { root + b } else { b - root };
        (time / a) as f32
    }

    /// Normal of the end that the mover comes from, and the time at which it is reached from the height `z` above the base.
    fn cap(&self, z: f32) -> Option<(Vec3, f32)> {
        let m = self.movement;
        if m.z.abs() < EPSILON {
            return None;
        }
        let radius = self.sphere.radius;
        Some(if m.z > 0.0 {
            (Vec3::NEG_Z, -((z + radius) / m.z))
        } else {
            (Vec3::Z, (radius + self.cylinder.height - z) / m.z)
        })
    }

    /// The horizontal normal where the mover touches the shaft.
    fn shaft_normal(&self, offset: Vec3) -> Vec3 {
        let n = (offset + self.start - self.cylinder.low) / self.reach;
        Vec3::new(n.x, n.y, 0.0)
    }

    fn shaft(&self) -> Option<ClipTime> {
        if self.discriminant < 0.0 || self.a < EPSILON {
            return None;
        }
        let time = self.horizontal_time();
        Some(ClipTime {
            normal: self.shaft_normal(self.movement * time),
            time,
        })
    }

    fn uncertain(&self) -> Option<ClipTime> {
        let (normal, time) = self.cap(if self.takes_movement_for_height {
            self.movement.z
        } else {
            self.from_base.z
        })?;
        let offset = self.movement * time;
        if level_squared(offset + self.from_base) < self.reach * self.reach {
            return Some(ClipTime { normal, time });
        }
        if self.a.abs() < EPSILON {
            return None;
        }
        let time = if self.discriminant >= 0.0 && self.a > EPSILON {
            self.horizontal_time()
        } else {
            time
        };
        let normal = self.shaft_normal(self.movement * time);
        Some(ClipTime { normal, time })
    }

    /// From the check position to where the mover touches. Quirk: current and check space are mixed without a block offset.
    fn offset(&self, time: f32, definite: bool) -> Vec3 {
        let way = self.movement * time;
        if self.takes_movement_for_height && !definite {
            self.start - way - self.sphere.center
        } else {
            self.start + way - self.sphere.center
        }
    }
}
