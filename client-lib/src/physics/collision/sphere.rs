//! Spheres: tests between two of them, and spheres as obstacles of a transition (`spec/04-collision-primitives.md`, section 8).
//!
//! An obstacle sphere is in check space: block coordinates of the check position. `ρ` is the distance of the centres at which mover and
//! obstacle count as touching, ε less than the sum of their radii; the radius of the mover's first sphere is used for both of its spheres.

use super::polygon::{WalkLimit, lowered_walk_interp};
use crate::math::vector::normalize_check_small;
use crate::math::{EPSILON, Plane, Position, Ray, Sphere, Vec3};
use crate::physics::transition::{InsertType, ObjectInfoState, Transition, TransitionState};
use crate::profile::{PerfectClip, Profile, SphereSlide, Width};

/// Ground that may be landed on: cosine of 85°.
pub const LANDING_Z: f32 = 0.087_155_7;

impl Sphere {
    /// Whether two spheres intersect (8.1); a hair apart still counts. `04:S1`: profile `ace` is strict.
    #[inline]
    pub fn intersects(&self, other: &Self, profile: &Profile) -> bool {
        let distance_squared = (self.center - other.center).length_squared();
        let sum = self.radius + other.radius;
        if profile.spheres_intersect_strict {
            distance_squared < sum * sum
        } else {
            distance_squared - sum * sum < EPSILON
        }
    }

    /// Whether the ray's line ahead meets the sphere from outside, and the multiple of the direction at which it does (8.4).
    ///
    /// `04:S8`: profile `gdle` tests the infinite line and knows no time.
    pub fn hit_by_ray(&self, ray: &Ray, profile: &Profile) -> (bool, f32) {
        let a = ray.dir.length_squared();
        if a < EPSILON {
            return (false, 0.0);
        }
        let u = ray.point - self.center;
        let c = u.length_squared() - self.radius * self.radius;
        if profile.sphere_ray_is_line {
            let b = u.dot(ray.dir);
            return (b * b - c * a > 0.0, 0.0);
        }
        if c <= 0.0 {
            return (false, 0.0);
        }
        let b = -u.dot(ray.dir);
        let discriminant = b * b - c * a;
        if discriminant < 0.0 {
            return (false, 0.0);
        }
        let (b, root) = (f64::from(b), f64::from(discriminant).sqrt());
        let time = if b <= root { b + root } else { b - root };
        (true, (time / f64::from(a)) as f32)
    }
}

/// Whether a displacement between two centres is within the touching distance (8.2). `04:S2`: profile `gdle` compares lengths.
#[inline]
pub fn collides_with_sphere(displacement: Vec3, radius_sum: f32, profile: &Profile) -> bool {
    if profile.sphere_overlap_lengths {
        radius_sum >= displacement.length()
    } else {
        displacement.length_squared() <= radius_sum * radius_sum
    }
}

/// Multiple of `movement` after which two spheres touch (8.3); −1 if never, or if they touch already.
///
/// `displacement` is the mover's centre minus the obstacle's at the start. `04:S3`: profile `ace` has the opposite sign, and an f32
/// discriminant.
pub fn find_time_of_collision(
    movement: Vec3,
    displacement: Vec3,
    radius_sum: f32,
    profile: &Profile,
) -> f64 {
    let (m, d) = (movement, displacement);
    let a = m.length_squared();
    let c = d.length_squared() - radius_sum * radius_sum;
    let (b, discriminant) = if profile.perfect_clip == PerfectClip::Ace {
        let b = d.dot(m);
        (b, f64::from(b * b - c * a))
    } else {
        let b = -(d.z * m.z + d.y * m.y + m.x * d.x);
        let (a, b64, c) = (f64::from(a), f64::from(b), f64::from(c));
        (b, b64 * b64 - c * a)
    };
    if c < EPSILON || a < EPSILON || discriminant < 0.0 {
        return -1.0;
    }
    let (a, b, root) = (f64::from(a), f64::from(b), discriminant.sqrt());
    if b - root < 0.0 {
        (root + b) / a
    } else {
        (b - root) / a
    }
}

/// One sphere of the mover: where it is and where it comes from.
#[derive(Debug, Clone, Copy)]
pub(super) struct MoverSphere {
    /// At the check position, check space.
    pub sphere: Sphere,
    /// Centre at the current position, current space.
    pub current: Vec3,
}

