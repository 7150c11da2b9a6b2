//! Setup: parts, collision shapes and sizes of a kind of object, 0x02...... Source: `spec/11-dat-files.md, 9.2`, `spec/07-animation.md, 3.1`.

use bitflags::bitflags;
use serde::Serialize;

use super::anim_frame::AnimFrame;
use super::cyl_sphere::CylSphere;
use super::frame::StoredFrame;
use super::keyed::{KeyedList, keyed};
use super::kind::RecordKind;
use super::reader::{Read, Reader};
use super::record::Record;
use super::writer::Writer;
use crate::math::{Sphere, Vec3};

bitflags! {
    /// Which parts are stored, and two marks.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
    pub struct SetupFlags: u32 {
        /// Parent parts follow.
        const PARENTS = 1;
        /// Default scales follow.
        const SCALES = 2;
        /// Free heading is allowed.
        const FREE_HEADING = 4;
        /// Some part has a physics tree.
        const PHYSICS_BSP = 8;
    }
}

/// A place on a part: where a child is held or the object would be gripped.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Location {
    /// Part number, -1 the object itself.
    pub part: i32,
    /// Place in the part's space.
    pub frame: StoredFrame,
}

/// A light of an object.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Light {
    /// Place in the object's space.
    pub frame: StoredFrame,
    /// 0xAARRGGBB.
    pub color: u32,
    /// Intensity.
    pub intensity: f32,
    /// Falloff, metres.
    pub falloff: f32,
    /// Cone angle.
    pub cone_angle: f32,
}

/// A setup.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Setup {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Flags.
    pub flags: SetupFlags,
    /// Shapes of the parts, 0x01......
    #[serde(serialize_with = "super::json::hex_list")]
    pub parts: Vec<u32>,
    /// Skeleton parent of each part, 0xFFFFFFFF none; empty if not stored. Not used when parts are placed.
    pub parents: Vec<u32>,
    /// Scale of each part; empty if not stored.
    pub scales: Vec<Vec3>,
    /// Where children are attached, by parent location.
    pub holding_locations: KeyedList<i32, Location>,
    /// Where the object would be gripped; not used by physics.
    pub connection_points: KeyedList<i32, Location>,
    /// Static poses, by placement id.
    pub placements: KeyedList<i32, AnimFrame>,
    /// Collision cylinders.
    pub cyl_spheres: Vec<CylSphere>,
    /// Collision spheres.
    pub spheres: Vec<Sphere>,
    /// Height, metres.
    pub height: f32,
    /// Radius, metres.
    pub radius: f32,
    /// Step-up height, metres.
    pub step_up_height: f32,
    /// Step-down height, metres.
    pub step_down_height: f32,
    /// Draw sorting, and cell membership of objects without spheres.
    pub sorting_sphere: Sphere,
    /// Mouse picking.
    pub selection_sphere: Sphere,
    /// Lights with their keys. A list: one reference reads the key as the kind of light, and two of a kind are legal.
    pub lights: Vec<(i32, Light)>,
    /// Default animation, 0x03......, 0 none.
    #[serde(serialize_with = "super::json::hex")]
    pub default_animation: u32,
    /// Default physics script, 0x33......, 0 none.
    #[serde(serialize_with = "super::json::hex")]
    pub default_script: u32,
    /// Default motion table, 0x09......, 0 none.
    #[serde(serialize_with = "super::json::hex")]
    pub default_motion_table: u32,
    /// Default sound table, 0x20......, 0 none.
    #[serde(serialize_with = "super::json::hex")]
    pub default_sound_table: u32,
    /// Default script table, 0x34......, 0 none.
    #[serde(serialize_with = "super::json::hex")]
    pub default_script_table: u32,
}

impl Setup {
    /// A setup as it is without a record: free heading, no parts, all sizes and ids 0 (`spec/07-animation.md, 3.1`).
    #[must_use]
    pub fn empty(id: u32) -> Self {
        Self {
            id,
            flags: SetupFlags::FREE_HEADING,
            parts: Vec::new(),
            parents: Vec::new(),
            scales: Vec::new(),
            holding_locations: KeyedList::default(),
            connection_points: KeyedList::default(),
            placements: KeyedList::default(),
            cyl_spheres: Vec::new(),
            spheres: Vec::new(),
            height: 0.0,
            radius: 0.0,
            step_up_height: 0.0,
            step_down_height: 0.0,
            sorting_sphere: ZERO_SPHERE,
            selection_sphere: ZERO_SPHERE,
            lights: Vec::new(),
            default_animation: 0,
            default_script: 0,
            default_motion_table: 0,
            default_sound_table: 0,
            default_script_table: 0,
        }
    }

    /// Free heading is allowed.
    #[must_use]
    pub fn allows_free_heading(&self) -> bool {
        self.flags.contains(SetupFlags::FREE_HEADING)
    }

    /// Some part has a physics tree.
    #[must_use]
    pub fn has_physics_bsp(&self) -> bool {
        self.flags.contains(SetupFlags::PHYSICS_BSP)
    }
}

