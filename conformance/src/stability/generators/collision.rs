//! Collision primitives (`spec/04-collision-primitives.md`, 17): polygons, spheres, cylinders and trees, called and met in scenes.

use ac_client::{
    dat::worldgen::{Axis, SetupBuilder, WorldBuilder, block, prism},
    math::{EPSILON, Plane, Sphere, Vec3},
    physics::collision::{BoundingType, CellTree, MAX_TREE_DEPTH, Polygon, make_plane},
};

use super::{
    super::{
        invariants::Invariant,
        stage::{DT, FALLS, FLOATS, Stage},
        trial::Trial,
        worlds::spots,
    },
    cases,
    transition::{furthest_east, highest, play, stage},
};

cases! { "04";
    1 "sphere exactly r from a plane" => exact_touch;
    2 "grazing within epsilon of r" => grazing;
    3 "zero movement over an overlapping polygon" => no_movement;
    4 "movement parallel to the polygon" => parallel_movement;
    5 "slide shorter than the root of epsilon" => short_slide;
    6 "normal and ground nearly parallel" => nearly_parallel;
    7 "ceiling over floor" => ceiling_over_floor;
    8 "never had a contact plane" => no_contact_plane;
    9 "one sphere near a sphere obstacle while landing" => landing_beside_sphere;
    10 "upper sphere overlaps, lower one outside" => upper_overlap;
    11 "thin or sliver polygons" => slivers;
    12 "degenerate polygon" => degenerate;
    13 "radius of at most epsilon" => tiny_radius;
    14 "step-down amount below epsilon" => tiny_step;
    15 "walk interpolation zero or negative" => walk_interp;
    16 "obstacle of another scale" => scaled_obstacle;
    17 "rotated cylinder" => rotated_cylinder;
    18 "across a landblock border within a step" => border_obstacle;
    19 "block at the map edge" => edge_block;
    20 "huge plane distances" => huge_distance;
    21 "many polygons in one leaf, stepping down" => many_polygons;
    22 "placed inside solid, no polygon near" => inside_solid;
    23 "tree that straddles the struck polygon" => straddling;
    24 "cell tree that ends in a leaf" => leaf_end;
    25 "cell of twenty planes" => twenty_planes;
}

const FLOOR: [Vec3; 4] = [
    Vec3::new(-5.0, -5.0, 0.0),
    Vec3::new(5.0, -5.0, 0.0),
    Vec3::new(5.0, 5.0, 0.0),
    Vec3::new(-5.0, 5.0, 0.0),
];

fn at(z: f32) -> Sphere {
    Sphere::new(Vec3::new(0.5, 0.25, z), 0.4)
}

fn exact_touch(t: &mut Trial) {
    let floor = Polygon::new(&FLOOR, &t.profile.clone());
    t.same("a sphere at exactly r", floor.hits_sphere(&at(0.4)), false);
    t.same(
        "a sphere at r − ε/2",
        floor.hits_sphere(&at(0.4 - EPSILON / 2.0)),
        false,
    );
    t.same(
        "a sphere at r − 2ε",
        floor.hits_sphere(&at(0.4 - 2.0 * EPSILON)),
        true,
    );
    let Some(play) = play(t) else { return };
    let run = t.scene(&stage(play, 100).thrown(play.ball, spots::OPEN, [3.0, 0.0, 0.0]));
    t.promise(run.end()[2].abs() < 1e-3, || {
        format!("rolled to {:?}", run.end())
    });
}

fn grazing(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    // Past the northern end of the wall at y = 80, at distances around the radius.
    for off in [-2e-3_f32, -EPSILON, -1e-5, 0.0, 1e-5, EPSILON, 2e-3] {
        let start = [95.0, 80.0 + 0.3 + off, 2.0];
        let run = t.scene(&stage(play, 60).entity(play.ball, start, |spec| {
            spec.state = FLOATS;
            spec.velocity = [8.0, 0.0, 0.0];
        }));
        let passed = furthest_east(&run) > 101.0;
        t.promise(passed || off < 0.0, || {
            format!("stopped {off} m beside the edge")
        });
    }
    // Along the face of the wall.
    for off in [-EPSILON, 0.0, EPSILON] {
        let start = [spots::WALL_X - 0.025 - 0.3 - off, 45.0, 2.0];
        t.scene(&stage(play, 80).entity(play.ball, start, |spec| {
            spec.state = FLOATS;
            spec.velocity = [0.0, 9.0, 0.0];
        }));
    }
}

