//! Animation hooks: events stored in animation frames and physics scripts. Source: `spec/11-dat-files.md, 7`.

use serde::Serialize;

use super::error::Problem;
use super::frame::StoredFrame;
use super::reader::{Read, Reader};
use super::writer::Writer;
use crate::math::Vec3;

/// When a hook fires; the raw number, of which only the four constants occur.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct HookDirection(pub i32);

impl HookDirection {
    /// Playing in either direction.
    pub const BOTH: Self = Self(0);
    /// Playing forward.
    pub const FORWARD: Self = Self(1);
    /// Playing backward.
    pub const BACKWARD: Self = Self(-1);
    /// Never.
    pub const UNKNOWN: Self = Self(-2);
}

/// A hook: when it fires and what it does.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AnimationHook {
    /// When it fires.
    pub direction: HookDirection,
    /// What it does.
    pub action: HookAction,
}

/// A change of a value over time; seconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ramp {
    /// First value.
    pub start: f32,
    /// Last value.
    pub end: f32,
    /// Duration, seconds.
    pub time: f32,
}

/// Area of an attack, in the space of a part.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AttackCone {
    /// Part number.
    pub part: u32,
    /// Left edge, x and y.
    pub left: [f32; 2],
    /// Right edge, x and y.
    pub right: [f32; 2],
    /// Radius, metres.
    pub radius: f32,
    /// Height, metres.
    pub height: f32,
}

/// Start of a particle emitter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CreateParticle {
    /// Emitter info, 0x32......
    pub emitter_info: u32,
    /// Part number, 0xFFFFFFFF the object.
    pub part: u32,
    /// Place in the part's space.
    pub offset: StoredFrame,
    /// Number by which the emitter can be stopped, 0 none.
    pub emitter_id: u32,
}

/// What a hook does, by type number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum HookAction {
    /// 0: nothing. Consumes its 8 bytes (D-11).
    NoOp,
    /// 1: plays a wave.
    Sound {
        /// Wave, 0x0A......
        wave: u32,
    },
    /// 2: plays a sound of the object's sound table.
    SoundTable {
        /// Sound slot.
        sound: u32,
    },
    /// 3: an attack lands.
    Attack(AttackCone),
    /// 4: the animation counts as done.
    AnimationDone,
    /// 5: replaces the shape of a part.
    ReplaceObject {
        /// Part number.
        part: u16,
        /// Shape, 0x01......
        shape: u32,
    },
    /// 6: sets or clears ethereal.
    Ethereal {
        /// Not 0: set.
        value: i32,
    },
    /// 7: fades a part.
    TransparentPart {
        /// Part number.
        part: u32,
        /// Translucency over time.
        ramp: Ramp,
    },
    /// 8: luminosity of the object.
    Luminous(Ramp),
    /// 9: luminosity of a part.
    LuminousPart {
        /// Part number.
        part: u32,
        /// Luminosity over time.
        ramp: Ramp,
    },
    /// 10: diffuse factor of the object.
    Diffuse(Ramp),
    /// 11: diffuse factor of a part.
    DiffusePart {
        /// Part number.
        part: u32,
        /// Factor over time.
        ramp: Ramp,
    },
    /// 12: scales the object.
    Scale {
        /// Scale at the end.
        end: f32,
        /// Duration, seconds.
        time: f32,
    },
    /// 13: starts a particle emitter.
    CreateParticle(CreateParticle),
    /// 14: removes a particle emitter.
    DestroyParticle {
        /// Its number.
        emitter_id: u32,
    },
    /// 15: stops a particle emitter.
    StopParticle {
        /// Its number.
        emitter_id: u32,
    },
    /// 16: hides or shows the object.
    NoDraw {
        /// Not 0: hidden.
        value: u32,
    },
    /// 17: runs the default script.
    DefaultScript,
    /// 18: runs the default script of a part.
    DefaultScriptPart {
        /// Part number.
        part: u32,
    },
    /// 19: calls a physics script after a pause.
    CallScript {
        /// Script, 0x33......
        script: u32,
        /// Seconds.
        pause: f32,
    },
    /// 20: fades the object.
    Transparent(Ramp),
    /// 21: plays a wave with its own settings (order of the numbers: D-13).
    SoundTweaked {
        /// Wave, 0x0A......
        wave: u32,
        /// Priority.
        priority: f32,
        /// Probability, 0 to 1.
        probability: f32,
        /// Volume.
        volume: f32,
    },
    /// 22: sets the turn rate.
    SetOmega {
        /// Axis times radians per second.
        axis: Vec3,
    },
    /// 23: moves the texture.
    TextureVelocity {
        /// Speed in u per second.
        u: f32,
        /// Speed in v per second.
        v: f32,
    },
    /// 24: moves the texture of a part.
    TextureVelocityPart {
        /// Part number.
        part: u32,
        /// Speed in u per second.
        u: f32,
        /// Speed in v per second.
        v: f32,
    },
    /// 25: switches the lights.
    SetLight {
        /// Not 0: on.
        on: i32,
    },
    /// 26: starts a particle emitter that exists once (D-14).
    CreateBlockingParticle(CreateParticle),
}

