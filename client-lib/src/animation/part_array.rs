//! The part array: skeleton, parts with their collision shapes, and the animation that moves them (`spec/07-animation.md`, 6).

use std::sync::Arc;

use super::completion::{CompletionRun, MotionNotice};
use super::error::{AnimationError, MotionTableError, PartArrayError};
use super::hooks::AnimHookQueue;
use super::motion_table_manager::{MotionRequest, MotionTableManager};
use super::part::PhysicsPart;
use super::placing::Pending;
use super::sequence::{Placement, Sequence};
use super::simple_setup::simple_setup;
use super::source::AnimationSource;
use crate::dat::{AnimRange, CylSphere, Location, Setup, StoredFrame};
use crate::math::{CellId, Frame, Sphere, Vec3};
use crate::profile::{DefaultAnimation, MissingTables, Profile};

/// Placement that every new object gets: "resting".
const DEFAULT_PLACEMENT: i32 = 0x65;
/// Step height of a part array without a setup, m.
const DEFAULT_STEP: f32 = 0.01;
/// Parts of a particle object. Emitters of the dat files use a few dozen.
const PARTICLE_LIMIT: usize = 1 << 16;

/// Skeleton and parts of one object, its animations and its motion table.
#[derive(Debug, Clone)]
pub struct PartArray {
    /// What is being played.
    pub sequence: Sequence,
    /// The motion table, if one was assigned.
    pub motion_table: Option<MotionTableManager>,
    /// Parts by index; a part that could not be made is `None`. Particle objects start with empty slots.
    ///
    /// Where they are is up to date after [`PartArray::settle_parts`].
    pub parts: Vec<Option<PhysicsPart>>,
    /// Animation hooks that wait to be executed, in order.
    pub hooks: AnimHookQueue,
    pub(crate) setup: Option<Arc<Setup>>,
    pub(crate) scale: Vec3,
    /// Places that the parts wait for.
    pub(crate) pending: Pending,
    /// Some part can be collided with by its physics BSP.
    pub(crate) has_bsp_part: bool,
    /// The quanta of the object change nothing but the frame number of what is played, until somebody changes the object.
    pub(crate) stands_still: bool,
    /// Of the setup: see [`PartArray::obstacle_reach`].
    pub(crate) obstacle_reach: f32,
}

impl PartArray {
    pub(crate) fn empty() -> Self {
        Self {
            sequence: Sequence::new(),
            motion_table: None,
            parts: Vec::new(),
            hooks: AnimHookQueue::new(),
            setup: None,
            scale: Vec3::ONE,
            pending: Pending::NOTHING,
            has_bsp_part: false,
            stands_still: false,
            obstacle_reach: 0.0,
        }
    }

    /// An object that is one shape, 0x01...... (`CreateMesh`).
    ///
    /// # Errors
    /// The shape is missing.
    pub fn mesh(id: u32, source: &mut dyn AnimationSource) -> Result<Self, PartArrayError> {
        if id == 0 {
            return Err(PartArrayError::NullId);
        }
        let shape = source
            .shape(id)
            .ok_or(PartArrayError::MissingShape { part: 0, shape: id })?;
        let mut array = Self::empty();
        array.take_setup(Arc::new(simple_setup(&shape)));
        array.parts = vec![Some(PhysicsPart::new(shape))];
        array.has_bsp_part = array.has_physics_bsp();
        array.set_placement_frame(DEFAULT_PLACEMENT);
        Ok(array)
    }

    /// An object made of parts, 0x02...... (`CreateSetup`). It has no motion table, also if the setup names one.
    ///
    /// # Errors
    /// The setup or a part's shape is missing, or there are no parts.
    pub fn with_setup(
        id: u32,
        source: &mut dyn AnimationSource,
        profile: &Profile,
    ) -> Result<Self, PartArrayError> {
        let mut array = Self::empty();
        array.set_setup(id, source, profile)?;
        array.set_placement_frame(DEFAULT_PLACEMENT);
        Ok(array)
    }

