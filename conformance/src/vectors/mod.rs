//! Vectors: calls of single primitives, compared number by number with what an oracle answered (`spec/vector-format.md`).
//!
//! A file is read line by line. For every vector the *family* of the file computes what the client library answers, in the
//! same JSON shape, and one comparer for all families puts the two beside each other: numbers bit for bit (sign of zero
//! included), ids as numbers, texts as texts. Exact or not, nothing in between.
//!
//! # Filling in a family
//! Each family is one file beside this one with one function
//!
//! ```text
//! pub fn answer(ctx: &VectorContext<'_>, vector: &Value) -> Option<Value>
//! ```
//!
//! - `vector` is the whole line; `vector["fn"]` names the function, `vector["in"]` holds the arguments. Read them with the
//!   helpers in [`json`]; each gives an `Option`, so `?` does for malformed input.
//! - Return the actual `out` object. For a history (a vector with `ops`) return the actual `ops` as an array: one object per
//!   operation with its results and the state after it. Arguments of an operation need not be repeated.
//! - Write every f32 with [`json::put`] (f64-widened); write a field that does not apply as the format says (absent or null).
//! - `None` means "not implemented" and is counted as that, never as a match.
//! - [`VectorContext::profile`] is the profile to run under, [`VectorContext::tables`] the tables of the file,
//!   [`VectorContext::previous`] the line before (the integrator's `set_velocity` goes on from it).
//!
//! Then `ac-conform vectors golden-traces/vectors/gdle/FAMILY.jsonl.gz` shows what is exact and the first mismatch per function.

mod compare;
pub mod json;
pub mod math;
mod read;
mod report;

mod bsp;
mod cylsphere;
mod frame;
mod integrator;
mod jump;
mod landdefs;
mod motion_object;
mod motioninterp;
mod motiontable;
mod mover;
mod polygon;
mod position;
mod sequence;
mod sphere;
mod tables;
mod terrain;

pub(crate) use compare::same_leaf;
pub use compare::{Mismatch, compare_vector};
pub use read::{Header, VectorError, VectorFile};
pub use report::{FnResult, human_table};

use std::path::Path;

use ac_client::profile::Profile;
use serde_json::Value;

/// What a family function knows beside the vector itself.
#[derive(Clone, Copy, Debug)]
pub struct VectorContext<'a> {
    /// The profile to answer under.
    pub profile: &'a Profile,
    /// First line of the file.
    pub header: &'a Header,
    /// The table lines between header and vectors, in order (`animations`, `motion_table`).
    pub tables: &'a [Value],
    /// The vector before this one.
    pub previous: Option<&'a Value>,
}

impl<'a> VectorContext<'a> {
    /// The oracle that wrote the file.
    pub fn oracle(&self) -> &'a str {
        &self.header.oracle
    }

    /// The table of that name: the value of key `name` in whichever table line has it.
    pub fn table(&self, name: &str) -> Option<&'a Value> {
        self.tables.iter().find_map(|line| line.get(name))
    }
}

/// A family's function: the actual `out` (or `ops`), or `None` when it is not implemented.
pub type Family = fn(&VectorContext<'_>, &Value) -> Option<Value>;

/// Every family, by the name in the header.
pub const FAMILIES: [(&str, Family); 13] = [
    ("frame", frame::answer),
    ("landdefs", landdefs::answer),
    ("position", position::answer),
    ("terrain", terrain::answer),
    ("polygon", polygon::answer),
    ("sphere", sphere::answer),
    ("cylsphere", cylsphere::answer),
    ("bsp", bsp::answer),
    ("sequence", sequence::answer),
    ("motiontable", motiontable::answer),
    ("motioninterp", motioninterp::answer),
    ("integrator", integrator::answer),
    ("jump", jump::answer),
];

/// The family of that name.
pub fn family(name: &str) -> Option<Family> {
    FAMILIES
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, family)| *family)
}

/// Runs every vector of a file and counts per function.
///
/// `profile` names a profile; `None` takes that of the oracle in the header.
///
/// # Errors
/// When the file cannot be read, is malformed, or names an unknown family or profile.
pub fn run_file(path: &Path, profile: Option<&str>) -> Result<Vec<FnResult>, VectorError> {
    let file = VectorFile::open(path)?;
    let name = profile.unwrap_or(&file.header.oracle).to_owned();
    let profile = Profile::named(&name).ok_or_else(|| VectorError::Profile {
        path: path.into(),
        name: name.clone(),
    })?;
    let answer = family(&file.header.family).ok_or_else(|| VectorError::Family {
        path: path.into(),
        name: file.header.family.clone(),
    })?;
    let mut results: Vec<FnResult> = Vec::new();
    for (index, (line, vector)) in file.vectors.iter().enumerate() {
        let ctx = VectorContext {
            profile: &profile,
            header: &file.header,
            tables: &file.tables,
            previous: index.checked_sub(1).map(|before| &file.vectors[before].1),
        };
        let function = vector.get("fn").and_then(Value::as_str).unwrap_or("");
        let result = match results
            .iter_mut()
            .find(|result| result.function == function)
        {
            Some(result) => result,
            None => {
                results.push(FnResult::new(&file.header, function, &name));
                results.last_mut().ok_or_else(|| VectorError::Line {
                    path: path.into(),
                    line: *line,
                    reason: "no function".into(),
                })?
            }
        };
        result.count(*line, vector, || answer(&ctx, vector));
    }
    Ok(results)
}
