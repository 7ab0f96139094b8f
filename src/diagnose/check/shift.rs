//! By how many samples one signal lies behind another.

use super::projection::standard_error;
use crate::diagnose::scalar_product::dot;
use crate::diagnose::thresholds::BEYOND_CHANCE;

/// Whether a channel that lies so many samples behind (or ahead) is at least a row off, rounded: where within its period a channel is sampled is not stated
/// anywhere, and a column can be moved by whole rows only.
pub fn is_a_row(samples: f64) -> bool {
    samples.round() != 0.0
}

/// A shift found by least squares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shift {
    /// Samples by which the signal lies behind; negative: ahead.
    pub samples: f64,
    /// Standard error of that.
    pub standard_error: f64,
    /// Share of the signal's variance that stays unexplained without a shift.
    pub before: f64,
    /// And with it.
    pub after: f64,
}

impl Shift {
    /// The shift that leaves the smallest residual.
    ///
    /// # Model
    /// `residual(s)` is what a relation leaves when the signal is taken s samples later. The whole shift s with
    /// the smallest sum of squares is found by trial; beyond it the residual is linear in the rest δ, with the
    /// slope g = (r(s+1) − r(s−1))/2, so δ = −g·r/g·g. The error comes from sums of g·r over pieces.
    ///
    /// # Validity
    /// Signals that change little within a sample (smoothed ones). None where the smallest residual lies at the
    /// end of the range: then nothing there is a minimum.
    pub fn find(most: usize, variance: f64, residual: impl Fn(isize) -> Vec<f64>) -> Option<Self> {
        let most = most as isize;
        let size = |shift| {
            let r = residual(shift);
            dot(&r, &r)
        };
        let sizes: Vec<(isize, f64)> = (-most..=most).map(|shift| (shift, size(shift))).collect();
        // The nearest to zero of equals: where nothing depends on the shift there is none.
        let best = sizes.iter().min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.abs().cmp(&b.0.abs())))?.0;
        if best.abs() == most || variance <= 0.0 {
            return None;
        }
        let middle = residual(best);
        let slope: Vec<f64> = residual(best + 1)
            .iter()
            .zip(residual(best - 1))
            .map(|(later, earlier)| 0.5 * (later - earlier))
            .collect();
        let steepness = dot(&slope, &slope);
        if steepness <= 0.0 {
            return None;
        }
        let rest = (-dot(&slope, &middle) / steepness).clamp(-1.0, 1.0);
        let left: Vec<f64> = middle.iter().zip(&slope).map(|(r, g)| r + rest * g).collect();
        let before = sizes.iter().find(|(shift, _)| *shift == 0).map_or(0.0, |(_, size)| *size);
        Some(Self {
            samples: best as f64 + rest,
            standard_error: standard_error(&slope, &left, steepness),
            before: before / variance,
            after: dot(&left, &left).min(dot(&middle, &middle)) / variance,
        })
    }

    /// Whether it is neither chance nor within a sample's own width.
    pub fn is_real(&self) -> bool {
        is_a_row(self.samples) && self.samples.abs() >= BEYOND_CHANCE * self.standard_error
    }

    /// The share of what was unexplained that the shift takes away.
    pub fn explains(&self) -> f64 {
        if self.before > 0.0 { 1.0 - self.after / self.before } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slow wave and a copy of it that lies `late` samples behind.
    fn shift(late: f64) -> Shift {
        let wave = |k: f64| (0.05 * k).sin() + 0.4 * (0.083 * k + 1.0).sin();
        let residual = |s: isize| -> Vec<f64> {
            (0..600).map(|k| wave(k as f64 + s as f64 - late) - wave(k as f64)).collect()
        };
        Shift::find(12, 600.0, residual).unwrap()
    }

    #[test]
    fn exact_shift_is_found_to_a_fraction_of_a_sample() {
        for late in [-3.0, -0.6, 0.0, 0.6, 1.6, 7.25] {
            let found = shift(late);
            assert!((found.samples - late).abs() < 2e-3, "{late}: {found:?}");
            assert_eq!(found.is_real(), late.abs() > 0.5);
        }
    }

    #[test]
    fn exact_shift_beyond_the_range_is_none() {
        let line = |s: isize| (0..100).map(|k| f64::from(k) + s as f64 + 50.0).collect::<Vec<f64>>();
        assert_eq!(Shift::find(5, 1.0, line), None);
        assert_eq!(Shift::find(5, 1.0, |_| vec![1.0; 100]), None);
    }
}
