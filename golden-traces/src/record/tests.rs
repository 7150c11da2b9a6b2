use ac_client::frame::state::{
    AnimState, Collision, ContactPlane, Fields, FrameEvent, FrameState, FrameStates, MotionState,
    Outcome, Step,
};
use proptest::{collection::vec, option, prelude::*};

use super::{Unknown, fast, read_line, read_message, tree, write_line, write_message};

const LINE: &str = r#"{"frame":-1,"time":1000,"guid":"0x50000001","cell":"0xD010102","origin":[18,-40,-12],"rotation":[6.123234262925839e-17,0,-0.0,-1],"velocity":["nan","inf","-inf"],"acceleration":[0,0,-9.800000190734863],"omega":[0,0,0],"state":"0x400C08","transient":"0x83","contact_plane":{"n":[0,0,1],"d":12,"cell":"0xD010102"},"sliding_normal":null,"anim":{"frame_number":1.6799990236759186,"id":"0x3000001","first_cyclic":true,"queue":["0x3000001","0x3000002"],"velocity":[0,0,0],"omega":[0,0,0]},"motion":{"style":"0x8000003D","substate":"0x41000003","substate_speed":1,"forward":"0x41000003","forward_speed":1,"sidestep":"0x0","sidestep_speed":1,"turn":"0x0","turn_speed":1},"steps":[{"dt":0.03999999910593033,"outcome":"slid"}],"collisions":["environment","0x50000002"],"events":["motion_done:0x41000003","hit_ground","anim_hook:12"]}"#;

fn float() -> impl Strategy<Value = f32> {
    prop_oneof![
        2 => any::<u32>().prop_map(f32::from_bits),
        2 => -1000.0f32..1000.0,
        1 => (-20i8..20).prop_map(f32::from),
        1 => Just(-0.0),
    ]
}

fn double() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<u64>().prop_map(f64::from_bits),
        -1e6f64..1e6,
        (-20i8..20).prop_map(f64::from)
    ]
}

fn vector() -> impl Strategy<Value = [f32; 3]> {
    [float(), float(), float()]
}

fn state() -> impl Strategy<Value = FrameState> {
    let kinematics = (
        vector(),
        [float(), float(), float(), float()],
        vector(),
        vector(),
        vector(),
    );
    let plane = option::of(
        (vector(), float(), any::<u32>()).prop_map(|(n, d, cell)| ContactPlane { n, d, cell }),
    );
    let anim = option::of(
        (
            double(),
            any::<u32>(),
            any::<bool>(),
            vec(any::<u32>(), 0..4),
            vector(),
            vector(),
        )
            .prop_map(|(frame_number, id, first_cyclic, queue, velocity, omega)| {
                AnimState {
                    frame_number,
                    id,
                    first_cyclic,
                    queue,
                    velocity,
                    omega,
                }
            }),
    );
    let motion = option::of(
        (any::<[u32; 5]>(), [float(), float(), float(), float()]).prop_map(|(c, s)| MotionState {
            style: c[0],
            substate: c[1],
            substate_speed: s[0],
            forward: c[2],
            forward_speed: s[1],
            sidestep: c[3],
            sidestep_speed: s[2],
            turn: c[4],
            turn_speed: s[3],
        }),
    );
    let steps = vec(
        (float(), 0usize..6).prop_map(|(dt, outcome)| Step {
            dt,
            outcome: Outcome::ALL[outcome],
        }),
        0..3,
    );
    let collisions = vec(
        prop_oneof![
            Just(Collision::Environment),
            any::<u32>().prop_map(Collision::Object)
        ],
        0..3,
    );
    let events = vec(
        prop_oneof![
            Just(FrameEvent::HitGround),
            Just(FrameEvent::LeaveGround),
            any::<u32>().prop_map(FrameEvent::MotionDone),
            any::<u32>().prop_map(FrameEvent::AnimHook),
        ],
        0..4,
    );
    let ids = (any::<i32>(), double(), any::<[u32; 4]>(), any::<u32>());
    (
        ids,
        kinematics,
        (plane, option::of(vector()), anim, motion),
        (steps, collisions, events),
    )
        .prop_map(
            |(
                (frame, time, words, has),
                (origin, rotation, velocity, acceleration, omega),
                (contact_plane, sliding_normal, anim, motion),
                lists,
            )| {
                let (steps, collisions, events) = lists;
                let mut state = FrameState {
                    has: Fields::from_bits_truncate(has),
                    frame,
                    time,
                    guid: words[0],
                    cell: words[1],
                    origin,
                    rotation,
                    velocity,
                    acceleration,
                    omega,
                    state: words[2],
                    transient: words[3],
                    contact_plane,
                    sliding_normal,
                    anim,
                    motion,
                    steps,
                    collisions,
                    events,
                };
                normalise(&mut state);
                state
            },
        )
}

