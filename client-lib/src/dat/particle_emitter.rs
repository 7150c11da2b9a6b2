//! Particle emitter info, 0x32......; cosmetic. Source: `spec/11-dat-files.md, 9.10`.

use serde::Serialize;

use super::kind::RecordKind;
use super::reader::{Read, Reader};
use super::record::Record;
use super::writer::Writer;
use crate::math::Vec3;

/// A direction and the range of its length.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct VectorRange {
    /// Direction.
    pub direction: Vec3,
    /// Least length.
    pub min: f32,
    /// Greatest length.
    pub max: f32,
}

/// How particles start, move and end.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParticleEmitterInfo {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Not known.
    pub unknown: u32,
    /// How emission is counted.
    pub emitter_kind: i32,
    /// How particles move.
    pub particle_kind: i32,
    /// Shape of software rendering.
    #[serde(serialize_with = "super::json::hex")]
    pub shape: u32,
    /// Shape of hardware rendering.
    #[serde(serialize_with = "super::json::hex")]
    pub hardware_shape: u32,
    /// Seconds or metres per particle.
    pub birth_rate: f64,
    /// Most particles at a time.
    pub max_particles: i32,
    /// Particles at the start.
    pub initial_particles: i32,
    /// Particles in all, 0 unlimited.
    pub total_particles: i32,
    /// Seconds, 0 unlimited.
    pub total_seconds: f64,
    /// Seconds.
    pub lifespan: f64,
    /// Seconds.
    pub lifespan_variation: f64,
    /// Offset, A, B and C of the particle's motion.
    pub vectors: [VectorRange; 4],
    /// Scale at the start, at the end, and its variation.
    pub scale: [f32; 3],
    /// Transparency at the start, at the end, and its variation.
    pub transparency: [f32; 3],
    /// Not 0: particles move with the parent.
    pub parent_local: i32,
}

impl Record for ParticleEmitterInfo {
    const KIND: RecordKind = RecordKind::ParticleEmitter;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        Ok(Self {
            id: r.own_id()?,
            unknown: r.u32()?,
            emitter_kind: r.i32()?,
            particle_kind: r.i32()?,
            shape: r.u32()?,
            hardware_shape: r.u32()?,
            birth_rate: r.f64()?,
            max_particles: r.i32()?,
            initial_particles: r.i32()?,
            total_particles: r.i32()?,
            total_seconds: r.f64()?,
            lifespan: r.f64()?,
            lifespan_variation: r.f64()?,
            vectors: [vector(r)?, vector(r)?, vector(r)?, vector(r)?],
            scale: [r.f32()?, r.f32()?, r.f32()?],
            transparency: [r.f32()?, r.f32()?, r.f32()?],
            parent_local: r.i32()?,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.u32(self.unknown);
        w.i32(self.emitter_kind);
        w.i32(self.particle_kind);
        w.u32(self.shape);
        w.u32(self.hardware_shape);
        w.f64(self.birth_rate);
        w.i32(self.max_particles);
        w.i32(self.initial_particles);
        w.i32(self.total_particles);
        w.f64(self.total_seconds);
        w.f64(self.lifespan);
        w.f64(self.lifespan_variation);
        for v in &self.vectors {
            w.vec3(v.direction);
            w.f32(v.min);
            w.f32(v.max);
        }
        for v in self.scale.into_iter().chain(self.transparency) {
            w.f32(v);
        }
        w.i32(self.parent_local);
    }

    fn id(&self) -> u32 {
        self.id
    }
}

fn vector(r: &mut Reader<'_>) -> Read<VectorRange> {
    Ok(VectorRange {
        direction: r.vec3("particle vector")?,
        min: r.f32()?,
        max: r.f32()?,
    })
}