fn no_movement(t: &mut Trial) {
    let floor = Polygon::new(&FLOOR, &t.profile.clone());
    let mut contact = Vec3::ZERO;
    let found = floor.pos_hits_sphere(&at(0.2), Vec3::ZERO, &mut contact);
    t.same("touched and hit without movement", found, (true, false));
    let Some(play) = play(t) else { return };
    // Placed into the wall, at rest and with something under it.
    for z in [0.0, 2.0] {
        t.scene(&stage(play, 60).entity(play.ball, [spots::WALL_X - 0.1, 60.0, z], |_| ()));
    }
}

fn parallel_movement(t: &mut Trial) {
    let p = t.profile.clone();
    let floor = Polygon::new(&FLOOR, &p);
    for dz in [0.0, EPSILON * 0.5, -EPSILON * 0.5, -EPSILON * 2.0] {
        let mut contact = Vec3::ZERO;
        let movement = Vec3::new(1.0, 0.0, dz);
        let found = floor.pos_hits_sphere(&at(0.3), movement, &mut contact);
        // By sign alone.
        t.same("touched and hit along the polygon", found, (true, dz < 0.0));
        if dz.abs() < EPSILON {
            let (mut sphere, mut walk) = (at(0.3), 1.0);
            let adjusted = floor.adjust_sphere_to_plane(&mut sphere, movement, &mut walk, &p);
            t.same("adjusted", (adjusted, sphere, walk), (false, at(0.3), 1.0));
        }
    }
}

fn short_slide(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    // Slow movers at an obtuse corner: they may stop dead, they may not get through.
    for speed in [0.3_f32, 0.5, 1.0] {
        for dy in [0.05_f32, 0.5, 1.0] {
            let run = t.scene(&stage(play, 200).entity(
                play.ball,
                [spots::WALL_X - 0.5, 60.0, 2.0],
                |spec| {
                    spec.state = FLOATS;
                    spec.velocity = [speed, speed * dy, 0.0];
                },
            ));
            t.promise(furthest_east(&run) < spots::WALL_X, || {
                format!("through the wall to {}", furthest_east(&run))
            });
        }
    }
}

fn nearly_parallel(t: &mut Trial) {
    // Two slabs whose tops differ by less than 0.8 degrees.
    let mut world = WorldBuilder::new();
    let floor = world.solid(&prism(
        &[[-4.0, -1.0], [4.0, -1.0], [4.0, 0.05], [-4.0, 0.0]],
        Axis::Y,
        -4.0,
        4.0,
    ));
    let body = world.solid(&block(Vec3::splat(-0.1), Vec3::splat(0.1)));
    let ball = world.setup(
        SetupBuilder::new()
            .part(body, ac_client::dat::StoredFrame::IDENTITY)
            .sphere(Vec3::new(0.0, 0.0, 0.3), 0.3)
            .size(0.6, 0.3)
            .steps(0.2, 0.2),
    );
    world
        .block(0x20, 0x20)
        .object(floor, Vec3::new(60.0, 60.0, 1.0), 0.0);
    let source = world.surround().build();
    let Some(play) = play(t) else { return };
    match source {
        Err(error) => t.promise(false, || error.to_string()),
        Ok(source) => {
            let mut rolling = stage(play, 200).in_block(0x2020_0000).thrown(
                ball,
                [57.5, 60.0, 1.6],
                [4.0, 0.0, -1.0],
            );
            rolling.source = std::sync::Arc::new(source);
            t.scene(&rolling);
        }
    }
}

fn ceiling_over_floor(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    let [x, y, _] = spots::CEILING;
    // 1.8 m high under 1.7 m: it cannot get in; jumping under the edge, neither.
    let run = t.scene(
        &stage(play, 150)
            .walker(play, [x - 7.0, y, 0.0], 90.0)
            .walks(3),
    );
    t.promise(furthest_east(&run) < x - 3.5, || {
        format!("under the slab to {}", furthest_east(&run))
    });
    let jump = ac_golden_traces::scene::Action::Jump { extent: 1.0 };
    t.scene(
        &stage(play, 150)
            .walker(play, [x - 4.6, y, 0.0], 90.0)
            .walks(3)
            .at(20, 0, jump),
    );
}

