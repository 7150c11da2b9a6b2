//! Any bytes as captured frames, with IP fragments.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ac_recorder::fuzzing::frames(data));
