//! Region: map grid, height table, terrain and scene types, sky, calendar; id 0x13000000.
//! Source: `spec/11-dat-files.md, 9.11`, `spec/02-terrain.md, 3.4, 17`.

use bitflags::bitflags;
use serde::{Serialize, Serializer};

use super::error::Problem;
use super::kind::RecordKind;
use super::reader::{Read, Reader};
use super::record::Record;
use super::sky::Sky;
use super::writer::Writer;

bitflags! {
    /// Which optional parts a region has. Retail's mask is 0x21F.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
    pub struct RegionParts: u32 {
        /// Ambient sounds.
        const SOUNDS = 0x01;
        /// Scene types.
        const SCENES = 0x02;
        /// Adds nothing to the record.
        const TERRAIN = 0x04;
        /// Adds nothing to the record.
        const ENCOUNTERS = 0x08;
        /// Sky.
        const SKY = 0x10;
        /// Six numbers at the end.
        const MISC = 0x200;
    }
}

/// A region.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Region {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Region number, 1.
    pub number: u32,
    /// Version, 3; anything else is refused by one reference (D-27).
    pub version: u32,
    /// Name.
    pub name: String,
    /// Map grid.
    pub grid: MapGrid,
    /// Height in metres of each height index.
    #[serde(serialize_with = "heights")]
    pub height_table: [f32; 256],
    /// Calendar.
    pub calendar: Calendar,
    /// Which optional parts are stored.
    pub parts: RegionParts,
    /// Sky; stored iff [`RegionParts::SKY`].
    pub sky: Option<Sky>,
    /// Ambient sounds; stored iff [`RegionParts::SOUNDS`].
    pub ambient_sounds: Vec<AmbientSounds>,
    /// Scene types; stored iff [`RegionParts::SCENES`].
    pub scene_types: Vec<SceneType>,
    /// Terrain types, 32.
    pub terrain_types: Vec<TerrainType>,
    /// How the land is textured.
    pub land_surface: LandSurface,
    /// Stored iff [`RegionParts::MISC`].
    pub misc: Option<RegionMisc>,
}

fn heights<S: Serializer>(v: &[f32; 256], s: S) -> Result<S::Ok, S::Error> {
    s.collect_seq(v)
}

/// Sizes of the map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MapGrid {
    /// Landblocks from west to east, 255.
    pub width: i32,
    /// Landblocks from south to north, 255.
    pub length: i32,
    /// Side of a square, 24 metres.
    pub square_length: f32,
    /// Squares along a landblock's side, 8.
    pub squares_per_block: i32,
    /// Vertices per square, 1.
    pub vertices_per_square: i32,
    /// 200 metres.
    pub max_object_height: f32,
    /// 1000 metres.
    pub sky_height: f32,
    /// 5 metres.
    pub road_width: f32,
}

/// Times of day, days, seasons.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Calendar {
    /// Zero time of year.
    pub zero_time: f64,
    /// Zero year.
    pub zero_year: u32,
    /// Seconds of a day.
    pub day_length: f32,
    /// Days of a year.
    pub days_per_year: u32,
    /// Name of the era.
    pub year_name: String,
    /// Times of day.
    pub times_of_day: Vec<TimeOfDay>,
    /// Names of the days.
    pub days_of_week: Vec<String>,
    /// First day and name of each season.
    pub seasons: Vec<(u32, String)>,
}

/// A part of the day.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TimeOfDay {
    /// Begin as a fraction of the day.
    pub begin: f32,
    /// Not 0: night.
    pub is_night: u32,
    /// Name.
    pub name: String,
}

/// Ambient sounds of a kind of land.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AmbientSounds {
    /// Sound table, 0x20......
    #[serde(serialize_with = "super::json::hex")]
    pub sound_table: u32,
    /// Sounds.
    pub sounds: Vec<AmbientSound>,
}

/// One ambient sound.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AmbientSound {
    /// Sound slot.
    pub slot: u32,
    /// Volume.
    pub volume: f32,
    /// Base chance.
    pub base_chance: f32,
    /// Least rate.
    pub min_rate: f32,
    /// Greatest rate.
    pub max_rate: f32,
}

/// Scenes of a kind of land.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneType {
    /// Index into the ambient sounds, -1 none.
    pub ambient_sound: i32,
    /// Scenes, 0x12......
    #[serde(serialize_with = "super::json::hex_list")]
    pub scenes: Vec<u32>,
}

/// A kind of terrain.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TerrainType {
    /// Name.
    pub name: String,
    /// Colour on the map, 0xAARRGGBB.
    pub color: u32,
    /// Indices into the scene types, -1 none (D-29).
    pub scene_types: Vec<i32>,
}

