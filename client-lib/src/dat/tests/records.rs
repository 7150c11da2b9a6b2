//! Records from random values: what is written is read, byte for byte (`spec/11-dat-files.md, 15`: 8 to 15, and the cases of 16).

use proptest::prelude::*;

use super::super::worldgen::{Rect, Room, Side};
use super::super::{
    AnimFrame, Animation, AnimationHook, AnyRecord, Building, BuildingPortal, CellPortal,
    CylSphere, EnvCell, EnvCellFlags, Environment, KeyedList, Landblock, LandblockInfo,
    LandblockInfoMask, Light, Location, MotionBits, MotionData, MotionTable, PhysicsScript,
    Polygon, PolygonSet, PortalFlags, Reader, Record, RecordKind, ScriptEntry, Setup, SetupFlags,
    Sides, Stab, Stippling, StoredFrame, Strictness, TerrainWord, VertexArray, Writer,
};
use crate::math::{Quat, Sphere, Vec3};

fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        -1e6f32..1e6,
        Just(0.0),
        Just(-0.0),
        Just(f32::MIN_POSITIVE / 2.0),
        Just(1e38)
    ]
}

fn vector() -> impl Strategy<Value = Vec3> {
    (number(), number(), number()).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

fn frame() -> impl Strategy<Value = StoredFrame> {
    (vector(), -3.2f32..3.2).prop_map(|(origin, a)| StoredFrame {
        origin,
        rotation: Quat {
            w: a.cos(),
            x: 0.0,
            y: a.sin(),
            z: 0.0,
        },
    })
}

fn stab() -> impl Strategy<Value = Stab> {
    (any::<u32>(), frame()).prop_map(|(model, frame)| Stab { model, frame })
}

/// Any hook: random payload bytes for a random type. Frames inside need a unit quaternion, so it is patched in.
fn hook() -> impl Strategy<Value = AnimationHook> {
    (0u32..27, -2i32..2, prop::collection::vec(0u8..0x7F, 44)).prop_map(
        |(kind, direction, mut payload)| {
            payload[20..36]
                .copy_from_slice(&[0, 0, 0x80, 0x3F, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
            let bytes: Vec<u8> = kind
                .to_le_bytes()
                .into_iter()
                .chain(direction.to_le_bytes())
                .chain(payload)
                .collect();
            AnimationHook::parse(&mut Reader::new("hook", 0, &bytes, Strictness::Strict))
                .expect("a hook")
        },
    )
}

fn anim_frame(parts: usize) -> impl Strategy<Value = AnimFrame> {
    (
        prop::collection::vec(frame(), parts),
        prop::collection::vec(hook(), 0..4),
    )
        .prop_map(|(parts, hooks)| AnimFrame { parts, hooks })
}

fn motion() -> impl Strategy<Value = MotionData> {
    let ranges = prop::collection::vec((any::<u32>(), any::<i32>(), any::<i32>(), number()), 0..4);
    (
        ranges,
        any::<Option<u8>>(),
        prop::option::of(vector()),
        prop::option::of(vector()),
    )
        .prop_map(|(ranges, bits, velocity, omega)| {
            let mut m = ranges
                .into_iter()
                .fold(MotionData::default(), |m, (a, low, high, rate)| {
                    m.then(a, low, high, rate)
                });
            m = m.with_bits(MotionBits::from_bits_retain(bits.unwrap_or(0)));
            m = velocity.into_iter().fold(m, MotionData::with_velocity);
            omega.into_iter().fold(m, MotionData::with_omega)
        })
}

/// Writes and reads strictly; the value, and the bytes of writing again, must be the same.
fn round_trip<T: Record + PartialEq + std::fmt::Debug>(
    record: &T,
) -> Result<Vec<u8>, TestCaseError> {
    let bytes = record.to_bytes().expect("written");
    let read = T::from_bytes("test.dat", record.id(), &bytes, Strictness::Strict).expect("read");
    prop_assert_eq!(&read, record);
    prop_assert_eq!(&read.to_bytes().expect("written"), &bytes);
    Ok(bytes)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn compressed_numbers(v in 0u32..0x4000_0000, shift in 0u32..30) {
        let v = v >> shift;
        let mut w = Writer::new();
        w.compressed_u32(v);
        let bytes = w.finish(0).expect("written");
        prop_assert_eq!(bytes.len(), if v < 0x80 { 1 } else if v < 0x4000 { 2 } else { 4 });
        prop_assert_eq!(Reader::new("", 0, &bytes, Strictness::Strict).compressed_u32().expect("read"), v);
    }

    #[test]
    fn packed_ids(v in 0u32..0x4000_0000, shift in 0u32..30, base in prop::sample::select(vec![0u32, 0x0100_0000, 0x0800_0000])) {
        let v = v >> shift;
        let mut w = Writer::new();
        w.packed_did(base + v, base);
        let bytes = w.finish(0).expect("written");
        prop_assert_eq!(bytes.len(), if v < 0x8000 { 2 } else { 4 });
        prop_assert_eq!(Reader::new("", 0, &bytes, Strictness::Strict).packed_did(base).expect("read"), base + v);
    }

    #[test]
    fn strings_of_any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..40), before in 0usize..4) {
        let text = encoding_rs::WINDOWS_1252.decode_without_bom_handling(&bytes).0.into_owned();
        let mut w = Writer::new();
        w.bytes(&[7; 4][..before]);
        w.pstring(&text);
        w.obfuscated_string(&text);
        prop_assert_eq!(w.len() % 4, 0);
        let out = w.finish(0).expect("written");
        let mut r = Reader::new("", 0, &out, Strictness::Strict);
        r.bytes(before).expect("read");
        prop_assert_eq!(&r.pstring().expect("read"), &text);
        prop_assert_eq!(&r.obfuscated_string().expect("read"), &text);
        prop_assert_eq!(r.left(), 0);
        prop_assert_eq!(&out[before + 2..before + 2 + bytes.len()], &bytes[..]);
    }

    #[test]
    fn align4_moves_by_at_most_three(n in 0usize..20) {
        let mut w = Writer::new();
        w.bytes(&vec![1; n]);
        w.align4();
        let once = w.len();
        w.align4();
        prop_assert_eq!(once, w.len());
        prop_assert!(once.is_multiple_of(4) && once - n <= 3);
    }

    #[test]
    fn landblocks(id in any::<u32>(), has_info in 0u32..2, seed in any::<u16>()) {
        let block = Landblock {
            id,
            has_info,
            terrain: std::array::from_fn(|i| TerrainWord(seed.wrapping_mul(i as u16))),
            heights: std::array::from_fn(|i| (seed as u8).wrapping_add(i as u8)),
        };
        prop_assert_eq!(round_trip(&block)?.len(), Landblock::SIZE);
        let t = block.terrain[1];
        prop_assert_eq!(TerrainWord::new(t.road(), t.terrain(), t.scenery()).0, t.0 & !0x0780);
    }

    #[test]
    fn rooms(
        (id, environment, structure) in any::<(u32, u16, u16)>(),
        surfaces in prop::collection::vec(any::<u16>(), 0..5),
        portals in prop::collection::vec(any::<[u16; 4]>(), 0..4),
        visible_rooms in prop::collection::vec(any::<u16>(), 0..4),
        frame in frame(),
        statics in prop::option::of(prop::collection::vec(stab(), 0..3)),
        restriction in any::<Option<u32>>(),
        seen in any::<bool>(),
    ) {
        let mut flags = EnvCellFlags::empty();
        flags.set(EnvCellFlags::SEEN_OUTSIDE, seen);
        flags.set(EnvCellFlags::STATICS, statics.is_some());
        flags.set(EnvCellFlags::RESTRICTION, restriction.is_some());
        let portals = portals.into_iter().map(|[a, polygon, other_room, other_portal]| {
            CellPortal { flags: PortalFlags::from_bits_retain(a), polygon, other_room, other_portal }
        });
        let room = EnvCell {
            id, flags, surfaces, environment, structure, frame, portals: portals.collect(), visible_rooms,
            statics: statics.unwrap_or_default(), restriction: restriction.unwrap_or(0),
        };
        let bytes = round_trip(&room)?;
        prop_assert_eq!(bytes.len() % 2, 0);
    }

    #[test]
    fn landblock_infos(
        id in any::<u32>(),
        room_count in 0u32..0xFEFE,
        statics in prop::collection::vec(stab(), 0..3),
        buildings in prop::collection::vec((stab(), any::<u32>(), prop::collection::vec((any::<[u16; 3]>(), 0usize..4), 0..3)), 0..3),
        restrictions in prop::option::of(prop::collection::btree_map(any::<u32>(), any::<u32>(), 0..12)),
    ) {
        let building = |(s, leaf_count, portals): (Stab, u32, Vec<([u16; 3], usize)>)| Building {
            model: s.model,
            frame: s.frame,
            leaf_count,
            portals: portals.into_iter().map(|([f, room, room_portal], n)| BuildingPortal {
                flags: PortalFlags::from_bits_retain(f), room, room_portal, visible_rooms: vec![room; n],
            }).collect(),
        };
        let mask = if restrictions.is_some() { LandblockInfoMask::RESTRICTIONS } else { LandblockInfoMask::empty() };
        // Not in order of key, so that the lookup has to sort.
        let table: Vec<(u32, u32)> = restrictions.unwrap_or_default().into_iter().rev().collect();
        let info = LandblockInfo {
            id, room_count, statics, buildings: buildings.into_iter().map(building).collect(), mask,
            restrictions: KeyedList::new(table.clone()), restriction_buckets: if mask.is_empty() { 0 } else { 8 },
        };
        prop_assert_eq!(round_trip(&info)?.len() % 4, 0);
        for (key, value) in table {
            prop_assert_eq!(info.restrictions.get(key), Some(&value));
            prop_assert_eq!(info.restrictions.get(key ^ 0x5555_0000).is_some(), info.restrictions.iter().any(|e| e.0 == key ^ 0x5555_0000));
        }
    }

    #[test]
    fn animations(
        (parts, frames) in (0usize..4).prop_flat_map(|p| (Just(p), prop::collection::vec((anim_frame(p), frame()), 0..4))),
        root in any::<bool>(),
    ) {
        let mut animation = Animation::new(0x0300_0001, parts as u32);
        for (f, r) in &frames {
            animation.push(f.clone(), root.then_some(*r));
        }
        round_trip(&animation)?;
        prop_assert_eq!(animation.frame_count(), frames.len());
        for (i, (f, r)) in frames.iter().enumerate() {
            let view = animation.frame(i).expect("a frame");
            prop_assert_eq!((view.parts, view.hooks), (&f.parts[..], &f.hooks[..]));
            prop_assert_eq!(animation.root_frame(i), root.then_some(r));
        }
        prop_assert!(animation.frame(frames.len()).is_none());
    }

    #[test]
    fn scripts(hooks in prop::collection::vec((any::<u8>(), hook()), 0..12)) {
        let entries = hooks.into_iter().map(|(t, hook)| ScriptEntry { time: f64::from(t / 64), hook }).collect();
        let script = PhysicsScript { id: 0x3300_0001, entries };
        round_trip(&script)?;
        let sorted = script.in_order_of_time();
        for w in sorted.windows(2) {
            let at = |e: &ScriptEntry| script.entries.iter().position(|x| std::ptr::eq(x, e)).expect("one of them");
            prop_assert!(w[0].time < w[1].time || (w[0].time == w[1].time && at(w[0]) < at(w[1])), "stable");
        }
    }

    #[test]
    fn motion_tables(
        styles in prop::collection::btree_map(any::<u32>(), any::<u32>(), 0..12),
        cycles in prop::collection::btree_map(any::<u32>(), motion(), 0..20),
        links in prop::collection::btree_map(any::<u32>(), prop::collection::btree_map(any::<u32>(), motion(), 0..4), 0..4),
    ) {
        let mut table = MotionTable::new(0x0900_0001, 0x8000_003D);
        table.style_defaults = styles.into_iter().rev().collect();
        table.cycles = cycles.clone().into_iter().rev().collect();
        table.links = links.into_iter().map(|(k, v)| (k, v.into_iter().collect())).collect();
        prop_assert_eq!(round_trip(&table)?.len() % 4, 0);
        for (key, motion) in &cycles {
            prop_assert_eq!(table.cycles.get(*key), Some(motion));
        }
    }

    #[test]
    fn setups(
        (parts, placements) in (0usize..4).prop_flat_map(|p| (Just(p), prop::collection::vec(anim_frame(p), 0..3))),
        (parents, scales) in any::<(bool, bool)>(),
        place in frame(),
        spheres in prop::collection::vec((vector(), number()), 0..3),
        lights in 0usize..3,
    ) {
        let mut s = Setup::empty(0x0200_0001);
        s.flags.set(SetupFlags::PARENTS, parents);
        s.flags.set(SetupFlags::SCALES, scales);
        s.parts = (0..parts as u32).map(|i| 0x0100_0000 + i).collect();
        s.parents = if parents { vec![u32::MAX; parts] } else { Vec::new() };
        s.scales = if scales { vec![Vec3::ONE; parts] } else { Vec::new() };
        s.placements = placements.into_iter().enumerate().map(|(i, f)| (i as i32 * 7, f)).collect();
        s.holding_locations.push(1, Location { part: 2, frame: place });
        s.cyl_spheres = spheres.iter().map(|&(low, radius)| CylSphere { low, radius, height: 2.0 }).collect();
        s.spheres = spheres.iter().map(|&(center, radius)| Sphere { center, radius }).collect();
        // Lights of one kind are legal: a list, not a map.
        s.lights = vec![(0, Light { frame: place, color: 1, intensity: 2.0, falloff: 3.0, cone_angle: 4.0 }); lights];
        round_trip(&s)?;
    }

    #[test]
    fn polygon_sets(
        heads in prop::collection::vec((3usize..12, any::<u8>(), 0i32..4, any::<(i16, i16)>()), 0..6),
        uvs in 1usize..4,
    ) {
        let mut vertices = VertexArray::default();
        for i in 0..12 {
            vertices.push(Vec3::splat(i as f32), Vec3::Z, &vec![[0.5, 0.25]; uvs]);
        }
        let mut set = PolygonSet::default();
        for &(n, stippling, sides, (front_surface, back_surface)) in &heads {
            let points: Vec<u16> = (0..n as u16).collect();
            let indices = vec![uvs as u8 - 1; n];
            set.push(Polygon {
                key: 0, stippling: Stippling::from_bits_retain(stippling), sides: Sides(sides), front_surface, back_surface,
                points: &points, front_uvs: &indices, back_uvs: &indices,
            });
        }
        for p in set.iter() {
            prop_assert!(p.front_uvs.is_empty() || p.front_uvs.len() == p.points.len());
            prop_assert!(p.back_uvs.is_empty() || (p.back_uvs.len() == p.points.len() && p.sides == Sides::BOTH));
        }
        let mut environment = Environment { id: 0x0D00_0001, structures: vec![Default::default()] };
        let room = Room::new(Vec3::ZERO, Vec3::ONE).structure();
        environment.structures[0] = super::super::CellStruct { vertices, polygons: set, physics_polygons: Default::default(), ..room };
        // The trees refer to polygons that are gone.
        environment.structures[0].physics_bsp = super::super::worldgen::physics_tree(&[], &[]);
        environment.structures[0].drawing_bsp = None;
        round_trip(&environment)?;
    }
}

#[test]
fn polygons_with_255_points_and_odd_numbers_of_portals() {
    let mut vertices = VertexArray::default();
    for i in 0..255 {
        vertices.push(Vec3::splat(i as f32), Vec3::Z, &[]);
    }
    let points: Vec<u16> = (0..255).collect();
    let mut polygons = PolygonSet::default();
    for stippling in [
        Stippling::NO_FRONT_UV,
        Stippling::NO_FRONT_UV | Stippling::NO_UVS,
        Stippling::NO_FRONT_UV | Stippling::NO_BACK_UV,
    ] {
        polygons.push(Polygon {
            key: 0,
            stippling,
            sides: if stippling.contains(Stippling::NO_BACK_UV) {
                Sides::BOTH
            } else {
                Sides::FRONT
            },
            front_surface: -1,
            back_surface: -1,
            points: &points,
            front_uvs: &[],
            back_uvs: &[],
        });
    }
    let door = Rect {
        u: [0.2, 0.4],
        v: [0.2, 0.4],
    };
    let room = Room::new(Vec3::ZERO, Vec3::ONE);
    for doors in 0..4 {
        let with_doors = Side::ALL[..doors]
            .iter()
            .fold(room.clone(), |r, &s| r.doorway(s, door));
        let big = super::super::CellStruct {
            vertices: vertices.clone(),
            polygons: polygons.clone(),
            portals: vec![0; doors],
            ..Default::default()
        };
        let big = super::super::CellStruct {
            cell_bsp: super::super::worldgen::cell_tree(&[], true),
            physics_bsp: super::super::worldgen::physics_tree(&[], &[]),
            ..big
        };
        let e = Environment {
            id: 0x0D00_0001,
            structures: vec![with_doors.structure(), big, with_doors.structure()],
        };
        let bytes = e.to_bytes().expect("written");
        let read =
            Environment::from_bytes("test.dat", e.id, &bytes, Strictness::Strict).expect("read");
        // Bytes, not values: the generator fills the pools of a tree in another order than a reader.
        assert_eq!(read.to_bytes().expect("written"), bytes);
        assert_eq!(read.structures[1].polygons, polygons);
    }
}

#[test]
fn long_strings() {
    for n in [0, 1, 2, 3, 4, 5, 0xFFFE, 0xFFFF, 0x1_0001] {
        let text = "x".repeat(n);
        let mut w = Writer::new();
        w.pstring(&text);
        let bytes = w.finish(0).expect("written");
        assert_eq!(
            bytes.len(),
            (if n < 0xFFFF { 2 + n } else { 6 + n }).next_multiple_of(4)
        );
        assert_eq!(
            Reader::new("", 0, &bytes, Strictness::Strict)
                .pstring()
                .expect("read"),
            text
        );
    }
    let mut w = Writer::new();
    w.pstring("日本");
    assert!(
        w.finish(0).is_err(),
        "characters that the format cannot hold"
    );
}

#[test]
fn motion_data_with_255_animations() {
    let many = (0..255).fold(MotionData::default(), |m, i| m.then(i, 0, -1, 30.0));
    let table = MotionTable::new(1, 2)
        .with_cycle(3, 4, many.clone())
        .with_modifier(0x6500_000D, MotionData::default());
    let bytes = table.to_bytes().expect("written");
    assert_eq!(
        MotionTable::from_bytes("test.dat", 1, &bytes, Strictness::Strict).expect("read"),
        table
    );
    let more = MotionTable::new(1, 2).with_cycle(3, 4, many.then(0, 0, 0, 0.0));
    assert!(more.to_bytes().is_err(), "one more does not fit");
}

#[test]
fn render_textures_are_laid_out_as_surface_textures() {
    let bytes = [1, 0, 0, 0x15, 0, 0, 0, 0, 2, 1, 0, 0, 0, 1, 0, 0, 6];
    let parsed = AnyRecord::parse(
        RecordKind::RenderTexture,
        "test.dat",
        0x1500_0001,
        &bytes,
        Strictness::Strict,
    );
    let (record, _) = parsed.expect("known").expect("read");
    assert_eq!(record.to_bytes().expect("written"), bytes);
}
