//! Worked values and invariants of `spec/02-terrain.md`, sections 19 to 21.

#![allow(
    clippy::excessive_precision,
    reason = "worked values stand as the specification prints them"
)]

use proptest::prelude::*;

use crate::math::{CellId, Direction, Vec3};
use crate::profile::{Normalize, Profile};
use crate::world::terrain::{
    Detail, DetailScale, HeightTable, TerrainBlock, TerrainVertices, Triangle, VERTICES,
    VERTICES_PER_SIDE, WaterType, is_sw_to_ne_cut,
};

fn block(heights: [u8; VERTICES], words: [u16; VERTICES]) -> TerrainBlock {
    let source = TerrainVertices { heights, words };
    TerrainBlock::new(
        CellId(0xA9B4_FFFF),
        source,
        &HeightTable::linear(),
        &Profile::retail(),
    )
}

fn corners() -> [Vec3; 4] {
    let (x, y) = (72.0, 120.0);
    [
        Vec3::new(x, y, 20.0),
        Vec3::new(x + 24.0, y, 24.0),
        Vec3::new(x + 24.0, y + 24.0, 30.0),
        Vec3::new(x, y + 24.0, 22.0),
    ]
}

#[test]
fn the_worked_cell() {
    let [sw, se, ne, nw] = corners();
    let profile = Profile::retail();
    let point = Vec3::new(80.0, 130.0, 0.0);
    let rows = [
        (
            [sw, se, ne],
            [-0.159617379, -0.239426062, 0.957704246],
            21.0694962,
            23.8333282,
        ),
        (
            [sw, ne, nw],
            [-0.315244198, -0.0788110495, 0.945732534],
            13.2402573,
            23.5000019,
        ),
        (
            [sw, se, nw],
            [-0.163846374, -0.0819231868, 0.983078301],
            1.96615469,
            22.1666679,
        ),
        (
            [ne, nw, se],
            [-0.307692319, -0.230769232, 0.923076928],
            35.0769272,
            21.1666641_f32,
        ),
    ];
    for (vertices, n, d, z) in rows {
        let plane = Triangle::new(vertices, &profile).plane;
        assert_eq!((plane.n, plane.d), (Vec3::from(n), d));
        assert_eq!(plane.height_at(point), Some(z));
    }
    assert!(Triangle::new([sw, ne, nw], &profile).contains(point));
    assert!(!Triangle::new([sw, se, ne], &profile).contains(point));
    assert!(Triangle::new([sw, se, nw], &profile).contains(point));
}

#[test]
fn the_worked_cell_divided_by_the_length() {
    let [sw, se, ne, nw] = corners();
    let profile = Profile {
        normalize: Normalize::Division,
        ..Profile::retail()
    };
    let plane = Triangle::new([sw, ne, nw], &profile).plane;
    assert_eq!(
        (plane.n, plane.d),
        (
            Vec3::new(-0.315244168, -0.078811042, 0.945732534),
            13.2402544
        )
    );
    let plane = Triangle::new([sw, se, nw], &profile).plane;
    assert_eq!(
        (plane.n, plane.d),
        (
            Vec3::new(-0.163846388, -0.0819231942, 0.983078301),
            1.96615732
        )
    );
}

#[test]
fn nan_is_inside_the_first_triangle() {
    let terrain = block([10; VERTICES], [0; VERTICES]);
    let (poly, _) = terrain.find_terrain_poly(0, Vec3::splat(f32::NAN)).unwrap();
    assert_eq!(poly, 0);
    assert_eq!(
        terrain.height_at(Vec3::splat(f32::NAN), &Profile::retail()),
        None
    );
}

#[test]
fn the_border_belongs_to_both_cells() {
    let terrain = block([10; VERTICES], [0; VERTICES]);
    let border = Vec3::new(24.0, 12.0, 0.0);
    assert!(terrain.find_terrain_poly(0, border).is_some());
    assert!(terrain.find_terrain_poly(8, border).is_some());
    assert!(terrain.find_terrain_poly(16, border).is_none());
    assert!(terrain.find_terrain_poly(64, border).is_none());
}

#[test]
fn a_flat_block_at_height_zero() {
    let terrain = block([0; VERTICES], [0; VERTICES]);
    let plane = terrain.triangles()[0].plane;
    assert_eq!(
        (plane.n, plane.d.to_bits()),
        (Vec3::Z, (-0.0_f32).to_bits())
    );
}

#[test]
fn generating_twice_changes_nothing() {
    let mut terrain = block([3; VERTICES], [0x50; VERTICES]);
    let (table, profile) = (HeightTable::linear(), Profile::retail());
    let before = terrain.triangles().to_vec();
    assert!(!terrain.generate(Detail::FULL, &table, &profile));
    let north = Detail {
        direction: Direction::North,
        ..Detail::FULL
    };
    assert!(!terrain.generate(north, &table, &profile));
    assert_eq!(terrain.triangles(), before);
    let half = Detail {
        scale: DetailScale::Half,
        direction: Direction::East,
    };
    assert!(terrain.generate(half, &table, &profile));
    assert_eq!(
        (terrain.triangles().len(), terrain.block_water()),
        (32, WaterType::None)
    );
    assert_eq!(terrain.cell_index(CellId(0xA9B4_0001)), None);
    assert!(terrain.generate(Detail::FULL, &table, &profile));
    assert_eq!(terrain.triangles(), before);
}

