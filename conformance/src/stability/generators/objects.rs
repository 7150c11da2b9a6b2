//! Physics objects (`spec/06-physics-object.md`, H4): clocks, thresholds, placing, attaching, managers.

use ac_client::{frame::state::Outcome, profile::Profile};
use ac_golden_traces::scene::{Action, EntityKind, EntitySpec, OffsetSpec, PositionSpec};

use super::{
    super::{
        invariants::Invariant,
        stage::{CREATURE, DT, FALLS, FLOATS, GUID, MISSILE, Stage, WALK, indoors, motion, place},
        trial::Trial,
        worlds::{Playground, halls, spots},
    },
    cases,
    transition::{STEEP, furthest_east, highest, play, stage},
};

cases! { "06";
    1 "dt at the gates, 0, negative, not-a-number; very large times" => clocks;
    2 "speeds one ulp around the thresholds" => speed_thresholds;
    3 "velocity along the contact normal around its limits" => friction_limits;
    4 "n.z one ulp around the walkable limit and cos 10°" => slope_limits;
    5 "displacement one ulp around epsilon" => epsilon_displacement;
    6 "resting on a slope just too steep" => steep_rest;
    7 "jump apex" => apex;
    8 "bounce between two walls in one frame" => two_walls;
    9 "huge scale, scale 0" => scales;
    10 "root motion that is not a number" => bad_root_motion;
    11 "orientation over 10⁵ steps" => long_spin;
    12 "more than a turn in a step" => fast_spin;
    13 "teleport to bad places" => teleports;
    14 "placed in impossible cells" => bad_cells;
    15 "placement displaced" => displaced;
    16 "parents: self, cycle, again, bad part" => parents;
    17 "ethereal while overlapping" => toggled_ethereal;
    18 "destroyed while something goes on" => destroyed;
    19 "collision table while time jumps" => time_jump;
    20 "flood of interpolations" => interpolations;
    21 "sticky to what is gone, to itself" => sticky;
    22 "constraints without room" => constraints;
    23 "map edge" => map_edge;
    24 "missile inside its owner, against missile" => missiles;
    25 "static and hidden words" => state_words;
}

fn clocks(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let around = |s: f64| [s.next_down(), s, s.next_up()];
    let lengths = around(1.0 / 30.0)
        .into_iter()
        .chain(around(0.2))
        .chain(around(2.0));
    for dt in lengths.chain([0.0, 1e-6, 1e-4, 0.5, 3.0, -0.1, f64::NAN]) {
        for start in [0.0, 1000.0, 1e6, 1e9] {
            let stage = Stage::new(play).starts(start).frames(dt, 12).frames(DT, 12);
            let run = t.scene(&stage.walker(play, spots::OPEN, 90.0).walks(1));
            let gone = (run.end()[0] - spots::OPEN[0]).abs();
            t.promise(
                f64::from(gone) <= 3.2 * 24.0 * dt.abs().max(DT) + 0.5 || dt.is_nan(),
                || format!("dt {dt} at {start}: went {gone} m"),
            );
        }
    }
    // An hour, with a clock that grows.
    let hour = Stage::new(play).starts(1e6).frames(0.05, 72_000);
    let hour =
        hour.walker(play, spots::OPEN, 90.0)
            .at(10, 0, motion(super::super::stage::TURN, 1.0));
    let run = t.scene(&hour);
    let off = run
        .end()
        .iter()
        .zip(spots::OPEN)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f32::max);
    t.promise(off < 0.05, || {
        format!("turning for an hour moved it {off} m")
    });
    let long: f32 = run.last(0).rotation.iter().map(|c| c * c).sum();
    t.promise((long - 1.0).abs() < 1e-3, || {
        format!("squared length of the rotation {long}")
    });
}

