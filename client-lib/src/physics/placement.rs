//! Placing and teleporting (`spec/06-physics-object.md`, C3, C4).

use bitflags::bitflags;

use crate::entity::Entity;
use crate::math::Position;
use crate::physics::transition::{Path, Transit, TransitionInput};
use crate::world::{CellHandle, World};

bitflags! {
    /// How an object is placed (A4.3). Only SLIDE, DONT_CREATE_CELLS, SCATTER and RANDOM_SCATTER influence a rule.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub struct PlacementFlags: u32 {
        /// First placement.
        const PLACEMENT = 0x0001;
        /// Teleport.
        const TELEPORT = 0x0002;
        /// Restored.
        const RESTORE = 0x0004;
        /// May be placed beside the wanted position.
        const SLIDE = 0x0010;
        /// Cells are not loaded for it.
        const DONT_CREATE_CELLS = 0x0020;
        /// Tries random places near by if the wanted one is taken.
        const SCATTER = 0x0100;
        /// Tries random places near by at once.
        const RANDOM_SCATTER = 0x0200;
        /// Along a line; not used.
        const LINE = 0x0400;
        /// Tell the server.
        const SEND_POSITION_EVENT = 0x1000;
        /// Bits without a name are kept.
        const _ = !0;
    }
}

/// What `SetPosition` answers (A4.3); the numbers are the client's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum SetPositionError {
    /// Placed, or lost because there is no such cell.
    Ok = 0,
    /// No transition to be had, or no try was made.
    GeneralFailure = 1,
    /// No room.
    NoValidPosition = 2,
    /// The placement has left all cells.
    NoCell = 3,
    /// Something was hit and reported.
    Collided = 4,
}

/// Arguments of a placement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetPosition {
    /// Where to.
    pub position: Position,
    /// How.
    pub flags: PlacementFlags,
    /// Range of the scatter along x, m.
    pub range_x: f32,
    /// Range of the scatter along y, m.
    pub range_y: f32,
    /// Tries of the scatter.
    pub tries: u32,
}

impl SetPosition {
    /// A placement without scatter.
    pub const fn new(position: Position, flags: PlacementFlags) -> Self {
        Self {
            position,
            flags,
            range_x: 0.0,
            range_y: 0.0,
            tries: 0,
        }
    }
}

/// Displacement along an axis that a placement without SLIDE may have, m; signed (C3).
const PLACEMENT_TOLERANCE: f32 = 0.05;

impl Entity {
    /// Places the object (`SetPosition`).
    pub fn set_position(&mut self, to: &SetPosition, world: &mut World) -> SetPositionError {
        let Some(mut transit) = world.slots.make(&world.profile) else {
            return SetPositionError::GeneralFailure;
        };
        let mut tries = Tries {
            transit: &mut transit,
            again: false,
        };
        let result = if to.flags.contains(PlacementFlags::RANDOM_SCATTER) {
            self.scatter(to, &mut tries, world)
        } else {
            match self.place(to.position, to, &mut tries, world) {
                error
                    if error != SetPositionError::Ok
                        && to.flags.contains(PlacementFlags::SCATTER) =>
                {
                    self.scatter(to, &mut tries, world)
                }
                result => result,
            }
        };
        world.slots.cleanup();
        world.slots.recycle(transit);
        result
    }

    /// Teleports the object, beside the wanted place if need be when `sliding` (`SetPositionSimple`).
    pub fn set_position_simple(
        &mut self,
        position: &Position,
        sliding: bool,
        world: &mut World,
    ) -> SetPositionError {
        let mut flags = PlacementFlags::TELEPORT | PlacementFlags::SEND_POSITION_EVENT;
        flags.set(PlacementFlags::SLIDE, sliding);
        self.set_position(&SetPosition::new(*position, flags), world)
    }

    /// Tries random places in a rectangle around the wanted one (`SetScatterPositionInternal`).
    fn scatter(
        &mut self,
        to: &SetPosition,
        tries: &mut Tries<'_>,
        world: &mut World,
    ) -> SetPositionError {
        let mut result = SetPositionError::GeneralFailure;
        for _ in 0..to.tries {
            let mut place = to.position;
            place.frame.origin.x += world.random.uniform() * to.range_x;
            place.frame.origin.y += world.random.uniform() * to.range_y;
            result = self.place(place, to, tries, world);
            if result == SetPositionError::Ok {
                break;
            }
        }
        result
    }