/// What is absent has no value, and what is null has no parts: the form in which two equal records are equal.
fn normalise(state: &mut FrameState) {
    let blank = FrameState::default();
    let has = state.has;
    let clear = |field, slot: &mut [f32; 3]| {
        if !has.contains(field) {
            *slot = [0.0; 3];
        }
    };
    clear(Fields::ORIGIN, &mut state.origin);
    if !has.contains(Fields::CONTACT_PLANE) {
        state.contact_plane = None;
    }
    if !has.contains(Fields::SLIDING_NORMAL) {
        state.sliding_normal = None;
    }
    if !has.contains(Fields::ANIM) {
        state.anim = None;
    }
    if !has.contains(Fields::MOTION) {
        state.motion = None;
    }
    if state.contact_plane.is_none() {
        state.has -= Fields::PLANE_PARTS;
    }
    if state.anim.is_none() {
        state.has -= Fields::ANIM_PARTS;
    }
    if state.motion.is_none() {
        state.has -= Fields::MOTION_PARTS;
    }
    if !has.contains(Fields::STEPS) {
        state.steps = blank.steps;
    }
    if !has.contains(Fields::COLLISIONS) {
        state.collisions = blank.collisions;
    }
    if !has.contains(Fields::EVENTS) {
        state.events = blank.events;
    }
}

/// Not-a-number loses its payload in text.
fn one_nan(mut state: FrameState) -> FrameState {
    let fix = |number: &mut f32| {
        if number.is_nan() {
            *number = f32::NAN;
        }
    };
    for number in state
        .origin
        .iter_mut()
        .chain(&mut state.velocity)
        .chain(&mut state.acceleration)
        .chain(&mut state.omega)
    {
        fix(number);
    }
    state.rotation.iter_mut().for_each(fix);
    if let Some(plane) = &mut state.contact_plane {
        plane.n.iter_mut().for_each(fix);
        fix(&mut plane.d);
    }
    state.sliding_normal.iter_mut().flatten().for_each(fix);
    if let Some(anim) = &mut state.anim {
        anim.velocity
            .iter_mut()
            .chain(&mut anim.omega)
            .for_each(fix);
        if anim.frame_number.is_nan() {
            anim.frame_number = f64::NAN;
        }
    }
    if let Some(motion) = &mut state.motion {
        for speed in [
            &mut motion.substate_speed,
            &mut motion.forward_speed,
            &mut motion.sidestep_speed,
            &mut motion.turn_speed,
        ] {
            fix(speed);
        }
    }
    state.steps.iter_mut().for_each(|step| fix(&mut step.dt));
    if state.time.is_nan() {
        state.time = f64::NAN;
    }
    state
}

fn by_tree(line: &[u8]) -> FrameState {
    let mut state = FrameState::default();
    tree::line(
        &serde_json::from_slice(line).unwrap(),
        Unknown::Refuse,
        &mut state,
    )
    .unwrap();
    state
}

#[test]
fn the_writer_gives_back_the_line() {
    let mut state = FrameState::default();
    fast::line(LINE.as_bytes(), &mut state).expect("the fast path takes a canonical line");
    let mut text = Vec::new();
    write_line(&mut text, &state);
    assert_eq!(String::from_utf8(text).unwrap(), LINE);
}

#[test]
fn short_records_are_read() {
    for line in [
        r#"{"frame":3,"time":1.5,"guid":"0x1","cell":"0x0","events":["motion_done:0x1"]}"#,
        r#"{"frame":3,"time":1.5,"guid":"0x1","cell":"0x0"}"#,
    ] {
        let mut state = by_tree(LINE.as_bytes());
        fast::line(line.as_bytes(), &mut state).unwrap();
        assert!(state.same_bits(&by_tree(line.as_bytes())), "{line}");
        assert_eq!(state.anim, None);
    }
}

