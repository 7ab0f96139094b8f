//! Is what a model leaves over still structured?

use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Lags that the test looks at, if the runs are long enough.
const LAGS: usize = 20;
/// Level below which whiteness is rejected.
const LEVEL: f64 = 0.05;
/// Two-sided 95 % quantile of the normal distribution.
const NORMAL_QUANTILE: f64 = 1.96;

/// Ljung–Box test of residuals for autocorrelation.
///
/// # Model
/// Q = N(N+2) Σ rₖ²/Nₖ over the lags k = 1…h, Nₖ pairs at lag k within runs; under whiteness Q follows χ² with h − n degrees of
/// freedom, n = number of coefficients of A(z) that were fitted.
///
/// # Validity
/// N ≫ h. A rejection says that the intervals of the parameters are too narrow and that the model lacks something.
///
/// # Source
/// Ljung, Box, On a measure of lack of fit in time series models, Biometrika 65, 1978.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Whiteness {
    /// Q.
    pub statistic: f64,
    /// h − n.
    pub degrees_of_freedom: usize,
    /// Probability of a Q at least as large from white residuals.
    pub p_value: f64,
    /// r₁ … rₕ.
    pub autocorrelation: Vec<f64>,
    /// 1.96/√N: a single autocorrelation of white residuals stays within ± this in 95 % of the cases.
    pub bound: f64,
}

impl Whiteness {
    /// Whether whiteness is not rejected at the 5 % level.
    pub fn is_white(&self) -> bool {
        self.p_value >= LEVEL
    }

    /// Tests residuals, run by run, that remain after `fitted` coefficients of A(z). Residuals of 0 count as white.
    pub fn of(runs: &[&[f64]], fitted: usize) -> Self {
        let count: usize = runs.iter().map(|run| run.len()).sum();
        let lags = (count / 4).min(LAGS).max(fitted + 1);
        let power: f64 = runs.iter().flat_map(|run| run.iter()).map(|e| e * e).sum();
        let mut statistic = 0.0;
        let mut autocorrelation = Vec::with_capacity(lags);
        for lag in 1..=lags {
            let pairs: usize = runs.iter().map(|run| run.len().saturating_sub(lag)).sum();
            let sum: f64 =
                runs.iter().flat_map(|run| run.iter().zip(run.iter().skip(lag))).map(|(a, b)| a * b).sum();
            let r = if power > 0.0 { sum / power } else { 0.0 };
            if pairs > 0 {
                statistic += r * r / pairs as f64;
            }
            autocorrelation.push(r);
        }
        let n = count as f64;
        statistic *= n * (n + 2.0);
        let degrees_of_freedom = lags - fitted;
        let p_value = ChiSquared::new(degrees_of_freedom as f64).map_or(1.0, |chi| chi.sf(statistic));
        let bound = if count > 0 { NORMAL_QUANTILE / n.sqrt() } else { f64::INFINITY };
        Self { statistic, degrees_of_freedom, p_value, autocorrelation, bound }
    }
}
