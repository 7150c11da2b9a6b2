//! Math and positions (`spec/01-math-and-positions.md`, 16): calls of the functions that the cases are about.

use ac_client::math::{
    CellId, EPSILON, Frame, Plane, Position, Quat, Vec3, heading_of_position_offset, vector,
};

use super::{
    super::{
        stage::{FLOATS, Stage},
        trial::Trial,
        worlds,
    },
    cases,
};

const BLOCK: CellId = CellId(0x2020_0001);

cases! { "01";
    1 "zero-length heading vector, two positions above each other" => heading_of_nothing;
    2 "vertical heading vector" => heading_upwards;
    3 "heading vector whose z rounds above 1" => heading_beyond_one;
    4 "zero quaternion from data" => zero_quaternion;
    5 "NaN origin" => nan_origin;
    6 "infinite origin" => infinite_origin;
    7 "x = -0.0" => negative_zero;
    8 "x one ulp below 192" => below_border;
    9 "huge local coordinates" => huge_coordinates;
    10 "block row or column 0xFF" => off_map_blocks;
    11 "rotation below epsilon in a step" => slow_spin;
    12 "interpolation between nearly opposite rotations" => opposite_rotations;
    13 "snap to a plane that is nearly vertical" => steep_snap;
    14 "plane through far points" => far_plane;
    15 "quaternion at the limit of validity" => quaternion_limit;
    16 "dt of exactly 1/30, 0.2 and 2 s" => gate_times;
}

fn heading_of_nothing(t: &mut Trial) {
    let p = t.profile.clone();
    t.same(
        "heading of no offset",
        heading_of_position_offset(Vec3::ZERO, &p),
        0.0,
    );
    let a = Position::new(BLOCK, Vec3::new(5.0, 5.0, 0.0), Quat::IDENTITY);
    let b = Position::new(BLOCK, Vec3::new(5.0, 5.0, 9.0), Quat::IDENTITY);
    t.same("heading of what is above", a.heading_to(&b, &p), 0.0);
    let mut frame = Frame::IDENTITY;
    frame.set_heading(77.0, &p);
    let before = frame.bits();
    frame.set_vector_heading(Vec3::ZERO, &p);
    t.same("frame after a heading of length 0", frame.bits(), before);
}

fn heading_upwards(t: &mut Trial) {
    let p = t.profile.clone();
    let mut frame = Frame::IDENTITY;
    frame.set_vector_heading(Vec3::Z, &p);
    t.promise(frame.is_valid(&p), || format!("{frame:?} is not valid"));
    let up = frame.forward(&p);
    t.promise((up - Vec3::Z).length() < 1e-5, || {
        format!("forward is {up}")
    });
}

fn heading_beyond_one(t: &mut Trial) {
    let p = t.profile.clone();
    // Lengths whose reciprocal rounds up, so that z comes out above 1.
    for bits in 0..4000_u32 {
        let long = f32::from_bits(3.0_f32.to_bits() + bits * 977);
        let mut frame = Frame::IDENTITY;
        frame.set_vector_heading(Vec3::new(0.0, 0.0, long), &p);
        let q = frame.rotation();
        let nan = [q.w, q.x, q.y, q.z].iter().any(|c| c.is_nan());
        if nan == frame.is_valid(&p) {
            t.promise(false, || format!("length {long}: validity does not see it"));
        }
    }
    t.promise(true, String::new);
}

fn zero_quaternion(t: &mut Trial) {
    let p = t.profile.clone();
    let zero = Quat::new(0.0, 0.0, 0.0, 0.0);
    let frame = Frame::new(Vec3::ZERO, zero);
    t.promise(!frame.is_valid(&p), || {
        "the zero quaternion is valid".into()
    });
    t.same(
        "a vector turned by it",
        frame.local_to_global_vec(Vec3::X, &p),
        Vec3::X,
    );
    let mut turned = frame;
    turned.set_rotation(zero, &p);
    t.promise(!turned.is_valid(&p), || {
        "normalising 0 gives a valid frame".into()
    });
}

fn nan_origin(t: &mut Trial) {
    let p = t.profile.clone();
    let frame = Frame::from_origin(Vec3::new(f32::NAN, 0.0, 0.0));
    t.promise(!frame.is_valid(&p), || "a NaN origin is valid".into());
    let mut position = Position { cell: BLOCK, frame };
    t.promise(!position.adjust_to_outside(&p), || {
        "a NaN origin has a cell".into()
    });
}

fn infinite_origin(t: &mut Trial) {
    let p = t.profile.clone();
    let frame = Frame::from_origin(Vec3::new(f32::INFINITY, 0.0, 0.0));
    t.promise(frame.is_valid(&p), || {
        "an infinite origin is not valid".into()
    });
    let mut position = Position { cell: BLOCK, frame };
    t.promise(!position.adjust_to_outside(&p), || {
        "an infinite origin has a cell".into()
    });
}

fn negative_zero(t: &mut Trial) {
    let (_, point) = BLOCK.adjust_to_outside(Vec3::new(-0.0, 5.0, 0.0), &t.profile);
    t.same("bits of x", point.x.to_bits(), 0);
}

fn below_border(t: &mut Trial) {
    let x = 192.0_f32.next_down();
    let (cell, point) = BLOCK.adjust_to_outside(Vec3::new(x, 5.0, 0.0), &t.profile);
    t.same("cell", cell, CellId(0x2020_0000 | (7 * 8 + 1)));
    t.same("x", point.x, x);
}

