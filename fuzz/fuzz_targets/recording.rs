//! Any bytes as a recording.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ac_recorder::fuzzing::recording(data));
