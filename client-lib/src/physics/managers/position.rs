//! The position manager (F1).

use super::constraint::ConstraintManager;
use super::interpolation::InterpolationManager;
use super::sticky::StickyManager;
use crate::profile::Profile;

/// Interpolation, sticky and constraint managers of one object; each made when first used.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PositionManager {
    /// Server positions.
    pub interpolation: Option<InterpolationManager>,
    /// Sticking to a target.
    pub sticky: Option<StickyManager>,
    /// The constraint.
    pub constraint: Option<ConstraintManager>,
}

impl PositionManager {
    /// Whether server positions are being followed.
    pub fn is_interpolating(&self) -> bool {
        self.interpolation
            .as_ref()
            .is_some_and(InterpolationManager::is_interpolating)
    }

    /// Whether the profile's interpolation has broken the object (`O-38`).
    pub fn is_broken(&self) -> bool {
        self.interpolation.as_ref().is_some_and(|i| i.broken)
    }

    /// Whether nine tenths of the constrained way are used up.
    pub fn is_fully_constrained(&self, profile: &Profile) -> bool {
        self.constraint
            .as_ref()
            .is_some_and(|c| c.is_fully_constrained(profile))
    }

    /// GUID of the sticky target; 0 without one.
    pub fn sticky_target(&self) -> u32 {
        self.sticky.as_ref().map_or(0, |s| s.target_id)
    }
}