/// How the land is textured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum LandSurface {
    /// Kind 0: textures merged along alpha maps.
    TextureMerge(TextureMerge),
    /// Kind 1: shifted palettes; does not occur.
    PaletteShift(PaletteShift),
}

/// Textures merged along alpha maps.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TextureMerge {
    /// Pixels of a side.
    pub base_texture_size: u32,
    /// Code and surface texture of each.
    pub corner_maps: Vec<(u32, u32)>,
    /// Code and surface texture of each.
    pub side_maps: Vec<(u32, u32)>,
    /// Code and surface texture of each.
    pub road_maps: Vec<(u32, u32)>,
    /// Texture of each terrain type.
    pub terrain: Vec<TerrainTexture>,
}

/// Texture of a terrain type.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[allow(missing_docs, reason = "named after the fields of the record")]
pub struct TerrainTexture {
    /// Terrain type, 32 the road.
    pub terrain_type: u32,
    /// Surface texture, 0x05......
    pub texture: u32,
    pub tiling: u32,
    pub max_brightness: u32,
    pub min_brightness: u32,
    pub max_saturation: u32,
    pub min_saturation: u32,
    pub max_hue: u32,
    pub min_hue: u32,
    pub detail_tiling: u32,
    /// Surface texture, 0x05......
    pub detail_texture: u32,
}

/// Shifted palettes (`spec/02-terrain.md, 17`).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PaletteShift {
    /// Index and length of each range.
    pub ranges: Vec<(u32, u32)>,
    /// Road code and one kind for each range.
    pub roads: Vec<(u32, Vec<u32>)>,
    /// Terrain and palette.
    pub palettes: Vec<(u32, u32)>,
}

/// Numbers at the end of the record.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[allow(missing_docs, reason = "named after the fields of the record")]
pub struct RegionMisc {
    pub version: u32,
    pub game_map: u32,
    pub autotest_map: u32,
    pub autotest_map_size: u32,
    pub clear_cell: u32,
    pub clear_monster: u32,
}

impl Region {
    /// Scene type index of a terrain type and the scenery number of a terrain word; `None` if there is none (D-29) or out of range.
    #[must_use]
    pub fn scene_type(&self, terrain: u8, scenery: u8) -> Option<&SceneType> {
        let index = *self
            .terrain_types
            .get(usize::from(terrain))?
            .scene_types
            .get(usize::from(scenery))?;
        self.scene_types.get(usize::try_from(index).ok()?)
    }
}

impl Record for Region {
    const KIND: RecordKind = RecordKind::Region;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let (id, number, version) = (r.own_id()?, r.u32()?, r.u32()?);
        if version != 3 {
            r.deviation(
                4,
                Problem::Value {
                    what: "region version",
                    found: i64::from(version),
                    expected: "3",
                },
            )?;
        }
        let name = r.pstring()?;
        let grid = parse_grid(r)?;
        let mut height_table = [0.0; 256];
        for h in &mut height_table {
            *h = r.finite("height")?;
        }
        let calendar = parse_calendar(r)?;
        let parts = RegionParts::from_bits_retain(r.u32()?);
        let sky = if parts.contains(RegionParts::SKY) {
            Some(Sky::parse(r)?)
        } else {
            None
        };
        let ambient_sounds = if parts.contains(RegionParts::SOUNDS) {
            parse_sounds(r)?
        } else {
            Vec::new()
        };
        let scene_types = if parts.contains(RegionParts::SCENES) {
            parse_scene_types(r)?
        } else {
            Vec::new()
        };
        let terrain_types = parse_terrain_types(r)?;
        let land_surface = parse_land_surface(r)?;
        let misc = if parts.contains(RegionParts::MISC) {
            Some(parse_misc(r)?)
        } else {
            None
        };
        Ok(Self {
            id,
            number,
            version,
            name,
            grid,
            height_table,
            calendar,
            parts,
            sky,
            ambient_sounds,
            scene_types,
            terrain_types,
            land_surface,
            misc,
        })
    }

    fn write(&self, w: &mut Writer) {
        let stored = |part| usize::from(self.parts.contains(part));
        w.same_len(
            "sky without its flag",
            usize::from(self.sky.is_some()),
            stored(RegionParts::SKY),
        );
        w.same_len(
            "misc without its flag",
            usize::from(self.misc.is_some()),
            stored(RegionParts::MISC),
        );
        w.u32(self.id);
        w.u32(self.number);
        w.u32(self.version);
        w.pstring(&self.name);
        write_grid(w, &self.grid);
        for &h in &self.height_table {
            w.f32(h);
        }
        write_calendar(w, &self.calendar);
        w.u32(self.parts.bits());
        if let Some(sky) = &self.sky {
            sky.write(w);
        }
        if self.parts.contains(RegionParts::SOUNDS) {
            write_sounds(w, &self.ambient_sounds);
        }
        if self.parts.contains(RegionParts::SCENES) {
            write_scene_types(w, &self.scene_types);
        }
        write_terrain_types(w, &self.terrain_types);
        write_land_surface(w, &self.land_surface);
        if let Some(m) = &self.misc {
            for v in [
                m.version,
                m.game_map,
                m.autotest_map,
                m.autotest_map_size,
                m.clear_cell,
                m.clear_monster,
            ] {
                w.u32(v);
            }
        }
    }

    fn id(&self) -> u32 {
        self.id
    }
}