    /// One try (`SetPositionInternal` with a position).
    fn place(
        &mut self,
        mut place: Position,
        to: &SetPosition,
        tries: &mut Tries<'_>,
        world: &mut World,
    ) -> SetPositionError {
        let enters = self.body.cell.is_none();
        if enters {
            self.prepare_to_enter_world(world);
        }
        let slide = to.flags.contains(PlacementFlags::SLIDE);
        let do_not_load = to.flags.contains(PlacementFlags::DONT_CREATE_CELLS);
        let input = self.placement_input(None, &place, slide, do_not_load, world);
        let low = input
            .spheres
            .as_slice()
            .first()
            .map_or_else(Default::default, |s| s.center);
        let Some(cell) = world.adjust_position(&mut place, low, true) else {
            self.become_lost(&place, world);
            return SetPositionError::Ok;
        };
        let forced = self.body.weenie.storage || self.weenie.as_ref().is_some_and(|w| w.corpse);
        if forced {
            return self.force_into_cell(cell, &place, world);
        }
        let input = TransitionInput {
            begin_cell: Some(cell),
            path: Path::Place {
                at: place,
                slide,
                do_not_load_cells: do_not_load,
            },
            ..input
        };
        if !self.try_placement(&input, cell, &mut place, slide, tries, world) {
            let info = std::mem::take(&mut tries.transit.result.info);
            let collided = self.handle_all_collisions(&info, false, false, world);
            tries.transit.result.info = info;
            return if collided {
                SetPositionError::Collided
            } else {
                SetPositionError::NoValidPosition
            };
        }
        if tries.transit.result.cell.is_none() {
            return SetPositionError::NoCell;
        }
        let result = std::mem::take(&mut tries.transit.result);
        if enters && world.profile.server_scatter && !result.position.cell.same_block(place.cell) {
            // O-28: a spawn that ends in another landblock is refused.
            tries.transit.result = result;
            return SetPositionError::GeneralFailure;
        }
        self.set_position_internal(&result, world);
        tries.transit.result = result;
        SetPositionError::Ok
    }

    /// Whether the object fits at `place` (`CheckPositionInternal`). Without SLIDE it must not end up elsewhere; the test is signed, as the
    /// client's: any negative displacement passes, and z is not limited.
    fn try_placement(
        &mut self,
        input: &TransitionInput,
        cell: CellHandle,
        place: &mut Position,
        slide: bool,
        tries: &mut Tries<'_>,
        world: &mut World,
    ) -> bool {
        let found = if std::mem::replace(&mut tries.again, true) {
            world.run_transition_again(tries.transit, input)
        } else {
            world.run_transition(tries.transit, input)
        };
        if tries.transit.result.velocity_killed {
            self.set_velocity(crate::math::Vec3::ZERO, world);
        }
        if !found || slide {
            return found;
        }
        let at = &tries.transit.result.position;
        let moved = at.frame.origin - place.frame.origin;
        let near = moved.x < PLACEMENT_TOLERANCE && moved.y < PLACEMENT_TOLERANCE;
        if near && at.cell == world.land.cell_id(cell) {
            place.frame.origin = at.frame.origin;
            return true;
        }
        false
    }

    /// Puts the object into a cell without a test (`ForceIntoCell`). Without a change of cells the shadows stay, and so does the cell id.
    fn force_into_cell(
        &mut self,
        cell: CellHandle,
        place: &Position,
        world: &mut World,
    ) -> SetPositionError {
        self.set_frame(place.frame, world);
        if self.body.cell != Some(cell) {
            self.change_cell(Some(cell), world);
            self.calc_cross_cells(world);
        }
        SetPositionError::Ok
    }
}

/// The one transition that all tries of a placement share: what was touched accumulates.
struct Tries<'a> {
    transit: &'a mut Transit,
    again: bool,
}
