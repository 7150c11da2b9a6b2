//! A plain region for generated worlds.

use crate::dat::{
    Calendar, DayGroup, LandSurface, MapGrid, REGION_ID, Region, RegionParts, SceneType, Sky,
    SkyTime, TerrainTexture, TerrainType, TextureMerge, TimeOfDay,
};

/// Names of the terrain types (`spec/02-terrain.md, 3.2`); types without a name are reserved.
const TERRAIN: [&str; 21] = [
    "BarrenRock",
    "Grassland",
    "Ice",
    "LushGrass",
    "MarshSparseSwamp",
    "MudRichDirt",
    "ObsidianPlain",
    "PackedDirt",
    "PatchyDirt",
    "PatchyGrassland",
    "SandYellow",
    "SandGrey",
    "SandRockStrewn",
    "SedimentaryRock",
    "SemiBarrenRock",
    "Snow",
    "WaterRunning",
    "WaterStandingFresh",
    "WaterShallowSea",
    "WaterShallowStillSea",
    "WaterDeepSea",
];

/// A region with 2 metres per height index, 32 terrain types without scenery, an empty sky that stays as it is.
pub(super) fn flat_region() -> Region {
    Region {
        id: REGION_ID,
        number: 1,
        version: 3,
        name: "Generated".to_owned(),
        grid: MapGrid {
            width: 255,
            length: 255,
            square_length: 24.0,
            squares_per_block: 8,
            vertices_per_square: 1,
            max_object_height: 200.0,
            sky_height: 1000.0,
            road_width: 5.0,
        },
        height_table: std::array::from_fn(|i| i as f32 * 2.0),
        calendar: Calendar {
            zero_time: 0.0,
            zero_year: 10,
            day_length: 7620.0,
            days_per_year: 360,
            year_name: "P.Y.".to_owned(),
            times_of_day: vec![TimeOfDay {
                begin: 0.0,
                is_night: 0,
                name: "Day".to_owned(),
            }],
            days_of_week: vec!["Day".to_owned()],
            seasons: vec![(0, "Season".to_owned())],
        },
        parts: RegionParts::SKY
            | RegionParts::SOUNDS
            | RegionParts::SCENES
            | RegionParts::TERRAIN
            | RegionParts::ENCOUNTERS,
        sky: Some(still_sky()),
        ambient_sounds: Vec::new(),
        scene_types: vec![SceneType {
            ambient_sound: -1,
            scenes: Vec::new(),
        }],
        terrain_types: (0..32).map(terrain_type).collect(),
        land_surface: LandSurface::TextureMerge(TextureMerge {
            base_texture_size: 256,
            corner_maps: Vec::new(),
            side_maps: Vec::new(),
            road_maps: Vec::new(),
            terrain: vec![TerrainTexture {
                terrain_type: 0,
                texture: 0x0500_0001,
                tiling: 1,
                max_brightness: 0,
                min_brightness: 0,
                max_saturation: 0,
                min_saturation: 0,
                max_hue: 0,
                min_hue: 0,
                detail_tiling: 1,
                detail_texture: 0,
            }],
        }),
        misc: None,
    }
}

fn terrain_type(i: usize) -> TerrainType {
    let name = TERRAIN
        .get(i)
        .map_or_else(|| format!("Reserved{i}"), |n| (*n).to_owned());
    TerrainType {
        name,
        color: 0xFF80_8080,
        scene_types: vec![0; 32],
    }
}

/// Longer than all terrain names together: one reference subtracts the names twice and the sky not at all from the bytes it believes are
/// left (`spec/11-dat-files.md, 13.9`).
fn still_sky() -> Sky {
    let time = |i: u32| SkyTime {
        begin: i as f32 / 32.0,
        sun_brightness: 1.0,
        sun_heading: 180.0,
        sun_pitch: 45.0,
        sun_color: 0xFFFF_FFFF,
        ambient_brightness: 0.5,
        ambient_color: 0xFFFF_FFFF,
        fog_min: 200.0,
        fog_max: 1000.0,
        fog_color: 0xFFC0_C0C0,
        fog_kind: 1,
        replacements: Vec::new(),
    };
    let group = DayGroup {
        chance: 1.0,
        name: "Clear".to_owned(),
        objects: Vec::new(),
        times: (0..32).map(time).collect(),
    };
    Sky {
        tick: 10.0,
        light_tick: 10.0,
        day_groups: vec![group],
    }
}
