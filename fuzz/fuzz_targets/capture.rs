//! Any bytes as a capture file (pcap, pcapng).
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ac_recorder::fuzzing::capture(data));