fn speed_thresholds(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for speed in [50.0_f32, 0.25, 1.25, 2.5] {
        for speed in [speed.next_down(), speed, speed.next_up()] {
            for state in [FLOATS, FALLS, FALLS | 0x0080_0000] {
                t.scene(&stage(play, 80).entity(play.ball, spots::OPEN, |spec| {
                    spec.state = state;
                    spec.velocity = [speed, 0.0, 0.0];
                }));
            }
        }
    }
    // In the air what is not faster than 0.25 m/s stands.
    let slow = t.scene(
        &stage(play, 20).entity(play.ball, [30.0, 100.0, 20.0], |spec| {
            spec.state = FLOATS;
            spec.velocity = [0.25_f32.next_down(), 0.0, 0.0];
        }),
    );
    t.same("velocity after a while", slow.last(0).velocity, [0.0; 3]);
}

fn friction_limits(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for up in [
        0.25_f32.next_down(),
        0.25,
        0.25_f32.next_up(),
        1.9e-4,
        2e-4,
        2.1e-4,
    ] {
        t.scene(&stage(play, 80).thrown(play.ball, spots::OPEN, [4.0, 0.0, up]));
    }
    // Down over a crest.
    let (x, rise) = spots::RAMPS[0];
    t.scene(
        &stage(play, 150)
            .walker(play, [x + 4.0, 176.0, 4.0 * rise], 90.0)
            .walks(3),
    );
    t.scene(&stage(play, 150).thrown(play.ball, [x + 4.0, 176.0, 4.0 * rise], [5.0, 0.0, 2.0]));
}

fn slope_limits(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    t.as_retail(Invariant::Energy, STEEP);
    for (x, rise) in spots::RAMPS {
        for state in [FALLS, FALLS | 0x0080_0000] {
            t.scene(&stage(play, 200).entity(
                play.ball,
                [x + 4.0, 176.0, 4.0 * rise + 0.5],
                |spec| {
                    spec.state = state;
                    spec.velocity = [0.5, 0.5, 0.0];
                },
            ));
        }
    }
}

fn epsilon_displacement(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let eps = ac_client::math::EPSILON / DT as f32;
    for speed in [eps.next_down(), eps, eps.next_up(), eps * 1.5] {
        t.scene(
            &stage(play, 40).entity(play.ball, [30.0, 100.0, 20.0], |spec| {
                spec.state = FLOATS;
                spec.velocity = [0.3, speed, 0.0];
            }),
        );
    }
    let spin = t.scene(
        &stage(play, 40).entity(play.ball, [30.0, 100.0, 20.0], |spec| {
            spec.state = FLOATS;
            spec.omega = [0.0, 0.0, 1.0];
        }),
    );
    t.promise(!spin.has(Outcome::Failed), || {
        "a turn on the spot failed".into()
    });
}

fn steep_rest(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let (x, rise) = spots::RAMPS[2];
    for height in [0.0_f32, 0.01, 1.0] {
        let run =
            t.scene(&stage(play, 400).walker(play, [x + 4.0, 176.0, 4.0 * rise + height], 0.0));
        t.promise(run.end()[2] > -0.01, || {
            format!("below the ground at {:?}", run.end())
        });
    }
}

fn apex(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for dt in [0.034, 0.04, 0.05, 0.1] {
        let up =
            Stage::new(play)
                .frames(dt, 100)
                .thrown(play.ball, [30.0, 100.0, 0.0], [0.0, 0.0, 9.8]);
        let run = t.scene(&up);
        t.promise(run.end()[2].abs() < 0.01, || {
            format!("dt {dt}: hangs at {:?}", run.end())
        });
    }
    // With quanta below 0.0255 s it never falls again: the rest rule takes away what gravity gives.
    let gravity_gives = |dt: f32| 9.8 * dt;
    t.promise(
        gravity_gives(1.0 / 30.0) > 0.25 && gravity_gives(1.0 / 60.0) < 0.25,
        || "the rest rule".into(),
    );
}