fn huge_coordinates(t: &mut Trial) {
    // The specification asks nobody to generate them: they must neither hang nor give a cell off the map.
    for x in [2.0_f32.powi(23), 3.3e7, 1e9, 1e20, f32::MAX] {
        for x in [x, -x] {
            let (cell, _) = BLOCK.adjust_to_outside(Vec3::new(x, 5.0, 0.0), &t.profile);
            t.promise(cell.is_none() || cell.cell_in_range(), || {
                format!("x = {x} is in {cell}")
            });
        }
    }
}

fn off_map_blocks(t: &mut Trial) {
    let east = CellId(0xFF20_0001);
    t.promise(!east.is_inbound_valid(), || {
        "column 0xFF is on the map".into()
    });
    t.same("its coordinates", east.land_coord(), None);
    let north = CellId(0x20FF_0001);
    let (cell, _) = north.adjust_to_outside(Vec3::new(5.0, 5.0, 0.0), &t.profile);
    t.promise(cell.is_none(), || format!("row 0xFF has cell {cell}"));
}

fn slow_spin(t: &mut Trial) {
    let p = t.profile.clone();
    let mut frame = Frame::IDENTITY;
    frame.grotate(Vec3::new(0.0, 0.0, EPSILON * 0.9), &p);
    t.same("turn below epsilon", frame.bits(), Frame::IDENTITY.bits());
    frame.grotate(Vec3::new(0.0, 0.0, EPSILON * 1.1), &p);
    t.promise(frame != Frame::IDENTITY, || {
        "a turn above epsilon is lost".into()
    });
    // The same spin: stands at a high frame rate, turns at a low one.
    let Ok(play) = worlds::play() else {
        return t.promise(false, || "no world".into());
    };
    let spin = |dt: f64, count: u32| {
        Stage::new(play)
            .frames(dt, count)
            .entity(play.ball, [30.0, 100.0, 40.0], |spec| {
                spec.state = FLOATS;
                spec.omega = [0.0, 0.0, 0.0045];
            })
    };
    let fast = t.scene(&spin(0.04, 100));
    let slow = t.scene(&spin(0.1, 40));
    t.same(
        "rotation at 25 quanta a second",
        fast.last(0).rotation,
        [1.0, 0.0, 0.0, 0.0],
    );
    t.promise(slow.last(0).rotation != [1.0, 0.0, 0.0, 0.0], || {
        "does not turn at 10 a second".into()
    });
}

fn opposite_rotations(t: &mut Trial) {
    let p = t.profile.clone();
    for degrees in [179.0_f32, 179.99, 180.0, 180.01, 359.0] {
        let (mut a, mut b, mut between) = (Frame::IDENTITY, Frame::IDENTITY, Frame::IDENTITY);
        a.set_heading(0.0, &p);
        b.set_heading(degrees, &p);
        for share in [0.0, 0.25, 0.5, 1.0] {
            between.interpolate_rotation(&a, &b, share, &p);
            t.promise(between.is_valid(&p), || {
                format!("{degrees} degrees at {share}: {between:?}")
            });
        }
    }
}

fn steep_snap(t: &mut Trial) {
    let p = t.profile.clone();
    for nz in [EPSILON * 1.01, -EPSILON * 1.01, EPSILON, EPSILON * 0.5] {
        let n = Vec3::new((1.0 - nz * nz).sqrt(), 0.0, nz);
        let plane = Plane { n, d: -70.0 };
        let mut offset = Vec3::new(0.01, 0.02, 0.0);
        plane.snap_to_plane(&mut offset, &p);
        t.promise(offset.is_finite(), || format!("n.z = {nz}: {offset}"));
        if nz.abs() <= EPSILON {
            t.same("z at or below epsilon", offset.z, 0.0);
        }
    }
}

fn far_plane(t: &mut Trial) {
    let n = Vec3::new(0.36, 0.48, 0.8);
    for far in [190.0_f32, 500.0, 900.0] {
        let point = Vec3::new(far, far, far);
        let plane = Plane::from_normal_and_point(n, point);
        let height = plane.height_at(point).unwrap_or(f32::NAN);
        t.promise((height - far).abs() < 1e-3, || {
            format!("height {height} at {far}")
        });
    }
}

fn quaternion_limit(t: &mut Trial) {
    let p = t.profile.clone();
    let of = |squared: f32| Quat::new(squared.sqrt(), 0.0, 0.0, 0.0);
    t.same("squared length 1.0009", of(1.0009).is_valid(&p), true);
    t.same("squared length 1.0012", of(1.0012).is_valid(&p), false);
    t.same(
        "not-a-number",
        Quat::new(f32::NAN, 0.0, 0.0, 0.0).is_valid(&p),
        false,
    );
    t.same("normalised", of(4.0).normalized(&p).is_valid(&p), true);
    t.promise(vector::is_valid(Vec3::INFINITY), || {
        "infinity is no number".into()
    });
}

fn gate_times(t: &mut Trial) {
    let Ok(play) = worlds::play() else {
        return t.promise(false, || "no world".into());
    };
    let fall = |dt: f64| {
        // The clock starts at 0, so that the first gap is the frame itself.
        let stage = Stage::new(play).starts(0.0).frames(dt, 1);
        stage.thrown(play.ball, [30.0, 100.0, 40.0], [1.0, 0.0, 0.0])
    };
    let wanted = [
        (1.0 / 30.0, 0),
        ((1.0_f64 / 30.0).next_up(), 1),
        (0.2, 1),
        (0.2_f64.next_up(), 1),
        (0.21, 1),
        (0.25, 2),
        (2.0, 10),
        (2.0_f64.next_up(), 0),
    ];
    for (dt, quanta) in wanted {
        let run = t.scene(&fall(dt));
        let found = run.quanta();
        t.promise(found == quanta || (dt == 2.0 && found == 9), || {
            format!("dt {dt}: {found} quanta, wanted {quanta}")
        });
    }
}
