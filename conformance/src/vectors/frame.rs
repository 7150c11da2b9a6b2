//! Vector family `frame` (`spec/vector-format.md`; defined in `spec/01-math-and-positions.md`, 5 to 9).

use ac_client::math::{Frame, heading_of_vector, vector};
use serde_json::{Value, json};

use super::VectorContext;
use super::json::{f32, put};
use super::math::{frame, plane, put_frame, put_vec3, quat, vec3};

/// The library's answer to one vector; `None`: not implemented.
pub fn answer(ctx: &VectorContext<'_>, vector: &Value) -> Option<Value> {
    let (name, args, p) = (vector["fn"].as_str()?, &vector["in"], ctx.profile);
    let f = || frame(&args["frame"]);
    let changed = |change: &dyn Fn(&mut Frame) -> Option<()>| {
        let mut frame = f()?;
        change(&mut frame)?;
        Some(json!({ "frame": put_frame(&frame) }))
    };
    let point = |v| Some(json!({ "point": put_vec3(v) }));
    let combined = |v: Frame| Some(json!({ "frame": put_frame(&v) }));
    match name {
        "globaltolocal" => point(f()?.global_to_local(vec3(&args["point"])?, p)),
        "globaltolocalvec" => point(f()?.global_to_local_vec(vec3(&args["point"])?, p)),
        "localtoglobal" => point(f()?.local_to_global(vec3(&args["point"])?, p)),
        "localtoglobalvec" => point(f()?.local_to_global_vec(vec3(&args["point"])?, p)),
        "localtolocal" => {
            point(f()?.local_to_local(&frame(&args["from"])?, vec3(&args["point"])?, p))
        }
        "combine" => combined(frame(&args["a"])?.combine(&frame(&args["b"])?, p)),
        "combine_scaled" => combined(frame(&args["a"])?.combine_scaled(
            &frame(&args["b"])?,
            vec3(&args["scale"])?,
            p,
        )),
        "subtract1" => combined(frame(&args["a"])?.subtract_animation(&frame(&args["b"])?, p)),
        "subtract2" => combined(frame(&args["a"])?.relative_to(&frame(&args["b"])?, p)),
        "rotate" => changed(&|frame| {
            frame.rotate(vec3(&args["angles"])?, p);
            Some(())
        }),
        "grotate" => changed(&|frame| {
            frame.grotate(vec3(&args["angles"])?, p);
            Some(())
        }),
        "euler_set_rotate" => changed(&|frame| {
            frame.set_rotation_euler(vec3(&args["angles"])?, p);
            Some(())
        }),
        "set_vector_heading" => changed(&|frame| {
            frame.set_vector_heading(vec3(&args["vector"])?, p);
            Some(())
        }),
        "interpolate_rotation" => changed(&|f| {
            f.interpolate_rotation(
                &frame(&args["from"])?,
                &frame(&args["to"])?,
                f32(&args["t"])?,
                p,
            );
            Some(())
        }),
        "set_rotate" => {
            let mut frame = f()?;
            frame.set_rotation(quat(&args["rotation"])?, p);
            let matrix: Vec<f32> = frame.axes(p).iter().flat_map(|r| r.to_array()).collect();
            Some(
                json!({ "frame": put_frame(&frame), "matrix": put::floats(&matrix), "valid": frame.is_valid(p) }),
            )
        }
        "set_heading" => {
            let mut frame = f()?;
            frame.set_heading(f32(&args["heading"])?, p);
            Some(json!({ "frame": put_frame(&frame), "heading_after": put::f32(frame.heading(p)) }))
        }
        "get_heading" => Some(json!({ "heading": put::f32(f()?.heading(p)) })),
        "get_vector_heading" => Some(json!({ "vector": put_vec3(f()?.forward(p)) })),
        "normalize_check_small" => {
            let v = vec3(&args["vector"])?;
            let unit = vector::normalize_check_small(v);
            Some(json!({
                "small": unit.is_none(),
                "vector": put_vec3(unit.unwrap_or(v)),
                "is_zero": vector::is_zero(v),
                "heading": put::f32(heading_of_vector(v, p)),
            }))
        }
        "snap_to_plane" => {
            let (plane, given) = (plane(&args["plane"])?, vec3(&args["offset"])?);
            let mut offset = given;
            plane.snap_to_plane(&mut offset, p);
            Some(json!({
                "offset": put_vec3(offset),
                "dot": put::f32(plane.distance(given)),
                "side": plane.which_side(given, vector::EPSILON) as u8,
            }))
        }
        _ => None,
    }
}
