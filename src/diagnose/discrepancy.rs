//! What a hypothesis leaves undescribed, and what of it may have gone into the numbers of its fit.

use super::estimate::Screen;
use super::linearised::Linearised;
use super::motion;
use super::waves::{self, PROBE, Wave};
use crate::effect::{AmplifierOffset, ConstantForce, Effect};
use crate::error::Result;
use crate::machine::Machine;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Periods of the force over the travel, twice the travel first, each half of the one before: down to an eighth of the travel.
const OCTAVES: i32 = 5;
/// Share of its power that a fit must leave of a constant: derivatives are differences, known to a thousandth, of which this is the square.
const TOLD: f64 = 1e-6;

/// Covariance that the discrepancy of a hypothesis adds to that of its numbers, in units of their scales; none where the residuals are noise.
///
/// # Model
/// What a hypothesis does not describe is a force d(x) of the place x that acts on the moving part, a constant force and a constant voltage of the amplifier, seen
/// through the twin's own loop:
/// ```text
///   d(x) = Σ_j a_j·w_j(x),   a_j ~ N(0, τ²),   w_j: sin and cos of 2πx/p, p = 2L, L, L/2, L/4, L/8
/// ```
/// over a travel L: as much force in each octave. With J the derivatives of the normalised residuals, W their weights, P the precision of the
/// priors and c_j the response to w_j, the fit takes up b_j and leaves r_j of each:
/// ```text
///   b_j = −(JᵀWJ + P)⁻¹·JᵀW·c_j,   r_j = c_j + J·b_j
///   τ²  = max(Σ W(r² − 1) / tr N, (sᵀs − tr N) / tr N²),   N_ij = r_iᵀW r_j,   s_j = r_jᵀW r
///   added covariance = τ²·Σ_j b_j·b_jᵀ
/// ```
/// so that the undescribed part is as large as what the residuals r of the training runs have above noise: in all, or along the waves, where
/// E[sᵀs] = tr N + τ²·tr N² (method of moments). Along the waves it shows where it is far below the level of the noise, too: a part that is the
/// same over many samples moves the numbers by more than noise does. Each constant has a variance τ² of its own, by the method of moments alone: a trimmed amplifier and
/// a balanced weight leave one that no magnet or screw tells of.
///
/// # Validity
/// To first order in the force, and for what depends on place or on nothing. Noise that is really larger than its estimate counts as discrepancy, and so does
/// coloured noise along the waves: E[sᵀs] is that of white residuals. A constant that the numbers of the fit take up but for a millionth of its power is not told by these runs, and counts as
/// none: what it is taken for is confusable with it.
///
/// # Source
/// Kennedy, O'Hagan (2001), *Bayesian calibration of computer models*, J. R. Stat. Soc. B 63:425; Brynjarsdóttir, O'Hagan (2014), *Learning
/// about physical parameters: the importance of model discrepancy*, Inverse Problems 30:114007: without it intervals do not hold the truth.
///
/// # Errors
/// Whatever a replay refuses.
pub fn covariance(linear: &Linearised, fitted: &Machine) -> Result<Option<DMatrix<f64>>> {
    let Linearised { objective, residuals, weights, .. } = linear;
    let screen = motion::screen(objective.experiments, fitted)?;
    let responses = |machines: &[Machine]| -> Result<Vec<DVector<f64>>> {
        Ok(objective.residuals_at(machines)?.into_iter().map(|changed| changed - residuals).collect())
    };
    let (taken, left) = split(linear, &responses(&with_waves(fitted, &screen))?);
    let along = variance(residuals, weights, &left).max(in_all(residuals, weights, &left));
    let mut added = summed(linear, &taken) * along;
    for response in responses(&with_constants(fitted, &screen))? {
        let (taken, left) = split(linear, std::slice::from_ref(&response));
        let power = |change: &DVector<f64>| change.component_mul(weights).dot(change);
        if power(&left[0]) > TOLD * power(&response) {
            added += summed(linear, &taken) * variance(residuals, weights, &left);
        }
    }
    Ok((added.amax() > 0.0).then_some(added))
}

/// What the numbers of a fit take up of each response, and what they leave of it.
fn split(linear: &Linearised, responses: &[DVector<f64>]) -> (Vec<DVector<f64>>, Vec<DVector<f64>>) {
    let one = |response: &DVector<f64>| {
        let taken = linear.step(response);
        let left = response + &linear.jacobian * &taken;
        (taken, left)
    };
    responses.par_iter().map(one).unzip()
}

