//! Motion (`spec/08-motion.md`, 18): formulas at their limits, and scenes of walking, jumping and moving to.

use ac_client::motion::{Command, formulas, heading_diff, heading_greater};
use ac_golden_traces::scene::{Action, EntityKind, HoldKey, MoveParams};

use super::{
    super::{
        stage::{CREATURE, DT, GUID, Run, SIDE, Stage, TURN, WALK, motion, move_to, place},
        trial::Trial,
        worlds::{Playground, spots},
    },
    cases,
    transition::{highest, play, stage},
};

cases! { "08";
    1 "speed 0 and −0 while running, speed not a number" => run_speeds;
    2 "side-step exactly at the clamp" => sidestep_clamp;
    3 "velocity exactly at the cap" => velocity_cap;
    4 "leaving the ground without state velocity" => leave_ground;
    5 "run rate 0 or negative" => run_rates;
    6 "off a ledge while only turning" => turning_off;
    7 "jump extents beyond 1 and near 0" => extents;
    8 "jump in the quantum of landing" => jump_on_landing;
    9 "no cell" => no_cell;
    10 "table without the motion" => missing_motion;
    11 "no motion table" => no_table;
    12 "style change in the air" => style_in_air;
    13 "both directions of an axis held" => both_directions;
    14 "heading goal at the seam" => heading_seam;
    15 "right turn across 0" => turn_across;
    16 "turn rate too small for a quantum" => slow_turn;
    17 "move-to with long quanta" => long_quanta;
    18 "target standing on the mover" => target_here;
    19 "target above or below" => target_above;
    20 "fleeing from a moving target" => fleeing;
    21 "target update during completion" => reentry;
    22 "across landblock seams" => seams;
    23 "fail distance FLT_MAX, goal not a number" => no_failure;
    24 "action stamps half a circle apart" => stamps;
    25 "wire index out of range or 0" => wire_index;
    26 "burden of 2 and more, capacity 0" => burden;
    27 "jump power not a number" => jump_power;
    28 "samples at exactly 1 s" => one_second;
}

fn running(command: u32, speed: f32) -> Action {
    Action::DoMotion {
        command,
        speed,
        hold_key: HoldKey::Run,
    }
}

fn walker(play: &Playground, frames: u32) -> Stage {
    stage(play, frames).walker(play, spots::OPEN, 0.0)
}

fn run_speeds(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for speed in [0.0_f32, -0.0, f32::NAN, f32::MIN_POSITIVE, -1.0, 1e30] {
        for command in [WALK, SIDE, TURN] {
            let run = t.scene(&walker(play, 60).at(3, 0, running(command, speed)).at(
                30,
                0,
                Action::StopCompletely,
            ));
            let still = run.end() == spots::OPEN;
            t.promise(still || speed != 0.0, || {
                format!("speed {speed} moved it to {:?}", run.end())
            });
        }
    }
}

fn sidestep_clamp(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let limit = 2.403_846_f32;
    for rate in [limit.next_down(), limit, limit.next_up(), 5.0] {
        let mut stage = walker(play, 60).at(3, 0, running(SIDE, 1.0));
        stage.scene.entities[0].run_rate = rate;
        let run = t.scene(&stage);
        let speed = run.last(0).motion.map_or(0.0, |m| m.sidestep_speed);
        t.promise(speed.abs() <= 3.0, || {
            format!("run rate {rate}: side-step at {speed}")
        });
    }
}

fn velocity_cap(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for speed in [1.0_f32, 1.0_f32.next_up(), 2.0, 10.0] {
        for side in [false, true] {
            let mut stage = walker(play, 120).at(3, 0, running(WALK, speed)).at(
                20,
                0,
                Action::Jump { extent: 0.5 },
            );
            if side {
                stage = stage.at(3, 0, running(SIDE, speed));
            }
            let run = t.scene(&stage);
            let flat = run
                .first()
                .iter()
                .filter(|s| s.contact_plane.is_none())
                .map(|s| s.velocity[0].hypot(s.velocity[1]))
                .fold(0.0, f32::max);
            t.promise(flat <= 4.0 + 1e-4, || {
                format!("speed {speed}: leaves the ground with {flat} m/s")
            });
        }
    }
}

fn leave_ground(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for speed in [0.0_f32, 6e-5, 1.0] {
        let stage = walker(play, 100).at(3, 0, motion(WALK, speed)).at(
            10,
            0,
            Action::SetVelocity {
                velocity: [1.0, 0.5, 0.0],
            },
        );
        let run = t.scene(&stage.at(11, 0, Action::Jump { extent: 0.4 }));
        t.promise(run.end().iter().all(|c| c.is_finite()), || {
            format!("{:?}", run.end())
        });
    }
}

