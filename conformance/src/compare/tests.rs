use ac_client::frame::state::{AnimState, ContactPlane, Fields, FrameEvent, FrameState, Step};
use serde_json::json;

use super::{Class, Comparison};

fn state() -> FrameState {
    FrameState {
        has: Fields::all(),
        frame: 3,
        time: 1.5,
        guid: 1,
        cell: 0xA9B4_0001,
        origin: [1.0, 2.0, 3.0],
        contact_plane: Some(ContactPlane::default()),
        anim: Some(AnimState {
            queue: vec![1, 2],
            ..AnimState::default()
        }),
        motion: Some(Default::default()),
        steps: vec![Step::default()],
        events: vec![FrameEvent::HitGround],
        ..FrameState::default()
    }
}

fn compare(expected: &FrameState, actual: &FrameState) -> Comparison {
    let mut comparison = Comparison::default();
    comparison.frame(expected, Some(actual));
    comparison
}

/// Expects one difference, at `field`.
#[track_caller]
fn differs(field: &str, change: impl FnOnce(&mut FrameState)) -> Comparison {
    let mut actual = state();
    change(&mut actual);
    let comparison = compare(&state(), &actual);
    assert_eq!(comparison.frames_exact, 0);
    assert_eq!(
        comparison
            .first_divergence
            .as_ref()
            .expect("a difference")
            .field,
        field
    );
    comparison
}

#[test]
fn equal_records_are_exact() {
    let comparison = compare(&state(), &state());
    assert_eq!(
        (comparison.frames_compared, comparison.frames_exact),
        (1, 1)
    );
    assert_eq!(comparison.class(), Class::Exact);
}

#[test]
fn every_field_is_looked_at() {
    differs("time", |s| s.time = 2.0);
    differs("cell", |s| s.cell = 0xA9B4_0002);
    differs("origin[2]", |s| s.origin[2] = 4.0);
    differs("rotation[0]", |s| s.rotation[0] = -0.0);
    differs("velocity[1]", |s| s.velocity[1] = 1.0);
    differs("acceleration[1]", |s| s.acceleration[1] = 1.0);
    differs("omega[1]", |s| s.omega[1] = 1.0);
    differs("state", |s| s.state = 1);
    differs("transient", |s| s.transient = 1);
    differs("contact_plane", |s| s.contact_plane = None);
    differs("contact_plane.cell", |s| {
        s.contact_plane.as_mut().unwrap().cell = 1
    });
    differs("sliding_normal", |s| s.sliding_normal = Some([0.0; 3]));
    differs("anim", |s| s.anim = None);
    differs("anim.frame_number", |s| {
        s.anim.as_mut().unwrap().frame_number = 1.0
    });
    differs("anim.id", |s| s.anim.as_mut().unwrap().id = 1);
    differs("anim.first_cyclic", |s| {
        s.anim.as_mut().unwrap().first_cyclic = true
    });
    differs("anim.queue[1]", |s| s.anim.as_mut().unwrap().queue[1] = 1);
    differs("anim.queue", |s| s.anim.as_mut().unwrap().queue.clear());
    differs("motion", |s| s.motion = None);
    differs("motion.turn", |s| s.motion.as_mut().unwrap().turn = 1);
    differs("motion.turn_speed", |s| {
        s.motion.as_mut().unwrap().turn_speed = 1.0
    });
    differs("steps[0].dt", |s| s.steps[0].dt = 1.0);
    differs("steps", |s| s.steps.clear());
    differs("collisions", |s| {
        s.collisions
            .push(ac_client::frame::state::Collision::Environment)
    });
    differs("events[0]", |s| s.events[0] = FrameEvent::LeaveGround);
}

#[test]
fn missing_is_a_difference_and_absent_is_left_out() {
    let comparison = differs("velocity", |s| s.has -= Fields::VELOCITY);
    assert_eq!(
        comparison.first_divergence.unwrap().actual,
        json!("missing")
    );
    let expected = FrameState {
        has: Fields::all() - Fields::VELOCITY - Fields::ANIM_ID,
        ..state()
    };
    let mut actual = FrameState {
        velocity: [9.0; 3],
        ..state()
    };
    actual.anim.as_mut().unwrap().id = 9;
    assert_eq!(compare(&expected, &actual).frames_exact, 1);
    let mut none = Comparison::default();
    none.frame(&state(), None);
    assert_eq!(none.first_divergence.unwrap().field, "record");
}

