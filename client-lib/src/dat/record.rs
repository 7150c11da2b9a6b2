//! What all records have in common: a kind, reading from an exact slice, and writing.

use super::error::DatError;
use super::kind::RecordKind;
use super::reader::{Note, Read, Reader, Strictness};
use super::writer::Writer;

/// A record type: parses from and writes to the bytes stored under one id.
///
/// `parse` then `write` reproduces the bytes, but for three things that the format allows in more than one form and that are written in the
/// canonical one: compressed numbers and packed ids that are longer than needed, long-form strings that would fit the short form, and
/// alignment bytes that are not zero (lenient reading only).
pub trait Record: Sized {
    /// Which kind of record this is.
    const KIND: RecordKind;

    /// Reads the record. [`Reader::id`] is the id under which it is stored.
    ///
    /// # Errors
    /// What `spec/11-dat-files.md, 12.3` lists.
    fn parse(r: &mut Reader<'_>) -> Read<Self>;

    /// Writes the record.
    fn write(&self, w: &mut Writer);

    /// Id of the record.
    fn id(&self) -> u32;

    /// Reads from the exact bytes of a record; `file` names the file in errors.
    ///
    /// # Errors
    /// As [`Record::parse`]; when strict also bytes left over.
    fn from_bytes(
        file: &str,
        id: u32,
        bytes: &[u8],
        strictness: Strictness,
    ) -> Result<Self, DatError> {
        Self::from_bytes_noting(file, id, bytes, strictness).map(|(record, _)| record)
    }

    /// The same, answering also what a lenient reader passed over.
    ///
    /// # Errors
    /// As [`Record::from_bytes`].
    fn from_bytes_noting(
        file: &str,
        id: u32,
        bytes: &[u8],
        strictness: Strictness,
    ) -> Result<(Self, Vec<Note>), DatError> {
        let mut r = Reader::new(file, id, bytes, strictness);
        let record = Self::parse(&mut r)?;
        r.finish()?;
        Ok((record, r.into_notes()))
    }

    /// The bytes to store.
    ///
    /// # Errors
    /// A list that is too long for its count, or lists that must agree in length and do not.
    fn to_bytes(&self) -> Result<Vec<u8>, DatError> {
        let mut w = Writer::new();
        self.write(&mut w);
        w.finish(self.id())
    }
}
