//! Which ground lets an object move (`spec/08-motion.md`, section 16).

use super::constants::{FLOOR_Z, FLOOR_Z_F64};
use crate::profile::{Profile, Width};

/// Whether ground with a unit normal of this z is walkable: 48.381° or flatter (`D32`, alias `T-12`).
pub fn is_walkable(normal_z: f32, profile: &Profile) -> bool {
    match profile.floor_z {
        Width::F32 => normal_z >= FLOOR_Z,
        Width::F64 => f64::from(normal_z) >= FLOOR_Z_F64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_differ_for_one_number_only() {
        let (retail, gdle) = (Profile::retail(), Profile::gdle());
        assert!(is_walkable(FLOOR_Z, &retail) && !is_walkable(FLOOR_Z, &gdle));
        for (z, walkable) in [
            (FLOOR_Z.next_up(), true),
            (FLOOR_Z.next_down(), false),
            (1.0, true),
            (-1.0, false),
            (f32::NAN, false),
        ] {
            assert_eq!(is_walkable(z, &retail), walkable);
            assert_eq!(is_walkable(z, &gdle), walkable);
        }
    }
}