    /// A particle object with `count` empty parts and no pose (`CreateParticle`).
    ///
    /// # Errors
    /// More parts than any emitter has.
    pub fn particle(count: usize) -> Result<Self, PartArrayError> {
        if count == 0 {
            return Err(PartArrayError::NoParts(0));
        }
        if count > PARTICLE_LIMIT {
            return Err(PartArrayError::TooManyParts(count));
        }
        let mut array = Self::empty();
        array.take_setup(Arc::new(Setup::empty(0)));
        array.parts.resize(count, None);
        Ok(array)
    }

    /// The array with that sorting sphere (own space, m) instead of its setup's.
    #[must_use]
    pub fn with_sorting_sphere(mut self, sphere: Sphere) -> Self {
        let mut setup = self
            .setup
            .as_deref()
            .cloned()
            .unwrap_or_else(|| Setup::empty(0));
        setup.sorting_sphere = sphere;
        self.setup = Some(Arc::new(setup));
        self
    }

    /// Replaces the setup (`SetSetupID`). `Ok(false)`: it was the present one and nothing changed. The caller applies the setup's defaults
    /// to the object afterwards: scripts, motion table and state bits (`InitDefaults`, `spec/06`, G1).
    ///
    /// # Errors
    /// The setup is missing (nothing changed), it has no parts, or the shape of a part is missing (the setup is installed without them).
    pub fn set_setup(
        &mut self,
        id: u32,
        source: &mut dyn AnimationSource,
        profile: &Profile,
    ) -> Result<bool, PartArrayError> {
        if self.setup.as_ref().is_some_and(|s| s.id == id) {
            return Ok(false);
        }
        let setup = match (source.setup(id), profile.missing_tables) {
            (Some(setup), _) => setup,
            (None, MissingTables::Absent) => return Err(PartArrayError::MissingSetup(id)),
            (None, MissingTables::Empty) => Arc::new(Setup::empty(0)),
        };
        self.parts.clear();
        self.has_bsp_part = false;
        self.pending.clear();
        // The stored pose belongs to the old setup.
        self.sequence.placement = Placement::default();
        self.take_setup(Arc::clone(&setup));
        self.make_parts(&setup, source)?;
        if setup.default_animation != 0 {
            self.play_default(setup.default_animation, source, profile);
        }
        Ok(true)
    }

    pub(crate) fn take_setup(&mut self, setup: Arc<Setup>) {
        self.obstacle_reach = reach_of(&setup);
        self.setup = Some(setup);
    }

    fn make_parts(
        &mut self,
        setup: &Setup,
        source: &mut dyn AnimationSource,
    ) -> Result<(), PartArrayError> {
        if setup.parts.is_empty() {
            return Err(PartArrayError::NoParts(setup.id));
        }
        self.parts.resize(setup.parts.len(), None);
        for (i, (slot, &id)) in self.parts.iter_mut().zip(&setup.parts).enumerate() {
            let shape = source
                .shape(id)
                .ok_or(PartArrayError::MissingShape { part: i, shape: id })?;
            let mut part = PhysicsPart::new(shape);
            part.scale = setup.scales.get(i).copied().unwrap_or(Vec3::ONE);
            self.has_bsp_part |= part.has_physics_bsp();
            *slot = Some(part);
        }
        Ok(())
    }

    /// Plays the setup's default animation (`N-09`, `N-10`). Entering the default motion of a motion table ends it.
    fn play_default(&mut self, id: u32, source: &mut dyn AnimationSource, profile: &Profile) {
        let (high_frame, framerate) = match profile.default_animation {
            DefaultAnimation::All30 => (-1, 30.0),
            DefaultAnimation::FirstFrame => (0, 0.0),
        };
        let range = AnimRange {
            animation: id,
            low_frame: 0,
            high_frame,
            framerate,
        };
        self.sequence.clear_animations();
        self.sequence.append_animation(&range, source, profile);
    }

    /// The setup, if there is one.
    pub fn setup(&self) -> Option<&Arc<Setup>> {
        self.setup.as_ref()
    }

