//! Where immutable resources come from.

use std::sync::Arc;

use crate::dat::{Animation, MotionTable, Setup};
use crate::physics::collision::GfxShape;

/// Looks up the records that animation needs, loading them if necessary. `None`: there is no such record, or it cannot be read.
///
/// The world's resource cache implements this. It is asked when a motion starts or a part array is made, never during a tick.
pub trait AnimationSource {
    /// An animation, 0x03......
    fn animation(&mut self, id: u32) -> Option<Arc<Animation>>;
    /// A motion table, 0x09......
    fn motion_table(&mut self, id: u32) -> Option<Arc<MotionTable>>;
    /// A setup, 0x02......
    fn setup(&mut self, id: u32) -> Option<Arc<Setup>>;
    /// The shape of a part, 0x01......
    fn shape(&mut self, id: u32) -> Option<Arc<GfxShape>>;
}
