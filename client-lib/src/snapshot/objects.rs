//! Forms of entities, bodies, managers, the pool of transitions and the object table.

use std::collections::{HashMap, VecDeque};

use super::form::{Stored, stored};
use super::{Restorer, SnapshotError, inconsistent};
use crate::animation::{PartArray, TimedHook};
use crate::entity::{
    AttackReport, Child, CollisionProfile, CollisionRecord, CollisionReport, Ending, Entities,
    Entity, EnvironmentReport, HouseAccess, Kinetics, ObjectReport, Timestamps, Weenie,
};
use crate::frame::state::{FrameEvent, Step};
use crate::math::{CellId, Frame, Plane, Position, Vec3};
use crate::motion::{Character, MovementManager};
use crate::physics::body::{Body, EntityId, ObjectRef, StaticId, WeenieFlags};
use crate::physics::maintenance::{DestructionQueue, LostCells};
use crate::physics::managers::{
    ConstraintManager, InterpolationManager, InterpolationNode, NodeKind, PositionManager,
    StickyManager, TargetInfo, TargetManager, TargetStatus, Voyeur,
};
use crate::physics::state::{PhysicsState, TransientState};
use crate::physics::transition::{CellArray, CellArrayEntry, LeftFields, TransitionSlots};
use crate::profile::Profile;
use crate::world::CellHandle;

#[cfg(test)]
use super::form::{Forms, define};

stored!(
    enum ObjectRefForm of ObjectRef { Entity(id: EntityId), Static(id: StaticId) }
);
stored!(
    struct CellEntryForm of CellArrayEntry { id: CellId, cell: Option<CellHandle> }
);
stored!(
    struct CellArrayForm of CellArray {
        cells: Vec<CellArrayEntry>,
        added_outside: bool,
        do_not_load_cells: bool,
        free_slots: Vec<u32>,
    }
);
stored!(
    struct WeenieFlagsForm of WeenieFlags {
        present: bool,
        player: bool,
        creature: bool,
        pk: bool,
        pk_lite: bool,
        impenetrable: bool,
        bypasses_restrictions: bool,
        storage: bool,
    }
);
stored!(
    struct BodyForm of Body {
        guid: u32,
        position: Position,
        cell: Option<CellHandle>,
        state: PhysicsState,
        scale: f32,
        part_array: Option<PartArray>,
        weenie: WeenieFlags,
        target: u32,
        parent: Option<ObjectRef>,
        shadows: Vec<CellArrayEntry>,
    }
);
stored!(
    struct KineticsForm of Kinetics {
        transient: TransientState,
        velocity: Vec3,
        acceleration: Vec3,
        omega: Vec3,
        cached_velocity: Vec3,
        friction: f32,
        elasticity: f32,
        contact_plane: Plane,
        contact_plane_cell_id: CellId,
        sliding_normal: Vec3,
        update_time: f64,
        last_move_was_autonomous: bool,
        jumped_this_frame: bool,
        colliding_with_environment: bool,
    }
);
stored!(
    enum NodeKindForm of NodeKind { Position, Jump, Velocity }
);
stored!(
    struct InterpolationNodeForm of InterpolationNode { kind: NodeKind, position: Position, velocity: Vec3 }
);
stored!(
    struct InterpolationForm of InterpolationManager {
        queue: VecDeque<InterpolationNode>,
        keep_heading: bool,
        frame_counter: u32,
        original_distance: f32,
        progress_quantum: f32,
        node_fail_counter: u32,
        blip_to: Option<Position>,
        broken: bool,
    }
);
stored!(
    struct StickyForm of StickyManager {
        target_id: u32,
        target_radius: f32,
        target_position: Position,
        initialized: bool,
        timeout: f64,
    }
);
stored!(
    struct ConstraintForm of ConstraintManager { constrained: bool, pos_offset: f32, start: f32, max: f32 }
);
stored!(
    struct PositionManagerForm of PositionManager {
        interpolation: Option<InterpolationManager>,
        sticky: Option<StickyManager>,
        constraint: Option<ConstraintManager>,
    }
);
stored!(
    enum TargetStatusForm of TargetStatus { Undefined, Ok, ExitWorld, Teleported, Contained, Parented, TimedOut }
);
stored!(
    struct TargetInfoForm of TargetInfo {
        context_id: u32,
        object_id: u32,
        radius: f32,
        quantum: f64,
        target_position: Position,
        interpolated_position: Position,
        interpolated_heading: Vec3,
        velocity: Vec3,
        status: TargetStatus,
        last_update_time: f64,
    }
);
stored!(
    struct VoyeurForm of Voyeur { object_id: u32, radius: f32, quantum: f64, last_sent_position: Position }
);
stored!(
    struct TargetManagerForm of TargetManager {
        target: Option<TargetInfo>,
        voyeurs: Vec<Voyeur>,
        last_update: f64,
    }
);
stored!(
    struct CollisionProfileForm of CollisionProfile { wcid: u32, item_type: u32, flags: u32 }
);
stored!(
    struct HouseAccessForm of HouseAccess { open: bool, guests: Vec<u32> }
);
stored!(
    struct WeenieForm of Weenie {
        run_rate: Option<f32>,
        jump_velocity: Option<f32>,
        can_jump: bool,
        jump_stamina_cost: Option<i32>,
        character: Option<Character>,
        corpse: bool,
        profile: Option<CollisionProfile>,
        house: Option<HouseAccess>,
        collects_reports: bool,
    }
);
stored!(
    struct ObjectReportForm of ObjectReport { guid: u32, velocity: Vec3, profile: Option<CollisionProfile> }
);
stored!(
    struct AttackReportForm of AttackReport { guid: u32, quadrant: u32, part: u32 }
);
stored!(
    struct EnvironmentReportForm of EnvironmentReport { velocity: Vec3, my_contact: bool }
);
stored!(
    enum CollisionReportForm of CollisionReport {
        Object(report: ObjectReport),
        Attack(report: AttackReport),
        Environment(report: EnvironmentReport),
        End(guid: u32),
    }
);
stored!(
    struct ChildForm of Child { object: EntityId, frame: Frame, part: u32, location: i32 }
);
stored!(
    struct CollisionRecordForm of CollisionRecord { guid: u32, touched: f64, ethereal: bool }
);

