//! Each training run left out in turn: what the others say of it, and how far that differs from run to run.

use super::evidence::{LEAST_EXCESS, Score};
use super::experiment::Experiment;
use super::fit::{Care, Fit, fit};
use super::noise::Floor;
use crate::error::Result;
use crate::machine::Machine;

/// What fits to all training runs but one come to.
pub struct Folds {
    /// Closed share that they predict for the runs left out. A single training run can only predict itself.
    pub predicted_closed: f64,
    /// Standard errors that their scatter gives the hypothesis' numbers, as wide as so few runs make a 95 % interval; none
    /// below [`LEAST_RUNS`].
    pub scatter: Option<Vec<f64>>,
}

/// Fewer runs leave no scatter to speak of.
const LEAST_RUNS: usize = 3;
/// 97.5 % quantiles of Student's t with 2, 3, … degrees of freedom, over that of the normal distribution.
const STUDENT: [f64; 9] = [2.195, 1.624, 1.417, 1.312, 1.248, 1.207, 1.176, 1.154, 1.137];

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
    /// # Errors
    /// Whatever a replay refuses.
    pub fn of(machine: &Machine, chosen: &Fit, training: &[Experiment], floor: &Floor) -> Result<Self> {
        let (mut before, mut after) = (0.0, 0.0);
        let mut fits: Vec<Vec<f64>> = Vec::new();
        for left_out in 0..training.len() {
            let test = &training[left_out..=left_out];
            let rest = [&training[..left_out], &training[left_out + 1..]].concat();
            let values = if rest.is_empty() {
                chosen.values.clone()
            } else {
                let warm = Some(chosen.values.as_slice());
                fit(machine, &chosen.hypothesis, &rest, floor, warm, Care::Thorough)?.values
            };
            before += Score::of(machine, test, floor)?.mean_square();
            after += Score::of(&chosen.hypothesis.machine(machine, &values)?, test, floor)?.mean_square();
            fits.push(values);
        }
        let count = training.len() as f64;
        let excess = before / count - 1.0;
        let closed = (1.0 - (after / count - 1.0) / excess).min(1.0);
        let predicted_closed = if excess > LEAST_EXCESS { closed } else { 0.0 };
        Ok(Self { predicted_closed, scatter: scatter(&fits) })
    }

    /// The larger of the standard errors given and those of the scatter.
    pub fn widened(&self, standard_errors: &[f64]) -> Vec<f64> {
        match &self.scatter {
            None => standard_errors.to_vec(),
            Some(scatter) => standard_errors.iter().zip(scatter).map(|(own, jack)| own.max(*jack)).collect(),
        }
    }
}

/// Standard errors by the jackknife, times what Student's t has over the normal distribution.
fn scatter(fits: &[Vec<f64>]) -> Option<Vec<f64>> {
    let count = fits.len() as f64;
    let wider = *STUDENT.get(fits.len().checked_sub(LEAST_RUNS)?).unwrap_or(&1.0);
    let numbers = fits.first()?.len();
    let of = |k: usize| {
        let mean = fits.iter().map(|fit| fit[k]).sum::<f64>() / count;
        let squares: f64 = fits.iter().map(|fit| (fit[k] - mean).powi(2)).sum();
        wider * ((count - 1.0) / count * squares).sqrt()
    };
    Some((0..numbers).map(of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a mean, the jackknife's standard error is the textbook one: s/√n.
    #[test]
    fn exact_jackknife_of_a_mean_is_its_standard_error() {
        let sample = [1.0, 4.0, 2.0, 9.0];
        let total: f64 = sample.iter().sum();
        let fits: Vec<Vec<f64>> = sample.iter().map(|left_out| vec![(total - left_out) / 3.0, 7.0]).collect();
        let own = scatter(&fits).unwrap();
        let variance = sample.iter().map(|x| (x - total / 4.0_f64).powi(2)).sum::<f64>() / 3.0;
        assert!((own[0] - STUDENT[1] * (variance / 4.0).sqrt()).abs() < 1e-12);
        assert_eq!(own[1], 0.0);
    }

    #[test]
    fn exact_two_runs_have_no_scatter_and_the_larger_error_counts() {
        assert_eq!(scatter(&[vec![1.0], vec![2.0]]), None);
        let folds = Folds { predicted_closed: 1.0, scatter: Some(vec![2.0, 0.5]) };
        assert_eq!(folds.widened(&[1.0, 1.0]), [2.0, 1.0]);
        assert_eq!(Folds { scatter: None, ..folds }.widened(&[1.0, 1.0]), [1.0, 1.0]);
    }
}
