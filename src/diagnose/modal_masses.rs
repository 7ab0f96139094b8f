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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::long_steps::tests::{bristles, slow, to_and_fro};
    use crate::machine::shipped;
    use crate::replay::recording::recorded;

    /// Friction and bristles at these values, and the log of a machine to which they belong.
    fn at(machine: &Machine, real: &Machine, truth: [f64; 2]) -> (Fit, Vec<Experiment>, Floor) {
        let hypothesis = bristles();
        let (reference, traces) = to_and_fro(real);
        let run = recorded("run", machine, &reference, traces).unwrap();
        let runs = vec![Experiment::new(&run, machine).unwrap()];
        let floor = Floor::estimate(machine, &runs.iter().collect::<Vec<_>>()).unwrap();
        let values = truth.to_vec();
        let shown = hypothesis.effects.clone();
        let covariance = DMatrix::zeros(2, 2);
        let fit = Fit {
            hypothesis,
            values,
            size: 0.0,
            mean_square: 0.0,
            standard_errors: Vec::new(),
            covariance,
            shown,
        };
        (fit, runs, floor)
    }

    /// By what logs of machines, of which one modal mass after the other is heavier by half its tolerance, move the numbers adds up, in squares, to the covariance.
    #[test]
    fn exact_heavier_modes_move_the_numbers_by_what_is_added() {
        let has_base = |machine: &Machine| !machine.constants().modes.is_empty();
        let stated = shipped().find(has_base).unwrap();
        // Of a sensor that is a thousand times finer the recoil of the base shows in one short run.
        let noise_m = toml::Value::Float(1e-3 * stated.description().encoder.noise_m);
        let machine = stated.with_settings([("encoder.noise_m", noise_m)]).unwrap();
        let truth = [60.0, 4e7];
        let real = bristles().machine(&machine, &truth).unwrap();
        let (fit, runs, floor) = at(&machine, &real, truth);
        let added = covariance(&machine, &fit, &runs, &floor).unwrap().unwrap();
        let sigma = 0.5 * machine.description().tolerance.mass;
        let mut squares = [0.0; 2];
        for k in 0..machine.constants().modes.len() {
            let path = format!("base.mode.{k}.mass_kg");
            let mass = machine.number(&path).unwrap();
            let heavier =
                real.with_settings([(path.as_str(), toml::Value::Float(mass * (1.0 + sigma)))]).unwrap();
            let (_, log, _) = at(&machine, &heavier, truth);
            let of_log = Linearised::of(&machine, &fit, &log, &floor).unwrap();
            let moved = of_log.step(&of_log.residuals);
            squares.iter_mut().enumerate().for_each(|(j, square)| *square += moved[j].powi(2));
        }
        for (j, square) in squares.iter().enumerate() {
            let ratio = (square / added[(j, j)]).sqrt();
            // To first order in σ, 1.5 %.
            assert!(*square > 0.0 && (0.9..1.1).contains(&ratio), "{j}: {ratio}");
        }
    }

    #[test]
    fn exact_without_a_base_nothing_is_added() {
        let machine = slow();
        assert!(machine.constants().modes.is_empty());
        let truth = [60.0, 4e7];
        let (fit, runs, floor) = at(&machine, &bristles().machine(&machine, &truth).unwrap(), truth);
        assert_eq!(covariance(&machine, &fit, &runs, &floor).unwrap(), None);
    }
}
