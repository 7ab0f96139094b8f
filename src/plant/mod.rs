//! Plants: what the drive's effort moves.

pub mod rapier;
