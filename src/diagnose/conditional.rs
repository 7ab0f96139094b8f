//! Where the numbers of a fit go when further runs are taken in, each inside its range.

use super::objective::weighted;
use nalgebra::{DMatrix, DVector};

/// Rounds in which the variance of the residuals and the numbers are taken in turn; a choice of cost, the first two do nearly all.
const ROUNDS: usize = 4;

/// A variance that is no more than this share of what it was is rounding.
const ROUNDING: f64 = 1e-12;

/// A normal distribution of the numbers about those of the fit, some of them held.
#[derive(Debug, Clone)]
pub struct Gaussian {
    /// How far the mean is from the fit, in units of the numbers' scales.
    mean: DVector<f64>,
    /// Covariance; zero of those that are held.
    covariance: DMatrix<f64>,
    /// ½·ΔᵀC⁻¹Δ of the mean, C the covariance with none held; in nats.
    strain: f64,
}

impl Gaussian {
    /// That of a fit.
    pub fn of(covariance: &DMatrix<f64>) -> Self {
        Self { mean: DVector::zeros(covariance.nrows()), covariance: covariance.clone(), strain: 0.0 }
    }

    /// The distribution of the others where one number is held; the number must not be certain already.
    ///
    /// # Model
    /// With c the column of the number k in C, and d how far it is held from its mean,
    /// ```text
    ///   mean' = mean + c·d/C_kk,   C' = C − c·cᵀ/C_kk,   strain' = strain + ½·d²/C_kk
    /// ```
    /// # Source
    /// T. W. Anderson (2003), *An Introduction to Multivariate Statistical Analysis*, 3rd ed., theorem 2.5.1.
    pub fn holding(&self, number: usize, at: f64) -> Self {
        let column = self.covariance.column(number).into_owned();
        let variance = column[number];
        let way = at - self.mean[number];
        let mut covariance = &self.covariance - &column * column.transpose() / variance;
        // Held is held, and so is what goes with it: rounding would let it move.
        let is_held = |&k: &usize| covariance[(k, k)] <= ROUNDING * self.covariance[(k, k)];
        for k in (0..covariance.nrows()).filter(is_held).collect::<Vec<_>>() {
            covariance.row_mut(k).fill(0.0);
            covariance.column_mut(k).fill(0.0);
        }
        let mut mean = &self.mean + column * (way / variance);
        mean[number] = at;
        Self { mean, covariance, strain: self.strain + 0.5 * way * way / variance }
    }
}

/// I + JᵀWJ·C.
pub fn system(weighted: &DMatrix<f64>, jacobian: &DMatrix<f64>, covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let information = weighted.tr_mul(jacobian);
    DMatrix::identity(information.nrows(), information.nrows()) + information * covariance
}

/// Where the numbers go when held-out runs are taken in as well.
pub struct Update {
    /// Step from the fit in units of the numbers' scales.
    pub step: DVector<f64>,
    /// Weights of the residuals there.
    pub weights: DVector<f64>,
    /// ½·ΔᵀC⁻¹Δ, in nats.
    pub strain: f64,
}

impl Update {
    /// The update with each number inside its range of steps, which holds zero; none where the numbers are not finite. `residuals` are those at the fit.
    ///
    /// Of the numbers that would leave their ranges, the one that is farthest outside, in standard errors, is held at the end of its own, and so on; none is let
    /// go again.
    pub fn within(
        residuals: &DVector<f64>,
        jacobian: &DMatrix<f64>,
        prior: &Gaussian,
        ranges: &[(f64, f64)],
        weights: impl Fn(&DVector<f64>) -> DVector<f64>,
    ) -> Option<Self> {
        let mut prior = prior.clone();
        loop {
            let update = Self::of(residuals, jacobian, &prior, &weights)?;
            let outside = ranges.iter().zip(&update.step).enumerate().filter_map(|(k, (range, step))| {
                let at = step.clamp(range.0, range.1);
                let variance = prior.covariance[(k, k)];
                (at != *step && variance > 0.0).then(|| (k, at, (step - at).abs() / variance.sqrt()))
            });
            let Some((number, at, _)) = outside.max_by(|a, b| a.2.total_cmp(&b.2)) else {
                return Some(update);
            };
            prior = prior.holding(number, at);
        }
    }

