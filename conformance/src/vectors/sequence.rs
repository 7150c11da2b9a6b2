//! Vector family `sequence` (`spec/vector-format.md`; defined in `spec/07-animation.md`, 7 and 8).

use ac_client::animation::{AnimHookQueue, AnimSequenceNode, Sequence};
use ac_client::math::Frame;
use serde_json::{Map, Value, json};

use super::VectorContext;
use super::json::{boolean, f32, f64, int, put};
use super::math::{put_frame, put_vec3, vec3};
use super::tables::{Tables, marker, range};

/// The library's answer to one vector; `None`: not implemented.
pub fn answer(ctx: &VectorContext<'_>, vector: &Value) -> Option<Value> {
    let mut tables = Tables::read(ctx)?;
    let mut sequence = Sequence::new();
    let mut hooks = AnimHookQueue::new();
    let operations = vector["ops"].as_array()?.iter();
    operations
        .take_while(|op| op.get("exception").is_none())
        .map(|op| {
            let frame = operate(&mut sequence, &mut hooks, op, &mut tables, ctx)?;
            let mut state = state(&sequence);
            if let Some(frame) = frame {
                state.insert("frame".into(), put_frame(&frame));
            }
            let types: Vec<_> = hooks.drain(..).map(|hook| marker(&hook)).collect();
            state.insert("hooks".into(), json!(types));
            Some(Value::Object(state))
        })
        .collect()
}

/// Carries out one operation; the offset frame of an update that has one.
fn operate(
    sequence: &mut Sequence,
    hooks: &mut AnimHookQueue,
    op: &Value,
    tables: &mut Tables,
    ctx: &VectorContext<'_>,
) -> Option<Option<Frame>> {
    match op["op"].as_str()? {
        "append" => sequence.append_animation(&range(op)?, tables, ctx.profile),
        "set_physics" => {
            sequence.velocity = vec3(&op["velocity_in"])?;
            sequence.omega = vec3(&op["omega_in"])?;
        }
        "remove_cyclic" => sequence.remove_cyclic_animations(),
        "remove_all_links" => sequence.remove_all_link_animations(),
        "remove_links" => sequence.remove_link_animations(u32::try_from(int(&op["amount"])?).ok()?),
        "clear" => sequence.clear(),
        "multiply_cyclic_rate" => sequence.multiply_cyclic_rate(f32(&op["factor"])?),
        "update" => {
            let mut frame = Frame::IDENTITY;
            let with_frame = boolean(&op["with_frame"])?;
            let offset = with_frame.then_some(&mut frame);
            sequence
                .update(f64(&op["dt"])?, offset, hooks, ctx.profile)
                .ok()?;
            return Some(with_frame.then_some(frame));
        }
        _ => return None,
    }
    Some(None)
}

/// The state of a sequence, without its hooks.
pub fn state(sequence: &Sequence) -> Map<String, Value> {
    let index = |i: Option<usize>| i.map_or(-1, |i| i as i64);
    let queue: Vec<_> = sequence.nodes().map(node).collect();
    let fields = [
        ("frame_number", put::f64(sequence.frame_number())),
        ("queue", Value::from(queue)),
        ("current", json!(index(sequence.current_index()))),
        ("first_cyclic", json!(index(sequence.first_cyclic_index()))),
        ("velocity", put_vec3(sequence.velocity)),
        ("omega", put_vec3(sequence.omega)),
    ];
    fields.map(|(k, v)| (k.to_owned(), v)).into_iter().collect()
}

fn node(node: &AnimSequenceNode) -> Value {
    json!({
        "anim": put::id(node.animation_id()),
        "low": node.low,
        "high": node.high,
        "rate": put::f32(node.rate),
    })
}
