//! The drive: amplifier and motor, from control effort to force.

pub mod printed;
