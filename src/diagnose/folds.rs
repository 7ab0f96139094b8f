//! Each training run left out in turn: what the others say of it, and how far that differs from run to run.

use super::evidence::{Score, closed_power};
use super::experiment::Training;
use super::fit::{Care, Fit, fit};
use super::noise::Floor;
use super::thresholds::ADEQUATE_GAP;
use crate::error::Result;
use crate::machine::Machine;
use rayon::prelude::*;

/// A hypothesis fitted without each training run in turn.
#[derive(Debug, Clone)]
pub struct Folds {
    /// The fits; of a single training run, the one to it.
    pub fits: Vec<Fit>,
}

/// A quantity of a fit, with its uncertainty.
#[derive(Debug, Clone, Copy)]
pub struct Uncertain {
    /// Its value.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
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
    /// Fits a hypothesis again without each training run in turn.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub fn of(machine: &Machine, chosen: &Fit, training: &Training, floor: &Floor) -> Result<Self> {
        let fold = |left_out: usize| match training.leaving_out(left_out) {
            None => Ok(chosen.clone()),
            Some((rest, _)) => {
                fit(machine, &chosen.hypothesis, &rest, floor, Some(&chosen.values), Care::Thorough)
            }
        };
        let fits: Result<Vec<Fit>> = (0..training.runs().len()).into_par_iter().map(fold).collect();
        Ok(Self { fits: fits? })
    }

    /// Closed share that they predict for the runs left out. A single training run can only predict itself.
    ///
    /// The twin as it is is judged by the common noise floor, the hypothesis by its own.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub fn predicted_closed(
        &self,
        machine: &Machine,
        training: &Training,
        [common, own]: [&Floor; 2],
    ) -> Result<f64> {
        let judged = |(left_out, fit): (usize, &Fit)| -> Result<[f64; 2]> {
            let judge = match training.leaving_out(left_out) {
                None => training.resubstituted(),
                Some((_, judge)) => judge,
            };
            let before = Score::of(machine, &judge, common)?.mean_square();
            Ok([before, Score::of(&fit.machine(machine)?, &judge, own)?.mean_square()])
        };
        let squares: Vec<[f64; 2]> = self.fits.par_iter().enumerate().map(judged).collect::<Result<_>>()?;
        let mean = |k: usize| squares.iter().map(|squares| squares[k]).sum::<f64>() / squares.len() as f64;
        let is_gap = mean(0).sqrt() > ADEQUATE_GAP;
        Ok(if is_gap { closed_power(mean(0), mean(1)) } else { 0.0 })
    }

    /// Standard errors of a fit's values: its own, or those of the scatter where they are larger.
    pub fn widened(&self, fit: &Fit) -> Vec<f64> {
        let wide = |k: usize| {
            let of = |fit: &Fit| Uncertain { value: fit.values[k], standard_error: fit.standard_errors[k] };
            fit.standard_errors[k].max(self.scatter(of(fit), &of).unwrap_or(0.0))
        };
        (0..fit.values.len()).map(wide).collect()
    }

    /// Standard error of a quantity by how far runs disagree about it, times what Student's t has over the normal distribution for so
    /// few runs; none below [`LEAST_RUNS`].
    ///
    /// # Model
    /// With θ₍ᵢ₎ ± s₍ᵢ₎ without run i of n, and θ ± s of all, the jackknife's variance is (n − 1)/n · Σ (θ₍ᵢ₎ − θ)². Unlike an interval
    /// from the residuals of one fit, it also knows what a law that is only nearly right puts into a number, as far as that differs from
    /// run to run. Runs that agree leave θ₍ᵢ₎ − θ a variance of s₍ᵢ₎² − s², which is s²/(n − 1) where all tell the same: where run i tells more, what the
    /// others say without it differs for want of data, and counts by the ratio of the two.
    ///
    /// # Validity
    /// s and s₍ᵢ₎ are sandwich errors, of fits that are not efficient where residuals are correlated: then s₍ᵢ₎² − s² is only about that
    /// variance. A weight is never more than one, so that the jackknife's own error is the most that comes out.
    ///
    /// # Source
    /// B. Efron, *The Jackknife, the Bootstrap and Other Resampling Plans*, SIAM 1982, chapter 3. The variance of the difference of an
    /// estimate and an efficient one: J. A. Hausman (1978), *Specification tests in econometrics*, Econometrica 46:1251.
    pub fn scatter(&self, whole: Uncertain, of: &dyn Fn(&Fit) -> Uncertain) -> Option<f64> {
        let runs = self.fits.len() as f64;
        if self.fits.len() < LEAST_RUNS {
            return None;
        }
        let usual = whole.standard_error.powi(2) / (runs - 1.0);
        let squares = self.fits.iter().map(|fit| {
            let fold = of(fit);
            let own = fold.standard_error.powi(2) - whole.standard_error.powi(2);
            let weight = if own > usual { usual / own } else { 1.0 };
            weight * (fold.value - whole.value).powi(2)
        });
        Some(student(self.fits.len() - 1) * ((runs - 1.0) / runs * squares.sum::<f64>()).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::found::tests::{COULOMB, candidate};

    /// A fit of one number.
    fn one(value: f64, standard_error: f64) -> Fit {
        let fit = candidate(&[COULOMB], value, 1.0).fit;
        Fit { standard_errors: vec![standard_error], ..fit }
    }

    fn folds(fits: Vec<Fit>) -> Folds {
        Folds { fits }
    }

    /// Of a mean, the jackknife's standard error is the textbook one: s/√n.
    #[test]
    fn exact_jackknife_of_a_mean_is_its_standard_error() {
        let sample = [1.0, 4.0, 2.0, 9.0];
        let total: f64 = sample.iter().sum();
        let variance = sample.iter().map(|x| (x - total / 4.0_f64).powi(2)).sum::<f64>() / 3.0;
        let error = (variance / 4.0).sqrt();
        let without = |x: &f64| one((total - x) / 3.0, error * (4.0_f64 / 3.0).sqrt());
        let folds = folds(sample.iter().map(without).collect());
        let widened = |own: f64| folds.widened(&one(total / 4.0, own))[0];
        assert!((widened(error) - student(3) * error).abs() < 1e-12);
        // Whichever is larger: that of the residuals, or that of the scatter.
        assert_eq!(widened(100.0), 100.0);
    }

    /// Of three runs one tells nearly all: what the others say without it is as far off as they are uncertain, and is no disagreement.
    /// The same distance beside a small uncertainty is one.
    #[test]
    fn exact_what_is_uncertain_for_want_of_data_is_no_disagreement() {
        let widened = |alone: f64| {
            let fits = vec![one(1.0, 0.1), one(1.0, 0.1), one(3.0, alone)];
            folds(fits).widened(&one(1.0, 0.1))[0]
        };
        let plain = student(2) * (2.0_f64 / 3.0 * 4.0).sqrt();
        assert!((widened(0.1) - plain).abs() < 1e-12);
        // Variances: 0.01/2 is usual, 4 − 0.01 is what is lacking.
        assert!((widened(2.0) - plain * (0.005_f64 / 3.99).sqrt()).abs() < 1e-12);
        assert_eq!(widened(4.0), 0.1);
    }

    #[test]
    fn exact_quantiles_go_on_where_the_table_ends() {
        // 2.201 and 2.086 over 1.960.
        assert!((student(11) - 1.1230).abs() < 2e-3 && (student(20) - 1.0643).abs() < 2e-3);
        assert!((student(10) - (1.0 + 0.121 + 0.014)).abs() < 3e-3);
    }

    #[test]
    fn exact_two_runs_have_no_scatter() {
        let folds = folds(vec![one(1.0, 0.1), one(2.0, 0.1)]);
        assert_eq!(folds.widened(&one(1.5, 0.1)), [0.1]);
    }
}
