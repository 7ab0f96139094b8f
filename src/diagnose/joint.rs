//! The numbers of a hypothesis where a fit to training and held-out runs together leaves them.

use super::care::Care;
use super::descent::{InitialGuess, descend};
use super::evidence::{Score, predictions};
use super::experiment::Experiment;
use super::fit::Fit;
use super::noise::Floor;
use super::objective::Objective;
use super::predictive_weights::{squares, weights};
use crate::error::Result;
use crate::machine::Machine;
use nalgebra::DVector;

/// Steps of the fit to both kinds of run at most; a choice of cost.
const STEPS: usize = 30;

/// A place to which the held-out runs move the numbers of a fit.
pub(super) struct Place {
    pub(super) values: Vec<f64>,
    /// Normalised residuals of the held-out runs there.
    pub(super) residuals: DVector<f64>,
    /// Their score.
    pub(super) score: Score,
    /// By how much the training runs and the prior are less likely there than at the fit, in nats.
    pub(super) strain: f64,
}

/// Fits the hypothesis of a fit to training runs, the first, and held-out runs together, from these values on.
///
/// # Model
/// The strain is `½·(r*ᵀWr* − r̂ᵀWr̂) + ln π(θ̂) − ln π(θ*)` with r̂ and r* the residuals of the training runs at the fit θ̂ and here, W the weights of the
/// posterior-predictive score by what is left at θ̂ ([`weights`]), and π the prior. Near θ̂ that is `½·ΔᵀC⁻¹Δ`; far from it
/// the training runs are not quadratic (two pitches over a stroke that is shorter than either), and are replayed.
///
/// # Validity
/// A local minimum, the one to which the values lead.
///
/// # Errors
/// Whatever a replay refuses.
///
/// # Source
/// L. Tierney, J. B. Kadane (1986), *Accurate approximations for posterior moments and marginal densities*, J. Amer. Statist. Assoc. 81:82: a ratio of
/// integrals by the Laplace approximation of each about its own maximum.
pub(super) fn joint(
    machine: &Machine,
    fit: &Fit,
    [training, held_out]: [&[Experiment]; 2],
    floor: &Floor,
    from: &[f64],
) -> Result<Place> {
    let both: Vec<Experiment> = training.iter().chain(held_out).cloned().collect();
    let of_both = Objective::new(machine, &fit.hypothesis, &both, floor);
    let values = descend(&of_both, InitialGuess::at(&of_both, from.to_vec())?, Care::Thorough, STEPS)?.values;

    let at = |values: &[f64], runs: &[Experiment]| -> Result<(DVector<f64>, Score)> {
        let traces = predictions(&fit.hypothesis.machine(machine, values)?, runs)?;
        let objective = Objective::new(machine, &fit.hypothesis, runs, floor);
        Ok((objective.residuals_from(&traces), Score::of_traces(runs, &traces, floor)))
    };
    let (begun, begun_score) = at(&fit.values, training)?;
    let (left, _) = at(&values, training)?;
    let of_training = Objective::new(machine, &fit.hypothesis, training, floor);
    let weights = weights(&of_training, &begun_score, &begun);
    let prior = fit.hypothesis.strain(&values) - fit.strain();
    let strain = (0.5 * (squares(&left, &weights) - squares(&begun, &weights)) + prior).max(0.0);
    let (residuals, score) = at(&values, held_out)?;
    Ok(Place { values, residuals, score, strain })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::hypothesis::EffectSet;
    use crate::diagnose::long_steps::tests::{bristles, slow, to_and_fro};
    use crate::replay::recording::recorded;
    use nalgebra::DMatrix;

    /// Of friction and bristles that made both runs it ends at their numbers, from others; the strain is what the training runs lose against a fit to them, and nothing
    /// against one that leaves more of them.
    #[test]
    fn exact_a_fit_to_both_kinds_of_run_ends_at_the_numbers_of_both() {
        let (machine, hypothesis, truth) = (slow(), bristles(), [60.0, 4e7]);
        let real = hypothesis.machine(&machine, &truth).unwrap();
        let (reference, traces) = to_and_fro(&real);
        let run = recorded("run", &machine, &reference, traces).unwrap();
        let runs = [Experiment::new(&run, &machine).unwrap()];
        let floor = Floor::estimate(&machine, &[&runs[0]]).unwrap();
        let fit_at = |values: [f64; 2]| Fit {
            hypothesis: hypothesis.clone(),
            values: values.to_vec(),
            size: 0.0,
            mean_square: 0.0,
            standard_errors: vec![0.0; 2],
            covariance: DMatrix::zeros(2, 2),
            shown: EffectSet::new(),
        };
        let ends = |fit: [f64; 2], from: [f64; 2]| {
            let end = joint(&machine, &fit_at(fit), [&runs, &runs], &floor, &from).unwrap();
            let off = end.values.iter().zip(truth).map(|(v, t)| (v / t - 1.0).abs()).fold(0.0, f64::max);
            (off, end.strain, end.score.gap())
        };
        let (off, strain, gap) = ends(truth, [58.0, 1e7]);
        assert!(off < 1e-3 && strain < 0.1 && gap < 0.1, "{off} {strain} {gap}");
        let (off, strain, _) = ends([57.0, 1e7], [58.0, 1e7]);
        assert!(off < 1e-3 && strain == 0.0, "{off} {strain}");
    }
}
