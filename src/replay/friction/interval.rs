//! How uncertain the numbers are: residuals of a closed loop are not independent of each other.

use super::subject::{DRAWS, Subject};
use crate::error::{Error, ErrorKind, Result};
use crate::identify::nonlinear::Solution;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Samples whose residuals are taken to depend on each other lie within this time, in s.
const MEMORY_S: f64 = 0.02;
/// Upper end of a two-sided interval of 95 %.
const UPPER: f64 = 0.975;

/// Standard errors of a solution, and what they rest on.
pub(super) struct Spread {
    pub(super) standard_errors: Vec<f64>,
    /// Standard errors to each side that a 95 % interval reaches.
    pub(super) quantile: f64,
    /// Independent samples that would tell each number as well.
    pub(super) effective_samples: Vec<f64>,
    /// Residuals over what the stated noise makes of them, root mean square; none where no noise is stated.
    pub(super) misfit: Option<f64>,
}

/// Standard errors that allow for autocorrelation.
///
/// # Model
/// With H = JᵀJ the estimate answers noise e with δθ = H⁻¹Jᵀe. Two estimates of its covariance are formed and the larger
/// variance of each number is taken:
/// - H⁻¹·S·H⁻¹, S = Σ_l w_l Σ_k g_k·g_{k+l}ᵀ over lags l up to 20 ms with w_l = 1 − |l|/(L + 1), g_k the sum over both
///   signals of J_kᵀ·r_k: from the residuals themselves (Newey and West);
/// - the mean of δθ·δθᵀ over draws of the sensors' stated noise through the twin's closed loop, times what the residuals
///   have more of mean square than those draws: it knows correlations that outlast the run.
///
/// To that the square of δθ under the difference between rigid-body scene and reduced axis is added: what the reduction and
/// the steps of integration may be off.
///
/// Effective number of samples: N times the variance that independent residuals of the same mean square would give over
/// the one taken. The interval is Student's with as many degrees of freedom as there are draws.
///
/// # Validity
/// Linear about the solution: a force that noise cannot reverse. Errors of what is held fixed (mass, force constant,
/// gains) are not in it.
///
/// # Source
/// Newey, West, *Econometrica* 55 (1987) 703.
///
/// # Errors
/// A Jacobian without full rank.
pub(super) fn spread(
    solution: &Solution,
    subjects: &[Subject],
    draws: &[Vec<[Vec<f64>; 2]>],
    scene: Vec<f64>,
) -> Result<Spread> {
    let jacobian = &solution.jacobian;
    let inverse = inverse(&jacobian.tr_mul(jacobian))?;
    let count = inverse.nrows();
    let newey_west = &inverse * scores(solution, subjects) * &inverse;
    let mut drawn = DMatrix::zeros(count, count);
    let mut squares = 0.0;
    for draw in 0..DRAWS as usize {
        let noise = subjects.iter().zip(draws).flat_map(|(s, own)| s.normalised(&own[draw]));
        let noise = DVector::from_iterator(jacobian.nrows(), noise);
        squares += noise.norm_squared() / DRAWS as f64;
        let moved = &inverse * jacobian.tr_mul(&noise);
        drawn += &moved * moved.transpose() / DRAWS as f64;
    }
    let reduced = moved(solution, scene)?;
    let left = solution.residuals.norm_squared();
    let more = if squares > 0.0 { (left / squares).max(1.0) } else { 1.0 };
    let rows = jacobian.nrows() as f64;
    let independent = left / (rows - count as f64).max(1.0);
    let noise = |k: usize| newey_west[(k, k)].max(more * drawn[(k, k)]).max(0.0);
    let variance = |k: usize| noise(k) + reduced[k] * reduced[k];
    let student = StudentsT::new(0.0, 1.0, DRAWS as f64).map_err(|error| {
        Error::new(ErrorKind::Undetermined).found(error.to_string()).expected("degrees of freedom")
    })?;
    Ok(Spread {
        standard_errors: (0..count).map(|k| variance(k).sqrt()).collect(),
        quantile: student.inverse_cdf(UPPER),
        misfit: (squares > 0.0).then(|| (left / squares).sqrt()),
        effective_samples: (0..count)
            .map(|k| rows * (independent * inverse[(k, k)] / noise(k).max(f64::MIN_POSITIVE)).min(1.0))
            .collect(),
    })
}

/// By how much the numbers move where residuals change by so much: −H⁻¹Jᵀ·change.
pub(super) fn moved(solution: &Solution, change: Vec<f64>) -> Result<DVector<f64>> {
    let inverse = inverse(&solution.jacobian.tr_mul(&solution.jacobian))?;
    Ok(-(inverse * solution.jacobian.tr_mul(&DVector::from_vec(change))))
}

/// Inverse of a normal matrix whose numbers are of very different size.
fn inverse(normal: &DMatrix<f64>) -> Result<DMatrix<f64>> {
    let scale = DMatrix::from_diagonal(&normal.diagonal().map(|x| x.max(f64::MIN_POSITIVE).sqrt().recip()));
    let scaled = (&scale * normal * &scale).try_inverse().ok_or_else(|| {
        Error::new(ErrorKind::Undetermined)
            .found("numbers that the residuals do not tell apart")
            .expected("a Jacobian of full rank")
            .remedy("record strokes at several feeds")
    })?;
    Ok(&scale * scaled * &scale)
}

/// S: scores summed with Bartlett's weights over the memory of the residuals, run by run.
fn scores(solution: &Solution, subjects: &[Subject]) -> DMatrix<f64> {
    let count = solution.jacobian.ncols();
    let mut sum = DMatrix::zeros(count, count);
    let mut offset = 0;
    for subject in subjects {
        let samples = subject.run.len();
        let lags = ((MEMORY_S / subject.run.sample_period_s()) as usize).min(samples / 10);
        let row = |k: usize| solution.jacobian.row(offset + k) * solution.residuals[offset + k];
        let score: Vec<DVector<f64>> =
            (0..samples).map(|k| (row(k) + row(samples + k)).transpose()).collect();
        for lag in 0..=lags {
            let weight = 1.0 - lag as f64 / (lags as f64 + 1.0);
            let mut product = DMatrix::zeros(count, count);
            for k in lag..samples {
                product.ger(weight, &score[k], &score[k - lag], 1.0);
            }
            sum += &product;
            if lag > 0 {
                sum += product.transpose();
            }
        }
        offset += 2 * samples;
    }
    sum
}
