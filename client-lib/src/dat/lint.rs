//! What the physics takes for granted and no reader checks: reported, never refused. Source: `spec/11-dat-files.md, 11`.

use std::collections::BTreeSet;
use std::fmt;

use serde::Serialize;

use super::bsp::{NodeId, PhysicsBsp, PhysicsNode};
use super::error::DatError;
use super::kind::{DataSet, RecordKind};
use super::polygon::PolygonSet;
use super::set::DatSet;
use super::vertex::VertexArray;
use super::{Animation, CellStruct, EnvCell, Environment, GfxObj, MotionTable, Setup, motion_key};
use crate::math::Vec3;

/// Something that breaks one reference or makes it answer nonsense.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Lint {
    /// Record.
    pub id: u32,
    /// Number of the rule in `spec/11-dat-files.md, 11`.
    pub rule: u8,
    /// What was found.
    pub what: String,
}

impl fmt::Display for Lint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "record 0x{:08X}, rule {}: {}",
            self.id, self.rule, self.what
        )
    }
}

struct Lints {
    id: u32,
    found: Vec<Lint>,
}

impl Lints {
    fn add(&mut self, rule: u8, what: impl Into<String>) {
        self.found.push(Lint {
            id: self.id,
            rule,
            what: what.into(),
        });
    }

    fn check(&mut self, good: bool, rule: u8, what: impl FnOnce() -> String) {
        if !good {
            self.add(rule, what());
        }
    }
}

/// Goes through all records of a world that physics uses.
///
/// # Errors
/// A record that cannot be read.
pub fn world(dats: &DatSet) -> Result<Vec<Lint>, DatError> {
    let mut lints = Lints {
        id: 0,
        found: Vec::new(),
    };
    for id in dats.portal().ids()? {
        lints.id = id;
        match RecordKind::of(DataSet::Portal, id) {
            RecordKind::GfxObj => shape(&*dats.require::<GfxObj>(id, None)?, &mut lints),
            RecordKind::Environment => {
                for (key, s) in dats
                    .require::<Environment>(id, None)?
                    .structures
                    .iter()
                    .enumerate()
                {
                    structure(key, s, &mut lints);
                }
            }
            RecordKind::Setup => setup(dats, &*dats.require::<Setup>(id, None)?, &mut lints)?,
            RecordKind::MotionTable => {
                motion_table(dats, &*dats.require::<MotionTable>(id, None)?, &mut lints)?
            }
            _ => {}
        }
    }
    region(dats, &mut lints);
    for id in dats.cell().ids()? {
        lints.id = id;
        match RecordKind::of(DataSet::Cell, id) {
            RecordKind::EnvCell => room(dats, &*dats.require::<EnvCell>(id, None)?, &mut lints)?,
            RecordKind::Landblock => landblock(dats, id, &mut lints)?,
            _ => {}
        }
    }
    dats.forget_unused();
    Ok(lints.found)
}

fn shape(record: &GfxObj, lints: &mut Lints) {
    if let Some(p) = &record.physics {
        polygons("physics", &p.polygons, &record.vertices, lints);
        physics_tree(&p.bsp, &p.polygons, &record.vertices, lints);
    }
    if let Some(d) = &record.drawing {
        polygons("drawing", &d.polygons, &record.vertices, lints);
    }
}

fn structure(key: usize, s: &CellStruct, lints: &mut Lints) {
    polygons("physics", &s.physics_polygons, &s.vertices, lints);
    polygons("drawing", &s.polygons, &s.vertices, lints);
    physics_tree(&s.physics_bsp, &s.physics_polygons, &s.vertices, lints);
    lints.check(!s.portals.is_empty(), 9, || {
        format!("structure {key} has no portal")
    });
}