fn run_rates(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for rate in [0.0_f32, -1.0, -0.0, 1e20, f32::MIN_POSITIVE] {
        let mut stage =
            walker(play, 100)
                .at(3, 0, running(WALK, 1.0))
                .at(20, 0, Action::Jump { extent: 0.5 });
        stage.scene.entities[0].run_rate = rate;
        t.scene(&stage);
    }
}

fn turning_off(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let (x, height) = spots::STEPS[4];
    let base = stage(play, 120)
        .walker(play, [x + 3.9, 20.0, height], 0.0)
        .at(3, 0, motion(TURN, 1.0));
    let run = t.scene(&base.at(
        6,
        0,
        Action::SetVelocity {
            velocity: [2.0, 0.0, 0.5],
        },
    ));
    t.promise(run.end()[0] > x + 4.0, || {
        format!("stays on the step: {:?}", run.end())
    });
    t.promise(run.end()[2].abs() < 0.01, || {
        format!("hangs at {:?}", run.end())
    });
}

fn extents(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for extent in [
        0.0_f32,
        1e-5,
        1.9e-4,
        2e-4,
        0.5,
        1.0,
        1.0_f32.next_up(),
        5.0,
        -1.0,
    ] {
        let run = t.scene(&walker(play, 120).at(3, 0, Action::Jump { extent }));
        // 9 m/s at extent 1 is 4.13 m.
        t.promise(highest(&run) < 4.2, || {
            format!("extent {extent}: {} m high", highest(&run))
        });
        t.promise(run.end()[2].abs() < 0.01, || {
            format!("extent {extent}: ends at {:?}", run.end())
        });
    }
    t.promise(
        formulas::jump_stamina_cost(5.0, 0.5, false, &t.profile.clone())
            > formulas::jump_stamina_cost(1.0, 0.5, false, &t.profile.clone()),
        || "the cost is cut too".into(),
    );
}

fn jump_on_landing(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for frame in 20..40 {
        let stage =
            walker(play, 140)
                .at(3, 0, running(WALK, 1.0))
                .at(5, 0, Action::Jump { extent: 0.3 });
        let run = t.scene(&stage.at(frame, 0, Action::Jump { extent: 0.3 }));
        t.promise(run.end()[2] < 4.2, || format!("{:?}", run.end()));
    }
}

fn no_cell(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let mut stage = walker(play, 60)
        .at(3, 0, motion(WALK, 1.0))
        .at(5, 0, motion(TURN, 1.0))
        .at(9, 0, Action::Jump { extent: 1.0 });
    stage.scene.entities[0].position.cell = 0x7777_0001;
    let run = t.scene(&stage);
    t.same("its cell", run.last(0).cell, 0);
}

fn missing_motion(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for z in [0.0_f32, 15.0] {
        let mut stage =
            stage(play, 80)
                .walker(play, [30.0, 100.0, z], 0.0)
                .at(5, 0, motion(0x4400_0099, 1.0));
        stage = stage
            .at(9, 0, motion(WALK, 1.0))
            .at(30, 0, Action::StopCompletely);
        t.scene(&stage);
        stage.scene.entities[0].motion_table = play.empty_table;
        let run = t.scene(&stage);
        t.promise(run.end()[0] == 30.0, || {
            format!("an empty table moved it to {:?}", run.end())
        });
    }
}

fn no_table(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let mut stage = walker(play, 120).at(3, 0, motion(WALK, 1.0)).at(
        20,
        0,
        move_to(play.home, [40.0, 100.0, 0.0]),
    );
    stage.scene.entities[0].motion_table = 0;
    // A move-to makes the manager; it waits for ever.
    let run = t.scene(&stage);
    t.promise(run.end()[1] <= 100.1, || {
        format!("it steers to {:?}", run.end())
    });
}

fn style_in_air(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let jump = walker(play, 120).at(3, 0, Action::Jump { extent: 0.8 });
    for style in [0x8000_003C, 0x8000_003E, 0x8000_0000] {
        let run = t.scene(
            &jump
                .clone()
                .at(10, 0, motion(style, 1.0))
                .at(60, 0, motion(WALK, 1.0)),
        );
        t.promise(run.last(0).contact_plane.is_some(), || {
            "it does not land".into()
        });
    }
}

fn both_directions(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    const BACK: u32 = 0x4500_0006;
    let release = |command: u32| Action::StopMotion {
        command,
        speed: 1.0,
        hold_key: HoldKey::None,
    };
    let both = walker(play, 120)
        .at(3, 0, motion(WALK, 1.0))
        .at(10, 0, motion(BACK, 1.0));
    let run = t.scene(&both.clone().at(30, 0, release(BACK)));
    // Without a command interpreter nobody presses the other one again.
    let forward = run.last(0).motion.map_or(0, |m| m.forward);
    t.same(
        "forward command after one was released",
        forward,
        0x4100_0003,
    );
    t.scene(&both.at(30, 0, release(WALK)));
}

