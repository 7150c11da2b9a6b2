//! What records promise about geometry and references (`spec/11-dat-files.md, 15`: 16 to 22), for the worlds of the repository and for
//! generated ones.

use std::collections::BTreeSet;

use glam::DVec3;

use super::super::worldgen::{
    Axis, Rect, Room, SetupBuilder, Side, WorldBuilder, block, prism, ramp,
};
use super::super::{
    CellNode, CellStruct, DatSet, DrawingNode, NodeId, PhysicsBsp, PhysicsNode, PolygonSet,
    PortalFlags, Record, RecordKind, StoredFrame, Strictness, VertexArray, motion_key,
};
use super::world;
use crate::math::{Frame, Vec3};
use crate::profile::Profile;

/// Reproducible random numbers.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn point(&mut self, low: DVec3, high: DVec3) -> DVec3 {
        low + (high - low) * DVec3::new(self.unit(), self.unit(), self.unit())
    }
}

type Corners = Vec<DVec3>;

fn corners(set: &PolygonSet, vertices: &VertexArray) -> Vec<Corners> {
    set.iter()
        .map(|p| {
            p.points
                .iter()
                .map(|&v| vertices.get(v).expect("checked").position.as_dvec3())
                .collect()
        })
        .collect()
}

fn distance(p: DVec3, polygon: &[DVec3]) -> f64 {
    let n = (polygon[1] - polygon[0])
        .cross(polygon[2] - polygon[0])
        .normalize();
    let edges = || polygon.iter().zip(polygon.iter().cycle().skip(1));
    if edges().all(|(a, b)| n.cross(b - a).dot(p - a) >= 0.0) {
        return n.dot(p - polygon[0]).abs();
    }
    let to_edge = |(a, b): (&DVec3, &DVec3)| {
        let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(*a + (*b - *a) * t)
    };
    edges().map(to_edge).fold(f64::MAX, f64::min)
}

/// How often the surface goes round a point: 1 inside a closed surface that faces outwards.
fn winding(p: DVec3, polygons: &[Corners]) -> f64 {
    let mut sum = 0.0;
    for q in polygons {
        for w in q.windows(2).skip(1) {
            let (a, b, c) = (q[0] - p, w[0] - p, w[1] - p);
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let det = a.dot(b.cross(c));
            sum += 2.0
                * f64::atan2(
                    det,
                    la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb,
                );
        }
    }
    sum / (4.0 * std::f64::consts::PI)
}

/// Polygons listed in the leaves that a sphere reaches (`spec/04-collision-primitives.md, 10.1`).
fn reached(tree: &PhysicsBsp, center: DVec3, radius: f64) -> BTreeSet<u16> {
    let (mut found, mut open) = (BTreeSet::new(), vec![&tree.nodes[0]]);
    while let Some(node) = open.pop() {
        let s = node.sphere();
        if s.center.as_dvec3().distance(center) > f64::from(s.radius) + radius {
            continue;
        }
        match node {
            PhysicsNode::Leaf(l) => found.extend(tree.polygons(l.polygons)),
            PhysicsNode::Inner(n) => {
                let d = n.plane.n.as_dvec3().dot(center) + f64::from(n.plane.d);
                let child = |id: Option<NodeId>| {
                    id.and_then(|id| tree.node(id))
                        .expect("physics nodes have both children")
                };
                if d > -(radius - 0.0002) {
                    open.push(child(n.positive));
                }
                if d < radius - 0.0002 {
                    open.push(child(n.negative));
                }
            }
        }
    }
    found
}

fn solid_at(tree: &PhysicsBsp, p: DVec3) -> bool {
    let mut node = &tree.nodes[0];
    loop {
        match node {
            PhysicsNode::Leaf(l) => return l.solid != 0,
            PhysicsNode::Inner(n) => {
                let front = n.plane.n.as_dvec3().dot(p) + f64::from(n.plane.d) >= 0.0;
                node = if front { n.positive } else { n.negative }
                    .and_then(|id| tree.node(id))
                    .expect("both children");
            }
        }
    }
}

