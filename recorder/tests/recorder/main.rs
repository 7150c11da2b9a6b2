//! The recorder as a whole: proxies over loopback, and the program's commands.

mod cli;
mod common;
mod kill;
mod proxy;
mod secrets;
