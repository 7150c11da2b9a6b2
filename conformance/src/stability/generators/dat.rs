//! Dat files (`spec/11-dat-files.md`, 16): records written by the library, damaged, and read again.

use ac_client::{
    dat::{
        AnimFrame, AnimRange, Animation, AnimationHook, DatBuilder, DatFile, DataSet, EnvCell,
        Environment, HookAction, HookDirection, MotionBits, MotionData, MotionTable, PORTAL_FILE,
        Reader, Record, Setup, StoredFrame, Strictness, VertexArray, Writer,
        worldgen::{Rect, Room, SetupBuilder, Side, WorldBuilder, block, shape, structure},
    },
    math::{Plane, Sphere, Vec3},
};

use super::{super::trial::Trial, cases};

cases! { "11";
    1 "record sizes around the payload of a block" => record_sizes;
    2 "chains at the end of the file, and backwards" => chains;
    3 "numbers of records around the nodes of a tree" => node_counts;
    4 "ids that order differently signed and unsigned" => id_order;
    5 "chains with cycles, shared tails, bad links" => bad_chains;
    6 "nodes that are their own children, bad counts" => bad_nodes;
    7 "counts of all ones, compressed numbers" => counts;
    8 "a tree of 100 000 nodes in a chain" => deep_trees;
    9 "rooms with 1 to 3 surfaces, without rooms in sight" => rooms;
    10 "building portals with 0 to 2 stabs" => building_portals;
    11 "polygons of 3 and of 255 points" => polygon_points;
    12 "odd numbers of portals in the middle of a record" => odd_portals;
    13 "hooks with short and long ids" => hooks;
    14 "motions without animations, and with 255" => motions;
    15 "heights at the limits, tables that fall" => heights;
    16 "strings of every padding, and long ones" => strings;
    17 "surface −1 on drawn polygons" => no_surface;
    18 "denormal, −0 and huge coordinates" => coordinates;
}

fn read_file(bytes: Vec<u8>) -> Result<DatFile, ac_client::dat::DatError> {
    DatFile::from_bytes(
        PORTAL_FILE,
        bytes,
        Some(DataSet::Portal),
        Strictness::Lenient,
    )
}

/// A file of plain records by id.
fn file(records: &[(u32, usize)]) -> Vec<u8> {
    let mut builder = DatBuilder::new(DataSet::Portal);
    for (id, size) in records {
        builder.insert(*id, (0..*size).map(|i| i as u8).collect());
    }
    builder.write().unwrap_or_default()
}

/// Every word of the file changed in turn: opening and reading everything never does more than refuse.
fn damaged(t: &mut Trial, bytes: &[u8]) {
    let step = (bytes.len() / 400).max(1) & !3;
    let mut at = 0x140;
    while at + 4 <= bytes.len() {
        for word in [0_u32, 0xFFFF_FFFF, 0x8000_0001, at as u32] {
            let mut copy = bytes.to_vec();
            copy[at..at + 4].copy_from_slice(&word.to_le_bytes());
            if let Ok(file) = read_file(copy) {
                for id in file.ids().unwrap_or_default().into_iter().take(64) {
                    let _ = file.get(id);
                }
                let _ = file.check();
            }
        }
        at += step.max(4);
    }
    t.promise(true, String::new);
}

fn record_sizes(t: &mut Trial) {
    let payload = read_file(file(&[(1, 10)])).map_or(1020, |f| f.header().payload());
    for size in [
        0,
        1,
        payload - 1,
        payload,
        payload + 1,
        2 * payload,
        2 * payload + 1,
    ] {
        let found = read_file(file(&[(0x0600_0001, size)])).and_then(|f| f.get(0x0600_0001));
        let length = found.ok().flatten().map(|bytes| bytes.len());
        t.same("bytes read", length, Some(size));
    }
}

fn chains(t: &mut Trial) {
    let bytes = file(&[(1, 5000), (2, 10), (3, 9000)]);
    let Ok(opened) = read_file(bytes.clone()) else {
        return t.promise(false, || "the file is not read".into());
    };
    for (id, size) in [(1, 5000), (3, 9000)] {
        t.same(
            "record",
            opened.get(id).ok().flatten().map(|b| b.len()),
            Some(size),
        );
    }
    // Cut off in the last block.
    for cut in [1, 4, 100, 1024, 2048] {
        let short = bytes[..bytes.len() - cut].to_vec();
        if let Ok(file) = read_file(short) {
            for id in [1, 2, 3] {
                let _ = file.get(id);
            }
        }
    }
    damaged(t, &bytes);
}

