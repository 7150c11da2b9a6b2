//! Lists of the object maintenance: lost objects, and objects that are due for deletion (`spec/06-physics-object.md`, G7).

use std::collections::BTreeMap;

use crate::math::CellId;
use crate::physics::body::EntityId;

/// How long an object may be out of sight before the client deletes it, s.
const DESTRUCTION_TIME: f64 = 25.0;

/// Objects whose cell is not loaded, by cell id.
#[derive(Debug, Clone, Default)]
pub struct LostCells {
    pub(crate) cells: BTreeMap<CellId, Vec<EntityId>>,
    /// Objects whose cell was loaded and who have not re-entered yet, in the order in which the cells came.
    pub(crate) arrived: Vec<EntityId>,
}

impl LostCells {
    /// Puts an object on the list of a cell.
    pub fn insert(&mut self, cell: CellId, entity: EntityId) {
        self.remove(entity);
        self.cells.entry(cell).or_default().push(entity);
    }

    /// Takes an object off whatever list it is on.
    pub fn remove(&mut self, entity: EntityId) {
        self.arrived.retain(|&e| e != entity);
        if self.cells.is_empty() {
            return;
        }
        self.cells.retain(|_, list| {
            list.retain(|&e| e != entity);
            !list.is_empty()
        });
    }

    /// A landblock was loaded (any of its outdoor cells stands for all of them) or an indoor cell: who waited for it is to re-enter.
    pub fn arrive(&mut self, cell: CellId) {
        if self.cells.is_empty() {
            return;
        }
        let cells = if cell.is_indoor() && cell.low() != 0xFFFF {
            cell..=cell
        } else {
            cell.with_low(1)..=cell.with_low(0x40)
        };
        let found: Vec<CellId> = self.cells.range(cells).map(|(&id, _)| id).collect();
        for id in found {
            self.arrived
                .extend(self.cells.remove(&id).into_iter().flatten());
        }
    }

    /// Takes off the objects whose cell was loaded: each is to get `reenter_visibility`.
    pub fn take_arrived(&mut self) -> Vec<EntityId> {
        std::mem::take(&mut self.arrived)
    }

    /// Whether an object is lost.
    pub fn contains(&self, entity: EntityId) -> bool {
        self.cells
            .values()
            .chain([&self.arrived])
            .any(|list| list.contains(&entity))
    }
}

/// Objects out of sight and when they are due, s.
#[derive(Debug, Clone, Default)]
pub struct DestructionQueue {
    pub(crate) due: BTreeMap<EntityId, f64>,
}

impl DestructionQueue {
    /// Queues an object that went out of sight at `now`, s. An object that is queued already keeps its time.
    pub fn insert(&mut self, entity: EntityId, now: f64) {
        self.due.entry(entity).or_insert(now + DESTRUCTION_TIME);
    }

    /// Takes an object off: it is back.
    pub fn remove(&mut self, entity: EntityId) {
        self.due.remove(&entity);
    }

    /// Takes off what is due at `now`, s.
    pub fn due(&mut self, now: f64) -> Vec<EntityId> {
        let due: Vec<_> = self
            .due
            .iter()
            .filter(|(_, time)| **time <= now)
            .map(|(id, _)| *id)
            .collect();
        for id in &due {
            self.due.remove(id);
        }
        due
    }
}
