//! Conclusions: the order of convergence, the Pareto front, and the cheapest setting that is good enough.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{
    grid::{Axis, Setting},
    lab::{Row, SceneLab, converges},
};

/// Good enough, m (or rad).
pub const GOOD: f64 = 0.01;
/// Errors below this, m (or rad), are rounding of f32 coordinates.
const ROUNDING: f64 = 1e-3;
/// Quanta per second up to which rounding is not what counts.
const COARSE: f64 = 30.0;
/// Errors of coarse quanta below this, m (or rad), are rounding too.
const EXACT: f64 = 2e-3;

/// How the error falls with the quantum.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind", content = "order")]
pub enum Order {
    /// It does not: at every quantum there is nothing but rounding.
    Exact,
    /// As a power of the quantum.
    Power(f64),
    /// It does not fall with the quantum: something is decided differently.
    None,
    /// Too few quanta were run.
    Unknown,
}

/// The observed order over the settings that only change the quantum.
pub fn order(rows: &[Row]) -> Order {
    let points: Vec<(f64, f64)> = rows
        .iter()
        .filter(|row| converges(&row.setting))
        .filter_map(|row| Some((f64::from(row.setting.quanta_per_second?), row.error()?)))
        .collect();
    if points.len() < 3 {
        return Order::Unknown;
    }
    // Finer quanta round more often: only the coarser half tells whether the step itself is exact.
    let coarse = |quanta: f64| quanta <= COARSE;
    let all = points.iter().filter(|(quanta, _)| coarse(*quanta)).count();
    let exact = |(quanta, error): &&(f64, f64)| coarse(*quanta) && *error < EXACT;
    if all > 1 && points.iter().filter(exact).count() == all {
        return Order::Exact;
    }
    // The finest is the reference itself, and what is near rounding has no slope.
    let logs: Vec<(f64, f64)> = points
        .iter()
        .filter(|(_, error)| *error > ROUNDING)
        .map(|(quanta, error)| (-quanta.log2(), error.log2()))
        .collect();
    match slope(&logs) {
        Some((slope, fit)) if slope > 0.25 && fit > 0.8 => Order::Power(slope),
        Some(_) => Order::None,
        None => Order::Unknown,
    }
}

/// Slope of the line through at least three points, and the share of the variance that it explains.
fn slope(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    if points.len() < 3 {
        return None;
    }
    let n = points.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (mx, my) = (mean(|p| p.0), mean(|p| p.1));
    let sum =
        |f: &dyn Fn(f64, f64) -> f64| points.iter().map(|p| f(p.0 - mx, p.1 - my)).sum::<f64>();
    let (xx, xy, yy) = (sum(&|x, _| x * x), sum(&|x, y| x * y), sum(&|_, y| y * y));
    if xx == 0.0 {
        return None;
    }
    let fit = if yy == 0.0 { 0.0 } else { xy * xy / (xx * yy) };
    Some((xy / xx, fit))
}

/// Marks the rows that no other row beats in both cost and error. Instructions are the cost where every row has them: they do not jitter.
pub fn mark_pareto(rows: &mut [Row]) {
    let counted = rows.iter().all(|row| row.instructions_per_second.is_some());
    let cost = |row: &Row| {
        if counted {
            row.instructions_per_second
        } else {
            row.ns_per_second
        }
    };
    let points: Vec<Option<(f64, f64)>> = rows
        .iter()
        .map(|row| Some((cost(row)?, row.plotted()?)))
        .collect();
    for (row, own) in rows.iter_mut().zip(&points) {
        row.pareto = own.is_some_and(|own| {
            !points.iter().flatten().any(|other| {
                other.0 <= own.0 && other.1 <= own.1 && (other.0 < own.0 || other.1 < own.1)
            })
        });
    }
}

/// What the cheapest good setting is good against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Against {
    /// What the oracle shows.
    Oracle,
    /// What small quanta, or the solution, converge to.
    Truth,
}

/// The cheapest setting of a class whose error stays below [`GOOD`] in every scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Recommendation {
    /// The class.
    pub class: String,
    /// Good against what.
    pub against: Against,
    /// The setting; `None` if none is good enough.
    pub setting: Option<String>,
    /// Its largest error in the class, m (or rad).
    pub error: Option<f64>,
    /// Its time per simulated second over all scenes of the class, ns.
    pub ns_per_second: Option<f64>,
    /// Scenes of the class in which it is good enough; of the best setting if there is none that always is.
    pub good: usize,
    /// Scenes of the class that have such an error.
    pub scenes: usize,
}

/// Two recommendations per class, in order of class.
pub fn recommendations(labs: &[SceneLab]) -> Vec<Recommendation> {
    let mut classes: BTreeMap<&str, Vec<&SceneLab>> = BTreeMap::new();
    for lab in labs {
        classes.entry(&lab.class).or_default().push(lab);
    }
    classes
        .into_iter()
        .flat_map(|(class, labs)| {
            [Against::Oracle, Against::Truth]
                .into_iter()
                .filter_map(move |against| recommend(class, &labs, against))
        })
        .collect()
}