/// Rule 1: convex, flat, at least three distinct points.
fn polygons(which: &str, set: &PolygonSet, vertices: &VertexArray, lints: &mut Lints) {
    for p in set.iter() {
        let points: Vec<Vec3> = p
            .points
            .iter()
            .filter_map(|&v| vertices.get(v))
            .map(|v| v.position)
            .collect();
        let distinct: BTreeSet<[u32; 3]> = points
            .iter()
            .map(|p| (*p + Vec3::ZERO).to_array().map(f32::to_bits))
            .collect();
        if distinct.len() < 3 {
            lints.add(
                1,
                format!(
                    "{which} polygon {} has {} distinct points",
                    p.key,
                    distinct.len()
                ),
            );
            continue;
        }
        let mut normal = Vec3::ZERO;
        for w in points.windows(2).skip(1) {
            normal += (w[0] - points[0]).cross(w[1] - points[0]);
        }
        let normal = normal.normalize_or_zero();
        let size = points
            .iter()
            .map(|q| (*q - points[0]).length())
            .fold(0.0, f32::max);
        let flat = points
            .iter()
            .all(|q| normal.dot(*q - points[0]).abs() <= 1e-3 * size.max(1.0));
        lints.check(flat, 1, || format!("{which} polygon {} is not flat", p.key));
        let n = points.len();
        let turns = (0..n).map(|i| {
            (points[(i + 1) % n] - points[i])
                .cross(points[(i + 2) % n] - points[(i + 1) % n])
                .dot(normal)
        });
        let convex = turns.into_iter().all(|t| t >= -1e-3 * size);
        lints.check(convex, 1, || {
            format!("{which} polygon {} is not convex", p.key)
        });
    }
}

/// Rules 3 to 6, and the length of plane normals.
fn physics_tree(tree: &PhysicsBsp, set: &PolygonSet, vertices: &VertexArray, lints: &mut Lints) {
    lints.check(
        matches!(tree.root(), Some(PhysicsNode::Inner(_))),
        3,
        || "the root of the physics tree is a leaf".to_owned(),
    );
    let mut listed = BTreeSet::new();
    for (i, node) in tree.nodes.iter().enumerate() {
        match node {
            PhysicsNode::Inner(n) => {
                lints.check(n.positive.is_some() && n.negative.is_some(), 4, || {
                    format!("node {i} lacks a child")
                });
                let length = n.plane.n.length();
                lints.check((length - 1.0).abs() <= 1e-3, 6, || {
                    format!("normal of node {i} has length {length}")
                });
            }
            PhysicsNode::Leaf(l) => {
                let keys = tree.polygons(l.polygons);
                listed.extend(keys.iter().copied());
                lints.check(l.solid == 0 || !keys.is_empty(), 5, || {
                    format!("solid leaf {i} has no polygons")
                });
            }
        }
    }
    for key in (0..set.len() as u16).filter(|k| !listed.contains(k)) {
        lints.add(5, format!("physics polygon {key} is in no leaf"));
    }
    spheres(tree, set, vertices, lints);
}

/// Rule 6: the sphere of a node holds all polygons below it.
fn spheres(tree: &PhysicsBsp, set: &PolygonSet, vertices: &VertexArray, lints: &mut Lints) {
    // Polygons below each node, from the last node to the first: children come after their parents.
    let mut below: Vec<BTreeSet<u16>> = vec![BTreeSet::new(); tree.nodes.len()];
    for (i, node) in tree.nodes.iter().enumerate().rev() {
        let keys = match node {
            PhysicsNode::Leaf(l) => tree.polygons(l.polygons).iter().copied().collect(),
            PhysicsNode::Inner(n) => {
                let child = |c: Option<NodeId>| {
                    c.and_then(|c| below.get(c.index()))
                        .cloned()
                        .unwrap_or_default()
                };
                let mut keys = child(n.positive);
                keys.extend(child(n.negative));
                keys
            }
        };
        let s = node.sphere();
        let outside = |&key: &u16| {
            set.get(key).is_some_and(|p| {
                let far = |v: &u16| {
                    vertices
                        .get(*v)
                        .is_some_and(|v| (v.position - s.center).length() > s.radius + 1e-3)
                };
                p.points.iter().any(far)
            })
        };
        if let Some(key) = keys.iter().find(|k| outside(k)) {
            lints.add(
                6,
                format!("the sphere of node {i} does not hold polygon {key}"),
            );
        }
        below[i] = keys;
    }
}

fn setup(dats: &DatSet, s: &Setup, lints: &mut Lints) -> Result<(), DatError> {
    lints.check(
        s.parts.is_empty() || s.placements.get(0).is_some(),
        18,
        || "no placement under key 0".to_owned(),
    );
    for &part in &s.parts {
        lints.check(part == 0 || dats.portal().contains(part)?, 18, || {
            format!("part 0x{part:08X} does not exist")
        });
    }
    Ok(())
}