fn no_contact_plane(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    // In the air from the start, against the wall.
    let run =
        t.scene(
            &stage(play, 60).entity(play.ball, [spots::WALL_X - 3.0, 60.0, 3.0], |spec| {
                spec.state = FLOATS;
                spec.velocity = [10.0, 4.0, 1.0];
            }),
        );
    t.promise(furthest_east(&run) < spots::WALL_X, || {
        "through the wall".into()
    });
    t.promise(run.end()[1] > 60.0 || run.end()[0] < spots::WALL_X, || {
        "no slide".into()
    });
}

fn landing_beside_sphere(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for off in [0.0_f32, 0.3, 1.0, 1.6, 1.79, 1.8, 1.81] {
        t.scene(
            &stage(play, 200)
                .thrown(play.ball, [40.0 + off, 100.0, 6.0], [0.0; 3])
                .entity(play.boulder, [40.0, 100.0, 0.0], |spec| spec.state = 8),
        );
    }
}

fn upper_overlap(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    // The upper sphere meets a boulder that hangs beside the lower one.
    for off in [1.0_f32, 1.5, 1.85, 1.9] {
        let hanging =
            |stage: Stage| stage.entity(play.boulder, [40.0, 100.0, 1.2], |spec| spec.state = 8);
        t.scene(&hanging(
            stage(play, 150)
                .walker(play, [40.0 - off - 3.0, 100.0, 0.0], 90.0)
                .walks(3),
        ));
        t.scene(&hanging(stage(play, 150).walker(
            play,
            [40.0 - off, 100.0, 5.0],
            90.0,
        )));
    }
}

fn slivers(t: &mut Trial) {
    let p = t.profile.clone();
    for width in [1e-3_f32, 1e-5, 1e-7] {
        let corners = [
            Vec3::ZERO,
            Vec3::new(10.0, 0.0, 0.0),
            Vec3::new(5.0, width, 0.0),
        ];
        let plane = make_plane(&corners, &p);
        let polygon = Polygon {
            plane,
            vertices: &corners,
            single_sided: false,
        };
        // A normal made of rounding is allowed; a hang or a panic is not.
        let _ = polygon.hits_sphere(&at(0.1));
        t.promise(plane.n.length() < 1.01 || plane.n.is_nan(), || {
            format!("normal {}", plane.n)
        });
    }
}

fn degenerate(t: &mut Trial) {
    let p = t.profile.clone();
    let corners = [Vec3::ONE, Vec3::ONE, Vec3::ONE];
    let plane = make_plane(&corners, &p);
    let polygon = Polygon {
        plane,
        vertices: &corners,
        single_sided: false,
    };
    t.promise(plane.n.is_nan(), || format!("normal {}", plane.n));
    t.same(
        "hit",
        polygon.hits_sphere(&Sphere::new(Vec3::ONE, 1.0)),
        false,
    );
}

fn tiny_radius(t: &mut Trial) {
    let floor = Polygon::new(&FLOOR, &t.profile.clone());
    t.same(
        "a speck in the plane",
        floor.hits_sphere(&Sphere::new(Vec3::new(0.5, 0.25, 0.0), EPSILON / 2.0)),
        false,
    );
    t.as_retail(
        Invariant::Depth,
        "04 17: a radius of at most epsilon never hits a polygon",
    );
    let Some(play) = play(t) else { return };
    t.scene(&stage(play, 60).thrown(play.speck, [30.0, 100.0, 2.0], [1.0, 0.0, 0.0]));
}

fn tiny_step(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    // Step heights come from the setup times the scale.
    for scale in [1e-3_f32, 1e-4] {
        let tiny = |setup: u32, at: [f32; 3]| {
            stage(play, 60).entity(setup, at, |spec| {
                spec.scale = scale;
                spec.velocity = [1.0, 0.0, 0.0];
            })
        };
        t.as_retail(
            Invariant::Depth,
            "04 17: a radius of at most epsilon never hits a polygon",
        );
        t.scene(&tiny(play.ball, [30.0, 100.0, 0.0]));
        t.scene(&tiny(play.ball, [spots::STEPS[0].0 + 1.0, 20.0, 0.3]));
    }
}

