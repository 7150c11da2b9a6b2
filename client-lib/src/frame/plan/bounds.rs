//! How far things can get: bounds that need no simulation.

use std::collections::{BTreeMap, BTreeSet};

use super::auto::EntityOutline;
use crate::dat::{MotionData, MotionTable, Setup};
use crate::math::{BLOCK_LENGTH, Position, Vec3};
use crate::physics::integrator::MAX_VELOCITY;
use crate::physics::state::PhysicsState;
use crate::world::WorldSource;

/// The last block of the map in each direction.
const LAST_BLOCK: i32 = 254;
/// Search range of a placement, m (`spec/05-transition.md`, 12.5).
const SEARCH_RANGE: f32 = 4.0;
/// Factor by which the interpreter may speed a command up: its own limit for side steps, and more than any other
/// (`spec/08-motion.md`, 9).
const COMMAND_FACTOR: f32 = 3.12;

/// Places that an entity can be at, and how far it can get from them, m.
#[derive(Debug, Clone, PartialEq)]
pub struct Travel {
    /// Where it is put: created, placed, interpolated to.
    pub places: Vec<Position>,
    /// How far it can get from each, m.
    pub distance: f32,
}

impl Travel {
    /// Blocks (upper halves of ids) within the distance of a place.
    pub fn blocks(&self) -> BTreeSet<u16> {
        let mut blocks = BTreeSet::new();
        for place in &self.places {
            blocks.extend(blocks_around(place, self.distance));
        }
        blocks
    }
}

/// Blocks of the map within `distance` m of a position, along x and y; all if something is not a number.
pub(super) fn blocks_around(place: &Position, distance: f32) -> impl Iterator<Item = u16> {
    let range = |corner: i32, at: f32| {
        let (low, high) = (at - distance, at + distance);
        let block = |x: f32| corner.saturating_add((x / BLOCK_LENGTH).floor() as i32);
        if low.is_nan() || high.is_nan() {
            return 0..=LAST_BLOCK;
        }
        block(low).clamp(0, LAST_BLOCK)..=block(high).clamp(0, LAST_BLOCK)
    };
    let origin = place.frame.origin;
    let (xs, ys) = (
        range(place.cell.block_x(), origin.x),
        range(place.cell.block_y(), origin.y),
    );
    xs.flat_map(move |x| ys.clone().map(move |y| (x << 8 | y) as u16))
}

/// Largest extents and speeds of the records that a scene uses; each record is looked at once.
#[derive(Debug)]
pub(super) struct Bounds<'a> {
    source: &'a dyn WorldSource,
    extents: BTreeMap<u32, Option<f32>>,
    speeds: BTreeMap<u32, f32>,
}

impl<'a> Bounds<'a> {
    pub fn new(source: &'a dyn WorldSource) -> Self {
        Self {
            source,
            extents: BTreeMap::new(),
            speeds: BTreeMap::new(),
        }
    }

    /// How far an object of a setup that is not animated reaches from its origin, m at scale 1; `None` if it cannot be told, or the setup
    /// is animated or scripted by default.
    pub fn extent(&mut self, setup: u32) -> Option<f32> {
        if let Some(&known) = self.extents.get(&setup) {
            return known;
        }
        let record = self.source.setup(setup).ok().flatten();
        let extent = record.and_then(|record| self.extent_of(&record));
        self.extents.insert(setup, extent);
        extent
    }

    fn extent_of(&self, setup: &Setup) -> Option<f32> {
        if setup.default_animation != 0 || setup.default_script != 0 {
            return None;
        }
        let spheres = setup.spheres.iter().chain([&setup.sorting_sphere]);
        let mut extent = spheres.fold(setup.radius.abs(), |extent, sphere| {
            extent.max(sphere.center.length() + sphere.radius.abs())
        });
        for cylinder in &setup.cyl_spheres {
            extent = extent.max(cylinder.low.length() + cylinder.radius.abs());
        }
        for (index, &part) in setup.parts.iter().enumerate() {
            let shape = self.source.gfx_obj(part).ok()??;
            let vertices = shape.vertices.vertices().iter();
            let mut radius = vertices.fold(0.0_f32, |r, v| r.max(v.position.length()));
            for sphere in [shape.physics_sphere(), shape.drawing_sphere()]
                .into_iter()
                .flatten()
            {
                radius = radius.max(sphere.center.length() + sphere.radius.abs());
            }
            let scale = setup
                .scales
                .get(index)
                .map_or(1.0, |s| s.abs().max_element());
            let offsets = setup
                .placements
                .iter()
                .filter_map(|(_, pose)| pose.parts.get(index));
            let offset = offsets.fold(0.0_f32, |o, frame| o.max(frame.origin.length()));
            extent = extent.max(offset + radius * scale.max(1.0));
        }
        extent.is_finite().then_some(extent)
    }

    /// Distance from its origin up to which an object that stays where it is put can touch anything, m: its extent after a search for a
    /// place that pushes it about.
    pub fn touch(&mut self, entity: &EntityOutline) -> Option<f32> {
        let extent = self.extent(entity.setup)? * entity.scale.abs().max(1.0);
        Some(SEARCH_RANGE + 4.0 * extent + 2.0)
    }

    /// Largest speed of the motions of a table at rate 1, m/s: velocity and root motion.
    pub fn motion_speed(&mut self, table: u32) -> f32 {
        if let Some(&known) = self.speeds.get(&table) {
            return known;
        }
        let record = self.source.motion_table(table).ok().flatten();
        let speed = record.map_or(0.0, |record| self.speed_of(&record));
        self.speeds.insert(table, speed);
        speed
    }

    fn speed_of(&self, table: &MotionTable) -> f32 {
        let links = table.links.iter().flat_map(|(_, to)| to.iter());
        let all = table
            .cycles
            .iter()
            .chain(table.modifiers.iter())
            .chain(links);
        all.fold(0.0, |speed: f32, (_, motion)| {
            speed.max(self.speed_of_motion(motion))
        })
    }

    fn speed_of_motion(&self, motion: &MotionData) -> f32 {
        let root = motion.anims.iter().map(|range| {
            let animation = self.source.animation(range.animation).ok().flatten();
            let frames = animation.as_ref().map_or(&[][..], |a| a.root_frames());
            let step = frames
                .iter()
                .fold(0.0_f32, |l, frame| l.max(frame.origin.length()));
            step * range.framerate.abs()
        });
        motion.velocity.length() + root.fold(0.0, f32::max)
    }

    /// Speed that an entity cannot exceed, m/s. `rate` is the largest speed that the script asks for.
    pub fn top_speed(&mut self, entity: &EntityOutline, rate: f32) -> f32 {
        let rate = rate.max(1.0) * entity.run_rate.abs().max(1.0) * COMMAND_FACTOR;
        let root = match entity.motion_table {
            0 => 0.0,
            table => self.motion_speed(table) * rate * entity.scale.abs().max(1.0),
        };
        if entity.stays() {
            0.0
        } else {
            MAX_VELOCITY + root
        }
    }
}

impl EntityOutline {
    /// Whether no force, motion or script step can move the entity: it stays where it is put.
    pub(super) fn stays(&self) -> bool {
        let moved = PhysicsState::GRAVITY | PhysicsState::MISSILE | PhysicsState::PARTICLE_EMITTER;
        self.motion_table == 0
            && !self.acts
            && self.velocity == Vec3::ZERO
            && self.omega == Vec3::ZERO
            && !self.state.intersects(moved)
    }
}
