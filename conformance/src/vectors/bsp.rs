//! Vector family `bsp` (`spec/vector-format.md`; defined in `spec/04-collision-primitives.md`, 10).

use ac_client::math::{BoundingBox, Sphere, Vec3};
use ac_client::physics::collision::{
    BoundingType, CellTree, PhysicsTree, PolygonIndex, PolygonList, SolidSearch, SourceNode,
    TouchedPolygon, WalkableSearch,
};
use ac_client::profile::Profile;
use serde_json::{Value, json};

use super::VectorContext;
use super::json::{boolean, f32, int, list, put};
use super::math::{plane, put_vec3, sphere, vec3};

/// The library's answer to one vector; `None`: not implemented.
pub fn answer(ctx: &VectorContext<'_>, vector: &Value) -> Option<Value> {
    let args = &vector["in"];
    match vector["fn"].as_str()? {
        "physics_bsp" => {
            let tree = physics_tree(args, ctx.profile)?;
            let results = list(&args["queries"], |q| query(&tree, q, ctx.profile))?;
            Some(json!({ "results": results }))
        }
        "cell_bsp" => cell_bsp(args),
        _ => None,
    }
}

fn cell_bsp(args: &Value) -> Option<Value> {
    let tree = CellTree::new(list(&args["planes"], plane)?, false);
    let spheres = list(&args["spheres"], sphere)?;
    let inside: Vec<bool> = spheres.iter().map(|s| tree.contains(s.center)).collect();
    let of_sphere: Vec<u8> = spheres
        .iter()
        .map(|s| tree.intersects_sphere(s) as u8)
        .collect();
    let of_box = list(&args["boxes"], |b| {
        let bounds = BoundingBox {
            min: vec3(&b["min"])?,
            max: vec3(&b["max"])?,
        };
        Some(if tree.intersects_box(&bounds) {
            BoundingType::PartiallyInside as u8
        } else {
            BoundingType::Outside as u8
        })
    })?;
    Some(json!({ "point_inside": inside, "sphere": of_sphere, "box": of_box }))
}

/// A node of the nested tree in the order of the flat one.
struct Flat<'a> {
    value: &'a Value,
    positive: Option<usize>,
    negative: Option<usize>,
    polygons: Vec<u16>,
}

fn physics_tree(args: &Value, profile: &Profile) -> Option<PhysicsTree> {
    let mut polygons = PolygonList::default();
    for (key, corners) in list(&args["polys"], |p| list(p, vec3))?
        .into_iter()
        .enumerate()
    {
        polygons.push(u16::try_from(key).ok()?, corners, true, profile);
    }
    let mut flat: Vec<Flat<'_>> = Vec::new();
    // Each entry: the node's value, and the parent that waits for its number.
    let mut open = vec![(&args["tree"], None)];
    while let Some((value, parent)) = open.pop() {
        let number = flat.len();
        match parent {
            Some((at, true)) => flat.get_mut::<usize>(at)?.positive = Some(number),
            Some((at, false)) => flat.get_mut::<usize>(at)?.negative = Some(number),
            None => {}
        }
        let leaf = value.get("leaf").is_some();
        for (name, positive) in [("neg", false), ("pos", true)] {
            if let Some(child) = value.get(name).filter(|c| !leaf && !c.is_null()) {
                open.push((child, Some((number, positive))));
            }
        }
        flat.push(Flat {
            value,
            positive: None,
            negative: None,
            polygons: match value.get("polys") {
                Some(keys) => list(keys, |k| u16::try_from(int(k)?).ok())?,
                None => Vec::new(),
            },
        });
    }
    let nodes: Vec<SourceNode<'_>> = flat.iter().map(source_node).collect::<Option<_>>()?;
    PhysicsTree::new(&nodes, &polygons).ok()
}

fn source_node<'a>(node: &'a Flat<'_>) -> Option<SourceNode<'a>> {
    let bound = sphere(&node.value["sphere"])?;
    Some(if node.value.get("leaf").is_some() {
        SourceNode::Leaf {
            solid: int(&node.value["solid"])? as i32,
            sphere: bound,
            polygons: &node.polygons,
        }
    } else {
        SourceNode::Inner {
            plane: plane(&node.value["plane"])?,
            sphere: bound,
            positive: node.positive,
            negative: node.negative,
        }
    })
}

fn query(tree: &PhysicsTree, q: &Value, p: &Profile) -> Option<Value> {
    let key = |i: Option<PolygonIndex>| i.and_then(|i| tree.polygon_key(i));
    let ball = Sphere::new(vec3(&q["center"])?, f32(&q["radius"])?);
    let movement = vec3(&q["movement"])?;
    let allowance = f32(&q["walkable_allowance"])?;
    let center_check = boolean(&q["center_check"])?;
    let mut touched = TouchedPolygon::default();
    let hit = tree.sphere_intersects_poly(&ball, movement, &mut touched, p);
    let mut walk = WalkableSearch {
        sphere: ball,
        movement,
        up: Vec3::Z,
        walkable_allowance: allowance,
        walk_interp: f32(&q["walk_interp"])?,
        found: None,
    };
    tree.find_walkable(&mut walk, p);
    let mut solid = SolidSearch::default();
    let solid_poly =
        tree.sphere_intersects_solid_poly(&ball, ball.radius, &mut solid, center_check, p);
    Some(json!({
        "point_solid": tree.point_intersects_solid(ball.center, p),
        "sphere_poly": hit,
        "poly": key(touched.polygon),
        "contact": put_vec3(touched.contact),
        "sphere_solid": tree.sphere_intersects_solid(&ball, center_check, p),
        "walkable_changed": walk.found.is_some(),
        "walkable": key(walk.found),
        "walkable_center": put_vec3(walk.sphere.center),
        "walk_interp": put::f32(walk.walk_interp),
        "hits_walkable": tree.hits_walkable(&ball, Vec3::Z, allowance, p),
        "solid_poly": solid_poly,
        "center_solid": solid.center_solid,
        "solid_hit": key(solid.hit),
    }))
}
