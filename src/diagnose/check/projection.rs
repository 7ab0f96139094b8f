//! What is left of a signal after all that a few others can explain of it.

use crate::diagnose::scalar_product::dot;

/// A column that keeps less than this share of its length beside those before it repeats them: half the digits
/// of an `f64`.
const LEAST_SHARE: f64 = 1e-8;

/// An orthonormal basis of the space that some columns span.
#[derive(Debug, Clone, Default)]
pub struct Basis {
    columns: Vec<Vec<f64>>,
}

impl Basis {
    /// Of columns of one length; those that repeat earlier ones, or vanish, are left out.
    pub fn of(columns: impl IntoIterator<Item = Vec<f64>>) -> Self {
        let mut basis = Self::default();
        for column in columns {
            let length = norm(&column);
            // Twice, because once leaves rounding along the basis.
            let rest = basis.residual(basis.residual(column));
            let left = norm(&rest);
            if left > LEAST_SHARE * length {
                basis.columns.push(rest.into_iter().map(|x| x / left).collect());
            }
        }
        basis
    }

    /// The part of `y` that the columns do not explain.
    pub fn residual(&self, mut y: Vec<f64>) -> Vec<f64> {
        for column in &self.columns {
            let share = dot(column, &y);
            for (y, column) in y.iter_mut().zip(column) {
                *y -= share * column;
            }
        }
        y
    }
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Sum of squares about the mean.
pub fn spread(y: &[f64]) -> f64 {
    let mean = y.iter().sum::<f64>() / (y.len() as f64).max(1.0);
    y.iter().map(|y| (y - mean) * (y - mean)).sum()
}

/// Pieces into which residuals are cut for standard errors: enough to estimate a variance, and each long enough
/// that what an unmodelled force leaves in one says little of the next.
const PIECES: usize = 16;

/// Least-squares coefficient of one column beside others, with a standard error that autocorrelated residuals do
/// not fool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficient {
    /// The coefficient.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

impl Coefficient {
    /// Of `column` in the fit of `y` by it and `others`; none where it is not determined.
    ///
    /// # Model
    /// With g the part of the column that the others do not explain and r the residual of the whole fit,
    /// `value = g·y/g·g` and `error² = Σ_pieces (Σ g·r)² / (g·g)²`.
    ///
    /// # Source
    /// Frisch, Waugh, Lovell for the value; White, *Asymptotic Theory for Econometricians*, chapter 6, for
    /// the error from sums over pieces.
    pub fn of(column: &[f64], others: &Basis, y: &[f64]) -> Option<Self> {
        let alone = others.residual(column.to_vec());
        let size = dot(&alone, &alone);
        if size <= LEAST_SHARE * LEAST_SHARE * dot(column, column) {
            return None;
        }
        let rest = others.residual(y.to_vec());
        let value = dot(&alone, &rest) / size;
        let residual: Vec<f64> = rest.iter().zip(&alone).map(|(r, g)| r - value * g).collect();
        Some(Self { value, standard_error: standard_error(&alone, &residual, size) })
    }

    /// How many standard errors away from zero.
    pub fn significance(&self) -> f64 {
        if self.standard_error > 0.0 { self.value.abs() / self.standard_error } else { f64::INFINITY }
    }
}

/// Standard error of a coefficient along `direction`, from sums over [`PIECES`] pieces of its product with the
/// residual.
pub fn standard_error(direction: &[f64], residual: &[f64], size: f64) -> f64 {
    let length = direction.len().div_ceil(PIECES).max(1);
    let pieces = direction.chunks(length).zip(residual.chunks(length));
    let sum: f64 = pieces.map(|(g, r)| dot(g, r).powi(2)).sum();
    sum.sqrt() / size
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_what_the_columns_hold_leaves_nothing() {
        let line: Vec<f64> = (0..50).map(f64::from).collect();
        let one = vec![1.0; 50];
        let basis = Basis::of([one.clone(), line.clone(), line.iter().map(|x| 3.0 * x - 2.0).collect()]);
        assert_eq!(basis.columns.len(), 2);
        let rest = basis.residual(line.iter().map(|x| 7.0 - 0.3 * x).collect());
        assert!(norm(&rest) < 1e-12);
    }

    #[test]
    fn exact_coefficient_beside_others() {
        let line: Vec<f64> = (0..64).map(f64::from).collect();
        let bend: Vec<f64> = line.iter().map(|x| x * x).collect();
        let y: Vec<f64> = line.iter().zip(&bend).map(|(x, b)| 4.0 - 2.0 * x + 0.5 * b).collect();
        let others = Basis::of([vec![1.0; 64], line.clone()]);
        let found = Coefficient::of(&bend, &others, &y).unwrap();
        assert!((found.value - 0.5).abs() < 1e-12 && found.significance() > 1e6);
        assert_eq!(Coefficient::of(&line, &others, &y), None);
    }
}
