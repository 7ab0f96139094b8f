//! The machine simulated by MuJoCo, or what is said where that is not built in.

#[path = "../support/mod.rs"]
mod support;

mod crosscheck;
mod mujoco;
mod without_mujoco;
