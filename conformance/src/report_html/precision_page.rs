//! `precision.html`: error against run time, in plots and tables.

use std::{
    collections::BTreeMap,
    fmt::Write,
    path::{Path, PathBuf},
};

use super::{
    ReportError,
    plot::{self, Axis, Point, Series, escape},
};
use crate::precision::{
    grid::{self, Setting},
    lab::{Row, SceneLab},
    output::{duration, length, order_text, reference_text},
    summary::{Against, GOOD, recommendations},
};

/// Name of the file in the folder of the report.
pub const FILE: &str = "precision.html";

const TIME: Axis = Axis {
    label: "run time per simulated second",
    log: true,
    floor: 1.0,
    text: decade_time,
};
const ERROR: Axis = Axis {
    label: "largest error",
    log: true,
    floor: 1e-7,
    text: decade_length,
};
const ANGLE: Axis = Axis {
    text: decade_angle,
    ..ERROR
};
const QUANTUM: Axis = Axis {
    label: "quantum",
    log: true,
    floor: 1e-6,
    text: decade_quantum,
};

fn decade_time(ns: f64) -> String {
    match ns {
        ns if ns < 999.0 => format!("{ns:.0} ns"),
        ns if ns < 0.999e6 => format!("{:.0} µs", ns / 1e3),
        ns if ns < 0.999e9 => format!("{:.0} ms", ns / 1e6),
        ns => format!("{:.0} s", ns / 1e9),
    }
}

fn decade_length(m: f64) -> String {
    match m {
        m if m < 1.5e-7 => "≤ 0.1 µm".into(),
        m if m < 0.999e-3 => format!("{} µm", round(m * 1e6)),
        m if m < 0.999 => format!("{} mm", round(m * 1e3)),
        m => format!("{} m", round(m)),
    }
}

fn decade_angle(rad: f64) -> String {
    match rad {
        r if r < 0.999e-3 => format!("{} µrad", round(r * 1e6)),
        r if r < 0.999 => format!("{} mrad", round(r * 1e3)),
        r => format!("{} rad", round(r)),
    }
}

fn decade_quantum(s: f64) -> String {
    format!("{} ms", round(s * 1e3))
}

/// A round number without noise in its last digits.
fn round(number: f64) -> f64 {
    (number * 1e3).round() / 1e3
}

/// Writes the page into the folder, which is made if it is not there. The answer is the path of the file.
///
/// # Errors
/// When the folder or the file cannot be written.
pub fn write(folder: &Path, labs: &[SceneLab]) -> Result<PathBuf, ReportError> {
    super::write_page(folder, FILE, &page(labs))
}

/// The text of the page.
pub fn page(labs: &[SceneLab]) -> String {
    let mut classes: BTreeMap<&str, Vec<&SceneLab>> = BTreeMap::new();
    for lab in labs {
        classes.entry(&lab.class).or_default().push(lab);
    }
    let mut body = String::new();
    intro(&mut body);
    recommended(&mut body, labs);
    body.push_str("<h2>Classes of scenes</h2><nav>");
    for class in classes.keys() {
        let _ = write!(body, "<a href=\"#{0}\">{0}</a>", escape(class));
    }
    body.push_str("</nav>");
    for (class, labs) in &classes {
        section(&mut body, class, labs);
    }
    let settings = labs.iter().map(|lab| lab.rows.len()).max().unwrap_or(0);
    let subtitle = format!(
        "{} scenes, up to {settings} settings each; ac-conform {}",
        labs.len(),
        env!("CARGO_PKG_VERSION")
    );
    plot::page("Error against run time", &subtitle, &body)
}

fn intro(body: &mut String) {
    body.push_str(
        "<details><summary>What is measured</summary><dl class=\"words\">\
         <dt>run time</dt><dd>Median of interleaved runs of all frames, per simulated second. Landblocks met on the way are loaded in it.</dd>\
         <dt>error against the oracle</dt><dd>What is shown at the frames of the oracle's trace. It contains the lag of the client behind the clock: \
         a finer quantum lags less than retail, and is further from what retail shows.</dd>\
         <dt>error against the truth</dt><dd>The path at the times that were really simulated, against the solution in closed form where there is one, \
         else against the client at quanta of 1/960 s. How far that moves when its quanta are doubled stands as ± at each scene: where it is large, \
         nothing converges, because the rules of retail decide differently at every quantum. Some scenes have no such reference at all: the rest rule stops \
         whatever is slower than 0.25 m/s, so an object that falls from rest never gets going with quanta below 0.025 s and hangs in the air. They are \
         plotted against the oracle.</dd>\
         <dt>smooth phases</dt><dd>Free flight, sliding and turning are integrated again in f64 and extrapolated to a quantum of 0; the number is the client's distance from that.</dd>\
         <dt>Pareto front</dt><dd>Settings with a rim: no other is both cheaper and nearer.</dd></dl></details>",
    );
}

