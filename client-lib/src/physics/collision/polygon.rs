//! Collision polygons (`spec/04-collision-primitives.md`, 3.1 and 7).
//!
//! A [`Polygon`] is a view: the plane by value, the corners borrowed from whoever owns them (a shape's list, a terrain triangle). Everything
//! is in the owner's space, metres. Polygons are one-sided by movement, not by their sides type: see [`Polygon::pos_hits_sphere`].

use crate::math::{EPSILON, Plane, Ray, Sidedness, Sphere, Vec3, vector};
use crate::profile::{Profile, Width};

/// Half of the radius, squared: the footprint that must find ground in [`Polygon::check_small_walkable`].
const SMALL_FOOTPRINT: f32 = 0.25;

/// A convex, flat polygon in the space of its owner.
#[derive(Debug, Clone, Copy)]
pub struct Polygon<'a> {
    /// Plane of the polygon, as [`make_plane`] gives it; NaN for a degenerate polygon, which nothing ever hits.
    pub plane: Plane,
    /// Corners, counter-clockwise seen from the side that the normal points to.
    pub vertices: &'a [Vec3],
    /// Rays from behind pass (sides type 0).
    pub single_sided: bool,
}

/// What becomes of a sphere that overlaps a polygon during placement ([`Polygon::placement_offset`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlacementSolidity {
    /// The tree found the centre inside solid matter.
    pub center_solid: bool,
    /// Solid matter counts at all.
    pub solid_check: bool,
}

/// Plane of a polygon (7.1): the normal of the summed triangle normals, the mean distance of all corners.
///
/// NaN for fewer than three corners and for corners on one line. `01:V1`: profile `ace` divides by the length.
pub fn make_plane(vertices: &[Vec3], profile: &Profile) -> Plane {
    let mut sum = Vec3::ZERO;
    if let [first, rest @ ..] = vertices {
        for pair in rest.windows(2) {
            sum += (pair[0] - first).cross(pair[1] - first);
        }
    }
    let n = vector::normalize(sum, profile);
    let mut total = 0.0;
    for v in vertices {
        total += n.dot(*v);
    }
    Plane {
        n,
        d: -(total / vertices.len() as f32),
    }
}

/// An edge as seen from a point in the polygon's plane (7.2).
struct Edge {
    /// From the edge's start to its end.
    along: Vec3,
    /// From the edge's start to the point.
    to_point: Vec3,
    /// In the plane, into the polygon; as long as the edge.
    inward: Vec3,
    /// Positive inside, scaled by the length of the edge.
    depth: f32,
}

impl Edge {
    /// The point is strictly on the outer side.
    fn violated(&self) -> bool {
        self.depth < 0.0
    }

    fn too_far(&self, reach_squared: f32) -> bool {
        self.inward.length_squared() * reach_squared < self.depth * self.depth
    }

    fn foot_on_segment(&self) -> bool {
        let t = self.to_point.dot(self.along);
        0.0 <= t && t <= self.along.length_squared()
    }

    fn near_start(&self, reach_squared: f32) -> bool {
        self.to_point.length_squared() <= reach_squared
    }
}

/// What a violated edge does to a scan when the foot of the point is off its segment.
#[derive(Clone, Copy, PartialEq, Eq)]
enum OffSegment {
    /// Nothing; a scan that runs out of edges answers no.
    Ignore,
    /// The scan goes on, but can no longer run out of edges with yes.
    Remember,
    /// The scan ends with no.
    End,
}

impl<'a> Polygon<'a> {
    /// The polygon of these corners, with the plane that they make.
    pub fn new(vertices: &'a [Vec3], profile: &Profile) -> Self {
        Self {
            plane: make_plane(vertices, profile),
            vertices,
            single_sided: true,
        }
    }

    /// Edges in the order of the scans: the closing edge first.
    fn edges(&self, point: Vec3) -> impl Iterator<Item = Edge> {
        let n = self.plane.n;
        let last = self.vertices.last().copied().unwrap_or(Vec3::ZERO);
        self.vertices.iter().scan(last, move |start, &end| {
            let along = end - *start;
            let to_point = point - *start;
            let inward = n.cross(along);
            *start = end;
            Some(Edge {
                along,
                to_point,
                inward,
                depth: to_point.dot(inward),
            })
        })
    }

    /// Whether a disc around `point` (in the plane) of that squared radius reaches the polygon (7.2).
    fn scan(&self, point: Vec3, reach_squared: f32, off_segment: OffSegment) -> bool {
        let mut inside = off_segment != OffSegment::Ignore;
        for edge in self.edges(point) {
            if edge.violated() {
                if edge.too_far(reach_squared) {
                    return false;
                }
                if edge.foot_on_segment() {
                    return true;
                }
                match off_segment {
                    OffSegment::Ignore => {}
                    OffSegment::Remember => inside = false,
                    OffSegment::End => return false,
                }
            }
            if edge.near_start(reach_squared) {
                return true;
            }
        }
        inside
    }

