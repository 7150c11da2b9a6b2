//! [`World`] owns everything; entities, statics and cells are handles into it.

use crate::profile::Profile;

/// Handle of a loaded cell (outdoor or indoor) of a [`World`]. Cells stay loaded under a handle until their landblock is released.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct CellHandle(pub u32);

/// Everything that exists: landscape, static objects, entities, clocks and the behaviour profile.
///
/// Iteration order is creation order: the same inputs always give the same bits.
#[derive(Debug)]
pub struct World {
    /// Behaviour at every numbered point of difference.
    pub profile: Profile,
}