impl MoverSphere {
    pub(super) fn of(t: &Transition<'_>, index: usize) -> Self {
        Self {
            sphere: t.path.global_sphere[index],
            current: t.path.global_curr_center[index],
        }
    }
}

/// What tests of one obstacle need of the mover.
#[derive(Debug, Clone, Copy)]
struct Contact {
    /// From the obstacle's centre to the first sphere's.
    displacement: Vec3,
    /// Touching distance ρ.
    reach: f32,
    /// Which of the mover's spheres touch.
    hits: [bool; 2],
}

impl Contact {
    fn any(&self) -> bool {
        self.hits[0] || self.hits[1]
    }
}

impl Sphere {
    fn contact(&self, t: &Transition<'_>) -> Contact {
        self.contact_within(t, t.path.global_sphere[0].radius + self.radius - EPSILON)
    }

    fn contact_within(&self, t: &Transition<'_>, reach: f32) -> Contact {
        let profile = t.profile();
        let displacement = t.path.global_sphere[0].center - self.center;
        let upper = t.path.num_sphere > 1
            && collides_with_sphere(t.path.global_sphere[1].center - self.center, reach, profile);
        Contact {
            displacement,
            reach,
            hits: [collides_with_sphere(displacement, reach, profile), upper],
        }
    }

    /// Tests this sphere of an object at `position` with uniform `scale` against the mover (8.5); `is_creature`: the object is a creature or
    /// a missile. What a test may change: the check position, walk interp, allowance, contact plane, collision normal and collide state.
    pub fn intersects_sphere_at(
        &self,
        position: &Position,
        scale: f32,
        t: &mut Transition<'_>,
        is_creature: bool,
    ) -> TransitionState {
        let center =
            t.path
                .check_pos
                .landblock_point_of(position, self.center * scale, t.profile());
        Self::new(center, self.radius * scale).intersects_sphere(t, is_creature)
    }

    /// Tests this sphere, in check space, against the mover (8.6).
    pub fn intersects_sphere(&self, t: &mut Transition<'_>, is_creature: bool) -> TransitionState {
        let contact = self.contact(t);
        let blocked = if contact.any() {
            TransitionState::Collided
        } else {
            TransitionState::Ok
        };
        if t.path.obstruction_ethereal || t.path.insert_type == InsertType::Placement {
            return blocked;
        }
        if t.path.step_down {
            return if is_creature {
                TransitionState::Ok
            } else {
                self.step_down(t, contact)
            };
        }
        if t.path.check_walkable {
            return blocked;
        }
        if t.path.collide {
            // `04:S5`.
            return if is_creature != t.profile().land_on_creature_spheres {
                TransitionState::Ok
            } else {
                land_on_top(t, self.center, contact.reach, contact.hits)
            };
        }
        self.respond(t, contact)
    }

    /// The mover runs into the obstacle (rules 4 to 6).
    fn respond(&self, t: &mut Transition<'_>, contact: Contact) -> TransitionState {
        let state = t.object.state;
        if state.intersects(ObjectInfoState::CONTACT | ObjectInfoState::ON_WALKABLE) {
            if contact.hits[0] {
                self.step_up(t, contact)
            } else if contact.hits[1] {
                self.slide_around(t, 1)
            } else {
                TransitionState::Ok
            }
        } else if state.contains(ObjectInfoState::PATH_CLIPPED) {
            if contact.hits[0] {
                self.collide_with_point(t, 0, contact.reach)
            } else {
                TransitionState::Ok
            }
        } else if contact.hits[0] {
            self.land_on(t)
        } else if contact.hits[1] {
            self.collide_with_point(t, 1, contact.reach)
        } else {
            TransitionState::Ok
        }
    }

    /// From the obstacle to where mover sphere `index` comes from. Quirk: no block offset, even across landblocks.
    fn to_current(self, t: &Transition<'_>, index: usize) -> Vec3 {
        t.path.global_curr_center[index] - self.center
    }

