//! Worked values (`spec/01-math-and-positions.md`, 14) and invariants (15) of the mathematics.

#![allow(
    clippy::excessive_precision,
    reason = "the digits are those of the specification's tables"
)]

use ac_client::math::{
    BoundingBox, CellId, Frame, LandCoord, Plane, Position, Quat, Sidedness, UprightCylinder, Vec3,
    block_offset, vector,
};
use ac_client::profile::Profile;
use proptest::prelude::*;

const RETAIL: Profile = Profile::retail();

fn upright(heading: f32) -> Frame {
    let mut frame = Frame::IDENTITY;
    frame.set_heading(heading, &RETAIL);
    frame
}

#[test]
fn headings_become_the_quaternions_of_the_table() {
    let rows: [(f32, f32, f32, f32); 11] = [
        (0.0, 1.0, -0.0, 0.0),
        (1.0, 0.999961913, -0.00872653536, 1.0),
        (45.0, 0.923879504, -0.382683456, 45.0),
        (89.5, 0.710185409, -0.704014719, 89.5),
        (90.0, 0.707106829, -0.707106829, 90.0),
        (180.0, -4.37113883e-08, -1.0, 180.0),
        (270.0, -0.707106829, -0.707106829, 270.0),
        (359.0, -0.999961913, -0.00872663688, 359.0),
        (360.0, 1.0, -0.0, 0.0),
        (-90.0, -0.707106829, -0.707106829, 270.0),
        (450.0, 0.707106829, -0.707106829, 90.0),
    ];
    for (heading, w, z, after) in rows {
        let frame = upright(heading);
        let q = frame.rotation();
        assert_eq!((q.w, q.x, q.y, q.z), (w, 0.0, 0.0, z), "heading {heading}");
        assert_eq!(frame.heading(&RETAIL), after, "heading {heading}");
    }
}

#[test]
fn adjust_to_outside_gives_the_cells_of_the_table() {
    let rows: [(u32, f32, f32, u32, f32, f32); 11] = [
        (0xA9B40019, -0.5, 10.0, 0xA8B40039, 191.5, 10.0),
        (0xA9B40001, -0.00019, 0.0, 0xA9B40001, 0.0, 0.0),
        (
            0xA9B40001,
            -0.0002,
            0.0,
            0xA8B40039,
            191.999_801_635_742_19,
            0.0,
        ),
        (0xA9B40001, 24.0, 23.999998, 0xA9B40009, 24.0, 23.999998),
        (0xA9B40001, 192.0, 192.0, 0xAAB50001, 0.0, 0.0),
        (0xA9B40105, 30.0, 100.0, 0xA9B4000D, 30.0, 100.0),
        (0x00000001, -1.0, 5.0, 0, -1.0, 5.0),
        (0xFEFE0040, 200.0, 10.0, 0, 200.0, 10.0),
        (0xA9B40050, 1.0, 1.0, 0, 1.0, 1.0),
        (0xA9B4FFFE, 1.0, 1.0, 0, 1.0, 1.0),
        (0xA9B4FFFF, 1.0, 1.0, 0xA9B40001, 1.0, 1.0),
    ];
    for (id, x, y, want, wx, wy) in rows {
        let (cell, at) = CellId(id).adjust_to_outside(Vec3::new(x, y, 7.0), &RETAIL);
        assert_eq!(
            (cell, at),
            (CellId(want), Vec3::new(wx, wy, 7.0)),
            "{id:#X} ({x}, {y})"
        );
    }
}

/// `04:A6`: with a block off the map on either side, different from the other, one reference throws.
#[test]
fn offsets_off_the_map_by_profile() {
    let cases = [
        (0xFFF6_0013, 0xFE78_003E, true),
        (0xA4FF_003E, 0xFDE9_0020, true),
        (0xA9B4_0001, 0xFFB4_0001, true),
        (0xFFFF_0001, 0xFFFF_0100, false),
        (0, 0xFEFE_0001, false),
        (0xFE00_0001, 0x00FE_0001, false),
    ];
    for (from, to, throws) in cases {
        let (from, to) = (CellId(from), CellId(to));
        let plain = Some(block_offset(from, to));
        assert_eq!(from.block_offset_to(to, &RETAIL), plain);
        assert_eq!(from.block_offset_to(to, &Profile::gdle()), plain);
        let ace = from.block_offset_to(to, &Profile::ace());
        assert_eq!(ace, plain.filter(|_| !throws), "{from} {to}");
    }
}