fn node_counts(t: &mut Trial) {
    // The builder adds the record of iterations.
    for count in [0_u32, 60, 61, 60 + 62 * 61, 61 + 62 * 61] {
        let records: Vec<(u32, usize)> = (0..count).map(|i| (0x0600_0000 + i, 4)).collect();
        let ids = read_file(file(&records))
            .and_then(|f| f.ids())
            .unwrap_or_default();
        t.same("records", ids.len(), count as usize + 1);
        t.promise(ids.is_sorted(), || "ids are not in order".into());
    }
}

fn id_order(t: &mut Trial) {
    let ids = [0_u32, 1, 0x7FFF_FFFF, 0x8000_0000, 0xFFFF_0001, 0xFFFF_FFFF];
    let records: Vec<(u32, usize)> = ids.iter().map(|id| (*id, 8)).collect();
    let Ok(opened) = read_file(file(&records)) else {
        return t.promise(false, || "the file is not read".into());
    };
    for id in ids {
        t.same(
            "record",
            opened.get(id).ok().flatten().map(|b| b.len()),
            Some(8),
        );
        t.same(
            "a record that is not there",
            opened.get(id ^ 0x10).ok().flatten(),
            None,
        );
    }
}

fn bad_chains(t: &mut Trial) {
    let bytes = file(&[(1, 3000), (2, 3000)]);
    let Ok(opened) = read_file(bytes.clone()) else {
        return t.promise(false, || "the file is not read".into());
    };
    let Ok(Some(entry)) = opened.entry(1) else {
        return t.promise(false, || "no entry".into());
    };
    let first = entry.offset as usize;
    let other = opened.entry(2).ok().flatten().map_or(0, |e| e.offset);
    // To itself, into the other chain, into the header, with the top bit, beyond the end.
    for link in [
        entry.offset,
        other,
        0x140,
        0,
        entry.offset | 0x8000_0000,
        bytes.len() as u32,
        u32::MAX,
    ] {
        let mut copy = bytes.clone();
        copy[first..first + 4].copy_from_slice(&link.to_le_bytes());
        let read = read_file(copy).and_then(|f| f.get(1));
        t.promise(
            read.as_ref().is_err()
                || read
                    .as_ref()
                    .is_ok_and(|b| b.as_ref().is_none_or(|b| b.len() == 3000)),
            || format!("link {link:#X}: {read:?}"),
        );
    }
}

fn bad_nodes(t: &mut Trial) {
    let records: Vec<(u32, usize)> = (0..200).map(|i| (i, 4)).collect();
    damaged(t, &file(&records));
}

/// A record as bytes; every prefix and every damaged word of it is read or refused.
fn shaken<T: Record>(t: &mut Trial, record: &T, id: u32) {
    let mut writer = Writer::new();
    record.write(&mut writer);
    let Ok(bytes) = writer.finish(id) else {
        return t.promise(false, || "the record cannot be written".into());
    };
    let read = |bytes: &[u8]| {
        T::parse(&mut Reader::new(
            "generated",
            id,
            bytes,
            Strictness::Lenient,
        ))
        .is_ok()
    };
    t.promise(read(&bytes), || "the record cannot be read again".into());
    for length in 0..bytes.len().min(2000) {
        let _ = read(&bytes[..length]);
    }
    for at in (0..bytes.len().saturating_sub(4)).step_by((bytes.len() / 500).max(1)) {
        for word in [u32::MAX, 0, 0x8000_0000, 0x7FFF_FFFF] {
            let mut copy = bytes.clone();
            copy[at..at + 4].copy_from_slice(&word.to_le_bytes());
            let _ = read(&copy);
        }
    }
}

fn counts(t: &mut Trial) {
    let mut animation = Animation::new(0x0300_0001, 2);
    for _ in 0..4 {
        animation.push(
            AnimFrame {
                parts: vec![StoredFrame::IDENTITY; 2],
                hooks: Vec::new(),
            },
            None,
        );
    }
    shaken(t, &animation, 0x0300_0001);
    let mut setup = Setup::empty(0x0200_0001);
    setup.parts = vec![0x0100_0001; 3];
    shaken(t, &setup, 0x0200_0001);
    for bytes in [
        vec![0x80, 0x00],
        vec![0xC0, 0, 0, 0],
        vec![0x7F],
        vec![0xFF; 4],
        vec![0x80],
    ] {
        let _ = Reader::new("generated", 1, &bytes, Strictness::Lenient).compressed_u32();
    }
    for number in [0_u32, 0x7F, 0x80, 0x3FFF, 0x4000, 0x3FFF_FFFF] {
        let mut writer = Writer::new();
        writer.compressed_u32(number);
        let bytes = writer.finish(1).unwrap_or_default();
        let read = Reader::new("generated", 1, &bytes, Strictness::Strict).compressed_u32();
        t.same("compressed number", read.ok(), Some(number));
    }
}

