//! Series as compact JSON: fewer points, small integers, one character per error.

use serde_json::{Map, Value, json};

use super::series::{Sample, Series};

/// Most points of a plotted series.
pub const POINTS: usize = 400;

/// Most changes of cell in a timeline; what follows is left out and the script says so.
const CHANGES: usize = 200;

/// Steps over the extent of a path: finer than a screen shows.
const STEPS: f64 = 4000.0;

/// All modes of one scene, oracle and entity. They expect the same, so the expectation is there once.
pub fn group(modes: &[&Series]) -> Value {
    // A mode that ended early (an error elsewhere) is not the one to take the expectation from.
    let Some(longest) = modes.iter().max_by_key(|series| series.expected.len()) else {
        return Value::Null;
    };
    let expected: Vec<Option<Sample>> = longest.expected.iter().copied().map(Some).collect();
    let each: Map<String, Value> = modes
        .iter()
        .map(|series| (series.mode.name().into(), mode(series)))
        .collect();
    json!({
        "frames": [
            longest.expected.first().map(|sample| sample.frame),
            longest.expected.last().map(|sample| sample.frame),
        ],
        "expected": track(&expected),
        "modes": each,
    })
}

fn mode(series: &Series) -> Value {
    let errors: Map<String, Value> = series
        .errors
        .iter()
        .map(|(field, points)| {
            (
                (*field).into(),
                levels(points, series.expected.len()).into(),
            )
        })
        .collect();
    json!({
        "actual": (!series.actual.is_empty()).then(|| track(&series.actual)),
        "errors": errors,
    })
}

/// Path, outcomes and cells of one side.
fn track(samples: &[Option<Sample>]) -> Value {
    let picked: Vec<Option<[f64; 3]>> = picks(samples.len())
        .map(|index| samples[index].and_then(|sample| sample.place))
        .collect();
    let axes: Vec<Value> = (0..3).map(|axis| quantised(&picked, axis)).collect();
    let gaps: Vec<usize> = (0..picked.len())
        .filter(|index| picked[*index].is_none())
        .collect();
    json!({"axes": axes, "gaps": gaps, "outcomes": outcomes(samples), "cells": cells(samples)})
}

/// Indices of the points to keep: first and last are among them.
fn picks(length: usize) -> impl Iterator<Item = usize> {
    let points = length.min(POINTS);
    (0..points).map(move |point| {
        if points < 2 {
            0
        } else {
            point * (length - 1) / (points - 1)
        }
    })
}

/// `[lowest, step, first, difference, difference, ...]`; a gap repeats the point before.
fn quantised(places: &[Option<[f64; 3]>], axis: usize) -> Value {
    let numbers = || places.iter().flatten().map(|place| place[axis]);
    let low = numbers().fold(f64::INFINITY, f64::min);
    let high = numbers().fold(f64::NEG_INFINITY, f64::max);
    if low > high {
        return json!([0, 1]);
    }
    let step = ((high - low) / STEPS).max(1e-6);
    let mut last = 0;
    let mut values = vec![json!(low), json!(step)];
    for place in places {
        let value = place.map_or(last, |place| ((place[axis] - low) / step).round() as i64);
        values.push((value - last).into());
        last = value;
    }
    Value::Array(values)
}

/// One character per point: the worst outcome of its frames as a digit, `-` for none.
fn outcomes(samples: &[Option<Sample>]) -> String {
    bins(samples.len())
        .map(|bin| {
            let worst = samples[bin]
                .iter()
                .flatten()
                .filter_map(|sample| sample.outcome)
                .max();
            worst.map_or('-', |worst| char::from(b'0' + worst.min(9)))
        })
        .collect()
}

/// Ranges of indices of equal length, as many as there are points.
fn bins(length: usize) -> impl Iterator<Item = std::ops::Range<usize>> {
    let points = length.min(POINTS);
    (0..points).map(move |point| point * length / points..(point + 1) * length / points)
}

/// `[frame, cell]` at every change; the cell is text.
fn cells(samples: &[Option<Sample>]) -> Value {
    let mut last = None;
    let mut changes = Vec::new();
    for sample in samples.iter().flatten() {
        if last != Some(sample.cell) {
            last = Some(sample.cell);
            changes.push(json!([sample.frame, format!("{:08X}", sample.cell)]));
            if changes.len() == CHANGES {
                break;
            }
        }
    }
    changes.into()
}

/// One character per point: `.` for no error, else the largest error as [`level`].
fn levels(points: &[(u32, f32)], length: usize) -> String {
    let mut points = points.iter().peekable();
    bins(length)
        .map(|bin| {
            let mut worst: Option<f32> = None;
            while let Some((_, error)) = points.next_if(|(index, _)| (*index as usize) < bin.end) {
                worst = Some(worst.map_or(*error, |worst| worst.max(*error)));
            }
            worst.map_or('.', level)
        })
        .collect()
}

/// Fifths of a decade from 1e-10, counted from the character `/`: 1e-10 and less is `/`, 1e6 and more `~`. The script undoes it.
fn level(error: f32) -> char {
    let steps = ((f64::from(error).log10() + 10.0) * 5.0)
        .round()
        .clamp(0.0, 79.0);
    char::from(b'/' + steps as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_and_last_are_picked() {
        for length in [1, 2, POINTS, POINTS + 1, 100_000] {
            let picked: Vec<usize> = picks(length).collect();
            assert_eq!(picked.first(), Some(&0));
            assert_eq!(picked.last(), Some(&(length - 1)));
            assert!(picked.len() <= POINTS);
        }
        assert_eq!(picks(0).count(), 0);
    }

    #[test]
    fn bins_cover_everything_once() {
        for length in [0, 1, 7, POINTS + 3] {
            let covered: Vec<usize> = bins(length).flatten().collect();
            assert_eq!(covered, (0..length).collect::<Vec<_>>());
        }
    }

    #[test]
    fn errors_are_characters_that_need_no_escape_but_one() {
        assert_eq!(level(0.0), '/');
        assert_eq!(level(1e-10), '/');
        assert_eq!(level(1.0), 'a');
        assert_eq!(level(f32::INFINITY), '~');
        assert_eq!(levels(&[(0, 1.0), (2, f32::INFINITY)], 3), "a.~");
    }

    #[test]
    fn a_path_is_small_differences() {
        let place = |x: f64| Some([x, 0.0, 0.0]);
        let values = quantised(&[place(1.0), None, place(5.0), place(3.0)], 0);
        assert_eq!(values, json!([1.0, 0.001, 0, 0, 4000, -2000]));
    }
}
