//! Tests of the dat layer as a whole.

mod container;
mod geometry;
mod malformed;
mod records;
mod smoke;
mod worked;
mod worlds;

use std::path::PathBuf;

use super::{DatFile, DataSet, Strictness};

/// Folder of a world of the repository.
pub(super) fn world(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../golden-traces/worlds")
        .join(name)
}

/// Both files of a world, strictly opened.
pub(super) fn files(name: &str) -> [DatFile; 2] {
    [
        (super::PORTAL_FILE, DataSet::Portal),
        (super::CELL_FILE, DataSet::Cell),
    ]
    .map(|(file, set)| {
        DatFile::open(world(name).join(file), Some(set), Strictness::Strict)
            .expect("a world of this repository")
    })
}
