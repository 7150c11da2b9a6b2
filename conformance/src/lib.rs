//! Conformance: compares what the client library does with what reconstructions of the retail client did.
//!
//! - [`run`]: scenes, frame by frame; [`compare`] is its core.
//! - [`report_html`]: results and plots of a run as one HTML file.
//! - [`status`]: the page that says what matches how well.
//! - [`gate`]: what a run means for a change, in shards, for CI systems.
//! - [`bisect`]: which commit changed a trace, and where in it.
//! - [`bless`]: expectations of this library's own, and taking a change into them.
//! - [`shrink`]: making a scene that diverges as small as it can be.
//! - [`hash`]: whether two runs computed the same bits.
//! - [`precision`]: what each choice of fidelity costs, and what error it makes.
//! - [`stability`]: what small changes grow to, and what stiff and extreme cases do to the rules.
//! - [`vectors`]: calls of single primitives.
//!
//! The binary `ac-conform` is a thin shell around [`cli`].
#![forbid(unsafe_code)]

pub mod bisect;
pub mod bless;
pub mod cli;
pub mod compare;
pub mod gate;
pub mod hash;
pub mod precision;
pub mod report_html;
pub mod run;
pub mod shrink;
pub mod stability;
pub mod status;
pub mod vectors;
