//! The last cell list of a transition, and how far the mover may go until the list could be another.
//!
//! A transition makes its list several times within a few centimetres: after the step, after it was lowered, after it was lifted. Indoors every
//! question that a list asks is how far a place is from a plane. Until the mover has gone as far as the nearest of those distances, and a margin
//! that is wider than rounding, every answer is the same, and so is the list, which is still there.

use super::cell_list::{CellListOutcome, SpheresAt};
use crate::math::{CellId, Sphere, Vec3};

/// What the list was made of, and what it answered.
#[derive(Debug, Clone, Copy)]
pub struct CellListMemo {
    start: CellId,
    want_current: bool,
    count: usize,
    spheres: [Sphere; 2],
    outcome: CellListOutcome,
}

impl CellListMemo {
    /// Remembers a list; `None` if it holds for no other place.
    pub(super) fn new(at: SpheresAt<'_>, outcome: CellListOutcome) -> Option<Self> {
        let holds = outcome.holds_within > 0.0 && outcome.missing.0.is_none();
        if !holds || at.spheres.len() > 2 {
            return None;
        }
        let mut spheres = [Sphere::new(Vec3::ZERO, 0.0); 2];
        spheres[..at.spheres.len()].copy_from_slice(at.spheres);
        Some(Self {
            start: at.position.cell,
            want_current: at.want_current,
            count: at.spheres.len(),
            spheres,
            outcome,
        })
    }

    /// What the list answered, if it is the same at this place.
    pub(super) fn answer(&self, at: SpheresAt<'_>) -> Option<CellListOutcome> {
        let reach = self.outcome.holds_within;
        let same = self.start == at.position.cell
            && self.want_current == at.want_current
            && self.count == at.spheres.len()
            && self.spheres.iter().zip(at.spheres).all(|(then, now)| {
                let gone = (now.center - then.center).length_squared();
                then.radius.to_bits() == now.radius.to_bits() && gone < reach * reach
            });
        same.then_some(self.outcome)
    }
}
