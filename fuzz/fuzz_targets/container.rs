//! Any bytes as a dat file.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ac_client::dat::fuzzing::container(data));
