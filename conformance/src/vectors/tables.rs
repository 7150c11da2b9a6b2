//! The table lines of the animation families as a source of records (`spec/vector-format.md`, "Tables").

use std::sync::Arc;

use ac_client::animation::AnimationSource;
use ac_client::dat::{
    AnimFrame, AnimRange, Animation, AnimationHook, HookAction, HookDirection, KeyedList,
    MotionBits, MotionData, MotionDataFlags, MotionTable, Setup, StoredFrame,
};
use ac_client::physics::collision::GfxShape;
use ac_client::world::MemorySource;
use serde_json::Value;

use super::VectorContext;
use super::json::{f32, id, int, list, nullable};
use super::math::{quat, vec3};

/// Id of the motion table of the vectors.
pub const MOTION_TABLE: u32 = 0x0900_0001;

/// Animations and the motion table of a vector file.
#[derive(Debug, Default)]
pub struct Tables {
    animations: Vec<Arc<Animation>>,
    motion_table: Option<Arc<MotionTable>>,
}

impl Tables {
    /// Reads the table lines; `None` if they are malformed.
    pub fn read(ctx: &VectorContext<'_>) -> Option<Self> {
        let animations = ctx.table("animations")?.as_object()?;
        let animations: Option<Vec<_>> = animations
            .iter()
            .map(|(key, value)| Some(Arc::new(animation(id(&Value::from(key.as_str()))?, value)?)))
            .collect();
        let motion_table = match ctx.table("motion_table") {
            Some(table) => Some(Arc::new(motion_table(table)?)),
            None => None,
        };
        Some(Self {
            animations: animations?,
            motion_table,
        })
    }
}

impl Tables {
    /// A world that holds these tables and nothing else.
    pub fn into_source(self) -> MemorySource {
        MemorySource {
            animations: self.animations.into_iter().map(|a| (a.id, a)).collect(),
            motion_tables: self.motion_table.into_iter().map(|t| (t.id, t)).collect(),
            ..MemorySource::default()
        }
    }
}

impl AnimationSource for Tables {
    fn animation(&mut self, id: u32) -> Option<Arc<Animation>> {
        self.animations.iter().find(|a| a.id == id).cloned()
    }

    fn motion_table(&mut self, id: u32) -> Option<Arc<MotionTable>> {
        self.motion_table.clone().filter(|t| t.id == id)
    }

    fn setup(&mut self, _id: u32) -> Option<Arc<Setup>> {
        None
    }

    fn shape(&mut self, _id: u32) -> Option<Arc<GfxShape>> {
        None
    }
}

/// A marker hook, as a hook without effect on anything that is compared. [`marker`] gives its number back.
fn hook(value: &Value) -> Option<(usize, AnimationHook)> {
    let frame = usize::try_from(int(&value["frame"])?).ok()?;
    let hook = AnimationHook {
        direction: HookDirection(i32::try_from(int(&value["direction"])?).ok()?),
        action: HookAction::Sound {
            wave: u32::try_from(int(&value["type"])?).ok()?,
        },
    };
    Some((frame, hook))
}

/// Type number of a queued hook of the vectors.
pub fn marker(hook: &HookAction) -> u32 {
    match hook {
        HookAction::Sound { wave } => *wave,
        other => other.kind(),
    }
}

fn animation(id: u32, value: &Value) -> Option<Animation> {
    let root = nullable(&value["pos_frames"], |frames| list(frames, stored_frame))?;
    let hooks = list(&value["hooks"], hook)?;
    let mut animation = Animation::new(id, 0);
    for frame in 0..usize::try_from(int(&value["frames"])?).ok()? {
        let here = hooks.iter().filter(|(at, _)| *at == frame);
        let pose = AnimFrame {
            parts: Vec::new(),
            hooks: here.map(|(_, hook)| hook.clone()).collect(),
        };
        let root = match &root {
            Some(frames) => Some(*frames.get(frame)?),
            None => None,
        };
        animation.push(pose, root);
    }
    Some(animation)
}

fn stored_frame(value: &Value) -> Option<StoredFrame> {
    Some(StoredFrame {
        origin: vec3(&value["origin"])?,
        rotation: quat(&value["rotation"])?,
    })
}

fn motion_table(value: &Value) -> Option<MotionTable> {
    let mut table = MotionTable::new(MOTION_TABLE, id(&value["default_style"])?);
    table.style_defaults = list(&value["style_defaults"], |pair| {
        Some((id(&pair[0])?, id(&pair[1])?))
    })?
    .into_iter()
    .collect();
    table.cycles = motions(&value["cycles"])?;
    table.modifiers = motions(&value["modifiers"])?;
    table.links = list(&value["links"], |link| {
        Some((id(&link["key"])?, motions(&link["to"])?))
    })?
    .into_iter()
    .collect();
    Some(table)
}

fn motions(value: &Value) -> Option<KeyedList<u32, MotionData>> {
    let entries = list(value, |data| Some((id(&data["key"])?, motion(data)?)))?;
    Some(entries.into_iter().collect())
}

fn motion(value: &Value) -> Option<MotionData> {
    Some(MotionData {
        bits: MotionBits::from_bits_retain(u8::try_from(int(&value["bitfield"])?).ok()?),
        flags: MotionDataFlags::all(),
        anims: list(&value["anims"], range)?,
        velocity: vec3(&value["velocity"])?,
        omega: vec3(&value["omega"])?,
    })
}

/// A range of an animation.
pub fn range(value: &Value) -> Option<AnimRange> {
    let frame = |name: &str| i32::try_from(int(&value[name])?).ok();
    Some(AnimRange {
        animation: id(&value["anim"])?,
        low_frame: frame("low")?,
        high_frame: frame("high")?,
        framerate: f32(&value["rate"])?,
    })
}