fn recommended(body: &mut String, labs: &[SceneLab]) {
    let _ = write!(
        body,
        "<h2>The cheapest setting with an error below {}</h2><div class=\"scroll\"><table><thead><tr><th>Class</th><th>Against</th><th>Setting</th>\
         <th class=\"n\">Largest error</th><th class=\"n\">Run time per second</th><th class=\"n\">Scenes in which it is</th></tr></thead><tbody>",
        length(GOOD)
    );
    for found in recommendations(labs) {
        let against = match found.against {
            Against::Oracle => "oracle",
            Against::Truth => "truth",
        };
        let _ = write!(
            body,
            "<tr><td><a href=\"#{0}\">{0}</a></td><td>{against}</td><td>{1}</td><td class=\"n\">{2}</td><td class=\"n\">{3}</td><td class=\"n\">{4}/{5}</td></tr>",
            escape(&found.class),
            found
                .setting
                .as_deref()
                .map_or("<span class=\"muted\">none</span>".into(), escape),
            found.error.map_or("–".into(), length),
            found.ns_per_second.map_or("–".into(), duration),
            found.good,
            found.scenes
        );
    }
    body.push_str("</tbody></table></div>");
}

fn section(body: &mut String, class: &str, labs: &[&SceneLab]) {
    let _ = write!(
        body,
        "<section><h2 id=\"{0}\">{0}</h2><div class=\"grid\">",
        escape(class)
    );
    let turning: Vec<&SceneLab> = labs.iter().copied().filter(|lab| lab.turns).collect();
    let moving: Vec<&SceneLab> = labs.iter().copied().filter(|lab| !lab.turns).collect();
    for (labs, error) in [(moving, ERROR), (turning, ANGLE)] {
        if labs.is_empty() {
            continue;
        }
        let mut what = if labs.len() == 1 {
            labs[0].scene.clone()
        } else {
            format!("worst of {} scenes", labs.len())
        };
        let hanging = labs.iter().filter(|lab| lab.hangs).count();
        if hanging > 0 {
            let _ = write!(what, " ({hanging} against the oracle)");
        }
        card(
            body,
            &format!("{what}: error against run time"),
            &work(&labs, error),
        );
        card(
            body,
            &format!("{what}: error against quantum"),
            &convergence(&labs, error),
        );
    }
    body.push_str("</div>");
    let _ = write!(
        body,
        "<details><summary>Settings and scenes of {}</summary>",
        escape(class)
    );
    for lab in labs {
        table(body, lab);
    }
    body.push_str("</details></section>");
}

fn card(body: &mut String, title: &str, svg: &str) {
    let _ = write!(
        body,
        "<div class=\"card\"><h3>{}</h3>{svg}</div>",
        escape(title)
    );
}

/// A setting over scenes: mean time, worst error.
fn merged<'a>(labs: &[&'a SceneLab]) -> Vec<(&'a Setting, f64, f64)> {
    let mut order: Vec<&'a Setting> = Vec::new();
    let mut sums: BTreeMap<&str, (f64, f64, f64)> = BTreeMap::new();
    for lab in labs {
        for row in &lab.rows {
            let (Some(error), Some(ns)) = (row.plotted(), row.ns_per_second) else {
                continue;
            };
            if !sums.contains_key(&*row.setting.name) {
                order.push(&row.setting);
            }
            let sum = sums.entry(&row.setting.name).or_default();
            sum.0 += ns * lab.seconds;
            sum.1 += lab.seconds;
            sum.2 = sum.2.max(error);
        }
    }
    order
        .into_iter()
        .map(|setting| {
            let (ns, seconds, error) = sums[&*setting.name];
            (setting, ns / seconds.max(1e-9), error)
        })
        .collect()
}

