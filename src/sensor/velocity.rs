//! Velocity from encoder readings.

use std::f64::consts::PI;

use nalgebra::Complex;
use serde::{Deserialize, Serialize};

use crate::units::largest;

/// How velocity is estimated from the readings `x[k]`, `x[k−1]`, ….
///
/// # Model
/// - `smoothed_difference`: `v[k] = v[k−1] + T/(T+τ)·((x[k] − x[k−1])/T − v[k−1])`
/// - `taps`: `v[k] = Σ_j taps[j]·x[k−j]/T`; the taps sum to zero and `−Σ j·taps[j] = 1`
///   (unit slope), which is checked. `[1, −1]` is the plain difference, `[0.5, 0, −0.5]` the difference
///   of the two-sample mean, `[0.3, 0.1, −0.1, −0.3]` the four-point least-squares slope. With a time constant,
///   the sum is smoothed like the difference above.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum VelocityEstimate {
    /// First-order smoothing of the difference of two readings.
    SmoothedDifference {
        /// τ in s.
        time_constant_s: f64,
    },
    /// Weighted sum of the latest readings.
    Taps {
        /// Weights of `x[k]`, `x[k−1]`, …, per sample period.
        taps: Vec<f64>,
        /// τ in s of a smoothing after them.
        #[serde(default)]
        time_constant_s: f64,
    },
}

/// Most taps that an estimate may have.
pub const MOST_TAPS: usize = 8;

/// The readings and the estimate that the next sample needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityMemory {
    readings: [f64; MOST_TAPS],
    estimate: f64,
}

impl VelocityMemory {
    /// Memory of an axis that has stood at `position` or moved there at the constant `velocity`.
    pub fn moving(position: f64, velocity: f64, period_s: f64) -> Self {
        let readings = std::array::from_fn(|j| position - velocity * period_s * (j as f64 + 1.0));
        Self { readings, estimate: velocity }
    }

    /// The reading before the coming one.
    pub fn newest_reading(&self) -> f64 {
        self.readings[0]
    }

    /// The estimate so far.
    pub fn estimate(&self) -> f64 {
        self.estimate
    }

    /// The memory of the same motion, moved by `position` at the coming sample and faster by `velocity`.
    #[must_use]
    pub fn shifted(mut self, position: f64, velocity: f64, period_s: f64) -> Self {
        for (j, reading) in self.readings.iter_mut().enumerate() {
            *reading += position - velocity * period_s * (j as f64 + 1.0);
        }
        self.estimate += velocity;
        self
    }
}

impl VelocityEstimate {
    /// What is wrong with the configuration, if anything.
    pub fn fault(&self) -> Option<String> {
        match self {
            Self::SmoothedDifference { time_constant_s } | Self::Taps { time_constant_s, .. }
                if !(0.0..=largest("time_constant_s")).contains(time_constant_s) =>
            {
                Some(format!("time_constant_s = {time_constant_s}, expected zero or more"))
            }
            Self::SmoothedDifference { .. } => None,
            Self::Taps { taps, .. } => {
                let sum: f64 = taps.iter().sum();
                let slope: f64 = -taps.iter().enumerate().map(|(j, w)| j as f64 * w).sum::<f64>();
                let right =
                    (2..=MOST_TAPS).contains(&taps.len()) && sum.abs() < 1e-9 && (slope - 1.0).abs() < 1e-9;
                (!right).then(|| {
                    format!("taps {taps:?} (sum {sum}, slope {slope}), expected 2 to {MOST_TAPS} taps with sum 0 and slope 1")
                })
            }
        }
    }

    /// τ of the smoothing in s.
    pub fn time_constant_s(&self) -> f64 {
        match self {
            Self::SmoothedDifference { time_constant_s } | Self::Taps { time_constant_s, .. } => {
                *time_constant_s
            }
        }
    }

    /// Sets τ of the smoothing in s.
    pub fn set_time_constant_s(&mut self, value: f64) {
        match self {
            Self::SmoothedDifference { time_constant_s } | Self::Taps { time_constant_s, .. } => {
                *time_constant_s = value;
            }
        }
    }

    /// Estimate over reading at `frequency_hz`, in 1/s.
    ///
    /// # Model
    /// `V(z) = a·W(z)/(1 − (1 − a)·z⁻¹)`, `a = T/(T + τ)`, `z = e^{iωT}`, with `W(z) = (1 − z⁻¹)/T` or `Σ_j taps[j]·z⁻ʲ/T`.
    pub fn response(&self, frequency_hz: f64, period_s: f64) -> Complex<f64> {
        let half = PI * frequency_hz * period_s;
        let back = Complex::from_polar(1.0, -2.0 * half);
        let slope = match self {
            // 1 − z⁻¹ without taking two numbers near 1 apart.
            Self::SmoothedDifference { .. } => {
                Complex::new(0.0, 2.0 * half.sin()) * Complex::from_polar(1.0, -half)
            }
            Self::Taps { taps, .. } => {
                taps.iter().rev().fold(Complex::default(), |sum, tap| sum * back + *tap)
            }
        };
        let share = period_s / (period_s + self.time_constant_s());
        slope * (share / period_s) / (Complex::from(1.0) - back * (1.0 - share))
    }

    /// The estimate after the reading `x`; `period_s` is the sample period.
    #[inline]
    pub fn update(&self, memory: &mut VelocityMemory, x: f64, period_s: f64) -> f64 {
        memory.estimate = match self {
            Self::SmoothedDifference { time_constant_s } => {
                let difference = (x - memory.readings[0]) * (1.0 / period_s);
                // One earlier reading is all that it needs.
                memory.readings[0] = x;
                memory.estimate += period_s / (period_s + time_constant_s) * (difference - memory.estimate);
                return memory.estimate;
            }
            Self::Taps { taps, time_constant_s } => {
                let newest = taps.first().map_or(0.0, |w| w * x);
                let older: f64 = taps.iter().skip(1).zip(&memory.readings).map(|(w, r)| w * r).sum();
                let slope = (newest + older) / period_s;
                memory.estimate + period_s / (period_s + time_constant_s) * (slope - memory.estimate)
            }
        };
        memory.readings.copy_within(0..MOST_TAPS - 1, 1);
        memory.readings[0] = x;
        memory.estimate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_constant_velocity_is_read_without_error() {
        let (period, speed) = (1e-3, 0.37);
        let estimates = [
            VelocityEstimate::SmoothedDifference { time_constant_s: 5e-4 },
            VelocityEstimate::Taps { taps: vec![0.5, 0.0, -0.5], time_constant_s: 0.0 },
            VelocityEstimate::Taps { taps: vec![0.3, 0.1, -0.1, -0.3], time_constant_s: 2e-3 },
        ];
        for estimate in estimates {
            assert_eq!(estimate.fault(), None);
            let mut memory = VelocityMemory::moving(0.2, speed, period);
            for k in 0..20 {
                let v = estimate.update(&mut memory, 0.2 + speed * period * f64::from(k), period);
                assert!((v - speed).abs() < 1e-11, "{estimate:?}: {v}");
            }
        }
    }

    #[test]
    fn exact_taps_without_unit_slope_are_refused() {
        assert!(VelocityEstimate::Taps { taps: vec![1.0, -0.5], time_constant_s: 0.0 }.fault().is_some());
        assert!(VelocityEstimate::Taps { taps: vec![2.0, -2.0], time_constant_s: 0.0 }.fault().is_some());
    }
}
