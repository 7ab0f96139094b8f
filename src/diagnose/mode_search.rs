//! Frequencies of a mode that is not listed, from what the replays of a fit leave.

use super::care::Sensitivities;
use super::fit::{Fit, inverted};
use super::hypothesis::with_effect;
use super::objective::Objective;
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use nalgebra::DVector;

/// Frequencies of modes in Hz (prior of [`FlexibleMode`](crate::effect::FlexibleMode): 8 to 400 Hz), and lower ones of what stands soft.
const FREQUENCIES_HZ: (f64, f64) = (2.0, 400.0);
/// The highest as a share of the sample rate, by the same prior.
const HIGHEST: f64 = 0.2;
/// Damping ratio of the modes tried, the largest of the prior: each covers its neighbourhood.
const DAMPING: f64 = 0.06;
/// Ratio of a frequency to the one before: 1 + 2ζ, a mode's width at half its power.
const STEP: f64 = 1.0 + 2.0 * DAMPING;
/// Modal mass while a response is taken, in moving masses: a hundred times the largest of the prior, so that the response is of first order.
const MASSES: f64 = 1e4;

/// Where the fit of a mode may begin: frequency in Hz, modal mass in kg or kg·m², damping ratio; at most so many, the one that explains most first.
/// `mass` is the moving mass or inertia.
///
/// # Model
/// The replay's normalised residuals r change with a mode of frequency f and modal mass M by R(f)/M, seen through the twin's own loop. With J the
/// derivatives by the numbers of the fit, W the weights and N = JᵀWJ + prior:
/// ```text
///   g = Rᵀ(W − W·J·N⁻¹·Jᵀ·W)·R,   b = −RᵀWr + RᵀWJ·N⁻¹·(gradient)
///   1/M = b/g,   gain = b²/g, where b > 0
/// ```
/// The gain is by how much a fit of M lowers the weighted sum of squares. Unlike the reaction of an oscillator in the missing force it takes no
/// derivative of the position, which smoothing bounds to about 120 Hz, and weighs every sample by what it tells.
///
/// # Validity
/// To first order in 1/M, with one damping for all.
///
/// # Source
/// The score test: C. R. Rao (1948), Math. Proc. Cambridge Philos. Soc. 44:50.
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
    let heavy = MASSES * mass;
    let with = |f: &f64| with_effect(&fitted, EffectId::FlexibleMode, &[*f, heavy, DAMPING]);
    let machines: Result<Vec<Machine>> = frequencies.iter().map(with).collect();
    let residuals = objective.residuals(&fit.values)?;
    let changed = objective.residuals_at(&machines?)?;
    let weights = objective.weights(&residuals);
    let jacobian = &sensitivities.columns;
    let (normal, gradient) = objective.normal(jacobian, &residuals, &weights, &fit.values);
    let normal = inverted(&normal);
    let score = |changed: DVector<f64>| {
        let response = (changed - &residuals) * heavy;
        let weighted = response.component_mul(&weights);
        let cross = jacobian.tr_mul(&weighted);
        let taken = &normal * &cross;
        let g = weighted.dot(&response) - cross.dot(&taken);
        let b = taken.dot(&gradient) - weighted.dot(&residuals);
        (b > 0.0 && g > 0.0).then_some(Score { gain: b * b / g, mass: g / b })
    };
    let scores: Vec<Option<Score>> = changed.into_iter().map(score).collect();
    let starts = peaks(&scores).into_iter().take(most);
    Ok(starts.map(|(k, mass)| vec![frequencies[k], mass, DAMPING]).collect())
}

/// What a mode explains.
#[derive(Debug, Clone, Copy)]
struct Score {
    /// By how much it lowers the weighted sum of squares.
    gain: f64,
    /// Its modal mass.
    mass: f64,
}

/// Frequencies in Hz that are tried.
fn frequencies(period_s: f64) -> Vec<f64> {
    let (lowest, highest) = (FREQUENCIES_HZ.0, FREQUENCIES_HZ.1.min(HIGHEST / period_s));
    let up = std::iter::successors(Some(lowest), |f| Some(f * STEP));
    up.take_while(|f| *f < highest).collect()
}

/// Places that explain more than their neighbours, with the modal mass; the one that explains most first.
fn peaks(scores: &[Option<Score>]) -> Vec<(usize, f64)> {
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
        let scores: Vec<Option<Score>> =
            gains.iter().map(|&gain| (gain > 0.0).then_some(Score { gain, mass: 10.0 * gain })).collect();
        assert_eq!(peaks(&scores), [(3, 50.0), (6, 40.0), (0, 30.0)]);
        assert_eq!(peaks(&[None; 3]), []);
    }

    /// From the lowest frequency to a fifth of the sample rate, each within a mode's width of the one before.
    #[test]
    fn exact_frequencies_cover_all_that_is_sampled() {
        let frequencies = frequencies(1e-3);
        let last = frequencies[frequencies.len() - 1];
        assert!(frequencies[0] == 2.0 && last < 200.0 && last * STEP >= 200.0);
        assert!(frequencies.windows(2).all(|pair| (pair[1] / pair[0] - 1.12).abs() < 1e-12));
    }
}
