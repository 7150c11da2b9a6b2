//! The movement resolver (`spec/05-transition.md`, 16): scenes in which it is driven into its corners.

use ac_client::{frame::state::Outcome, physics::transition::FLOOR_Z};

use super::{
    super::{
        invariants::Invariant,
        stage::{CREATURE, DT, FALLS, FLOATS, MISSILE, Run, Stage},
        trial::Trial,
        worlds::{self, Playground, spots},
    },
    cases,
};

cases! { "05";
    1 "zero-length move with rotation" => turn_in_place;
    2 "move shorter than epsilon" => tiny_moves;
    3 "move of exactly r, 2r, …" => whole_radii;
    4 "long move in one quantum" => long_moves;
    5 "radius 0 or tiny" => tiny_radius;
    6 "standing exactly on terrain" => standing;
    7 "slope next to the walkable limit" => limit_slope;
    8 "into a too steep slope from walkable ground" => steep_slope;
    9 "concave corner of two walls" => concave_corner;
    10 "crease of nearly parallel normals" => parallel_crease;
    11 "ledge, stepping down" => ledge;
    12 "stairs higher than the step" => high_stairs;
    13 "step height larger than two radii" => stilts;
    14 "falling on a spike or into a crevice" => spike_and_crevice;
    15 "across a landblock border on the ground" => block_border;
    16 "edge of the map" => map_edge;
    17 "ethereal objects" => ethereal;
    18 "several objects in one cell" => crowd;
    19 "very large coordinates" => large_coordinates;
    20 "missile" => missile;
}

/// On a slope that is too steep gravity goes on adding speed while the slope keeps the object up.
pub(super) const STEEP: &str = "06 H4.6: contact without walkable ground has acceleration and no friction, and its velocity is not turned along the slope";

/// The playground, or a check that fails.
pub(super) fn play(t: &mut Trial) -> Option<&'static Playground> {
    match worlds::play() {
        Ok(play) => Some(play),
        Err(error) => {
            t.promise(false, || error.to_string());
            None
        }
    }
}

/// Frames of one quantum on the home block.
pub(super) fn stage(play: &Playground, frames: u32) -> Stage {
    Stage::new(play).frames(DT, frames)
}

/// Largest x that was reached.
pub(super) fn furthest_east(run: &Run) -> f32 {
    run.first()
        .iter()
        .map(|s| s.origin[0])
        .fold(f32::NEG_INFINITY, f32::max)
}

/// Highest z that was reached.
pub(super) fn highest(run: &Run) -> f32 {
    run.first()
        .iter()
        .map(|s| s.origin[2])
        .fold(f32::NEG_INFINITY, f32::max)
}

fn turn_in_place(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let spin = stage(play, 60).entity(play.ball, [30.0, 100.0, 30.0], |spec| {
        spec.state = FLOATS;
        spec.omega = [0.0, 0.0, 3.0];
    });
    let run = t.scene(&spin);
    t.same("place", run.end(), [30.0, 100.0, 30.0]);
    t.promise(run.last(0).rotation != [1.0, 0.0, 0.0, 0.0], || {
        "does not turn".into()
    });
    t.promise(!run.has(Outcome::Failed), || "a quantum failed".into());
}

fn tiny_moves(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for speed in [1e-6_f32, 1e-4, 2.4e-3, 2.6e-3, 4.9e-3, 5.1e-3, 0.2] {
        // The rest rule stops what is slower than 0.25 m/s; gravity keeps it going down.
        for state in [FLOATS, FALLS] {
            let run = t.scene(
                &stage(play, 60).entity(play.ball, [30.0, 100.0, 30.0], |spec| {
                    spec.state = state;
                    spec.velocity = [speed, 0.0, 0.0];
                }),
            );
            let gone = run.end()[0] - 30.0;
            t.promise(gone.abs() < 0.02, || {
                format!("{speed} m/s moved it {gone} m")
            });
        }
    }
}

fn whole_radii(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for radii in 1..=6_u32 {
        let speed = 0.3 * radii as f32 / DT as f32;
        for speed in [speed.next_down(), speed, speed.next_up()] {
            // Steps of exactly n radii into the thin wall.
            let run = t.scene(&stage(play, 60).entity(
                play.ball,
                [spots::WALL_X - 7.0, 60.0, 2.0],
                |spec| {
                    spec.state = FLOATS;
                    spec.velocity = [speed, 0.0, 0.0];
                },
            ));
            let far = furthest_east(&run);
            t.promise(far <= spots::WALL_X - 0.3 + 1e-3, || {
                format!("{speed} m/s: {far}")
            });
        }
    }
}

