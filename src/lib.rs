//! Slideway.
pub mod error;