fn two_walls(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let [x, y, z] = halls::CLOSED;
    let low = [x - halls::HALF, y - halls::HALF, z - 0.01];
    let high = [x + halls::HALF, y + halls::HALF, z + 4.0];
    for elasticity in [0.0_f32, 0.05, 0.1] {
        for dt in [DT, 0.2] {
            t.scene(&Stage::new(play).frames(dt, 100).closed(low, high).entity(
                play.ball,
                [0.0; 3],
                |spec| {
                    spec.position = indoors(play.rooms | halls::CLOSED_CELL, [x, y, z + 1.0]);
                    spec.state = FLOATS;
                    spec.velocity = [49.0, 0.0, 0.0];
                    spec.elasticity = elasticity;
                },
            ));
        }
    }
    // Between the walls of the crevice.
    t.scene(&stage(play, 100).entity(
        play.ball,
        [spots::CREVICE[0], spots::CREVICE[1], 3.0],
        |spec| {
            spec.velocity = [0.0, 30.0, -10.0];
            spec.elasticity = 0.1;
        },
    ));
}

fn scales(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for scale in [0.0_f32, 1e-30, 0.1, 0.5, 2.0, 10.0, 100.0] {
        t.as_retail(Invariant::Depth, "06 H4.9: spheres of radius 0 hit nothing");
        t.scene(
            &stage(play, 60)
                .entity(play.walker, spots::OPEN, |spec| {
                    spec.kind = EntityKind::Player;
                    spec.motion_table = play.table;
                    spec.state = CREATURE;
                    spec.scale = scale;
                })
                .walks(3),
        );
        t.scene(
            &stage(play, 60).entity(play.ball, [30.0, 100.0, 40.0], |spec| {
                spec.scale = scale;
                spec.velocity = [3.0, 0.0, 0.0];
            }),
        );
    }
}

fn bad_root_motion(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    t.as_retail(
        Invariant::AnimationFrame,
        "07 16: with an infinite rate what is left of a step is ∞/∞",
    );
    for speed in [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN_POSITIVE * 0.5,
    ] {
        for z in [0.0, 20.0] {
            t.scene(&stage(play, 30).walker(play, [30.0, 100.0, z], 90.0).at(
                3,
                0,
                motion(WALK, speed),
            ));
        }
    }
    for velocity in [
        [f32::NAN, 0.0, 0.0],
        [f32::INFINITY, 0.0, 0.0],
        [0.0, f32::NEG_INFINITY, 0.0],
    ] {
        t.scene(&stage(play, 30).thrown(play.ball, [30.0, 100.0, 5.0], velocity));
    }
}

fn long_spin(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let run = t.scene(
        &stage(play, 100_000).entity(play.ball, [30.0, 100.0, 30.0], |spec| {
            spec.state = FLOATS;
            spec.omega = [0.7, -1.1, 2.3];
        }),
    );
    let long: f64 = run
        .last(0)
        .rotation
        .iter()
        .map(|c| f64::from(*c) * f64::from(*c))
        .sum();
    t.promise((long.sqrt() - 1.0).abs() < 1e-6, || {
        format!("length {}", long.sqrt())
    });
    let slow = t.scene(
        &stage(play, 100).entity(play.ball, [30.0, 100.0, 30.0], |spec| {
            spec.state = FLOATS;
            spec.omega = [0.0, 0.0, 0.0049];
        }),
    );
    t.same(
        "a turn below epsilon",
        slow.last(0).rotation,
        [1.0, 0.0, 0.0, 0.0],
    );
}

fn fast_spin(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for omega in [157.1_f32, 160.0, 1e4, 1e8, f32::MAX] {
        let run = t.scene(
            &stage(play, 60).entity(play.ball, [30.0, 100.0, 30.0], |spec| {
                spec.state = FLOATS;
                spec.omega = [0.0, 0.0, omega];
            }),
        );
        let finite = run.last(0).rotation.iter().all(|c| c.is_finite());
        t.promise(finite || omega == f32::MAX, || {
            format!("omega {omega}: {:?}", run.last(0).rotation)
        });
    }
    t.as_retail(
        Invariant::Finite,
        "06 H4.12, 01 8.3: the sine of a turn that overflows is not a number",
    );
}

/// Flags of a placement: teleport with and without sliding.
const PLACE: [u32; 3] = [0x0, 0x10, 0x1012];