    fn of(
        residuals: &DVector<f64>,
        jacobian: &DMatrix<f64>,
        prior: &Gaussian,
        weights: impl Fn(&DVector<f64>) -> DVector<f64>,
    ) -> Option<Self> {
        let Gaussian { mean, covariance, strain } = prior;
        let begun = residuals + jacobian * mean;
        let mut update: Option<Self> = None;
        for _ in 0..ROUNDS {
            let left = update.as_ref().map_or_else(|| begun.clone(), |u| residuals + jacobian * &u.step);
            let weights = weights(&left);
            let weighted = weighted(jacobian, &weights);
            let factors = system(&weighted, jacobian, covariance).lu();
            let pulled = factors.solve(&weighted.tr_mul(&begun))?;
            let moved = covariance * &pulled;
            let strain = strain + (0.5 * pulled.dot(&moved)).max(0.0);
            let step = mean - moved;
            if !(strain.is_finite() && step.iter().all(|s| s.is_finite())) {
                return None;
            }
            update = Some(Self { step, weights, strain });
        }
        update
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even(left: &DVector<f64>) -> DVector<f64> {
        DVector::from_element(left.len(), 1.0)
    }

    /// Numbers that are certain do not move.
    #[test]
    fn exact_certain_numbers_stay() {
        let jacobian = DMatrix::from_element(4, 2, 1.0);
        let prior = Gaussian::of(&DMatrix::zeros(2, 2));
        let update =
            Update::within(&DVector::from_element(4, 3.0), &jacobian, &prior, &[(-1.0, 1.0); 2], even);
        let update = update.unwrap();
        assert_eq!((update.step.norm(), update.strain), (0.0, 0.0));
    }

    /// Two numbers that are one: where the first is at the end of its range, the second stays with it.
    #[test]
    fn exact_numbers_that_are_one_stop_together() {
        let prior = Gaussian::of(&DMatrix::from_row_slice(2, 2, &[4.0, 2.0, 2.0, 1.0]));
        let held = prior.holding(0, 3.0);
        assert_eq!((held.mean.as_slice(), held.covariance.norm()), (&[3.0, 1.5][..], 0.0));
        assert!((held.strain - 9.0 / 8.0).abs() < 1e-15);
    }

    /// Two correlated numbers, the first held at the end of its range: the second goes where the normal equations of the rest put it, and the strain is that
    /// of the step that is made.
    #[test]
    fn exact_a_number_at_the_end_of_its_range_moves_the_others() {
        let covariance = DMatrix::from_row_slice(2, 2, &[1.0, 0.6, 0.6, 0.5]);
        let jacobian = DMatrix::from_row_slice(3, 2, &[1.0, 0.2, -0.3, 1.0, 0.5, 0.5]);
        let residuals = DVector::from_vec(vec![-4.0, -1.0, -2.0]);
        let prior = Gaussian::of(&covariance);
        let anywhere = [(f64::NEG_INFINITY, f64::INFINITY); 2];
        let free = Update::within(&residuals, &jacobian, &prior, &anywhere, even).unwrap();
        assert!(free.step[0] > 0.5, "{}", free.step);
        let held = Update::within(&residuals, &jacobian, &prior, &[(-0.5, 0.5), anywhere[1]], even).unwrap();
        assert!((held.step[0] - 0.5).abs() < 1e-15);
        // Derivative of ½|r + JΔ|² + ½ΔᵀC⁻¹Δ with respect to the second number: zero.
        let inverse = covariance.try_inverse().unwrap();
        let slope = jacobian.tr_mul(&(&residuals + &jacobian * &held.step)) + &inverse * &held.step;
        assert!(slope[1].abs() < 1e-12 && slope[0].abs() > 0.1, "{slope}");
        assert!((held.strain - 0.5 * held.step.dot(&(inverse * &held.step))).abs() < 1e-12);
        assert!((free.step[1] - held.step[1]).abs() > 0.01);
    }
}
