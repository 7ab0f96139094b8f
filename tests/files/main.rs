//! Recordings, machines and logs as they come, broken ones among them, and what is written.

#[path = "../support/mod.rs"]
mod support;

mod bare_logs;
mod broken;
mod broken_inputs;
mod formats;
mod fuzz;
mod killed;
mod recording;
mod write_machine;