/// Invariants 16 to 18 of one physics tree. `doors` close the surface, facing as it does; `room`: the surface faces into free space.
fn check_physics(
    name: &str,
    polygons: &[Corners],
    tree: &PhysicsBsp,
    doors: &[Corners],
    room: bool,
) -> usize {
    let listed: BTreeSet<u16> = tree.polygon_keys.iter().copied().collect();
    assert_eq!(
        listed,
        (0..polygons.len() as u16).collect(),
        "{name}: every polygon is in a leaf"
    );
    let (low, high) = polygons
        .iter()
        .flatten()
        .fold((DVec3::MAX, DVec3::MIN), |(l, h), p| (l.min(*p), h.max(*p)));
    let (low, high) = (low - 0.5, high + 0.5);
    let surface: Vec<Corners> = polygons.iter().chain(doors).cloned().collect();
    let mut random = Random(0x5EED + polygons.len() as u64);
    let mut closed = 0;
    for _ in 0..150 {
        let (p, r) = (random.point(low, high), 0.05 + 0.9 * random.unit());
        let walk = reached(tree, p, r);
        for (key, q) in polygons.iter().enumerate() {
            let d = distance(p, q);
            assert!(
                d >= r - 0.0012 || walk.contains(&(key as u16)),
                "{name}: polygon {key} at {d} from {p}, radius {r}"
            );
        }
        if surface.iter().any(|q| distance(p, q) < 0.02) {
            continue;
        }
        let w = winding(p, &surface);
        // Behind a doorway is free, whatever the walls say.
        let behind_door = doors
            .iter()
            .any(|q| (q[1] - q[0]).cross(q[2] - q[0]).dot(p - q[0]) < 0.0);
        if (w - w.round()).abs() < 1e-3 && !behind_door {
            closed += 1;
            let solid = if room {
                w.round() == 0.0
            } else {
                w.round() == 1.0
            };
            assert_eq!(solid_at(tree, p), solid, "{name}: {p} winding {w}");
        }
    }
    closed
}

fn inside(structure: &CellStruct, p: DVec3) -> bool {
    let mut node = structure.cell_bsp.root();
    while let Some(CellNode::Inner(n)) = node {
        if n.plane.n.as_dvec3().dot(p) + f64::from(n.plane.d) < -1e-4 {
            return false;
        }
        node = n.positive.and_then(|id| structure.cell_bsp.node(id));
    }
    true
}

fn middle(q: &[DVec3]) -> DVec3 {
    q.iter().sum::<DVec3>() / q.len() as f64
}

fn normal(q: &[DVec3]) -> DVec3 {
    (q[1] - q[0]).cross(q[2] - q[0]).normalize()
}

fn check_structure(name: &str, s: &CellStruct) -> usize {
    let drawn = corners(&s.polygons, &s.vertices);
    let doors: Vec<Corners> = s
        .portals
        .iter()
        .map(|&k| {
            let q = drawn[usize::from(k)].clone();
            let outwards = !inside(s, middle(&q) + normal(&q) * 0.01);
            if outwards {
                q.into_iter().rev().collect()
            } else {
                q
            }
        })
        .collect();
    for v in s.vertices.vertices() {
        assert!(
            inside(s, v.position.as_dvec3()),
            "{name}: vertex {:?} is outside the room",
            v.position
        );
    }
    let mut times = vec![0; s.polygons.len()];
    if let Some(tree) = &s.drawing_bsp {
        for &k in &tree.polygon_keys {
            times[usize::from(k)] += 1;
        }
        for (k, &n) in times.iter().enumerate() {
            assert_eq!(
                n == 0,
                s.portals.contains(&(k as u16)),
                "{name}: drawing polygon {k} is in {n} nodes"
            );
        }
    }
    check_physics(
        name,
        &corners(&s.physics_polygons, &s.vertices),
        &s.physics_bsp,
        &doors,
        true,
    )
}

/// All invariants of a world; answers how many points were compared with the winding number.
fn check_world(dats: &DatSet) -> usize {
    let mut compared = 0;
    for id in dats.portal().ids().expect("directory") {
        match RecordKind::of(super::super::DataSet::Portal, id) {
            RecordKind::GfxObj => {
                let shape = dats.gfx_obj(id).expect("readable").expect("listed");
                if let Some(p) = &shape.physics {
                    compared += check_physics(
                        &format!("{id:08X}"),
                        &corners(&p.polygons, &shape.vertices),
                        &p.bsp,
                        &[],
                        false,
                    );
                }
                if let Some(d) = &shape.drawing {
                    let mut times = vec![0; d.polygons.len()];
                    let ports = d.bsp.portals.iter().map(|p| p.polygon);
                    for k in d.bsp.polygon_keys.iter().copied().chain(ports) {
                        times[usize::from(k)] += 1;
                    }
                    assert!(times.iter().all(|&n| n == 1), "{id:08X}: {times:?}");
                    assert!(matches!(d.bsp.root(), Some(DrawingNode::Inner(_))));
                }
            }
            RecordKind::Environment => {
                let environment = dats.environment(id).expect("readable").expect("listed");
                for (key, s) in environment.structures.iter().enumerate() {
                    compared += check_structure(&format!("{id:08X}/{key}"), s);
                }
            }
            RecordKind::MotionTable => {
                let table = dats.motion_table(id).expect("readable").expect("listed");
                for &(style, substate) in &table.style_defaults {
                    assert!(
                        table.cycles.get(motion_key(style, substate)).is_some(),
                        "{id:08X}: {style:08X} has no default cycle"
                    );
                }
            }
            _ => {}
        }
    }
    check_rooms(dats);
    check_edges(dats);
    compared
}

