//! Frequencies of a mode that is not listed, from what the replays of a fit leave.

use super::care::Sensitivities;
use super::estimate::resonance::LOWEST_HZ;
use super::fit::Fit;
use super::hypothesis::with_effect;
use super::objective::Objective;
use super::score_test::ScoreTest;
use crate::effect::EffectId;
use crate::effect::flexible_mode::{DAMPING_RATIOS, HIGHEST_HZ, HIGHEST_OF_RATE};
use crate::error::Result;
use crate::machine::Machine;
use nalgebra::{DMatrix, DVector};

/// Damping ratio of the modes tried, the largest that modes have: each covers its neighbourhood.
const DAMPING: f64 = DAMPING_RATIOS.1;
/// Ratio of a frequency to the one before: 1 + 2ζ, a mode's width at half its power.
const STEP: f64 = 1.0 + 2.0 * DAMPING;
/// Modal mass while a response is taken, in moving masses: a hundred times the largest of the prior, so that the response is of first order.
const MASSES: f64 = 1e4;

/// Where the fit of a mode may begin: frequency in Hz, modal mass in kg or kg·m², damping ratio; at most so many, the one that explains most first.
/// `mass` is the moving mass or inertia.
///
/// # Model
/// The replay's normalised residuals change with a mode of frequency f and modal mass M by R(f)/M, seen through the twin's own loop. With g and b of the
/// [score test](ScoreTest) of R:
/// ```text
///   1/M = b/g,   gain = b²/g, where b > 0
/// ```
/// Unlike the reaction of an oscillator in the missing force it takes no derivative of the position, which smoothing bounds to about 120 Hz, and weighs
/// every sample by what it tells.
///
/// # Validity
/// To first order in 1/M, with one damping for all.
///
/// # Errors
/// Whatever a replay refuses.
pub fn modes(
    objective: &Objective,
    fit: &Fit,
    sensitivities: &Sensitivities,
    mass: f64,
    most: usize,
) -> Result<Vec<Vec<f64>>> {
    let fitted = fit.machine(objective.machine)?;
    let frequencies = frequencies(objective.machine.description().sample_period_s);
    if frequencies.is_empty() {
        return Ok(Vec::new());
    }
    let heavy = MASSES * mass;
    let with = |f: &f64| with_effect(&fitted, EffectId::FlexibleMode, &[*f, heavy, DAMPING]);
    let machines: Result<Vec<Machine>> = frequencies.iter().map(with).collect();
    let residuals = objective.residuals(&fit.values)?;
    let changed = objective.residuals_at(&machines?)?;
    let responses: Vec<DVector<f64>> =
        changed.into_iter().map(|changed| (changed - &residuals) * heavy).collect();
    let responses = DMatrix::from_columns(&responses);
    let test = ScoreTest::of(objective, &fit.values, &residuals, &sensitivities.columns, &responses);
    let score = |k: usize| {
        let (g, b) = (test.normal[(k, k)], test.right[k]);
        (b > 0.0 && g > 0.0).then_some(Explained { gain: b * b / g, mass: g / b })
    };
    let scores: Vec<Option<Explained>> = (0..frequencies.len()).map(score).collect();
    let starts = peaks(&scores).into_iter().take(most);
    Ok(starts.map(|(k, mass)| vec![frequencies[k], mass, DAMPING]).collect())
}

/// What a mode explains.
#[derive(Debug, Clone, Copy)]
struct Explained {
    /// By how much it lowers the weighted sum of squares.
    gain: f64,
    /// Its modal mass.
    mass: f64,
}

/// Frequencies in Hz that are tried.
fn frequencies(period_s: f64) -> Vec<f64> {
    let (lowest, highest) = (LOWEST_HZ, HIGHEST_HZ.min(HIGHEST_OF_RATE / period_s));
    let up = std::iter::successors(Some(lowest), |f| Some(f * STEP));
    up.take_while(|f| *f < highest).collect()
}

/// Places that explain more than their neighbours, with the modal mass; the one that explains most first.
fn peaks(scores: &[Option<Explained>]) -> Vec<(usize, f64)> {
    let gain = |k: usize| scores.get(k).copied().flatten().map_or(0.0, |score| score.gain);
    let is_peak = |&k: &usize| gain(k) > gain(k + 1) && (k == 0 || gain(k) >= gain(k - 1));
    let mut peaks: Vec<usize> = (0..scores.len()).filter(is_peak).collect();
    peaks.sort_by(|&a, &b| gain(b).total_cmp(&gain(a)));
    peaks.into_iter().filter_map(|k| Some((k, scores[k]?.mass))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Peaks are higher than both neighbours, at the ends than the one; what would need a negative mass is none.
    #[test]
    fn exact_peaks_are_told_by_what_they_explain() {
        let gains = [3.0, 1.0, 5.0, 5.0, 2.0, 0.0, 4.0];
        let scores: Vec<Option<Explained>> =
            gains.iter().map(|&gain| (gain > 0.0).then_some(Explained { gain, mass: 10.0 * gain })).collect();
        assert_eq!(peaks(&scores), [(3, 50.0), (6, 40.0), (0, 30.0)]);
        assert_eq!(peaks(&[None; 3]), []);
    }

    /// From the lowest frequency to a fifth of the sample rate, each within a mode's width of the one before.
    #[test]
    fn exact_frequencies_cover_all_that_is_sampled() {
        let frequencies = frequencies(1e-3);
        let last = frequencies[frequencies.len() - 1];
        assert!(frequencies[0] == 2.0 && last < 200.0 && last * STEP >= 200.0);
        assert!(super::frequencies(0.1).is_empty());
        assert!(frequencies.windows(2).all(|pair| (pair[1] / pair[0] - 1.12).abs() < 1e-12));
    }
}
