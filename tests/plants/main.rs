//! The plant, its parts and the loop around it, and what is identified on them.

#[path = "../support/mod.rs"]
mod support;

mod antiwindup;
mod base;
mod batch;
mod determinism;
mod drives;
mod feedforward;
mod friction;
mod gains;
mod gravity;
mod identify;
mod ladder;
mod parity;
mod rapier_scene;
mod replay;
mod response;
mod servo;
mod servo_inputs;
mod solid;
mod start;
mod tune;
