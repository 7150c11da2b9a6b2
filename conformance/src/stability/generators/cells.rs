//! Cells (`spec/03-cells.md`, 19.2): lists of the cells that spheres touch, and scenes across cells.

use std::sync::Arc;

use ac_client::{
    math::{CellId, EPSILON, Position, Quat, Sphere, Vec3},
    physics::transition::CellArray,
    world::{SpheresAt, World, terrain::WaterType},
};

use super::{
    super::{
        invariants::Invariant,
        stage::{DT, MISSILE, Stage, WALK, compass, indoors, motion},
        trial::Trial,
        worlds::{self, Playground, halls, houses, spots},
    },
    cases,
};

cases! { "03";
    1 "point on a cell border or diagonal" => border_point;
    2 "point within epsilon below 0" => epsilon_below_zero;
    3 "sphere that touches four landblocks" => four_blocks;
    4 "map edges" => map_edges;
    5 "radius exactly the distance to the border" => exact_radius;
    6 "two spheres in different landblocks" => two_blocks;
    7 "out through an exit portal, and in line with it elsewhere" => exit_portal;
    8 "rooms that overlap in space" => overlapping_rooms;
    9 "indoor id, centre outside every cell" => outside_its_room;
    10 "building in a neighbouring landblock" => building_next_block;
    11 "room without portals" => closed_room;
    12 "radius larger than a cell" => huge_radius;
    13 "partly flooded cell" => partly_flooded;
    14 "entirely flooded block" => flooded_block;
    15 "shadow order follows creation" => shadow_order;
    16 "loading order of rooms" => loading_order;
    17 "floor below the terrain of the block" => below_terrain;
    18 "several buildings in one cell" => two_buildings;
    19 "cell id 0" => no_cell;
    20 "scaled objects" => scaled_objects;
}

/// A playground whose world is loaded on demand.
struct Map {
    play: &'static Playground,
    world: World,
}

fn map(t: &mut Trial) -> Option<Map> {
    match worlds::play() {
        Ok(play) => Some(Map {
            play,
            world: World::with_source(t.profile.clone(), 0.0, Arc::clone(&play.source) as _),
        }),
        Err(error) => {
            t.promise(false, || error.to_string());
            None
        }
    }
}

impl Map {
    /// Ids of the cells that spheres at a place touch, and the cell of the first centre.
    fn cells(&mut self, cell: u32, spheres: &[(Vec3, f32)]) -> (Vec<u32>, Option<CellId>) {
        let spheres: Vec<Sphere> = spheres.iter().map(|(c, r)| Sphere::new(*c, *r)).collect();
        let position = Position::new(CellId(cell), spheres[0].center, Quat::IDENTITY);
        self.world.ensure_loaded_around(&position);
        let _ = self.world.visible_cell(position.cell);
        let mut array = CellArray::default();
        let at = SpheresAt {
            position: &position,
            spheres: &spheres,
            is_path: false,
            want_current: true,
        };
        let found = self.world.with_loading(|land, profile, missing| {
            let outcome = land.find_cell_list(at, &mut array, profile);
            *missing = outcome.missing;
            outcome
        });
        let ids = array.entries().map(|entry| entry.id.0).collect();
        let current = found.current.flatten().map(|cell| self.world.cell_id(cell));
        (ids, current)
    }
}

fn border_point(t: &mut Trial) {
    let Some(mut map) = map(t) else { return };
    let home = map.play.home;
    let (ids, current) = map.cells(home | 0x13, &[(Vec3::new(60.0, 24.0, 0.3), 0.3)]);
    t.promise(ids.len() >= 2, || format!("cells on a border: {ids:X?}"));
    let listed = current.is_some_and(|cell| ids.contains(&cell.0));
    t.promise(listed, || {
        format!("current {current:?} is not among {ids:X?}")
    });
    // Along the border, and along a diagonal.
    let stage = |heading| {
        Stage::new(map.play)
            .frames(DT, 150)
            .walker(map.play, [48.0, 96.0, 0.0], heading)
            .walks(3)
    };
    for heading in [0.0, 45.0, 90.0] {
        t.scene(&stage(heading));
    }
}