/// Corners of a room's portal in landblock coordinates, and its flags.
fn portal(dats: &DatSet, room: u32, index: usize) -> (Vec<DVec3>, PortalFlags) {
    let cell = dats.env_cell(room).expect("readable").expect("listed");
    let environment = dats
        .require::<super::super::Environment>(cell.environment_id(), Some(room))
        .expect("there");
    let structure = environment.structure(cell.structure).expect("structure");
    let frame = Frame::from(cell.frame);
    let p = cell.portals[index];
    assert_eq!(
        p.polygon, structure.portals[index],
        "portals are in the structure's order"
    );
    let local = corners(&structure.polygons, &structure.vertices)[usize::from(p.polygon)].clone();
    let front_inside = inside(structure, middle(&local) + normal(&local) * 0.01);
    assert_eq!(
        front_inside,
        p.flags.contains(PortalFlags::INVERTED_SIDE),
        "{room:08X} portal {index}"
    );
    (
        local
            .iter()
            .map(|v| {
                frame
                    .local_to_global(v.as_vec3(), &Profile::default())
                    .as_dvec3()
            })
            .collect(),
        p.flags,
    )
}

fn check_rooms(dats: &DatSet) {
    for id in dats.cell().ids().expect("directory") {
        if RecordKind::of(super::super::DataSet::Cell, id) != RecordKind::EnvCell {
            continue;
        }
        let cell = dats.env_cell(id).expect("readable").expect("listed");
        for (i, p) in cell.portals.iter().enumerate() {
            let (here, _) = portal(dats, id, i);
            if p.is_outside() {
                assert_eq!(p.other_room, 0xFFFF);
                continue;
            }
            let other = dats
                .env_cell(cell.room_id(p.other_room))
                .expect("readable")
                .expect("other room");
            let back = other.portals[usize::from(p.other_portal)];
            assert_eq!(
                (
                    cell.room_id(back.other_room),
                    usize::from(back.other_portal)
                ),
                (id, i),
                "portals answer each other"
            );
            let (there, _) = portal(dats, other.id, usize::from(p.other_portal));
            for a in &here {
                assert!(
                    there.iter().any(|b| a.distance(*b) < 1e-3),
                    "{id:08X} portal {i}: {here:?} {there:?}"
                );
            }
        }
    }
}

fn check_edges(dats: &DatSet) {
    for id in dats
        .cell()
        .ids()
        .expect("directory")
        .into_iter()
        .filter(|id| id & 0xFFFF == 0xFFFF)
    {
        let block = dats.landblock(id).expect("readable").expect("listed");
        let east = dats
            .landblock(id.wrapping_add(0x0100_0000))
            .expect("readable");
        let north = dats
            .landblock(id.wrapping_add(0x0001_0000))
            .expect("readable");
        for k in 0..9 {
            if let Some(east) = &east {
                assert_eq!(
                    block.height_at(8, k),
                    east.height_at(0, k),
                    "{id:08X} east edge"
                );
            }
            if let Some(north) = &north {
                assert_eq!(
                    block.height_at(k, 8),
                    north.height_at(k, 0),
                    "{id:08X} north edge"
                );
            }
        }
    }
}

#[test]
fn worlds_of_the_repository_keep_their_promises() {
    for name in ["testbed", "testbed2"] {
        let dats = DatSet::open(world(name), Strictness::Strict).expect("world");
        let compared = check_world(&dats);
        assert!(compared > 2000, "{name}: {compared} points compared");
    }
}

