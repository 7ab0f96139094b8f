//! Linear least squares with intervals, by orthogonal decomposition.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::check;
use super::excitation::{Excitation, NotExcited, Outcome, scale_columns};
use crate::error::{Error, ErrorKind, Result};

/// Samples that each parameter must be able to lean on.
pub const LEAST_SAMPLES_PER_PARAMETER: usize = 5;
/// Probability that a stated interval covers.
pub const COVERAGE: f64 = 0.95;

/// 97.5 % quantile of the normal distribution.
const NORMAL_975: f64 = 1.959_964;

/// A number found from data, with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The most likely value.
    pub value: f64,
    /// One standard deviation of it.
    pub standard_error: f64,
    /// Lower and upper end of the 95 % interval.
    pub ci95: [f64; 2],
}

impl Estimate {
    /// From value and standard error, with the quantile that the degrees of freedom ask for.
    pub(super) fn new(value: f64, standard_error: f64, quantile: f64) -> Self {
        let half = quantile * standard_error;
        Self { value, standard_error, ci95: [value - half, value + half] }
    }

    /// From value and standard error, of so many samples that the error is normal: 1.96 standard errors to either side.
    pub(crate) fn of_many(value: f64, standard_error: f64) -> Self {
        Self::new(value, standard_error, NORMAL_975)
    }

    /// A value without an error.
    pub(crate) fn exact(value: f64) -> Self {
        Self { value, standard_error: 0.0, ci95: [value; 2] }
    }

    /// In another unit, by a factor > 0.
    pub(crate) fn times(&self, factor: f64) -> Self {
        let ci95 = self.ci95.map(|end| end * factor);
        Self { value: self.value * factor, standard_error: self.standard_error * factor, ci95 }
    }

    /// Whether the 95 % interval holds `truth`.
    pub fn covers(&self, truth: f64) -> bool {
        (self.ci95[0]..=self.ci95[1]).contains(&truth)
    }
}

/// A regressor with named columns and what it is to explain.
#[derive(Debug, Clone)]
pub struct Regression {
    /// Name of each column.
    pub names: Vec<String>,
    /// One row a sample, one column a parameter.
    pub regressor: DMatrix<f64>,
    /// The right-hand side, one entry a row.
    pub target: DVector<f64>,
}

/// The solution of a [`Regression`].
///
/// # Model
/// y = Φθ + e, θ = argmin ‖y − Φθ‖², s² = ‖y − Φθ‖²/(N − n), cov θ = s² (ΦᵀΦ)⁻¹;
/// 95 % interval by Student's t with N − n degrees of freedom.
///
/// # Validity
/// The covariance holds for white e that is independent of its row of Φ.
#[derive(Debug, Clone)]
pub struct LeastSquares {
    /// One a column.
    pub estimates: Vec<Estimate>,
    /// Covariance of the parameters.
    pub covariance: DMatrix<f64>,
    /// y − Φθ, one a row.
    pub residuals: Vec<f64>,
    /// s, the standard deviation of the residual.
    pub residual_sd: f64,
    /// N − n.
    pub degrees_of_freedom: usize,
    /// Condition number of the column-scaled regressor.
    pub condition: f64,
}

impl Regression {
    /// Solves by Householder QR of the column-scaled regressor, unless the regressor leaves a direction open.
    ///
    /// # Errors
    /// Numbers that are not finite; fewer than five rows a column.
    pub fn solve(&self, remedy: &str) -> Result<Outcome<LeastSquares>> {
        let (rows, columns) = self.regressor.shape();
        check::enough_rows(rows, LEAST_SAMPLES_PER_PARAMETER * columns, columns)?;
        check::finite("regressor", self.regressor.as_slice())?;
        check::finite("target", self.target.as_slice())?;
        let (scaled, lengths) = scale_columns(&self.regressor);
        let qr = scaled.qr();
        let triangle = qr.r();
        let excitation = Excitation::of_triangle(triangle.clone())?;
        if !excitation.is_full_rank() {
            return Ok(Outcome::NotExcited(self.refusal(&excitation, remedy)));
        }
        let mut rotated = self.target.clone();
        qr.q_tr_mul(&mut rotated);
        let singular =
            || Error::new(ErrorKind::Undetermined).found("a regressor without full rank").remedy(remedy);
        let scaled_solution =
            triangle.solve_upper_triangular(&rotated.rows(0, columns).into_owned()).ok_or_else(singular)?;
        let inverse =
            triangle.solve_upper_triangular(&DMatrix::identity(columns, columns)).ok_or_else(singular)?;
        let scale = DVector::from_iterator(columns, lengths.iter().map(|length| 1.0 / length));
        let solution = scaled_solution.component_mul(&scale);
        let inverse = DMatrix::from_diagonal(&scale) * inverse;
        self.with_intervals(&solution, &inverse, excitation.condition()).map(Outcome::Identified)
    }

