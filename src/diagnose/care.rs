//! How far a fit goes.

use super::free::Free;
use nalgebra::{DMatrix, DVector};

/// Steps along a narrow, curved valley are short: motor constants, mass and friction compensate each other.
const MOST_ITERATIONS: usize = 60;
/// Iterations of a fit that only has to show whether a hypothesis matters.
pub(super) const ROUGH_ITERATIONS: usize = 8;
/// Relative fall of the sum of squares below which a rough fit has arrived: a choice of cost, rough fits are told apart by factors of two.
pub(super) const ROUGHLY_ARRIVED: f64 = 3e-3;
/// Fall of the weighted sum of squares below which a fit has arrived, where residuals are white: its numbers are within a tenth of their standard error.
/// Residuals that are autocorrelated and uneven multiply it by what they make of that variance along the step.
pub(super) const ARRIVED: f64 = 0.01;

/// Sensitivities of a fitted hypothesis, to be used again by hypotheses that build on it.
///
/// They change slowly with what is added: a fit that takes the old ones for the numbers it shares still descends, a
/// little less directly, and needs replays for its own numbers only.
#[derive(Debug, Clone)]
pub struct Sensitivities {
    pub(super) free: Vec<Free>,
    pub(super) columns: DMatrix<f64>,
    pub(super) stride: usize,
    /// Longest step of the plant in these replays, in s.
    pub(super) longest_step_s: f64,
}

impl Sensitivities {
    pub(super) fn column(&self, free: &Free) -> Option<DVector<f64>> {
        let place = self.free.iter().position(|own| own.path == free.path)?;
        Some(self.columns.column(place) * (free.scale / self.free[place].scale))
    }

    /// Those of the numbers that are not left out: a fit takes its own of these.
    pub(super) fn without(&self, is_left_out: impl Fn(&Free) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.free.len()).filter(|&k| !is_left_out(&self.free[k])).collect();
        Self {
            free: kept.iter().map(|&k| self.free[k].clone()).collect(),
            columns: self.columns.select_columns(&kept),
            ..*self
        }
    }
}

/// How much a fit is worth.
#[derive(Debug, Clone, Copy)]
pub enum Care<'a> {
    /// Good enough to see which hypotheses matter: known sensitivities, few iterations.
    Rough(&'a Sensitivities),
    /// To the end, with sensitivities of its own.
    Thorough,
}

impl<'a> Care<'a> {
    pub(super) fn iterations(self) -> usize {
        match self {
            Self::Rough(_) => ROUGH_ITERATIONS,
            Self::Thorough => MOST_ITERATIONS,
        }
    }

    pub(super) fn known(self) -> Option<&'a Sensitivities> {
        match self {
            Self::Rough(known) => Some(known),
            Self::Thorough => None,
        }
    }
}