#[test]
fn gone_is_not_there() {
    let mut gone = FrameState::default();
    gone.gone(3, 1.5, 1, &[]);
    assert_eq!(compare(&gone, &gone).frames_exact, 1);
    let outside = FrameState { cell: 0, ..state() };
    assert_eq!(
        compare(&gone, &outside).first_divergence.unwrap().field,
        "record"
    );
    assert_eq!(
        compare(&outside, &gone).first_divergence.unwrap().field,
        "record"
    );
}

#[test]
fn undefined_values_are_counted_apart() {
    let expected = FrameState {
        velocity: [f32::NAN, 0.0, 0.0],
        ..state()
    };
    let actual = FrameState {
        velocity: [-f32::NAN, 0.0, 0.0],
        ..state()
    };
    let comparison = compare(&expected, &actual);
    assert_eq!((comparison.frames_exact, comparison.undefined), (1, 1));
    assert_eq!(compare(&expected, &state()).frames_exact, 0);
    assert_eq!(compare(&state(), &actual).frames_exact, 0);
}

#[test]
fn errors_are_measured_across_landblocks() {
    let expected = FrameState {
        origin: [0.5, 2.0, 3.0],
        cell: 0xAAB4_0001,
        ..state()
    };
    let actual = FrameState {
        origin: [191.75, 2.0, 3.0],
        cell: 0xA9B4_0039,
        ..state()
    };
    let comparison = compare(&expected, &actual);
    assert_eq!(comparison.max_error["origin"].abs, 0.75);
    assert_eq!(comparison.class(), Class::Diverged);
}

#[test]
fn stages_compare_what_is_recorded() {
    let expected = json!({"velocity": [0.0, 1.5], "cell": "0xA", "list": []});
    let mut same = Comparison::default();
    same.stage(
        4,
        "integrate",
        &expected,
        Some(&json!({"velocity": [0, 1.5], "cell": "0x0a", "list": [], "more": 1})),
    );
    assert_eq!(same.frames_exact, 1);
    let mut other = Comparison::default();
    other.stage(
        4,
        "integrate",
        &expected,
        Some(&json!({"velocity": [0, 1.25], "cell": "0xA"})),
    );
    let divergence = other.first_divergence.clone().unwrap();
    assert_eq!(
        (divergence.stage.as_deref(), divergence.field.as_str()),
        (Some("integrate"), "out.velocity[1]")
    );
    assert_eq!(other.max_error["integrate.velocity"].abs, 0.25);
    let mut missing = Comparison::default();
    missing.stage(4, "motion", &expected, None);
    assert_eq!((missing.frames_compared, missing.not_run), (0, 1));
}

fn with_policy(text: &str, expected: &FrameState, actual: &FrameState) -> Comparison {
    let policy = super::policy::Policy::parse(text).expect("a policy");
    let mut comparison = Comparison {
        rules: policy.rules_for("area/name", "gdle"),
        ..Comparison::default()
    };
    comparison.frame(expected, Some(actual));
    comparison
}

fn rule(field: &str, bound: &str) -> String {
    format!("[[tolerance]]\nfield = '{field}'\n{bound}\nreason = 'r'\n")
}

#[test]
fn bounds_hold_to_their_edge_and_no_further() {
    let moved = |z: f32| FrameState {
        origin: [1.0, 2.0, z],
        ..state()
    };
    let class =
        |bound: &str, z: f32| with_policy(&rule("origin", bound), &state(), &moved(z)).class();
    let next = 3.0f32.next_up().next_up();
    for (bound, within, beyond) in [
        ("ulp = 2", next, next.next_up()),
        ("abs = 0.25", 3.25, 3.25f32.next_up()),
        ("rel = 0.25", 4.0, 4.0f32.next_up()),
        ("distance = 0.25", 3.25, 3.25f32.next_up()),
    ] {
        assert_eq!(class(bound, within), Class::WithinTolerance, "{bound}");
        assert_eq!(class(bound, beyond), Class::Diverged, "{bound}");
        assert_eq!(class(bound, 3.0), Class::Exact, "{bound}");
        assert_eq!(class(bound, f32::NAN), Class::Diverged, "{bound}");
    }
    assert_eq!(class("exact = true", 3.0f32.next_up()), Class::Diverged);
}