fn long_moves(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    // One quantum of 0.2 s at the highest speed: 10 m, 33 radii, and the wall in between.
    for dt in [0.04, 0.1, 0.2] {
        for dy in [0.0, 11.0] {
            let start = [spots::WALL_X - 6.0, 60.0, 2.0];
            let run = t.scene(
                &Stage::new(play)
                    .frames(dt, 30)
                    .entity(play.ball, start, |spec| {
                        spec.state = FLOATS;
                        spec.velocity = [48.0, dy, 0.0];
                    }),
            );
            let far = furthest_east(&run);
            t.promise(far <= spots::WALL_X - 0.3 + 1e-3, || {
                format!("dt {dt}: {far}")
            });
        }
    }
    // A velocity beyond any limit is cut to the limit.
    for speed in [1e3_f32, 1e6, 1e18, f32::MAX] {
        let run =
            t.scene(&stage(play, 10).thrown(play.ball, [30.0, 100.0, 60.0], [speed, 0.0, 0.0]));
        let gone = run.end()[0] - 30.0;
        t.promise(gone.abs() < 21.0 || run.last(0).cell == 0, || {
            format!("{speed} m/s moved it {gone} m")
        });
    }
}

fn tiny_radius(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for scale in [1.0, 1e-3, 1e-6, 0.0] {
        let run = t.scene(
            &stage(play, 60).entity(play.speck, [30.0, 100.0, 1.0], |spec| {
                spec.scale = scale;
                spec.velocity = [2.0, 0.0, 0.0];
            }),
        );
        t.same("frames", run.frames(), 60);
    }
    t.as_retail(
        Invariant::Depth,
        "04 17: a radius of at most epsilon never hits a polygon",
    );
}

fn standing(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let heights = [0.0_f32, 1e-5, 1.9e-4, 2e-4, 2.1e-4, 1e-3, -1e-5, -1.9e-4];
    for z in heights {
        let run = t.scene(&stage(play, 200).walker(play, [30.0, 100.0, z], 0.0));
        let rest = run.end()[2];
        t.promise(rest.abs() < 1e-3, || format!("from {z} it came to {rest}"));
        let moved = run
            .bits(0)
            .windows(2)
            .skip(100)
            .filter(|w| w[0] != w[1])
            .count();
        t.same("changes while it stands", moved, 0);
    }
}

fn limit_slope(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    t.as_retail(Invariant::Energy, STEEP);
    for (x, rise) in spots::RAMPS {
        let walkable = 1.0 / (1.0 + rise * rise).sqrt() >= FLOOR_Z;
        let run = t.scene(
            &stage(play, 200)
                .walker(play, [x - 2.0, 176.0, 0.0], 90.0)
                .walks(3),
        );
        let climbed = highest(&run);
        t.promise((climbed > 1.0) == walkable, || {
            format!("rise {rise}: climbed {climbed} m")
        });
        // And resting on it.
        t.scene(&stage(play, 200).thrown(
            play.ball,
            [x + 3.0, 176.0, 3.0 * rise + 1.0],
            [0.0, 0.0, -0.5],
        ));
    }
}

fn steep_slope(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let (x, _) = spots::RAMPS[3];
    for heading in [90.0, 70.0, 45.0, 20.0] {
        let run = t.scene(
            &stage(play, 200)
                .walker(play, [x - 2.0, 175.0, 0.0], heading)
                .walks(3),
        );
        t.promise(highest(&run) < 1.0, || {
            format!("heading {heading}: climbed {} m", highest(&run))
        });
    }
    t.scene(
        &Stage::new(play)
            .in_block(play.hills)
            .frames(DT, 300)
            .walker(play, [60.0, 90.0, 17.0], 90.0)
            .walks(3),
    );
}

fn concave_corner(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let [x, y, _] = spots::CORNER;
    for heading in [1.0, 20.0, 45.0, 70.0, 89.0] {
        let run = t.scene(
            &stage(play, 300)
                .walker(play, [x - 4.0, y - 4.0, 0.0], heading)
                .walks(3),
        );
        let [ex, ey, _] = run.end();
        t.promise(ex < x && ey < y, || {
            format!("heading {heading}: through the corner to {ex}, {ey}")
        });
    }
    // An acute wedge.
    let [x, y, _] = spots::WEDGE;
    for offset in [-0.4_f32, -0.1, 0.0, 0.1, 0.4] {
        let run = t.scene(
            &stage(play, 300)
                .walker(play, [x - 12.0, y + offset, 0.0], 90.0)
                .walks(3),
        );
        t.promise(run.end()[0] < x, || {
            format!("through the wedge to {:?}", run.end())
        });
    }
}

