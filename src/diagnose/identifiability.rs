//! Practical identifiability: how well the data determine each parameter of the explanation, and which they determine only together.

use super::fit::Fit;
use super::free::{Free, Freedom};
use super::parameter::NORMAL_975;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// A fitted parameter and how well its data determine it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParameterIdentifiability {
    /// TOML key path.
    pub path: String,
    /// Half of the 95 % interval over the size of the value; none for a value of zero.
    pub relative_half_width: Option<f64>,
    /// Half of the 95 % interval over half of the tolerance, for a stated constant: near 1 its tolerance determines it, not the data.
    pub of_tolerance: Option<f64>,
    /// How many times narrower the interval would be if all other parameters were known: the root of the variance inflation factor,
    /// √((R⁻¹)ₖₖ), R the correlation matrix; none where R is singular.
    pub interval_inflation: Option<f64>,
    /// Place of the parameter that it is correlated with most; none where it is alone.
    pub most_correlated_with: Option<usize>,
}

/// The parameters of the explanation that was chosen, with the correlation of their errors.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Identifiability {
    /// Those of the causes, then stated constants.
    pub parameters: Vec<ParameterIdentifiability>,
    /// Correlation of their errors, row by row.
    pub correlation: Vec<Vec<f64>>,
}

impl Identifiability {
    /// Whether no parameter was fitted.
    pub fn is_empty(&self) -> bool {
        self.parameters.is_empty()
    }

    /// Of a fit; parameters that only starts set, and those that are held at a bound, have no error and are left out.
    pub fn of(fit: &Fit) -> Self {
        let free = &fit.hypothesis.free;
        let is_free = |k: &usize| !free[*k].held && fit.covariance[(*k, *k)] > 0.0;
        let chosen: Vec<usize> = (0..free.len()).filter(is_free).collect();
        let count = chosen.len();
        let part = DMatrix::from_fn(count, count, |i, j| fit.covariance[(chosen[i], chosen[j])]);
        let correlation = correlation(&part);
        let inflation = interval_inflation(&correlation);
        let parameters = chosen.iter().enumerate().map(|(row, &k)| {
            let half = NORMAL_975 * fit.standard_errors[k];
            ParameterIdentifiability {
                path: path(&free[k]),
                relative_half_width: share(half, fit.values[k].abs()),
                of_tolerance: tolerance(&free[k]).and_then(|tolerance| share(half, tolerance)),
                interval_inflation: inflation.as_ref().map(|all| all[row]),
                most_correlated_with: most_correlated_with(&correlation, row),
            }
        });
        let parameters = parameters.collect();
        let correlation = (0..count).map(|i| correlation.row(i).iter().copied().collect()).collect();
        Self { parameters, correlation }
    }
}

fn path(free: &Free) -> String {
    match free.freedom {
        Freedom::Cause => format!("effect.{}.{}", free.effect.name(), free.name),
        Freedom::Calibration => free.path.clone(),
    }
}

/// Half of a stated constant's tolerance.
fn tolerance(free: &Free) -> Option<f64> {
    (free.freedom == Freedom::Calibration).then_some(0.5 * (free.range.1 - free.range.0))
}

fn share(part: f64, whole: f64) -> Option<f64> {
    let share = part / whole;
    (whole > 0.0 && share.is_finite()).then_some(share)
}

/// Correlation of a covariance with a positive diagonal: C_ij/√(C_ii·C_jj), its rounding the same on both sides of the diagonal.
fn correlation(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let count = covariance.nrows();
    DMatrix::from_fn(count, count, |i, j| {
        let size = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        if i == j { 1.0 } else { (0.5 * (covariance[(i, j)] + covariance[(j, i)]) / size).clamp(-1.0, 1.0) }
    })
}

/// √((R⁻¹)ₖₖ), the root of the variance inflation factor; none where R is singular.
fn interval_inflation(correlation: &DMatrix<f64>) -> Option<Vec<f64>> {
    let inverse = correlation.clone().cholesky()?.inverse();
    let all: Vec<f64> = (0..inverse.nrows()).map(|k| inverse[(k, k)].max(1.0).sqrt()).collect();
    all.iter().all(|x| x.is_finite()).then_some(all)
}

fn most_correlated_with(correlation: &DMatrix<f64>, row: usize) -> Option<usize> {
    let others = (0..correlation.ncols()).filter(|column| *column != row);
    others.max_by(|a, b| correlation[(row, *a)].abs().total_cmp(&correlation[(row, *b)].abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ = D·R·D with D = diag(2, 3, 0.5): R comes back, whatever the units.
    #[test]
    fn exact_correlation_of_a_known_covariance() {
        let wanted = DMatrix::from_row_slice(3, 3, &[1.0, 0.8, -0.3, 0.8, 1.0, 0.1, -0.3, 0.1, 1.0]);
        let units = DMatrix::from_diagonal(&nalgebra::DVector::from_vec(vec![2.0, 3.0, 0.5]));
        let found = correlation(&(&units * &wanted * &units));
        assert!((&found - &wanted).norm() < 1e-15, "{found}");
        assert_eq!([0, 1, 2].map(|row| most_correlated_with(&found, row)), [Some(1), Some(0), Some(0)]);
        assert_eq!(most_correlated_with(&DMatrix::from_element(1, 1, 1.0), 0), None);
    }

    /// Two parameters correlated by ρ: 1/√(1 − ρ²); none where ρ = 1.
    #[test]
    fn exact_interval_inflation_of_a_pair() {
        let pair = |r: f64| DMatrix::from_row_slice(2, 2, &[1.0, r, r, 1.0]);
        for rho in [0.0, 0.6, -0.8, 0.999] {
            let found = interval_inflation(&pair(rho)).unwrap();
            let wanted = 1.0 / (1.0 - rho * rho).sqrt();
            assert!(found.iter().all(|x| (x / wanted - 1.0).abs() < 1e-12), "{found:?} for {wanted}");
        }
        assert!(interval_inflation(&pair(1.0)).is_none());
    }
}