fn work(labs: &[&SceneLab], error: Axis) -> String {
    let points = merged(labs);
    let beaten = |own: &(&Setting, f64, f64)| {
        points
            .iter()
            .any(|o| o.1 <= own.1 && o.2 <= own.2 && (o.1 < own.1 || o.2 < own.2))
    };
    let mut series: BTreeMap<grid::Axis, Series> = BTreeMap::new();
    for own in &points {
        let (setting, ns, far) = own;
        let kind = series.entry(setting.axis).or_insert_with(|| Series {
            name: setting.axis.name().into(),
            color: setting.axis as usize,
            ..Series::default()
        });
        let front = !beaten(own);
        kind.points.push(Point {
            x: *ns,
            y: *far,
            label: (front || setting.axis == grid::Axis::Own).then(|| setting.name.clone()),
            title: format!(
                "{}: {}, {}",
                setting.name,
                duration(*ns),
                (error.text)(*far)
            ),
            strong: front,
        });
    }
    let mut front: Vec<Point> = points
        .iter()
        .filter(|own| !beaten(own))
        .map(|(_, ns, far)| Point {
            x: *ns,
            y: *far,
            ..Point::default()
        })
        .collect();
    front.sort_by(|a, b| a.x.total_cmp(&b.x));
    let mut all = vec![Series {
        name: "Pareto front".into(),
        color: 4,
        guide: true,
        line: true,
        points: front,
    }];
    all.extend(series.into_values());
    plot::svg("error against run time", TIME, error, &all)
}

/// Lines of scenes over the quantum, with a guide of first order through the coarsest.
fn convergence(labs: &[&SceneLab], error: Axis) -> String {
    /// More lines than this are a tangle: those with the largest errors are drawn.
    const LINES: usize = 6;
    let mut lines: Vec<Series> = labs
        .iter()
        .filter_map(|lab| {
            let mut points: Vec<Point> = lab
                .rows
                .iter()
                .filter(|row| row.setting.axis == grid::Axis::Quantum)
                .filter_map(|row| point(row, error))
                .collect();
            points.sort_by(|a, b| a.x.total_cmp(&b.x));
            (points.len() > 1).then(|| Series {
                name: format!("{} (order {})", lab.scene, order_text(lab.order)),
                line: true,
                points,
                ..Series::default()
            })
        })
        .collect();
    let worst = |s: &Series| s.points.iter().map(|p| p.y).fold(0.0, f64::max);
    lines.sort_by(|a, b| worst(b).total_cmp(&worst(a)));
    lines.truncate(LINES);
    for (index, line) in lines.iter_mut().enumerate() {
        line.color = index;
    }
    let anchor = lines.first().and_then(|line| line.points.last().cloned());
    if let Some(anchor) = anchor.filter(|anchor| anchor.y > 1e-3) {
        let guide = [1.0 / 960.0, anchor.x].map(|x| Point {
            x,
            y: anchor.y * x / anchor.x,
            ..Point::default()
        });
        lines.push(Series {
            name: "first order".into(),
            color: 4,
            guide: true,
            line: true,
            points: guide.into(),
        });
    }
    plot::svg("error against quantum", QUANTUM, error, &lines)
}

fn point(row: &Row, error: Axis) -> Option<Point> {
    let far = row.plotted()?;
    Some(Point {
        x: 1.0 / f64::from(row.setting.quanta_per_second?),
        y: far,
        title: format!("{}: {}", row.setting.name, (error.text)(far)),
        ..Point::default()
    })
}

fn table(body: &mut String, lab: &SceneLab) {
    let _ = write!(
        body,
        "<h3>{} <span class=\"muted\">order {}, reference {}</span></h3><div class=\"scroll\"><table><thead><tr><th>Setting</th><th class=\"n\">Run time</th>\
         <th class=\"n\">Instructions</th><th class=\"n\">Oracle</th><th class=\"n\">Truth</th><th class=\"n\">Smooth phases</th></tr></thead><tbody>",
        escape(&lab.scene),
        order_text(lab.order),
        reference_text(lab)
    );
    for row in &lab.rows {
        let _ = write!(
            body,
            "<tr><td>{}{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
            escape(&row.setting.name),
            if row.pareto { " ★" } else { "" },
            row.ns_per_second.map_or("–".into(), duration),
            row.instructions_per_second
                .map_or("–".into(), |count| format!("{count:.2e}")),
            row.oracle.map_or("–".into(), |found| length(found.max)),
            row.error().map_or("–".into(), length),
            row.smooth.map_or("–".into(), |found| length(found.max)),
        );
    }
    body.push_str("</tbody></table></div>");
}
