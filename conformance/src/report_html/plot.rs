//! Plots as SVG text: points and lines on axes of which each is linear or in decades.
//!
//! Everything is drawn here and nothing by a script, so a page of plots works wherever it is opened. Text comes from our own tables and from
//! names of scenes; all of it is escaped.

use std::{fmt::Write, path::Path};

const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 360.0;
const LEFT: f64 = 74.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 46.0;
/// Colours of series.
const COLORS: usize = 7;

/// How an axis is divided and labelled.
#[derive(Clone, Copy)]
pub struct Axis {
    /// What it shows.
    pub label: &'static str,
    /// In decades; what is not positive is drawn at `floor`.
    pub log: bool,
    /// The smallest number that is told apart.
    pub floor: f64,
    /// Text of a number.
    pub text: fn(f64) -> String,
}

/// One point.
#[derive(Clone, Debug, Default)]
pub struct Point {
    /// Across.
    pub x: f64,
    /// Up.
    pub y: f64,
    /// Shown beside it, where there is room.
    pub label: Option<String>,
    /// Shown when pointed at.
    pub title: String,
    /// Drawn larger.
    pub strong: bool,
}

/// Points of one kind.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// Its name in the legend; empty: it has none.
    pub name: String,
    /// Number of its colour, 0 to 6.
    pub color: usize,
    /// The points are joined.
    pub line: bool,
    /// The line is dashed and has no dots: a guide.
    pub guide: bool,
    /// In order.
    pub points: Vec<Point>,
}

/// `<`, `&`, `>` and quotes as HTML wants them.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// Where numbers are on the page.
struct Scale {
    axis: Axis,
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Scale {
    fn new(axis: Axis, numbers: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let value = |n: f64| {
            if axis.log {
                n.max(axis.floor).log10()
            } else {
                n
            }
        };
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for number in numbers.filter(|n| n.is_finite()).map(value) {
            low = low.min(number);
            high = high.max(number);
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        let room = if axis.log {
            0.12 * (high - low).max(1.0)
        } else {
            0.04 * (high - low).max(1e-9)
        };
        Self {
            axis,
            low: low - room,
            high: high + room,
            from,
            to,
        }
    }

    fn at(&self, number: f64) -> f64 {
        let value = if self.axis.log {
            number.max(self.axis.floor).log10()
        } else {
            number
        };
        self.from + (self.to - self.from) * (value - self.low) / (self.high - self.low)
    }

    /// Numbers to label: decades, or five round steps.
    fn ticks(&self) -> Vec<f64> {
        if self.axis.log {
            let (first, last) = (self.low.ceil() as i32, self.high.floor() as i32);
            // Within one decade its halves and fifths help.
            let parts: &[f64] = if last - first < 2 {
                &[1.0, 2.0, 5.0]
            } else {
                &[1.0]
            };
            let every = ((last - first) / 8).max(1);
            return (first - 1..=last)
                .filter(|decade| decade.rem_euclid(every) == 0)
                .flat_map(|decade| parts.iter().map(move |part| part * 10f64.powi(decade)))
                .filter(|tick| (self.low..=self.high).contains(&tick.log10()))
                .collect();
        }
        let raw = (self.high - self.low) / 5.0;
        let power = 10f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|part| part * power)
            .find(|step| *step >= raw)
            .unwrap_or(raw);
        let first = (self.low / step).ceil() as i64;
        let last = (self.high / step).floor() as i64;
        (first..=last).map(|i| i as f64 * step).collect()
    }
}

/// A plot as SVG, with a legend below it.
pub fn svg(title: &str, x: Axis, y: Axis, series: &[Series]) -> String {
    let points = || series.iter().flat_map(|series| &series.points);
    let free = || series.iter().filter(|s| !s.guide).flat_map(|s| &s.points);
    let across = Scale::new(x, points().map(|p| p.x), LEFT, WIDTH - RIGHT);
    let up = Scale::new(y, free().map(|p| p.y), HEIGHT - BOTTOM, TOP);
    let mut text = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">",
        escape(title)
    );
    axes(&mut text, &across, &up);
    for series in series {
        draw(&mut text, series, &across, &up);
    }
    labels(&mut text, series, &across, &up);
    text.push_str("</svg>");
    legend(&mut text, series);
    text
}