    /// The point of the plane below the sphere's centre and the squared radius of the overlap; `None` if the sphere does not reach the plane.
    ///
    /// The effective radius is ε less than the sphere's: a sphere that rests on the plane does not touch it. NaN passes.
    fn overlap(&self, sphere: &Sphere) -> Option<(Vec3, f32)> {
        let h = self.plane.distance(sphere.center);
        let radius = sphere.radius - EPSILON;
        if h.abs() > radius {
            None
        } else {
            Some((sphere.center - self.plane.n * h, radius * radius - h * h))
        }
    }

    /// Whether a sphere touches the polygon (7.3, `polygon_hits_sphere_slow_but_sure`); `contact` is the nearest point of the plane and is
    /// written whenever the sphere reaches the plane.
    pub fn hits_sphere_precise(&self, sphere: &Sphere, contact: &mut Vec3) -> bool {
        let Some((point, reach_squared)) = self.overlap(sphere) else {
            return false;
        };
        // Not a number is no overlap here, unlike in the fast form.
        if reach_squared.is_nan() {
            return false;
        }
        *contact = point;
        !self.edges(point).any(|e| e.violated())
            || self.scan(point, reach_squared, OffSegment::Ignore)
    }

    /// The one-pass form of [`Self::hits_sphere_precise`] (7.4, `polygon_hits_sphere`): the same answer for every finite input; not a number is a hit.
    pub fn hits_sphere_fast(&self, sphere: &Sphere, contact: &mut Vec3) -> bool {
        let Some((point, reach_squared)) = self.overlap(sphere) else {
            return false;
        };
        *contact = point;
        self.scan(point, reach_squared, OffSegment::Remember)
    }

    /// Whether a sphere touches the polygon (7.5).
    pub fn hits_sphere(&self, sphere: &Sphere) -> bool {
        let mut unused = Vec3::ZERO;
        self.hits_sphere_precise(sphere, &mut unused)
    }

    /// Whether a sphere that came by `movement` touches the polygon and moves against its normal (7.6): `(touched, hit)`.
    ///
    /// A polygon touched from behind or without movement is touched, not hit; the callers tell the two apart.
    pub fn pos_hits_sphere(
        &self,
        sphere: &Sphere,
        movement: Vec3,
        contact: &mut Vec3,
    ) -> (bool, bool) {
        let touched = self.hits_sphere_precise(sphere, contact);
        // Retail asks `>= 0` for "not a hit": a NaN product is a hit.
        let with_normal = movement.dot(self.plane.n) >= 0.0;
        (touched, touched && !with_normal)
    }

    /// Backs `sphere` up along `movement` until it rests on the plane (7.7); lowers `walk_interp`. `false` changes nothing.
    ///
    /// Refused for a movement along the plane, for one that would lengthen the walk, and for more than one and a half movements.
    /// `04:A3`: profile `gdle` compares with f64 limits.
    pub fn adjust_sphere_to_plane(
        &self,
        sphere: &mut Sphere,
        movement: Vec3,
        walk_interp: &mut f32,
        profile: &Profile,
    ) -> bool {
        let h = self.plane.distance(sphere.center);
        let s = movement.dot(self.plane.n);
        let (from_behind, refused) = match profile.walk_interp_width {
            Width::F32 => (s <= EPSILON, s >= -EPSILON),
            Width::F64 => {
                let (s, limit) = (f64::from(s), 0.000_199_999_99);
                (s <= limit, s >= -limit)
            }
        };
        let gap = if from_behind {
            if refused {
                return false;
            }
            h - sphere.radius
        } else {
            -sphere.radius - h
        };
        let k = gap / s;
        let Some(rest) = lowered_walk_interp(k.into(), *walk_interp, WalkLimit::Polygon, profile)
        else {
            return false;
        };
        sphere.center -= movement * k;
        *walk_interp = rest;
        true
    }

    /// Share of `movement` after which a sphere of that radius, now at `center`, touches the plane (7.8). Nothing depends on it.
    pub fn touching_time(&self, radius: f32, center: Vec3, movement: Vec3) -> f64 {
        let h = self.plane.distance(center);
        if h.abs() < radius {
            return 1.0;
        }
        let s = movement.dot(self.plane.n);
        if s.abs() < EPSILON {
            return 0.0;
        }
        let reach = if movement.length_squared() <= radius * radius {
            -radius
        } else {
            radius
        };
        f64::from((reach - h) / s)
    }

    /// Whether a sphere touches the polygon and its slope is allowed (7.9): `up` in the polygon's space, exactly the allowance is refused.
    pub fn walkable_hits_sphere(&self, sphere: &Sphere, up: Vec3, walkable_allowance: f32) -> bool {
        let refused = up.dot(self.plane.n) <= walkable_allowance;
        !refused && self.hits_sphere(sphere)
    }

    /// The sphere's centre, projected along `up` onto the plane; `None` for a plane along `up`.
    fn footprint(&self, sphere: &Sphere, up: Vec3, facing: f32) -> Vec3 {
        sphere.center - up * (self.plane.distance(sphere.center) / facing)
    }

