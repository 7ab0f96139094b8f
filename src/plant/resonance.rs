//! An oscillation of the assembled system.

use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// An oscillation of the assembled system: moving part, drag and base together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resonance {
    /// Undamped natural frequency |λ|/2π, in Hz.
    pub frequency_hz: f64,
    /// Damping ratio −Re λ/|λ|.
    pub damping_ratio: f64,
}

impl Resonance {
    /// The oscillations of `ż = A·z`, by frequency: eigenvalues λ of A whose imaginary part is more than `least` (1/s).
    pub(super) fn of(system: &DMatrix<f64>, least: f64) -> Vec<Self> {
        let values = system.complex_eigenvalues();
        let mut found: Vec<Self> = values
            .iter()
            .filter(|value| value.im > least)
            .map(|value| Self { frequency_hz: value.norm() / TAU, damping_ratio: -value.re / value.norm() })
            .collect();
        found.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        found
    }
}
