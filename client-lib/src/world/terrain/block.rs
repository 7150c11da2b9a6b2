//! The terrain of one landblock as triangles (`spec/02-terrain.md`, sections 5 to 8 and 10).

use super::water::{cell_index, is_water};
use super::{
    CELLS, Detail, DetailScale, HeightTable, VERTICES, VERTICES_PER_SIDE, WaterType, detail,
    is_sw_to_ne_cut,
};
use crate::math::vector::normalize;
use crate::math::{BLOCK_LENGTH, CellId, Direction, LandCoord, Plane, Vec3};
use crate::physics::collision::Polygon;
use crate::profile::Profile;

/// What the landblock record says of its 81 vertices.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TerrainVertices {
    /// Indices into the height table.
    pub heights: [u8; VERTICES],
    /// Terrain words: road, terrain type, scene type.
    pub words: [u16; VERTICES],
}

/// Half of a terrain square, in block space (m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triangle {
    /// Its plane; the normal points up.
    pub plane: Plane,
    /// Corners, counter-clockwise from above.
    pub vertices: [Vec3; 3],
}

impl Triangle {
    /// A triangle with its plane (8.2): sum of cross products, normalised, offset averaged over the corners.
    pub fn new(vertices: [Vec3; 3], profile: &Profile) -> Self {
        let [a, b, c] = vertices;
        let n = normalize(Vec3::ZERO + (b - a).cross(c - a), profile);
        let sum = ((0.0 + n.dot(a)) + n.dot(b)) + n.dot(c);
        Self {
            plane: Plane { n, d: -(sum / 3.0) },
            vertices,
        }
    }

    /// The triangle as a collision polygon.
    pub fn polygon(&self) -> Polygon<'_> {
        Polygon {
            plane: self.plane,
            vertices: &self.vertices,
            single_sided: true,
        }
    }

    /// Whether (x, y) of a point is inside or on an edge (10.1, positive side). A NaN point is inside: no comparison is true.
    pub fn contains(&self, point: Vec3) -> bool {
        let mut prev = self.vertices[0];
        for cur in [self.vertices[2], self.vertices[1], self.vertices[0]] {
            let (dx, dy) = (cur.x - prev.x, cur.y - prev.y);
            let s = ((dy * cur.x - dx * cur.y) + dx * point.y) - dy * point.x;
            if s > 0.0 {
                return false;
            }
            prev = cur;
        }
        true
    }
}

/// Terrain of one landblock, in its own space (m).
#[derive(Debug, Clone)]
pub struct TerrainBlock {
    pub(crate) block: CellId,
    pub(crate) source: TerrainVertices,
    pub(crate) detail: Option<Detail>,
    /// Index `i * (side + 1) + j`.
    pub(crate) vertices: Vec<Vec3>,
    /// Index `2 * (x * side + y) + k`.
    pub(crate) triangles: Vec<Triangle>,
    /// Bit `x * side + y`: the square is cut from south-west to north-east.
    pub(crate) cuts: u64,
    pub(crate) cell_water: [WaterType; CELLS],
    pub(crate) block_water: WaterType,
}

impl TerrainBlock {
    /// The terrain of a landblock at full detail. `block` is any id of the landblock.
    pub fn new(
        block: CellId,
        source: TerrainVertices,
        table: &HeightTable,
        profile: &Profile,
    ) -> Self {
        let mut terrain = Self {
            block,
            source,
            detail: None,
            vertices: Vec::new(),
            triangles: Vec::new(),
            cuts: 0,
            cell_water: [WaterType::None; CELLS],
            block_water: WaterType::None,
        };
        terrain.generate(Detail::FULL, table, profile);
        terrain
    }

    /// Builds vertices and triangles for a level of detail (5). Answers whether the squares were made anew; `false` also when nothing
    /// changed or only heights and planes did.
    pub fn generate(&mut self, detail: Detail, table: &HeightTable, profile: &Profile) -> bool {
        if self.detail == Some(detail) {
            return false;
        }
        let rebuilt = self.detail.map(|d| d.scale) != Some(detail.scale);
        self.detail = Some(detail);
        self.place_vertices(detail, table);
        self.make_triangles(detail.scale, profile);
        self.calc_water(detail.scale);
        rebuilt
    }

    fn place_vertices(&mut self, detail: Detail, table: &HeightTable) {
        let (scale, side) = (detail.scale.cells(), detail.scale.squares_per_side());
        let step = BLOCK_LENGTH / side as f32;
        let heights = &self.source.heights;
        self.vertices.clear();
        for i in 0..=side {
            for j in 0..=side {
                let z = table.height(heights[(i * VERTICES_PER_SIDE + j) * scale]);
                self.vertices
                    .push(Vec3::new(i as f32 * step, j as f32 * step, z));
            }
        }
        if detail.direction != Direction::Inside && side > 1 && side < 8 {
            detail::stitch(&mut self.vertices, detail, heights, table);
        }
    }

