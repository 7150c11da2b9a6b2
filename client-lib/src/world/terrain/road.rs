//! Roads (`spec/02-terrain.md`, section 14).

use super::{VERTICES, VERTICES_PER_SIDE, is_road};
use crate::math::CELL_LENGTH;

/// Half the width of a road, m.
const HALF_WIDTH: f32 = 5.0;

/// Whether the point (x, y), m in block space, in [0, 192) each, is on a road. Points outside the block are not.
pub fn on_road(words: &[u16; VERTICES], x: f32, y: f32) -> bool {
    if !(x >= 0.0 && y >= 0.0) {
        return false;
    }
    let (column, row) = ((x / CELL_LENGTH) as usize, (y / CELL_LENGTH) as usize);
    if column >= VERTICES_PER_SIDE - 1 || row >= VERTICES_PER_SIDE - 1 {
        return false;
    }
    let dx = x - column as f32 * CELL_LENGTH;
    let dy = y - row as f32 * CELL_LENGTH;
    let south_west = column * VERTICES_PER_SIDE + row;
    let corner = |offset| is_road(words[south_west + offset]);
    let corners = (
        corner(0),
        corner(1),
        corner(VERTICES_PER_SIDE),
        corner(VERTICES_PER_SIDE + 1),
    );
    in_strip(corners, dx, dy)
}

/// The table of section 14: corners in the order SW, NW, SE, NE; every comparison is strict.
fn in_strip(corners: (bool, bool, bool, bool), dx: f32, dy: f32) -> bool {
    const L: f32 = CELL_LENGTH;
    let r = HALF_WIDTH;
    let (west, east) = (dx < r, dx > L - r);
    let (south, north) = (dy < r, dy > L - r);
    match corners {
        (false, false, false, false) => false,
        (false, false, false, true) => L * 2.0 - dx - dy < r,
        (false, false, true, false) => L - dx + dy < r,
        (false, false, true, true) => east,
        (false, true, false, false) => L + dx - dy < r,
        (false, true, false, true) => north,
        (false, true, true, false) => (dx + dy - L).abs() < r,
        (false, true, true, true) => east || north,
        (true, false, false, false) => dx + dy < r,
        (true, false, false, true) => (dx - dy).abs() < r,
        (true, false, true, false) => south,
        (true, false, true, true) => east || south,
        (true, true, false, false) => west,
        (true, true, false, true) => west || north,
        (true, true, true, false) => west || south,
        (true, true, true, true) => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_road_is_ten_metres_wide() {
        let mut words = [0; VERTICES];
        for row in 0..VERTICES_PER_SIDE {
            words[3 * VERTICES_PER_SIDE + row] = 1;
        }
        assert!(on_road(&words, 72.0, 50.0) && on_road(&words, 76.9, 50.0));
        assert!(on_road(&words, 67.1, 50.0) && !on_road(&words, 67.0, 50.0));
        assert!(!on_road(&words, 77.0, 50.0) && !on_road(&words, 100.0, 50.0));
    }

    #[test]
    fn all_corners_cover_the_cell_and_none_leave_it_free() {
        let all = [3; VERTICES];
        let none = [0x7C; VERTICES];
        for (x, y) in [(0.0, 0.0), (191.9, 191.9), (12.0, 100.0)] {
            assert!(on_road(&all, x, y) && !on_road(&none, x, y));
        }
        for (x, y) in [
            (192.0, 1.0),
            (-0.1, 1.0),
            (f32::NAN, 1.0),
            (1.0, f32::INFINITY),
        ] {
            assert!(!on_road(&all, x, y), "outside the block");
        }
    }

    #[test]
    fn a_diagonal_road_joins_two_corners() {
        let mut words = [0; VERTICES];
        words[0] = 2;
        words[VERTICES_PER_SIDE + 1] = 2;
        assert!(on_road(&words, 12.0, 12.0) && on_road(&words, 14.0, 10.0));
        assert!(!on_road(&words, 20.0, 4.0));
    }
}
