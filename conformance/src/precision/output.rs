//! Results as tables for people, as CSV and as JSON.

use std::fmt::Write;

use serde_json::{Value, json};

use super::{
    lab::{Row, SceneLab},
    summary::{Against, GOOD, Order, recommendations},
};

/// Schema of the JSON document.
pub const SCHEMA: &str = "ac-conform-precision/1";

/// Everything as one JSON document.
pub fn document(labs: &[SceneLab]) -> Value {
    json!({
        "schema": SCHEMA,
        "machine": crate::status::machine(),
        "build": if cfg!(debug_assertions) { "debug" } else { "release" },
        "good": GOOD,
        "scenes": labs,
        "recommendations": recommendations(labs),
    })
}

/// The header line and one line per scene and setting.
pub fn csv(labs: &[SceneLab]) -> String {
    let mut text = String::from(
        "scene,class,axis,setting,profile,quanta_per_second,frame_rate,remote_every,plan,ns_per_second,instructions_per_second,\
         oracle_max_m,oracle_rms_m,reference_max_m,reference_rms_m,reference_uncertainty_m,solution_max,smooth_max_m,pareto\n",
    );
    for lab in labs {
        for row in &lab.rows {
            csv_line(&mut text, lab, row);
        }
    }
    text
}

fn csv_line(text: &mut String, lab: &SceneLab, row: &Row) {
    let setting = &row.setting;
    let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    let whole = |value: Option<u32>| value.map_or(String::new(), |value| value.to_string());
    let cells = [
        lab.scene.clone(),
        lab.class.clone(),
        setting.axis.name().replace(',', ";"),
        setting.name.replace(',', ";"),
        setting.profile.into(),
        whole(setting.quanta_per_second),
        whole(setting.frame_rate),
        setting.remote_every.to_string(),
        setting
            .plan
            .map_or(String::new(), |plan| format!("{plan:?}").to_lowercase()),
        number(row.ns_per_second),
        number(row.instructions_per_second),
        number(row.oracle.map(|found| found.max)),
        number(row.oracle.map(|found| found.rms)),
        number(row.reference.map(|found| found.max)),
        number(row.reference.map(|found| found.rms)),
        number(lab.uncertainty),
        number(row.solution.map(|found| found.max)),
        number(row.smooth.map(|found| found.max)),
        row.pareto.to_string(),
    ];
    let _ = writeln!(text, "{}", cells.join(","));
}

/// Tables for people: recommendations per class, then every scene.
pub fn human(labs: &[SceneLab], details: bool) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "Cheapest setting with an error below {} over the horizon, in every scene of the class\n",
        length(GOOD)
    );
    let _ = writeln!(
        text,
        "{:<12} {:<8} {:<22} {:>10} {:>14} {:>12}",
        "class", "against", "setting", "error", "per second", "good/scenes"
    );
    for found in recommendations(labs) {
        let against = match found.against {
            Against::Oracle => "oracle",
            Against::Truth => "truth",
        };
        let _ = writeln!(
            text,
            "{:<12} {:<8} {:<22} {:>10} {:>14} {:>12}",
            found.class,
            against,
            found.setting.as_deref().unwrap_or("none"),
            found.error.map_or("–".into(), length),
            found.ns_per_second.map_or("–".into(), duration),
            format!("{}/{}", found.good, found.scenes)
        );
    }
    for lab in labs {
        let _ = writeln!(
            text,
            "\n{}: order {}, reference {}",
            lab.scene,
            order_text(lab.order),
            reference_text(lab)
        );
        if details {
            rows(&mut text, lab);
        }
    }
    text
}

fn rows(text: &mut String, lab: &SceneLab) {
    let _ = writeln!(
        text,
        "  {:<22} {:>11} {:>12} {:>10} {:>10} {:>10} {:>10}",
        "setting", "per second", "instructions", "oracle", "reference", "solution", "smooth"
    );
    for row in &lab.rows {
        let max =
            |found: Option<super::track::Distance>| found.map_or("–".into(), |f| length(f.max));
        let _ = writeln!(
            text,
            "{} {:<22} {:>11} {:>12} {:>10} {:>10} {:>10} {:>10}",
            if row.pareto { '*' } else { ' ' },
            row.setting.name,
            row.ns_per_second.map_or("–".into(), duration),
            row.instructions_per_second
                .map_or("–".into(), |count| format!("{count:.3e}")),
            max(row.oracle),
            max(row.reference),
            max(row.solution),
            row.smooth.map_or("–".into(), |found| length(found.max)),
        );
    }
}

/// How far the reference can be trusted.
pub fn reference_text(lab: &SceneLab) -> String {
    match lab.uncertainty {
        _ if lab.hangs => "none: something hangs in the air".into(),
        Some(uncertainty) => format!("± {}", length(uncertainty)),
        None => "–".into(),
    }
}

/// An order in a few words.
pub fn order_text(order: Order) -> String {
    match order {
        Order::Exact => "exact".into(),
        Order::Power(p) => format!("{p:.2}"),
        Order::None => "none".into(),
        Order::Unknown => "–".into(),
    }
}

/// A length with the unit that suits it.
pub fn length(metres: f64) -> String {
    match metres {
        0.0 => "0".into(),
        m if m < 1e-3 => format!("{:.3} µm", m * 1e6),
        m if m < 1.0 => format!("{:.2} mm", m * 1e3),
        m => format!("{m:.2} m"),
    }
}

/// A time with the unit that suits it.
pub fn duration(nanoseconds: f64) -> String {
    match nanoseconds {
        ns if ns < 1e3 => format!("{ns:.0} ns"),
        ns if ns < 1e6 => format!("{:.1} µs", ns / 1e3),
        ns if ns < 1e9 => format!("{:.2} ms", ns / 1e6),
        ns => format!("{:.2} s", ns / 1e9),
    }
}
