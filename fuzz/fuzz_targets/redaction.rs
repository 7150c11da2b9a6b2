//! Any bytes as datagrams: no known secret is let through.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ac_recorder::fuzzing::guard(data));
