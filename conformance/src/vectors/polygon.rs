//! Vector family `polygon` (`spec/vector-format.md`; defined in `spec/04-collision-primitives.md`, 7).

use ac_client::math::{Sidedness, Vec3};
use ac_client::physics::collision::{PlacementSolidity, Polygon, make_plane};
use serde_json::{Value, json};

use super::VectorContext;
use super::json::{boolean, f32, list, put};
use super::math::{put_plane, put_vec3, sphere, vec3};

/// The library's answer to one vector; `None`: not implemented.
pub fn answer(ctx: &VectorContext<'_>, vector: &Value) -> Option<Value> {
    let (name, args, p) = (vector["fn"].as_str()?, &vector["in"], ctx.profile);
    let vertices = list(&args["vertices"], vec3)?;
    let polygon = Polygon::new(&vertices, p);
    let ball = || sphere(&args["sphere"]);
    let up = || vec3(&args["up"]);
    let mut contact = Vec3::ZERO;
    Some(match name {
        "make_plane" => json!({ "plane": put_plane(&make_plane(&vertices, p)) }),
        "point_in_polygon" => json!({ "inside": polygon.contains(vec3(&args["point"])?) }),
        "point_in_poly2d" => {
            let point = vec3(&args["point"])?;
            json!({
                "positive": polygon.contains_2d(point, Sidedness::Positive),
                "negative": polygon.contains_2d(point, Sidedness::Negative),
            })
        }
        "check_walkable" => json!({
            "result": polygon.check_walkable(&ball()?, up()?, p),
            "small": polygon.check_small_walkable(&ball()?, up()?, p),
        }),
        "walkable_hits_sphere" => {
            let allowance = f32(&args["walkable_allowance"])?;
            json!({ "result": polygon.walkable_hits_sphere(&ball()?, up()?, allowance) })
        }
        "hits_sphere_precise" => {
            let hit = polygon.hits_sphere_precise(&ball()?, &mut contact);
            json!({ "result": hit, "contact": put_vec3(contact) })
        }
        "polygon_hits_sphere" => {
            let hit = polygon.hits_sphere_fast(&ball()?, &mut contact);
            json!({ "result": hit, "contact": put_vec3(contact) })
        }
        "adjust_sphere_to_plane" => {
            let (mut ball, mut walk_interp) = (ball()?, f32(&args["walk_interp"])?);
            let movement = vec3(&args["movement"])?;
            let result = polygon.adjust_sphere_to_plane(&mut ball, movement, &mut walk_interp, p);
            json!({
                "result": result,
                "center": put_vec3(ball.center),
                "walk_interp": put::f32(walk_interp),
            })
        }
        "pos_hits_sphere" => {
            let movement = vec3(&args["movement"])?;
            let (struck, hit) = polygon.pos_hits_sphere(&ball()?, movement, &mut contact);
            json!({ "result": hit, "struck": struck, "contact": put_vec3(contact) })
        }
        "adjust_to_placement_poly" => {
            let solidity = PlacementSolidity {
                center_solid: boolean(&args["center_solid"])?,
                solid_check: boolean(&args["solid_check"])?,
            };
            let (struck, other) = (sphere(&args["struck"])?, sphere(&args["other"])?);
            let shift = polygon.placement_offset(struck.center, f32(&args["radius"])?, solidity, p);
            json!({ "struck": put_vec3(struck.center + shift), "other": put_vec3(other.center + shift) })
        }
        "find_crossed_edge" => match polygon.find_crossed_edge(&ball()?, up()?) {
            Some(normal) => json!({ "result": true, "normal": put_vec3(normal) }),
            None => json!({ "result": false }),
        },
        _ => return None,
    })
}