fn epsilon_below_zero(t: &mut Trial) {
    let id = CellId(0x2020_0001);
    let (cell, point) = id.adjust_to_outside(Vec3::new(-EPSILON * 0.5, 5.0, 0.0), &t.profile);
    t.same("cell half an epsilon below 0", cell, id);
    t.same("x", point.x, 0.0);
    let (cell, _) = id.adjust_to_outside(Vec3::new(-EPSILON * 1.5, 5.0, 0.0), &t.profile);
    t.same("block further below", cell.block_x(), 0x1F);
}

fn four_blocks(t: &mut Trial) {
    let Some(mut map) = map(t) else { return };
    let home = map.play.home;
    let (ids, _) = map.cells(home | 1, &[(Vec3::new(0.2, 0.2, 0.5), 0.5)]);
    let mut blocks: Vec<u32> = ids.iter().map(|id| id >> 16).collect();
    blocks.sort_unstable();
    blocks.dedup();
    t.same("landblocks", blocks.len(), 4);
    t.scene(
        &Stage::new(map.play)
            .frames(DT, 150)
            .walker(map.play, [3.0, 3.0, 0.0], 225.0)
            .walks(3),
    );
}

fn map_edges(t: &mut Trial) {
    let Some(mut map) = map(t) else { return };
    let (ids, _) = map.cells(1, &[(Vec3::new(0.1, 0.1, 0.5), 0.5)]);
    t.same("cells at the south-west corner", ids, vec![1]);
    let (ids, _) = map.cells(0xFEFE_0040, &[(Vec3::new(191.9, 191.9, 0.5), 0.5)]);
    t.same("cells at the north-east corner", ids, vec![0xFEFE_0040]);
    let p = t.profile.clone();
    let outside = |id: u32, x: f32| CellId(id).adjust_to_outside(Vec3::new(x, 5.0, 0.0), &p).0;
    t.promise(outside(1, -1.0).is_none(), || {
        "there is a cell west of the map".into()
    });
    t.promise(outside(0xFE20_0001, 192.5).is_none(), || {
        "there is a cell east of the map".into()
    });
    t.promise(!outside(1, -EPSILON / 2.0).is_none(), || {
        "the snap to 0 fails".into()
    });
}

fn exact_radius(t: &mut Trial) {
    let Some(mut map) = map(t) else { return };
    let home = map.play.home;
    let (ids, _) = map.cells(home | 0x0A, &[(Vec3::new(36.0, 36.0, 0.5), 12.0)]);
    t.same(
        "cells with a radius that just reaches the border",
        ids.len(),
        1,
    );
    let (ids, _) = map.cells(
        home | 0x0A,
        &[(Vec3::new(36.0, 36.0, 0.5), 12.0_f32.next_up() + 1e-5)],
    );
    t.promise(ids.len() > 1, || format!("a larger radius: {ids:X?}"));
}

fn two_blocks(t: &mut Trial) {
    let Some(mut map) = map(t) else { return };
    let home = map.play.home;
    let (ids, _) = map.cells(
        home | 1,
        &[
            (Vec3::new(0.5, 90.0, 0.5), 0.3),
            (Vec3::new(-0.5, 90.0, 1.5), 0.3),
        ],
    );
    let blocks: std::collections::BTreeSet<u32> = ids.iter().map(|id| id >> 16).collect();
    t.same("landblocks", blocks.len(), 2);
}