fn walk_interp(t: &mut Trial) {
    let p = t.profile.clone();
    let floor = Polygon::new(&FLOOR, &p);
    // Nothing left to walk: nothing adjusts.
    for walk in [0.0_f32, -0.5] {
        let (mut sphere, mut left) = (at(0.3), walk);
        let down = Vec3::new(0.0, 0.0, -1.0);
        let adjusted = floor.adjust_sphere_to_plane(&mut sphere, down, &mut left, &p);
        t.promise(!adjusted || left < walk, || {
            format!("with {walk} left it goes on to {left}")
        });
        t.promise(sphere.center.is_finite(), || {
            format!("sphere at {}", sphere.center)
        });
    }
    let Some(play) = play(t) else { return };
    t.scene(
        &stage(play, 60)
            .walker(play, [spots::STEPS[2].0 - 0.41, 20.0, 0.0], 90.0)
            .walks(3),
    );
}

fn scaled_obstacle(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for scale in [0.1_f32, 0.5, 2.0, 10.0] {
        let base = stage(play, 150)
            .walker(play, [20.0, 100.0, 0.0], 90.0)
            .walks(3);
        let run = t.scene(&base.entity(play.crate_, [36.0, 100.0, 0.0], |spec| {
            spec.scale = scale;
            spec.state = 0x0001_0008;
        }));
        // Up to 0.6 m is a step.
        let stopped = run.end()[0] < 36.0;
        t.promise(stopped || 2.0 * scale <= 0.6, || {
            format!("scale {scale}: went to {:?}", run.end())
        });
        let drop = stage(play, 150).thrown(play.ball, [36.0, 100.0, 2.0 * scale + 3.0], [0.0; 3]);
        t.scene(&drop.entity(play.crate_, [36.0, 100.0, 0.0], |spec| {
            spec.scale = scale;
            spec.state = 0x0001_0008;
        }));
    }
}

fn rotated_cylinder(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for turn in [45.0_f32, 90.0, 180.0] {
        let (s, c) = (turn.to_radians() / 2.0).sin_cos();
        let run = t.scene(
            &stage(play, 150)
                .walker(play, [30.0, 100.0, 0.0], 90.0)
                .walks(3)
                .entity(play.pillar, [36.0, 100.0, 0.0], |spec| {
                    spec.state = 8;
                    spec.position.rotation = [c, s, 0.0, 0.0];
                }),
        );
        t.promise(run.end()[0] < 35.0, || {
            format!("turned by {turn}: through it to {:?}", run.end())
        });
    }
}

fn border_obstacle(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for setup in [play.pillar, play.boulder, play.crate_] {
        for x in [191.5_f32, 192.0, 192.5] {
            let state = if setup == play.crate_ { 0x0001_0008 } else { 8 };
            let stage = stage(play, 200)
                .walker(play, [184.0, 100.0, 0.0], 90.0)
                .walks(3);
            let run = t
                .scene(&stage.entity(setup, [x.min(191.9), 100.0, 0.0], |spec| spec.state = state));
            let last = run.last(0);
            let beyond = last.cell >> 16 != play.home >> 16 && last.origin[0] > 2.0;
            t.promise(!beyond, || {
                format!("through the obstacle to {:?}", last.origin)
            });
        }
    }
}

fn edge_block(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    for (block, x) in [(0xFE00_0000, 188.0), (0x0000_0000, 4.0)] {
        let stage = Stage::new(play).in_block(block).frames(DT, 100);
        let heading = if x > 96.0 { 90.0 } else { 270.0 };
        t.scene(
            &stage
                .walker(play, [x, 100.0, 0.0], heading)
                .walks(3)
                .entity(
                    play.pillar,
                    [if x > 96.0 { 190.5 } else { 1.5 }, 100.0, 0.0],
                    |spec| spec.state = 8,
                ),
        );
    }
}