/// Σ b·bᵀ.
fn summed(linear: &Linearised, taken: &[DVector<f64>]) -> DMatrix<f64> {
    let count = linear.jacobian.ncols();
    taken.iter().fold(DMatrix::zeros(count, count), |sum, step| sum + step * step.transpose())
}

/// τ² of directions of which a fit leaves these, by what the residuals have above noise in all.
fn in_all(residuals: &DVector<f64>, weights: &DVector<f64>, left: &[DVector<f64>]) -> f64 {
    let trace: f64 = left.iter().map(|rest| rest.component_mul(weights).dot(rest)).sum();
    let above: f64 = residuals.iter().zip(weights).map(|(r, w)| w * (r * r - 1.0)).sum();
    if trace > 0.0 { (above / trace).max(0.0) } else { 0.0 }
}

/// τ² of directions of which a fit leaves these, by what the residuals have along them: zero where that is noise.
fn variance(residuals: &DVector<f64>, weights: &DVector<f64>, left: &[DVector<f64>]) -> f64 {
    let weighted: Vec<DVector<f64>> = left.par_iter().map(|rest| rest.component_mul(weights)).collect();
    let trace: f64 = left.iter().zip(&weighted).map(|(rest, weighted)| rest.dot(weighted)).sum();
    let along = |rest: &DVector<f64>| weighted.iter().map(|w| w.dot(rest).powi(2)).sum::<f64>();
    let squares: f64 = left.par_iter().map(along).collect::<Vec<f64>>().iter().sum();
    let scores: f64 = weighted.iter().map(|w| w.dot(residuals).powi(2)).sum();
    if squares > 0.0 { ((scores - trace) / squares).max(0.0) } else { 0.0 }
}

/// The machine with each of the waves of force over the travel, all of one amplitude.
fn with_waves(fitted: &Machine, screen: &Screen) -> Vec<Machine> {
    let period = |octave: i32| 2.0 * screen.travel() * 0.5f64.powi(octave);
    let all = (0..OCTAVES).flat_map(|octave| Wave::both(period(octave), PROBE * screen.largest_force));
    waves::machines(fitted, waves::force, all)
}

/// The machine with each of the constants that it can have.
fn with_constants(fitted: &Machine, screen: &Screen) -> Vec<Machine> {
    let force = ConstantForce { force_n: PROBE * screen.largest_force };
    let voltage = AmplifierOffset { offset_v: PROBE * screen.largest_voltage() };
    let all = [Effect::ConstantForce(force), Effect::AmplifierOffset(voltage)];
    let can_have = |effect: &Effect| effect.id().applies(&fitted.constants());
    all.into_iter().filter(can_have).map(|effect| fitted.clone().with_probe(effect)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Waves of variance τ² in residuals whose level is below that of the noise: over draws the mean of the estimates is τ². Without any it is small.
    #[test]
    fn exact_what_is_coherent_shows_below_the_level_of_the_noise() {
        use rand::rngs::StdRng;
        use rand::{RngExt, SeedableRng};
        let mut draw = StdRng::seed_from_u64(3);
        let mut normal = || (0..12).map(|_| draw.random_range(-1.0..1.0)).sum::<f64>() / 2.0;
        let (samples, quiet, waves) = (4000, 0.9, 10);
        let wave = |j: usize| DVector::from_fn(samples, |k, _| (0.003 * (j + 1) as f64 * k as f64).sin());
        let left: Vec<DVector<f64>> = (0..waves).map(wave).collect();
        let weights = DVector::from_element(samples, 1.0);
        let mut estimated = |sd: f64| -> f64 {
            let draws = 200;
            let one = |_| {
                let mut residuals = DVector::from_fn(samples, |_, _| quiet * normal());
                left.iter().for_each(|wave| residuals.axpy(sd * normal(), wave, 1.0));
                variance(&residuals, &weights, &left)
            };
            (0..draws).map(one).sum::<f64>() / f64::from(draws)
        };
        let (sd, none) = (0.1, estimated(0.0));
        let found = estimated(sd);
        assert!((found / (sd * sd) - 1.0).abs() < 0.15, "{found}");
        assert!(none < 0.02 * sd * sd, "{none}");
    }
}
