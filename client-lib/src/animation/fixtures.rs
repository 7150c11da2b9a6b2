//! Records made by hand, and an object that plays them.

use std::sync::Arc;

use super::{
    AnimHookQueue, AnimationError, AnimationSource, MotionNotice, MotionRequest, MotionTableError,
    MotionTableManager, Sequence,
};
use crate::dat::{
    AnimFrame, AnimRange, Animation, AnimationHook, HookAction, HookDirection, MotionBits,
    MotionData, MotionTable, Setup, StoredFrame, motion_key,
};
use crate::math::{Frame, Vec3};
use crate::physics::collision::GfxShape;
use crate::profile::Profile;

pub const TABLE: u32 = 0x0900_0001;
pub const NON_COMBAT: u32 = 0x8000_003D;
pub const READY: u32 = 0x4100_0003;
pub const WALK: u32 = 0x4500_0005;
pub const RUN: u32 = 0x4400_0007;
pub const TURN: u32 = 0x6500_000D;
pub const SIDE: u32 = 0x6500_000F;
pub const WAVE: u32 = 0x1000_0087;

/// One quantum of the worked examples, s.
pub const STEP: f64 = 0.033_333_335_071_802_14;

/// Records by id.
#[derive(Debug, Clone, Default)]
pub struct Shelf {
    pub animations: Vec<Arc<Animation>>,
    pub tables: Vec<Arc<MotionTable>>,
    pub setups: Vec<Arc<Setup>>,
    pub shapes: Vec<(u32, Arc<GfxShape>)>,
}

impl AnimationSource for Shelf {
    fn animation(&mut self, id: u32) -> Option<Arc<Animation>> {
        self.animations.iter().find(|a| a.id == id).cloned()
    }

    fn motion_table(&mut self, id: u32) -> Option<Arc<MotionTable>> {
        self.tables.iter().find(|t| t.id == id).cloned()
    }

    fn setup(&mut self, id: u32) -> Option<Arc<Setup>> {
        self.setups.iter().find(|s| s.id == id).cloned()
    }

    fn shape(&mut self, id: u32) -> Option<Arc<GfxShape>> {
        let shape = self.shapes.iter().find(|s| s.0 == id)?;
        Some(Arc::clone(&shape.1))
    }
}

/// A hook that only its number tells from others.
pub fn marker(number: u32, direction: i32) -> AnimationHook {
    AnimationHook {
        direction: HookDirection(direction),
        action: HookAction::Sound { wave: number },
    }
}

/// An animation without parts; every frame has the same root motion, if any. Hooks are (frame, number, direction).
pub fn animation(
    id: u32,
    frames: u32,
    root: Option<Vec3>,
    hooks: &[(u32, u32, i32)],
) -> Arc<Animation> {
    let mut animation = Animation::new(id, 0);
    for frame in 0..frames {
        let here = hooks.iter().filter(|h| h.0 == frame);
        let pose = AnimFrame {
            parts: Vec::new(),
            hooks: here.map(|h| marker(h.1, h.2)).collect(),
        };
        animation.push(pose, root.map(StoredFrame::at));
    }
    Arc::new(animation)
}

/// All frames of an animation.
pub fn whole(animation: u32, framerate: f32) -> AnimRange {
    AnimRange {
        animation,
        low_frame: 0,
        high_frame: -1,
        framerate,
    }
}

/// A motion of whole animations without velocities.
pub fn motion(anims: &[(u32, f32)]) -> MotionData {
    MotionData {
        anims: anims.iter().map(|a| whole(a.0, a.1)).collect(),
        ..MotionData::default()
    }
}

/// A motion of one animation, with bits and velocities.
pub fn moving(anim: (u32, f32), bits: u8, velocity: Vec3, omega: Vec3) -> MotionData {
    MotionData {
        bits: MotionBits::from_bits_retain(bits),
        velocity,
        omega,
        ..motion(&[anim])
    }
}

/// Cycles by (style, substate), modifiers by key, links by (key, target).
#[derive(Default)]
pub struct TableParts {
    pub cycles: Vec<(u32, u32, MotionData)>,
    pub modifiers: Vec<(u32, MotionData)>,
    pub links: Vec<(u32, Vec<(u32, MotionData)>)>,
}