fn axes(text: &mut String, x: &Scale, y: &Scale) {
    let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
    for tick in x.ticks() {
        let at = x.at(tick);
        let _ = write!(
            text,
            "<path class=\"grid-line\" d=\"M{at:.1} {TOP}V{bottom}\"/><text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            bottom + 16.0,
            escape(&(x.axis.text)(tick))
        );
    }
    for tick in y.ticks() {
        let at = y.at(tick);
        let _ = write!(
            text,
            "<path class=\"grid-line\" d=\"M{LEFT} {at:.1}H{right}\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            LEFT - 6.0,
            at + 4.0,
            escape(&(y.axis.text)(tick))
        );
    }
    let middle = (TOP + bottom) / 2.0;
    let _ = write!(
        text,
        "<path class=\"axis\" d=\"M{LEFT} {TOP}V{bottom}H{right}\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\
         <text x=\"12\" y=\"{middle}\" text-anchor=\"middle\" transform=\"rotate(-90 12 {middle})\">{}</text>",
        (LEFT + right) / 2.0,
        HEIGHT - 8.0,
        escape(x.axis.label),
        escape(y.axis.label)
    );
}

fn draw(text: &mut String, series: &Series, x: &Scale, y: &Scale) {
    let color = series.color % COLORS;
    let shown = |p: &&Point| p.x.is_finite() && p.y.is_finite();
    if series.line || series.guide {
        let mut path = String::new();
        for (index, point) in series.points.iter().filter(shown).enumerate() {
            let letter = if index == 0 { 'M' } else { 'L' };
            let _ = write!(path, "{letter}{:.1} {:.1}", x.at(point.x), y.at(point.y));
        }
        let class = if series.guide { "guide" } else { "path" };
        let _ = write!(text, "<path class=\"{class} k{color}\" d=\"{path}\"/>");
    }
    if series.guide {
        return;
    }
    for point in series.points.iter().filter(shown) {
        let radius = if point.strong { 5.0 } else { 3.0 };
        let class = if point.strong { "mark strong" } else { "mark" };
        // A long line needs no dots.
        if series.line && series.points.len() > 40 && !point.strong {
            continue;
        }
        let _ = write!(
            text,
            "<circle class=\"{class} k{color}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius}\"><title>{}</title></circle>",
            x.at(point.x),
            y.at(point.y),
            escape(&point.title)
        );
    }
}

/// Labels at the first of four places that is free; without a free place a label is left out, its title remains.
fn labels(text: &mut String, series: &[Series], x: &Scale, y: &Scale) {
    let mut taken: Vec<[f64; 4]> = Vec::new();
    for point in series.iter().flat_map(|s| &s.points) {
        let (px, py) = (x.at(point.x), y.at(point.y));
        if point.strong {
            taken.push([px - 4.0, py - 4.0, px + 4.0, py + 4.0]);
        }
    }
    for point in series.iter().flat_map(|s| &s.points) {
        let Some(label) = &point.label else {
            continue;
        };
        let (px, py) = (x.at(point.x), y.at(point.y));
        let long = label.chars().count() as f64 * 6.0;
        let places = [
            (px + 7.0, py - 5.0),
            (px + 7.0, py + 13.0),
            (px - 7.0 - long, py - 5.0),
            (px - 7.0 - long, py + 13.0),
        ];
        let free = places.into_iter().find(|(lx, ly)| {
            let own = [*lx, ly - 10.0, lx + long, ly + 2.0];
            let inside =
                own[0] > LEFT && own[2] < WIDTH && own[1] > 0.0 && own[3] < HEIGHT - BOTTOM;
            inside && !taken.iter().any(|other| overlap(&own, other))
        });
        if let Some((lx, ly)) = free {
            taken.push([lx, ly - 10.0, lx + long, ly + 2.0]);
            let _ = write!(
                text,
                "<text class=\"label\" x=\"{lx:.1}\" y=\"{ly:.1}\">{}</text>",
                escape(label)
            );
        }
    }
}

