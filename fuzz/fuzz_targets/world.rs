//! Any bytes as the recipe of a small world and of what happens in it.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ac_client::physics::fuzzing::world(data));