fn heading_seam(t: &mut Trial) {
    let p = t.profile.clone();
    let right = Command::TURN_RIGHT;
    let near = heading_diff(359.999_94, 0.0, right, &p);
    t.promise(near + ac_client::math::EPSILON > 360.0, || {
        format!("359.99995 is {near} away")
    });
    t.same("a hair", heading_diff(0.0001, 0.0, right, &p), 0.0);
    t.same("half a turn", heading_diff(180.0, 0.0, right, &p), 180.0);
    let Some(play) = play(t) else { return };
    for heading in [
        0.0_f32,
        0.0001,
        180.0,
        359.999_94,
        360.0,
        720.0,
        -90.0,
        f32::NAN,
    ] {
        t.scene(&walker(play, 150).at(
            3,
            0,
            Action::TurnToHeading {
                heading,
                params: MoveParams::default(),
            },
        ));
    }
}

fn turn_across(t: &mut Trial) {
    let right = Command::TURN_RIGHT;
    t.same(
        "own 350, goal 10",
        heading_greater(350.0, 10.0, right),
        false,
    );
    t.same(
        "own 9.99, goal 10",
        heading_greater(9.99, 10.0, right),
        false,
    );
    t.same(
        "own 10.01, goal 10",
        heading_greater(10.01, 10.0, right),
        true,
    );
    let Some(play) = play(t) else { return };
    for dt in [DT, 0.2] {
        let stage = Stage::new(play)
            .frames(dt, 200)
            .walker(play, spots::OPEN, 350.0);
        t.scene(&stage.at(
            3,
            0,
            Action::TurnToHeading {
                heading: 10.0,
                params: MoveParams::default(),
            },
        ));
    }
}

fn slow_turn(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for speed in [1e-5_f32, 1e-3] {
        let params = MoveParams {
            speed: Some(speed),
            ..MoveParams::default()
        };
        t.scene(&walker(play, 200).at(
            3,
            0,
            Action::TurnToHeading {
                heading: 90.0,
                params,
            },
        ));
    }
}

fn long_quanta(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for dt in [0.2, 0.5, 1.5, 1.99] {
        let stage = Stage::new(play)
            .frames(DT, 5)
            .frames(dt, 60)
            .walker(play, spots::OPEN, 0.0);
        let run = t.scene(&stage.at(2, 0, move_to(play.home, [45.0, 100.0, 0.0])));
        let away = (run.end()[0] - 45.0).hypot(run.end()[1] - 100.0);
        t.promise(away < 3.0, || format!("dt {dt}: ends {away} m away"));
    }
}

/// Somebody to move to.
fn with_target(play: &Playground, frames: u32, at: [f32; 3]) -> Stage {
    walker(play, frames).entity(play.walker, at, |spec| {
        spec.kind = EntityKind::Creature;
        spec.motion_table = play.table;
        spec.state = CREATURE;
    })
}

fn follow(params: MoveParams) -> Action {
    Action::MoveToObject {
        target: GUID + 1,
        params,
    }
}

fn target_here(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for distance in [0.0_f32, 0.6] {
        let params = MoveParams {
            distance_to_object: Some(distance),
            ..MoveParams::default()
        };
        t.scene(&with_target(play, 150, [30.0, 100.0, 2.0]).at(3, 0, follow(params)));
        t.scene(&walker(play, 100).at(3, 0, move_to(play.home, spots::OPEN)));
        t.scene(&with_target(play, 150, [30.1, 100.0, 0.0]).at(
            3,
            0,
            Action::TurnToObject {
                target: GUID + 1,
                params,
            },
        ));
    }
}

fn target_above(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for z in [8.0_f32, -8.0] {
        t.scene(&walker(play, 250).at(3, 0, move_to(play.home, [30.0, 100.0, z])));
        t.scene(&walker(play, 250).at(3, 0, move_to(play.home, [30.001, 100.0, z])));
    }
    t.scene(&with_target(play, 200, [30.0, 100.0, 9.0]).at(3, 0, follow(MoveParams::default())));
}

fn fleeing(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    // Flags of a move-to that moves away.
    for bits in [0x0000_0400_u32, 0x0000_0600] {
        let params = MoveParams {
            bitfield: Some(0x0001_EE0F & !0x200 | bits),
            min_distance: Some(15.0),
            ..MoveParams::default()
        };
        let stage = with_target(play, 300, [33.0, 100.0, 0.0]).at(3, 0, follow(params));
        t.scene(
            &stage
                .at(5, 1, motion(WALK, 1.0))
                .at(150, 1, Action::StopCompletely),
        );
    }
}

