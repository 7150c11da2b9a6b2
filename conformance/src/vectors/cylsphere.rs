//! Vector family `cylsphere` (`spec/vector-format.md`; defined in `spec/04-collision-primitives.md`, 9).

use ac_client::math::EPSILON;
use ac_client::physics::collision::CylSphere;
use ac_client::world::World;
use serde_json::{Value, json};

use super::VectorContext;
use super::json::f32;
use super::math::{put_vec3, sphere, vec3};
use super::mover;

fn cylinder(value: &Value) -> Option<CylSphere> {
    Some(CylSphere {
        low: vec3(&value["low"])?,
        radius: f32(&value["radius"])?,
        height: f32(&value["height"])?,
    })
}

/// The library's answer to one vector; `None`: not implemented.
pub fn answer(ctx: &VectorContext<'_>, vector: &Value) -> Option<Value> {
    let (name, args) = (vector["fn"].as_str()?, &vector["in"]);
    let obstacle = cylinder(&args["cyl"])?;
    if name == "collides_with_sphere" {
        let ball = sphere(&args["sphere"])?;
        let reach = obstacle.radius + ball.radius - EPSILON;
        let hit = obstacle.collides_with_sphere(&ball, ball.center - obstacle.low, reach);
        return Some(json!({ "result": hit }));
    }
    let world = World::new(ctx.profile.clone(), 0.0);
    let mut t = mover::transition(&world, args)?;
    let first = t.path.global_sphere[0];
    let reach = obstacle.radius + first.radius - EPSILON;
    let result = match name {
        "normal_of_collision" => {
            let found = obstacle.normal_of_collision(&t, 0, first.center - obstacle.low, reach);
            return Some(json!({ "definite": found.definite, "normal": put_vec3(found.normal) }));
        }
        "land_on_cylinder" => obstacle.land_on(&mut t, reach),
        "step_sphere_down" => obstacle.step_sphere_down(&mut t, reach),
        "step_sphere_up" => obstacle.step_sphere_up(&mut t, reach),
        "slide_sphere" => obstacle.slide_sphere(&mut t, 0, reach),
        "intersects_sphere" => obstacle.intersects_sphere(&mut t),
        _ => return None,
    };
    Some(mover::records(&t, result))
}
