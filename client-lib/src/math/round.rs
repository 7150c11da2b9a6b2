//! Rounding down without a library call: most processors that we build for are not known to have an instruction for it.

/// `f32::floor`, bit for bit.
#[inline]
pub fn floor(v: f32) -> f32 {
    // From 2^23 on every number is an integer. Not a number stays.
    if v.is_nan() || v.abs() >= 8_388_608.0 {
        return v;
    }
    let towards_zero = v as i32 as f32;
    let below = if towards_zero > v {
        towards_zero - 1.0
    } else {
        towards_zero
    };
    // Minus zero stays.
    below.copysign(v)
}

/// `f64::floor`, bit for bit.
#[inline]
pub fn floor64(v: f64) -> f64 {
    if v.is_nan() || v.abs() >= 4_503_599_627_370_496.0 {
        return v;
    }
    let towards_zero = v as i64 as f64;
    let below = if towards_zero > v {
        towards_zero - 1.0
    } else {
        towards_zero
    };
    below.copysign(v)
}

#[cfg(test)]
mod tests {
    use super::{floor, floor64};
    use proptest::prelude::*;

    #[test]
    fn zeros_and_borders() {
        for v in [
            0.0,
            -0.0,
            0.5,
            -0.5,
            1.0,
            -1.0,
            8_388_607.5,
            -8_388_607.5,
            8_388_608.0,
            f32::INFINITY,
            f32::MIN_POSITIVE,
            -1e-40,
        ] {
            assert_eq!(floor(v).to_bits(), v.floor().to_bits(), "{v}");
            let v = f64::from(v);
            assert_eq!(floor64(v).to_bits(), v.floor().to_bits(), "{v}");
        }
        assert!(floor(f32::NAN).is_nan() && floor64(f64::NAN).is_nan());
    }

    proptest! {
        #[test]
        fn same_as_the_library(bits in any::<u32>(), wide in any::<u64>()) {
            let v = f32::from_bits(bits);
            prop_assert!(v.is_nan() || floor(v).to_bits() == v.floor().to_bits());
            let v = f64::from_bits(wide);
            prop_assert!(v.is_nan() || floor64(v).to_bits() == v.floor().to_bits());
        }
    }
}