fn moved_to(play: &Playground, to: PositionSpec, flags: u32) -> Stage {
    stage(play, 40)
        .walker(play, spots::OPEN, 0.0)
        .at(
            5,
            0,
            Action::SetPosition {
                position: to,
                flags,
            },
        )
        .walks(20)
}

fn teleports(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let rock = indoors(
        play.rooms | halls::CLOSED_CELL,
        [
            halls::CLOSED[0] + 3.95,
            halls::CLOSED[1],
            halls::FLOOR + 0.1,
        ],
    );
    let places = [
        place(0x7777_0000, [90.0, 90.0, 0.0]),
        place(play.home, [-5000.0, 90.0, 0.0]),
        place(play.home, [90.0, 1e6, 0.0]),
        place(play.home, [spots::WALL_X, 60.0, 0.5]),
        place(play.home, [14.0, 20.0, 0.1]),
        rock,
    ];
    for to in places {
        for flags in PLACE {
            t.scene(&moved_to(play, to, flags));
        }
    }
    // Onto another player, and onto an open door.
    for state in [CREATURE, 0x0000_000C] {
        let both = moved_to(play, place(play.home, [50.0, 100.0, 0.0]), PLACE[1]);
        t.scene(&both.entity(play.walker, [50.0, 100.0, 0.0], |spec| {
            spec.kind = EntityKind::Player;
            spec.state = state;
        }));
    }
}

fn bad_cells(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for low in [0x0041, 0x00FF, 0xFFFE, 0xFFFF, 0x0000, 0x01FF] {
        let to = PositionSpec {
            cell: play.home | low,
            ..place(play.home, [90.0, 90.0, 0.0])
        };
        for flags in PLACE {
            let run = t.scene(&moved_to(play, to, flags));
            t.promise(run.last(0).cell & 0xFFFF != 0x41, || {
                "it is in cell 0x41".into()
            });
        }
        t.scene(
            &stage(play, 10).entity(play.ball, [90.0, 90.0, 1.0], |spec| {
                spec.position.cell = play.home | low
            }),
        );
    }
}

fn displaced(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    // Into a crate: the search moves it out.
    for dx in [-1.9_f32, -1.0, 0.0, 1.0, 1.9] {
        let stage = stage(play, 40).entity(play.crate_, [60.0, 100.0, 0.0], |spec| {
            spec.state = 0x0001_0008
        });
        t.scene(&stage.walker(play, [60.0 + dx, 100.0, 0.0], 0.0));
    }
}

fn parents(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let hold = |parent: u32, part: i32| Action::SetParent {
        parent: GUID + parent,
        part,
        offset: OffsetSpec {
            origin: [0.0, 0.0, 1.0],
            rotation: [1.0, 0.0, 0.0, 0.0],
        },
    };
    let pair = || {
        let stage = stage(play, 60).walker(play, spots::OPEN, 90.0).thrown(
            play.ball,
            [33.0, 100.0, 0.0],
            [0.0; 3],
        );
        stage.entity(play.ghost, [34.0, 100.0, 0.0], |spec| spec.state = FLOATS)
    };
    t.scene(&pair().at(3, 0, hold(0, -1)).walks(10));
    t.scene(&pair().at(3, 1, hold(0, -1)).at(5, 0, hold(1, -1)).walks(10));
    t.scene(
        &pair()
            .at(3, 1, hold(0, -1))
            .at(5, 2, hold(1, -1))
            .at(7, 0, hold(2, -1))
            .walks(10),
    );
    t.scene(
        &pair()
            .at(3, 1, hold(0, -1))
            .at(5, 1, hold(0, -1))
            .at(7, 1, Action::UnsetParent)
            .walks(10),
    );
    for part in [0, 1, 99, -2, i32::MAX] {
        t.scene(&pair().at(3, 1, hold(0, part)).walks(10));
    }
    t.scene(&pair().at(3, 0, Action::Destroy).at(5, 1, hold(0, -1)));
}