fn exit_portal(t: &mut Trial) {
    let Some(mut map) = map(t) else { return };
    let (town, [x, y, _]) = (map.play.town, houses::AT[0]);
    let outdoor = |ids: &[u32]| ids.iter().filter(|id| *id & 0xFFFF < 0x100).count();
    let (ids, _) = map.cells(town | 0x100, &[(Vec3::new(x, y - 3.0, 0.5), 0.3)]);
    t.promise(outdoor(&ids) > 0, || format!("in the door: {ids:X?}"));
    // In line with the door, but beside it: the plane has no end.
    let (ids, _) = map.cells(town | 0x100, &[(Vec3::new(x - 2.5, y - 2.9, 0.5), 0.3)]);
    t.promise(outdoor(&ids) > 0, || format!("beside the door: {ids:X?}"));
    let (ids, _) = map.cells(town | 0x100, &[(Vec3::new(x, y + 2.0, 0.5), 0.3)]);
    t.same("outdoor cells at the back wall", outdoor(&ids), 0);
    // Out and in again.
    let run = t.scene(&inside(map.play, 0, [x, y, 0.0], 180.0).walks(3));
    t.promise(run.last(0).cell & 0xFFFF < 0x100, || {
        format!("still in {:#X}", run.last(0).cell)
    });
    let run = t.scene(
        &Stage::new(map.play)
            .in_block(town)
            .frames(DT, 60)
            .walker(map.play, [x, y - 6.0, 0.0], 0.0)
            .walks(3),
    );
    t.promise(run.last(0).cell & 0xFFFF >= 0x100, || {
        format!("not inside: {:#X} at {:?}", run.last(0).cell, run.end())
    });
}

/// A walker in house number `room`.
fn inside(play: &Playground, room: u32, origin: [f32; 3], heading: f32) -> Stage {
    let mut stage = Stage::new(play)
        .in_block(play.town)
        .frames(DT, 100)
        .walker(play, origin, heading);
    stage.scene.entities[0].position = indoors(play.town | (0x100 + room), origin);
    stage.scene.entities[0].position.rotation = compass(heading);
    stage
}

fn overlapping_rooms(t: &mut Trial) {
    let Some(mut map) = map(t) else { return };
    let cell = map.play.rooms | halls::TRICK_CELL;
    let [x, y, z] = halls::TRICK;
    let (ids, current) = map.cells(cell, &[(Vec3::new(x, y + 3.5, z + 0.5), 0.4)]);
    t.same("rooms touched where both are", ids.len(), 2);
    t.promise(current.is_some(), || "no current cell".into());
    let mut stage = Stage::new(map.play)
        .in_block(map.play.rooms)
        .frames(DT, 150)
        .walker(map.play, halls::TRICK, 0.0);
    stage.scene.entities[0].position = indoors(cell, halls::TRICK);
    t.scene(&stage.walks(3));
}

fn outside_its_room(t: &mut Trial) {
    let Some(mut map) = map(t) else { return };
    let cell = map.play.rooms | halls::CLOSED_CELL;
    let (ids, current) = map.cells(cell, &[(Vec3::new(120.0, 150.0, -30.0), 0.3)]);
    t.same("current cell", current, None);
    t.promise(ids.len() <= 1, || format!("cells: {ids:X?}"));
    let stage = Stage::new(map.play)
        .frames(DT, 60)
        .entity(map.play.ball, [0.0; 3], |spec| {
            spec.position = indoors(cell, [120.0, 150.0, -30.0]);
        });
    t.scene(&stage);
}

fn building_next_block(t: &mut Trial) {
    let Some(mut map) = map(t) else { return };
    let (town, [x, y, _]) = (map.play.town, houses::AT[2]);
    // From the block east of it into the door.
    let east = CellId(town).block_corner();
    t.promise(east.in_bounds(), || "the town is off the map".into());
    let (ids, _) = map.cells(town | 0x3B, &[(Vec3::new(191.8, y - 3.6, 0.5), 0.5)]);
    t.promise(!ids.is_empty(), || "no cells beside the house".into());
    t.scene(
        &Stage::new(map.play)
            .in_block(town + 0x0100_0000)
            .frames(DT, 150)
            .walker(map.play, [4.0, y - 5.0, 0.0], 290.0)
            .walks(3),
    );
    t.scene(
        &Stage::new(map.play)
            .in_block(town)
            .frames(DT, 150)
            .walker(map.play, [x, y - 7.0, 0.0], 0.0)
            .walks(3),
    );
}