fn any_block() -> impl Strategy<Value = TerrainBlock> {
    (
        prop::array::uniform32(any::<u8>()),
        prop::array::uniform32(prop::sample::select(vec![0_u16, 16, 18, 20, 8, 3, 15, 21])),
        any::<bool>(),
    )
        .prop_map(|(heights, types, cliffs)| {
            let height = |i: usize| {
                if cliffs {
                    heights[i * 7 % 32]
                } else {
                    heights[i * 7 % 32] % 16
                }
            };
            block(
                std::array::from_fn(height),
                std::array::from_fn(|i| types[i * 5 % 32] << 2),
            )
        })
}

fn is_water(word: u16) -> bool {
    (16..=20).contains(&(word >> 2 & 0x1F))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn normals_planes_and_vertices(terrain in any_block()) {
        for triangle in terrain.triangles() {
            let plane = triangle.plane;
            prop_assert!((plane.n.length() - 1.0).abs() <= 2.0 * f32::EPSILON && plane.n.z > 0.0);
            for v in triangle.vertices {
                prop_assert!((plane.n.dot(v) + plane.d).abs() < 2e-4);
            }
        }
    }

    #[test]
    fn gentle_heights_agree_at_vertices(terrain in any_block().prop_filter("gentle", |t| t.height_limits().1 < 32.0)) {
        for triangle in terrain.triangles() {
            for v in triangle.vertices {
                let z = triangle.plane.height_at(v).unwrap();
                prop_assert!((z - v.z).abs() < 2e-4);
            }
        }
    }

    #[test]
    fn every_point_has_a_triangle(terrain in any_block(), x in 0.0_f32..=192.0, y in 0.0_f32..=192.0) {
        let point = Vec3::new(x, y, 0.0);
        let inside = |i: usize| terrain.find_terrain_poly(i, point);
        let found: Vec<usize> = (0..64).filter(|&i| inside(i).is_some()).collect();
        prop_assert!(!found.is_empty());
        if x % 24.0 != 0.0 && y % 24.0 != 0.0 {
            prop_assert_eq!(found.len(), 1);
            let index = (x / 24.0) as usize * 8 + (y / 24.0) as usize;
            prop_assert_eq!(found[0], index);
        }
        prop_assert!(found.iter().all(|&i| inside(i).unwrap().1.contains(point)));
    }

    #[test]
    fn cells_have_their_numbers(index in 0_usize..64) {
        let terrain = block([0; VERTICES], [0; VERTICES]);
        let id = terrain.cell_id(index);
        prop_assert_eq!(id.low() as usize, index + 1);
        prop_assert_eq!(terrain.cell_index(id), Some(index));
        let coord = id.land_coord().unwrap();
        prop_assert_eq!(terrain.is_sw_to_ne_cut(index), is_sw_to_ne_cut(coord));
        prop_assert_eq!((coord.x & 7, coord.y & 7), ((index / 8) as i32, (index % 8) as i32));
    }

    #[test]
    fn water_of_blocks_and_depths(terrain in any_block(), index in 0_usize..64, x in -1.0_f32..193.0, y in -1.0_f32..193.0) {
        let water = terrain.words().iter().filter(|&&w| is_water(w)).count();
        let expected = match water {
            0 => WaterType::None,
            VERTICES => WaterType::Entire,
            _ => WaterType::Partial,
        };
        prop_assert_eq!(terrain.block_water(), expected);
        let depth = terrain.water_depth(index, Vec3::new(x, y, 0.0), &Profile::retail()).metres();
        prop_assert!([0.0, 0.1, 0.45, 0.9].contains(&depth));
    }

    #[test]
    fn stitching_leaves_corners_and_meets_the_coarser_edge(terrain in any_block(), dx in -2_i32..=2, dy in -2_i32..=2) {
        let detail = Detail::at_offset(dx, dy);
        prop_assume!(detail.scale == DetailScale::Half);
        let (table, profile) = (HeightTable::linear(), Profile::retail());
        let mut terrain = terrain;
        terrain.generate(detail, &table, &profile);
        let v = terrain.vertices();
        let z = |i: usize, j: usize| v[i * 5 + j].z;
        for (i, j) in [(0, 0), (0, 4), (4, 0), (4, 4)] {
            let index = (i * VERTICES_PER_SIDE + j) * 2;
            prop_assert_eq!(z(i, j), table.height(terrain.source().heights[index]));
        }
        for k in [1, 3] {
            match detail.direction {
                Direction::North => prop_assert_eq!(z(k, 4), (z(k - 1, 4) + z(k + 1, 4)) / 2.0),
                Direction::West => prop_assert_eq!(z(0, k), (z(0, k - 1) + z(0, k + 1)) / 2.0),
                _ => {}
            }
        }
    }

    #[test]
    fn neighbours_with_equal_words_share_heights(heights in prop::array::uniform9(any::<u8>())) {
        let mut west = [0; VERTICES];
        let mut east = [0; VERTICES];
        west[8 * VERTICES_PER_SIDE..].copy_from_slice(&heights);
        east[..VERTICES_PER_SIDE].copy_from_slice(&heights);
        let (west, east) = (block(west, [0; VERTICES]), block(east, [0; VERTICES]));
        for j in 0..VERTICES_PER_SIDE {
            prop_assert_eq!(west.vertices()[8 * VERTICES_PER_SIDE + j].z.to_bits(), east.vertices()[j].z.to_bits());
        }
    }
}
