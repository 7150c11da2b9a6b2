//! Conformance: compares what the client library does with what reconstructions of the retail client did.
//!
//! - [`run`]: scenes, frame by frame; [`compare`] is its core.
//! - [`report_html`]: results and plots of a run as one HTML file.
//! - [`status`]: the page that says what matches how well.
//! - [`gate`]: what a run means for a change, in shards, for CI systems.
//! - [`hash`]: whether two runs computed the same bits.
//! - [`precision`]: what each choice of fidelity costs, and what error it makes.
//! - [`stability`]: what small changes grow to, and what stiff and extreme cases do to the rules.
//! - [`vectors`]: calls of single primitives.
//!
//! The binary `ac-conform` is a thin shell around [`cli`].
#![forbid(unsafe_code)]

pub mod cli;
pub mod compare;
pub mod gate;
pub mod hash;
pub mod precision;
pub mod report_html;
pub mod run;
pub mod stability;
pub mod status;
pub mod vectors;
