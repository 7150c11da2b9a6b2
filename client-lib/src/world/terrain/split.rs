//! Direction of the diagonal of a terrain square (`spec/02-terrain.md`, section 7).

use crate::math::LandCoord;

/// Whether the two triangles of an outdoor cell meet along the diagonal from south-west to north-east (otherwise south-east to north-west).
///
/// The references test a product with 2^-32 against one half; over the whole map that is bit 31 (7.3).
pub const fn is_sw_to_ne_cut(cell: LandCoord) -> bool {
    hash(cell) & 0x8000_0000 != 0
}

/// The hash whose top bit decides.
const fn hash(cell: LandCoord) -> u32 {
    let (x, y) = (cell.x as u32, cell.y as u32);
    y.wrapping_mul(x.wrapping_mul(0x0CCA_C033).wrapping_add(0x6C1A_C587))
        .wrapping_sub(x.wrapping_mul(0x421B_E3BD))
        .wrapping_sub(0x519B_8F25)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worked_values() {
        for (x, y, expected) in [
            (0, 0, 0xAE64_70DB),
            (1, 0, 0x6C48_8D1E),
            (0, 1, 0x1A7F_3662),
            (8, 8, 0x310B_8BEB),
            (1352, 1440, 0xC15B_D913),
            (2039, 2039, 0x3846_F0E4),
        ] {
            assert_eq!(hash(LandCoord { x, y }), expected, "({x}, {y})");
        }
    }

    #[test]
    fn every_cell_of_the_map() {
        let (mut fnv, mut cut) = (0xCBF2_9CE4_8422_2325_u64, 0);
        for x in 0..2040 {
            for y in 0..2040 {
                let bit = u64::from(is_sw_to_ne_cut(LandCoord { x, y }));
                cut += bit;
                fnv = (fnv ^ bit).wrapping_mul(0x0000_0100_0000_01B3);
            }
        }
        assert_eq!(cut, 2_081_396);
        assert_eq!(fnv, 0xAC54_B55E_F3FB_954F);
    }

    #[test]
    fn the_top_bit_is_the_comparison_of_the_references() {
        for x in (0..2040).step_by(7) {
            for y in (0..2040).step_by(3) {
                let cell = LandCoord { x, y };
                let below_half = f64::from(hash(cell)) * 2.3283064e-10 < 0.5;
                assert_eq!(is_sw_to_ne_cut(cell), !below_half);
            }
        }
    }
}
