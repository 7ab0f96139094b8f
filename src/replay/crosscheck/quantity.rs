//! What is compared of a stroke.

use std::fmt;

/// What is compared of a stroke.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Position of the moving part relative to the base, as the encoder shows it.
    Position,
    /// The controller's velocity estimate.
    Velocity,
    /// Motor force or torque.
    Thrust,
    /// Vertical load of a bearing slider, mean over the last step of the plant.
    Slider(usize),
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Position => f.write_str("position"),
            Self::Velocity => f.write_str("velocity"),
            Self::Thrust => f.write_str("thrust"),
            Self::Slider(k) => write!(f, "slider {}", ["A", "B", "C", "D"].get(*k).unwrap_or(&"?")),
        }
    }
}
