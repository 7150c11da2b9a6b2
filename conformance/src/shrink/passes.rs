//! What is taken out, and in which order: first what makes every later run cheaper.

use std::ops::Range;

use ac_golden_traces::scene::EntitySpec;

use super::{Candidate, Session, ShrinkError};

/// Takes out what can go, again and again until a round changes nothing.
pub(super) fn all(session: &mut Session<'_>) -> Result<(), ShrinkError> {
    loop {
        let mut changed = false;
        changed |= chunks(
            session,
            |c| c.scene.entities.len(),
            |c, range| c.without_entities(range),
        )?;
        changed |= chunks(
            session,
            |c| c.scene.script.len(),
            |c, range| c.without_steps(range),
        )?;
        changed |= chunks(
            session,
            |c| c.scene.track.len(),
            |c, range| c.without_tracked(range),
        )?;
        if session.judge.may_change_time() {
            changed |= chunks(
                session,
                |c| c.scene.frame_count() as usize,
                |c, range| c.without_frames(range),
            )?;
        }
        changed |= chunks(
            session,
            |c| c.records.len(),
            |c, range| c.without_records(range),
        )?;
        changed |= plainer(session)?;
        if !changed || session.spent() {
            return Ok(());
        }
    }
}

/// Takes out pieces of a list: halves, quarters, and so on to single elements, from the end to the start.
fn chunks(
    session: &mut Session<'_>,
    length: fn(&Candidate) -> usize,
    without: fn(&Candidate, &Range<usize>) -> Candidate,
) -> Result<bool, ShrinkError> {
    let mut changed = false;
    let mut size = length(&session.best).div_ceil(2);
    while size > 0 {
        let mut end = length(&session.best);
        while end > 0 && !session.spent() {
            let start = end.saturating_sub(size);
            let candidate = without(&session.best, &(start..end));
            // What cannot go (the region of a world) changes nothing and needs no run.
            let smaller = length(&candidate) < length(&session.best);
            changed |= smaller && session.attempt(candidate)?;
            // A divergence that comes earlier than before takes the end of the list with it.
            end = start.min(length(&session.best));
        }
        size = if size == 1 { 0 } else { size.div_ceil(2) };
    }
    Ok(changed)
}

/// A way to make an entity plainer; `false`: it already is.
type Plainer = fn(&mut EntitySpec) -> bool;

const PLAINER: [Plainer; 8] = [
    |entity| set(&mut entity.motion_table, 0),
    |entity| set(&mut entity.velocity, [0.0; 3]),
    |entity| set(&mut entity.omega, [0.0; 3]),
    |entity| set(&mut entity.scale, 1.0),
    |entity| set(&mut entity.elasticity, 0.05),
    |entity| set(&mut entity.friction, 0.95),
    |entity| set(&mut entity.run_rate, 1.0),
    |entity| set(&mut entity.jump_velocity, 0.0),
];

fn set<T: PartialEq>(field: &mut T, value: T) -> bool {
    let differs = *field != value;
    *field = value;
    differs
}

/// Gives entities the defaults of the format where that changes nothing that matters.
fn plainer(session: &mut Session<'_>) -> Result<bool, ShrinkError> {
    let mut changed = false;
    for index in 0..session.best.scene.entities.len() {
        for plain in PLAINER {
            let mut scene = session.best.scene.clone();
            if plain(&mut scene.entities[index]) {
                let candidate = session.best.with(scene);
                changed |= session.attempt(candidate)?;
            }
        }
    }
    Ok(changed)
}
