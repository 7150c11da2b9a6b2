//! The self-check: a written file is read again and searched for the secrets that were seen.
//!
//! The bytes of the file are searched as they are, and every record as it reads after decompression: datagrams, index, metadata,
//! attachments, names.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::error::RecordError;
use crate::secrets::Searcher;

/// Bytes that are read at once.
const READ: usize = 1 << 18;

/// Where secrets were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ScanReport {
    /// Places in the bytes of the file.
    pub in_file: usize,
    /// Places in its records.
    pub in_records: usize,
    /// Records searched.
    pub records: usize,
}

impl ScanReport {
    /// Whether nothing was found.
    pub const fn is_clean(&self) -> bool {
        self.in_file == 0 && self.in_records == 0
    }
}

/// Searches a file. What cannot be decompressed is searched as bytes only.
///
/// # Errors
/// The file cannot be read.
pub fn scan(path: &Path, searcher: &Searcher) -> Result<ScanReport, RecordError> {
    let failed = |source| RecordError::File {
        path: path.into(),
        source,
    };
    let mut report = ScanReport::default();
    if searcher.is_empty() {
        return Ok(report);
    }
    report.in_file = scan_bytes(File::open(path).map_err(failed)?, searcher).map_err(failed)?;
    scan_records(File::open(path).map_err(failed)?, searcher, &mut report).map_err(failed)?;
    Ok(report)
}

/// Places in a stream of bytes.
fn scan_bytes(mut source: impl Read, searcher: &Searcher) -> std::io::Result<usize> {
    let overlap = searcher.longest().saturating_sub(1);
    let (mut window, mut found) = (Vec::with_capacity(READ + overlap), 0);
    loop {
        let kept = window.len();
        let n = source.by_ref().take(READ as u64).read_to_end(&mut window)?;
        if n == 0 {
            return Ok(found);
        }
        found += searcher.count_long(&window);
        // What lies wholly in the part that stays was counted now and will be counted again; a place more than there is does no harm.
        debug_assert!(kept <= overlap);
        window.drain(..window.len().saturating_sub(overlap));
    }
}

/// Places in the records of an MCAP file, up to the first damage.
fn scan_records(
    mut source: impl Read,
    searcher: &Searcher,
    report: &mut ScanReport,
) -> std::io::Result<()> {
    let options = LinearReaderOptions::default().with_record_length_limit(64 << 20);
    let mut mcap = LinearReader::new_with_options(options);
    loop {
        let wanted = match mcap.next_event() {
            Some(Ok(LinearReadEvent::ReadRequest(n))) => n,
            Some(Ok(LinearReadEvent::Record { data, .. })) => {
                report.records += 1;
                report.in_records += searcher.count(data);
                continue;
            }
            Some(Err(_)) | None => return Ok(()),
        };
        let n = source.read(mcap.insert(wanted.clamp(READ, 4 * READ)))?;
        mcap.notify_read(n);
    }
}
