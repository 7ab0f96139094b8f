//! Slideway.
pub mod base;
pub mod drive;
pub mod error;
pub mod identify;
pub mod recording;
pub mod solid;
pub mod units;