/// A setting over the scenes of a class.
#[derive(Default)]
struct Candidate {
    worst: f64,
    good: usize,
    scenes: usize,
    ns: f64,
    seconds: f64,
    timed: bool,
}

fn recommend(class: &str, labs: &[&SceneLab], against: Against) -> Option<Recommendation> {
    let mut candidates: BTreeMap<usize, (&Setting, Candidate)> = BTreeMap::new();
    for lab in labs {
        for row in &lab.rows {
            let error = match against {
                Against::Oracle => row.oracle.map(|found| found.max),
                Against::Truth => row.error(),
            };
            // Another profile is another behaviour, not a finer or coarser one.
            let (Some(error), true) = (error, row.setting.axis != Axis::Profile) else {
                continue;
            };
            let entry = candidates.entry(place(&row.setting));
            let (_, sum) = entry.or_insert_with(|| (&row.setting, Candidate::default()));
            sum.worst = sum.worst.max(error);
            sum.good += usize::from(error < GOOD);
            sum.scenes += 1;
            sum.ns += row.ns_per_second.unwrap_or(0.0) * lab.seconds;
            sum.seconds += lab.seconds;
            sum.timed |= row.ns_per_second.is_some();
        }
    }
    let scenes = candidates.values().map(|(_, c)| c.scenes).max()?;
    let complete = || candidates.values().filter(|(_, c)| c.scenes == scenes);
    let cheapest = complete()
        .filter(|(_, c)| c.good == scenes)
        .min_by(|a, b| per_second(&a.1).total_cmp(&per_second(&b.1)));
    let best = cheapest.or_else(|| complete().max_by_key(|(_, c)| c.good))?;
    Some(Recommendation {
        class: class.into(),
        against,
        setting: cheapest.map(|(setting, _)| setting.name.clone()),
        error: cheapest.map(|(_, c)| c.worst),
        ns_per_second: cheapest
            .filter(|(_, c)| c.timed)
            .map(|(_, c)| per_second(c)),
        good: best.1.good,
        scenes,
    })
}

fn per_second(candidate: &Candidate) -> f64 {
    candidate.ns / candidate.seconds.max(f64::MIN_POSITIVE)
}

/// A key that is the same for the same setting in every scene: some scenes leave settings out.
fn place(setting: &Setting) -> usize {
    let rate =
        setting.frame_rate.unwrap_or(0) as usize + setting.plan.map_or(0, |plan| plan as usize + 1);
    let quanta = setting.quanta_per_second.unwrap_or(0) as usize;
    let axis = setting.axis as usize;
    ((axis * 1024 + rate) * 1024 + quanta) * 16 + setting.remote_every as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::track::Distance;

    fn row(per_second: u32, ns: f64, error: f64) -> Row {
        let found = Distance {
            max: error,
            rms: error,
            angle: 0.0,
            samples: 1,
        };
        Row {
            setting: Setting::quanta("retail", per_second),
            ns_per_second: Some(ns),
            instructions_per_second: None,
            oracle: None,
            reference: Some(found),
            solution: None,
            smooth: None,
            is_reference: false,
            pareto: false,
        }
    }

    #[test]
    fn orders() {
        let power = |p: f64| -> Vec<Row> {
            [10, 20, 40, 80]
                .map(|n| row(n, 1.0, (10.0 / f64::from(n)).powf(p)))
                .into()
        };
        assert!(matches!(order(&power(1.0)), Order::Power(p) if (p - 1.0).abs() < 1e-9));
        assert!(matches!(order(&power(2.0)), Order::Power(p) if (p - 2.0).abs() < 1e-9));
        assert_eq!(order(&power(0.0)), Order::None);
        assert_eq!(
            order(&[10, 20, 40].map(|n| row(n, 1.0, 1e-5))),
            Order::Exact
        );
        assert_eq!(order(&[]), Order::Unknown);
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let mut rows = [row(10, 1.0, 0.5), row(20, 2.0, 0.1), row(40, 3.0, 0.2)];
        mark_pareto(&mut rows);
        assert_eq!(rows.map(|row| row.pareto), [true, true, false]);
    }

    #[test]
    fn the_cheapest_good_setting_is_recommended() {
        let lab = SceneLab {
            scene: "a/b".into(),
            class: "a".into(),
            seconds: 1.0,
            uncertainty: None,
            hangs: false,
            turns: false,
            order: Order::Unknown,
            rows: vec![row(10, 1.0, 0.5), row(40, 3.0, 0.009), row(80, 9.0, 0.001)],
        };
        let [found] = &recommendations(&[lab])[..] else {
            panic!("one class, one error");
        };
        assert_eq!(found.setting.as_deref(), Some("q 1/40"));
        assert_eq!((found.good, found.scenes), (1, 1));
    }
}