    /// Chooses the static pose that shows while nothing plays. A missing id falls back to 0, and a missing 0 to no pose and `false`.
    pub fn set_placement_frame(&mut self, id: i32) -> bool {
        let Some(setup) = &self.setup else {
            self.sequence.placement = Placement::default();
            return false;
        };
        let entry = |id| {
            let entry = Some(setup.placements.position(id)?);
            Some(Placement { entry, id })
        };
        let found = entry(id).or_else(|| entry(0));
        self.sequence.placement = found.unwrap_or_default();
        found.is_some()
    }

    /// Part frames that show now, in the object's space (`get_curr_animframe`).
    pub fn pose(&self) -> Option<&[StoredFrame]> {
        pose_of(&self.sequence, self.setup.as_deref())
    }

    /// Advances the animation by a quantum, s. Root motion is added to `offset` (the object's own axes, m, before the object's scale);
    /// hooks are queued in [`PartArray::hooks`].
    ///
    /// # Errors
    /// See [`Sequence::update`].
    pub fn update(
        &mut self,
        quantum: f64,
        offset: Option<&mut Frame>,
        profile: &Profile,
    ) -> Result<(), AnimationError> {
        let quantum = f64::from(quantum as f32);
        self.sequence
            .update(quantum, offset, &mut self.hooks, profile)
    }

    /// Cell id of all parts.
    pub fn set_cell_id(&mut self, cell: CellId) {
        for part in self.existing_parts_mut() {
            part.position.cell = cell;
        }
    }

    /// Parts that exist, in order.
    pub fn existing_parts(&self) -> impl Iterator<Item = &PhysicsPart> {
        self.parts.iter().flatten()
    }

    fn existing_parts_mut(&mut self) -> impl Iterator<Item = &mut PhysicsPart> {
        self.parts.iter_mut().flatten()
    }

    /// Scale of part offsets and, with the setup's default scales, of the parts.
    pub fn scale(&self) -> Vec3 {
        self.scale
    }

    /// Scales the parts; their places follow at the next [`PartArray::update_parts`].
    pub fn set_scale(&mut self, scale: Vec3) {
        self.scale = scale;
        let defaults = self.setup.as_ref().map_or(&[][..], |s| &s.scales);
        for (i, part) in self.parts.iter_mut().enumerate() {
            if let Some(part) = part {
                part.scale = defaults.get(i).map_or(scale, |d| *d * scale);
            }
        }
    }

    /// Replaces shapes of parts: (part index, shape id) in order. `false` if some replacement was not possible.
    pub fn set_parts(
        &mut self,
        changes: impl IntoIterator<Item = (usize, u32)>,
        source: &mut dyn AnimationSource,
    ) -> bool {
        if self.setup.is_none() {
            return false;
        }
        let mut all = true;
        for (index, id) in changes {
            let slot = self.parts.get_mut(index).and_then(Option::as_mut);
            let shape = (id != 0).then(|| source.shape(id)).flatten();
            match (slot, shape) {
                (Some(part), Some(shape)) => part.shape = shape,
                _ => all = false,
            }
        }
        self.has_bsp_part = self.has_physics_bsp();
        all
    }

    /// Whether some part can be collided with by its physics BSP (`CacheHasPhysicsBSP`).
    pub fn has_physics_bsp(&self) -> bool {
        self.existing_parts().any(PhysicsPart::has_physics_bsp)
    }

    /// Hides or shows all parts. Cosmetic.
    pub fn set_no_draw(&mut self, no_draw: bool) {
        if self.setup.is_some() {
            self.existing_parts_mut().for_each(|p| p.no_draw = no_draw);
        }
    }

    /// Fades all parts; the caller leaves cloaked objects alone. Cosmetic.
    pub fn set_translucency(&mut self, translucency: f32) {
        if self.setup.is_some() {
            self.existing_parts_mut()
                .for_each(|p| p.set_translucency(translucency));
        }
    }