fn closed_room(t: &mut Trial) {
    let Some(mut map) = map(t) else { return };
    let cell = map.play.rooms | halls::CLOSED_CELL;
    let [x, y, z] = halls::CLOSED;
    let (ids, current) = map.cells(cell, &[(Vec3::new(x, y, z + 0.5), 0.4)]);
    t.same("cells", ids, vec![cell]);
    t.same("current", current, Some(CellId(cell)));
    // Against all its walls at the highest legal speed.
    for (vx, vy) in [(49.0, 3.0), (-30.0, 38.0), (1.0, -49.0)] {
        let low = [x - halls::HALF, y - halls::HALF, z - 0.01];
        let high = [x + halls::HALF, y + halls::HALF, z + 4.0];
        let stage = Stage::new(map.play)
            .frames(DT, 100)
            .closed(low, high)
            .entity(map.play.ball, [0.0; 3], |spec| {
                spec.position = indoors(cell, [x, y, z + 1.0]);
                spec.velocity = [vx, vy, 4.0];
                spec.elasticity = 0.1;
            });
        t.scene(&stage);
    }
}

fn huge_radius(t: &mut Trial) {
    let Some(mut map) = map(t) else { return };
    let home = map.play.home;
    for radius in [25.0, 100.0, 300.0, 1e4] {
        let (ids, _) = map.cells(home | 0x25, &[(Vec3::new(110.0, 110.0, 0.5), radius)]);
        t.promise((9..2000).contains(&ids.len()), || {
            format!("radius {radius}: {} cells", ids.len())
        });
    }
    let wide = |scale| {
        Stage::new(map.play)
            .frames(DT, 40)
            .entity(map.play.crate_, spots::OPEN, |spec| {
                spec.scale = scale;
                spec.state = 0x0001_0008;
            })
    };
    t.scene(&wide(30.0));
}

fn partly_flooded(t: &mut Trial) {
    let Some(map) = map(t) else { return };
    // The walker's height jumps in the middle of the cell: nothing else may.
    let stage = Stage::new(map.play)
        .in_block(map.play.shore)
        .frames(DT, 260)
        .walker(map.play, [70.0, 90.0, 0.0], 90.0);
    let run = t.scene(&stage.walks(3));
    let lowest = run.first().iter().map(|s| s.origin[2]).fold(0.0, f32::min);
    t.promise(lowest < -0.05, || format!("never in the water: {lowest}"));
}

fn flooded_block(t: &mut Trial) {
    let Some(mut map) = map(t) else { return };
    let sea = CellId(map.play.shore + 0x0100_0001);
    let _ = map.world.visible_cell(sea);
    let water = map
        .world
        .land
        .block(sea)
        .map(|block| block.terrain.block_water());
    t.same("water of the block", water, Some(WaterType::Entire));
    // Nobody walks into it; what flies as a missile may.
    let walker = Stage::new(map.play)
        .in_block(map.play.shore)
        .frames(DT, 200)
        .walker(map.play, [180.0, 90.0, 0.0], 90.0);
    let run = t.scene(&walker.walks(3));
    t.promise(run.last(0).cell >> 16 == map.play.shore >> 16, || {
        format!("walked into the sea at {:?}", run.end())
    });
    let missile = Stage::new(map.play)
        .in_block(map.play.shore)
        .frames(DT, 40)
        .entity(map.play.ball, [180.0, 90.0, 4.0], |spec| {
            spec.state = MISSILE;
            spec.velocity = [25.0, 0.0, 3.0];
        });
    t.as_retail(
        Invariant::Depth,
        "03 19.2.14: water is no floor for missiles",
    );
    let run = t.scene(&missile);
    t.promise(
        run.first().iter().any(|s| s.cell >> 16 == sea.0 >> 16),
        || "the missile stays out".into(),
    );
}

fn shadow_order(t: &mut Trial) {
    let Some(map) = map(t) else { return };
    // Two crates side by side, walked into in the middle; created in either order.
    let ends: Vec<[f32; 3]> = [1.0_f32, -1.0]
        .map(|side| {
            let stage =
                Stage::new(map.play)
                    .frames(DT, 120)
                    .walker(map.play, [30.0, 100.0, 0.0], 90.0);
            let crates = [side, -side].into_iter().fold(stage, |stage, side| {
                stage.entity(map.play.crate_, [36.0, 100.0 + side * 1.05, 0.0], |spec| {
                    spec.state = 0x0001_0008
                })
            });
            t.scene(&crates.walks(3)).end()
        })
        .into();
    t.promise(ends.iter().all(|end| end[0] < 35.5), || {
        format!("through the crates: {ends:?}")
    });
}

