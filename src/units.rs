//! Quantities and units: everything inside is SI, converted once at the door.

use serde::{Deserialize, Serialize};

/// How the driven axis moves; decides whether its coordinate is in m or rad, its effort in N or N·m.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// Straight-line motion: position in m, effort in N.
    Prismatic,
    /// Rotation about one axis: position in rad, effort in N·m.
    Revolute,
}
