//! The object of the families `motioninterp` and `jump`: in the world, with the motion table of the file and a part array without parts.

use std::sync::Arc;

use ac_client::animation::PartArray;
use ac_client::entity::{Entity, Weenie};
use ac_client::math::{Frame, Vec3};
use ac_client::motion::{HoldKey, MotionInterp};
use ac_client::physics::state::{PhysicsState, TransientState};
use ac_client::world::{CellHandle, World};
use serde_json::Value;

use super::VectorContext;
use super::json::{boolean, f32, id};
use super::math::quat;
use super::tables::{MOTION_TABLE, Tables};

/// Contact, on walkable ground, active.
pub const STANDING: u32 = 0x83;
/// State word of the object.
const STATE: u32 = 0x0040_0C08;
/// Where its clock stands, s.
const NOW: f64 = 100.0;

/// An object that is taken out of its world.
pub struct Object {
    /// The world.
    pub world: World,
    /// The object.
    pub entity: Box<Entity>,
}

impl Object {
    /// The object of a vector's arguments; `None` if they are malformed. It has no movement manager yet.
    pub fn new(ctx: &VectorContext<'_>, arguments: &Value) -> Option<Self> {
        let source = Arc::new(Tables::read(ctx)?.into_source());
        let mut world = World::with_source(ctx.profile.clone(), NOW, source);
        let mut entity = world.entities.create(0x5000_0001, NOW);
        entity.weenie = Some(weenie(arguments)?);
        entity.body.weenie.present = true;
        entity.body.weenie.creature = boolean(&arguments["creature"])?;
        entity.body.weenie.player = true;
        entity.body.state = PhysicsState::from_bits_retain(STATE);
        entity.body.cell = Some(CellHandle(0));
        // One empty part: without a shape it is as good as none.
        entity.body.part_array = Some(PartArray::particle(1).ok()?);
        entity.kin.transient = TransientState::from_bits_retain(STANDING);
        entity.kin.last_move_was_autonomous = true;
        if let Some(rotation) = arguments.get("rotation") {
            entity.body.position.frame = Frame::new(Vec3::ZERO, quat(rotation)?);
        }
        Some(Self { world, entity })
    }

    /// Gives the object its motion table, and a movement manager in its default state.
    pub fn enter_default_state(&mut self) {
        self.entity.set_motion_table(MOTION_TABLE, &mut self.world);
    }
}

/// The weenie of a vector's arguments.
pub fn weenie(arguments: &Value) -> Option<Weenie> {
    let run_rate = f32(&arguments["run_rate"])?;
    Some(Weenie {
        run_rate: boolean(&arguments["has_run_rate"])?.then_some(run_rate),
        jump_velocity: Some(f32(&arguments["jump_velocity"])?),
        can_jump: arguments.get("can_jump").map_or(Some(true), boolean)?,
        jump_stamina_cost: Some(0),
        ..Weenie::default()
    })
}

/// The interpreter of a vector that gives its state: interpreted motions, run rate, jump extent.
pub fn interpreter(arguments: &Value) -> Option<MotionInterp> {
    use ac_client::motion::Command;
    let mut interp = MotionInterp::default();
    let state = &mut interp.interpreted;
    state.forward_command = Command(id(&arguments["forward"])?);
    state.forward_speed = f32(&arguments["forward_speed"])?;
    state.sidestep_command = Command(id(&arguments["sidestep"])?);
    state.sidestep_speed = f32(&arguments["sidestep_speed"])?;
    state.turn_command = Command(id(&arguments["turn"])?);
    interp.my_run_rate = f32(&arguments["my_run_rate"])?;
    interp.jump_extent = f32(&arguments["jump_extent"])?;
    Some(interp)
}

/// A *hold key*.
pub fn hold_key(value: &Value) -> Option<HoldKey> {
    Some(match value.as_str()? {
        "invalid" => HoldKey::Invalid,
        "none" => HoldKey::None,
        "run" => HoldKey::Run,
        _ => return None,
    })
}

/// Writes a *hold key*.
pub fn put_hold_key(key: HoldKey) -> Value {
    match key {
        HoldKey::Invalid => "invalid",
        HoldKey::None => "none",
        HoldKey::Run => "run",
    }
    .into()
}