fn parallel_crease(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    // Straight up against the slab, and down on it: the normal of the slide and that of the ground are parallel.
    let [x, y, _] = spots::CEILING;
    let up = t.scene(&stage(play, 80).entity(play.ball, [x, y, 0.2], |spec| {
        spec.velocity = [0.0, 0.0, 12.0]
    }));
    t.promise(highest(&up) < 1.7, || {
        format!("through the slab to {}", highest(&up))
    });
    let down = t.scene(&stage(play, 80).thrown(play.ball, [x, y, 5.0], [0.4, 0.0, -3.0]));
    let lowest = down
        .first()
        .iter()
        .map(|s| s.origin[2])
        .fold(f32::INFINITY, f32::min);
    t.promise(lowest > 2.19, || format!("into the slab to {lowest}"));
}

fn ledge(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for (x, height) in spots::STEPS {
        // Off the eastern edge, straight and along it.
        for heading in [90.0, 60.0, 10.0] {
            let run = t.scene(
                &stage(play, 120)
                    .walker(play, [x + 3.0, 20.0, height], heading)
                    .walks(3),
            );
            t.promise(run.end()[2] < height + 1e-3, || {
                format!("{height} m: rose to {:?}", run.end())
            });
        }
    }
}

fn high_stairs(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for (x, height) in spots::STEPS {
        let run = t.scene(
            &stage(play, 80)
                .walker(play, [x - 2.0, 20.0, 0.0], 90.0)
                .walks(3),
        );
        let up = highest(&run) > height - 0.01;
        // 0.6 m is what this walker steps up; a hair more passes, because the round sphere needs less.
        t.promise(up || height > 0.6, || {
            format!("a step of {height} m is too high")
        });
        t.promise(!up || height < 0.7, || {
            format!("a step of {height} m: reached {}", highest(&run))
        });
    }
}

fn stilts(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for (x, height) in spots::STEPS {
        let run = t.scene(
            &stage(play, 80)
                .entity(play.stilts, [x - 2.0, 20.0, 0.0], |spec| {
                    spec.kind = ac_golden_traces::scene::EntityKind::Player;
                    spec.motion_table = play.table;
                    spec.state = CREATURE;
                    spec.position.rotation = super::super::stage::compass(90.0);
                })
                .walks(3),
        );
        let up = highest(&run) > height - 0.01;
        // Two half-steps: what lies between is decided by the state that the first leaves.
        t.promise(
            up == (height <= 0.6) || (0.6..=1.2).contains(&height),
            || format!("a step of {height} m: reached {}", highest(&run)),
        );
    }
}

fn spike_and_crevice(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for (dx, dy) in [(0.0, 0.0), (0.05, 0.0), (0.0, 0.1), (0.2, 0.2)] {
        let spike = [spots::SPIKE[0] + dx, spots::SPIKE[1] + dy, 6.0];
        t.scene(&stage(play, 250).thrown(play.ball, spike, [0.0; 3]));
        t.scene(&stage(play, 250).walker(play, spike, 0.0));
        let crevice = [spots::CREVICE[0] + dx, spots::CREVICE[1] + dy, 5.0];
        let run = t.scene(&stage(play, 250).thrown(play.ball, crevice, [0.0; 3]));
        t.promise(run.end()[2] > -1e-2, || {
            format!("through the ground to {:?}", run.end())
        });
        t.scene(&stage(play, 250).walker(play, crevice, 0.0));
    }
}

fn block_border(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for (x, y, heading) in [
        (189.0, 100.0, 90.0),
        (100.0, 189.0, 0.0),
        (189.5, 189.5, 45.0),
        (2.0, 30.0, 270.0),
    ] {
        let run = t.scene(&stage(play, 150).walker(play, [x, y, 0.0], heading).walks(3));
        t.promise(run.last(0).cell >> 16 != play.home >> 16, || {
            "it stays in its block".into()
        });
        let heights = run
            .first()
            .iter()
            .map(|s| s.origin[2].abs())
            .fold(0.0, f32::max);
        t.promise(heights < 1e-3, || {
            format!("height {heights} on level ground")
        });
    }
    t.scene(&stage(play, 150).thrown(play.ball, [188.0, 100.0, 0.0], [9.0, 0.5, 0.0]));
}