#[test]
fn orientations_are_compared_by_angle() {
    let turned = |w: f32, z: f32| FrameState {
        rotation: [w, 0.0, 0.0, z],
        ..state()
    };
    let policy = rule("rotation", "angle = 0.001");
    let class = |w, z| with_policy(&policy, &turned(0.8, 0.6), &turned(w, z)).class();
    assert_eq!(class(-0.8, -0.6), Class::WithinTolerance);
    assert_eq!(class(0.8002, 0.5997), Class::WithinTolerance);
    assert_eq!(class(0.81, 0.59), Class::Diverged);
    assert_eq!(class(0.0, 0.0), Class::Diverged);
    assert_eq!(class(f32::NAN, 0.6), Class::Diverged);
}

#[test]
fn positions_are_compared_across_landblock_borders() {
    let at = |cell, x| FrameState {
        origin: [x, 2.0, 3.0],
        cell,
        ..state()
    };
    let (expected, actual) = (at(0xAAB4_0001, 0.125), at(0xA9B4_0039, 191.875));
    let policy = rule("origin", "distance = 0.25");
    let comparison = with_policy(&policy, &expected, &actual);
    assert_eq!(comparison.first_divergence.unwrap().field, "cell");
    let comparison = with_policy(&(policy + &rule("cell", "any = true")), &expected, &actual);
    assert_eq!(comparison.class(), Class::WithinTolerance);
    assert_eq!(comparison.max_error["origin (distance)"].abs, 0.25);
    assert_eq!(
        comparison.tolerated["origin within distance 2.5e-1 m: r"],
        1
    );
}

#[test]
fn no_bound_makes_up_for_what_is_missing() {
    let policy = rule("*", "any = true");
    let mut actual = state();
    actual.has -= Fields::VELOCITY;
    assert_eq!(
        with_policy(&policy, &state(), &actual).class(),
        Class::Diverged
    );
    let none = FrameState {
        contact_plane: None,
        ..state()
    };
    assert_eq!(
        with_policy(&policy, &state(), &none).class(),
        Class::Diverged
    );
    assert_eq!(
        with_policy(&policy, &none, &state()).class(),
        Class::Diverged
    );
    let mut gone = FrameState::default();
    gone.gone(3, 1.5, 1, &[]);
    assert_eq!(
        with_policy(&policy, &state(), &gone).class(),
        Class::Diverged
    );
    let mut absent = Comparison {
        rules: super::policy::Policy::parse(&policy)
            .unwrap()
            .rules_for("a/b", "ace"),
        ..Comparison::default()
    };
    absent.frame(&state(), None);
    assert_eq!(absent.class(), Class::Diverged);
    absent = Comparison {
        first_divergence: None,
        ..absent
    };
    absent.stage(1, "integrate", &json!({"x": 1.0}), Some(&json!({})));
    assert_eq!(absent.class(), Class::Diverged);
}

#[test]
fn a_rule_is_for_the_scenes_it_names_and_needs_a_reason() {
    use super::policy::Policy;
    let policy = Policy::parse(
        "[[tolerance]]\nscene = 'jump/*'\noracle = 'ace'\nfield = 'velocity'\nulp = 1\nreason = 'r'\n[[skip]]\narea = 'extreme'\nreason = 's'",
    )
    .unwrap();
    assert_eq!(policy.rules_for("jump/high", "ace").len(), 1);
    assert!(policy.rules_for("jump/high", "gdle").is_empty());
    assert!(policy.rules_for("walk/high", "ace").is_empty());
    assert_eq!(policy.skips("extreme/far").unwrap().reason, "s");
    assert!(policy.skips("jump/high").is_none());
    let bad = |text: &str| Policy::parse(text).unwrap_err();
    insta::assert_snapshot!(bad(&rule("velocity", "")), @"tolerance of `velocity` needs exactly one of exact, ulp, abs, rel, angle, distance, any");
    insta::assert_snapshot!(bad(&rule("velocity", "abs = nan")), @"tolerance of `velocity`: NaN is no bound");
    insta::assert_snapshot!(bad(&rule("velocity", "angle = 1.0")), @"tolerance of `velocity`: angle is for field `rotation`");
    insta::assert_snapshot!(bad("[[skip]]\nscene = 'a/b'\nreason = ' '"), @"a reason is empty: say why");
    assert!(bad("[[skip]]\nscene = 'a/b'").contains("missing field `reason`"));
}
