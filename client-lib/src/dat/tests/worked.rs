//! The worked bytes of `spec/11-dat-files.md, 14`.

use super::super::{
    BspTag, DrawingNode, EnvCell, GfxObj, Iteration, MotionBits, MotionData, MotionDataFlags,
    PortalFlags, Reader, Record, Sides, Stippling, Strictness, Writer,
};
use super::files;
use crate::math::Vec3;

fn hex(text: &str) -> Vec<u8> {
    text.split_whitespace()
        .map(|b| u8::from_str_radix(b, 16).expect("hex"))
        .collect()
}

fn written(f: impl FnOnce(&mut Writer)) -> Vec<u8> {
    let mut w = Writer::new();
    f(&mut w);
    w.finish(0).expect("written")
}

fn reader(bytes: &[u8]) -> Reader<'_> {
    Reader::new("worked", 0, bytes, Strictness::Strict)
}

#[test]
fn compressed_numbers() {
    for (v, bytes) in [
        (0, "00"),
        (0x7F, "7F"),
        (0x80, "80 80"),
        (0x3FFF, "BF FF"),
        (0x4000, "C0 00 00 40"),
        (0x1234_5678, "D2 34 78 56"),
    ] {
        let bytes = hex(bytes);
        assert_eq!(written(|w| w.compressed_u32(v)), bytes);
        assert_eq!(reader(&bytes).compressed_u32().expect("read"), v);
    }
    // Forms that are longer than needed are read all the same.
    assert_eq!(reader(&hex("80 00")).compressed_u32().expect("read"), 0);
    assert_eq!(
        reader(&hex("C0 00 00 00")).compressed_u32().expect("read"),
        0
    );
}

#[test]
fn packed_ids() {
    for (did, bytes) in [(0x0100_0002, "02 00"), (0x0101_0003, "01 80 03 00")] {
        let bytes = hex(bytes);
        assert_eq!(written(|w| w.packed_did(did, 0x0100_0000)), bytes);
        assert_eq!(reader(&bytes).packed_did(0x0100_0000).expect("read"), did);
    }
}

#[test]
fn strings() {
    let bytes = hex("07 00 54 65 73 74 62 65 64 00 00 00");
    assert_eq!(written(|w| w.pstring("Testbed")), bytes);
    assert_eq!(reader(&bytes).pstring().expect("read"), "Testbed");
    let bytes = hex("02 00 14 26");
    assert_eq!(written(|w| w.obfuscated_string("Ab")), bytes);
    assert_eq!(reader(&bytes).obfuscated_string().expect("read"), "Ab");
}

#[test]
fn tags() {
    for (tag, bytes) in [
        (BspTag::Leaf, "46 41 45 4C"),
        (BspTag::Port, "54 52 4F 50"),
        (BspTag::BPnN, "4E 6E 50 42"),
        (BspTag::BpIn, "6E 49 70 42"),
    ] {
        assert_eq!(tag.value().to_le_bytes().to_vec(), hex(bytes));
        assert_eq!(BspTag::from_value(tag.value()), Some(tag));
    }
}

#[test]
fn iteration_and_motion_data() {
    let bytes = hex("01 00 00 00 FF FF FF FF 01 00 00 00");
    assert_eq!(Iteration::complete(1).to_bytes().expect("written"), bytes);
    let read =
        Iteration::from_bytes("worked", 0xFFFF_0001, &bytes, Strictness::Strict).expect("read");
    assert_eq!(read, Iteration::complete(1));
    let motion = MotionData::playing(0x0300_0001, 0, -1, 30.0)
        .with_omega(Vec3::Z)
        .with_bits(MotionBits::FROM_DEFAULT_ONLY);
    assert_eq!(motion.flags, MotionDataFlags::OMEGA);
    assert_eq!(written(|w| motion.write(w))[..4], hex("01 02 02 00"));
}

#[test]
fn a_whole_shape() {
    let [portal, _] = files("testbed");
    let bytes = portal.get(0x0100_0007).expect("read").expect("there");
    assert_eq!(bytes.len(), 248);
    assert_eq!(
        bytes[..0x15],
        hex("07 00 00 01 0A 00 00 00 01 01 00 00 08 01 00 00 00 04 00 00 00")[..]
    );
    assert_eq!(bytes[0xB2..0xB6], hex("00 00 04 00")[..]);
    assert_eq!(bytes[0xCA..0xCE], hex("4C 4F 50 42")[..]);
    let shape = portal
        .record::<GfxObj>(0x0100_0007)
        .expect("read")
        .expect("there");
    assert_eq!(shape.surfaces, [0x0800_0001]);
    assert_eq!(shape.vertices.len(), 4);
    assert_eq!(
        shape.vertices.get(0).expect("vertex").position,
        Vec3::new(-1.0, 0.0, 0.0)
    );
    assert_eq!(shape.vertices.uvs(0), [[-0.25, -0.0]]);
    assert_eq!(shape.sort_center, Vec3::Z);
    assert!(shape.physics.is_none());
    let drawing = shape.drawing.as_ref().expect("drawn");
    let polygon = drawing.polygons.get(0).expect("polygon");
    assert_eq!(
        (polygon.stippling, polygon.sides),
        (Stippling::empty(), Sides::BOTH_ALIKE)
    );
    assert_eq!(
        (
            polygon.front_surface,
            polygon.back_surface,
            polygon.effective_back_surface()
        ),
        (0, -1, 0)
    );
    assert_eq!(
        (polygon.points, polygon.front_uvs),
        (&[0, 1, 2, 3][..], &[0, 0, 0, 0][..])
    );
    let Some(DrawingNode::Inner(root)) = drawing.bsp.root() else {
        panic!("an inner node")
    };
    assert_eq!(
        (root.tag, root.plane.n, root.plane.d),
        (BspTag::BPOL, Vec3::NEG_Y, 0.0)
    );
    assert_eq!(shape.drawing_sphere().expect("sphere").radius, 1.414_313_6);
    assert_eq!(drawing.bsp.polygons(root.polygons), [0]);
    assert_eq!(shape.degrade, 0x1100_0001);
}

#[test]
fn a_whole_room() {
    let [_, cell] = files("testbed");
    let bytes = cell.get(0xA9B4_0105).expect("read").expect("there");
    assert_eq!(bytes.len(), 78);
    assert_eq!(
        bytes[..0x18],
        hex("05 01 B4 A9 01 00 00 00 05 01 B4 A9 02 02 05 00 01 00 02 00 01 00 05 00")[..]
    );
    let room = cell
        .record::<EnvCell>(0xA9B4_0105)
        .expect("read")
        .expect("there");
    assert!(room.seen_outside());
    assert_eq!(
        (room.surface_id(0), room.surface_id(1), room.surface_id(2)),
        (Some(0x0800_0001), Some(0x0800_0002), None)
    );
    assert_eq!((room.environment_id(), room.structure), (0x0D00_0001, 5));
    assert_eq!(room.frame.origin, Vec3::new(108.0, 108.0, 20.0));
    let [a, b] = room.portals[..] else {
        panic!("two portals")
    };
    assert_eq!(
        (a.flags, a.polygon, a.other_room, a.other_portal),
        (PortalFlags::EXACT_MATCH, 0, 0x102, 3)
    );
    assert!(a.flags.portal_side() && !b.flags.portal_side());
    assert_eq!((b.polygon, b.other_room, b.other_portal), (1, 0x104, 0));
    assert_eq!(room.visible_rooms, [0x100, 0x101, 0x102, 0x103, 0x104]);
}
