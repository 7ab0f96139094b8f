//! How many samples of a residual count as one.

use super::scalar_product::dot;

/// Autocorrelation below which residuals have nothing more in common: white noise over 400 samples has 1/√400 by chance (Bartlett).
const DIED_OUT: f64 = 0.05;
/// Lags up to this one are taken one by one, longer ones ever farther apart: long correlations change slowly.
const DENSE: usize = 16;

/// Integrated autocorrelation time of a residual, in samples: so many of them tell as much as one independent sample.
///
/// # Model
/// ```text
///   τ = 1 + 2·Σ ρ(lag),  ρ(lag) = Σ r(k)·r(k + lag) / Σ r(k)²
/// ```
/// up to the first lag at which ρ has died out, at most a quarter of the samples. White noise has 1, and so has a residual of zeros. The mean is not
/// taken off: a constant residual is structure.
///
/// # Source
/// M. B. Priestley (1981), *Spectral Analysis and Time Series*, section 5.3: the variance of a mean of correlated samples is τ times that of
/// independent ones.
pub(super) fn autocorrelation_time(residual: &[f64]) -> f64 {
    let power = dot(residual, residual);
    if power <= 0.0 {
        return 1.0;
    }
    let (mut sum, mut lag, mut width) = (1.0, 1, 1);
    while lag < residual.len() / 4 {
        let correlation = dot(residual, &residual[lag..]) / power;
        if correlation < DIED_OUT {
            break;
        }
        sum += 2.0 * width as f64 * correlation;
        width = (lag / DENSE).max(1);
        lag += width;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// A first-order process with coefficient a has τ = (1 + a)/(1 − a), cut where aⁿ falls below [`DIED_OUT`]; white noise 1. The sampling error of τ
    /// is √(2·(2·lags + 1)/N) of it (Madras, Sokal 1988, J. Stat. Phys. 50:109): 0.054 of the slowest.
    #[test]
    fn exact_time_of_a_first_order_process() {
        let mut rng = rand::rngs::StdRng::seed_from_u64(3);
        let mut series = |a: f64| {
            let mut state = 0.0;
            let mut next = || {
                state = a * state + rng.random_range(-1.0..1.0);
                state
            };
            (0..200_000).map(|_| next()).collect::<Vec<f64>>()
        };
        assert_eq!(autocorrelation_time(&series(0.0)), 1.0);
        for a in [0.5, 0.9, 0.98] {
            let lags = (DIED_OUT.ln() / f64::ln(a)).floor();
            let exact = 1.0 + 2.0 * a * (1.0 - a.powf(lags)) / (1.0 - a);
            let found = autocorrelation_time(&series(a));
            assert!((found / exact - 1.0).abs() < 0.06, "{a}: {found}, {exact}");
        }
    }

    /// Zeros are one sample each. A constant is alike at all lags that are looked at, n/4 of n samples: 1 + 2·Σ(1 − lag/n) = 1 + 7n/16, to what the lags
    /// that are left out between others make.
    #[test]
    fn exact_time_of_constants() {
        assert_eq!(autocorrelation_time(&[0.0; 100]), 1.0);
        let constant = autocorrelation_time(&[2.0; 1000]);
        assert!((constant / (1.0 + 7.0 * 1000.0 / 16.0) - 1.0).abs() < 0.05, "{constant}");
        assert_eq!(autocorrelation_time(&[]), 1.0);
    }
}