fn deep_trees(t: &mut Trial) {
    // A room bounded by so many planes: its tree is a chain of as many nodes.
    for depth in [20_usize, 100_000] {
        let planes = vec![Plane { n: Vec3::X, d: 5.0 }; depth];
        let room = structure(
            &block(Vec3::splat(-1.0), Vec3::splat(1.0)),
            &[],
            &[],
            &planes,
            false,
        );
        let mut world = WorldBuilder::new();
        world.add(&Environment {
            id: 0x0D00_0009,
            structures: vec![room],
        });
        world.block(0x20, 0x20);
        let read = world
            .surround()
            .build()
            .and_then(|set| set.environment(0x0D00_0009));
        t.promise(read.is_ok() == (depth == 20), || {
            format!("a tree of {depth} nodes is read: {}", read.is_ok())
        });
    }
}

fn door() -> Rect {
    Rect {
        u: [-1.0, 1.0],
        v: [0.0, 2.0],
    }
}

fn rooms(t: &mut Trial) {
    for surfaces in 1..=3_usize {
        let mut world = WorldBuilder::new();
        let environment = world.environment(&[
            Room::new(Vec3::splat(-3.0), Vec3::splat(3.0)).doorway(Side::North, door())
        ]);
        let home = world.block(0x20, 0x20);
        let room = home.room(environment, 0, StoredFrame::IDENTITY, 1);
        if let Some(cell) = home.room_mut(room) {
            cell.surfaces = vec![1; surfaces];
            cell.visible_rooms.clear();
        }
        home.restrict(room, 0x7777_7777);
        let read = world
            .surround()
            .build()
            .and_then(|set| set.env_cell(0x2020_0100));
        match read {
            Ok(Some(cell)) => {
                t.same("surfaces", cell.surfaces.len(), surfaces);
                shaken::<EnvCell>(t, &cell, 0x2020_0100);
            }
            other => t.promise(false, || format!("{other:?}")),
        }
    }
}

fn building_portals(t: &mut Trial) {
    for stabs in 0..=2_usize {
        let mut world = WorldBuilder::new();
        let shell = world.solid(&block(Vec3::splat(-4.0), Vec3::splat(4.0)));
        let environment = world.environment(&[
            Room::new(Vec3::splat(-3.0), Vec3::splat(3.0)).doorway(Side::South, door())
        ]);
        let home = world.block(0x20, 0x20);
        let rooms: Vec<_> = (0..3)
            .map(|_| home.room(environment, 0, StoredFrame::IDENTITY, 1))
            .collect();
        home.building(
            shell,
            StoredFrame::IDENTITY,
            &[(rooms[0], 0, &rooms[..stabs]), (rooms[1], 0, &rooms[..1])],
        );
        let read = world
            .surround()
            .build()
            .and_then(|set| set.landblock_info_of(0x2020_0001));
        match read {
            Ok(Some(info)) => {
                let seen = info
                    .buildings
                    .first()
                    .and_then(|b| b.portals.first())
                    .map(|p| p.visible_rooms.len());
                t.same("stabs", seen, Some(stabs));
                shaken(t, &*info, 0x2020_FFFE);
            }
            other => t.promise(false, || format!("{other:?}")),
        }
    }
}

fn polygon_points(t: &mut Trial) {
    for points in [3_usize, 4, 255] {
        let ring: Vec<Vec3> = (0..points)
            .map(|i| {
                let (s, c) = (std::f32::consts::TAU * i as f32 / points as f32).sin_cos();
                Vec3::new(c, s, 0.0)
            })
            .collect();
        let record = shape(
            0x0100_0001,
            &[],
            &[ac_client::dat::worldgen::Face::new(ring)],
        );
        shaken(t, &record, 0x0100_0001);
    }
}

fn odd_portals(t: &mut Trial) {
    let room = |doors: usize| {
        let sides = [Side::North, Side::South, Side::East];
        (0..doors).fold(Room::new(Vec3::splat(-3.0), Vec3::splat(3.0)), |room, i| {
            room.doorway(sides[i], door())
        })
    };
    for (first, second) in [(1, 2), (2, 1), (3, 1), (1, 3)] {
        let mut world = WorldBuilder::new();
        let id = world.environment(&[room(first), room(second)]);
        world.block(0x20, 0x20);
        match world.surround().build().and_then(|set| set.environment(id)) {
            Ok(Some(environment)) => {
                let portals: Vec<usize> = environment
                    .structures
                    .iter()
                    .map(|s| s.portals.len())
                    .collect();
                t.same("portals", portals, vec![first, second]);
                shaken(t, &*environment, id);
            }
            other => t.promise(false, || format!("{other:?}")),
        }
    }
}

