//! Stages run alone, from recorded inputs (`spec/stage-format.md`).

use serde_json::Value;

use super::SceneRun;
use crate::simulation::SimulationError;

/// The `out` of `records[index]` as the client computes it from the record's `in`; `None` for a stage that cannot be run alone.
pub(super) fn run(
    _run: &mut SceneRun,
    _records: &[Value],
    _index: usize,
) -> Result<Option<Value>, SimulationError> {
    Ok(None)
}