/// A world with one of everything that the generator can make.
pub(super) fn generated() -> WorldBuilder {
    let mut world = WorldBuilder::new();
    let crate_shape = world.solid(&block(Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 2.0)));
    let ramp_shape = world.solid(&ramp(6.0, 3.0, 2.0));
    let octagon: Vec<[f32; 2]> = (0..8)
        .map(|i| (i as f32 * std::f32::consts::FRAC_PI_4).sin_cos())
        .map(|(s, c)| [2.0 * c, 2.0 * s])
        .collect();
    world.solid(&prism(&octagon, Axis::Z, 0.0, 1.5));
    let stairs: Vec<_> = (0..3)
        .flat_map(|i| {
            let (x, z) = (i as f32, 0.3 * (i + 1) as f32);
            block(Vec3::new(x, -1.0, 0.0), Vec3::new(x + 1.0, 1.0, z))
        })
        .collect();
    // Touching boxes do not close up as one surface; as drawing they are fine.
    world.shape(&[], &stairs);
    let crate_setup = world.setup(SetupBuilder::of_shape(crate_shape));
    world.setup(SetupBuilder::humanoid(crate_shape, 1.8, 0.4));
    let door = Rect {
        u: [-1.0, 1.0],
        v: [0.0, 2.5],
    };
    let hatch = Rect {
        u: [-1.0, 1.0],
        v: [-1.0, 1.0],
    };
    let hall = Room::new(Vec3::new(-4.0, -4.0, 0.0), Vec3::new(4.0, 4.0, 3.0));
    let rooms = world.environment(&[
        hall.clone().doorway(Side::North, door).doorway(
            Side::East,
            Rect {
                u: [-2.0, 0.5],
                v: [0.5, 2.0],
            },
        ),
        hall.clone().doorway(Side::South, door).leaf_end(),
        hall.clone()
            .doorway(
                Side::West,
                Rect {
                    u: [-2.0, 0.5],
                    v: [0.5, 2.0],
                },
            )
            .doorway(Side::Floor, hatch),
        Room::new(Vec3::new(-1.0, -1.0, -2.0), Vec3::new(1.0, 1.0, 0.0))
            .doorway(Side::Ceiling, hatch)
            .doorway(Side::Floor, hatch),
    ]);
    let home = world.block(0x10, 0x20);
    home.heights(|x, y| {
        if (1..8).contains(&x) && (1..8).contains(&y) {
            (x * y) as u8
        } else {
            0
        }
    });
    home.object(crate_setup, Vec3::new(30.0, 30.0, 2.5), 45.0);
    home.object(ramp_shape, Vec3::new(60.0, 30.0, 5.0), 0.0);
    let at = |x, y, z| StoredFrame::at(Vec3::new(x, y, z));
    let a = home.room(rooms, 0, at(96.0, 96.0, -50.0), 2);
    let b = home.room(rooms, 1, at(96.0, 104.0, -50.0), 1);
    let c = home.room(rooms, 2, at(104.0, 96.0, -50.0), 2);
    let d = home.room(rooms, 3, at(104.0, 96.0, -50.0), 2);
    home.connect((a, 0), (b, 0))
        .connect((a, 1), (c, 0))
        .connect((c, 1), (d, 0));
    home.room_object(a, crate_setup, Vec3::new(97.0, 97.0, -50.0), 10.0)
        .restrict(b, 0x5000_0001);
    world.surround();
    world
}

#[test]
fn generated_worlds_keep_their_promises() {
    let dats = generated().build().expect("a world");
    let compared = check_world(&dats);
    assert!(compared > 300, "{compared} points compared");
    assert_eq!(dats.portal().check().errors, []);
    assert_eq!(dats.cell().check().errors, []);
    // One spare room portal leads outdoors: the shaft's lower end.
    let shaft = dats
        .env_cell(0x1020_0103)
        .expect("readable")
        .expect("there");
    assert!(shaft.portals[1].is_outside() && shaft.seen_outside());
}

#[test]
fn the_generator_is_deterministic() {
    assert_eq!(
        generated().write().expect("written"),
        generated().write().expect("written")
    );
}

#[test]
fn a_record_that_cannot_be_written_is_reported() {
    let mut world = WorldBuilder::new();
    world.setup(SetupBuilder::new().with(|s| s.parents.push(1)));
    let error = world.build().expect_err("parents without parts");
    assert!(error.to_string().contains("parent parts"), "{error}");
    assert!(super::super::Setup::empty(1).to_bytes().is_ok());
}
