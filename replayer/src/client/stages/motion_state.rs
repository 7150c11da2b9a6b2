//! The motion state as the stages `hooks` and `motion` have it on both sides.

use ac_client::animation::{MotionEntry, MotionTableManager};
use ac_client::entity::Entity;
use ac_client::math::{Position, Vec3};
use ac_client::motion::{
    Action, Actions, Command, DistanceSample, HoldKey, InterpretedMotionState, MotionInterp,
    MoveToKind, MoveToManager, MoveToNode, MovementFlags, MovementParameters, PendingMotion,
};
use ac_client::physics::state::TransientState;
use ac_client::world::World;
use ac_golden_traces::number;
use ac_golden_traces::scene::PositionSpec;
use serde::{Deserialize, Serialize};

use super::super::entity::position;
use super::shapes::{Hex, position_spec};

#[derive(Debug, Deserialize, Serialize)]
pub(super) struct MotionSide {
    position: PositionSpec,
    #[serde(with = "number::floats")]
    velocity: [f32; 3],
    #[serde(with = "number::hex")]
    transient: u32,
    interpreted: Option<Interpreted>,
    pending: Option<Vec<Hex>>,
    table: Option<Table>,
    move_to_type: u8,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    move_to: Option<MoveTo>,
}

/// The interpreted motion state.
#[derive(Debug, Deserialize, Serialize)]
pub(super) struct Interpreted {
    #[serde(with = "number::hex")]
    style: u32,
    #[serde(with = "number::hex")]
    forward: u32,
    #[serde(with = "number::f32")]
    forward_speed: f32,
    #[serde(with = "number::hex")]
    sidestep: u32,
    #[serde(with = "number::f32")]
    sidestep_speed: f32,
    #[serde(with = "number::hex")]
    turn: u32,
    #[serde(with = "number::f32")]
    turn_speed: f32,
    actions: Vec<Hex>,
}

#[derive(Debug, Deserialize, Serialize)]
struct Table {
    #[serde(with = "number::hex")]
    style: u32,
    #[serde(with = "number::hex")]
    substate: u32,
    #[serde(with = "number::f32")]
    substate_speed: f32,
    modifiers: Vec<Modifier>,
    actions: Vec<Hex>,
    queue: Vec<(Hex, u32)>,
    counter: u32,
}

