//! Terrain (`spec/02-terrain.md`, 21): blocks made in memory, asked directly, and scenes on them.

use std::sync::Arc;

use ac_client::{
    dat::{Region, Scene, SceneObject, StoredFrame, worldgen::WorldBuilder},
    math::{CellId, Vec3},
    world::{
        World,
        terrain::{
            Detail, HeightTable, TerrainBlock, TerrainVertices, VERTICES, WaterDepth, WaterType,
            scenery,
        },
    },
};

use super::{
    super::{
        stage::{DT, Stage, WALK, motion},
        trial::Trial,
        worlds,
    },
    cases,
};

const BLOCK: CellId = CellId(0x2020_FFFF);

cases! { "02";
    1 "point exactly on the diagonal" => on_the_diagonal;
    2 "point on the cell border" => on_the_border;
    3 "point outside the cell" => outside_the_cell;
    4 "NaN point" => nan_point;
    5 "last column of the map" => last_column;
    6 "blocks that are missing" => missing_blocks;
    7 "cliffs of hundreds of metres in one cell" => cliffs;
    8 "flat block at height index 0" => flat_block;
    9 "height table with impossible entries" => height_tables;
    10 "depth at exactly 12 m inside the cell" => middle_depth;
    11 "partly flooded cell, dry corner nearest" => dry_corner;
    12 "scenery that names nothing" => no_scenes;
    13 "frequency 1" => always_there;
    14 "displacement out of the block" => displaced_out;
    15 "slope limits that let everything pass" => any_slope;
    16 "least scale 0" => zero_scale;
    17 "all corners road" => all_road;
    18 "alpha maps without a matching code" => no_alpha_map;
    19 "a block leaves full detail while objects stand in it" => detail_change;
}

fn block(
    t: &Trial,
    height: impl Fn(usize, usize) -> u8,
    word: impl Fn(usize, usize) -> u16,
) -> TerrainBlock {
    let source = TerrainVertices {
        heights: std::array::from_fn(|i| height(i / 9, i % 9)),
        words: std::array::from_fn(|i| word(i / 9, i % 9)),
    };
    TerrainBlock::new(BLOCK, source, &HeightTable::linear(), &t.profile)
}

/// Water from this column on.
fn shore(column: usize, from: usize) -> u16 {
    if column >= from { 20 << 2 } else { 0 }
}

fn on_the_diagonal(t: &mut Trial) {
    let terrain = block(t, |x, y| (x * 3 + y) as u8, |_, _| 0);
    for cell in 0..64 {
        let (x, y) = ((cell / 8) as f32 * 24.0, (cell % 8) as f32 * 24.0);
        for share in [0.25_f32, 0.5, 0.75] {
            let along = 24.0 * share;
            let point = if terrain.is_sw_to_ne_cut(cell) {
                Vec3::new(x + along, y + along, 0.0)
            } else {
                Vec3::new(x + along, y + 24.0 - along, 0.0)
            };
            let found = terrain.find_terrain_poly(cell, point).map(|(i, _)| i);
            t.same("polygon of a point on the diagonal", found, Some(0));
        }
    }
}

fn on_the_border(t: &mut Trial) {
    let terrain = block(t, |x, _| x as u8, |_, _| 0);
    let point = Vec3::new(24.0, 10.0, 0.0);
    let owner = BLOCK
        .with_low(1)
        .outside_coord(point.x, point.y, &t.profile)
        .map(|c| c.cell_id().low());
    t.same("cell of x = 24", owner, Some(9));
    t.promise(terrain.find_terrain_poly(0, point).is_some(), || {
        "the western cell does not accept it".into()
    });
    t.promise(terrain.find_terrain_poly(8, point).is_some(), || {
        "the eastern cell does not accept it".into()
    });
    let heights = [0, 8].map(|cell| {
        terrain
            .find_terrain_poly(cell, point)
            .and_then(|(_, tri)| tri.plane.height_at(point))
    });
    let [Some(a), Some(b)] = heights else {
        return t.promise(false, || "no height on the border".into());
    };
    t.promise((a - b).abs() < 1e-4, || {
        format!("{a} and {b} on the same border")
    });
}

fn outside_the_cell(t: &mut Trial) {
    let terrain = block(t, |_, _| 0, |_, _| 0);
    for point in [
        Vec3::new(-1.0, 5.0, 0.0),
        Vec3::new(25.0, 5.0, 0.0),
        Vec3::new(5.0, 30.0, 0.0),
    ] {
        t.promise(terrain.find_terrain_poly(0, point).is_none(), || {
            format!("cell 0 has {point}")
        });
    }
    t.same(
        "height outside the block",
        terrain.height_at(Vec3::new(200.0, 5.0, 0.0), &t.profile),
        None,
    );
    t.same(
        "cell that is none",
        terrain.find_terrain_poly(64, Vec3::ZERO).is_none(),
        true,
    );
}