fn toggled_ethereal(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let base = stage(play, 100).walker(play, spots::OPEN, 90.0).entity(
        play.walker,
        [30.2, 100.0, 0.0],
        |spec| {
            spec.kind = EntityKind::Creature;
            spec.state = CREATURE | 4;
        },
    );
    t.scene(&base.clone().at(20, 1, Action::SetState { state: CREATURE }));
    let both = base.at(
        10,
        0,
        Action::SetState {
            state: CREATURE | 4,
        },
    );
    let both = both.at(20, 0, Action::SetState { state: CREATURE }).at(
        20,
        1,
        Action::SetState { state: CREATURE },
    );
    t.scene(&both.walks(40));
}

fn destroyed(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let throw = || {
        stage(play, 60)
            .thrown(play.ball, [30.0, 100.0, 1.0], [8.0, 0.0, 0.0])
            .entity(play.boulder, [36.0, 100.0, 0.0], |spec| spec.state = 8)
    };
    for frame in 10..24 {
        t.scene(&throw().at(frame, 1, Action::Destroy));
        t.scene(&throw().at(frame, 0, Action::Destroy));
    }
    let walk = stage(play, 60).walker(play, spots::OPEN, 90.0).walks(3).at(
        9,
        0,
        Action::Jump { extent: 0.5 },
    );
    t.scene(&walk.at(12, 0, Action::Destroy).at(30, 0, motion(WALK, 1.0)));
}

fn time_jump(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let stage = Stage::new(play)
        .frames(DT, 40)
        .frames(2.5, 1)
        .frames(DT, 40)
        .frames(1.9, 1)
        .frames(DT, 40);
    let stage = stage
        .walker(play, [spots::WALL_X - 3.0, 60.0, 0.0], 90.0)
        .walks(2);
    let run = t.scene(&stage.entity(play.boulder, [36.0, 100.0, 0.0], |spec| spec.state = 8));
    t.promise(furthest_east(&run) < spots::WALL_X, || {
        "through the wall while time jumped".into()
    });
}

fn interpolations(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let to = |x: f32, y: f32| Action::InterpolateTo {
        position: place(play.home, [x, y, 0.0]),
        keep_heading: false,
    };
    let mut flood = stage(play, 120).walker(play, spots::OPEN, 0.0);
    for i in 0..100 {
        flood = flood.at(3, 0, to(30.0 + 0.05 * i as f32, 100.0));
    }
    let run = t.scene(&flood);
    t.promise(run.end().iter().all(|c| c.is_finite()), || {
        format!("{:?}", run.end())
    });
    let mut far_near = stage(play, 160).walker(play, spots::OPEN, 0.0);
    for i in 0..12 {
        far_near = far_near.at(
            3 + i * 8,
            0,
            if i % 2 == 0 {
                to(90.0, 110.0)
            } else {
                to(31.0, 100.0)
            },
        );
    }
    t.scene(&far_near);
    // A goal inside a wall; and the ground lost while the queue is full.
    t.scene(
        &stage(play, 160)
            .walker(play, spots::WALL, 0.0)
            .at(3, 0, to(spots::WALL_X, 60.0)),
    );
    let queue = stage(play, 160)
        .walker(play, spots::OPEN, 0.0)
        .at(3, 0, to(33.0, 100.0))
        .at(3, 0, to(36.0, 100.0));
    t.scene(&queue.at(6, 0, Action::Jump { extent: 1.0 }));
}

fn sticky(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let stick = |target: u32| Action::StickTo {
        target: GUID + target,
        radius: 0.4,
        height: 1.8,
    };
    let pair = || {
        stage(play, 120).walker(play, spots::OPEN, 0.0).entity(
            play.walker,
            [33.0, 100.0, 0.0],
            |spec| {
                spec.kind = EntityKind::Creature;
                spec.motion_table = play.table;
                spec.state = CREATURE;
            },
        )
    };
    t.scene(&pair().at(3, 0, stick(1)));
    t.scene(&pair().at(3, 0, stick(1)).at(10, 1, Action::Destroy));
    t.scene(&pair().at(3, 0, stick(0)));
    t.scene(&pair().at(3, 0, stick(77)));
    for heading in [90.0_f32, 270.0, 270.0_f32.next_up()] {
        t.scene(
            &pair()
                .at(2, 0, Action::SetHeading { heading })
                .at(3, 0, stick(1))
                .at(20, 1, motion(WALK, 1.0)),
        );
    }
}

