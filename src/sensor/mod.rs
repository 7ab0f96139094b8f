//! Sensors: what the controller and the recording see of the axis.
//!
//! Encoder and current sensor, each with resolution and noise, and the velocity estimate that the
//! controller forms from the encoder.

pub mod velocity;

use serde::{Deserialize, Serialize};
pub use velocity::{VelocityEstimate, VelocityMemory};

/// End of the drive train that a sensor sees: the same thing where motor and load are one rigid body.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// The moving part itself.
    #[default]
    Load,
    /// The motor, expressed as the axis coordinate.
    Motor,
}

/// A second position sensor, at the load: a linear scale beside a motor encoder.
///
/// # Model
/// As [`Encoder`]. Its zero is its own: a constant difference to the encoder means nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadSensor {
    /// Step of the reading in m, or rad for a revolute axis; 0: none.
    #[serde(default, alias = "resolution_rad")]
    pub resolution_m: f64,
    /// σ of the noise in m, or rad for a revolute axis.
    #[serde(default, alias = "noise_rad")]
    pub noise_m: f64,
    /// Whether the controller closes its position loop on this sensor; its velocity loop stays on the encoder.
    #[serde(default)]
    pub closes_position_loop: bool,
}

impl LoadSensor {
    /// The reading at position `q` with the noise value `noise` (same unit) already drawn.
    pub fn read(&self, q: f64, noise: f64) -> f64 {
        rounded(q + noise, self.resolution_m)
    }
}

/// `value` on the nearest multiple of `step`; a step of zero leaves it.
#[inline]
pub fn rounded(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step).round() * step } else { value }
}

/// Position encoder of the axis: its head sits on the base and reads the moving part relative to it.
///
/// # Model
/// `reading = step · round((q + noise)/step)`, noise white Gaussian with the stated σ; a step of zero
/// leaves the reading unrounded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Encoder {
    /// Step of the reading in m, or rad for a revolute axis; 0: none.
    #[serde(default, alias = "resolution_rad")]
    pub resolution_m: f64,
    /// σ of the noise in m, or rad for a revolute axis.
    #[serde(default, alias = "noise_rad")]
    pub noise_m: f64,
    /// Which end of the drive train it sees.
    #[serde(default)]
    pub end: End,
    /// How the controller estimates velocity from the readings.
    pub velocity: VelocityEstimate,
}

impl Encoder {
    /// The reading at position `q` with the noise value `noise` (same unit) already drawn.
    pub fn read(&self, q: f64, noise: f64) -> f64 {
        rounded(q + noise, self.resolution_m)
    }
}

/// Current sensor: additive white Gaussian noise.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurrentSensor {
    /// σ of the noise in A.
    #[serde(default)]
    pub noise_a: f64,
}

/// By what factors the log shows current and control effort other than they are.
///
/// # Model
/// As logged, factor times as it is; of the log alone, before noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogScale {
    /// Factor of the current; more than zero.
    pub current: f64,
    /// Factor of the control effort; more than zero.
    pub effort: f64,
}

impl Default for LogScale {
    fn default() -> Self {
        Self { current: 1.0, effort: 1.0 }
    }
}
