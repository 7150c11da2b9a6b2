//! Vector family `position` (`spec/vector-format.md`; defined in `spec/01-math-and-positions.md`, 11).

use ac_client::math::UprightCylinder;
use serde_json::{Value, json};

use super::VectorContext;
use super::json::{f32, put};
use super::math::{plane, position, put_frame, put_plane, put_position, put_vec3, vec3};

/// The library's answer to one vector; `None`: not implemented.
pub fn answer(ctx: &VectorContext<'_>, vector: &Value) -> Option<Value> {
    let (name, args, p) = (vector["fn"].as_str()?, &vector["in"], ctx.profile);
    let (a, b) = (|| position(&args["a"]), || position(&args["b"]));
    Some(match name {
        "distance" => {
            json!({ "distance": put::f32(a()?.distance(&b()?)), "squared": put::f32(a()?.distance_squared(&b()?)) })
        }
        "get_offset" => json!({ "offset": put_vec3(a()?.offset_to(&b()?)) }),
        "get_offset_rotated" => {
            json!({ "offset": put_vec3(a()?.offset_to_point(&b()?, vec3(&args["point"])?, p)) })
        }
        "cylinder_distance" => {
            let (a, b) = (a()?, b()?);
            let one = UprightCylinder {
                radius: f32(&args["r1"])?,
                height: f32(&args["h1"])?,
                position: &a,
            };
            let two = UprightCylinder {
                radius: f32(&args["r2"])?,
                height: f32(&args["h2"])?,
                position: &b,
            };
            // The root is f64; an oracle that narrows it writes an f32.
            let wide = one.distance(&two, p);
            let distance = if ctx.oracle() == "ace" {
                wide
            } else {
                f64::from(wide as f32)
            };
            json!({ "distance": put::f64(distance), "no_z": put::f32(one.distance_no_z(&two)) })
        }
        "heading" => {
            json!({ "heading": put::f32(a()?.heading_to(&b()?, p)), "diff": put::f32(a()?.heading_diff(&b()?, p)) })
        }
        "determine_quadrant" => {
            json!({ "quadrant": put::id(a()?.quadrant_of(f32(&args["height"])?, &b()?, p)) })
        }
        "localtolocal" => {
            json!({ "point": put_vec3(a()?.local_to_local(&b()?, vec3(&args["point"])?, p)) })
        }
        "localtoglobal" => {
            json!({ "point": put_vec3(a()?.landblock_point_of(&b()?, vec3(&args["point"])?, p)) })
        }
        "equal" => json!({ "equal": a()?.is_equal(&b()?, p) }),
        "adjust_to_outside" => {
            let mut position = position(&args["position"])?;
            position.adjust_to_outside(p);
            json!({ "position": put_position(&position) })
        }
        "plane_localtoglobal" => {
            let (to, from) = (position(&args["to"])?, position(&args["from"])?);
            let moved = plane(&args["plane"])?.local_to_global(&to, &from, p);
            json!({ "plane": put_plane(&moved), "subtract2": put_frame(&to.relative_to(&from, p)) })
        }
        _ => return None,
    })
}
