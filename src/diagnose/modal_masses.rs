//! What stated modal masses of the base put into the numbers of an explanation.

use super::experiment::Experiment;
use super::fit::Fit;
use super::linearised::Linearised;
use super::noise::Floor;
use crate::error::Result;
use crate::machine::Machine;
use nalgebra::DMatrix;

/// Covariance that the tolerance of the base's modal masses adds to that of a fit's numbers, in units of their scales; none for a machine without base modes.
///
/// # Model
/// Mass, friction and motor constant that grow by the same share move an axis alike but for the recoil of its base, which goes with the
/// force over the modal masses. A fit takes these as stated; each is as uncertain as the moving mass, with a standard deviation of half the tolerance of that (a
/// tolerance is two). With r the residuals, J their derivatives by the numbers, W their weights and P the precision of the priors, independent errors σ of the masses
/// m_k add (parameters that are considered and not estimated)
/// ```text
///   Σ_k b_k·b_kᵀ,   b_k = −(JᵀWJ + P)⁻¹·JᵀW·(r(m_k·(1 + σ)) − r)
/// ```
///
/// # Validity
/// To first order in the change of the numbers. In a comparison both recordings have the same base: what changed is known better than that.
///
/// # Source
/// Tapley, Schutz, Born (2004), *Statistical Orbit Determination*, ch. 6 (consider covariance analysis).
///
/// # Errors
/// Whatever a replay refuses.
pub fn covariance(
    machine: &Machine,
    fit: &Fit,
    experiments: &[Experiment],
    floor: &Floor,
) -> Result<Option<DMatrix<f64>>> {
    let description = machine.description();
    let masses: Vec<f64> =
        description.base.iter().flat_map(|base| &base.mode).map(|mode| mode.mass_kg()).collect();
    if masses.is_empty() || fit.values.is_empty() {
        return Ok(None);
    }
    let (fitted, sigma) = (fit.machine(machine)?, 0.5 * description.tolerance.mass);
    let heavier = |(k, mass): (usize, &f64)| {
        let (path, mass) = (format!("base.mode.{k}.mass_kg"), toml::Value::Float(mass * (1.0 + sigma)));
        fitted.with_settings([(path.as_str(), mass)])
    };
    let machines: Vec<Machine> = masses.iter().enumerate().map(heavier).collect::<Result<_>>()?;
    let linear = Linearised::of(machine, fit, experiments, floor)?;
    let count = fit.values.len();
    let mut added = DMatrix::zeros(count, count);
    for residuals in linear.objective.residuals_at(&machines)? {
        let step = linear.step(&(residuals - &linear.residuals));
        added += &step * step.transpose();
    }
    Ok(Some(added))
}
