//! Each training run left out in turn: what the others say of it, and how far that differs from run to run.

use super::evidence::{LEAST_EXCESS, Score};
use super::experiment::Training;
use super::fit::{Care, Fit, fit};
use super::noise::Floor;
use crate::error::Result;
use crate::machine::Machine;
use rayon::prelude::*;

/// What fits to all training runs but one come to.
pub struct Folds {
    /// Closed share that they predict for the runs left out. A single training run can only predict itself.
    pub predicted_closed: f64,
    /// The hypothesis' numbers without each training run in turn.
    pub values: Vec<Vec<f64>>,
}

/// Fewer runs leave no scatter to speak of.
const LEAST_RUNS: usize = 3;
/// 97.5 % quantiles of Student's t with 2, 3, … degrees of freedom ν, over that of the normal distribution; beyond the last one
/// 1 + 1.21/ν + 1.4/ν² is right to a thousandth.
const STUDENT: [f64; 9] = [2.195, 1.624, 1.417, 1.312, 1.248, 1.207, 1.177, 1.154, 1.137];

fn student(freedom: usize) -> f64 {
    let per = 1.0 / freedom as f64;
    freedom.checked_sub(2).and_then(|k| STUDENT.get(k)).map_or(1.0 + 1.21 * per + 1.4 * per * per, |t| *t)
}

impl Folds {
    /// Fits the hypothesis again without each training run in turn.
    ///
    /// # Model
    /// With θ₍ᵢ₎ fitted without run i of n, the jackknife's variance is (n − 1)/n · Σ (θ₍ᵢ₎ − θ̄)². Unlike an interval from the
    /// residuals of one fit, it also knows what a law that is only nearly right puts into a number, as far as that differs
    /// from run to run.
    ///
    /// # Source
    /// B. Efron, *The Jackknife, the Bootstrap and Other Resampling Plans*, SIAM 1982, chapter 3.
    ///
    /// The twin as it is is judged by the common noise floor, the hypothesis by its own.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub fn of(
        machine: &Machine,
        chosen: &Fit,
        training: &Training,
        [common, own]: [&Floor; 2],
    ) -> Result<Self> {
        let fold = |left_out: usize| -> Result<(Vec<f64>, [f64; 2])> {
            let (values, judge) = match training.leaving_out(left_out) {
                None => (chosen.values.clone(), training.resubstituted()),
                Some((rest, judge)) => {
                    let warm = Some(chosen.values.as_slice());
                    let fitted = fit(machine, &chosen.hypothesis, &rest, common, warm, Care::Thorough)?;
                    (fitted.values, judge)
                }
            };
            let before = Score::of(machine, &judge, common)?.mean_square();
            let after = Score::of(&chosen.hypothesis.machine(machine, &values)?, &judge, own)?.mean_square();
            Ok((values, [before, after]))
        };
        let runs = 0..training.runs().len();
        let folds: Vec<(Vec<f64>, [f64; 2])> = runs.into_par_iter().map(fold).collect::<Result<_>>()?;
        let mean = |k: usize| folds.iter().map(|(_, squares)| squares[k]).sum::<f64>() / folds.len() as f64;
        let excess = mean(0) - 1.0;
        let closed = (1.0 - (mean(1) - 1.0) / excess).min(1.0);
        let predicted_closed = if excess > LEAST_EXCESS { closed } else { 0.0 };
        Ok(Self { predicted_closed, values: folds.into_iter().map(|(values, _)| values).collect() })
    }

    /// The larger of the standard errors given and those of the scatter.
    pub fn widened(&self, standard_errors: &[f64]) -> Vec<f64> {
        let wide = |(k, own): (usize, &f64)| own.max(self.scatter(&|values| values[k]).unwrap_or(0.0));
        standard_errors.iter().enumerate().map(wide).collect()
    }

    /// Standard error of a quantity by the jackknife, times what Student's t has over the normal distribution for so few
    /// runs; none below [`LEAST_RUNS`].
    pub fn scatter(&self, of: &dyn Fn(&[f64]) -> f64) -> Option<f64> {
        let runs = self.values.len();
        if runs < LEAST_RUNS {
            return None;
        }
        let all: Vec<f64> = self.values.iter().map(|values| of(values)).collect();
        let mean = all.iter().sum::<f64>() / runs as f64;
        let squares: f64 = all.iter().map(|value| (value - mean).powi(2)).sum();
        Some(student(runs - 1) * ((runs as f64 - 1.0) / runs as f64 * squares).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a mean, the jackknife's standard error is the textbook one: s/√n.
    #[test]
    fn exact_jackknife_of_a_mean_is_its_standard_error() {
        let sample = [1.0, 4.0, 2.0, 9.0];
        let total: f64 = sample.iter().sum();
        let values = sample.iter().map(|left_out| vec![(total - left_out) / 3.0, 7.0]).collect();
        let folds = Folds { predicted_closed: 1.0, values };
        let variance = sample.iter().map(|x| (x - total / 4.0_f64).powi(2)).sum::<f64>() / 3.0;
        let own = folds.scatter(&|values| values[0]).unwrap();
        assert!((own - student(3) * (variance / 4.0).sqrt()).abs() < 1e-12);
        // Whichever is larger: that of the residuals, or that of the scatter.
        assert_eq!(folds.widened(&[0.1, 0.3]), [own, 0.3]);
    }

    #[test]
    fn exact_quantiles_go_on_where_the_table_ends() {
        // 2.201 and 2.086 over 1.960.
        assert!((student(11) - 1.1230).abs() < 2e-3 && (student(20) - 1.0643).abs() < 2e-3);
        assert!((student(10) - (1.0 + 0.121 + 0.014)).abs() < 3e-3);
    }

    #[test]
    fn exact_two_runs_have_no_scatter() {
        let folds = Folds { predicted_closed: 1.0, values: vec![vec![1.0], vec![2.0]] };
        assert_eq!((folds.scatter(&|values| values[0]), folds.widened(&[0.1])), (None, vec![0.1]));
    }
}
