//! Damaged records, one row per check of `spec/11-dat-files.md, 12.3`.

use super::super::{
    Animation, AnimationHook, AnyRecord, BspTag, DatError, DataSet, EnvCell, Environment, GfxObj,
    Iteration, Landblock, LandblockInfo, MotionTable, Palette, PhysicsScript, Problem, Read,
    Reader, Record, RecordKind, Region, Setup, Strictness, Writer,
};
use super::files;

fn read<T: Record>(id: u32, bytes: &[u8], strictness: Strictness) -> Result<T, DatError> {
    T::from_bytes("test.dat", id, bytes, strictness)
}

fn record(id: u32) -> Vec<u8> {
    let [portal, cell] = files("testbed");
    portal
        .get(id)
        .expect("read")
        .or_else(|| cell.get(id).expect("read"))
        .expect("a record of the testbed")
}

fn put(bytes: &mut [u8], at: usize, v: u32) {
    bytes[at..at + 4].copy_from_slice(&v.to_le_bytes());
}

fn bytes(f: impl FnOnce(&mut Writer)) -> Vec<u8> {
    let mut w = Writer::new();
    f(&mut w);
    w.finish(0).expect("written")
}

#[test]
fn an_error_names_file_record_offset_and_what() {
    let error =
        read::<Palette>(0x0400_0001, &[1, 0, 0, 4, 2, 0, 0], Strictness::Lenient).expect_err("cut");
    assert_eq!(
        error.to_string(),
        "test.dat: record 0x04000001, offset 0x4: record ends early: 4 bytes wanted, 3 left"
    );
    assert_eq!(
        (error.file(), error.record(), error.offset()),
        ("test.dat", Some(0x0400_0001), 4)
    );
}

#[test]
fn every_cut_of_every_kind_is_an_error() {
    // One of each kind; a record that is cut anywhere ends early or leaves a count that does not fit.
    for file in files("testbed") {
        let mut seen = Vec::new();
        for id in file.ids().expect("directory") {
            let kind = RecordKind::of(file.data_set(), id);
            if seen.contains(&kind) {
                continue;
            }
            seen.push(kind);
            let bytes = file.get(id).expect("read").expect("listed");
            let step = bytes.len() / 200 + 1;
            for n in (0..bytes.len()).step_by(step).chain([bytes.len() - 1]) {
                let cut = AnyRecord::parse(kind, "test.dat", id, &bytes[..n], Strictness::Lenient)
                    .expect("a known kind");
                assert!(cut.is_err(), "{kind} cut to {n} of {}", bytes.len());
            }
        }
    }
}

#[test]
fn bytes_left_over_and_wrong_ids() {
    let mut palette = bytes(|w| {
        w.u32(0x0400_0002);
        w.i32(1);
        w.u32(0xFFFF_FFFF);
    });
    palette.push(0);
    let at = |s| Palette::from_bytes_noting("test.dat", 0x0400_0001, &palette, s);
    assert!(matches!(
        at(Strictness::Strict).expect_err("strict").problem(),
        Problem::OwnId { found: 0x0400_0002 }
    ));
    let (record, notes) = at(Strictness::Lenient).expect("lenient");
    assert_eq!(record.id, 0x0400_0002);
    assert_eq!(notes.len(), 2, "{notes:?}");
    assert!(matches!(notes[1].problem, Problem::LeftOver { bytes: 1 }));
}

#[test]
fn counts_out_of_proportion() {
    type Case = (u32, usize, fn(u32, &[u8]) -> Option<DatError>);
    fn error<T: Record>(id: u32, bytes: &[u8]) -> Option<DatError> {
        read::<T>(id, bytes, Strictness::Lenient).err()
    }
    // Record, offset of a count.
    let cases: [Case; 8] = [
        (0x0200_0001, 8, error::<Setup>),
        (0x0300_0001, 12, error::<Animation>),
        (0x0900_0001, 8, error::<MotionTable>),
        (0x0D00_0001, 4, error::<Environment>),
        (0x0D00_0001, 12, error::<Environment>),
        (0xA9B4_FFFE, 8, error::<LandblockInfo>),
        (0x0400_0001, 4, error::<Palette>),
        (0x0100_0007, 0x11, error::<GfxObj>),
    ];
    for (id, at, parse) in cases {
        for count in [0x7FFF_FFFF, 0x8000_0000, 0xFFFF_FFFF] {
            let mut bytes = record(id);
            put(&mut bytes, at, count);
            let error = parse(id, &bytes).unwrap_or_else(|| panic!("{id:08X} at {at}"));
            assert!(
                matches!(
                    error.problem(),
                    Problem::Count { .. }
                        | Problem::NegativeCount { .. }
                        | Problem::TooLarge { .. }
                ),
                "{id:08X} at {at}: {error}"
            );
        }
    }
}