fn constraints(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for (start, max) in [
        (0.0, 0.0),
        (5.0, 2.0),
        (2.0, f32::INFINITY),
        (2.0, 5.0),
        (f32::NAN, 5.0),
    ] {
        let constraint = Action::ConstrainTo {
            position: place(play.home, spots::OPEN),
            start,
            max,
        };
        let run = t.scene(
            &stage(play, 120)
                .walker(play, spots::OPEN, 90.0)
                .at(3, 0, constraint)
                .walks(5),
        );
        let gone = run.end()[0] - spots::OPEN[0];
        t.promise(gone.is_finite() && gone < 20.0, || {
            format!("start {start}, max {max}: went {gone} m")
        });
    }
}

fn map_edge(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for (block, velocity) in [
        (0x0000_0000, [-20.0, -3.0, 2.0]),
        (0xFEFE_0000, [20.0, 20.0, 2.0]),
    ] {
        let at = if block == 0 {
            [2.0, 2.0, 0.5]
        } else {
            [190.0, 190.0, 0.5]
        };
        t.scene(
            &Stage::new(play)
                .in_block(block)
                .frames(DT, 60)
                .thrown(play.ball, at, velocity),
        );
        let beyond = [if block == 0 { -30.0 } else { 230.0 }, 90.0, 0.0];
        for flags in PLACE {
            let to = PositionSpec {
                origin: beyond,
                ..place(block, [90.0; 3])
            };
            let there = Stage::new(play).in_block(block).frames(DT, 40).walker(
                play,
                [90.0, 90.0, 0.0],
                0.0,
            );
            t.scene(&there.at(
                5,
                0,
                Action::SetPosition {
                    position: to,
                    flags,
                },
            ));
        }
    }
}

fn missiles(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let shot = |spec: &mut EntitySpec, velocity: [f32; 3]| {
        spec.kind = EntityKind::Missile;
        spec.state = MISSILE;
        spec.velocity = velocity;
    };
    let inside = stage(play, 60).walker(play, spots::OPEN, 90.0);
    t.scene(&inside.entity(play.ball, [30.0, 100.0, 1.0], |spec| {
        shot(spec, [20.0, 0.0, 1.0])
    }));
    let two = stage(play, 60).entity(play.ball, [30.0, 100.0, 2.0], |spec| {
        shot(spec, [15.0, 0.0, 0.0])
    });
    t.scene(&two.entity(play.ball, [40.0, 100.0, 2.0], |spec| {
        shot(spec, [-15.0, 0.0, 0.0])
    }));
    let gone = stage(play, 60).entity(play.ball, [30.0, 100.0, 2.0], |spec| {
        shot(spec, [15.0, 0.0, 0.0])
    });
    let gone = gone.entity(play.walker, [40.0, 100.0, 0.0], |spec| {
        spec.kind = EntityKind::Creature
    });
    t.scene(&gone.at(5, 1, Action::Destroy));
}

fn state_words(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for state in [
        0x0000_0001_u32,
        0x0000_4001,
        0x0000_0005,
        0x0100_0408,
        0x0000_4408,
        0x0000_0409,
    ] {
        t.scene(
            &stage(play, 60).entity(play.ball, [30.0, 100.0, 5.0], |spec| {
                spec.state = state;
                spec.velocity = [3.0, 0.0, 0.0];
            }),
        );
        let moving = stage(play, 90).thrown(play.ball, [30.0, 100.0, 5.0], [3.0, 0.0, 0.0]);
        let run = t.scene(&moving.at(10, 0, Action::SetState { state }).at(
            40,
            0,
            Action::SetState { state: FALLS },
        ));
        t.promise(highest(&run) < 6.0, || {
            format!("state {state:#X}: rose to {}", highest(&run))
        });
    }
    t.same(
        "the normative profile",
        t.profile == Profile::retail(),
        true,
    );
}
