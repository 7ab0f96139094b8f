//! Sensors: what the controller and the recording see of the axis.
//!
//! Encoder and current sensor, each with resolution and noise, and the velocity estimate that the
//! controller forms from the encoder.

pub mod velocity;

use serde::{Deserialize, Serialize};
pub use velocity::{VelocityEstimate, VelocityMemory};

/// Position encoder of the axis: its head sits on the base and reads the moving part relative to it.
///
/// # Model
/// `reading = step · round((q + noise)/step)`, noise white Gaussian with the stated σ; a step of zero
/// leaves the reading unrounded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Encoder {
    /// Step of the reading in m, or rad for a revolute axis; 0: none.
    #[serde(default, alias = "resolution_rad")]
    pub resolution_m: f64,
    /// σ of the noise in m, or rad for a revolute axis.
    #[serde(default, alias = "noise_rad")]
    pub noise_m: f64,
    /// How the controller estimates velocity from the readings.
    pub velocity: VelocityEstimate,
}

impl Encoder {
    /// The reading at position `q` with the noise value `noise` (same unit) already drawn.
    pub fn read(&self, q: f64, noise: f64) -> f64 {
        let value = q + noise;
        if self.resolution_m > 0.0 { (value / self.resolution_m).round() * self.resolution_m } else { value }
    }
}

/// Current sensor: additive white Gaussian noise.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CurrentSensor {
    /// σ of the noise in A.
    #[serde(default)]
    pub noise_a: f64,
}
