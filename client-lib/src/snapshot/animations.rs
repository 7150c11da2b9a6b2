//! Forms of part arrays: sequence, motion table, parts, hooks. Shapes, setups, animations and motion tables are named by their ids.

use std::sync::Arc;

use super::form::{Stored, stored};
use super::{Restorer, SnapshotError, inconsistent};
use crate::animation::{
    AnimSequenceNode, AnimationSource, MotionEntry, MotionState, MotionTableManager, PartArray,
    PendingMotion, PhysicsPart, Placement, Sequence, TimedHook, TimedHookKind, simple_setup,
};
use crate::dat::{
    Animation, AttackCone, CreateParticle, HookAction, MotionTable, Ramp, Setup, StoredFrame,
};
use crate::math::{Position, Vec3};
use crate::physics::collision::GfxShape;

#[cfg(test)]
use super::form::{Forms, define};

/// A record of the dat files, named by its id.
macro_rules! record {
    ($($type:ty = $kind:literal by $find:ident;)*) => {$(
        impl Stored for Arc<$type> {
            type Form = u32;

            fn store(&self) -> u32 {
                self.id
            }

            fn restore(id: u32, by: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
                by.resources.$find(id).ok_or(SnapshotError::MissingRecord { kind: $kind, id })
            }

            #[cfg(test)]
            fn describe(_: &mut Forms) -> String {
                concat!($kind, " as u32").into()
            }
        }
    )*};
}

record! {
    GfxShape = "shape" by shape;
    Animation = "animation" by animation;
}

impl Stored for Arc<MotionTable> {
    type Form = u32;

    fn store(&self) -> u32 {
        self.id
    }

    /// Id 0: the empty table that a profile puts in the place of a missing one.
    fn restore(id: u32, by: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
        if id == 0 {
            return Ok(Self::new(MotionTable::new(0, 0)));
        }
        by.resources
            .motion_table(id)
            .ok_or(SnapshotError::MissingRecord {
                kind: "motion table",
                id,
            })
    }

    #[cfg(test)]
    fn describe(_: &mut Forms) -> String {
        "motion table as u32".into()
    }
}

/// Which setup.
#[derive(Debug, Clone, Copy, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) enum SetupForm {
    /// Of the dat files.
    Record(u32),
    /// That of an object that is one shape.
    Shape(u32),
    /// Of an object without setup: all that it has is a sorting sphere.
    Empty { center: [f32; 3], radius: f32 },
}

impl Stored for Arc<Setup> {
    type Form = SetupForm;

    fn store(&self) -> SetupForm {
        match (self.id, self.parts.as_slice()) {
            (0, [shape]) => SetupForm::Shape(*shape),
            (0, _) => SetupForm::Empty {
                center: self.sorting_sphere.center.store(),
                radius: self.sorting_sphere.radius,
            },
            (id, _) => SetupForm::Record(id),
        }
    }

    fn restore(form: SetupForm, by: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
        Ok(match form {
            SetupForm::Record(id) => by
                .resources
                .setup(id)
                .ok_or(SnapshotError::MissingRecord { kind: "setup", id })?,
            SetupForm::Shape(id) => Self::new(simple_setup(&*Arc::<GfxShape>::restore(id, by)?)),
            SetupForm::Empty { center, radius } => {
                let mut setup = Setup::empty(0);
                setup.sorting_sphere.center = Stored::restore(center, by)?;
                setup.sorting_sphere.radius = radius;
                Self::new(setup)
            }
        })
    }

    #[cfg(test)]
    fn describe(forms: &mut Forms) -> String {
        define(forms, "SetupForm", |_| {
            "\n  | Record(u32)\n  | Shape(u32)\n  | Empty center: [f32; 3] radius: f32".into()
        })
    }
}

stored!(
    struct PartForm of PhysicsPart {
        shape: Arc<GfxShape>,
        scale: Vec3,
        position: Position,
        no_draw: bool,
        translucency: f32,
    }
);
stored!(
    struct NodeForm of AnimSequenceNode { animation: Option<Arc<Animation>>, rate: f32, low: i32, high: i32 }
);
stored!(
    struct PlacementForm of Placement { entry: Option<usize>, id: i32 }
);

#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SequenceForm {
    nodes: Vec<NodeForm>,
    current: Option<Box<u64>>,
    frame_number: f64,
    velocity: [f32; 3],
    omega: [f32; 3],
    placement: PlacementForm,
}

impl Stored for Sequence {
    type Form = SequenceForm;

    fn store(&self) -> SequenceForm {
        let Self {
            nodes,
            current,
            frame_number,
            velocity,
            omega,
            placement,
        } = self;
        SequenceForm {
            nodes: nodes.store(),
            current: current.store(),
            frame_number: *frame_number,
            velocity: velocity.store(),
            omega: omega.store(),
            placement: placement.store(),
        }
    }

    fn restore(form: SequenceForm, by: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
        let sequence = Self {
            nodes: Stored::restore(form.nodes, by)?,
            current: Stored::restore(form.current, by)?,
            frame_number: form.frame_number,
            velocity: Stored::restore(form.velocity, by)?,
            omega: Stored::restore(form.omega, by)?,
            placement: Stored::restore(form.placement, by)?,
        };
        let (current, nodes) = (sequence.current, sequence.nodes.len());
        if current.is_some_and(|current| current >= nodes) {
            return Err(inconsistent(format!(
                "a sequence of {nodes} nodes plays another one"
            )));
        }
        Ok(sequence)
    }

