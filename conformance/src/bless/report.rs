//! A change as a person reads it before saying yes or no.

use std::fmt::Write;

use super::{
    Change, Difference,
    diff::{Place, Sample},
};

/// One change as text: a summary, a line per field with its largest change, and sample frames.
pub fn human(change: &Change) -> String {
    let Difference {
        frames,
        changed,
        gone,
        fields,
        samples,
    } = &change.difference;
    if change.new {
        return format!(
            "{}: {frames} frames, no expectation of its own yet\n",
            change.scene
        );
    }
    let mut text = format!("{}: {changed} of {frames} frames change", change.scene);
    if change.other_scene {
        text += ", the scene itself is another";
    }
    if *gone > 0 {
        let _ = write!(text, ", {gone} frames go");
    }
    text.push('\n');
    for (name, field) in fields {
        let _ = writeln!(
            text,
            "  {name}: {} times from frame {} on; most: {}",
            field.count,
            field.first,
            place(&field.largest, true)
        );
    }
    for sample in samples {
        self::sample(&mut text, sample);
    }
    text
}

fn sample(text: &mut String, sample: &Sample) {
    let _ = writeln!(text, "  frame {}", sample.frame);
    for of in &sample.places {
        let _ = writeln!(text, "    {}", place(of, false));
    }
    if sample.more > 0 {
        let _ = writeln!(text, "    … and {} more", sample.more);
    }
}

fn place(place: &Place, with_frame: bool) -> String {
    let mut text = String::new();
    if with_frame {
        let _ = write!(text, "frame {}, ", place.frame);
    }
    let _ = write!(
        text,
        "0x{:X} {}: {} -> {}",
        place.guid, place.path, place.old, place.new
    );
    if let Some(abs) = place.abs {
        let unit = if place.unit.is_empty() { "" } else { " " };
        let _ = write!(text, " ({abs:.3e}{unit}{})", place.unit);
    }
    text
}