fn hooks(t: &mut Trial) {
    for wave in [0x0A00_0001_u32, 0x0A00_7FFF, 0x0A01_0000, 0] {
        let hook = |action| AnimationHook {
            direction: HookDirection(1),
            action,
        };
        let mut animation = Animation::new(0x0300_0001, 1);
        let hooks = vec![
            hook(HookAction::Sound { wave }),
            hook(HookAction::Sound { wave }),
        ];
        animation.push(
            AnimFrame {
                parts: vec![StoredFrame::IDENTITY],
                hooks,
            },
            None,
        );
        animation.push(
            AnimFrame {
                parts: vec![StoredFrame::IDENTITY],
                hooks: vec![hook(HookAction::Sound { wave })],
            },
            None,
        );
        shaken(t, &animation, 0x0300_0001);
    }
}

fn motions(t: &mut Trial) {
    let many = MotionData {
        anims: vec![
            AnimRange {
                animation: 0x0300_0001,
                low_frame: 0,
                high_frame: -1,
                framerate: 30.0
            };
            255
        ],
        bits: MotionBits::from_bits_retain(1),
        ..MotionData::default()
    };
    let none = MotionData::default()
        .with_velocity(Vec3::X)
        .with_omega(Vec3::Z);
    let table = MotionTable::new(0x0900_0001, 0x8000_003D)
        .with_style(0x8000_003D, 0x4100_0003)
        .with_cycle(0x8000_003D, 0x4100_0003, many)
        .with_cycle(0x8000_003D, 0x4500_0005, none);
    shaken(t, &table, 0x0900_0001);
}

fn heights(t: &mut Trial) {
    for table in [[0.0_f32, 800.0], [800.0, 0.0], [0.0, -0.0]] {
        let mut world = WorldBuilder::new();
        world.region.height_table = std::array::from_fn(|i| table[i % 2]);
        world.block(0x20, 0x20).heights(|x, y| (x + y) as u8);
        match world.surround().build() {
            Ok(set) => t.same(
                "first two heights",
                set.region().height_table[..2].to_vec(),
                table.to_vec(),
            ),
            Err(error) => t.promise(false, || error.to_string()),
        }
    }
}

fn strings(t: &mut Trial) {
    for length in (0..=5_usize).chain([0xFFFE, 0xFFFF, 70_000]) {
        let text = "x".repeat(length);
        let mut writer = Writer::new();
        writer.pstring(&text);
        writer.u32(0x1234_5678);
        let bytes = writer.finish(1).unwrap_or_default();
        let mut reader = Reader::new("generated", 1, &bytes, Strictness::Lenient);
        let read = reader.pstring().ok().map(|s| s.len());
        let after = reader.u32().ok();
        t.same(
            "string and what follows",
            (read, after),
            (Some(length), Some(0x1234_5678)),
        );
    }
}

fn no_surface(t: &mut Trial) {
    let mut faces = block(Vec3::splat(-1.0), Vec3::splat(1.0));
    faces[0].surface = -1;
    let record = shape(0x0100_0001, &faces, &faces);
    t.promise(record.drawing.is_some() || record.physics.is_some(), || {
        "nothing is left".into()
    });
    shaken(t, &record, 0x0100_0001);
}

fn coordinates(t: &mut Trial) {
    for number in [f32::MIN_POSITIVE / 4.0, -0.0, 1e38, f32::MAX, f32::MIN] {
        let setup = SetupBuilder::new()
            .sphere(Vec3::splat(number), 1.0)
            .with(|setup| {
                setup.id = 0x0200_0001;
                setup.sorting_sphere = Sphere {
                    center: Vec3::splat(number),
                    radius: 1.0,
                };
            });
        let mut world = WorldBuilder::new();
        let id = world.setup(setup);
        world.block(0x20, 0x20);
        let read = world.surround().build().and_then(|set| set.setup(id));
        let found = read
            .ok()
            .flatten()
            .and_then(|s| s.spheres.first().map(|s| s.center.x.to_bits()));
        t.same("bits of a coordinate", found, Some(number.to_bits()));
        let mut vertices = VertexArray::default();
        vertices.push(Vec3::splat(number), Vec3::Z, &[[0.0, 0.0]]);
        t.same("vertices", vertices.len(), 1);
    }
}