#[test]
fn errors_say_where() {
    let mut state = FrameState::default();
    let mut error = |line: &str| {
        read_line(line.as_bytes(), Unknown::Refuse, &mut state)
            .unwrap_err()
            .to_string()
    };
    insta::assert_snapshot!(error(&LINE.replace("[0,0,1]", "[0,0]")), @"contact_plane.n: has 2 numbers, not 3");
    insta::assert_snapshot!(error(&LINE.replace("\"slid\"", "\"slipped\"")), @"steps[0].outcome: expected the name of an outcome");
    insta::assert_snapshot!(error(&LINE.replace("\"d\":", "\"e\":")), @"contact_plane.e: unknown field");
    insta::assert_snapshot!(error(&LINE.replace("\"guid\"", "\"gid\"")), @"guid: is missing");
    insta::assert_snapshot!(error("{\"frame\":1"), @"record: EOF while parsing an object at line 1 column 10");
}

#[test]
fn a_newer_file_may_have_more_fields() {
    let line = LINE
        .replace("\"omega\"", "\"spin\":[1],\"omega\"")
        .replace("\"id\"", "\"more\":{},\"id\"");
    let mut state = FrameState::default();
    assert!(read_line(line.as_bytes(), Unknown::Refuse, &mut state).is_err());
    read_line(line.as_bytes(), Unknown::Skip, &mut state).unwrap();
    assert!(state.same_bits(&by_tree(LINE.as_bytes())) || state.velocity[0].is_nan());
}

proptest! {
    #[test]
    fn records_survive_text(state in state()) {
        let mut text = Vec::new();
        write_line(&mut text, &state);
        let mut back = FrameState::default();
        read_line(&text, Unknown::Refuse, &mut back).unwrap();
        let again = { let mut again = Vec::new(); write_line(&mut again, &back); again };
        prop_assert_eq!(&text, &again);
        let (a, b) = (one_nan(state), one_nan(back));
        prop_assert!(a.same_bits(&b), "{:?} {:?}", a, b);
        prop_assert!(b.same_bits(&one_nan(by_tree(&text))));
    }

    #[test]
    fn messages_survive_text(list in vec(state(), 0..4), frame: i32, time in -1e9f64..1e9) {
        let mut text = Vec::new();
        write_message(&mut text, frame, time, &list);
        let mut back = FrameStates::new();
        prop_assert_eq!(read_message(&text, Unknown::Refuse, &mut back).unwrap(), (frame, time));
        prop_assert_eq!(back.len(), list.len());
        for (a, b) in list.into_iter().zip(back.iter()) {
            let same = one_nan(FrameState { frame, time, ..a }).same_bits(&one_nan(b.clone()));
            prop_assert!(same);
        }
    }

    #[test]
    fn numbers_are_read_as_the_slow_path_reads_them(text in "-?(0|[1-9][0-9]{0,20})(\\.[0-9]{1,20})?([eE][+-]?[0-9]{1,3})?") {
        let line = format!(r#"{{"frame":0,"time":{text},"guid":"0x1","cell":"0x1","origin":[{text},{text},0]}}"#);
        let mut state = FrameState::default();
        let tree = serde_json::from_str(&line).ok().map(|value| tree::line(&value, Unknown::Refuse, &mut state).map(|()| state.clone()));
        let mut quick = FrameState::default();
        if fast::line(line.as_bytes(), &mut quick).is_some() {
            let tree = tree.expect("the fast path took what JSON refuses").unwrap();
            prop_assert!(quick.same_bits(&tree), "{:?} {:?}", quick, tree);
        }
    }

    #[test]
    fn floats_near_the_middle_round_as_the_slow_path(bits: u32, offset in -3i64..=3) {
        // Halfway between two floats, give or take some last places of the double.
        let wide = f64::from(f32::from_bits(bits & 0x7FFF_FFFF));
        prop_assume!(wide.is_finite());
        let middle = f64::from_bits((wide.to_bits() | 0x1000_0000).wrapping_add_signed(offset));
        let line = format!(r#"{{"frame":0,"time":0,"guid":"0x1","cell":"0x1","origin":[{middle},{middle:e},0]}}"#);
        let mut quick = FrameState::default();
        read_line(line.as_bytes(), Unknown::Refuse, &mut quick).unwrap();
        prop_assert_eq!(quick.origin[0].to_bits(), (middle as f32).to_bits());
        prop_assert_eq!(quick.origin[1].to_bits(), (middle as f32).to_bits());
    }

    #[test]
    fn garbage_is_an_error(text in proptest::string::string_regex("[\\[\\]{}\":,a-z0-9.-]{0,60}").unwrap()) {
        let mut state = FrameState::default();
        let _ = read_line(text.as_bytes(), Unknown::Refuse, &mut state);
        let _ = read_message(text.as_bytes(), Unknown::Skip, &mut FrameStates::new());
    }
}
