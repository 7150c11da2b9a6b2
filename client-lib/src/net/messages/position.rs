//! The position pack (`spec/10-messages.md`, 5).

use super::common::{Origin, WirePosition};
use super::wire::{ReadError, Reader, Wire, Writer};

/// A position event's content. A component of the rotation that is exactly 0 may be left out; the bits say which ones were.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PositionPack {
    /// Bits 0x08, 0x10, 0x20, 0x40: w, x, y, z are left out; 0x04 contact; bits above 0x7F are kept.
    flags: u32,
    /// Place.
    pub position: WirePosition,
    /// World axes, m/s.
    pub velocity: Option<[f32; 3]>,
    /// Placement frame.
    pub placement: Option<u32>,
    /// Instance, position, teleport and force-position stamps.
    pub stamps: PositionStamps,
}

super::wire::wire_struct! {
    /// The four stamps of a position event.
    #[derive(Copy, Eq)]
    pub struct PositionStamps {
        /// Instance.
        instance: u16,
        /// Position.
        position: u16,
        /// Teleport.
        teleport: u16,
        /// Force position.
        force: u16,
    }
}

const VELOCITY: u32 = 0x01;
const PLACEMENT: u32 = 0x02;
const CONTACT: u32 = 0x04;
const NO_W: u32 = 0x08;
const KNOWN: u32 = 0x7F;

impl PositionPack {
    /// A pack to send: components that are zero are left out.
    pub fn new(position: WirePosition, contact: bool, stamps: PositionStamps) -> Self {
        let mut flags = if contact { CONTACT } else { 0 };
        for (i, value) in position.rotation.into_iter().enumerate() {
            if value == 0.0 {
                flags |= NO_W << i;
            }
        }
        Self {
            flags,
            position,
            velocity: None,
            placement: None,
            stamps,
        }
    }

    /// The same with every component of the rotation written.
    #[must_use]
    pub fn with_all_components(mut self) -> Self {
        self.flags &= !(NO_W * 15);
        self
    }

    /// The object stands on the ground.
    pub const fn contact(&self) -> bool {
        self.flags & CONTACT != 0
    }

    /// Bits that no layout knows.
    pub const fn unknown_bits(&self) -> u32 {
        self.flags & !KNOWN
    }
}

impl Wire for PositionPack {
    const MIN: usize = 28;

    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let flags = r.get::<u32>()?;
        let Origin { cell, origin } = r.get()?;
        let mut rotation = [0.0; 4];
        for (i, value) in rotation.iter_mut().enumerate() {
            if flags & NO_W << i == 0 {
                *value = r.get()?;
            }
        }
        let has = |bit| flags & bit != 0;
        Ok(Self {
            flags: flags & !(VELOCITY | PLACEMENT),
            position: WirePosition {
                cell,
                origin,
                rotation,
            },
            velocity: if has(VELOCITY) { Some(r.get()?) } else { None },
            placement: if has(PLACEMENT) { Some(r.get()?) } else { None },
            stamps: r.get()?,
        })
    }

    fn write(&self, w: &mut Writer) {
        let mut flags = self.flags & !(VELOCITY | PLACEMENT);
        if self.velocity.is_some() {
            flags |= VELOCITY;
        }
        if self.placement.is_some() {
            flags |= PLACEMENT;
        }
        flags.write(w);
        self.position.cell.write(w);
        self.position.origin.write(w);
        for (i, value) in self.position.rotation.iter().enumerate() {
            if flags & NO_W << i == 0 {
                value.write(w);
            }
        }
        if let Some(velocity) = &self.velocity {
            velocity.write(w);
        }
        if let Some(placement) = &self.placement {
            placement.write(w);
        }
        self.stamps.write(w);
    }
}