    /// Triangles with corners counter-clockwise from above (8.1). A coarse square has the cut of the full-detail cell of the same number.
    fn make_triangles(&mut self, scale: DetailScale, profile: &Profile) {
        let side = scale.squares_per_side();
        let base = LandCoord {
            x: self.block.block_x() * 8,
            y: self.block.block_y() * 8,
        };
        self.triangles.clear();
        self.cuts = 0;
        for x in 0..side {
            for y in 0..side {
                let cut = is_sw_to_ne_cut(LandCoord {
                    x: base.x + x as i32,
                    y: base.y + y as i32,
                });
                self.cuts |= u64::from(cut) << (x * side + y);
                let at = |i: usize, j: usize| self.vertices[(x + i) * (side + 1) + y + j];
                let (sw, se, ne, nw) = (at(0, 0), at(1, 0), at(1, 1), at(0, 1));
                let corners = if cut {
                    [[sw, se, ne], [sw, ne, nw]]
                } else {
                    [[sw, se, nw], [ne, nw, se]]
                };
                for triangle in corners {
                    self.triangles.push(Triangle::new(triangle, profile));
                }
            }
        }
    }

    fn calc_water(&mut self, scale: DetailScale) {
        self.cell_water = [WaterType::None; CELLS];
        self.block_water = WaterType::None;
        if !self.source.words.iter().any(|&word| is_water(word)) {
            return;
        }
        if scale != DetailScale::Full {
            return;
        }
        for (index, water) in self.cell_water.iter_mut().enumerate() {
            let sw = index / 8 * VERTICES_PER_SIDE + index % 8;
            let corners = [
                sw,
                sw + 1,
                sw + VERTICES_PER_SIDE,
                sw + VERTICES_PER_SIDE + 1,
            ];
            *water = WaterType::of_corners(corners.map(|v| self.source.words[v]));
        }
        self.block_water = WaterType::of_cells(&self.cell_water);
    }

    /// An id of the landblock.
    pub fn block(&self) -> CellId {
        self.block
    }

    /// Height indices and terrain words of the record.
    pub fn source(&self) -> &TerrainVertices {
        &self.source
    }

    /// The 81 terrain words.
    pub fn words(&self) -> &[u16; VERTICES] {
        &self.source.words
    }

    /// Current level of detail.
    pub fn detail(&self) -> Detail {
        self.detail.unwrap_or(Detail::FULL)
    }

    /// Whether the block has cells to be in.
    pub fn is_full_detail(&self) -> bool {
        self.detail().scale == DetailScale::Full
    }

    /// Vertices, index `i * (side + 1) + j`.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// Triangles, index `2 * (x * side + y) + k`.
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// Whether square `index` is cut from south-west to north-east.
    pub fn is_sw_to_ne_cut(&self, index: usize) -> bool {
        self.cuts >> index & 1 != 0
    }

    /// Water of outdoor cell `index` (0..64).
    pub fn cell_water(&self, index: usize) -> WaterType {
        self.cell_water.get(index).copied().unwrap_or_default()
    }

    /// Water of the whole block.
    pub fn block_water(&self) -> WaterType {
        self.block_water
    }

    /// Id of outdoor cell `index` (0..64) of this block.
    pub fn cell_id(&self, index: usize) -> CellId {
        self.block.with_low(index as u32 + 1)
    }

    /// Index of an outdoor cell of this block; `None` for other ids and at reduced detail.
    pub fn cell_index(&self, id: CellId) -> Option<usize> {
        if !id.same_block(self.block) || !self.is_full_detail() {
            return None;
        }
        cell_index(id)
    }

    /// The triangle of full-detail cell `index` (0..64) below or above a point (m, block space): the first if the point is in both (10.2).
    /// Also answers whether it is the first (0) or second (1).
    pub fn find_terrain_poly(&self, index: usize, point: Vec3) -> Option<(usize, &Triangle)> {
        let pair = self.triangles.get(2 * index..2 * index + 2)?;
        pair.iter()
            .enumerate()
            .find(|(_, triangle)| triangle.contains(point))
    }

    /// Height of the terrain at (x, y) of a point (m, block space), in the outdoor cell that the point is in; `None` outside the block.
    pub fn height_at(&self, point: Vec3, profile: &Profile) -> Option<f32> {
        let cell = self
            .block
            .outside_coord(point.x, point.y, profile)?
            .cell_id();
        let index = self.cell_index(cell)?;
        self.find_terrain_poly(index, point)?
            .1
            .plane
            .height_at(point)
    }

    /// Lowest and highest vertex height, m.
    pub fn height_limits(&self) -> (f32, f32) {
        self.vertices
            .iter()
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| {
                (low.min(v.z), high.max(v.z))
            })
    }
}
