//! `stability.html`: the listed cases, the rules, and what small changes grow to.

use std::{
    collections::BTreeMap,
    fmt::Write,
    path::{Path, PathBuf},
};

use super::{
    ReportError,
    plot::{self, Axis, Point, Series, escape},
};
use crate::stability::{
    ensemble::{Class, Ensemble},
    generators,
    invariants::Violation,
    lab::Report,
    output::sentence,
    trial::Verdict,
};

/// Name of the file in the folder of the report.
pub const FILE: &str = "stability.html";
/// Plots of scenes that amplify; more would make the page heavy.
const PLOTS: usize = 60;

const FRAME: Axis = Axis {
    label: "frame",
    log: false,
    floor: 0.0,
    text: |n| format!("{n}"),
};
const APART: Axis = Axis {
    label: "distance of changed and unchanged run",
    log: true,
    floor: 1e-8,
    text: |m| match m {
        m if m < 1.5e-8 => "≤ 0.01 µm".into(),
        m if m < 0.999e-3 => format!("{} µm", (m * 1e8).round() / 1e2),
        m if m < 0.999 => format!("{} mm", (m * 1e6).round() / 1e3),
        m => format!("{} m", (m * 1e3).round() / 1e3),
    },
};

/// Writes the page into the folder, which is made if it is not there. The answer is the path of the file.
///
/// # Errors
/// When the folder or the file cannot be written.
pub fn write(folder: &Path, report: &Report) -> Result<PathBuf, ReportError> {
    super::write_page(folder, FILE, &page(report))
}

/// The text of the page.
pub fn page(report: &Report) -> String {
    let mut body = String::new();
    tiles(&mut body, report);
    ensembles(&mut body, &report.ensembles);
    cases(&mut body, report);
    scenes(&mut body, report);
    plot::page("Numerical stability", &sentence(report), &body)
}

fn tiles(body: &mut String, report: &Report) {
    let of = |verdict: Verdict| report.cases.iter().filter(|c| c.verdict == verdict).count();
    let checks: u64 = report.cases.iter().map(|c| c.checks).sum::<u64>()
        + report.scenes.iter().map(|s| s.checks).sum::<u64>();
    let tiles = [
        (report.cases.len() as u64, "listed cases"),
        (of(Verdict::Holds) as u64, "hold"),
        (
            of(Verdict::AsRetail) as u64,
            "violate a rule as retail does",
        ),
        (of(Verdict::NoCode) as u64, "without code in this library"),
        (report.ours() as u64, "violations of ours"),
        (checks, "checks"),
    ];
    body.push_str("<div class=\"tiles\">");
    for (number, text) in tiles {
        let _ = write!(body, "<div class=\"tile\"><b>{number}</b>{text}</div>");
    }
    body.push_str("</div>");
}

fn ensembles(body: &mut String, ensembles: &[Ensemble]) {
    if ensembles.is_empty() {
        return;
    }
    body.push_str(
        "<h2>What small changes grow to</h2><p class=\"muted\">Each scene runs again with its start moved by 1 to 8 units in the last place and by 1 µm to 1 mm, \
         and with frames that are longer by units in the last place. Contractive scenes forget the change, neutral ones keep it, growing ones amplify it; in a \
         discontinuous one something is decided differently and the runs part in one frame. Rounding of the clock decides in \
         which frame a quantum runs that is as long as its gate (1/30 s), and in which quantum a frame of an animation is crossed with its root motion: such scenes part by the \
         clock, in every implementation, and show the same places a frame earlier or later.</p>",
    );
    body.push_str("<div class=\"scroll\"><table><thead><tr><th>Area</th>");
    for class in CLASSES {
        let _ = write!(body, "<th class=\"n\">{}</th>", class.name());
    }
    body.push_str("<th class=\"n\">part by the clock</th><th>Parted by</th></tr></thead><tbody>");
    let mut areas: BTreeMap<&str, Vec<&Ensemble>> = BTreeMap::new();
    for ensemble in ensembles {
        areas
            .entry(area(&ensemble.scene))
            .or_default()
            .push(ensemble);
    }
    for (area, ensembles) in &areas {
        let _ = write!(body, "<tr><td>{}</td>", escape(area));
        for class in CLASSES {
            let count = ensembles.iter().filter(|e| e.class == class).count();
            let _ = write!(body, "<td class=\"n\">{count}</td>");
        }
        let clock = ensembles
            .iter()
            .filter(|e| e.clock == Class::Discontinuous)
            .count();
        let _ = write!(body, "<td class=\"n\">{clock}</td>");
        let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
        for event in ensembles
            .iter()
            .flat_map(|e| &e.members)
            .filter_map(|m| m.event.as_ref())
        {
            *kinds.entry(event.kind).or_default() += 1;
        }
        let kinds: Vec<String> = kinds
            .iter()
            .map(|(kind, n)| format!("{kind} ({n})"))
            .collect();
        let _ = write!(body, "<td>{}</td></tr>", kinds.join(", "));
    }
    body.push_str("</tbody></table></div>");
    plots(body, ensembles);
}

const CLASSES: [Class; 4] = [
    Class::Contractive,
    Class::Neutral,
    Class::Growing,
    Class::Discontinuous,
];

fn area(scene: &str) -> &str {
    scene.split('/').next().unwrap_or(scene)
}