impl HookAction {
    /// Type number on disk.
    #[must_use]
    pub fn kind(&self) -> u32 {
        match self {
            Self::NoOp => 0,
            Self::Sound { .. } => 1,
            Self::SoundTable { .. } => 2,
            Self::Attack(_) => 3,
            Self::AnimationDone => 4,
            Self::ReplaceObject { .. } => 5,
            Self::Ethereal { .. } => 6,
            Self::TransparentPart { .. } => 7,
            Self::Luminous(_) => 8,
            Self::LuminousPart { .. } => 9,
            Self::Diffuse(_) => 10,
            Self::DiffusePart { .. } => 11,
            Self::Scale { .. } => 12,
            Self::CreateParticle(_) => 13,
            Self::DestroyParticle { .. } => 14,
            Self::StopParticle { .. } => 15,
            Self::NoDraw { .. } => 16,
            Self::DefaultScript => 17,
            Self::DefaultScriptPart { .. } => 18,
            Self::CallScript { .. } => 19,
            Self::Transparent(_) => 20,
            Self::SoundTweaked { .. } => 21,
            Self::SetOmega { .. } => 22,
            Self::TextureVelocity { .. } => 23,
            Self::TextureVelocityPart { .. } => 24,
            Self::SetLight { .. } => 25,
            Self::CreateBlockingParticle(_) => 26,
        }
    }
}

const SHAPE_BASE: u32 = 0x0100_0000;

impl AnimationHook {
    /// Least bytes of a hook.
    pub const LEAST: usize = 8;

    /// Reads a hook.
    ///
    /// # Errors
    /// Unknown type (its length is unknown, D-16), and those of the reader.
    pub fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let kind = r.u32()?;
        let direction = HookDirection(r.i32()?);
        Ok(Self {
            direction,
            action: parse_action(r, kind)?,
        })
    }

    /// Writes the hook.
    pub fn write(&self, w: &mut Writer) {
        w.u32(self.action.kind());
        w.i32(self.direction.0);
        write_action(w, &self.action);
    }
}