fn nan_point(t: &mut Trial) {
    let terrain = block(t, |_, _| 0, |_, _| 0);
    let nan = Vec3::new(f32::NAN, f32::NAN, 0.0);
    t.same(
        "polygon of not-a-number",
        terrain.find_terrain_poly(0, nan).map(|(i, _)| i),
        Some(0),
    );
}

fn last_column(t: &mut Trial) {
    let corner = CellId(0xFE20_0001);
    let (cell, _) = corner.adjust_to_outside(Vec3::new(192.0, 5.0, 0.0), &t.profile);
    t.promise(cell.is_none(), || {
        format!("x = 192 of the last column is in {cell}")
    });
    let (cell, _) =
        corner.adjust_to_outside(Vec3::new(192.0_f32.next_down(), 5.0, 0.0), &t.profile);
    t.promise(!cell.is_none(), || {
        "one ulp before it there is no cell".into()
    });
}

fn missing_blocks(t: &mut Trial) {
    let Ok(play) = worlds::play() else {
        return t.promise(false, || "no world".into());
    };
    let mut world = World::with_source(t.profile.clone(), 0.0, Arc::clone(&play.source) as _);
    for id in [0xFFFF_0001, 0x7777_0001, 0x2020_0000, 0x2020_0041] {
        t.promise(world.visible_cell(CellId(id)).is_none(), || {
            format!("cell {id:#X} is there")
        });
    }
    // Thrown off the only blocks there are.
    let stage = Stage::new(play).in_block(0x1F20_0000).frames(DT, 200);
    t.scene(&stage.thrown(play.ball, [3.0, 90.0, 1.0], [-40.0, 0.0, 12.0]));
}

fn cliffs(t: &mut Trial) {
    let terrain = block(t, |x, y| if x + y > 7 { 255 } else { 0 }, |_, _| 0);
    let steepest = terrain
        .triangles()
        .iter()
        .map(|tri| tri.plane.n.z)
        .fold(1.0, f32::min);
    t.promise((0.02..0.1).contains(&steepest), || {
        format!("steepest n.z {steepest}")
    });
    for triangle in terrain.triangles() {
        for corner in triangle.vertices {
            let height = triangle.plane.height_at(corner).unwrap_or(f32::NAN);
            // About 40 times the rounding of d.
            t.promise((height - corner.z).abs() < 0.01, || {
                format!("height {height} at {corner}")
            });
        }
    }
    let Ok(play) = worlds::play() else {
        return t.promise(false, || "no world".into());
    };
    // Off the cliff, against its foot, and down its face.
    let stage = || Stage::new(play).in_block(play.hills).frames(DT, 400);
    t.scene(&stage().walker(play, [80.0, 90.0, 34.0], 90.0).walks(5));
    t.scene(&stage().thrown(play.ball, [130.0, 90.0, 440.0], [12.0, 1.0, 0.0]));
    t.scene(&stage().walker(play, [180.0, 90.0, 0.0], 270.0).walks(5));
}

fn flat_block(t: &mut Trial) {
    let terrain = block(t, |_, _| 0, |_, _| 0);
    for triangle in terrain.triangles() {
        t.same("normal", triangle.plane.n, Vec3::Z);
        t.same("d", triangle.plane.d, 0.0);
    }
    t.same("limits", terrain.height_limits(), (0.0, 0.0));
}

fn height_tables(t: &mut Trial) {
    t.promise(HeightTable::new(&[0.0; 255]).is_none(), || {
        "255 heights are a table".into()
    });
    // Taken as it is, and reported (11 D-28).
    for height in [-5.0, 801.0, f32::MAX] {
        let mut world = WorldBuilder::new();
        world.region.height_table[7] = height;
        world.block(0x20, 0x20).heights(|_, _| 7);
        match world.surround().build() {
            Err(error) => t.promise(false, || format!("height {height}: {error}")),
            Ok(set) => {
                let kept = set.region().height_table[7];
                t.same("height as read", kept, height);
            }
        }
    }
}

fn middle_depth(t: &mut Trial) {
    let terrain = block(t, |_, _| 0, |x, _| shore(x, 1));
    let at = |x: f32| terrain.water_depth(0, Vec3::new(x, 5.0, 0.0), &t.profile);
    let (before, middle, after) = (at(12.0_f32.next_down()), at(12.0), at(12.0_f32.next_up()));
    t.same("just west of the middle", before, WaterDepth::Damp);
    t.same("in the middle", middle, WaterDepth::Wading);
    t.same("just east of the middle", after, WaterDepth::Wading);
}

fn dry_corner(t: &mut Trial) {
    let terrain = block(t, |_, _| 0, |x, _| shore(x, 1));
    t.same(
        "water of the cell",
        terrain.cell_water(0),
        WaterType::Partial,
    );
    t.same(
        "depth",
        terrain
            .water_depth(0, Vec3::new(1.0, 1.0, 0.0), &t.profile)
            .metres(),
        0.1,
    );
    t.same(
        "depth in a dry cell",
        block(t, |_, _| 0, |_, _| 0)
            .water_depth(0, Vec3::ZERO, &t.profile)
            .metres(),
        0.0,
    );
}

