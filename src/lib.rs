//! Slideway: a multibody twin of a servo-driven machine axis that says why the real machine disagrees with it.
pub mod base;
pub mod controller;
pub mod diagnose;
pub mod drive;
pub mod effect;
pub mod error;
pub mod guide;
pub mod identify;
pub mod machine;
pub mod plant;
pub mod recording;
pub mod replay;
pub mod sensor;
pub mod solid;
pub mod twin;
pub mod units;