fn motion_table(dats: &DatSet, table: &MotionTable, lints: &mut Lints) -> Result<(), DatError> {
    for &(style, substate) in &table.style_defaults {
        let there = table.cycles.get(motion_key(style, substate)).is_some();
        lints.check(there, 17, || {
            format!("style 0x{style:08X} has no cycle for its default substate")
        });
    }
    for (key, cycle) in &table.cycles {
        lints.check(!cycle.anims.is_empty(), 17, || {
            format!("cycle 0x{key:08X} has no animation")
        });
    }
    let links = table.links.iter().flat_map(|(_, targets)| targets.iter());
    let motions = table.cycles.iter().chain(&table.modifiers).chain(links);
    let animations: BTreeSet<u32> = motions
        .flat_map(|(_, m)| m.anims.iter().map(|a| a.animation))
        .collect();
    for id in animations {
        match dats.get::<Animation>(id)? {
            None => lints.add(17, format!("animation 0x{id:08X} does not exist")),
            Some(a) => lints.check(a.frame_count() > 0, 17, || {
                format!("animation 0x{id:08X} has no frame")
            }),
        }
    }
    Ok(())
}

/// Rule 16 and the height table (D-28).
fn region(dats: &DatSet, lints: &mut Lints) {
    let region = dats.region();
    lints.id = region.id;
    let highest = region.grid.sky_height - region.grid.max_object_height;
    if let Some(i) = region
        .height_table
        .iter()
        .position(|h| !(0.0..=highest).contains(h))
    {
        lints.add(
            16,
            format!("height {i} is outside 0..={highest}: one reference stops there"),
        );
    }
    for (t, terrain) in region.terrain_types.iter().enumerate() {
        let outside = |&&i: &&i32| i < -1 || i64::from(i) >= region.scene_types.len() as i64;
        if let Some(i) = terrain.scene_types.iter().find(outside) {
            lints.add(16, format!("terrain type {t} names scene type {i}"));
        }
    }
}

/// Rules 10 and 11, and what a room refers to.
fn room(dats: &DatSet, cell: &EnvCell, lints: &mut Lints) -> Result<(), DatError> {
    let Some(environment) = dats.get::<Environment>(cell.environment_id())? else {
        lints.add(
            9,
            format!("environment 0x{:08X} does not exist", cell.environment_id()),
        );
        return Ok(());
    };
    let Some(structure) = environment.structure(cell.structure) else {
        lints.add(
            9,
            format!(
                "environment 0x{:08X} has no structure {}",
                environment.id, cell.structure
            ),
        );
        return Ok(());
    };
    let in_order = cell
        .portals
        .iter()
        .map(|p| p.polygon)
        .eq(structure.portals.iter().copied());
    lints.check(in_order, 10, || {
        "portals are not those of the structure, in its order".to_owned()
    });
    for (i, p) in cell.portals.iter().enumerate() {
        if p.is_outside() {
            continue;
        }
        lints.check(cell.visible_rooms.contains(&p.other_room), 11, || {
            format!("neighbour 0x{:04X} is not visible", p.other_room)
        });
        let back = dats
            .get::<EnvCell>(cell.room_id(p.other_room))?
            .and_then(|o| o.portals.get(usize::from(p.other_portal)).copied());
        let answers = back.is_some_and(|b| {
            cell.room_id(b.other_room) == cell.id && usize::from(b.other_portal) == i
        });
        lints.check(answers, 10, || {
            format!("portal {i} is not answered by room 0x{:04X}", p.other_room)
        });
    }
    Ok(())
}

fn landblock(dats: &DatSet, id: u32, lints: &mut Lints) -> Result<(), DatError> {
    let Some(block) = dats.landblock(id)? else {
        return Ok(());
    };
    let info = dats.landblock_info_of(id)?;
    lints.check((block.has_info != 0) == info.is_some(), 15, || {
        "the mark of an info record is wrong".to_owned()
    });
    let region = dats.region();
    let wrong = |t: &super::TerrainWord| {
        let types = region.terrain_types.get(usize::from(t.terrain()));
        types.is_none_or(|t2| {
            !t2.scene_types.is_empty() && usize::from(t.scenery()) >= t2.scene_types.len()
        })
    };
    if let Some(i) = block.terrain.iter().position(wrong) {
        lints.add(
            16,
            format!("terrain word {i} names no scenery of its terrain type"),
        );
    }
    for room in info.iter().flat_map(|i| 0..i.room_count) {
        let room = id & 0xFFFF_0000 | (0x0100 + room);
        lints.check(dats.cell().contains(room)?, 15, || {
            format!("room 0x{room:08X} does not exist")
        });
    }
    Ok(())
}
