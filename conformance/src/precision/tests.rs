//! Small grids on the scenes whose solution is known.

use super::{
    cases,
    grid::{Setting, quick},
    lab::{Options, SceneLab, Subject, run},
    output,
    summary::Order,
};

const PROFILE: &str = "gdle-repaired";

fn subjects() -> Vec<Subject> {
    let subject = |case: cases::Analytic| Subject {
        scene: case.scene.clone(),
        source: case.source.clone(),
        index: None,
        expected: Vec::new(),
        analytic: Some(case),
    };
    cases::all().unwrap().into_iter().map(subject).collect()
}

fn labs(grid: Vec<Setting>) -> Vec<SceneLab> {
    let options = Options {
        profile: PROFILE,
        grid,
        repeats: 0,
        horizon: 10.0,
    };
    run(&subjects(), &options, || ()).unwrap()
}

#[test]
fn the_client_converges_with_the_order_of_its_step() {
    let labs = labs(quick(PROFILE));
    let lab = |name: &str| labs.iter().find(|lab| lab.scene == name).unwrap();
    // Free flight: the step is exact for constant acceleration. What is left is f32 rounding of coordinates of 200 m.
    let flight = lab("analytic/free-flight");
    for row in &flight.rows {
        let error = row.solution.unwrap().max;
        assert!(error < 0.02, "{}: {error}", row.setting.name);
    }
    assert_eq!(flight.order, Order::Exact);
    // Friction: the place moves with the speed at the end of a quantum, which is of first order.
    let Order::Power(order) = lab("analytic/friction").order else {
        panic!("{:?}", lab("analytic/friction").order);
    };
    assert!((order - 1.0).abs() < 0.1, "{order}");
    // Constant omega: exact turns.
    assert_eq!(lab("analytic/omega").order, Order::Exact);
}

#[test]
fn the_reference_of_small_quanta_is_near_the_truth() {
    for lab in labs(vec![Setting::own(PROFILE)]) {
        assert!(
            lab.uncertainty.unwrap() < 0.02,
            "{}: {:?}",
            lab.scene,
            lab.uncertainty
        );
    }
}

#[test]
fn results_are_the_same_every_time() {
    let once = output::document(&labs(quick(PROFILE)));
    let again = output::document(&labs(quick(PROFILE)));
    assert_eq!(once, again);
}

#[test]
fn smooth_phases_are_found_in_flight_and_on_the_ground() {
    for lab in labs(vec![Setting::own(PROFILE), Setting::quanta(PROFILE, 60)]) {
        for row in &lab.rows {
            let smooth = row.smooth.expect("every analytic scene is smooth");
            assert!(smooth.seconds > 5.0, "{}: {smooth:?}", lab.scene);
        }
    }
}