    /// Stops at the obstacle (8.7).
    fn collide_with_point(
        &self,
        t: &mut Transition<'_>,
        index: usize,
        reach: f32,
    ) -> TransitionState {
        let displacement = self.to_current(t, index);
        if !t.object.state.contains(ObjectInfoState::PERFECT_CLIP) {
            if let Some(normal) = normalize_check_small(displacement) {
                t.set_collision_normal(normal);
            }
            return TransitionState::Collided;
        }
        let mover = MoverSphere::of(t, index);
        let movement = mover.sphere.center - mover.current + t.path.curr_to_check_block_offset();
        let profile = t.profile();
        let time = find_time_of_collision(movement, displacement, reach + EPSILON, profile) as f32;
        // Not a number goes on.
        let late = time > 1.0;
        if time < EPSILON || late {
            return TransitionState::Collided;
        }
        let back = movement * time - movement;
        let touching = back + mover.sphere.center - self.center;
        t.set_collision_normal(touching * (1.0 / reach));
        // `04:S4`: profile `ace` moves by the obstacle's distance.
        t.add_offset_to_check_pos(if profile.perfect_clip == PerfectClip::Ace {
            touching
        } else {
            back
        });
        TransitionState::Adjusted
    }

    /// Notes that the mover comes down on the obstacle (8.8); nothing moves, the caller tests again.
    pub fn land_on(&self, t: &mut Transition<'_>) -> TransitionState {
        let Some(normal) = normalize_check_small(self.to_current(t, 0)) else {
            return TransitionState::Collided;
        };
        t.set_collide(normal);
        t.path.walkable_allowance = LANDING_Z;
        TransitionState::Adjusted
    }

    /// Slides mover sphere `index` around the obstacle (8.9, variant C).
    fn slide_around(&self, t: &mut Transition<'_>, index: usize) -> TransitionState {
        let Some(mut normal) = normalize_check_small(self.to_current(t, index)) else {
            return TransitionState::Collided;
        };
        let mover = MoverSphere::of(t, index);
        t.slide_sphere(mover.sphere.center, &mut normal, mover.current)
    }

    /// Slides the mover's first sphere around an obstacle that is too high to step on (8.9, variant B).
    pub fn slide_below(&self, t: &mut Transition<'_>) -> TransitionState {
        let Some(normal) = normalize_check_small(self.to_current(t, 0)) else {
            return TransitionState::Collided;
        };
        let mover = MoverSphere::of(t, 0);
        t.set_collision_normal(normal);
        let ground = t.info.ground_normal();
        let crease = normal.cross(ground);
        let crease_squared = crease.length_squared();
        let step = mover.sphere.center - mover.current + t.path.curr_to_check_block_offset();
        if crease_squared >= EPSILON {
            return match t.profile().sphere_slide {
                SphereSlide::Once => t.slide_along_crease(crease, crease_squared, step),
                SphereSlide::TwiceX => slide_along_crease_twice(t, crease, crease_squared, step),
            };
        }
        if ground.dot(mover.sphere.center - self.center) < 0.0 {
            return TransitionState::Collided;
        }
        t.add_offset_to_check_pos(normal * -step.dot(normal));
        TransitionState::Slid
    }

    fn step_up(&self, t: &mut Transition<'_>, contact: Contact) -> TransitionState {
        if t.object.step_up_height < contact.reach + EPSILON - contact.displacement.z {
            return self.slide_below(t);
        }
        // Not normalised: a slide after a failed step up works with the distance of the centres as the length of its normal.
        let normal = self.to_current(t, 0);
        if t.step_up(normal) {
            TransitionState::Ok
        } else {
            t.step_up_slide()
        }
    }

    /// Steps the mover up onto the obstacle, or slides it around (8.10); ρ is `reach`.
    pub fn step_sphere_up(&self, t: &mut Transition<'_>, reach: f32) -> TransitionState {
        let contact = self.contact_within(t, reach);
        self.step_up(t, contact)
    }

    /// Lowers the mover onto the obstacle (8.11); ρ is `reach`.
    pub fn step_sphere_down(&self, t: &mut Transition<'_>, reach: f32) -> TransitionState {
        let contact = self.contact_within(t, reach);
        self.step_down(t, contact)
    }