#[test]
fn offsets_of_the_table() {
    let offset = |a, b| block_offset(CellId(a), CellId(b));
    assert_eq!(offset(0xA9B40001, 0xA9B40105), Vec3::ZERO);
    assert_eq!(offset(0xA9B40001, 0xAAB40001), Vec3::new(192.0, 0.0, 0.0));
    assert_eq!(
        offset(0xA9B40001, 0xA8B30001),
        Vec3::new(-192.0, -192.0, 0.0)
    );
    assert_eq!(
        offset(0x00000001, 0xFEFE0001),
        Vec3::new(48768.0, 48768.0, 0.0)
    );
    let a = Position::new(
        CellId(0xA9B40039),
        Vec3::new(190.0, 5.0, 0.0),
        Quat::IDENTITY,
    );
    let b = Position::new(CellId(0xAAB40001), Vec3::new(3.0, 5.0, 0.0), Quat::IDENTITY);
    assert_eq!(a.offset_to(&b), Vec3::new(5.0, 0.0, 0.0));
    assert_eq!((a.distance(&b), a.heading_to(&b, &RETAIL)), (5.0, 90.0));
}

#[test]
fn hard_cases_answer_as_specified() {
    let mut frame = upright(33.0);
    let before = frame.bits();
    frame.set_vector_heading(Vec3::ZERO, &RETAIL);
    assert_eq!(frame.bits(), before, "a zero vector has no heading");
    let here = Position::new(CellId(0xA9B40001), Vec3::ZERO, Quat::IDENTITY);
    let above = Position::new(CellId(0xA9B40001), Vec3::new(0.0, 0.0, 9.0), Quat::IDENTITY);
    assert_eq!(here.heading_to(&above, &RETAIL), 0.0);
    frame.set_vector_heading(Vec3::Z, &RETAIL);
    assert!(frame.is_valid(&RETAIL) && frame.forward(&RETAIL).z > 0.999);
    let zero = Frame::new(Vec3::ZERO, Quat::new(0.0, 0.0, 0.0, 0.0));
    assert!(!zero.is_valid(&RETAIL));
    assert_eq!(zero.axes(&RETAIL), [Vec3::X, Vec3::Y, Vec3::Z]);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(
            CellId(0xA9B40001)
                .adjust_to_outside(Vec3::new(bad, 1.0, 0.0), &RETAIL)
                .0
                .is_none()
        );
    }
    assert!(!Frame::from_origin(Vec3::new(0.0, f32::NAN, 0.0)).is_valid(&RETAIL));
    assert!(Frame::from_origin(Vec3::new(0.0, f32::INFINITY, 0.0)).is_valid(&RETAIL));
    let squared = |s: f32| Quat::new(s.sqrt(), 0.0, 0.0, 0.0).is_valid(&RETAIL);
    assert!(squared(1.0009) && !squared(1.0011));
}

fn land_id() -> impl Strategy<Value = CellId> {
    (0u32..255, 0u32..255, 1u32..=64).prop_map(|(x, y, c)| CellId(x << 24 | y << 16 | c))
}

fn any_id() -> impl Strategy<Value = CellId> {
    (
        0u32..255,
        0u32..255,
        prop_oneof![1u32..=64, 0x100u32..=0xFFFD],
    )
        .prop_map(|(x, y, c)| CellId(x << 24 | y << 16 | c))
}

fn vec(range: f32) -> impl Strategy<Value = Vec3> {
    (-range..range, -range..range, -range..range).prop_map(Vec3::from)
}

fn rotation() -> impl Strategy<Value = Quat> {
    (-1f32..1.0, -1f32..1.0, -1f32..1.0, -1f32..1.0)
        .prop_filter("long enough to be normalised", |(w, x, y, z)| {
            w * w + x * x + y * y + z * z > 0.01
        })
        .prop_map(|(w, x, y, z)| Quat::new(w, x, y, z).normalized(&RETAIL))
}

fn frame() -> impl Strategy<Value = Frame> {
    (vec(200.0), rotation()).prop_map(|(o, q)| Frame::new(o, q))
}

fn unit_length(q: Quat) -> bool {
    (q.length() - 1.0).abs() <= 2.0 * f32::EPSILON
}