const ZERO_SPHERE: Sphere = Sphere {
    center: Vec3::ZERO,
    radius: 0.0,
};

impl Record for Setup {
    const KIND: RecordKind = RecordKind::Setup;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let id = r.own_id()?;
        let flags = SetupFlags::from_bits_retain(r.u32()?);
        let p = r.count_u32("parts", 4)?;
        let parts = r.many(p, Reader::u32)?;
        let (mut parents, mut scales) = (Vec::new(), Vec::new());
        if flags.contains(SetupFlags::PARENTS) {
            let n = r.fits("parent parts", p as u64, 4)?;
            parents = r.many(n, Reader::u32)?;
        }
        if flags.contains(SetupFlags::SCALES) {
            let n = r.fits("scales", p as u64, 12)?;
            scales = r.many(n, |r| r.vec3("scale"))?;
        }
        let holding_locations = parse_locations(r, "holding location")?;
        let connection_points = parse_locations(r, "connection point")?;
        let n = r.count_i32("placements", 8usize.saturating_add(p.saturating_mul(28)))?;
        let placements = r.many(n, |r| Ok((r.i32()?, AnimFrame::parse(r, p)?)))?;
        let placements = keyed(r, "placement", placements)?;
        let n = r.count_u32("cylinders", 20)?;
        let cyl_spheres = r.many(n, Reader::cyl_sphere)?;
        let n = r.count_u32("spheres", 16)?;
        let spheres = r.many(n, Reader::sphere)?;
        Ok(Self {
            id,
            flags,
            parts,
            parents,
            scales,
            holding_locations,
            connection_points,
            placements,
            cyl_spheres,
            spheres,
            height: r.finite("height")?,
            radius: r.finite("radius")?,
            step_up_height: r.finite("step-up height")?,
            step_down_height: r.finite("step-down height")?,
            sorting_sphere: r.sphere()?,
            selection_sphere: r.sphere()?,
            lights: parse_lights(r)?,
            default_animation: r.u32()?,
            default_script: r.u32()?,
            default_motion_table: r.u32()?,
            default_sound_table: r.u32()?,
            default_script_table: r.u32()?,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.u32(self.flags.bits());
        w.count_u32("parts", self.parts.len());
        let expected = |flag| {
            if self.flags.contains(flag) {
                self.parts.len()
            } else {
                0
            }
        };
        w.same_len(
            "parent parts",
            self.parents.len(),
            expected(SetupFlags::PARENTS),
        );
        w.same_len("scales", self.scales.len(), expected(SetupFlags::SCALES));
        for &p in self.parts.iter().chain(&self.parents) {
            w.u32(p);
        }
        for &s in &self.scales {
            w.vec3(s);
        }
        write_locations(w, &self.holding_locations);
        write_locations(w, &self.connection_points);
        w.count_i32("placements", self.placements.len());
        for (key, frame) in &self.placements {
            w.i32(*key);
            frame.write(w, self.parts.len());
        }
        w.count_u32("cylinders", self.cyl_spheres.len());
        for c in &self.cyl_spheres {
            w.cyl_sphere(c);
        }
        w.count_u32("spheres", self.spheres.len());
        for s in &self.spheres {
            w.sphere(s);
        }
        for v in [
            self.height,
            self.radius,
            self.step_up_height,
            self.step_down_height,
        ] {
            w.f32(v);
        }
        w.sphere(&self.sorting_sphere);
        w.sphere(&self.selection_sphere);
        write_lights(w, &self.lights);
        w.u32(self.default_animation);
        w.u32(self.default_script);
        w.u32(self.default_motion_table);
        w.u32(self.default_sound_table);
        w.u32(self.default_script_table);
    }

    fn id(&self) -> u32 {
        self.id
    }
}

fn parse_locations(r: &mut Reader<'_>, what: &'static str) -> Read<KeyedList<i32, Location>> {
    let n = r.count_i32(what, 36)?;
    let list = r.many(n, |r| {
        Ok((
            r.i32()?,
            Location {
                part: r.i32()?,
                frame: r.frame()?,
            },
        ))
    })?;
    keyed(r, what, list)
}

fn write_locations(w: &mut Writer, list: &KeyedList<i32, Location>) {
    w.count_i32("locations", list.len());
    for (key, l) in list {
        w.i32(*key);
        w.i32(l.part);
        w.frame(&l.frame);
    }
}

fn parse_lights(r: &mut Reader<'_>) -> Read<Vec<(i32, Light)>> {
    let n = r.count_i32("lights", 48)?;
    r.many(n, |r| {
        let key = r.i32()?;
        let light = Light {
            frame: r.frame()?,
            color: r.u32()?,
            intensity: r.f32()?,
            falloff: r.f32()?,
            cone_angle: r.f32()?,
        };
        Ok((key, light))
    })
}

fn write_lights(w: &mut Writer, lights: &[(i32, Light)]) {
    w.count_i32("lights", lights.len());
    for (key, l) in lights {
        w.i32(*key);
        w.frame(&l.frame);
        w.u32(l.color);
        for v in [l.intensity, l.falloff, l.cone_angle] {
            w.f32(v);
        }
    }
}
