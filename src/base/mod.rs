//! The machine base: its modes, their motion under the drive's reaction, and the equivalent spring–mass
//! chain.
//!
//! Displacements of the base are positive along the joint's positive axis. The base receives the *reaction*:
//! the force on the base is the negative of the force on the table.

pub mod chain;
pub mod modes;
pub mod motion;

pub use chain::Chain;
pub use modes::{Mode, Modes};
pub use motion::BaseMotion;