fn parse_grid(r: &mut Reader<'_>) -> Read<MapGrid> {
    Ok(MapGrid {
        width: r.i32()?,
        length: r.i32()?,
        square_length: r.f32()?,
        squares_per_block: r.i32()?,
        vertices_per_square: r.i32()?,
        max_object_height: r.f32()?,
        sky_height: r.f32()?,
        road_width: r.f32()?,
    })
}

fn write_grid(w: &mut Writer, g: &MapGrid) {
    w.i32(g.width);
    w.i32(g.length);
    w.f32(g.square_length);
    w.i32(g.squares_per_block);
    w.i32(g.vertices_per_square);
    w.f32(g.max_object_height);
    w.f32(g.sky_height);
    w.f32(g.road_width);
}

fn parse_calendar(r: &mut Reader<'_>) -> Read<Calendar> {
    let (zero_time, zero_year, day_length, days_per_year) =
        (r.f64()?, r.u32()?, r.f32()?, r.u32()?);
    let year_name = r.pstring()?;
    let n = r.count_u32("times of day", 10)?;
    let times_of_day = r.many(n, |r| {
        Ok(TimeOfDay {
            begin: r.f32()?,
            is_night: r.u32()?,
            name: r.pstring()?,
        })
    })?;
    let n = r.count_u32("days of the week", 2)?;
    let days_of_week = r.many(n, Reader::pstring)?;
    let n = r.count_u32("seasons", 6)?;
    let seasons = r.many(n, |r| Ok((r.u32()?, r.pstring()?)))?;
    Ok(Calendar {
        zero_time,
        zero_year,
        day_length,
        days_per_year,
        year_name,
        times_of_day,
        days_of_week,
        seasons,
    })
}

fn write_calendar(w: &mut Writer, c: &Calendar) {
    w.f64(c.zero_time);
    w.u32(c.zero_year);
    w.f32(c.day_length);
    w.u32(c.days_per_year);
    w.pstring(&c.year_name);
    w.count_u32("times of day", c.times_of_day.len());
    for t in &c.times_of_day {
        w.f32(t.begin);
        w.u32(t.is_night);
        w.pstring(&t.name);
    }
    w.count_u32("days of the week", c.days_of_week.len());
    for d in &c.days_of_week {
        w.pstring(d);
    }
    w.count_u32("seasons", c.seasons.len());
    for (begin, name) in &c.seasons {
        w.u32(*begin);
        w.pstring(name);
    }
}

fn parse_sounds(r: &mut Reader<'_>) -> Read<Vec<AmbientSounds>> {
    let n = r.count_u32("ambient sound tables", 8)?;
    r.many(n, |r| {
        let sound_table = r.u32()?;
        let m = r.count_u32("ambient sounds", 20)?;
        let sounds = r.many(m, |r| {
            Ok(AmbientSound {
                slot: r.u32()?,
                volume: r.f32()?,
                base_chance: r.f32()?,
                min_rate: r.f32()?,
                max_rate: r.f32()?,
            })
        })?;
        Ok(AmbientSounds {
            sound_table,
            sounds,
        })
    })
}

fn write_sounds(w: &mut Writer, list: &[AmbientSounds]) {
    w.count_u32("ambient sound tables", list.len());
    for s in list {
        w.u32(s.sound_table);
        w.count_u32("ambient sounds", s.sounds.len());
        for a in &s.sounds {
            w.u32(a.slot);
            for v in [a.volume, a.base_chance, a.min_rate, a.max_rate] {
                w.f32(v);
            }
        }
    }
}

fn parse_scene_types(r: &mut Reader<'_>) -> Read<Vec<SceneType>> {
    let n = r.count_u32("scene types", 8)?;
    r.many(n, |r| {
        let ambient_sound = r.i32()?;
        let m = r.count_u32("scenes", 4)?;
        Ok(SceneType {
            ambient_sound,
            scenes: r.many(m, Reader::u32)?,
        })
    })
}

fn write_scene_types(w: &mut Writer, list: &[SceneType]) {
    w.count_u32("scene types", list.len());
    for s in list {
        w.i32(s.ambient_sound);
        w.count_u32("scenes", s.scenes.len());
        for &scene in &s.scenes {
            w.u32(scene);
        }
    }
}

