//! A mover in no cell, and generators.

use ac_client::math::{CellId, Plane, Position, Quat, Sphere, Vec3};
use ac_client::physics::transition::{ObjectInfoState, SpherePath, Transition};
use ac_client::profile::Profile;
use ac_client::world::World;
use proptest::prelude::*;

/// The normative profile.
pub static RETAIL: Profile = Profile::retail();

/// Cell of every position here.
pub const CELL: CellId = CellId(0xA9B4_0001);

pub fn world() -> World {
    World::new(Profile::retail(), 0.0)
}

pub fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

pub fn at(origin: Vec3) -> Position {
    Position::new(CELL, origin, Quat::IDENTITY)
}

/// A mover with spheres of that radius, the first around its own origin, the second `upper` above it.
#[derive(Debug, Clone)]
pub struct Mover {
    pub radius: f32,
    pub upper: Option<f32>,
    pub current: Position,
    pub check: Position,
    pub state: ObjectInfoState,
    pub step_up_height: f32,
    pub walk_interp: f32,
    pub step_down_amt: f32,
    pub walkable_allowance: f32,
    pub ground: Option<Plane>,
}

impl Mover {
    pub fn new(radius: f32, current: Vec3, check: Vec3) -> Self {
        Self {
            radius,
            upper: None,
            current: at(current),
            check: at(check),
            state: ObjectInfoState::empty(),
            step_up_height: 0.4,
            walk_interp: 1.0,
            step_down_amt: 0.6,
            walkable_allowance: 0.66,
            ground: None,
        }
    }

    pub fn transition<'w>(&self, world: &'w World) -> Transition<'w> {
        let mut t = Transition::new(world);
        t.object.state = self.state;
        t.object.scale = 1.0;
        t.object.step_up_height = self.step_up_height;
        t.object.step_down_height = self.step_up_height;
        let path = &mut t.path;
        path.num_sphere = 1 + usize::from(self.upper.is_some());
        path.local_sphere[0] = Sphere::new(Vec3::ZERO, self.radius);
        path.local_sphere[1] = Sphere::new(Vec3::Z * self.upper.unwrap_or(0.0), self.radius);
        path.local_low_point = Vec3::NEG_Z * self.radius;
        (path.curr_pos, path.check_pos) = (self.current, self.check);
        (path.begin_pos, path.end_pos) = (Some(self.current), self.check);
        path.walk_interp = self.walk_interp;
        path.step_down_amt = self.step_down_amt;
        path.walkable_allowance = self.walkable_allowance;
        path.cache_global_curr_center(&world.profile);
        path.cache_global_sphere(&world.profile);
        if let Some(plane) = self.ground {
            t.set_contact_plane(plane, false);
            t.info.contact_plane.cell_id = self.check.cell;
        }
        t
    }
}

/// Every record that a primitive may write, as text: equal texts mean equal bits (but for the payload of NaN).
pub fn records(t: &Transition<'_>) -> String {
    format!("{:?} {:?}", t.path, t.info)
}

/// [`records`] without what is cached in the obstacle's space.
pub fn records_without_caches(t: &Transition<'_>) -> String {
    let mut copy = t.clone();
    let fresh = SpherePath::default();
    copy.path.localspace_sphere = fresh.localspace_sphere;
    copy.path.localspace_curr_center = fresh.localspace_curr_center;
    copy.path.localspace_low_point = fresh.localspace_low_point;
    copy.path.localspace_pos = fresh.localspace_pos;
    copy.path.localspace_z = fresh.localspace_z;
    records(&copy)
}

pub fn vectors(reach: f32) -> impl Strategy<Value = Vec3> {
    let c = -reach..reach;
    (c.clone(), c.clone(), c).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

pub fn units() -> impl Strategy<Value = Vec3> {
    vectors(1.0)
        .prop_filter("long enough", |v| v.length() > 0.1)
        .prop_map(Vec3::normalize)
}

pub fn spheres(reach: f32) -> impl Strategy<Value = Sphere> {
    (vectors(reach), 0.05f32..2.0).prop_map(|(center, radius)| Sphere::new(center, radius))
}

/// Convex, flat polygons with 3 to 8 corners on a circle, anywhere and at any slope.
pub fn polygons() -> impl Strategy<Value = Vec<Vec3>> {
    (vectors(5.0), units(), 3usize..9, 0.5f32..4.0, 0.0f32..1.0).prop_map(
        |(center, normal, n, radius, turn)| {
            let a = normal.any_orthonormal_vector();
            let b = normal.cross(a);
            (0..n)
                .map(|i| {
                    let angle = (i as f32 + turn) * core::f32::consts::TAU / n as f32;
                    center + (a * angle.cos() + b * angle.sin()) * radius
                })
                .collect()
        },
    )
}

pub fn near(a: f32, b: f32, tolerance: f32) -> bool {
    (a - b).abs() <= tolerance
}