    /// `inverse` is R⁻¹ in the units of the parameters, so that (ΦᵀΦ)⁻¹ = R⁻¹R⁻ᵀ.
    fn with_intervals(
        &self,
        solution: &DVector<f64>,
        inverse: &DMatrix<f64>,
        condition: f64,
    ) -> Result<LeastSquares> {
        let residuals = &self.target - &self.regressor * solution;
        let degrees_of_freedom = self.regressor.nrows() - self.regressor.ncols();
        let residual_sd = residuals.norm() / (degrees_of_freedom as f64).sqrt();
        let covariance = inverse * inverse.transpose() * residual_sd.powi(2);
        let quantile = student_quantile(degrees_of_freedom)?;
        let estimates = solution
            .iter()
            .zip(covariance.diagonal().iter())
            .map(|(value, variance)| Estimate::new(*value, variance.sqrt(), quantile))
            .collect();
        let residuals = residuals.iter().copied().collect();
        Ok(LeastSquares { estimates, covariance, residuals, residual_sd, degrees_of_freedom, condition })
    }

    /// The solution with intervals that hold where the residual is autocorrelated or its size varies; `lengths` are the
    /// rows of each run, over whose ends nothing is correlated.
    ///
    /// # Model
    /// cov θ = (ΦᵀΦ)⁻¹·S·(ΦᵀΦ)⁻¹, S = Σ_l w_l Σ_k e_k·e_{k+l}·φ_k·φ_{k+l}ᵀ over the lags |l| ≤ L with Bartlett's weights
    /// w_l = 1 − |l|/(L + 1), L = 4·(N/100)^(2/9) and at least 4.
    ///
    /// # Validity
    /// L beyond the memory of the residual. A bias (noise in a regressor) is not seen.
    ///
    /// # Source
    /// Newey, West, A simple, positive semi-definite, heteroskedasticity and autocorrelation consistent covariance
    /// matrix, Econometrica 55, 1987; the lag after Newey, West, Review of Economic Studies 61, 1994.
    ///
    /// # Errors
    /// None in practice: the degrees of freedom are those of a solved regression.
    pub fn with_correlated_residual(
        &self,
        solution: &LeastSquares,
        lengths: &[usize],
    ) -> Result<LeastSquares> {
        let (rows, columns) = self.regressor.shape();
        let reach = (4.0 * (rows as f64 / 100.0).powf(2.0 / 9.0)).floor().max(4.0) as usize;
        let scores = DMatrix::from_fn(columns, rows, |j, k| self.regressor[(k, j)] * solution.residuals[k]);
        let mut middle = DMatrix::zeros(columns, columns);
        let mut start = 0;
        for &length in lengths {
            for lag in 0..=reach.min(length.saturating_sub(1)) {
                let weight = 1.0 - lag as f64 / (reach as f64 + 1.0);
                let (early, late) =
                    (scores.columns(start, length - lag), scores.columns(start + lag, length - lag));
                let product = late * early.transpose() * weight;
                if lag > 0 {
                    middle += product.transpose();
                }
                middle += product;
            }
            start += length;
        }
        let bread = &solution.covariance / solution.residual_sd.powi(2).max(f64::MIN_POSITIVE);
        let covariance = &bread * middle * &bread;
        let quantile = student_quantile(solution.degrees_of_freedom)?;
        let variances = covariance.diagonal();
        let estimates = solution
            .estimates
            .iter()
            .zip(variances.iter())
            .map(|(e, variance)| Estimate::new(e.value, variance.max(0.0).sqrt(), quantile))
            .collect();
        Ok(LeastSquares { estimates, covariance, ..solution.clone() })
    }

    fn refusal(&self, excitation: &Excitation, remedy: &str) -> NotExcited {
        excitation.refusal(&self.names, remedy)
    }
}

/// The number of standard errors to either side that a 95 % interval reaches.
pub(super) fn student_quantile(degrees_of_freedom: usize) -> Result<f64> {
    let student = StudentsT::new(0.0, 1.0, degrees_of_freedom as f64).map_err(|error| {
        Error::new(ErrorKind::TooLittleData)
            .found(format!("{degrees_of_freedom} degrees of freedom ({error})"))
            .expected("at least one")
            .remedy("record longer runs or ask for lower orders")
    })?;
    Ok(student.inverse_cdf(0.5 * (1.0 + COVERAGE)))
}
