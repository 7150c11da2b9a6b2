//! The form of a world.

use std::sync::Arc;

use super::form::{Stored, stored};
use super::map::{self, MapForm};
use super::objects::{CellArrayForm, EntitiesForm, LostForm, SlotsForm};
use super::{Restorer, SnapshotError};
use crate::profile::Profile;
use crate::world::{Clock, Random, Scratch, World, WorldSource};

#[cfg(test)]
use super::form::{Forms, define};

stored!(
    struct ClockForm of Clock { now: f64, sim_time: f64 }
);
stored!(
    enum RandomForm of Random { Middle, Seeded(state: u64) }
);

#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WorldForm {
    clock: ClockForm,
    land: MapForm,
    entities: EntitiesForm,
    slots: SlotsForm,
    random: RandomForm,
    local_player: Option<Box<u32>>,
    culling_enabled: bool,
    static_animations: Vec<u32>,
    lost: LostForm,
    doomed: Vec<(u32, f64)>,
    touched_cells: CellArrayForm,
    loading_cells: CellArrayForm,
}

pub(super) fn store(world: &World) -> Result<WorldForm, SnapshotError> {
    let World {
        // Given again when the world is restored.
        profile: _,
        clock,
        land,
        // Made of the files; what could not be read shows itself again.
        resources: _,
        entities,
        slots,
        random,
        local_player,
        culling_enabled,
        static_animations,
        lost,
        doomed,
        plan,
        scratch,
        loading_cells,
    } = world;
    if plan.is_some() {
        return Err(SnapshotError::Planned);
    }
    let Scratch {
        // Emptied before each use.
        guids: _,
        hits: _,
        // Under `C-01` a list of cells goes on from what was in it.
        cells,
        // Nothing of it is ever read.
        spare_entity: _,
    } = scratch;
    let mut stored_entities = entities.store();
    stored_entities.settle(entities, &world.profile);
    Ok(WorldForm {
        clock: clock.store(),
        land: map::store(land),
        entities: stored_entities,
        slots: slots.store(),
        random: random.store(),
        local_player: local_player.store(),
        culling_enabled: *culling_enabled,
        static_animations: static_animations.store(),
        lost: lost.store(),
        doomed: doomed.store(),
        touched_cells: cells.store(),
        loading_cells: loading_cells.store(),
    })
}

pub(super) fn restore(
    form: WorldForm,
    source: Arc<dyn WorldSource>,
    profile: Profile,
) -> Result<World, SnapshotError> {
    let WorldForm {
        clock,
        land,
        entities,
        slots,
        random,
        local_player,
        culling_enabled,
        static_animations,
        lost,
        doomed,
        touched_cells,
        loading_cells,
    } = form;
    let mut world = World::with_source(profile, 0.0, source);
    let mut elements = 0;
    map::restore(land, &mut world, &mut elements)?;
    let by = &mut Restorer {
        resources: &mut world.resources,
        profile: &world.profile,
        elements: &mut elements,
    };
    world.clock = Stored::restore(clock, by)?;
    world.entities = Stored::restore(entities, by)?;
    world.slots = Stored::restore(slots, by)?;
    world.random = Stored::restore(random, by)?;
    world.local_player = Stored::restore(local_player, by)?;
    world.culling_enabled = culling_enabled;
    world.static_animations = Stored::restore(static_animations, by)?;
    world.lost = Stored::restore(lost, by)?;
    world.doomed = Stored::restore(doomed, by)?;
    world.scratch.cells = Stored::restore(touched_cells, by)?;
    world.loading_cells = Stored::restore(loading_cells, by)?;
    Ok(world)
}

/// What a world is stored as.
#[cfg(test)]
pub(super) fn describe(forms: &mut Forms) {
    use crate::entity::Entities;
    use crate::physics::maintenance::{DestructionQueue, LostCells};
    use crate::physics::transition::{CellArray, TransitionSlots};

    let land = map::describe(forms);
    let text = format!(
        "\n  clock: {}\n  land: {land}\n  entities: {}\n  slots: {}\n  random: {}\n  local_player: optional u32\n  \
         culling_enabled: bool\n  static_animations: list of u32\n  lost: {}\n  doomed: {}\n  touched_cells: {}\n  \
         loading_cells: CellArrayForm",
        Clock::describe(forms),
        Entities::describe(forms),
        TransitionSlots::describe(forms),
        Random::describe(forms),
        LostCells::describe(forms),
        DestructionQueue::describe(forms),
        CellArray::describe(forms),
    );
    define(forms, "WorldForm", |_| text);
}