    #[cfg(test)]
    fn describe(forms: &mut Forms) -> String {
        define(forms, "SequenceForm", |forms| {
            format!(
                "\n  nodes: {}\n  current: {}\n  frame_number: f64\n  velocity: {}\n  omega: {}\n  placement: {}",
                std::collections::VecDeque::<AnimSequenceNode>::describe(forms),
                Option::<usize>::describe(forms),
                Vec3::describe(forms),
                Vec3::describe(forms),
                Placement::describe(forms),
            )
        })
    }
}

stored!(
    struct MotionEntryForm of MotionEntry { motion: u32, speed: f32 }
);
stored!(
    struct MotionStateForm of MotionState {
        style: u32,
        substate: u32,
        substate_speed: f32,
        modifiers: std::collections::VecDeque<MotionEntry>,
        actions: std::collections::VecDeque<MotionEntry>,
    }
);
stored!(
    struct QueuedMotionForm of PendingMotion { motion: u32, animations: u32, serial: u64 }
);
stored!(
    struct MotionTableForm of MotionTableManager {
        table: Option<Arc<MotionTable>>,
        state: MotionState,
        animation_counter: u32,
        pending: std::collections::VecDeque<PendingMotion>,
        next_serial: u64,
    }
);

#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PartArrayForm {
    sequence: SequenceForm,
    motion_table: Option<Box<MotionTableForm>>,
    parts: Vec<Option<Box<PartForm>>>,
    hooks: Vec<HookForm>,
    setup: Option<Box<SetupForm>>,
    scale: [f32; 3],
}

impl Stored for PartArray {
    type Form = PartArrayForm;

    fn store(&self) -> PartArrayForm {
        let Self {
            sequence,
            motion_table,
            parts,
            hooks,
            setup,
            scale,
            // Of the setup.
            obstacle_reach: _,
            // Of the parts.
            has_bsp_part: _,
            // The parts are stored where they will be: see `EntitiesForm::settle`.
            pending: _,
            // Found out again.
            stands_still: _,
        } = self;
        PartArrayForm {
            sequence: sequence.store(),
            motion_table: motion_table.store(),
            parts: parts.store(),
            hooks: hooks.store(),
            setup: setup.store(),
            scale: scale.store(),
        }
    }

    fn restore(form: PartArrayForm, by: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
        let PartArrayForm {
            sequence,
            motion_table,
            parts,
            hooks,
            setup,
            scale,
        } = form;
        let mut array = Self::empty();
        if let Some(setup) = Option::<Arc<Setup>>::restore(setup, by)? {
            array.take_setup(setup);
        }
        array.sequence = Stored::restore(sequence, by)?;
        array.motion_table = Stored::restore(motion_table, by)?;
        array.parts = Stored::restore(parts, by)?;
        array.hooks = Stored::restore(hooks, by)?;
        array.scale = Stored::restore(scale, by)?;
        array.has_bsp_part = array.has_physics_bsp();
        Ok(array)
    }

    #[cfg(test)]
    fn describe(forms: &mut Forms) -> String {
        define(forms, "PartArrayForm", |forms| {
            format!(
                "\n  sequence: {}\n  motion_table: {}\n  parts: {}\n  hooks: {}\n  setup: {}\n  scale: {}",
                Sequence::describe(forms),
                Option::<MotionTableManager>::describe(forms),
                Vec::<Option<PhysicsPart>>::describe(forms),
                Vec::<HookAction>::describe(forms),
                Option::<Arc<Setup>>::describe(forms),
                Vec3::describe(forms),
            )
        })
    }
}

stored!(
    enum TimedHookKindForm of TimedHookKind {
        Scale,
        Translucency,
        PartTranslucency(part: u32),
        Luminosity,
        Diffusion,
        PartLuminosity(part: u32),
        PartDiffusion(part: u32),
        CallScript(script: u32),
    }
);
stored!(
    struct TimedHookForm of TimedHook { kind: TimedHookKind, created: f64, duration: f64, start: f32, end: f32 }
);
stored!(
    struct RampForm of Ramp { start: f32, end: f32, time: f32 }
);
stored!(
    struct AttackConeForm of AttackCone { part: u32, left: [f32; 2], right: [f32; 2], radius: f32, height: f32 }
);
stored!(
    struct CreateParticleForm of CreateParticle {
        emitter_info: u32,
        part: u32,
        offset: StoredFrame,
        emitter_id: u32,
    }
);
stored!(
    enum HookForm of HookAction {
        NoOp,
        Sound { wave: u32 },
        SoundTable { sound: u32 },
        Attack(cone: AttackCone),
        AnimationDone,
        ReplaceObject { part: u16, shape: u32 },
        Ethereal { value: i32 },
        TransparentPart { part: u32, ramp: Ramp },
        Luminous(ramp: Ramp),
        LuminousPart { part: u32, ramp: Ramp },
        Diffuse(ramp: Ramp),
        DiffusePart { part: u32, ramp: Ramp },
        Scale { end: f32, time: f32 },
        CreateParticle(particle: CreateParticle),
        DestroyParticle { emitter_id: u32 },
        StopParticle { emitter_id: u32 },
        NoDraw { value: u32 },
        DefaultScript,
        DefaultScriptPart { part: u32 },
        CallScript { script: u32, pause: f32 },
        Transparent(ramp: Ramp),
        SoundTweaked { wave: u32, priority: f32, probability: f32, volume: f32 },
        SetOmega { axis: Vec3 },
        TextureVelocity { u: f32, v: f32 },
        TextureVelocityPart { part: u32, u: f32, v: f32 },
        SetLight { on: i32 },
        CreateBlockingParticle(particle: CreateParticle),
    }
);
