//! Game actions, client to server (`spec/10-messages.md`, 6).

use super::common::{Text, WirePosition};
use super::movement::RawState;
use super::wire::wire_struct;
use crate::motion::SequenceStamps;

wire_struct! {
    /// The four stamps of the player that travel with reports.
    #[derive(Copy, Eq)]
    pub struct ReportStamps {
        /// Instance.
        instance: u16,
        /// Server control.
        server_control: u16,
        /// Teleport.
        teleport: u16,
        /// Force position.
        force: u16,
    }

    /// MoveToState.
    pub struct MoveToState {
        /// What the input wants.
        state: RawState,
        /// Where.
        position: WirePosition,
        /// Stamps.
        stamps: ReportStamps,
        /// 1 contact, 2 standing long jump.
        bits: u8 => align,
    }

    /// AutonomousPosition.
    #[derive(Copy)]
    pub struct AutonomousPosition {
        /// Where.
        position: WirePosition,
        /// Stamps.
        stamps: ReportStamps,
        /// On the ground.
        contact: u8 => align,
    }

    /// Jump.
    #[derive(Copy)]
    pub struct Jump {
        /// 0..1.
        extent: f32,
        /// The player's own axes, m/s.
        velocity: [f32; 3],
        /// Where.
        position: WirePosition,
        /// Stamps.
        stamps: ReportStamps => align,
    }

    /// DoMovementCommand.
    #[derive(Copy)]
    pub struct DoMovementCommand {
        /// Command.
        command: u32,
        /// Factor of the animation's rate.
        speed: f32,
        /// Walk or run.
        hold_key: u32,
    }

    /// StopMovementCommand.
    #[derive(Copy, Eq)]
    pub struct StopMovementCommand {
        /// Command.
        command: u32,
        /// Walk or run.
        hold_key: u32,
    }

    /// Tell.
    pub struct TellTo {
        /// What is said.
        text: Text,
        /// To whom.
        target: Text,
    }

    /// TalkDirect.
    pub struct TalkDirect {
        /// What is said.
        text: Text,
        /// To whom.
        target: u32,
    }

    /// ChatChannel; fields that some channels append are extra bytes.
    pub struct ChatChannel {
        /// Channel.
        channel: u32,
        /// What is said.
        text: Text,
    }

    /// PutItemInContainer. Picking up: the player's GUID, slot 0.
    #[derive(Copy, Eq)]
    pub struct PutItemInContainer {
        /// Item.
        item: u32,
        /// Container.
        container: u32,
        /// Slot.
        slot: i32,
    }

    /// GiveObject.
    #[derive(Copy, Eq)]
    pub struct GiveObject {
        /// To whom.
        target: u32,
        /// Item.
        item: u32,
        /// How many.
        amount: u32,
    }

    /// StackableMerge.
    #[derive(Copy, Eq)]
    pub struct StackableMerge {
        /// Stack taken from.
        from: u32,
        /// Stack added to.
        to: u32,
        /// How many.
        amount: i32,
    }

    /// StackableSplitToContainer.
    #[derive(Copy, Eq)]
    pub struct StackableSplitToContainer {
        /// Stack.
        stack: u32,
        /// Container.
        container: u32,
        /// Slot.
        slot: i32,
        /// How many.
        amount: i32,
    }

    /// StackableSplitTo3D.
    #[derive(Copy, Eq)]
    pub struct StackableSplitTo3D {
        /// Stack.
        stack: u32,
        /// How many.
        amount: i32,
    }

    /// StackableSplitToWield.
    #[derive(Copy, Eq)]
    pub struct StackableSplitToWield {
        /// Stack.
        stack: u32,
        /// Equip location.
        location: u32,
        /// How many.
        amount: i32,
    }

    /// TargetedMeleeAttack, TargetedMissileAttack.
    #[derive(Copy)]
    pub struct TargetedAttack {
        /// Target.
        target: u32,
        /// 1 high, 2 medium, 3 low.
        height: u32,
        /// Power or accuracy, 0..1.
        power: f32,
    }

    /// ConfirmationResponse.
    #[derive(Copy, Eq)]
    pub struct ConfirmationResponse {
        /// Kind of question.
        kind: i32,
        /// Which question.
        context: u32,
        /// 0 no.
        yes: i32,
    }
}

impl From<SequenceStamps> for ReportStamps {
    fn from(s: SequenceStamps) -> Self {
        Self {
            instance: s.instance,
            server_control: s.server_control,
            teleport: s.teleport,
            force: s.force_position,
        }
    }
}
