//! Scenery: trees, rocks and the like, which no file lists; every client scatters the same (`spec/02-terrain.md`, section 15).
//!
//! Each vertex names a list of scenes by its terrain word. Hashes of the vertex's place on the map choose the scene and, for each of its
//! objects, whether, where, how turned and how large it stands. Nothing depends on load order, time or random state.

use std::sync::Arc;

use super::{CELLS, TerrainBlock, VERTICES, VERTICES_PER_SIDE, on_road, scene_type, terrain_type};
use crate::dat::{Region, Scene, SceneObject};
use crate::math::{BLOCK_LENGTH, CELL_LENGTH, Frame, LandCoord, Vec2, Vec3, heading_of_vector};
use crate::profile::Profile;

/// Slightly less than 2^-32, as an f64.
const UNIT: f64 = 2.3283064e-10;

/// Salts of the draws; the number of the object in its scene is added.
mod salt {
    pub(super) const FREQUENCY: u32 = 23399;
    pub(super) const DISPLACE_X: u32 = 45773;
    pub(super) const DISPLACE_Y: u32 = 72719;
    pub(super) const ROTATION: u32 = 63127;
    pub(super) const SCALE: u32 = 32593;
}

/// One object that the terrain asks for. It still has to fit into the block, which its shape decides.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneryPlacement {
    /// Shape or setup.
    pub model: u32,
    /// Place, block coordinates.
    pub frame: Frame,
    /// Outdoor cell it stands in, 0..64.
    pub cell: usize,
    /// Scale, set after the object has entered its cell.
    pub scale: f32,
}

/// The hashes of one vertex.
#[derive(Debug, Clone, Copy)]
struct Draws {
    x: u32,
    y: u32,
}

impl Draws {
    fn new(vertex: LandCoord) -> Self {
        Self {
            x: vertex.x as u32,
            y: vertex.y as u32,
        }
    }

    fn scene_hash(self) -> u32 {
        let Self { x, y } = self;
        y.wrapping_mul(x.wrapping_mul(0x2A7F_2B89).wrapping_add(0x6C1A_C587))
            .wrapping_sub(x.wrapping_mul(0x421B_E3BD))
            .wrapping_add(0x7F8C_DA01)
    }

    fn object_hash(self, salt: u32) -> u32 {
        let Self { x, y } = self;
        let mixed = x
            .wrapping_mul(y)
            .wrapping_mul(0x5111_BFEF)
            .wrapping_add(0x7089_2FB7);
        y.wrapping_mul(0x6C1A_C587)
            .wrapping_sub(salt.wrapping_mul(mixed))
            .wrapping_sub(x.wrapping_mul(0x421B_E3BD))
    }

    fn quadrant_hash(self) -> u32 {
        let Self { x, y } = self;
        y.wrapping_mul(0x6C1A_C587)
            .wrapping_sub(x.wrapping_mul(y.wrapping_mul(0x6F7B_D965).wrapping_add(0x421B_E3BD)))
            .wrapping_sub(0x17FC_EDFD)
    }

    /// A number in [0, 1) for object `k` of the scene.
    fn unit(self, salt: u32, k: u32) -> f64 {
        unit(self.object_hash(salt.wrapping_add(k)))
    }

    /// Which of `count` scenes.
    fn scene_index(self, count: usize) -> usize {
        if count == 1 {
            return 0;
        }
        let index = (count as f64 * unit(self.scene_hash())).floor() as usize;
        if index < count { index } else { 0 }
    }

    /// Offset of object `k` from the vertex, m.
    fn displacement(self, object: &SceneObject, k: u32) -> Vec2 {
        let base = object.frame.origin;
        let along = |salt, reach: f32, base: f32| {
            if reach <= 0.0 {
                base
            } else {
                (self.unit(salt, k) * f64::from(reach) + f64::from(base)) as f32
            }
        };
        let x = along(salt::DISPLACE_X, object.displace_x, base.x);
        let y = along(salt::DISPLACE_Y, object.displace_y, base.y);
        let quadrant = unit(self.quadrant_hash());
        if quadrant >= 0.75 {
            Vec2::new(y, -x)
        } else if quadrant >= 0.5 {
            Vec2::new(-x, -y)
        } else if quadrant >= 0.25 {
            Vec2::new(-y, x)
        } else {
            Vec2::new(x, y)
        }
    }

    fn scale(self, object: &SceneObject, k: u32) -> f32 {
        let (min, max) = (object.min_scale, object.max_scale);
        if min == max {
            return max;
        }
        let ratio = f64::from(max / min);
        (libm::pow(ratio, self.unit(salt::SCALE, k)) * f64::from(min)) as f32
    }
}

fn unit(hash: u32) -> f64 {
    f64::from(hash) * UNIT
}

/// What the terrain of a block asks for, in the order of the specification (15.2).
///
/// `scene` looks a scene record up; `has_building` tells whether outdoor cell 0..64 has a building.
pub fn scenery(
    terrain: &TerrainBlock,
    region: &Region,
    mut scene: impl FnMut(u32) -> Option<Arc<Scene>>,
    has_building: impl Fn(usize) -> bool,
    profile: &Profile,
) -> Vec<SceneryPlacement> {
    let mut placements = Vec::new();
    for vertex in 0..VERTICES {
        let (i, j) = (vertex / VERTICES_PER_SIDE, vertex % VERTICES_PER_SIDE);
        let draws = Draws::new(LandCoord {
            x: terrain.block().block_x() * 8 + i as i32,
            y: terrain.block().block_y() * 8 + j as i32,
        });
        let Some(scenes) = scenes_of(region, terrain.words()[vertex]) else {
            continue;
        };
        let Some(scene) = scene(scenes[draws.scene_index(scenes.len())]) else {
            continue;
        };
        let corner = Vec2::new(i as f32 * CELL_LENGTH, j as f32 * CELL_LENGTH);
        for (k, object) in scene.objects.iter().enumerate() {
            let placed = place(terrain, object, k as u32, draws, corner, profile)
                .filter(|placed| !has_building(placed.cell));
            placements.extend(placed);
        }
    }
    placements
}

