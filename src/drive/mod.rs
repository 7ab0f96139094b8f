//! The drive: amplifier and motor, from control effort to force.

pub mod amplifier;
pub mod circuit;
pub mod current_loop;
pub mod motor;
pub mod printed;
pub mod transmission;
