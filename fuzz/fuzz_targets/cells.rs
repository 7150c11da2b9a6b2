//! Any bytes as the recipe of a few small rooms, whole and damaged, and of what happens in and around them.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ac_client::world::fuzzing::cells(data));