/// Scenes of a terrain word; `None` for words and records that name none.
fn scenes_of(region: &Region, word: u16) -> Option<&[u32]> {
    let terrain = region.terrain_types.get(usize::from(terrain_type(word)))?;
    let index = *terrain.scene_types.get(usize::from(scene_type(word)))?;
    let scenes = &region.scene_types.get(usize::try_from(index).ok()?)?.scenes;
    (!scenes.is_empty()).then_some(scenes)
}

fn place(
    terrain: &TerrainBlock,
    object: &SceneObject,
    k: u32,
    draws: Draws,
    corner: Vec2,
    profile: &Profile,
) -> Option<SceneryPlacement> {
    let chosen = draws.unit(salt::FREQUENCY, k) < f64::from(object.frequency);
    if !chosen || object.weenie != 0 {
        return None;
    }
    let displaced = draws.displacement(object, k);
    let (x, y) = (corner.x + displaced.x, corner.y + displaced.y);
    if x < 0.0
        || y < 0.0
        || x >= BLOCK_LENGTH
        || y >= BLOCK_LENGTH
        || on_road(terrain.words(), x, y)
    {
        return None;
    }
    let mut origin = Vec3::new(x, y, object.frame.origin.z);
    let cell = terrain.cell_index(terrain.block().adjust_to_outside(origin, profile).0)?;
    debug_assert!(cell < CELLS);
    let normal_and_height = terrain.find_terrain_poly(cell, origin)?.1.plane;
    let n = normal_and_height.n;
    let level_enough = object.min_slope <= n.z && n.z <= object.max_slope;
    if !level_enough {
        return None;
    }
    origin.z = normal_and_height.height_at(origin).unwrap_or(origin.z);
    let mut frame = Frame::new(origin, object.frame.rotation);
    if object.align != 0 {
        frame.set_heading(heading_of_vector(-n, profile), profile);
    } else if object.max_rotation > 0.0 {
        let degrees = draws.unit(salt::ROTATION, k) * f64::from(object.max_rotation);
        frame.set_heading(degrees as f32, profile);
    }
    Some(SceneryPlacement {
        model: object.model,
        frame,
        cell,
        scale: draws.scale(object, k),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worked_hashes() {
        let rows: [(i32, i32, [u32; 7]); 6] = [
            (
                0,
                0,
                [
                    0x7F8C_DA01,
                    0xF4D7_C05F,
                    0x7EF7_8C75,
                    0x3707_3047,
                    0xCB3B_010F,
                    0x55EC_1E19,
                    0xE803_1203,
                ],
            ),
            (
                1,
                0,
                [
                    0x3D70_F644,
                    0xB2BB_DCA2,
                    0x3CDB_A8B8,
                    0xF4EB_4C8A,
                    0x891F_1D52,
                    0x13D0_3A5C,
                    0xA5E7_2E46,
                ],
            ),
            (
                0,
                1,
                [
                    0xEBA7_9F88,
                    0x60F2_85E6,
                    0xEB12_51FC,
                    0xA321_F5CE,
                    0x3755_C696,
                    0xC206_E3A0,
                    0x541D_D78A,
                ],
            ),
            (
                8,
                8,
                [
                    0x6F4E_CA91,
                    0xED43_446F,
                    0x2436_8205,
                    0x4925_7E57,
                    0x213A_111F,
                    0x7090_44A9,
                    0x5903_C713,
                ],
            ),
            (
                1352,
                1440,
                [
                    0x4B26_1039,
                    0x16DC_1C97,
                    0x3666_E6AD,
                    0x0A36_D47F,
                    0x6DF7_4D47,
                    0xE9BE_0C51,
                    0xAA2A_023B,
                ],
            ),
            (
                2039,
                2039,
                [
                    0xC8A4_F040,
                    0xC6DA_954C,
                    0xE976_9D08,
                    0x5D49_CCDC,
                    0xDFB1_932C,
                    0xEE51_00B0,
                    0x6FF4_78F4,
                ],
            ),
        ];
        for (x, y, expected) in rows {
            let d = Draws::new(LandCoord { x, y });
            let found = [
                d.scene_hash(),
                d.object_hash(salt::FREQUENCY),
                d.object_hash(salt::DISPLACE_X),
                d.object_hash(salt::DISPLACE_Y),
                d.object_hash(salt::ROTATION),
                d.object_hash(salt::SCALE),
                d.quadrant_hash(),
            ];
            assert_eq!(found, expected, "({x}, {y})");
        }
    }

    #[test]
    fn the_scene_index_at_a_sensitive_vertex() {
        // With 2^-32 in place of the f64 constant the index would be one higher here.
        let d = Draws::new(LandCoord { x: 1082, y: 768 });
        let exact = f64::from(d.scene_hash()) / 4_294_967_296.0;
        assert_eq!(d.scene_index(8) + 1, (8.0 * exact).floor() as usize);
    }
}
