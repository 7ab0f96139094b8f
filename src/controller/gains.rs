//! A control law as its gains.

use super::{Input, Memory};
use nalgebra::Complex;

/// The gains in which every law of this module is linear.
///
/// # Model
/// ```text
///   e = position·(x_ref − x) + feedforward·v_ref − v
///   I ← I + integral·e
///   u = I + error·e − velocity·v                       volts
/// ```
/// PDF has no gain on the error, a cascade none on the velocity alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// 1/s.
    pub position: f64,
    /// Share of the reference velocity.
    pub feedforward: f64,
    /// V per (m/s) or (rad/s) and sample.
    pub integral: f64,
    /// V·s/m or V·s/rad, on the error.
    pub error: f64,
    /// V·s/m or V·s/rad, on the measured velocity.
    pub velocity: f64,
}

impl Gains {
    /// The voltage commanded for this sample.
    #[inline]
    pub fn effort_v(&self, memory: &mut Memory, input: Input) -> f64 {
        let error = self.position * (input.position_reference - input.position)
            + self.feedforward * input.velocity_reference
            - input.velocity;
        memory.integral_v += self.integral * error;
        memory.integral_v + self.error * error - self.velocity * input.velocity
    }

    /// What feeds back, effort over reading with the sign turned, for a velocity estimate of `velocity` per reading.
    ///
    /// # Model
    /// `K = C·(position + V) + velocity·V` with `C = integral·S + error` and `S = 1/(1 − z⁻¹)` given as `sum`: the loop broken
    /// at the effort is `L = G·K`, and `u = −K·x` follows from a reading x alone.
    pub fn feedback(&self, sum: Complex<f64>, velocity: Complex<f64>) -> Complex<f64> {
        (sum * self.integral + self.error) * (velocity + self.position) + velocity * self.velocity
    }

    /// Effort over position reference, where the velocity reference is `rate` per position reference.
    ///
    /// # Model
    /// `C·(position + feedforward·V_r)`, C as in [`feedback`](Self::feedback).
    pub fn forward(&self, sum: Complex<f64>, rate: Complex<f64>) -> Complex<f64> {
        (sum * self.integral + self.error) * (rate * self.feedforward + self.position)
    }
}
