//! Slideway.
pub mod base;
pub mod error;
pub mod identify;
pub mod plant;
pub mod recording;
pub mod solid;
pub mod units;
