//! Pictures of a trace.

use std::io::{Read, Seek, Write};

use ac_client::frame::FrameStates;
use mcap::{McapError, McapResult};

use super::{Level, Look, PictureCounts, PictureWriter, Place};
use crate::GoldenError;
use crate::trace::{ChannelKind, TraceEvent, TraceReader};

/// Draws a trace: what was produced in blue, what is expected transparent in a colour for each oracle, inputs as log.
///
/// # Errors
/// The trace cannot be read, or the pictures cannot be written.
pub fn of_trace<R: Read, W: Write + Seek>(
    trace: &mut TraceReader<R>,
    out: W,
    library: &str,
    path: &std::path::Path,
) -> Result<PictureCounts, GoldenError> {
    let failed = |error: McapError| GoldenError::Io {
        path: path.into(),
        source: std::io::Error::other(error.to_string()),
    };
    let mut pictures = PictureWriter::new(out, library).map_err(failed)?;
    let scene = trace.scene().name.clone();
    pictures
        .log(0, Level::Info, "scene", scene)
        .map_err(failed)?;
    let (mut states, mut now) = (FrameStates::new(), 0);
    trace.select(|kind| !matches!(kind, ChannelKind::Stages(_) | ChannelKind::Clock));
    while let Some(event) = trace.next_event(&mut states)? {
        match event {
            TraceEvent::Script(step) => {
                let text = serde_json::to_string(&*step).unwrap_or_default();
                pictures.log(now, Level::Info, "script", text)
            }
            TraceEvent::States { kind, time, .. } => {
                now = (time.max(0.0) * 1e9) as u64;
                let (prefix, color) = style(kind);
                draw(&mut pictures, now, &prefix, color, &states)
            }
            TraceEvent::Clock(_) | TraceEvent::Stages { .. } => Ok(()),
        }
        .map_err(failed)?;
    }
    let (mut out, counts) = pictures.finish().map_err(failed)?;
    out.flush().map_err(|source| GoldenError::Io {
        path: path.into(),
        source,
    })?;
    Ok(counts)
}

/// Prefix of the ids, and colour.
fn style(kind: &ChannelKind) -> (String, [f64; 4]) {
    match kind {
        ChannelKind::Expect(oracle) => {
            let color = match oracle.as_str() {
                "ace" => [1.0, 0.6, 0.1, 0.4],
                "gdle" => [0.2, 0.8, 0.3, 0.4],
                _ => [0.8, 0.3, 0.8, 0.4],
            };
            (format!("{oracle}/"), color)
        }
        _ => (String::new(), [0.2, 0.5, 1.0, 1.0]),
    }
}

fn draw<W: Write + Seek>(
    pictures: &mut PictureWriter<W>,
    time: u64,
    prefix: &str,
    color: [f64; 4],
    states: &FrameStates,
) -> McapResult<()> {
    for state in states.iter() {
        let id = format!("{prefix}{:08X}", state.guid);
        if state.cell == 0 {
            pictures.remove(time, &id)?;
            continue;
        }
        let look = Look {
            label: id.clone(),
            color,
            facts: Vec::new(),
        };
        let place = Place {
            cell: state.cell,
            origin: state.origin,
            rotation: state.rotation,
        };
        pictures.place(time, &id, &look, &place)?;
    }
    Ok(())
}
