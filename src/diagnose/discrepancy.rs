//! What a hypothesis leaves undescribed, and what of it may have gone into the numbers of its fit.

use super::linearised::Linearised;
use super::motion;
use super::objective::Objective;
use super::waves::{self, Wave};
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use nalgebra::{DMatrix, DVector};

/// Laws of a force that depends on place alone, of which one that the machine does not have makes the waves.
const PLACES: [EffectId; 3] = [EffectId::Cogging, EffectId::SecondCogging, EffectId::ThirdCogging];
/// Periods of the force over the travel, twice the travel first, each half of the one before: down to an eighth of the travel.
const OCTAVES: i32 = 5;
/// Force of a wave while its response is taken, as a share of the largest force: small against any friction, large against rounding.
const SHARE: f64 = 1e-5;

/// Covariance that the discrepancy of a hypothesis adds to that of its numbers, in units of their scales; none where the residuals are noise.
///
/// # Model
/// What a hypothesis does not describe is a force d(x) of the place x that acts on the moving part, seen through the twin's own loop:
/// ```text
///   d(x) = Σ_j a_j·w_j(x),   a_j ~ N(0, τ²),   w_j: sin and cos of 2πx/p, p = 2L, L, L/2, L/4, L/8
/// ```
/// over a travel L: as much force in each octave. With J the derivatives of the normalised residuals, W their weights, P the precision of the
/// priors and c_j the response to w_j, the fit takes up b_j and leaves r_j of each:
/// ```text
///   b_j = −(JᵀWJ + P)⁻¹·JᵀW·c_j,   r_j = c_j + J·b_j
///   τ²  = Σ W(r² − 1) / Σ_j r_jᵀW r_j,   added covariance = τ²·Σ_j b_j·b_jᵀ
/// ```
/// so that the undescribed part is as large as what the residuals r of the training runs have above noise.
///
/// # Validity
/// To first order in the force, and for what depends on place. Noise that is really larger than its estimate counts as discrepancy.
///
/// # Source
/// Kennedy, O'Hagan (2001), *Bayesian calibration of computer models*, J. R. Stat. Soc. B 63:425; Brynjarsdóttir, O'Hagan (2014), *Learning
/// about physical parameters: the importance of model discrepancy*, Inverse Problems 30:114007: without it intervals do not hold the truth.
///
/// # Errors
/// Whatever a replay refuses.
pub fn covariance(linear: &Linearised, fitted: &Machine) -> Result<Option<DMatrix<f64>>> {
    let Linearised { objective, residuals, weights, jacobian, .. } = linear;
    let excess: f64 = residuals.iter().zip(weights).map(|(r, w)| w * (r * r - 1.0)).sum();
    if excess <= 0.0 {
        return Ok(None);
    }
    let count = jacobian.ncols();
    let (mut taken, mut left) = (DMatrix::zeros(count, count), 0.0);
    for response in responses(objective, fitted, residuals)? {
        let moved = linear.step(&response);
        let rest = &response + jacobian * &moved;
        left += rest.component_mul(weights).dot(&rest);
        taken += &moved * moved.transpose();
    }
    Ok((left > 0.0).then(|| taken * (excess / left)))
}

/// Responses of the normalised residuals to waves of force over the travel, all of one amplitude.
fn responses(objective: &Objective, fitted: &Machine, residuals: &DVector<f64>) -> Result<Vec<DVector<f64>>> {
    let Some(law) = waves::free(fitted, &PLACES) else { return Ok(Vec::new()) };
    let screen = motion::screen(objective.experiments, fitted)?;
    let period = |octave: i32| 2.0 * screen.travel() * 0.5f64.powi(octave);
    let all = (0..OCTAVES).flat_map(|octave| Wave::both(period(octave), SHARE * screen.largest_force));
    let Some(machines) = waves::machines(fitted, law, all) else { return Ok(Vec::new()) };
    Ok(objective.residuals_at(&machines)?.into_iter().map(|changed| changed - residuals).collect())
}
