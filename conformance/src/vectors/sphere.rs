//! Vector family `sphere` (`spec/vector-format.md`; defined in `spec/04-collision-primitives.md`, 8).

use ac_client::math::{EPSILON, Ray};
use ac_client::physics::collision::{collides_with_sphere, find_time_of_collision};
use ac_client::world::World;
use serde_json::{Value, json};

use super::VectorContext;
use super::json::{boolean, f32, put};
use super::math::{sphere, vec3};
use super::mover;

/// The library's answer to one vector; `None`: not implemented.
pub fn answer(ctx: &VectorContext<'_>, vector: &Value) -> Option<Value> {
    let (name, args, p) = (vector["fn"].as_str()?, &vector["in"], ctx.profile);
    Some(match name {
        "intersects" => {
            json!({ "result": sphere(&args["sphere"])?.intersects(&sphere(&args["other"])?, p) })
        }
        "intersects_ray" => {
            let ray = Ray {
                point: vec3(&args["origin"])?,
                dir: vec3(&args["direction"])?,
                length: 1.0,
            };
            json!({ "result": sphere(&args["sphere"])?.hit_by_ray(&ray, p).0 })
        }
        "collides_with_sphere" => {
            json!({ "result": collides_with_sphere(vec3(&args["disp"])?, f32(&args["radsum"])?, p) })
        }
        "find_time_of_collision" => {
            let (movement, disp) = (vec3(&args["movement"])?, vec3(&args["disp"])?);
            let time = find_time_of_collision(movement, disp, f32(&args["radsum"])?, p);
            json!({ "time": put::f64(time) })
        }
        _ => return against_mover(ctx, name, args),
    })
}

fn against_mover(ctx: &VectorContext<'_>, name: &str, args: &Value) -> Option<Value> {
    let world = World::new(ctx.profile.clone(), 0.0);
    let mut t = mover::transition(&world, args)?;
    let obstacle = sphere(&args["sphere"]);
    let reach = obstacle.map(|o| o.radius + t.path.global_sphere[0].radius - EPSILON);
    let result = match name {
        "slide_sphere_normal" => {
            let mut normal = vec3(&args["normal"])?;
            let center = t.path.global_sphere[0].center;
            let current = t.path.global_curr_center[0];
            t.slide_sphere(center, &mut normal, current)
        }
        "slide_sphere_disp" => obstacle?.slide_below(&mut t),
        "land_on_sphere" => obstacle?.land_on(&mut t),
        "step_sphere_down" => obstacle?.step_sphere_down(&mut t, reach?),
        "step_sphere_up" => obstacle?.step_sphere_up(&mut t, reach?),
        "intersects_sphere" => obstacle?.intersects_sphere(&mut t, boolean(&args["is_creature"])?),
        _ => return None,
    };
    Some(mover::records(&t, result))
}
