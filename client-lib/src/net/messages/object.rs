//! Messages about objects of the world, server to client (`spec/10-messages.md`, 5).

use super::common::WirePosition;
use super::movement::SequencedMovement;
use super::obj_desc::ObjDesc;
use super::physics_desc::PhysicsDesc;
use super::position::PositionPack;
use super::weenie_desc::WeenieDesc;
use super::wire::wire_struct;

wire_struct! {
    /// CreateObject and UpdateObject: everything about an object.
    pub struct ObjectDescription {
        /// Object.
        guid: u32,
        /// Appearance.
        appearance: ObjDesc,
        /// Physics.
        physics: PhysicsDesc,
        /// Game description.
        weenie: WeenieDesc,
    }

    /// PlayerCreate, InventoryRemoveObject: an object.
    #[derive(Copy, Eq)]
    pub struct Guid {
        /// Object.
        guid: u32,
    }

    /// DeleteObject.
    #[derive(Copy, Eq)]
    pub struct DeleteObject {
        /// Object.
        guid: u32,
        /// Instance stamp.
        instance: u16 => align,
    }

    /// UpdatePosition.
    pub struct UpdatePosition {
        /// Object.
        guid: u32,
        /// Where, and the stamps.
        position: PositionPack,
    }

    /// PositionAndMovement.
    pub struct PositionAndMovement {
        /// Object.
        guid: u32,
        /// Where, and the stamps.
        position: PositionPack,
        /// What it does.
        movement: SequencedMovement,
    }

    /// ParentEvent.
    #[derive(Copy, Eq)]
    pub struct ParentEvent {
        /// Who carries.
        parent: u32,
        /// What is carried.
        child: u32,
        /// Holding location.
        location: u32,
        /// Placement frame of the child.
        placement: u32,
        /// Instance stamp of the parent.
        parent_instance: u16,
        /// Position stamp of the child.
        child_position: u16,
    }

    /// PickupEvent.
    #[derive(Copy, Eq)]
    pub struct PickupEvent {
        /// Object.
        guid: u32,
        /// Instance stamp.
        instance: u16,
        /// Position stamp.
        position: u16,
    }

    /// SetState.
    #[derive(Copy, Eq)]
    pub struct SetState {
        /// Object.
        guid: u32,
        /// State word.
        state: u32,
        /// Instance stamp.
        instance: u16,
        /// State stamp.
        stamp: u16,
    }

    /// UpdateMotion.
    pub struct UpdateMotion {
        /// Object.
        guid: u32,
        /// Instance stamp.
        instance: u16,
        /// What it does.
        movement: SequencedMovement,
    }

    /// VectorUpdate.
    #[derive(Copy)]
    pub struct VectorUpdate {
        /// Object.
        guid: u32,
        /// World axes, m/s.
        velocity: [f32; 3],
        /// rad/s.
        omega: [f32; 3],
        /// Instance stamp.
        instance: u16,
        /// Vector stamp.
        stamp: u16,
    }

    /// Sound at an object.
    #[derive(Copy)]
    pub struct Sound {
        /// Object.
        guid: u32,
        /// Sound.
        sound: u32,
        /// 0..1.
        volume: f32,
    }

    /// PlayerTeleport.
    #[derive(Copy, Eq)]
    pub struct PlayerTeleport {
        /// Teleport stamp.
        stamp: u16 => align,
    }

    /// AutonomyLevel, either way.
    #[derive(Copy, Eq)]
    pub struct AutonomyLevel {
        /// 0..2.
        level: u32,
    }

    /// AutonomousPosition from the server; rarely sent.
    #[derive(Copy)]
    pub struct ServerAutonomousPosition {
        /// Object.
        guid: u32,
        /// Where.
        position: WirePosition,
        /// Instance, server control, teleport, force position.
        stamps: [u16; 4],
        /// Stands on the ground.
        contact: u32,
    }

    /// PlayScriptId.
    #[derive(Copy, Eq)]
    pub struct PlayScriptId {
        /// Object.
        guid: u32,
        /// Script, 0x33......
        script: u32,
    }

    /// PlayScript.
    #[derive(Copy)]
    pub struct PlayScript {
        /// Object.
        guid: u32,
        /// Script type.
        script: u32,
        /// 0..1.
        intensity: f32,
    }

    /// ObjDescEvent.
    pub struct ObjDescEvent {
        /// Object.
        guid: u32,
        /// Appearance.
        appearance: ObjDesc,
        /// Instance stamp.
        instance: u16,
        /// Description stamp.
        stamp: u16,
    }

    /// SetStackSize.
    #[derive(Copy, Eq)]
    pub struct SetStackSize {
        /// Sequence of the property.
        sequence: u8,
        /// Object.
        guid: u32,
        /// Size.
        size: u32,
        /// Value.
        value: u32,
    }
}
