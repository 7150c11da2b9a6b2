//! x
use super::cases;
cases! { "00"; }