    /// Takes setup, scale and parts of another array (`MorphToExistingObject`).
    pub fn morph_to(&mut self, other: &Self) {
        self.setup.clone_from(&other.setup);
        self.obstacle_reach = other.obstacle_reach;
        self.pending.clone_from(&other.pending);
        self.has_bsp_part = other.has_bsp_part;
        self.scale = other.scale;
        self.parts.clone_from(&other.parts);
        self.sequence.placement = other.sequence.placement;
    }
}

/// Sizes and shapes. Lengths are metres; scaled means multiplied by the z component of the array's scale.
impl PartArray {
    fn setup_length(&self, length: impl FnOnce(&Setup) -> f32) -> Option<f32> {
        Some(length(self.setup.as_ref()?) * self.scale.z)
    }

    /// Height, scaled; 0 without a setup.
    pub fn height(&self) -> f32 {
        self.setup_length(|s| s.height).unwrap_or(0.0)
    }

    /// Radius, scaled; 0 without a setup.
    pub fn radius(&self) -> f32 {
        self.setup_length(|s| s.radius).unwrap_or(0.0)
    }

    /// Height of a step up, scaled; 0.01 without a setup.
    pub fn step_up_height(&self) -> f32 {
        self.setup_length(|s| s.step_up_height)
            .unwrap_or(DEFAULT_STEP)
    }

    /// Height of a step down, scaled; 0.01 without a setup.
    pub fn step_down_height(&self) -> f32 {
        self.setup_length(|s| s.step_down_height)
            .unwrap_or(DEFAULT_STEP)
    }

    /// Collision spheres in the object's space, unscaled.
    pub fn spheres(&self) -> &[Sphere] {
        self.setup.as_ref().map_or(&[], |s| &s.spheres)
    }

    /// Distance from the object's origin within which all its collision spheres and cylinders lie, m, unscaled.
    #[inline]
    pub const fn obstacle_reach(&self) -> f32 {
        self.obstacle_reach
    }

    /// Collision cylinders in the object's space, unscaled.
    pub fn cyl_spheres(&self) -> &[CylSphere] {
        self.setup.as_ref().map_or(&[], |s| &s.cyl_spheres)
    }

    /// Sorting sphere in the object's space, unscaled; a zero sphere without a setup.
    pub fn sorting_sphere(&self) -> Sphere {
        self.setup.as_ref().map_or(
            Sphere {
                center: Vec3::ZERO,
                radius: 0.0,
            },
            |s| s.sorting_sphere,
        )
    }

    /// Selection sphere in the object's space, scaled.
    pub fn selection_sphere(&self) -> Option<Sphere> {
        let sphere = self.setup.as_ref()?.selection_sphere;
        Some(Sphere {
            center: sphere.center * self.scale,
            radius: sphere.radius * self.scale.z,
        })
    }

    /// Whether the object may turn freely.
    pub fn allows_free_heading(&self) -> bool {
        self.setup.as_ref().is_some_and(|s| s.allows_free_heading())
    }

    /// Where a child of this object is attached, by parent location.
    pub fn holding_location(&self, location: i32) -> Option<&Location> {
        self.setup.as_ref()?.holding_locations.get(location)
    }

    /// Id of the setup; 0 without one or for a setup that no file holds.
    pub fn setup_id(&self) -> u32 {
        self.setup.as_ref().map_or(0, |s| s.id)
    }

    /// Id of the setup, else the shape of the only part, else 0.
    pub fn data_id(&self) -> u32 {
        match (self.setup_id(), self.parts.as_slice()) {
            (0, [Some(only)]) => only.shape.id,
            (id, _) => id,
        }
    }
}

/// Motions.
impl PartArray {
    /// Assigns a motion table, 0 for none; the old one's state and pending motions are lost, the sequence is not touched. Nothing happens if
    /// this table is assigned already. A table that does not exist is assigned all the same and refuses every command.
    pub fn set_motion_table(
        &mut self,
        id: u32,
        source: &mut dyn AnimationSource,
        profile: &Profile,
    ) {
        if self
            .motion_table
            .as_ref()
            .is_some_and(|m| m.table_id() == id)
        {
            return;
        }
        self.motion_table = (id != 0).then(|| MotionTableManager::new(id, source, profile));
    }

