//! Trigonometry in `f64`, rounded once to `f32`, and conversions between degrees and radians (`spec/01`, 3.1).

/// Degrees per radian in f64.
pub const DEGREES_PER_RADIAN: f64 = 180.0 / core::f64::consts::PI;
/// Radians per degree in f64.
pub const RADIANS_PER_DEGREE: f64 = core::f64::consts::PI / 180.0;
/// Degrees per radian as the f32 that profile `gdle` multiplies by.
pub const DEGREES_PER_RADIAN_F32: f32 = f32::from_bits(0x4265_2EE0);
/// Radians per degree as the f32 that profile `gdle` multiplies by.
pub const RADIANS_PER_DEGREE_F32: f32 = f32::from_bits(0x3C8E_FA35);

/// Sine of an angle in radians.
pub fn sin(x: f32) -> f32 {
    libm::sin(f64::from(x)) as f32
}

/// Cosine of an angle in radians.
pub fn cos(x: f32) -> f32 {
    libm::cos(f64::from(x)) as f32
}

/// Arc sine in radians; NaN outside [−1, 1].
pub fn asin(x: f32) -> f32 {
    libm::asin(f64::from(x)) as f32
}

/// Arc cosine in radians; NaN outside [−1, 1].
pub fn acos(x: f32) -> f32 {
    libm::acos(f64::from(x)) as f32
}

/// Angle of the vector (x, y) in radians, in [−π, π].
pub fn atan2(y: f32, x: f32) -> f32 {
    libm::atan2(f64::from(y), f64::from(x)) as f32
}

/// Radians to degrees by the f64 factor (`deg32`).
pub fn degrees(radians: f32) -> f32 {
    (DEGREES_PER_RADIAN * f64::from(radians)) as f32
}

/// Degrees to radians by the f64 factor (`rad32`).
pub fn radians(degrees: f32) -> f32 {
    (RADIANS_PER_DEGREE * f64::from(degrees)) as f32
}