fn components(q: Quat) -> [f32; 4] {
    [q.w, q.x, q.y, q.z]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn ids_and_coordinates_are_inverse(id in land_id(), x in -50i32..2090, y in -50i32..2090) {
        prop_assert_eq!(id.land_coord().map(LandCoord::cell_id), Some(id));
        let c = LandCoord { x, y };
        if c.in_bounds() {
            prop_assert_eq!(c.cell_id().land_coord(), Some(c));
        } else {
            prop_assert_eq!(c.cell_id(), CellId::NONE);
        }
    }

    #[test]
    fn adjusted_points_lie_in_their_block(id in any_id(), at in vec(2000.0)) {
        let (cell, moved) = id.adjust_to_outside(at, &RETAIL);
        prop_assume!(!cell.is_none());
        prop_assert!((0.0..192.0).contains(&moved.x) && (0.0..192.0).contains(&moved.y));
        prop_assert!((1..=64).contains(&cell.low()));
        let shift = block_offset(id, cell) + moved - at;
        prop_assert!(shift.abs().max_element() <= vector::EPSILON + 2e-4);
        prop_assert_eq!(cell.adjust_to_outside(moved, &RETAIL), (cell, moved));
    }

    /// `spec/04`, 6 item 2: merging is growing by both corners, and a box merged into nothing is itself.
    #[test]
    fn merged_boxes_hold_both(
        a in prop::array::uniform6(-50.0f32..50.0), b in prop::array::uniform6(-50.0f32..50.0),
    ) {
        let boxed = |v: [f32; 6]| {
            let (p, q) = (Vec3::new(v[0], v[1], v[2]), Vec3::new(v[3], v[4], v[5]));
            BoundingBox { min: p.min(q), max: p.max(q) }
        };
        let (a, b) = (boxed(a), boxed(b));
        let (mut merged, mut grown) = (b, b);
        a.merge_into(&mut merged);
        grown.adjust(a.min);
        grown.adjust(a.max);
        prop_assert_eq!(merged, grown);
        prop_assert!(merged.corners().iter().all(|&c| merged.contains(c)));
        prop_assert!(a.corners().iter().chain(&b.corners()).all(|&c| merged.contains(c)));
        let mut nothing = BoundingBox::EMPTY;
        a.merge_into(&mut nothing);
        prop_assert_eq!(nothing, a);
        let mut unchanged = a;
        BoundingBox { min: Vec3::NAN, max: Vec3::NAN }.merge_into(&mut unchanged);
        prop_assert_eq!(unchanged, a);
    }

    #[test]
    fn block_offsets_are_antisymmetric_and_additive(a in any_id(), b in any_id(), c in any_id()) {
        prop_assert_eq!(block_offset(a, b), -block_offset(b, a));
        prop_assert_eq!(block_offset(a, b) + block_offset(b, c), block_offset(a, c));
    }

    #[test]
    fn offsets_between_positions_are_antisymmetric(a in any_id(), b in any_id(), p in vec(192.0), q in vec(192.0)) {
        let (one, two) = (Position::new(a, p, Quat::IDENTITY), Position::new(b, q, Quat::IDENTITY));
        let (there, back) = (one.offset_to(&two), -two.offset_to(&one));
        if a.same_block(b) {
            prop_assert_eq!(there, back);
        }
        let size = block_offset(a, b).abs() + p.abs() + q.abs();
        for i in 0..3 {
            prop_assert!((there[i] - back[i]).abs() <= 2.0 * f32::EPSILON * size[i].max(f32::MIN_POSITIVE));
        }
    }

    #[test]
    fn headings_lie_in_a_full_circle(f in frame(), g in frame()) {
        let (a, b) = (Position { cell: CellId(0xA9B40001), frame: f }, Position { cell: CellId(0xA9B50001), frame: g });
        for h in [a.heading_to(&b, &RETAIL), f.heading(&RETAIL), g.heading(&RETAIL)] {
            prop_assert!((0.0..360.0).contains(&h));
        }
    }

    #[test]
    fn a_heading_that_was_set_is_read_back(h in -1000f32..1000.0) {
        let read = upright(h).heading(&RETAIL);
        let difference = (read - h).rem_euclid(360.0);
        prop_assert!(difference.min(360.0 - difference) < 1e-3);
    }

    #[test]
    fn every_turn_ends_with_a_unit_rotation(f in frame(), g in frame(), turn in vec(3.0), h in 0f32..360.0, t in 0f32..=1.0) {
        let mut turned = f;
        turned.grotate(turn, &RETAIL);
        let mut local = f;
        local.rotate(turn, &RETAIL);
        let mut headed = f;
        headed.set_heading(h, &RETAIL);
        let mut between = f;
        between.interpolate_rotation(&f, &g, t, &RETAIL);
        for frame in [turned, local, headed, between, f.combine(&g, &RETAIL)] {
            prop_assert!(unit_length(frame.rotation()), "{:?}", frame.rotation());
        }
    }

    #[test]
    fn points_come_back(f in frame(), p in vec(200.0)) {
        let back = f.global_to_local(f.local_to_global(p, &RETAIL), &RETAIL);
        let bound = 8.0 * f32::EPSILON * (p.length() + f.origin.length());
        prop_assert!((back - p).length() <= bound, "{} > {bound}", (back - p).length());
    }

    #[test]
    fn combining_with_identity_only_normalises(f in frame()) {
        let combined = f.combine(&Frame::IDENTITY, &RETAIL);
        prop_assert_eq!(combined.origin, f.origin);
        prop_assert_eq!(combined.rotation(), f.rotation().normalized(&RETAIL));
        if f.rotation().length() == 1.0 {
            prop_assert_eq!(combined.rotation(), f.rotation());
        }
    }

    #[test]
    fn subtracting_undoes_combining(a in frame(), b in frame()) {
        let back = a.combine(&b, &RETAIL).subtract_animation(&b, &RETAIL);
        prop_assert!((back.origin - a.origin).length() <= 1e-5 * (a.origin.length() + b.origin.length()));
        for (x, y) in components(back.rotation()).into_iter().zip(components(a.rotation())) {
            prop_assert!((x - y).abs() < 1e-5);
        }
    }

    #[test]
    fn a_frame_seen_from_itself_is_identity(f in frame()) {
        let own = f.relative_to(&f, &RETAIL);
        prop_assert_eq!(own.origin, Vec3::ZERO);
        for (x, y) in components(own.rotation()).into_iter().zip([1.0, 0.0, 0.0, 0.0]) {
            prop_assert!((x - y).abs() < 1e-6);
        }
    }

    #[test]
    fn tiny_turns_leave_every_bit(f in frame(), turn in vec(0.0001)) {
        prop_assume!(turn.length() < vector::EPSILON);
        let mut turned = f;
        turned.grotate(turn, &RETAIL);
        prop_assert_eq!(turned.bits(), f.bits());
    }

    #[test]
    fn a_turn_about_z_lowers_the_heading(h in 0f32..360.0, a in 0.01f32..3.0) {
        let mut frame = upright(h);
        frame.grotate(Vec3::new(0.0, 0.0, a), &RETAIL);
        let difference = (h - a.to_degrees() - frame.heading(&RETAIL)).rem_euclid(360.0);
        prop_assert!(difference.min(360.0 - difference) < 1e-3);
    }

    #[test]
    fn interpolation_meets_both_ends(a in frame(), b in frame(), t in 0f32..=1.0) {
        let at = |t| {
            let mut f = a;
            f.interpolate_rotation(&a, &b, t, &RETAIL);
            f.rotation()
        };
        let close = |p: Quat, q: Quat| p.dot(q).abs() > 1.0 - 1e-6;
        prop_assert!(close(at(0.0), a.rotation()) && close(at(1.0), b.rotation()));
        prop_assert!(at(t).dot(a.rotation()) >= -1e-6);
    }

    #[test]
    fn a_box_in_front_has_all_corners_in_front(n in rotation(), d in -5f32..5.0, p in vec(3.0), q in vec(3.0)) {
        let plane = Plane { n: Frame::new(Vec3::ZERO, n).axes(&RETAIL)[2], d };
        let mut bounds = BoundingBox { min: p, max: p };
        bounds.adjust(q);
        if plane.intersect_box(&bounds, &RETAIL) == Sidedness::Positive {
            prop_assert!(bounds.corners().iter().all(|&c| plane.distance(c) > vector::EPSILON));
        }
    }

    #[test]
    fn a_height_lies_on_its_plane(q in rotation(), point in vec(192.0), x in 0f32..192.0, y in 0f32..192.0) {
        let n = Frame::new(Vec3::ZERO, q).axes(&RETAIL)[2];
        prop_assume!(n.z.abs() > 0.1);
        let plane = Plane::from_normal_and_point(n, point);
        let z = plane.height_at(Vec3::new(x, y, 0.0)).unwrap();
        prop_assume!(z.abs() < 1000.0);
        prop_assert!(plane.distance(Vec3::new(x, y, z)).abs() < 2e-4);
    }

    #[test]
    fn level_points_have_the_flat_distance(a in vec(192.0), b in vec(192.0), r1 in 0f32..2.0, r2 in 0f32..2.0) {
        let at = |o: Vec3| Position::new(CellId(0xA9B40001), Vec3::new(o.x, o.y, 4.0), Quat::IDENTITY);
        let (p, q) = (at(a), at(b));
        let one = UprightCylinder { radius: r1, height: 0.0, position: &p };
        let two = UprightCylinder { radius: r2, height: 0.0, position: &q };
        prop_assert_eq!(one.distance(&two, &RETAIL), f64::from(one.distance_no_z(&two)));
    }

    #[test]
    fn position_equality_is_symmetric(a in frame(), step in vec(0.0004)) {
        let one = Position { cell: CellId(0xA9B40001), frame: a };
        let mut two = one;
        two.frame.origin += step;
        prop_assert_eq!(one.is_equal(&two, &RETAIL), two.is_equal(&one, &RETAIL));
    }
}