#[derive(Debug, Deserialize, Serialize)]
struct Modifier(Hex, #[serde(with = "number::f32")] f32);

#[derive(Debug, Deserialize, Serialize)]
struct Node(String, #[serde(with = "number::f32")] f32);

#[derive(Debug, Deserialize, Serialize)]
struct MoveTo {
    nodes: Vec<Node>,
    #[serde(with = "number::hex")]
    command: u32,
    #[serde(with = "number::hex")]
    aux_command: u32,
    moving_away: bool,
    initialized: bool,
    fail_count: u32,
    #[serde(with = "number::f32")]
    previous_heading: f32,
    #[serde(with = "number::f32")]
    previous_distance: f32,
    #[serde(with = "number::f32")]
    original_distance: f32,
    previous_time: f64,
    original_time: f64,
    #[serde(with = "number::hex")]
    target: u32,
    target_position: PositionSpec,
    sought: PositionSpec,
    /// Null before anything was walked to.
    start: Option<PositionSpec>,
    params: Params,
}

#[derive(Debug, Deserialize, Serialize)]
struct Params {
    #[serde(with = "number::hex")]
    bitfield: u32,
    #[serde(with = "number::f32")]
    distance_to_object: f32,
    #[serde(with = "number::f32")]
    min_distance: f32,
    #[serde(with = "number::f32")]
    desired_heading: f32,
    #[serde(with = "number::f32")]
    speed: f32,
    #[serde(with = "number::f32")]
    fail_distance: f32,
    #[serde(with = "number::f32")]
    walk_run_threshold: f32,
    hold_key: u32,
}

impl MotionSide {
    /// Writes the state into an entity. What the record does not say of an entry (contexts, stamps) stays where the entry is the same.
    pub(super) fn apply(&self, entity: &mut Entity, world: &mut World) {
        place(entity, &self.position, world);
        entity.kin.velocity = self.velocity.into();
        entity.kin.transient = TransientState::from_bits_retain(self.transient);
        if let Some(interp) = entity.interp_mut() {
            if let Some(interpreted) = &self.interpreted {
                interpreted.apply(&mut interp.interpreted);
            }
            if let Some(pending) = &self.pending {
                apply_pending(pending, interp);
            }
        }
        let parts = entity.part_array_mut();
        let manager = parts.and_then(|parts| parts.motion_table.as_mut());
        if let (Some(manager), Some(table)) = (manager, &self.table) {
            table.apply(manager);
        }
        let now = world.clock.now;
        let Some(movement) = &mut entity.movement else {
            return;
        };
        match &self.move_to {
            Some(spec) => {
                let manager = movement
                    .move_to
                    .get_or_insert_with(|| MoveToManager::new(now));
                manager.kind = kind(self.move_to_type);
                spec.apply(manager);
            }
            None => {
                if let Some(manager) = &mut movement.move_to {
                    manager.kind = MoveToKind::Idle;
                }
            }
        }
    }

    /// Reads the state of an entity.
    pub(super) fn of(entity: &Entity) -> Self {
        let parts = entity.part_array();
        let table = parts.and_then(|parts| parts.motion_table.as_ref());
        let move_to = entity.move_to().filter(|m| m.is_active());
        Self {
            position: position_spec(&entity.body.position),
            velocity: entity.kin.velocity.into(),
            transient: entity.kin.transient.bits(),
            interpreted: entity.interp().map(|i| Interpreted::of(&i.interpreted)),
            pending: entity
                .interp()
                .map(|i| i.pending.iter().map(|p| Hex(p.command.0)).collect()),
            table: table.map(Table::of),
            move_to_type: move_to.map_or(0, |m| m.kind as u8),
            move_to: move_to.map(MoveTo::of),
        }
    }
}

/// Puts an entity where a record says. Who is in the same cell stays in its lists.
pub(super) fn place(entity: &mut Entity, spec: &PositionSpec, world: &mut World) {
    let Position { cell, frame } = position(spec);
    if cell != entity.body.position.cell {
        entity.body.cell = match cell.0 {
            0 => None,
            _ => world.visible_cell(cell),
        };
        entity.body.position.cell = cell;
    }
    entity.body.position.frame = frame;
}

const fn kind(number: u8) -> MoveToKind {
    match number {
        6 => MoveToKind::Object,
        7 => MoveToKind::Position,
        8 => MoveToKind::TurnToObject,
        9 => MoveToKind::TurnToHeading,
        _ => MoveToKind::Idle,
    }
}

/// Sets the commands; the rest of an entry stays if the commands are the same.
fn apply_pending(pending: &[Hex], interp: &mut MotionInterp) {
    let known = interp.pending.iter().map(|p| p.command.0);
    if known.eq(pending.iter().map(|p| p.0)) {
        return;
    }
    interp.pending.clear();
    interp
        .pending
        .extend(pending.iter().map(|&Hex(command)| PendingMotion {
            context_id: 0,
            command: Command(command),
            forbids_jump: false,
        }));
}

impl Interpreted {
    pub(super) fn apply(&self, state: &mut InterpretedMotionState) {
        state.style = Command(self.style);
        state.forward_command = Command(self.forward);
        state.forward_speed = self.forward_speed;
        state.sidestep_command = Command(self.sidestep);
        state.sidestep_speed = self.sidestep_speed;
        state.turn_command = Command(self.turn);
        state.turn_speed = self.turn_speed;
        let known = state.actions.iter().map(|a| a.command.0);
        if known.eq(self.actions.iter().map(|a| a.0)) {
            return;
        }
        state.actions = Actions::default();
        for &Hex(command) in &self.actions {
            state.actions.add(Action {
                command: Command(command),
                speed: 1.0,
                stamp: 0,
                autonomous: false,
            });
        }
    }

    fn of(state: &InterpretedMotionState) -> Self {
        Self {
            style: state.style.0,
            forward: state.forward_command.0,
            forward_speed: state.forward_speed,
            sidestep: state.sidestep_command.0,
            sidestep_speed: state.sidestep_speed,
            turn: state.turn_command.0,
            turn_speed: state.turn_speed,
            actions: state.actions.iter().map(|a| Hex(a.command.0)).collect(),
        }
    }
}

impl Table {
    fn apply(&self, manager: &mut MotionTableManager) {
        let state = &mut manager.state;
        state.style = self.style;
        state.substate = self.substate;
        state.substate_speed = self.substate_speed;
        state.modifiers.clear();
        let modifiers = self.modifiers.iter();
        state
            .modifiers
            .extend(modifiers.map(|&Modifier(Hex(motion), speed)| MotionEntry { motion, speed }));
        let known = state.actions.iter().map(|a| a.motion);
        if !known.eq(self.actions.iter().map(|a| a.0)) {
            state.actions.clear();
            let actions = self.actions.iter();
            let actions = actions.map(|&Hex(motion)| MotionEntry { motion, speed: 1.0 });
            state.actions.extend(actions);
        }
        let queue = self.queue.iter();
        manager.set_pending(queue.map(|&(Hex(motion), animations)| (motion, animations)));
        manager.animation_counter = self.counter;
    }

    fn of(manager: &MotionTableManager) -> Self {
        let state = &manager.state;
        let modifiers = state.modifiers.iter();
        Self {
            style: state.style,
            substate: state.substate,
            substate_speed: state.substate_speed,
            modifiers: modifiers
                .map(|m| Modifier(Hex(m.motion), m.speed))
                .collect(),
            actions: state.actions.iter().map(|a| Hex(a.motion)).collect(),
            queue: manager
                .pending()
                .map(|p| (Hex(p.motion), p.animations))
                .collect(),
            counter: manager.animation_counter,
        }
    }
}

impl MoveTo {
    fn apply(&self, manager: &mut MoveToManager) {
        let nodes = self.nodes.iter();
        manager.nodes.clear();
        manager.nodes.extend(nodes.map(|Node(kind, heading)| {
            if kind == "turn" {
                MoveToNode::Turn(*heading)
            } else {
                MoveToNode::Move
            }
        }));
        manager.current_command = Command(self.command);
        manager.aux_command = Command(self.aux_command);
        manager.moving_away = self.moving_away;
        manager.initialized = self.initialized;
        manager.fail_progress_count = self.fail_count;
        manager.previous_heading = self.previous_heading;
        manager.previous = DistanceSample {
            distance: self.previous_distance,
            time: self.previous_time,
        };
        manager.original = DistanceSample {
            distance: self.original_distance,
            time: self.original_time,
        };
        if manager.sought_object_id != self.target {
            manager.sought_object_id = self.target;
            manager.top_level_object_id = self.target;
        }
        manager.current_target_position = position(&self.target_position);
        manager.sought_position = position(&self.sought);
        manager.starting_position = self.start.as_ref().map(position).unwrap_or_default();
        self.params.apply(&mut manager.params);
    }

    fn of(manager: &MoveToManager) -> Self {
        let nodes = manager.nodes.iter();
        let start = &manager.starting_position;
        let untouched = start.cell.0 == 0 && start.frame.origin == Vec3::ZERO;
        Self {
            nodes: nodes
                .map(|node| match node {
                    MoveToNode::Move => Node("move".into(), 0.0),
                    MoveToNode::Turn(heading) => Node("turn".into(), *heading),
                })
                .collect(),
            command: manager.current_command.0,
            aux_command: manager.aux_command.0,
            moving_away: manager.moving_away,
            initialized: manager.initialized,
            fail_count: manager.fail_progress_count,
            previous_heading: manager.previous_heading,
            previous_distance: manager.previous.distance,
            original_distance: manager.original.distance,
            previous_time: manager.previous.time,
            original_time: manager.original.time,
            target: manager.sought_object_id,
            target_position: position_spec(&manager.current_target_position),
            sought: position_spec(&manager.sought_position),
            start: (!untouched).then(|| position_spec(start)),
            params: Params::of(&manager.params),
        }
    }
}

impl Params {
    fn apply(&self, params: &mut MovementParameters) {
        params.flags = MovementFlags::from_bits_retain(self.bitfield);
        params.distance_to_object = self.distance_to_object;
        params.min_distance = self.min_distance;
        params.desired_heading = self.desired_heading;
        params.speed = self.speed;
        params.fail_distance = self.fail_distance;
        params.walk_run_threshold = self.walk_run_threshold;
        params.hold_key = HoldKey::from_code(self.hold_key).unwrap_or(params.hold_key);
    }

    fn of(params: &MovementParameters) -> Self {
        Self {
            bitfield: params.flags.bits(),
            distance_to_object: params.distance_to_object,
            min_distance: params.min_distance,
            desired_heading: params.desired_heading,
            speed: params.speed,
            fail_distance: params.fail_distance,
            walk_run_threshold: params.walk_run_threshold,
            hold_key: params.hold_key.code(),
        }
    }
}