fn loading_order(t: &mut Trial) {
    let Some(map) = map(t) else { return };
    let ids = |reversed: bool, t: &Trial| {
        let mut world =
            World::with_source(t.profile.clone(), 0.0, Arc::clone(&map.play.source) as _);
        let mut rooms: Vec<u32> = (0..halls::ROW_LENGTH)
            .map(|i| map.play.rooms | (halls::ROW_CELL + i))
            .collect();
        if reversed {
            rooms.reverse();
        }
        rooms
            .iter()
            .filter(|id| world.visible_cell(CellId(**id)).is_some())
            .count()
    };
    let (forward, backward) = (ids(false, t), ids(true, t));
    t.same(
        "rooms loaded",
        (forward, backward),
        (halls::ROW_LENGTH as usize, halls::ROW_LENGTH as usize),
    );
}

fn below_terrain(t: &mut Trial) {
    let Some(map) = map(t) else { return };
    // The rooms lie 50 m below level ground.
    let [x, y, z] = halls::ROW;
    let mut stage = Stage::new(map.play)
        .in_block(map.play.rooms)
        .frames(DT, 250)
        .walker(map.play, halls::ROW, 0.0);
    stage.scene.entities[0].position = indoors(map.play.rooms | halls::ROW_CELL, [x, y - 4.0, z]);
    let run = t.scene(&stage.walks(3));
    let low = run
        .first()
        .iter()
        .map(|s| s.origin[2])
        .fold(f32::INFINITY, f32::min);
    t.promise((low - z).abs() < 0.01, || format!("lowest {low}"));
    t.promise(run.end()[1] > y, || {
        format!("does not get through the row: {:?}", run.end())
    });
}

fn two_buildings(t: &mut Trial) {
    let Some(map) = map(t) else { return };
    for (room, [x, y, _]) in houses::AT.into_iter().take(2).enumerate() {
        let stage = Stage::new(map.play)
            .in_block(map.play.town)
            .frames(DT, 80)
            .walker(map.play, [x, y - 6.0, 0.0], 0.0);
        let run = t.scene(&stage.walks(3));
        let wanted = map.play.town | (0x100 + room as u32);
        if room == 0 {
            t.same("room walked into", run.last(0).cell, wanted);
        } else {
            // One building per cell: the second is that of the cell it stands in, or nobody's (C-17).
            t.promise(run.frames() == 80, || "the scene ended early".into());
        }
    }
}

fn no_cell(t: &mut Trial) {
    let Some(mut map) = map(t) else { return };
    let (ids, current) = map.cells(0, &[(Vec3::new(5.0, 5.0, 5.0), 0.3)]);
    t.same("cells of id 0", (ids.len(), current), (0, None));
    let mut stage = Stage::new(map.play)
        .frames(DT, 30)
        .walker(map.play, spots::OPEN, 0.0);
    stage.scene.entities[0].position.cell = 0;
    let run = t.scene(&stage.at(3, 0, motion(WALK, 1.0)));
    t.same("its cell", run.last(0).cell, 0);
}

fn scaled_objects(t: &mut Trial) {
    let Some(map) = map(t) else { return };
    for scale in [0.1, 0.5, 2.0, 10.0] {
        for setup in [map.play.pillar, map.play.boulder, map.play.crate_] {
            let state = if setup == map.play.crate_ {
                0x0001_0008
            } else {
                0x0000_0008
            };
            let stage =
                Stage::new(map.play)
                    .frames(DT, 100)
                    .walker(map.play, [30.0, 100.0, 0.0], 90.0);
            let stage = stage.entity(setup, [52.0, 100.0, 0.0], |spec| {
                spec.scale = scale;
                spec.state = state;
            });
            t.scene(&stage.walks(3));
        }
    }
}
