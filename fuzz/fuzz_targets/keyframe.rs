//! Any bytes as a keyframe of a trace, and as the state in one.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ac_replayer::keyframes::fuzzing::keyframe(data));
