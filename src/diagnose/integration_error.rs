//! What the steps of the plant put into the numbers of a fit.

use super::linearised::Linearised;
use crate::error::Result;
use crate::machine::Machine;
use crate::plant::axis::{LONGEST_STEP_S, longest_step};
use nalgebra::{DMatrix, DVector};

/// The error of a step h beside what halving it changes, where it is c·h² as [`LONGEST_STEP_S`] has it: c·h²/(c·h² − c·h²/4).
const OF_HALVING: f64 = 4.0 / 3.0;

/// Covariance that the error of the plant's steps adds to that of a fit's numbers, in units of their scales.
///
/// # Model
/// The axis is exact but for forces that depend on its motion inside a step. With r(h) the residuals in steps h, Δ of [`Linearised::step`]:
/// ```text
///   b = 4/3·Δ(r(h/2) − r(h)),   added covariance = b·bᵀ
/// ```
/// b is what the numbers are off by, without sign: it counts as one standard deviation. Mass, friction and motor constant that grow by the same share move the axis alike but for its base: to that combination an error that is far
/// below the noise of a sample is several standard errors.
///
/// # Validity
/// To first order in the change of the numbers, and where the error falls with the square of the step. The values stay: what they predict, they predict in
/// the steps that they were fitted in.
///
/// # Source
/// L. F. Richardson (1911), *The approximate arithmetical solution by finite differences*, Phil. Trans. R. Soc. A 210:307.
///
/// # Errors
/// Whatever a replay refuses.
pub fn covariance(linear: &Linearised, fitted: &Machine) -> Result<DMatrix<f64>> {
    let period_s = linear.objective.machine.constants().sample_period_s;
    let half_s = 0.5 * longest_step(period_s, LONGEST_STEP_S);
    let finer = linear.objective.in_steps(half_s).residuals_at(std::slice::from_ref(fitted))?.remove(0);
    let bias: DVector<f64> = linear.step(&(finer - &linear.residuals)) * OF_HALVING;
    Ok(&bias * bias.transpose())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::care::Care;
    use crate::diagnose::descent::InitialGuess;
    use crate::diagnose::experiment::Experiment;
    use crate::diagnose::fit::Fit;
    use crate::diagnose::long_steps::descend_from;
    use crate::diagnose::long_steps::tests::{bristles, slow, to_and_fro};
    use crate::diagnose::noise::Floor;
    use crate::diagnose::objective::Objective;
    use crate::replay::recording::recorded;

    /// Bristles of a log that was made in steps a sixteenth as long: what the fit misses them by is what is added to their standard errors.
    #[test]
    fn exact_the_error_of_the_steps_is_known_to_the_intervals() {
        let machine = slow();
        let hypothesis = bristles();
        let truth = [60.0, 4e7];
        let real = hypothesis.machine(&machine, &truth).unwrap();
        let (reference, traces) = to_and_fro(&real);
        let coarse =
            Experiment::new(&recorded("run", &machine, &reference, traces).unwrap(), &machine).unwrap();
        let fine =
            coarse.predict_together(std::slice::from_ref(&real), LONGEST_STEP_S / 16.0).unwrap().remove(0);
        let run = Experiment::new(&recorded("run", &machine, &reference, fine).unwrap(), &machine).unwrap();
        let floor = Floor::estimate(&machine, &[&run]).unwrap();
        let runs = [run];
        let objective = Objective::new(&machine, &hypothesis, &runs, &floor);
        let start = InitialGuess::at(&objective, truth.to_vec()).unwrap();
        let values = descend_from(&objective, start, Care::Thorough, 60).unwrap().values;
        let fit = Fit {
            hypothesis: hypothesis.clone(),
            values,
            size: 0.0,
            mean_square: 0.0,
            standard_errors: Vec::new(),
            covariance: DMatrix::zeros(2, 2),
            shown: hypothesis.effects.clone(),
        };
        let linear = Linearised::of(&machine, &fit, &runs, &floor).unwrap();
        let added = covariance(&linear, &fit.machine(&machine).unwrap()).unwrap();
        for (k, true_value) in truth.iter().enumerate() {
            let missed = (fit.values[k] - true_value).abs() / fit.hypothesis.free[k].scale;
            let ratio = missed / added[(k, k)].sqrt();
            // Reversals inside a step leave terms of another order than the second: a third of the error at most here.
            assert!(missed > 0.0 && (0.7..1.4).contains(&ratio), "{k}: {missed:e} {ratio}");
        }
    }
}
