//! Vector family `motiontable` (`spec/vector-format.md`; defined in `spec/07-animation.md`, 10 and 12).

use ac_client::animation::{
    AnimHookQueue, MotionEntry, MotionRequest, MotionTableError, MotionTableManager, Sequence,
};
use ac_client::dat::HookAction;
use ac_client::math::Frame;
use serde_json::{Map, Value, json};

use super::VectorContext;
use super::json::{f32, f64, id, put};
use super::math::put_frame;
use super::sequence;
use super::tables::{MOTION_TABLE, Tables};

/// A manager with its sequence, and what it reads from.
struct Object<'a> {
    manager: MotionTableManager,
    sequence: Sequence,
    tables: Tables,
    ctx: &'a VectorContext<'a>,
}

/// The library's answer to one vector; `None`: not implemented.
pub fn answer(ctx: &VectorContext<'_>, vector: &Value) -> Option<Value> {
    let mut tables = Tables::read(ctx)?;
    let mut object = Object {
        manager: MotionTableManager::new(MOTION_TABLE, &mut tables, ctx.profile),
        sequence: Sequence::new(),
        tables,
        ctx,
    };
    let operations = vector["ops"].as_array()?.iter();
    operations
        .take_while(|op| op.get("exception").is_none())
        .map(|op| {
            let mut results = object.operate(op)?;
            results.extend(state(&object.manager));
            results.extend(sequence::state(&object.sequence));
            Some(Value::Object(results))
        })
        .collect()
}

impl Object<'_> {
    /// Carries out one operation; its results, without the state.
    fn operate(&mut self, op: &Value) -> Option<Map<String, Value>> {
        let mut results = Map::new();
        let request = match op["op"].as_str()? {
            "do" => MotionRequest::Do {
                motion: id(&op["motion"])?,
                speed: f32(&op["speed"])?,
            },
            "stop" => MotionRequest::Stop {
                motion: id(&op["motion"])?,
            },
            "stop_completely" => MotionRequest::StopCompletely,
            "init" => {
                let Self {
                    manager,
                    sequence,
                    tables,
                    ctx,
                } = self;
                manager.initialize_state(sequence, tables, ctx.profile);
                return Some(results);
            }
            "check_completed" => {
                let mut run = self.manager.check_for_completed_motions();
                while self.manager.next_completion(&mut run).is_some() {}
                return Some(results);
            }
            "update" => return self.update(f64(&op["dt"])?),
            _ => return None,
        };
        let result = self.manager.perform(
            request,
            &mut self.sequence,
            &mut self.tables,
            self.ctx.profile,
        );
        let code = result.map_or_else(MotionTableError::code, |()| 0);
        results.insert("result".into(), code.into());
        Some(results)
    }

    /// Advances the sequence and reports each animation done.
    fn update(&mut self, dt: f64) -> Option<Map<String, Value>> {
        let (mut frame, mut hooks) = (Frame::IDENTITY, AnimHookQueue::new());
        self.sequence
            .update(dt, Some(&mut frame), &mut hooks, self.ctx.profile)
            .ok()?;
        hooks.retain(|hook| *hook == HookAction::AnimationDone);
        for _ in &hooks {
            let mut run = self.manager.animation_done(true);
            while self.manager.next_completion(&mut run).is_some() {}
        }
        let mut results = Map::new();
        results.insert("frame".into(), put_frame(&frame));
        results.insert("animations_done".into(), hooks.len().into());
        Some(results)
    }
}

/// The state of a manager.
pub fn state(manager: &MotionTableManager) -> Map<String, Value> {
    let entry = |e: &MotionEntry| json!([put::id(e.motion), put::f32(e.speed)]);
    let state = &manager.state;
    let pending: Vec<_> = manager
        .pending()
        .map(|p| json!([put::id(p.motion), p.animations]))
        .collect();
    let modifiers: Vec<_> = state.modifiers.iter().map(entry).collect();
    let actions: Vec<_> = state.actions.iter().map(entry).collect();
    let fields = [
        ("style", put::id(state.style)),
        ("substate", put::id(state.substate)),
        ("substate_speed", put::f32(state.substate_speed)),
        ("modifiers", modifiers.into()),
        ("actions", actions.into()),
        ("pending", pending.into()),
        ("animation_counter", manager.animation_counter.into()),
    ];
    fields.map(|(k, v)| (k.to_owned(), v)).into_iter().collect()
}