/// A motion table whose only default is Ready in non-combat.
pub fn table(parts: TableParts) -> Arc<MotionTable> {
    let mut table = MotionTable::new(TABLE, NON_COMBAT);
    table.style_defaults = std::iter::once((NON_COMBAT, READY)).collect();
    let cycle = |(style, substate, data)| (motion_key(style, substate), data);
    table.cycles = parts.cycles.into_iter().map(cycle).collect();
    table.modifiers = parts.modifiers.into_iter().collect();
    let link = |(key, to): (u32, Vec<_>)| (key, to.into_iter().collect());
    table.links = parts.links.into_iter().map(link).collect();
    Arc::new(table)
}

/// An object that consists of its animation.
#[derive(Debug, Clone)]
pub struct Player {
    pub shelf: Shelf,
    pub profile: Profile,
    pub sequence: Sequence,
    pub manager: MotionTableManager,
    pub hooks: AnimHookQueue,
}

/// What one step did.
#[derive(Debug, Default)]
pub struct Outcome {
    pub offset: Frame,
    /// Numbers of the hooks executed; 4 is AnimationDone.
    pub hooks: Vec<u32>,
    pub done: Vec<MotionNotice>,
}

impl Player {
    /// An object without a motion table.
    pub fn new(animations: Vec<Arc<Animation>>, profile: Profile) -> Self {
        Self {
            shelf: Shelf {
                animations,
                ..Shelf::default()
            },
            profile,
            sequence: Sequence::new(),
            manager: MotionTableManager::default(),
            hooks: AnimHookQueue::new(),
        }
    }

    /// An object in the default state of its motion table.
    pub fn with_table(
        animations: Vec<Arc<Animation>>,
        table: Arc<MotionTable>,
        profile: Profile,
    ) -> Self {
        let mut player = Self::new(animations, profile);
        let id = table.id;
        player.shelf.tables.push(table);
        let Self {
            shelf,
            profile,
            sequence,
            manager,
            ..
        } = &mut player;
        *manager = MotionTableManager::new(id, shelf, profile);
        manager.initialize_state(sequence, shelf, profile);
        player
    }

    pub fn append(&mut self, range: AnimRange) {
        self.sequence
            .append_animation(&range, &mut self.shelf, &self.profile);
    }

    pub fn perform(&mut self, request: MotionRequest) -> Result<(), MotionTableError> {
        let Self {
            shelf,
            profile,
            sequence,
            manager,
            ..
        } = self;
        manager.perform(request, sequence, shelf, profile)
    }

    pub fn start(&mut self, motion: u32, speed: f32) -> Result<(), MotionTableError> {
        self.perform(MotionRequest::Do { motion, speed })
    }

    pub fn stop(&mut self, motion: u32) -> Result<(), MotionTableError> {
        self.perform(MotionRequest::Stop { motion })
    }

    /// One update; hooks stay queued.
    pub fn update(&mut self, t: f64) -> Result<Frame, AnimationError> {
        let mut offset = Frame::IDENTITY;
        self.sequence
            .update(t, Some(&mut offset), &mut self.hooks, &self.profile)?;
        Ok(offset)
    }

    /// One quantum: update, hooks, completed motions.
    pub fn step(&mut self, t: f64) -> Outcome {
        let mut outcome = Outcome {
            offset: self.update(t).expect("sane input"),
            ..Outcome::default()
        };
        for hook in std::mem::take(&mut self.hooks) {
            outcome.hooks.push(number(&hook));
            if hook == HookAction::AnimationDone {
                let mut run = self.manager.animation_done(true);
                outcome.done.extend(std::iter::from_fn(|| {
                    self.manager.next_completion(&mut run)
                }));
            }
        }
        let mut run = self.manager.check_for_completed_motions();
        outcome.done.extend(std::iter::from_fn(|| {
            self.manager.next_completion(&mut run)
        }));
        outcome
    }

    /// Animations in the list.
    pub fn list(&self) -> Vec<u32> {
        self.sequence.nodes().map(|n| n.animation_id()).collect()
    }

    /// Rates in the list.
    pub fn rates(&self) -> Vec<f32> {
        self.sequence.nodes().map(|n| n.rate).collect()
    }

    /// Motions that wait, with their animations.
    pub fn pending(&self) -> Vec<(u32, u32)> {
        self.manager
            .pending()
            .map(|p| (p.motion, p.animations))
            .collect()
    }

    /// Modifiers, newest first.
    pub fn modifiers(&self) -> Vec<u32> {
        let modifiers = &self.manager.state.modifiers;
        modifiers.iter().map(|m| m.motion).collect()
    }
}

/// Number of a queued hook.
pub fn number(hook: &HookAction) -> u32 {
    match hook {
        HookAction::Sound { wave } => *wave,
        other => other.kind(),
    }
}