fn map_edge(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let corners = [
        (0x0000_0000, 3.0, 3.0, 225.0),
        (0x00FE_0000, 3.0, 189.0, 315.0),
        (0xFE00_0000, 189.0, 3.0, 135.0),
        (0xFEFE_0000, 189.0, 189.0, 45.0),
    ];
    for (block, x, y, heading) in corners {
        let run = t.scene(
            &Stage::new(play)
                .in_block(block)
                .frames(DT, 150)
                .walker(play, [x, y, 0.0], heading)
                .walks(3),
        );
        let last = run.last(0);
        t.promise(last.cell == 0 || last.cell & 0xFFFF_0000 == block, || {
            format!("walked to {:#X}", last.cell)
        });
        t.scene(&Stage::new(play).in_block(block).frames(DT, 60).entity(
            play.ball,
            [x, y, 1.0],
            |spec| {
                let (s, c) = f32::to_radians(heading).sin_cos();
                spec.velocity = [30.0 * s, 30.0 * c, 4.0];
            },
        ));
    }
}

fn ethereal(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let run = t.scene(
        &stage(play, 120)
            .walker(play, [30.0, 100.0, 0.0], 90.0)
            .walks(3)
            .entity(play.boulder, [35.0, 100.0, 0.0], |spec| {
                spec.state = 0x0000_000C
            }),
    );
    t.promise(run.end()[0] > 37.0, || {
        format!("stopped by an ethereal object at {:?}", run.end())
    });
    // One inside a solid one: the first solid collision of the same step may be lost.
    let both = stage(play, 120)
        .walker(play, [30.0, 100.0, 0.0], 90.0)
        .walks(3);
    let both = [0x0000_000C, 0x0000_0008]
        .into_iter()
        .fold(both, |both, state| {
            both.entity(play.boulder, [35.0, 100.0, 0.0], |spec| spec.state = state)
        });
    t.scene(&both);
}

fn crowd(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let mut many = stage(play, 150)
        .walker(play, [30.0, 100.0, 0.0], 90.0)
        .walks(3);
    for i in 0..9_u32 {
        let (column, row) = ((i / 3) as f32, (i % 3) as f32 - 1.0);
        let setup = [play.pillar, play.boulder, play.crate_][i as usize % 3];
        many = many.entity(
            setup,
            [36.0 + column * 2.2, 100.0 + row * 2.2, 0.0],
            |spec| spec.state = if setup == play.crate_ { 0x0001_0008 } else { 8 },
        );
    }
    // They are placed around each other when they enter: only the rules can be checked.
    t.scene(&many);
}

fn large_coordinates(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    // High above, where the epsilon of collisions is a few ulps; and placed far outside its block.
    for z in [1e3_f32, 1e4, 1e5, 1e6, 1e7] {
        t.scene(
            &stage(play, 40).entity(play.ball, [30.0, 100.0, z], |spec| {
                spec.velocity = [3.0, 0.0, 1.0]
            }),
        );
    }
    for x in [200.0_f32, 1e3, 1e4, -5e3] {
        let run = t.scene(&stage(play, 40).entity(play.ball, [x, 100.0, 2.0], |spec| {
            spec.velocity = [3.0, 0.0, 1.0]
        }));
        let last = run.last(0);
        t.promise(
            last.cell == 0 || (0.0..192.0).contains(&last.origin[0]),
            || format!("x {} in {:#X}", last.origin[0], last.cell),
        );
    }
}

fn missile(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for (origin, velocity) in [
        ([90.0, 60.0, 2.0], [40.0, 0.0, 0.0]),
        ([30.0, 100.0, 2.0], [20.0, 5.0, -8.0]),
        ([146.0, 56.0, 1.0], [15.0, 15.0, 0.0]),
    ] {
        let run = t.scene(&stage(play, 80).entity(play.ball, origin, |spec| {
            spec.kind = ac_golden_traces::scene::EntityKind::Missile;
            spec.state = MISSILE;
            spec.velocity = velocity;
        }));
        if origin[0] == 90.0 {
            t.promise(furthest_east(&run) < spots::WALL_X, || {
                format!("through the wall to {}", furthest_east(&run))
            });
        }
    }
}
