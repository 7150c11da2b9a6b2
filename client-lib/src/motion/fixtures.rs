//! An object with a motion table, taken out of its world.

use std::sync::Arc;

use super::{Command, HoldKey, MotionInterp, MotionResult, Movement, MovementParameters};
use crate::animation::PartArray;
use crate::animation::fixtures::{TABLE, TableParts, animation, motion, moving, table};
use crate::dat::{MotionData, motion_key};
use crate::entity::{Entity, Weenie};
use crate::math::{CellId, Position, Quat, Vec3};
use crate::physics::state::TransientState;
use crate::profile::Profile;
use crate::world::{CellHandle, MemorySource, World};

pub const WAVE: Command = Command(0x1300_0087);
pub const HOP: Command = Command(0x1000_004A);
pub const SWORD: Command = Command(0x8000_003E);
pub const GROUND: TransientState = TransientState::CONTACT.union(TransientState::ON_WALKABLE);

/// A world with the table of [`source`], and an object in it.
pub struct Rig {
    pub world: World,
    pub entity: Box<Entity>,
}

fn cycles() -> Vec<(u32, u32, MotionData)> {
    let still = |anim: u32| moving((anim, 30.0), 0, Vec3::ZERO, Vec3::ZERO);
    let idle_only = |anim: u32| moving((anim, 30.0), 2, Vec3::ZERO, Vec3::ZERO);
    let (peace, combat) = (Command::NON_COMBAT.0, SWORD.0);
    vec![
        (peace, Command::READY.0, still(1)),
        (peace, Command::WALK_FORWARD.0, still(2)),
        (peace, Command::RUN_FORWARD.0, still(3)),
        (peace, Command::TURN_RIGHT.0, idle_only(4)),
        (peace, Command::SIDE_STEP_RIGHT.0, idle_only(5)),
        (peace, Command::FALLING.0, still(6)),
        (peace, Command::CROUCH.0, still(7)),
        (peace, Command::DEAD.0, still(8)),
        (combat, Command::READY.0, still(1)),
        (combat, Command::WALK_FORWARD.0, still(2)),
        (combat, Command::FALLING.0, still(6)),
    ]
}

fn source() -> MemorySource {
    let links = |targets: &[Command]| -> Vec<(u32, MotionData)> {
        let link = |c: &Command| (c.0, motion(&[(9, 30.0)]));
        targets.iter().map(link).collect()
    };
    let turn = moving((4, 30.0), 0, Vec3::ZERO, Vec3::new(0.0, 0.0, -1.5));
    let mut records = table(TableParts {
        cycles: cycles(),
        modifiers: vec![
            (Command::TURN_RIGHT.0 & 0xFF_FFFF, turn.clone()),
            (Command::SIDE_STEP_RIGHT.0 & 0xFF_FFFF, turn),
        ],
        links: vec![
            (
                motion_key(Command::NON_COMBAT.0, Command::READY.0),
                links(&[WAVE, HOP, Command::CROUCH]),
            ),
            (motion_key(SWORD.0, Command::READY.0), links(&[HOP])),
        ],
    });
    let both = [Command::NON_COMBAT, SWORD].map(|style| (style.0, Command::READY.0));
    Arc::make_mut(&mut records).style_defaults = both.into_iter().collect();
    let mut source = MemorySource::default();
    source.motion_tables.insert(TABLE, records);
    for id in 1..10 {
        source.animations.insert(id, animation(id, 4, None, &[]));
    }
    source
}

impl Rig {
    /// A creature with gravity on walkable ground, run rate 2, that jumps at 8 m/s.
    pub fn new(profile: Profile) -> Self {
        Self::with_transient(profile, GROUND)
    }

    pub fn with_transient(profile: Profile, transient: TransientState) -> Self {
        let mut rig = Self::without_table(profile, transient);
        let Rig { world, entity } = &mut rig;
        assert!(entity.set_motion_table(TABLE, world));
        rig
    }

    /// The same before it got its motion table.
    pub fn without_table(profile: Profile, transient: TransientState) -> Self {
        let mut world = World::with_source(profile, 100.0, Arc::new(source()));
        let mut entity = world.entities.create(0x5000_0001, 100.0);
        entity.weenie = Some(Weenie {
            run_rate: Some(2.0),
            jump_velocity: Some(8.0),
            can_jump: true,
            jump_stamina_cost: Some(3),
            ..Weenie::default()
        });
        entity.body.weenie.present = true;
        entity.body.weenie.creature = true;
        entity.body.cell = Some(CellHandle(0));
        entity.body.position = place(0.0, 0.0);
        entity.body.part_array = PartArray::particle(1).ok();
        entity.kin.transient = transient;
        entity.kin.last_move_was_autonomous = true;
        Self { world, entity }
    }

    pub fn interp(&self) -> &MotionInterp {
        self.entity.interp().expect("there is an interpreter")
    }

    pub fn perform(&mut self, movement: Movement) -> MotionResult {
        self.entity.perform_movement(&movement, &mut self.world)
    }

    pub fn press(&mut self, command: Command, hold_key: HoldKey) -> MotionResult {
        self.perform(Movement::Raw(command, with_key(hold_key)))
    }

    pub fn release(&mut self, command: Command, hold_key: HoldKey) -> MotionResult {
        self.perform(Movement::StopRaw(command, with_key(hold_key)))
    }

    /// Substate of the motion table.
    pub fn substate(&self) -> Command {
        let parts = self.entity.part_array().expect("there are parts");
        Command(parts.motion_table.as_ref().map_or(0, |m| m.state.substate))
    }

    /// Motions that wait in the animation layer.
    pub fn animating(&self) -> usize {
        let parts = self.entity.part_array().expect("there are parts");
        parts.motion_table.as_ref().map_or(0, |m| m.pending().len())
    }

    pub fn lift(&mut self) {
        let Rig { world, entity } = self;
        entity.kin.transient.remove(TransientState::CONTACT);
        entity.set_on_walkable(false, world);
    }

    pub fn land(&mut self) {
        let Rig { world, entity } = self;
        entity.kin.transient.insert(TransientState::CONTACT);
        entity.set_on_walkable(true, world);
    }

    /// Ends every waiting animation.
    pub fn settle(&mut self) {
        self.entity.remove_link_animations(&mut self.world);
    }

    /// Runs the movement manager for one quantum that ends at `time`, s.
    pub fn tick(&mut self, time: f64) {
        self.world.clock.now = time;
        self.world.clock.sim_time = time;
        self.entity.movement_use_time(&mut self.world);
        self.entity.check_for_completed_motions(&mut self.world);
    }
}

pub fn with_key(hold_key: HoldKey) -> MovementParameters {
    MovementParameters {
        hold_key,
        ..MovementParameters::default()
    }
}

/// A place in one landblock, m.
pub fn place(x: f32, y: f32) -> Position {
    let origin = Vec3::new(96.0 + x, 96.0 + y, 0.0);
    Position::new(CellId(0xA9B4_0025), origin, Quat::IDENTITY)
}
