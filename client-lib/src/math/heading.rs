//! Headings: compass degrees, clockwise from north, in [0, 360) (`spec/01`, section 8).

use super::Vec3;
use super::frame::{Frame, yaw_pitch_roll};
use super::trig::{self, DEGREES_PER_RADIAN_F32, RADIANS_PER_DEGREE_F32, asin, atan2};
use super::vector::normalize_check_small;
use crate::profile::{HeadingArithmetic, Profile};

/// Mathematical angle of (x, y) in degrees.
fn angle_degrees(y: f32, x: f32, profile: &Profile) -> f32 {
    let radians = atan2(y, x);
    match profile.heading_arithmetic {
        HeadingArithmetic::F64Factor => trig::degrees(radians),
        HeadingArithmetic::F32Factor => radians * DEGREES_PER_RADIAN_F32,
    }
}

/// Heading of a direction; 0 when its horizontal part is shorter than ε (8.2).
pub fn heading_of_vector(v: Vec3, profile: &Profile) -> f32 {
    match normalize_check_small(Vec3::new(v.x, v.y, 0.0)) {
        None => 0.0,
        Some(u) => (450.0 - angle_degrees(u.y, u.x, profile)) % 360.0,
    }
}

/// Heading from one position to another, given the offset between them (11.1): as [`heading_of_vector`], but profile `gdle` subtracts and
/// takes the remainder in f64 here (`01:F13`).
pub fn heading_of_position_offset(v: Vec3, profile: &Profile) -> f32 {
    match (
        normalize_check_small(Vec3::new(v.x, v.y, 0.0)),
        profile.heading_arithmetic,
    ) {
        (None, _) => 0.0,
        (Some(u), HeadingArithmetic::F64Factor) => {
            (450.0 - angle_degrees(u.y, u.x, profile)) % 360.0
        }
        (Some(u), HeadingArithmetic::F32Factor) => {
            ((450.0 - f64::from(angle_degrees(u.y, u.x, profile))) % 360.0) as f32
        }
    }
}

impl Frame {
    /// Heading of the forward direction, compass degrees in [0, 360) (8.1).
    pub fn heading(&self, profile: &Profile) -> f32 {
        let forward = self.forward(profile);
        (450.0 - angle_degrees(forward.y, forward.x, profile)) % 360.0
    }

    /// Turns to a heading in compass degrees; any finite number is accepted (8.3).
    pub fn set_heading(&mut self, degrees: f32, profile: &Profile) {
        let angle = match profile.heading_arithmetic {
            HeadingArithmetic::F64Factor => trig::radians(degrees),
            HeadingArithmetic::F32Factor => degrees * RADIANS_PER_DEGREE_F32,
        };
        let [r0, r1, _] = self.axes(profile);
        self.set_vector_heading(
            Vec3::new(trig::sin(angle), trig::cos(angle), r1.z + r0.z),
            profile,
        );
    }

    /// Turns the forward direction along `heading`, with the roll set to 0; nothing changes if `heading` is shorter than ε (8.4).
    pub fn set_vector_heading(&mut self, heading: Vec3, profile: &Profile) {
        let Some(n) = normalize_check_small(heading) else {
            return;
        };
        let angle = 450.0 - angle_degrees(n.y, n.x, profile);
        let az = match profile.heading_arithmetic {
            HeadingArithmetic::F64Factor => -trig::radians(angle % 360.0),
            HeadingArithmetic::F32Factor => {
                -((f64::from(angle) % 360.0) * f64::from(RADIANS_PER_DEGREE_F32)) as f32
            }
        };
        let ax = asin(n.z);
        if profile.vector_heading_pitches_y {
            self.set_rotation(yaw_pitch_roll(ax, 0.0, az), profile);
        } else {
            self.set_rotation_euler(Vec3::new(ax, 0.0, az), profile);
        }
    }
}