fn overlap(a: &[f64; 4], b: &[f64; 4]) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

fn legend(text: &mut String, series: &[Series]) {
    text.push_str("<div class=\"legend\">");
    for series in series.iter().filter(|s| !s.name.is_empty()) {
        let class = if series.guide { "guide" } else { "dot" };
        let _ = write!(
            text,
            "<span><i class=\"{class} b{}\"></i>{}</span>",
            series.color % COLORS,
            escape(&series.name)
        );
    }
    text.push_str("</div>");
}

/// A page of its own: title, one line below it, and what is in it. It needs nothing beside it and has no script.
pub fn page(title: &str, subtitle: &str, body: &str) -> String {
    let style = include_str!("page.css");
    let own = include_str!("plot.css");
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\
         <meta name=\"color-scheme\" content=\"light dark\"><title>{title}</title><style>{style}{own}</style></head>\n\
         <body><main><header><h1>{title}</h1><p class=\"muted\">{subtitle}</p></header>\n{body}</main></body></html>\n",
        title = escape(title),
        subtitle = escape(subtitle),
    )
}

/// The pages of a report.
const PAGES: [(&str, &str); 3] = [
    ("index.html", "Conformance"),
    ("precision.html", "Error against run time"),
    ("stability.html", "Numerical stability"),
];

/// A page with links to the other pages of the report that are in the folder.
pub fn with_links(folder: &Path, file: &str, text: &str) -> String {
    let links: String = PAGES
        .iter()
        .filter(|(other, _)| *other != file && folder.join(other).is_file())
        .map(|(other, title)| format!("<a href=\"{other}\">{title}</a>"))
        .collect();
    if links.is_empty() {
        return text.to_owned();
    }
    text.replacen(
        "</header>",
        &format!("<p class=\"bar\">{links}</p></header>"),
        1,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_link_to_those_that_are_there() {
        let folder = tempfile::tempdir().unwrap();
        let page = page("t", "s", "b");
        assert_eq!(with_links(folder.path(), "precision.html", &page), page);
        std::fs::write(folder.path().join("stability.html"), "").unwrap();
        let linked = with_links(folder.path(), "precision.html", &page);
        assert!(linked.contains("<a href=\"stability.html\">Numerical stability</a>"));
        assert!(!linked.contains("index.html"));
    }

    const PLAIN: Axis = Axis {
        label: "x",
        log: false,
        floor: 0.0,
        text: |n| format!("{n}"),
    };
    const LOG: Axis = Axis {
        label: "y",
        log: true,
        floor: 1e-7,
        text: |n| format!("{n:e}"),
    };

    #[test]
    fn markup_in_names_is_text() {
        let series = Series {
            name: "<b>".into(),
            points: vec![Point {
                x: 1.0,
                y: 0.0,
                label: Some("a & \"b\"".into()),
                ..Point::default()
            }],
            ..Series::default()
        };
        let text = svg("t<", PLAIN, LOG, &[series]);
        assert!(!text.contains("<b>") && text.contains("&lt;b&gt;"));
        assert!(text.contains("a &amp; &quot;b&quot;"));
        assert!(!text.contains("NaN") && !text.contains("inf"));
    }

    #[test]
    fn nothing_is_a_plot_too() {
        let text = svg("t", PLAIN, LOG, &[]);
        assert!(text.starts_with("<svg") && !text.contains("NaN"));
    }

    #[test]
    fn decades_are_labelled() {
        let scale = Scale::new(LOG, [1e-6, 1.0].into_iter(), 0.0, 100.0);
        let ticks = scale.ticks();
        assert!(ticks.len() >= 6, "{ticks:?}");
        assert!(scale.at(1e-6) < scale.at(1.0));
        assert_eq!(scale.at(0.0), scale.at(1e-7));
    }
}
