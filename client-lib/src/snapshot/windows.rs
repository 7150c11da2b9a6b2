//! Form of the window of landblocks around a player, and of the rooms that are kept with it.

use super::form::Stored;
use super::{SnapshotError, inconsistent};
use crate::math::CellId;
use crate::world::Streaming;
use crate::world::window::LandscapeWindow;

#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StreamingForm {
    radius: i32,
    load_point: u32,
    rooms: Vec<u32>,
}

pub(super) fn store(streaming: &Streaming) -> StreamingForm {
    let Streaming { window, rooms } = streaming;
    let LandscapeWindow {
        radius,
        // They follow from radius and load point.
        slots: _,
        load_point,
    } = window;
    StreamingForm {
        radius: *radius,
        load_point: load_point.store(),
        rooms: rooms.iter().map(|room| room.0).collect(),
    }
}

pub(super) fn restore(form: StreamingForm) -> Result<Streaming, SnapshotError> {
    let StreamingForm {
        radius,
        load_point,
        rooms,
    } = form;
    let mut window = LandscapeWindow::default();
    if !window.set_radius(radius) {
        return Err(inconsistent(format!(
            "there is no window of {radius} blocks"
        )));
    }
    window.update_load_point(CellId(load_point));
    Ok(Streaming {
        window,
        rooms: rooms.into_iter().map(CellId).collect(),
    })
}

/// What it is stored as.
#[cfg(test)]
pub(super) fn describe(forms: &mut super::form::Forms) {
    super::form::define(forms, "StreamingForm", |_| {
        "\n  radius: i32\n  load_point: u32\n  rooms: list of u32".into()
    });
}