#[test]
fn unknown_tags_and_kinds() {
    let shape = record(0x0100_0007);
    let mut bytes_ = shape.clone();
    put(&mut bytes_, 0x0D, 2);
    let error = read::<GfxObj>(0x0100_0007, &bytes_, Strictness::Lenient).expect_err("vertex type");
    assert!(
        matches!(
            error.problem(),
            Problem::Unknown {
                what: "vertex type",
                found: 2
            }
        ),
        "{error}"
    );
    for tag in [0, 0x4250_4F4D, u32::from_be_bytes(*b"BPXX")] {
        let mut bytes_ = shape.clone();
        put(&mut bytes_, 0xCA, tag);
        let error = read::<GfxObj>(0x0100_0007, &bytes_, Strictness::Lenient).expect_err("tag");
        assert!(
            matches!(
                error.problem(),
                Problem::Unknown {
                    what: "tree node tag",
                    ..
                }
            ),
            "{error}"
        );
        assert_eq!(error.offset(), 0xCA);
    }
    for kind in [27, 0xFFFF_FFFF] {
        let script = bytes(|w| {
            w.u32(0x3300_0001);
            w.u32(1);
            w.f64(0.0);
            w.u32(kind);
            w.i32(0);
        });
        let error =
            read::<PhysicsScript>(0x3300_0001, &script, Strictness::Lenient).expect_err("hook");
        assert!(
            matches!(
                error.problem(),
                Problem::Unknown {
                    what: "hook type",
                    ..
                }
            ),
            "{error}"
        );
    }
}

#[test]
fn indices_and_keys() {
    let shape = record(0x0100_0007);
    type Case = (&'static str, usize, &'static [u8], fn(&Problem) -> bool);
    let cases: [Case; 9] = [
        ("vertex key", 0x15, &[1, 0], |p| {
            matches!(
                p,
                Problem::KeyOrder {
                    what: "vertex",
                    expected: 0,
                    found: 1
                }
            )
        }),
        ("polygon key", 0xB2, &[1, 0], |p| {
            matches!(
                p,
                Problem::KeyOrder {
                    what: "polygon",
                    ..
                }
            )
        }),
        ("two points", 0xB4, &[2], |p| {
            matches!(
                p,
                Problem::Value {
                    what: "number of points",
                    found: 2,
                    ..
                }
            )
        }),
        ("surface", 0xBA, &[1, 0], |p| {
            matches!(
                p,
                Problem::Index {
                    what: "surface",
                    found: 1,
                    limit: 1
                }
            )
        }),
        ("surface -2", 0xBA, &[0xFE, 0xFF], |p| {
            matches!(
                p,
                Problem::Index {
                    what: "surface",
                    found: -2,
                    ..
                }
            )
        }),
        ("vertex", 0xBE, &[4, 0], |p| {
            matches!(
                p,
                Problem::Index {
                    what: "vertex",
                    found: 4,
                    limit: 4
                }
            )
        }),
        ("vertex -1", 0xBE, &[0xFF, 0xFF], |p| {
            matches!(
                p,
                Problem::Index {
                    what: "vertex",
                    found: 65535,
                    ..
                }
            )
        }),
        ("uv", 0xC6, &[1], |p| {
            matches!(
                p,
                Problem::Index {
                    what: "texture coordinate",
                    ..
                }
            )
        }),
        ("polygon of the tree", 0xF2, &[1, 0], |p| {
            matches!(
                p,
                Problem::Index {
                    what: "polygon of a tree node",
                    ..
                }
            )
        }),
    ];
    for (name, at, patch, expected) in cases {
        let mut bytes = shape.clone();
        bytes[at..at + patch.len()].copy_from_slice(patch);
        let error = read::<GfxObj>(0x0100_0007, &bytes, Strictness::Lenient).expect_err(name);
        assert!(expected(error.problem()), "{name}: {error}");
    }
    // No surface is allowed.
    let mut bytes = shape;
    bytes[0xBA..0xBC].copy_from_slice(&[0xFF, 0xFF]);
    assert!(read::<GfxObj>(0x0100_0007, &bytes, Strictness::Strict).is_ok());
}