/// The largest growth first.
fn plots(body: &mut String, ensembles: &[Ensemble]) {
    let largest = |e: &Ensemble| e.members.iter().map(|m| m.max).fold(0.0, f64::max);
    let mut sorted: Vec<&Ensemble> = ensembles.iter().collect();
    sorted.sort_by(|a, b| {
        b.class
            .cmp(&a.class)
            .then(largest(b).total_cmp(&largest(a)))
    });
    for (class, open) in [
        (Class::Discontinuous, true),
        (Class::Growing, true),
        (Class::Neutral, false),
        (Class::Contractive, false),
    ] {
        let of: Vec<&&Ensemble> = sorted.iter().filter(|e| e.class == class).collect();
        if of.is_empty() {
            continue;
        }
        let shown = of.len().min(if open { PLOTS } else { 8 });
        let _ = write!(
            body,
            "<details{}><summary>{}: {} scenes{}</summary><div class=\"grid\">",
            if class == Class::Discontinuous {
                " open"
            } else {
                ""
            },
            class.name(),
            of.len(),
            if shown < of.len() {
                format!(", the {shown} that differ most")
            } else {
                String::new()
            }
        );
        for ensemble in &of[..shown] {
            plot_of(body, ensemble);
        }
        body.push_str("</div></details>");
    }
}

fn plot_of(body: &mut String, ensemble: &Ensemble) {
    /// Members of the ensemble that are drawn, by their place in it.
    const DRAWN: [usize; 5] = [0, 3, 5, 7, 8];
    let every = ensemble.members.len() < 6;
    let series: Vec<Series> = ensemble
        .members
        .iter()
        .enumerate()
        .filter(|(index, _)| every || DRAWN.contains(index))
        .enumerate()
        .map(|(color, (_, member))| {
            let event = member.event.as_ref();
            let mut points: Vec<Point> = Vec::new();
            for (frame, apart) in &member.series {
                let at_event =
                    event.is_some_and(|e| e.frame <= *frame) && !points.iter().any(|p| p.strong);
                points.push(Point {
                    x: f64::from(*frame),
                    y: *apart,
                    strong: at_event,
                    title: event.map_or(String::new(), |e| {
                        format!("{} in frame {}", e.kind, e.frame)
                    }),
                    label: at_event.then(|| event.map_or("", |e| e.kind).to_owned()),
                });
            }
            Series {
                name: member.change.name(),
                color,
                line: true,
                guide: false,
                points,
            }
        })
        .collect();
    let growth = ensemble
        .members
        .iter()
        .filter_map(|m| m.growth)
        .fold(f64::NEG_INFINITY, f64::max);
    let note = if growth.is_finite() {
        format!(" <span class=\"muted\">up to ×{growth:.3} a frame</span>")
    } else {
        String::new()
    };
    let _ = write!(
        body,
        "<div class=\"card\"><h3>{}{note}</h3>{}</div>",
        escape(&ensemble.scene),
        plot::svg(&ensemble.scene, FRAME, APART, &series)
    );
}

fn cases(body: &mut String, report: &Report) {
    if report.cases.is_empty() {
        return;
    }
    body.push_str("<h2>Stiff and extreme cases that the specification lists</h2>");
    for (section, name) in generators::SECTIONS {
        let of: Vec<_> = report
            .cases
            .iter()
            .filter(|case| case.id.starts_with(section))
            .collect();
        if of.is_empty() {
            continue;
        }
        let _ = write!(
            body,
            "<details><summary>{section} {}: {} cases, {} ours</summary><div class=\"scroll\"><table><thead><tr><th>Case</th><th>What</th><th>Verdict</th>\
             <th class=\"n\">Checks</th><th class=\"n\">Frames</th></tr></thead><tbody>",
            escape(name),
            of.len(),
            of.iter().filter(|c| c.verdict == Verdict::Ours).count()
        );
        for case in of {
            let _ = write!(
                body,
                "<tr><td>{}</td><td>{}{}{}</td><td class=\"{}\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
                case.id,
                escape(&case.title),
                details(&case.violations),
                case.note.as_deref().map_or(String::new(), |note| format!(
                    "<br><span class=\"small\">{}</span>",
                    escape(note)
                )),
                color(case.verdict),
                case.verdict.name(),
                case.checks,
                case.frames
            );
        }
        body.push_str("</tbody></table></div></details>");
    }
}

fn scenes(body: &mut String, report: &Report) {
    let violated: Vec<_> = report
        .scenes
        .iter()
        .filter(|scene| scene.verdict != Verdict::Holds)
        .collect();
    if report.scenes.is_empty() {
        return;
    }
    let _ = write!(
        body,
        "<h2>Rules that must hold in every scene</h2><p class=\"muted\">{} scenes; {} hold every rule in every frame.</p>\
         <div class=\"scroll\"><table><thead><tr><th>Scene</th><th>Verdict</th><th>What does not hold, and where retail shows it</th></tr></thead><tbody>",
        report.scenes.len(),
        report.scenes.len() - violated.len()
    );
    for scene in violated {
        let _ = write!(
            body,
            "<tr><td>{}</td><td class=\"{}\">{}</td><td>{}</td></tr>",
            escape(&scene.scene),
            color(scene.verdict),
            scene.verdict.name(),
            details(&scene.violations)
        );
    }
    body.push_str("</tbody></table></div>");
}

fn color(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "holds",
        Verdict::AsRetail => "retail",
        Verdict::Ours => "ours",
        Verdict::NoCode => "muted",
    }
}

fn details(violations: &[Violation]) -> String {
    let mut text = String::new();
    for violation in violations {
        let frame = violation
            .frame
            .map_or(String::new(), |f| format!(", frame {f}"));
        let _ = write!(
            text,
            "<div class=\"small\">{}{frame}: {} — {}</div>",
            escape(violation.invariant.name()),
            escape(&violation.detail),
            escape(violation.retail.as_deref().unwrap_or("ours"))
        );
    }
    text
}
