//! Any bytes as datagrams and as damage to a connection.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| ac_client::net::transport::fuzzing::transport(data));