#[test]
fn numbers_that_are_not_finite_or_not_unit() {
    let room = record(0xA9B4_0105);
    for (at, value) in [
        (0x18, f32::NAN),
        (0x1C, f32::INFINITY),
        (0x24, 0.9),
        (0x28, f32::NAN),
    ] {
        let mut bytes = room.clone();
        put(&mut bytes, at, value.to_bits());
        let strict = read::<EnvCell>(0xA9B4_0105, &bytes, Strictness::Strict).expect_err("strict");
        assert!(
            matches!(
                strict.problem(),
                Problem::NotFinite { .. } | Problem::NotUnit { .. }
            ),
            "{strict}"
        );
        let (lenient, notes) =
            EnvCell::from_bytes_noting("test.dat", 0xA9B4_0105, &bytes, Strictness::Lenient)
                .expect("kept");
        assert_eq!(notes.len(), 1);
        assert_eq!(
            lenient.to_bytes().expect("written"),
            bytes,
            "kept bit for bit"
        );
    }
    for value in [1e38, -0.0, f32::from_bits(1)] {
        let mut bytes = room.clone();
        put(&mut bytes, 0x18, value.to_bits());
        let read = read::<EnvCell>(0xA9B4_0105, &bytes, Strictness::Strict).expect("allowed");
        assert_eq!(read.frame.origin.x.to_bits(), value.to_bits());
    }
}

#[test]
fn double_keys() {
    let table = bytes(|w| {
        w.u32(0x0900_0001);
        w.u32(0x8000_003D);
        w.u32(2);
        for substate in [1, 2] {
            w.u32(0x8000_003D);
            w.u32(substate);
        }
        for _ in 0..3 {
            w.u32(0);
        }
    });
    let strict = read::<MotionTable>(0x0900_0001, &table, Strictness::Strict).expect_err("strict");
    assert!(
        matches!(
            strict.problem(),
            Problem::DuplicateKey {
                key: 0x8000_003D,
                ..
            }
        ),
        "{strict}"
    );
    let lenient = read::<MotionTable>(0x0900_0001, &table, Strictness::Lenient).expect("lenient");
    assert_eq!(
        lenient.style_defaults.get(0x8000_003D),
        Some(&1),
        "the first counts"
    );
    assert_eq!(lenient.to_bytes().expect("written"), table);
}

#[test]
fn padding() {
    let mut block = record(0xA9B4_FFFF);
    assert_eq!(block.len(), Landblock::SIZE);
    block[251] = 1;
    let strict = read::<Landblock>(0xA9B4_FFFF, &block, Strictness::Strict).expect_err("strict");
    assert!(matches!(strict.problem(), Problem::Padding), "{strict}");
    assert_eq!(strict.offset(), 251);
    assert!(read::<Landblock>(0xA9B4_FFFF, &block, Strictness::Lenient).is_ok());
}

#[test]
fn iterations_that_would_never_end() {
    for run in [0, 1, i32::MAX] {
        let endless = bytes(|w| [2, run, 1].into_iter().for_each(|v| w.i32(v)));
        let error =
            read::<Iteration>(0xFFFF_0001, &endless, Strictness::Lenient).expect_err("endless");
        assert!(matches!(error.problem(), Problem::Value { .. }), "{error}");
    }
    let most = bytes(|w| [i32::MAX, i32::MIN, 1].into_iter().for_each(|v| w.i32(v)));
    assert!(read::<Iteration>(0xFFFF_0001, &most, Strictness::Strict).is_ok());
    let none = bytes(|w| w.i32(-5));
    assert!(
        read::<Iteration>(0xFFFF_0001, &none, Strictness::Strict)
            .expect("nothing")
            .is_complete()
    );
}

/// A shape whose drawing tree is a chain of `depth` inner nodes.
fn deep_shape(depth: usize) -> Vec<u8> {
    bytes(|w| {
        w.u32(0x0100_0001);
        w.u32(2);
        w.compressed_u32(0);
        w.i32(1);
        w.u32(0);
        [0.0; 3].into_iter().for_each(|v| w.f32(v));
        w.compressed_u32(0);
        for i in 0..depth {
            let tag = if i + 1 < depth {
                BspTag::BPnn
            } else {
                BspTag::Bpnn
            };
            w.u32(tag.value());
            [0.0, 0.0, 1.0, 0.0].into_iter().for_each(|v| w.f32(v));
        }
        for _ in 0..depth {
            [0.0; 4].into_iter().for_each(|v| w.f32(v));
            w.u32(0);
        }
    })
}

