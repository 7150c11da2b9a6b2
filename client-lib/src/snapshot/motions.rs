//! Forms of the motion interpreter, the motion states and the move-to manager.

use std::collections::VecDeque;

use super::form::stored;
use crate::math::Position;
use crate::motion::{
    Actions, Character, Command, DistanceSample, HoldKey, InterpretedMotionState, MotionInterp,
    MoveToKind, MoveToManager, MoveToNode, MovementFlags, MovementManager, MovementParameters,
    PendingMotion, RawAxis, RawMotionState,
};

stored!(
    enum HoldKeyForm of HoldKey { Invalid, None, Run }
);
stored!(
    struct RawAxisForm of RawAxis { command: Command, hold_key: HoldKey, speed: f32 }
);
stored!(
    struct RawStateForm of RawMotionState {
        current_hold_key: HoldKey,
        style: Command,
        forward: RawAxis,
        sidestep: RawAxis,
        turn: RawAxis,
        actions: Actions,
    }
);
stored!(
    struct InterpretedStateForm of InterpretedMotionState {
        style: Command,
        forward_command: Command,
        forward_speed: f32,
        sidestep_command: Command,
        sidestep_speed: f32,
        turn_command: Command,
        turn_speed: f32,
        actions: Actions,
    }
);
stored!(
    struct PendingMotionForm of PendingMotion { context_id: u32, command: Command, forbids_jump: bool }
);
stored!(
    struct MotionInterpForm of MotionInterp {
        initted: bool,
        raw: RawMotionState,
        interpreted: InterpretedMotionState,
        current_speed_factor: f32,
        standing_longjump: bool,
        jump_extent: f32,
        server_action_stamp: u32,
        my_run_rate: f32,
        pending: VecDeque<PendingMotion>,
    }
);
stored!(
    struct MovementParametersForm of MovementParameters {
        flags: MovementFlags,
        distance_to_object: f32,
        min_distance: f32,
        desired_heading: f32,
        speed: f32,
        fail_distance: f32,
        walk_run_threshold: f32,
        context_id: u32,
        hold_key: HoldKey,
        action_stamp: u32,
    }
);
stored!(
    enum MoveToKindForm of MoveToKind { Idle, Object, Position, TurnToObject, TurnToHeading }
);
stored!(
    enum MoveToNodeForm of MoveToNode { Move, Turn(heading: f32) }
);
stored!(
    struct DistanceSampleForm of DistanceSample { distance: f32, time: f64 }
);
stored!(
    struct MoveToForm of MoveToManager {
        kind: MoveToKind,
        sought_position: Position,
        current_target_position: Position,
        starting_position: Position,
        params: MovementParameters,
        previous_heading: f32,
        previous: DistanceSample,
        original: DistanceSample,
        fail_progress_count: u32,
        sought_object_id: u32,
        top_level_object_id: u32,
        sought_object_radius: f32,
        sought_object_height: f32,
        current_command: Command,
        aux_command: Command,
        moving_away: bool,
        initialized: bool,
        nodes: VecDeque<MoveToNode>,
    }
);
stored!(
    struct MovementManagerForm of MovementManager { interp: Option<MotionInterp>, move_to: Option<MoveToManager> }
);
stored!(
    struct CharacterForm of Character {
        local_player: bool,
        strength: i32,
        burden_augmentations: i32,
        encumbrance: i32,
        run_skill: Option<i32>,
        jump_skill: Option<i32>,
        stamina: Option<u32>,
        recent_player_fight: bool,
    }
);