impl Stored for Timestamps {
    type Form = [u16; 9];

    fn store(&self) -> [u16; 9] {
        self.0
    }

    fn restore(form: [u16; 9], _: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
        Ok(Self(form))
    }

    #[cfg(test)]
    fn describe(_: &mut Forms) -> String {
        "[u16; 9]".into()
    }
}

stored!(
    struct EntityForm of Entity {
        id: EntityId,
        body: Body,
        kin: Kinetics,
        movement: Option<Box<MovementManager>>,
        position_manager: Option<Box<PositionManager>>,
        target_manager: Option<Box<TargetManager>>,
        weenie: Option<Weenie>,
        children: Vec<Child>,
        collision_table: Vec<CollisionRecord>,
        hooks: Vec<TimedHook>,
        timestamps: Timestamps,
        player_vector: Vec3,
        player_distance: f32,
        translucency: f32,
        translucency_original: f32,
        default_script: u32,
        default_script_intensity: f32,
        examination_object: bool,
        attack_radius: f32,
        unposed: bool,
        events: Vec<FrameEvent>,
        steps: Vec<Step>,
        touched: Vec<u32>,
        touched_environment: bool,
        reports: Vec<CollisionReport>,
    }
);

/// The object table and all objects; `guids` in ascending order.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EntitiesForm {
    slots: Vec<Option<Box<EntityForm>>>,
    table: Vec<u32>,
    registered: Vec<bool>,
    guids: Vec<(u32, u32)>,
    resting: Vec<f64>,
    gone: Vec<bool>,
    ending: Vec<EndingForm>,
}

stored!(
    enum HowForm of Ending { Destroyed, Deleted }
);

/// An object that ends when it is put back.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EndingForm {
    entity: u32,
    how: HowForm,
}

impl EntitiesForm {
    /// Parts that wait for their places are stored where they will be.
    pub(super) fn settle(&mut self, entities: &Entities, profile: &Profile) {
        for (form, entity) in self.slots.iter_mut().zip(&entities.slots) {
            let (Some(form), Some(entity)) = (form, entity) else {
                continue;
            };
            let waiting = entity.body.part_array.as_ref();
            if let Some(parts) = waiting.filter(|parts| parts.waits_for_places()) {
                let mut settled = parts.clone();
                settled.settle_parts(profile);
                form.body.part_array = Some(settled).store();
            }
        }
    }
}

impl Stored for Entities {
    type Form = EntitiesForm;

    fn store(&self) -> EntitiesForm {
        let Self {
            slots,
            table,
            registered,
            by_guid,
            resting,
            gone,
            ending,
        } = self;
        let mut guids: Vec<(u32, u32)> = by_guid.iter().map(|(guid, id)| (*guid, id.0)).collect();
        guids.sort_unstable();
        EntitiesForm {
            slots: slots.store(),
            table: table.store(),
            registered: registered.store(),
            guids,
            resting: resting.store(),
            gone: gone.store(),
            ending: ending
                .iter()
                .map(|(id, how)| EndingForm {
                    entity: id.0,
                    how: how.store(),
                })
                .collect(),
        }
    }