#[test]
fn deep_trees() {
    let bytes_ = deep_shape(512);
    let shape =
        read::<GfxObj>(0x0100_0001, &bytes_, Strictness::Strict).expect("the deepest that is read");
    assert_eq!(shape.to_bytes().expect("written"), bytes_);
    for depth in [513, 100_000] {
        let error = read::<GfxObj>(0x0100_0001, &deep_shape(depth), Strictness::Lenient)
            .expect_err("too deep");
        assert!(
            matches!(error.problem(), Problem::TreeDepth { limit: 512 }),
            "{error}"
        );
    }
}

#[test]
fn land_surface_and_region_version() {
    let region = record(0x1300_0000);
    let mut wrong = region.clone();
    put(&mut wrong, 8, 2);
    assert!(read::<Region>(0x1300_0000, &wrong, Strictness::Strict).is_err());
    assert!(read::<Region>(0x1300_0000, &wrong, Strictness::Lenient).is_ok());
    let parsed = read::<Region>(0x1300_0000, &region, Strictness::Strict).expect("a region");
    // The kind of the land surface follows the terrain types: find it from the end of what was read before it.
    let kind_at = {
        let mut w = Writer::new();
        let mut no_surface = parsed.clone();
        no_surface.misc = None;
        no_surface.parts.remove(super::super::RegionParts::MISC);
        no_surface.write(&mut w);
        let super::super::LandSurface::TextureMerge(m) = &parsed.land_surface else {
            panic!("texture merge")
        };
        w.len()
            - (4 + 4
                + 4
                + 8 * (m.corner_maps.len() + m.side_maps.len() + m.road_maps.len())
                + 8
                + 4
                + 44 * m.terrain.len())
    };
    let mut wrong = region;
    put(&mut wrong, kind_at, 2);
    let error = read::<Region>(0x1300_0000, &wrong, Strictness::Lenient).expect_err("kind 2");
    assert!(
        matches!(
            error.problem(),
            Problem::Unknown {
                what: "land surface kind",
                found: 2
            }
        ),
        "{error}"
    );
}

#[test]
fn replace_object_hooks_are_not_aligned() {
    for (shape, size) in [(0x0100_0002, 12), (0x0101_0003, 14)] {
        let bytes = bytes(|w| {
            w.u32(5);
            w.i32(1);
            w.u16(3);
            w.packed_did(shape, 0x0100_0000);
        });
        assert_eq!(bytes.len(), size);
        let mut r = Reader::new("test.dat", 0, &bytes, Strictness::Strict);
        let hook: Read<AnimationHook> = AnimationHook::parse(&mut r);
        assert_eq!(
            hook.expect("read").action,
            super::super::HookAction::ReplaceObject { part: 3, shape }
        );
        assert_eq!(r.left(), 0);
    }
}

#[test]
fn kinds_of_ids() {
    for (set, id, kind) in [
        (DataSet::Cell, 0xFFFF_0001, RecordKind::Iteration),
        (DataSet::Cell, 0xA9B4_0100, RecordKind::EnvCell),
        (DataSet::Cell, 0xA9B4_FFFD, RecordKind::EnvCell),
        (DataSet::Cell, 0xA9B4_FFFE, RecordKind::LandblockInfo),
        (DataSet::Cell, 0xA9B4_FFFF, RecordKind::Landblock),
        (DataSet::Cell, 0xA9B4_00FF, RecordKind::Other),
        (DataSet::Portal, 0x0100_FFFF, RecordKind::GfxObj),
        (DataSet::Portal, 0x0101_0000, RecordKind::Other),
        (DataSet::Portal, 0x0512_3456, RecordKind::SurfaceTexture),
        (DataSet::Portal, 0x0712_3456, RecordKind::RenderSurface),
        (DataSet::Portal, 0x0E00_000E, RecordKind::Other),
        (DataSet::Portal, 0xFFFF_0001, RecordKind::Iteration),
    ] {
        assert_eq!(RecordKind::of(set, id), kind, "{id:08X}");
    }
    for &kind in RecordKind::ALL {
        assert_eq!(RecordKind::from_name(kind.name()), Some(kind));
    }
}
