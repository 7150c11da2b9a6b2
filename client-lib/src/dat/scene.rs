//! Scene: scenery that a landblock scatters, 0x12...... Source: `spec/11-dat-files.md, 9.10`, `spec/02-terrain.md, 3.5, 15`.

use serde::Serialize;

use super::frame::StoredFrame;
use super::kind::RecordKind;
use super::reader::{Read, Reader};
use super::record::Record;
use super::writer::Writer;

/// Scenery objects of one scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scene {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Objects.
    pub objects: Vec<SceneObject>,
}

/// One kind of scenery object and how it is scattered.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SceneObject {
    /// Shape or setup.
    #[serde(serialize_with = "super::json::hex")]
    pub model: u32,
    /// Place relative to the scattered point.
    pub frame: StoredFrame,
    /// Chance, 0 to 1.
    pub frequency: f32,
    /// Displacement along x, metres.
    pub displace_x: f32,
    /// Displacement along y, metres.
    pub displace_y: f32,
    /// Least scale.
    pub min_scale: f32,
    /// Greatest scale.
    pub max_scale: f32,
    /// Greatest rotation, degrees.
    pub max_rotation: f32,
    /// Least z of the ground's normal.
    pub min_slope: f32,
    /// Greatest z of the ground's normal.
    pub max_slope: f32,
    /// Not 0: aligned to the ground.
    pub align: i32,
    /// Not 0: oriented as the frame says.
    pub orient: i32,
    /// Not 0: a server object, not scenery.
    pub weenie: u32,
}

impl Record for Scene {
    const KIND: RecordKind = RecordKind::Scene;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let id = r.own_id()?;
        let n = r.count_u32("scene objects", 76)?;
        Ok(Self {
            id,
            objects: r.many(n, parse_object)?,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.count_u32("scene objects", self.objects.len());
        for o in &self.objects {
            w.u32(o.model);
            w.frame(&o.frame);
            for v in [
                o.frequency,
                o.displace_x,
                o.displace_y,
                o.min_scale,
                o.max_scale,
                o.max_rotation,
                o.min_slope,
                o.max_slope,
            ] {
                w.f32(v);
            }
            w.i32(o.align);
            w.i32(o.orient);
            w.u32(o.weenie);
        }
    }

    fn id(&self) -> u32 {
        self.id
    }
}

fn parse_object(r: &mut Reader<'_>) -> Read<SceneObject> {
    Ok(SceneObject {
        model: r.u32()?,
        frame: r.frame()?,
        frequency: r.f32()?,
        displace_x: r.f32()?,
        displace_y: r.f32()?,
        min_scale: r.f32()?,
        max_scale: r.f32()?,
        max_rotation: r.f32()?,
        min_slope: r.f32()?,
        max_slope: r.f32()?,
        align: r.i32()?,
        orient: r.i32()?,
        weenie: r.u32()?,
    })
}
