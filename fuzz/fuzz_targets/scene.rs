//! Any bytes as a record of kind `scene`.
#![no_main]

use ac_client::dat::{RecordKind, fuzzing};

libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzzing::record(RecordKind::Scene, data));