fn object() -> SceneObject {
    SceneObject {
        model: 0x0100_0001,
        frame: StoredFrame::IDENTITY,
        frequency: 1.0,
        displace_x: 0.0,
        displace_y: 0.0,
        min_scale: 1.0,
        max_scale: 1.0,
        max_rotation: 0.0,
        min_slope: 0.0,
        max_slope: 90.0,
        align: 0,
        orient: 0,
        weenie: 0,
    }
}

/// Scenery of a block whose words name scene type 0, which has one scene.
fn scattered(
    t: &Trial,
    change: impl Fn(&mut Region),
    object: SceneObject,
) -> Vec<scenery::SceneryPlacement> {
    let mut region = WorldBuilder::new().region;
    region.scene_types[0].scenes = vec![0x1200_0001];
    change(&mut region);
    let scene = Arc::new(Scene {
        id: 0x1200_0001,
        objects: vec![object],
    });
    let terrain = block(t, |_, _| 0, |_, _| 0);
    scenery::scenery(
        &terrain,
        &region,
        |_| Some(Arc::clone(&scene)),
        |_| false,
        &t.profile,
    )
}

fn no_scenes(t: &mut Trial) {
    let empty: [fn(&mut Region); 3] = [
        |region| region.scene_types[0].scenes.clear(),
        |region| region.terrain_types[0].scene_types[0] = 99,
        |region| region.terrain_types[0].scene_types[0] = -1,
    ];
    for change in empty {
        t.same("placements", scattered(t, change, object()).len(), 0);
    }
    let whole = scattered(t, |_| (), object()).len();
    t.promise(whole > 0, || "the control places nothing".into());
}

fn always_there(t: &mut Trial) {
    let full = scattered(t, |_| (), object()).len();
    let half = scattered(
        t,
        |_| (),
        SceneObject {
            frequency: 0.5,
            ..object()
        },
    )
    .len();
    // Vertices on the far borders lie outside the block.
    t.promise(full >= 64 && half < full, || {
        format!("{full} with frequency 1, {half} with 0.5")
    });
}

fn displaced_out(t: &mut Trial) {
    let far = SceneObject {
        displace_x: 500.0,
        displace_y: 500.0,
        ..object()
    };
    for placed in scattered(t, |_| (), far) {
        let at = placed.frame.origin;
        t.promise(
            (0.0..192.0).contains(&at.x) && (0.0..192.0).contains(&at.y),
            || format!("scenery at {at}"),
        );
    }
    t.promise(true, String::new);
}

fn any_slope(t: &mut Trial) {
    let open = scattered(t, |_| (), object()).len();
    let strict = scattered(
        t,
        |_| (),
        SceneObject {
            min_slope: 0.999,
            max_slope: 90.0,
            ..object()
        },
    )
    .len();
    t.same("level ground with a strict lower limit", strict, open);
    let none = scattered(
        t,
        |_| (),
        SceneObject {
            min_slope: 0.0,
            max_slope: 0.5,
            ..object()
        },
    )
    .len();
    t.same("level ground above the upper limit", none, 0);
}

fn zero_scale(t: &mut Trial) {
    let placed = scattered(
        t,
        |_| (),
        SceneObject {
            min_scale: 0.0,
            max_scale: 2.0,
            ..object()
        },
    );
    t.promise(!placed.is_empty(), || "nothing is placed".into());
    for one in placed {
        // pow(inf, u)·0: kept as it is.
        t.promise(one.scale.is_nan(), || format!("scale {}", one.scale));
    }
}

fn all_road(t: &mut Trial) {
    t.no_code("overlays of terrain textures are the renderer's");
}

fn no_alpha_map(t: &mut Trial) {
    t.no_code("alpha maps of terrain textures are the renderer's");
}

fn detail_change(t: &mut Trial) {
    let mut terrain = block(t, |x, _| x as u8, |_, _| 0);
    terrain.generate(Detail::at_offset(5, 5), &HeightTable::linear(), &t.profile);
    t.promise(!terrain.is_full_detail(), || {
        "five blocks away there is full detail".into()
    });
    t.same(
        "cells at reduced detail",
        terrain.cell_index(CellId(0x2020_0001)),
        None,
    );
    t.promise(VERTICES == 81, || "a block has 81 vertices".into());
    let Ok(play) = worlds::play() else {
        return t.promise(false, || "no world".into());
    };
    // Nothing physical of the released block remains: whoever stood there has no cell.
    let mut world = World::with_source(t.profile.clone(), 0.0, Arc::clone(&play.source) as _);
    let cell = CellId(play.home | 1);
    t.promise(world.visible_cell(cell).is_some(), || {
        "the block does not load".into()
    });
    let mut lost = Vec::new();
    world.release_block(cell, &mut lost);
    t.promise(world.land.loaded(cell).is_none(), || {
        "a cell of the released block remains".into()
    });
    let stage = Stage::new(play)
        .frames(DT, 20)
        .walker(play, worlds::spots::OPEN, 0.0);
    t.scene(&stage.at(2, 0, motion(WALK, 1.0)));
}