fn reentry(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let sticky = MoveParams {
        bitfield: Some(0x0001_EE8F),
        ..MoveParams::default()
    };
    let stage = with_target(play, 250, [36.0, 100.0, 0.0]).at(3, 0, follow(sticky));
    t.scene(&stage.clone().at(60, 1, motion(WALK, 1.0)));
    t.scene(
        &stage
            .at(20, 0, follow(sticky))
            .at(20, 0, follow(MoveParams::default()))
            .at(40, 1, Action::Destroy),
    );
}

fn seams(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let east = play.home + 0x0100_0000;
    let stage = stage(play, 400).walker(play, [186.0, 100.0, 0.0], 0.0).at(
        3,
        0,
        move_to(east, [8.0, 104.0, 0.0]),
    );
    let run = t.scene(&stage);
    let last = run.last(0);
    t.same("its landblock", last.cell >> 16, east >> 16);
    let away = (last.origin[0] - 8.0).hypot(last.origin[1] - 104.0);
    t.promise(away < 1.0, || format!("ends {away} m away"));
}

fn no_failure(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let far = MoveParams {
        fail_distance: Some(f32::MAX),
        ..MoveParams::default()
    };
    let goal = |origin: [f32; 3], params| Action::MoveToPosition {
        position: place(play.home, origin),
        params,
    };
    t.scene(&walker(play, 200).at(3, 0, goal([60.0, 110.0, 0.0], far)));
    for origin in [[f32::NAN, 100.0, 0.0], [f32::INFINITY, 100.0, 0.0]] {
        let mut at = goal([30.0; 3], far);
        if let Action::MoveToPosition { position, .. } = &mut at {
            position.origin = origin;
        }
        let run = t.scene(&walker(play, 200).at(3, 0, at));
        t.promise(run.frames() == 200, || "the scene ended".into());
    }
}

fn stamps(t: &mut Trial) {
    // The rule of 15 bits, as the list of actions applies it: see the messages for the way there.
    let newer = |stamp: u32, than: u32| {
        let distance = stamp.wrapping_sub(than) & 0x7FFF;
        (1..0x4000).contains(&distance)
    };
    for (stamp, than, wanted) in [
        (0x3FFF, 0, true),
        (0x4000, 0, false),
        (0, 0x7FFF, true),
        (0x7FFF, 0, false),
        (5, 5, false),
    ] {
        t.same("newer", newer(stamp, than), wanted);
    }
}

fn wire_index(t: &mut Trial) {
    for index in [0_u16, 0xFFFF, 0x0999] {
        let command = Command::from_index(index);
        t.same("command of an index out of range", command.0, 0x8000_0000);
        t.same("is a style", command.is_style(), true);
    }
    let Some(play) = play(t) else { return };
    t.scene(&walker(play, 60).at(
        3,
        0,
        Action::DoInterpretedMotion {
            command: 0x8000_0000,
            speed: 1.0,
        },
    ));
}

fn burden(t: &mut Trial) {
    let p = t.profile.clone();
    t.same("modifier of load 2", formulas::load_mod(2.0), 0.0);
    t.same("run rate of load 2", formulas::run_rate(2.0, 300, &p), 1.0);
    t.same(
        "jump height of load 3",
        formulas::jump_height(3.0, 300, 1.0, &p),
        0.35,
    );
    t.same("load of capacity 0", formulas::load(0, 100), 3.0);
    t.same("load of a negative burden", formulas::load(100, -5), 0.0);
    for (strength, augmentations) in [(i32::MAX, i32::MAX), (i32::MIN, 0), (0, 5)] {
        let _ = formulas::encumbrance_capacity(strength, augmentations);
    }
    t.promise(true, String::new);
}

fn jump_power(t: &mut Trial) {
    let p = t.profile.clone();
    let full = formulas::jump_height(0.5, 200, 1.0, &p);
    t.same(
        "height of a power that is no number",
        formulas::jump_height(0.5, 200, f32::NAN, &p),
        full,
    );
    t.same(
        "height of a power of 9",
        formulas::jump_height(0.5, 200, 9.0, &p),
        full,
    );
    t.promise(formulas::jump_velocity(full).is_finite(), || {
        "no launch speed".into()
    });
}

fn one_second(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    // Blocked by the wall: progress is asked for after a second, not at exactly one, whatever the quanta add up to.
    for dt in [0.05, 0.1, 0.2] {
        let stage = Stage::new(play)
            .starts(0.0)
            .frames(dt, 120)
            .walker(play, spots::WALL, 90.0);
        let run: Run =
            t.scene(&stage.at(2, 0, move_to(play.home, [spots::WALL_X + 10.0, 60.0, 0.0])));
        t.promise(run.end()[0] < spots::WALL_X, || {
            format!("through the wall to {:?}", run.end())
        });
    }
}