    /// Id of the loaded motion table; 0 without one.
    pub fn motion_table_id(&self) -> u32 {
        self.motion_table
            .as_ref()
            .map_or(0, MotionTableManager::table_id)
    }

    /// Starts or stops a motion (`DoInterpretedMotion`, `StopInterpretedMotion`, `StopCompletely_Internal`).
    ///
    /// # Errors
    /// See [`MotionTableManager::perform`].
    pub fn perform_motion(
        &mut self,
        request: MotionRequest,
        source: &mut dyn AnimationSource,
        profile: &Profile,
    ) -> Result<(), MotionTableError> {
        self.motion_table
            .as_mut()
            .ok_or(MotionTableError::NoAnimationTable)?
            .perform(request, &mut self.sequence, source, profile)
    }

    /// Starts the default motion (`InitializeMotionTables`).
    pub fn initialize_motion_tables(
        &mut self,
        source: &mut dyn AnimationSource,
        profile: &Profile,
    ) {
        if let Some(manager) = &mut self.motion_table {
            manager.initialize_state(&mut self.sequence, source, profile);
        }
    }

    fn run(
        &mut self,
        start: impl FnOnce(&mut MotionTableManager) -> CompletionRun,
    ) -> CompletionRun {
        self.motion_table
            .as_mut()
            .map_or(CompletionRun::nothing(), start)
    }

    /// An animation ended (hook AnimationDone).
    pub fn animation_done(&mut self, success: bool) -> CompletionRun {
        self.run(|m| m.animation_done(success))
    }

    /// Completes what needs no more animations (`HandleMovement`, `CheckForCompletedMotions`): once per quantum.
    pub fn check_for_completed_motions(&mut self) -> CompletionRun {
        self.run(MotionTableManager::check_for_completed_motions)
    }

    /// Drops all links and completes all motions unsuccessfully (`HandleEnterWorld`, `RemoveLinkAnimations`).
    pub fn handle_enter_world(&mut self) -> CompletionRun {
        if self.motion_table.is_some() {
            self.sequence.remove_all_link_animations();
        }
        self.run(MotionTableManager::handle_exit_world)
    }

    /// Completes all motions unsuccessfully; links stay (`HandleExitWorld`).
    pub fn handle_exit_world(&mut self) -> CompletionRun {
        self.run(MotionTableManager::handle_exit_world)
    }

    /// The next motion of a run that is done, to be reported to the motion interpreter at once; `None` when the run is over.
    pub fn next_completion(&mut self, run: &mut CompletionRun) -> Option<MotionNotice> {
        self.motion_table.as_mut()?.next_completion(run)
    }

    /// Whether anything is in the playing list.
    pub fn has_animations(&self) -> bool {
        self.sequence.has_animations()
    }
}

/// Distance from the origin within which all collision spheres and cylinders of a setup lie, m.
fn reach_of(setup: &Setup) -> f32 {
    let spheres = setup
        .spheres
        .iter()
        .map(|s| s.center.length() + s.radius.abs());
    let cylinders = setup
        .cyl_spheres
        .iter()
        .map(|c| c.low.length() + c.radius.abs() + c.height.abs());
    spheres.chain(cylinders).fold(0.0, |reach: f32, r| {
        // Not a number stays.
        if reach.is_nan() || r <= reach {
            reach
        } else {
            r
        }
    })
}

/// The pose of the current animation frame, or the placement while nothing plays.
pub(super) fn pose_of<'a>(
    sequence: &'a Sequence,
    setup: Option<&'a Setup>,
) -> Option<&'a [StoredFrame]> {
    if sequence.current_index().is_some() {
        return sequence.current_pose();
    }
    let (_, frame) = setup?.placements.entries().get(sequence.placement.entry?)?;
    Some(&frame.parts)
}