    fn carries(&self, sphere: &Sphere, up: Vec3, reach_squared: f32, profile: &Profile) -> bool {
        let facing = self.plane.n.dot(up);
        if facing < EPSILON {
            return false;
        }
        // `04:P1`.
        let off_segment = if profile.walkable_scan_ends {
            OffSegment::End
        } else {
            OffSegment::Remember
        };
        self.scan(
            self.footprint(sphere, up, facing),
            reach_squared,
            off_segment,
        )
    }

    /// Whether the sphere's footprint, projected along `up` (unit, the polygon's space), touches the polygon, however far away it is (7.10).
    pub fn check_walkable(&self, sphere: &Sphere, up: Vec3, profile: &Profile) -> bool {
        self.carries(sphere, up, sphere.radius * sphere.radius, profile)
    }

    /// [`Self::check_walkable`] with half the radius.
    pub fn check_small_walkable(&self, sphere: &Sphere, up: Vec3, profile: &Profile) -> bool {
        let reach_squared = sphere.radius * sphere.radius * SMALL_FOOTPRINT;
        self.carries(sphere, up, reach_squared, profile)
    }

    /// Unit normal, in the plane and into the polygon, of the first edge that the projected centre of the sphere is beyond (7.11).
    pub fn find_crossed_edge(&self, sphere: &Sphere, up: Vec3) -> Option<Vec3> {
        let facing = self.plane.n.dot(up);
        if facing.abs() < EPSILON {
            return None;
        }
        let point = self.footprint(sphere, up, facing);
        let inward = self.edges(point).find(Edge::violated)?.inward;
        Some(inward * (1.0 / inward.length()))
    }

    /// The shift (m) that puts a sphere centre at the signed distance `radius` from the plane, out of or through solid matter (7.12).
    ///
    /// `04:P2`: profile `ace` flips the side once where the reference flips it for each of two reasons.
    pub fn placement_offset(
        &self,
        center: Vec3,
        radius: f32,
        solidity: PlacementSolidity,
        profile: &Profile,
    ) -> Vec3 {
        let h = self.plane.distance(center);
        let behind = h <= 0.0;
        let flip = solidity.solid_check
            && if profile.placement_flips_one {
                solidity.center_solid || behind
            } else {
                solidity.center_solid != behind
            };
        let wanted = if flip { -radius } else { radius };
        self.plane.n * (wanted - h)
    }

    /// Whether a point is in the infinite prism over the polygon (7.13); every point is, for a degenerate polygon.
    pub fn contains(&self, point: Vec3) -> bool {
        !self.edges(point).any(|e| e.inward.dot(e.to_point) < 0.0)
    }

    /// Whether a point is inside in plan view (7.14). [`Sidedness::Positive`] is for polygons that are counter-clockwise seen from above;
    /// points on an edge are inside, and so is NaN.
    pub fn contains_2d(&self, point: Vec3, side: Sidedness) -> bool {
        let Some(&first) = self.vertices.first() else {
            return true;
        };
        let mut a = first;
        for &b in self.vertices.iter().rev() {
            let along = b - a;
            let x = along.y * b.x - along.x * b.y + along.x * point.y - along.y * point.x;
            let outside = if side == Sidedness::Positive {
                x > 0.0
            } else {
                x < 0.0
            };
            if outside {
                return false;
            }
            a = b;
        }
        true
    }

    /// Multiple of the ray's direction at which it meets the polygon (7.15); the ray's length does not count.
    pub fn hit_by_ray(&self, ray: &Ray, profile: &Profile) -> Option<f32> {
        if self.single_sided && self.plane.n.dot(ray.dir) > 0.0 {
            return None;
        }
        let (t, ahead) = self.plane.time_of_intersection(ray)?;
        let hit = ahead || (t.is_nan() && profile.ray_nan_time_hits);
        (hit && self.contains(ray.point + ray.dir * t)).then_some(t)
    }
}

/// How much of a movement may be taken back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WalkLimit {
    /// Polygons: down to −0.5.
    Polygon,
    /// Sphere and cylinder obstacles: down to −0.1.
    Object,
}

/// The walk interp after the share `k` of the movement was taken back: `None` if that does not lower it or lowers it too far.
///
/// NaN is let through. `04:A3`, `T-27`: profile `gdle` computes and compares in f64. `k` is an f32, or a quotient of two that only profile
/// `gdle` keeps wide.
pub(super) fn lowered_walk_interp(
    k: f64,
    walk_interp: f32,
    limit: WalkLimit,
    profile: &Profile,
) -> Option<f32> {
    match profile.walk_interp_width {
        Width::F32 => {
            let w = (1.0 - k as f32) * walk_interp;
            let lowest = match limit {
                WalkLimit::Polygon => -0.5,
                WalkLimit::Object => -0.1,
            };
            let refused = w >= walk_interp || w < lowest;
            (!refused).then_some(w)
        }
        Width::F64 => {
            let old = f64::from(walk_interp);
            let w = (1.0 - k) * old;
            let lowest = match limit {
                WalkLimit::Polygon => -0.5,
                WalkLimit::Object => -0.1,
            };
            let refused = w >= old || w < lowest;
            (!refused).then_some(w as f32)
        }
    }
}