fn parse_terrain_types(r: &mut Reader<'_>) -> Read<Vec<TerrainType>> {
    let n = r.count_u32("terrain types", 10)?;
    r.many(n, |r| {
        let (name, color) = (r.pstring()?, r.u32()?);
        let m = r.count_u32("scene type indices", 4)?;
        Ok(TerrainType {
            name,
            color,
            scene_types: r.many(m, Reader::i32)?,
        })
    })
}

fn write_terrain_types(w: &mut Writer, list: &[TerrainType]) {
    w.count_u32("terrain types", list.len());
    for t in list {
        w.pstring(&t.name);
        w.u32(t.color);
        w.count_u32("scene type indices", t.scene_types.len());
        for &s in &t.scene_types {
            w.i32(s);
        }
    }
}

fn parse_land_surface(r: &mut Reader<'_>) -> Read<LandSurface> {
    match r.u32()? {
        0 => Ok(LandSurface::TextureMerge(TextureMerge {
            base_texture_size: r.u32()?,
            corner_maps: pairs(r, "corner maps")?,
            side_maps: pairs(r, "side maps")?,
            road_maps: pairs(r, "road maps")?,
            terrain: {
                let n = r.count_u32("terrain textures", 44)?;
                r.many(n, parse_terrain_texture)?
            },
        })),
        1 => {
            let ranges = pairs(r, "palette ranges")?;
            let n = r.count_u32("palette roads", 4 + 4 * ranges.len())?;
            let roads = r.many(n, |r| Ok((r.u32()?, r.many(ranges.len(), Reader::u32)?)))?;
            Ok(LandSurface::PaletteShift(PaletteShift {
                ranges,
                roads,
                palettes: pairs(r, "terrain palettes")?,
            }))
        }
        found => Err(r.error_at(
            r.offset() - 4,
            Problem::Unknown {
                what: "land surface kind",
                found,
            },
        )),
    }
}

fn pairs(r: &mut Reader<'_>, what: &'static str) -> Read<Vec<(u32, u32)>> {
    let n = r.count_u32(what, 8)?;
    r.many(n, |r| Ok((r.u32()?, r.u32()?)))
}

fn parse_terrain_texture(r: &mut Reader<'_>) -> Read<TerrainTexture> {
    Ok(TerrainTexture {
        terrain_type: r.u32()?,
        texture: r.u32()?,
        tiling: r.u32()?,
        max_brightness: r.u32()?,
        min_brightness: r.u32()?,
        max_saturation: r.u32()?,
        min_saturation: r.u32()?,
        max_hue: r.u32()?,
        min_hue: r.u32()?,
        detail_tiling: r.u32()?,
        detail_texture: r.u32()?,
    })
}

fn write_land_surface(w: &mut Writer, surface: &LandSurface) {
    match surface {
        LandSurface::TextureMerge(m) => {
            w.u32(0);
            w.u32(m.base_texture_size);
            for maps in [&m.corner_maps, &m.side_maps, &m.road_maps] {
                write_pairs(w, maps);
            }
            w.count_u32("terrain textures", m.terrain.len());
            for t in &m.terrain {
                write_terrain_texture(w, t);
            }
        }
        LandSurface::PaletteShift(p) => {
            w.u32(1);
            write_pairs(w, &p.ranges);
            w.count_u32("palette roads", p.roads.len());
            for (code, kinds) in &p.roads {
                w.same_len("palette kinds of a road", kinds.len(), p.ranges.len());
                w.u32(*code);
                for &k in kinds {
                    w.u32(k);
                }
            }
            write_pairs(w, &p.palettes);
        }
    }
}

fn write_pairs(w: &mut Writer, list: &[(u32, u32)]) {
    w.count_u32("pairs", list.len());
    for (a, b) in list {
        w.u32(*a);
        w.u32(*b);
    }
}

fn write_terrain_texture(w: &mut Writer, t: &TerrainTexture) {
    for v in [
        t.terrain_type,
        t.texture,
        t.tiling,
        t.max_brightness,
        t.min_brightness,
        t.max_saturation,
        t.min_saturation,
        t.max_hue,
        t.min_hue,
        t.detail_tiling,
        t.detail_texture,
    ] {
        w.u32(v);
    }
}

fn parse_misc(r: &mut Reader<'_>) -> Read<RegionMisc> {
    Ok(RegionMisc {
        version: r.u32()?,
        game_map: r.u32()?,
        autotest_map: r.u32()?,
        autotest_map_size: r.u32()?,
        clear_cell: r.u32()?,
        clear_monster: r.u32()?,
    })
}