    fn step_down(&self, t: &mut Transition<'_>, contact: Contact) -> TransitionState {
        if !contact.any() {
            return TransitionState::Ok;
        }
        let profile = t.profile();
        let span = t.path.step_down_amt * t.path.walk_interp;
        if span.abs() < EPSILON {
            return TransitionState::Collided;
        }
        let reach = contact.reach + EPSILON;
        let d = contact.displacement;
        let below = root_minus(reach * reach - (d.x * d.x + d.y * d.y), d.z, profile);
        let k = below / span;
        let Some(rest) =
            lowered_walk_interp(k.into(), t.path.walk_interp, WalkLimit::Object, profile)
        else {
            return TransitionState::Collided;
        };
        // `04:S7`: profile `ace` writes the not-a-number of a sphere that is horizontally out of reach.
        if rest.is_nan() && !profile.sphere_nan_root_written {
            return TransitionState::Collided;
        }
        let z = span * k;
        let n = Vec3::new(d.x, d.y, d.z + z) * (1.0 / reach);
        if n.z <= t.path.walkable_allowance {
            return TransitionState::Ok;
        }
        let plane = Plane::from_normal_and_point(n, n * self.radius + self.center);
        set_object_plane(t, plane);
        t.path.walk_interp = rest;
        t.add_offset_to_check_pos(Vec3::new(0.0, 0.0, z));
        TransitionState::Adjusted
    }
}

/// The root of `square` minus `z`; `04:A7` for the width.
fn root_minus(square: f32, z: f32, profile: &Profile) -> f32 {
    match profile.sphere_roots {
        Width::F64 => (f64::from(square).sqrt() - f64::from(z)) as f32,
        Width::F32 => square.sqrt() - z,
    }
}

/// Makes a plane the contact plane that must not be extended, as all planes tangent to spheres and cylinders.
pub(super) fn set_object_plane(t: &mut Transition<'_>, plane: Plane) {
    t.set_contact_plane(plane, true);
    t.info.contact_plane.cell_id = t.path.check_pos.cell;
}

/// `04:S6` in profile `gdle`: the length of the crease is divided out twice and only the x component of the slide is tested.
fn slide_along_crease_twice(
    t: &mut Transition<'_>,
    crease: Vec3,
    crease_squared: f32,
    step: Vec3,
) -> TransitionState {
    let inverse = 1.0 / crease_squared;
    let along = crease * step.dot(crease) * inverse * inverse;
    if along.x * along.x < EPSILON {
        return TransitionState::Collided;
    }
    t.add_offset_to_check_pos(along - step);
    TransitionState::Slid
}

/// Landing retry: takes the mover back along its way until it touches a sphere of radius ρ + ε around `center` (8.6, rule 7).
///
/// Quirks: a mover with one sphere is solved without overlap too; the time is compared with 1 before it is divided by the squared length of
/// the way; the plane goes through the sphere that has not been moved.
pub(super) fn land_on_top(
    t: &mut Transition<'_>,
    center: Vec3,
    reach: f32,
    hits: [bool; 2],
) -> TransitionState {
    if !hits[0] && t.path.num_sphere > 1 && !hits[1] {
        return TransitionState::Ok;
    }
    let profile = t.profile();
    let mover = MoverSphere::of(t, 0);
    let back = mover.current - mover.sphere.center - t.path.curr_to_check_block_offset();
    let reach = reach + EPSILON;
    let displacement = mover.sphere.center - center;
    let a = back.length_squared();
    let b = -back.dot(displacement);
    if a.abs() < EPSILON {
        return TransitionState::Collided;
    }
    let square = b * b - (displacement.length_squared() - reach * reach) * a;
    let share = landing_root(square, b, profile) / a;
    let Some(rest) =
        lowered_walk_interp(share.into(), t.path.walk_interp, WalkLimit::Object, profile)
    else {
        return TransitionState::Collided;
    };
    let offset = back * share;
    let n = (displacement + offset) / reach;
    if !t.path.is_walkable_allowable(n.z) {
        return TransitionState::Ok;
    }
    let plane = Plane::from_normal_and_point(n, mover.sphere.center - n * mover.sphere.radius);
    set_object_plane(t, plane);
    t.path.walk_interp = rest;
    t.add_offset_to_check_pos(offset);
    TransitionState::Adjusted
}

fn landing_root(square: f32, b: f32, profile: &Profile) -> f32 {
    match profile.sphere_roots {
        Width::F64 => {
            let b = f64::from(b);
            let t = f64::from(square).sqrt() + b;
            (if t > 1.0 { b * 2.0 - t } else { t }) as f32
        }
        Width::F32 => {
            let t = square.sqrt() + b;
            if t > 1.0 { b * 2.0 - t } else { t }
        }
    }
}
