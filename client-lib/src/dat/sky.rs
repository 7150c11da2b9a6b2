//! Sky of a region: sun, ambient light, fog and sky objects by time of day. Source: `spec/11-dat-files.md, 9.11`.

use serde::Serialize;

use super::error::Problem;
use super::reader::{Read, Reader};
use super::writer::Writer;

/// Sky of a region.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sky {
    /// Seconds between two steps of the sky.
    pub tick: f64,
    /// Seconds between two steps of the light.
    pub light_tick: f64,
    /// Kinds of days, of which one is drawn.
    pub day_groups: Vec<DayGroup>,
}

/// A kind of day.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DayGroup {
    /// Chance, relative to the others.
    pub chance: f32,
    /// Name.
    pub name: String,
    /// Sun, moons, clouds.
    pub objects: Vec<SkyObject>,
    /// Light and fog from a time of day on.
    pub times: Vec<SkyTime>,
}

/// Something in the sky.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[allow(missing_docs, reason = "named after the fields of the record")]
pub struct SkyObject {
    /// Fraction of the day.
    pub begin: f32,
    /// Fraction of the day.
    pub end: f32,
    /// Degrees.
    pub begin_angle: f32,
    /// Degrees.
    pub end_angle: f32,
    pub u_velocity: f32,
    pub v_velocity: f32,
    /// Shape, 0x01......
    #[serde(serialize_with = "super::json::hex")]
    pub shape: u32,
    /// Physics script, 0x33......
    #[serde(serialize_with = "super::json::hex")]
    pub script: u32,
    pub properties: u32,
}

/// Light and fog from a time of day on. Colours are 0xAARRGGBB.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs, reason = "named after the fields of the record")]
pub struct SkyTime {
    /// Fraction of the day.
    pub begin: f32,
    pub sun_brightness: f32,
    /// Degrees.
    pub sun_heading: f32,
    /// Degrees.
    pub sun_pitch: f32,
    pub sun_color: u32,
    pub ambient_brightness: f32,
    pub ambient_color: u32,
    /// Metres.
    pub fog_min: f32,
    /// Metres.
    pub fog_max: f32,
    pub fog_color: u32,
    pub fog_kind: u32,
    /// What changes about the sky objects.
    pub replacements: Vec<SkyReplacement>,
}

/// Change of a sky object.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[allow(missing_docs, reason = "named after the fields of the record")]
pub struct SkyReplacement {
    /// Index among the sky objects of the group.
    pub object: u32,
    /// Shape, 0x01......
    #[serde(serialize_with = "super::json::hex")]
    pub shape: u32,
    pub rotate: f32,
    pub transparent: f32,
    pub luminosity: f32,
    pub max_brightness: f32,
}

impl Sky {
    pub(super) fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let (tick, light_tick) = (r.f64()?, r.f64()?);
        let n = r.count_u32("day groups", 14)?;
        Ok(Self {
            tick,
            light_tick,
            day_groups: r.many(n, DayGroup::parse)?,
        })
    }

    pub(super) fn write(&self, w: &mut Writer) {
        w.f64(self.tick);
        w.f64(self.light_tick);
        w.count_u32("day groups", self.day_groups.len());
        for g in &self.day_groups {
            g.write(w);
        }
    }
}

impl DayGroup {
    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let (chance, name) = (r.f32()?, r.pstring()?);
        let n = r.count_u32("sky objects", 36)?;
        let objects = r.many(n, SkyObject::parse)?;
        let n = r.count_u32("sky times", 48)?;
        let times = r.many(n, |r| SkyTime::parse(r, objects.len()))?;
        Ok(Self {
            chance,
            name,
            objects,
            times,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.f32(self.chance);
        w.pstring(&self.name);
        w.count_u32("sky objects", self.objects.len());
        for o in &self.objects {
            for v in [
                o.begin,
                o.end,
                o.begin_angle,
                o.end_angle,
                o.u_velocity,
                o.v_velocity,
            ] {
                w.f32(v);
            }
            w.u32(o.shape);
            w.u32(o.script);
            w.u32(o.properties);
        }
        w.count_u32("sky times", self.times.len());
        for t in &self.times {
            t.write(w);
        }
    }
}

impl SkyObject {
    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        Ok(Self {
            begin: r.f32()?,
            end: r.f32()?,
            begin_angle: r.f32()?,
            end_angle: r.f32()?,
            u_velocity: r.f32()?,
            v_velocity: r.f32()?,
            shape: r.u32()?,
            script: r.u32()?,
            properties: r.u32()?,
        })
    }
}

impl SkyTime {
    fn parse(r: &mut Reader<'_>, objects: usize) -> Read<Self> {
        Ok(Self {
            begin: r.f32()?,
            sun_brightness: r.f32()?,
            sun_heading: r.f32()?,
            sun_pitch: r.f32()?,
            sun_color: r.u32()?,
            ambient_brightness: r.f32()?,
            ambient_color: r.u32()?,
            fog_min: r.f32()?,
            fog_max: r.f32()?,
            fog_color: r.u32()?,
            fog_kind: r.u32()?,
            replacements: {
                let n = r.count_u32("sky replacements", 24)?;
                r.many(n, |r| parse_replacement(r, objects))?
            },
        })
    }

    fn write(&self, w: &mut Writer) {
        for v in [
            self.begin,
            self.sun_brightness,
            self.sun_heading,
            self.sun_pitch,
        ] {
            w.f32(v);
        }
        w.u32(self.sun_color);
        w.f32(self.ambient_brightness);
        w.u32(self.ambient_color);
        w.f32(self.fog_min);
        w.f32(self.fog_max);
        w.u32(self.fog_color);
        w.u32(self.fog_kind);
        w.count_u32("sky replacements", self.replacements.len());
        for c in &self.replacements {
            w.u32(c.object);
            w.u32(c.shape);
            for v in [c.rotate, c.transparent, c.luminosity, c.max_brightness] {
                w.f32(v);
            }
        }
    }
}

fn parse_replacement(r: &mut Reader<'_>, objects: usize) -> Read<SkyReplacement> {
    let object = r.u32()?;
    if object as usize >= objects {
        return Err(r.error_at(
            r.offset() - 4,
            Problem::Index {
                what: "sky object",
                found: i64::from(object),
                limit: objects,
            },
        ));
    }
    Ok(SkyReplacement {
        object,
        shape: r.u32()?,
        rotate: r.f32()?,
        transparent: r.f32()?,
        luminosity: r.f32()?,
        max_brightness: r.f32()?,
    })
}