    fn restore(form: EntitiesForm, by: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
        let EntitiesForm {
            slots,
            table,
            registered,
            guids,
            resting,
            gone,
            ending,
        } = form;
        by.spend(guids.len())?;
        let mut entities = Self {
            slots: Stored::restore(slots, by)?,
            table: Stored::restore(table, by)?,
            registered: Stored::restore(registered, by)?,
            by_guid: guids
                .into_iter()
                .map(|(guid, id)| (guid, EntityId(id)))
                .collect::<HashMap<_, _>>(),
            resting: Stored::restore(resting, by)?,
            gone: Stored::restore(gone, by)?,
            ending: Vec::new(),
        };
        by.spend(ending.len())?;
        for EndingForm { entity, how } in ending {
            let ending = (EntityId(entity), Ending::restore(how, by)?);
            entities.ending.push(ending);
        }
        check_entities(&entities)?;
        Ok(entities)
    }

    #[cfg(test)]
    fn describe(forms: &mut Forms) -> String {
        define(forms, "EntitiesForm", |forms| {
            format!(
                "\n  slots: {}\n  table: {}\n  registered: list of bool\n  guids: list of (u32, u32)\n  resting: list of f64\n  gone: list of bool\n  \
                 ending: list of {{ entity: u32, how: {} }}",
                Vec::<Option<Box<Entity>>>::describe(forms),
                Vec::<EntityId>::describe(forms),
                Ending::describe(forms),
            )
        })
    }
}

fn check_entities(entities: &Entities) -> Result<(), SnapshotError> {
    let count = entities.slots.len();
    if entities.registered.len() != count
        || entities.resting.len() > count
        || entities.gone.len() != count
    {
        return Err(inconsistent("the lists of entities differ in length"));
    }
    for (index, slot) in entities.slots.iter().enumerate() {
        if slot
            .as_ref()
            .is_some_and(|entity| entity.id.0 as usize != index)
        {
            return Err(inconsistent(format!(
                "entity {index} has the handle of another one"
            )));
        }
    }
    let ending = entities.ending.iter().map(|(id, _)| id);
    let named = entities
        .table
        .iter()
        .chain(entities.by_guid.values())
        .chain(ending);
    for id in named {
        if id.0 as usize >= count {
            return Err(inconsistent(format!("there is no entity {}", id.0)));
        }
    }
    Ok(())
}

stored!(
    struct LeftFieldsForm of LeftFields {
        contact_plane: Plane,
        contact_plane_is_water: bool,
        last_known_contact_plane: Plane,
        last_known_contact_plane_is_water: bool,
        last_known_cell_id: CellId,
        sliding_normal: Vec3,
        collision_normal: Vec3,
    }
);

#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SlotsForm {
    left: Vec<LeftFieldsForm>,
}

impl Stored for TransitionSlots {
    type Form = SlotsForm;

    fn store(&self) -> SlotsForm {
        let Self {
            // No transition runs between two frames.
            level: _,
            left,
            // Memory: what is in it is reset before it is used.
            spare: _,
        } = self;
        SlotsForm { left: left.store() }
    }

    fn restore(form: SlotsForm, by: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
        Ok(Self {
            left: Stored::restore(form.left, by)?,
            ..Self::default()
        })
    }

    #[cfg(test)]
    fn describe(forms: &mut Forms) -> String {
        define(forms, "SlotsForm", |forms| {
            format!("\n  left: {}", Vec::<LeftFields>::describe(forms))
        })
    }
}

/// Lost objects by cell, and those whose cell has come.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LostForm {
    cells: Vec<(u32, Vec<u32>)>,
    arrived: Vec<u32>,
}

impl Stored for LostCells {
    type Form = LostForm;

    fn store(&self) -> LostForm {
        let Self { cells, arrived } = self;
        let cells = cells.iter().map(|(cell, list)| (cell.0, list.store()));
        LostForm {
            cells: cells.collect(),
            arrived: arrived.store(),
        }
    }

    fn restore(form: LostForm, by: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
        by.spend(form.cells.len())?;
        let mut cells = std::collections::BTreeMap::new();
        for (cell, list) in form.cells {
            cells.insert(CellId(cell), Stored::restore(list, by)?);
        }
        Ok(Self {
            cells,
            arrived: Stored::restore(form.arrived, by)?,
        })
    }

    #[cfg(test)]
    fn describe(forms: &mut Forms) -> String {
        define(forms, "LostForm", |_| {
            "\n  cells: list of (u32, list of u32)\n  arrived: list of u32".into()
        })
    }
}

impl Stored for DestructionQueue {
    type Form = Vec<(u32, f64)>;

    fn store(&self) -> Self::Form {
        let Self { due } = self;
        due.iter().map(|(id, time)| (id.0, *time)).collect()
    }

    fn restore(form: Self::Form, by: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
        by.spend(form.len())?;
        let due = form.into_iter().map(|(id, time)| (EntityId(id), time));
        Ok(Self { due: due.collect() })
    }

    #[cfg(test)]
    fn describe(_: &mut Forms) -> String {
        "list of (entity as u32, f64)".into()
    }
}
