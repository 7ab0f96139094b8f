//! Is what a model leaves over still structured?

use serde::{Deserialize, Serialize};
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
/// Q = N(N+2) Σ rₖ²/Nₖ over the lags k = 1…h, Nₖ pairs at lag k within runs; under whiteness Q follows χ²
/// with h degrees of freedom. Fitting takes out some of them, at most one a coefficient of A(z), the fewer
/// the more the input drives the output; none is subtracted here, so whiteness is rejected wrongly in about 5
/// % of the cases.
///
/// # Validity
/// N ≫ h. A rejection says that the intervals of the parameters are too narrow and that the model lacks
/// something.
///
/// # Source
/// Ljung, Box, On a measure of lack of fit in time series models, Biometrika 65, 1978;
/// Ljung, System Identification: Theory for the User, 2nd ed., section 16.6.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Whiteness {
    /// Q.
    pub statistic: f64,
    /// h.
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

    /// Tests residuals, run by run. Residuals of 0 count as white.
    pub fn of(runs: &[&[f64]]) -> Self {
        Self::over(runs, LAGS)
    }

    /// The same over so many lags at most; a quarter of the samples bounds them too.
    pub fn over(runs: &[&[f64]], most: usize) -> Self {
        let count: usize = runs.iter().map(|run| run.len()).sum();
        let lags = (count / 4).clamp(1, most.max(1));
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
        let degrees_of_freedom = lags;
        let p_value = ChiSquared::new(degrees_of_freedom as f64).map_or(1.0, |chi| chi.sf(statistic));
        let bound = if count > 0 { NORMAL_QUANTILE / n.sqrt() } else { f64::INFINITY };
        Self { statistic, degrees_of_freedom, p_value, autocorrelation, bound }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Alternating signs: rₖ = (−1)ᵏ·(N − k)/N, Q = N(N+2)·Σ (N − k)/N², and the 95 % bound 1.96/√N.
    #[test]
    fn exact_alternating_residuals() {
        let run: Vec<f64> = (0..400).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let found = Whiteness::over(&[&run], 50);
        assert_eq!((found.autocorrelation.len(), found.degrees_of_freedom), (50, 50));
        for (k, r) in found.autocorrelation.iter().enumerate() {
            let lag = k as f64 + 1.0;
            let wanted = if k % 2 == 0 { -1.0 } else { 1.0 } * (400.0 - lag) / 400.0;
            assert!((r - wanted).abs() < 1e-12, "{r} for {wanted}");
        }
        let wanted: f64 = (1..=50).map(|k| 400.0 * 402.0 * (400.0 - f64::from(k)) / 400.0_f64.powi(2)).sum();
        assert!((found.statistic / wanted - 1.0).abs() < 1e-12 && (found.bound - 0.098).abs() < 1e-12);
        assert!(!found.is_white());
    }

    /// No pair reaches from one run into the next.
    #[test]
    fn exact_runs_are_apart() {
        let found = Whiteness::over(&[&[1.0, 0.0], &[0.0, 1.0], &[1.0, 0.0], &[0.0, 1.0]], 1);
        assert_eq!(found.autocorrelation, [0.0]);
        assert!(found.is_white());
    }
}
