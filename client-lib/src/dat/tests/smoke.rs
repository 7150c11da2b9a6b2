//! A deterministic smoke of the fuzz targets: real records and files, damaged by a small generator.

use super::super::{DataSet, RecordKind, fuzzing};
use super::{files, world};

struct Damage(u64);

impl Damage {
    fn next(&mut self, below: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 16) as usize % below.max(1)
    }

    fn apply(&mut self, bytes: &mut Vec<u8>) {
        for _ in 0..=self.next(3) {
            let n = bytes.len();
            let at = self.next(n);
            match self.next(8) {
                0 => bytes.truncate(at),
                1 => bytes.extend_from_within(..at.min(64)),
                2 if n >= 4 => {
                    let extreme = [
                        0u32,
                        1,
                        0x7F,
                        0x7FFF_FFFF,
                        0x8000_0000,
                        0xFFFF_FFFF,
                        0x7FC0_0000,
                        0xCDCD_CDCD,
                    ];
                    let value = extreme[self.next(extreme.len())];
                    let at = at.min(n - 4);
                    bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
                }
                3 if n > 0 => bytes[at] = self.next(256) as u8,
                _ if n > 0 => bytes[at] ^= 1 << self.next(8),
                _ => {}
            }
        }
    }
}

#[test]
fn damaged_records() {
    let mut damage = Damage(0x9E37_79B9_7F4A_7C15);
    let mut runs = 0;
    for file in files("testbed") {
        for id in file.ids().expect("directory") {
            let kind = RecordKind::of(file.data_set(), id);
            let bytes = file.get(id).expect("read").expect("listed");
            fuzzing::record(kind, &bytes);
            let rounds = if bytes.len() > 8192 { 3 } else { 24 };
            for _ in 0..rounds {
                let mut bytes = bytes.clone();
                damage.apply(&mut bytes);
                fuzzing::record(kind, &bytes);
                runs += 1;
            }
        }
    }
    assert!(runs > 4000, "{runs}");
}

#[test]
fn records_of_the_wrong_kind() {
    let [portal, cell] = files("testbed2");
    for (file, id) in [
        (&portal, 0x0100_0001),
        (&portal, 0x0900_0001),
        (&portal, 0x0D00_0001),
        (&cell, 0x0000_FFFF),
    ] {
        let Some(bytes) = file.get(id).expect("read") else {
            continue;
        };
        for &kind in RecordKind::ALL {
            fuzzing::record(kind, &bytes);
        }
    }
}

#[test]
fn damaged_files() {
    let mut damage = Damage(42);
    for (file, _) in [
        ("client_cell_1.dat", DataSet::Cell),
        ("client_portal.dat", DataSet::Portal),
    ] {
        let bytes = std::fs::read(world("testbed2").join(file)).expect("a file of this repository");
        fuzzing::container(&bytes);
        for round in 0..60 {
            let mut bytes = bytes.clone();
            if round % 2 == 0 {
                // Near the start, where the header is.
                let at = 0x140 + damage.next(0x50);
                bytes[at] ^= 1 << damage.next(8);
            }
            for _ in 0..8 {
                let at = damage.next(bytes.len());
                bytes[at] ^= 1 << damage.next(8);
            }
            fuzzing::container(&bytes);
        }
    }
}

#[test]
fn any_bit_of_a_small_file() {
    use super::super::{DatBuilder, Iteration, Record};
    let mut builder = DatBuilder::new(DataSet::Cell).block_size(64).free_blocks(2);
    for id in 0..5 {
        builder.insert(0x0100_FFFF + (id << 16), vec![id as u8; 50 * id as usize]);
    }
    builder.insert(
        0xFFFF_0001,
        Iteration::complete(1).to_bytes().expect("written"),
    );
    let bytes = builder.write().expect("written");
    let header_and_links =
        (0x140..0x190).chain((0x1C0..bytes.len()).step_by(64).flat_map(|b| b..b + 4));
    for at in header_and_links.chain((0x1C0..bytes.len()).step_by(7)) {
        for bit in 0..8 {
            let mut bytes = bytes.clone();
            bytes[at] ^= 1 << bit;
            fuzzing::container(&bytes);
        }
    }
}