fn huge_distance(t: &mut Trial) {
    let p = t.profile.clone();
    for far in [1e3_f32, 1e5, 1e7] {
        let n = Vec3::new(0.6, 0.0, 0.8);
        let plane = Plane::from_normal_and_point(n, Vec3::splat(far));
        let mut offset = Vec3::new(0.1, 0.1, 0.0);
        plane.snap_to_plane(&mut offset, &p);
        let error = (offset.dot(n)).abs();
        t.promise(error <= 2e-6 * far.max(1.0) + 1e-6, || {
            format!("off the plane by {error} at {far}")
        });
    }
}

fn many_polygons(t: &mut Trial) {
    // A floor of many small boxes of one height: the order in the file decides, the height may not.
    let mut faces = Vec::new();
    for i in 0..6_u8 {
        for j in 0..6_u8 {
            let low = Vec3::new(f32::from(i), f32::from(j), 0.0);
            faces.extend(block(low, low + Vec3::new(0.98, 0.98, 0.5)));
        }
    }
    let mut world = WorldBuilder::new();
    let floor = world.solid(&faces);
    world
        .block(0x20, 0x20)
        .object(floor, Vec3::new(60.0, 60.0, 0.0), 0.0);
    let built = world.surround().build();
    let Some(play) = play(t) else { return };
    t.promise(built.is_ok(), || "the floor cannot be built".into());
    let run = t.scene(
        &stage(play, 120)
            .walker(play, [spots::STEPS[0].0 - 2.0, 20.0, 0.0], 90.0)
            .walks(3),
    );
    t.promise(highest(&run) >= 0.29, || {
        format!("does not step up: {}", highest(&run))
    });
}

fn inside_solid(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    // In the middle of a crate of 20 m: no polygon within the search.
    let run = t.scene(
        &stage(play, 40)
            .entity(play.crate_, [40.0, 100.0, 0.0], |spec| {
                spec.scale = 10.0;
                spec.state = 0x0001_0008;
            })
            .walker(play, [40.0, 100.0, 5.0], 0.0),
    );
    t.promise(run.states.len() == 2, || "an entity has no state".into());
}

fn straddling(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    // Set down so that the sphere lies across the thin wall, at many offsets.
    for step in 0..12_u32 {
        let x = spots::WALL_X - 0.33 + 0.06 * step as f32;
        t.scene(&stage(play, 40).entity(play.ball, [x, 60.0, 2.0], |spec| spec.state = FALLS));
    }
}

/// The planes of a box of half side 1, facing inwards.
fn planes() -> Vec<Plane> {
    [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z]
        .map(|n| Plane { n, d: 1.0 })
        .into()
}

fn leaf_end(t: &mut Trial) {
    let middle = Sphere::new(Vec3::ZERO, 0.25);
    let open = CellTree::new(planes(), false);
    let leaf = CellTree::new(planes(), true);
    t.same(
        "a tree without a leaf",
        open.intersects_sphere(&middle),
        BoundingType::EntirelyInside,
    );
    t.promise(
        leaf.intersects_sphere(&middle) != BoundingType::Outside,
        || "the leaf loses what is inside".into(),
    );
    t.same(
        "points",
        (leaf.contains(Vec3::ZERO), leaf.contains(Vec3::splat(3.0))),
        (true, false),
    );
}

fn twenty_planes(t: &mut Trial) {
    let ring: Vec<Plane> = (0..20)
        .map(|i| {
            let (s, c) = (std::f32::consts::TAU * i as f32 / 20.0).sin_cos();
            Plane {
                n: Vec3::new(-c, -s, 0.0),
                d: 1.0,
            }
        })
        .collect();
    let tree = CellTree::new(ring, false);
    for i in 0..40 {
        let (s, c) = (std::f32::consts::TAU * i as f32 / 40.0).sin_cos();
        for far in [0.5_f32, 0.99, 1.0, 1.2, 1.3] {
            let sphere = Sphere::new(Vec3::new(c * far, s * far, 0.0), 0.2);
            let found = tree.intersects_sphere(&sphere);
            let fits = match found {
                BoundingType::Outside => far > 1.15,
                BoundingType::EntirelyInside => far < 0.85,
                BoundingType::PartiallyInside => (0.7..1.25).contains(&far),
            };
            t.promise(fits, || format!("at {far}: {found:?}"));
        }
    }
    t.promise(MAX_TREE_DEPTH >= 20, || "twenty levels are too deep".into());
}