fn parse_action(r: &mut Reader<'_>, kind: u32) -> Read<HookAction> {
    Ok(match kind {
        0 => HookAction::NoOp,
        1 => HookAction::Sound { wave: r.u32()? },
        2 => HookAction::SoundTable { sound: r.u32()? },
        3 => HookAction::Attack(AttackCone {
            part: r.u32()?,
            left: [r.f32()?, r.f32()?],
            right: [r.f32()?, r.f32()?],
            radius: r.f32()?,
            height: r.f32()?,
        }),
        4 => HookAction::AnimationDone,
        5 => HookAction::ReplaceObject {
            part: r.u16()?,
            shape: r.packed_did(SHAPE_BASE)?,
        },
        6 => HookAction::Ethereal { value: r.i32()? },
        7 => HookAction::TransparentPart {
            part: r.u32()?,
            ramp: ramp(r)?,
        },
        8 => HookAction::Luminous(ramp(r)?),
        9 => HookAction::LuminousPart {
            part: r.u32()?,
            ramp: ramp(r)?,
        },
        10 => HookAction::Diffuse(ramp(r)?),
        11 => HookAction::DiffusePart {
            part: r.u32()?,
            ramp: ramp(r)?,
        },
        12 => HookAction::Scale {
            end: r.f32()?,
            time: r.f32()?,
        },
        13 => HookAction::CreateParticle(create_particle(r)?),
        14 => HookAction::DestroyParticle {
            emitter_id: r.u32()?,
        },
        15 => HookAction::StopParticle {
            emitter_id: r.u32()?,
        },
        16 => HookAction::NoDraw { value: r.u32()? },
        17 => HookAction::DefaultScript,
        18 => HookAction::DefaultScriptPart { part: r.u32()? },
        19 => HookAction::CallScript {
            script: r.u32()?,
            pause: r.f32()?,
        },
        20 => HookAction::Transparent(ramp(r)?),
        21 => HookAction::SoundTweaked {
            wave: r.u32()?,
            priority: r.f32()?,
            probability: r.f32()?,
            volume: r.f32()?,
        },
        22 => HookAction::SetOmega {
            axis: r.vec3("omega")?,
        },
        23 => HookAction::TextureVelocity {
            u: r.f32()?,
            v: r.f32()?,
        },
        24 => HookAction::TextureVelocityPart {
            part: r.u32()?,
            u: r.f32()?,
            v: r.f32()?,
        },
        25 => HookAction::SetLight { on: r.i32()? },
        26 => HookAction::CreateBlockingParticle(create_particle(r)?),
        found => {
            return Err(r.error_at(
                r.offset() - 8,
                Problem::Unknown {
                    what: "hook type",
                    found,
                },
            ));
        }
    })
}

fn ramp(r: &mut Reader<'_>) -> Read<Ramp> {
    Ok(Ramp {
        start: r.f32()?,
        end: r.f32()?,
        time: r.f32()?,
    })
}

fn create_particle(r: &mut Reader<'_>) -> Read<CreateParticle> {
    Ok(CreateParticle {
        emitter_info: r.u32()?,
        part: r.u32()?,
        offset: r.frame()?,
        emitter_id: r.u32()?,
    })
}

fn write_action(w: &mut Writer, action: &HookAction) {
    use HookAction as H;
    match action {
        H::NoOp | H::AnimationDone | H::DefaultScript => {}
        H::Sound { wave: v }
        | H::SoundTable { sound: v }
        | H::DefaultScriptPart { part: v }
        | H::NoDraw { value: v } => w.u32(*v),
        H::DestroyParticle { emitter_id } | H::StopParticle { emitter_id } => w.u32(*emitter_id),
        H::Attack(c) => {
            w.u32(c.part);
            for v in [
                c.left[0], c.left[1], c.right[0], c.right[1], c.radius, c.height,
            ] {
                w.f32(v);
            }
        }
        H::ReplaceObject { part, shape } => {
            w.u16(*part);
            w.packed_did(*shape, SHAPE_BASE);
        }
        H::Ethereal { value } => w.i32(*value),
        H::SetLight { on } => w.i32(*on),
        H::TransparentPart { part, ramp }
        | H::LuminousPart { part, ramp }
        | H::DiffusePart { part, ramp } => {
            w.u32(*part);
            write_ramp(w, ramp);
        }
        H::Luminous(ramp) | H::Diffuse(ramp) | H::Transparent(ramp) => write_ramp(w, ramp),
        H::Scale { end: a, time: b } | H::TextureVelocity { u: a, v: b } => {
            w.f32(*a);
            w.f32(*b);
        }
        H::CreateParticle(p) | H::CreateBlockingParticle(p) => {
            w.u32(p.emitter_info);
            w.u32(p.part);
            w.frame(&p.offset);
            w.u32(p.emitter_id);
        }
        H::CallScript { script, pause } => {
            w.u32(*script);
            w.f32(*pause);
        }
        H::SoundTweaked {
            wave,
            priority,
            probability,
            volume,
        } => {
            w.u32(*wave);
            for v in [priority, probability, volume] {
                w.f32(*v);
            }
        }
        H::SetOmega { axis } => w.vec3(*axis),
        H::TextureVelocityPart { part, u, v } => {
            w.u32(*part);
            w.f32(*u);
            w.f32(*v);
        }
    }
}

fn write_ramp(w: &mut Writer, ramp: &Ramp) {
    w.f32(ramp.start);
    w.f32(ramp.end);
    w.f32(ramp.time);
}
