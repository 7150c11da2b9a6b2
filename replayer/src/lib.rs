//! Drives the client library from scenes and recordings, deterministically.

#![forbid(unsafe_code)]

pub mod dat_cmd;
