//! Fewer samples of the same signals, for identification at a longer period.

use super::check;
use crate::error::{Error, ErrorKind, Result};

/// Deviation of the wanted period from a whole multiple that still counts as one.
const MULTIPLE_TOLERANCE: f64 = 1e-6;

/// How many samples at `sample_period_s` make one of `period_s`.
///
/// ```
/// use slideway::identify::decimation::factor;
/// assert_eq!(factor(250e-6, 0.025)?, 100);
/// assert!(factor(250e-6, 0.0003).is_err());
/// # Ok::<(), slideway::error::Error>(())
/// ```
///
/// # Errors
/// A period that is not a whole multiple of the sample period.
pub fn factor(sample_period_s: f64, period_s: f64) -> Result<usize> {
    check::sample_period(sample_period_s)?;
    check::sample_period(period_s)?;
    let ratio = period_s / sample_period_s;
    let whole = ratio.round();
    if whole >= 1.0 && (ratio / whole - 1.0).abs() < MULTIPLE_TOLERANCE {
        return Ok(whole as usize);
    }
    Err(Error::new(ErrorKind::Inconsistent)
        .key("period")
        .found(format!("{period_s} s"))
        .expected(format!("a whole multiple of the sample period, {sample_period_s} s"))
        .remedy(format!("give {} s for instance", sample_period_s * whole.max(1.0))))
}

/// Input and output at a `factor` times longer period: the output as sampled, the input as its mean over each
/// period, which moves a lag as the input itself does to first order in its variation.
///
/// What is left over at the end is dropped.
pub fn decimate(input: &[f64], output: &[f64], factor: usize) -> (Vec<f64>, Vec<f64>) {
    let factor = factor.max(1);
    let means = input.chunks_exact(factor).map(|held| held.iter().sum::<f64>() / factor as f64);
    let readings = output.chunks_exact(factor).filter_map(|held| held.first().copied());
    means.zip(readings).unzip()
}
