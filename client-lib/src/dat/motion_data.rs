//! What is played for one motion, and the velocity and turn rate that go with it. Source: `spec/11-dat-files.md, 5.6`.

use bitflags::bitflags;
use serde::Serialize;

use super::reader::{Read, Reader};
use super::writer::Writer;
use crate::math::Vec3;

bitflags! {
    /// Which vectors are stored.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
    pub struct MotionDataFlags: u8 {
        /// Velocity follows.
        const VELOCITY = 1;
        /// Omega follows.
        const OMEGA = 2;
    }
}

bitflags! {
    /// Rules of a cycle.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
    pub struct MotionBits: u8 {
        /// Entering it clears all modifiers, and none can be added while it plays.
        const CLEARS_MODIFIERS = 1;
        /// It may be entered only from the default substate of the style.
        const FROM_DEFAULT_ONLY = 2;
    }
}

/// A range of an animation and its rate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AnimRange {
    /// Animation, 0x03......
    #[serde(serialize_with = "super::json::hex")]
    pub animation: u32,
    /// First frame.
    pub low_frame: i32,
    /// Last frame; negative: the last of the animation.
    pub high_frame: i32,
    /// Frames per second; negative: backwards, 0: held.
    pub framerate: f32,
}

/// Animations, velocity and turn rate of one motion.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct MotionData {
    /// Rules.
    pub bits: MotionBits,
    /// Which vectors are stored.
    pub flags: MotionDataFlags,
    /// Animations in order.
    pub anims: Vec<AnimRange>,
    /// Metres per second in the object's space; zero if not stored.
    pub velocity: Vec3,
    /// Axis times radians per second; zero if not stored.
    pub omega: Vec3,
}

impl MotionData {
    /// Least bytes, with the key in front.
    pub const LEAST: usize = 8;

    /// A motion that plays frames `low..=high` of an animation; `high` negative: to the end.
    #[must_use]
    pub fn playing(animation: u32, low_frame: i32, high_frame: i32, framerate: f32) -> Self {
        let range = AnimRange {
            animation,
            low_frame,
            high_frame,
            framerate,
        };
        Self {
            anims: vec![range],
            ..Self::default()
        }
    }

    /// The same with another animation after it.
    #[must_use]
    pub fn then(mut self, animation: u32, low_frame: i32, high_frame: i32, framerate: f32) -> Self {
        self.anims.push(AnimRange {
            animation,
            low_frame,
            high_frame,
            framerate,
        });
        self
    }

    /// The same with a velocity, metres per second in the object's space.
    #[must_use]
    pub fn with_velocity(mut self, velocity: Vec3) -> Self {
        self.flags |= MotionDataFlags::VELOCITY;
        self.velocity = velocity;
        self
    }

    /// The same with a turn rate, axis times radians per second.
    #[must_use]
    pub fn with_omega(mut self, omega: Vec3) -> Self {
        self.flags |= MotionDataFlags::OMEGA;
        self.omega = omega;
        self
    }

    /// The same with rules.
    #[must_use]
    pub fn with_bits(mut self, bits: MotionBits) -> Self {
        self.bits = bits;
        self
    }

    /// Reads one.
    ///
    /// # Errors
    /// Those of the reader.
    pub fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let n = r.u8()?;
        let bits = MotionBits::from_bits_retain(r.u8()?);
        let flags = MotionDataFlags::from_bits_retain(r.u8()?);
        r.align4()?;
        let n = r.fits("animations", u64::from(n), 16)?;
        let anims = r.many(n, |r| {
            Ok(AnimRange {
                animation: r.u32()?,
                low_frame: r.i32()?,
                high_frame: r.i32()?,
                framerate: r.finite("frame rate")?,
            })
        })?;
        let velocity = if flags.contains(MotionDataFlags::VELOCITY) {
            r.vec3("velocity")?
        } else {
            Vec3::ZERO
        };
        let omega = if flags.contains(MotionDataFlags::OMEGA) {
            r.vec3("omega")?
        } else {
            Vec3::ZERO
        };
        Ok(Self {
            bits,
            flags,
            anims,
            velocity,
            omega,
        })
    }

    /// Writes it.
    pub fn write(&self, w: &mut Writer) {
        w.count_u8("animations", self.anims.len());
        w.u8(self.bits.bits());
        w.u8(self.flags.bits());
        w.align4();
        for a in &self.anims {
            w.u32(a.animation);
            w.i32(a.low_frame);
            w.i32(a.high_frame);
            w.f32(a.framerate);
        }
        if self.flags.contains(MotionDataFlags::VELOCITY) {
            w.vec3(self.velocity);
        }
        if self.flags.contains(MotionDataFlags::OMEGA) {
            w.vec3(self.omega);
        }
    }
}
