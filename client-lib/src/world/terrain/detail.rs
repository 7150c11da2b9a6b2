//! Level of detail of a landblock in the client's window (`spec/02-terrain.md`, section 9).

use super::{HeightTable, VERTICES, VERTICES_PER_SIDE};
use crate::math::{Direction, Vec3};

/// Vertices left out along each side: a terrain square covers this many cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DetailScale {
    /// All vertices: the only one with cells to be in.
    #[default]
    Full = 1,
    /// Every second vertex.
    Half = 2,
    /// Every fourth.
    Quarter = 4,
    /// The four corners.
    Corners = 8,
}

/// Scale and direction of a block: what a terrain mesh is generated from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Detail {
    /// Vertices left out.
    pub scale: DetailScale,
    /// On which side coarser blocks lie.
    pub direction: Direction,
}

impl DetailScale {
    /// Cells of the full-detail block along a terrain square.
    pub const fn cells(self) -> usize {
        self as usize
    }

    /// Terrain squares along one side of the block.
    pub const fn squares_per_side(self) -> usize {
        8 / self.cells()
    }
}

impl Detail {
    /// What physics needs: all vertices. The direction has no effect then.
    pub const FULL: Self = Self {
        scale: DetailScale::Full,
        direction: Direction::Inside,
    };

    /// Scale and direction of the block at this offset (in blocks, eastwards and northwards) from the middle of the window (9.1).
    pub const fn at_offset(dx: i32, dy: i32) -> Self {
        let m = if dx.abs() > dy.abs() {
            dx.abs()
        } else {
            dy.abs()
        };
        let scale = match m {
            0 | 1 => DetailScale::Full,
            2 => DetailScale::Half,
            3 | 4 => DetailScale::Quarter,
            _ => DetailScale::Corners,
        };
        let direction = match scale {
            DetailScale::Corners => Direction::Inside,
            _ => direction_of(dx, dy, scale.cells() as i32),
        };
        Self { scale, direction }
    }
}

const fn direction_of(dx: i32, dy: i32, s: i32) -> Direction {
    let (north, south) = (dy == s, dy == -s);
    if dx == s {
        return if north {
            Direction::NorthEast
        } else if south {
            Direction::SouthEast
        } else {
            Direction::East
        };
    }
    if dx == -s {
        return if north {
            Direction::NorthWest
        } else if south {
            Direction::SouthWest
        } else {
            Direction::West
        };
    }
    if north {
        Direction::North
    } else if south {
        Direction::South
    } else {
        Direction::Inside
    }
}

/// Bends the outer edge of a finer block to its coarser neighbour, and lowers the inner edge under the full-detail ring (9.2, `TransAdjust`).
pub(super) fn stitch(
    vertices: &mut [Vec3],
    detail: Detail,
    heights: &[u8; VERTICES],
    table: &HeightTable,
) {
    use Direction::{East, North, NorthEast, NorthWest, South, SouthEast, SouthWest, West};
    let side = detail.scale.squares_per_side();
    let d = detail.direction;
    let at = |i: usize, j: usize| i * (side + 1) + j;
    for k in (1..side).step_by(2) {
        if matches!(d, North | NorthWest | NorthEast) {
            middle(vertices, at(k, side), at(k - 1, side), at(k + 1, side));
        }
    }
    for k in (1..side).step_by(2) {
        if matches!(d, West | NorthWest | SouthWest) {
            middle(vertices, at(0, k), at(0, k - 1), at(0, k + 1));
        }
    }
    for k in (1..side).step_by(2) {
        if matches!(d, South | SouthWest | SouthEast) {
            middle(vertices, at(k, 0), at(k - 1, 0), at(k + 1, 0));
        }
    }
    for k in (1..side).step_by(2) {
        if matches!(d, East | NorthEast | SouthEast) {
            middle(vertices, at(side, k), at(side, k - 1), at(side, k + 1));
        }
    }
    if side != 4 {
        return;
    }
    let h = |index: usize| table.height(heights[index]);
    const LAST: usize = VERTICES_PER_SIDE - 1;
    for k in [1, 3] {
        let f = 2 * k;
        match d {
            North => lower(&mut vertices[at(k, 0)], f, |t| h(t * VERTICES_PER_SIDE)),
            South => lower(&mut vertices[at(k, side)], f, |t| {
                h(t * VERTICES_PER_SIDE + LAST)
            }),
            East => lower(&mut vertices[at(0, k)], f, h),
            West => lower(&mut vertices[at(side, k)], f, |t| {
                h(LAST * VERTICES_PER_SIDE + t)
            }),
            _ => {}
        }
    }
}

fn middle(vertices: &mut [Vec3], k: usize, a: usize, b: usize) {
    vertices[k].z = (vertices[a].z + vertices[b].z) / 2.0;
}

/// Keeps a vertex below the extension of the full-detail edges on both of its sides.
fn lower(vertex: &mut Vec3, f: usize, h: impl Fn(usize) -> f32) {
    for extended in [
        (h(f - 1) + h(f - 1)) - h(f - 2),
        (h(f + 1) + h(f + 1)) - h(f + 2),
    ] {
        if extended < vertex.z {
            vertex.z = extended;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_of_the_window() {
        assert_eq!(Detail::at_offset(0, 0).scale, DetailScale::Full);
        assert_eq!(Detail::at_offset(-1, 1).direction, Direction::NorthWest);
        assert_eq!(Detail::at_offset(2, -2).direction, Direction::SouthEast);
        assert_eq!(Detail::at_offset(1, 2).direction, Direction::North);
        assert_eq!(Detail::at_offset(3, 0).direction, Direction::Inside);
        assert_eq!(Detail::at_offset(-4, 3).direction, Direction::West);
        let outer = Detail::at_offset(5, 4);
        assert_eq!(outer.scale.squares_per_side(), 1);
        assert_eq!(outer.direction, Direction::Inside);
    }
}
