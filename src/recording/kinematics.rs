//! Position, velocity and acceleration at one instant, from the positions around it.

use nalgebra::{DMatrix, DVector};

/// Position, velocity and acceleration at time zero, each with its standard error, in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kinematics {
    /// Position, velocity, acceleration.
    pub state: [f64; 3],
    /// Their standard errors for independent errors of the positions; zero where three samples leave no scatter.
    pub standard_errors: [f64; 3],
}

impl Kinematics {
    /// A velocity or an acceleration below so many of its standard errors is none: normal errors exceed five once in 1.7 million times.
    const SIGNIFICANT: f64 = 5.0;

    /// The least-squares parabola x(t) = x₀ + v₀·t + ½·a₀·t² through positions at these times in s; none for fewer than three or
    /// for times that do not determine it.
    pub fn fit(times_s: impl Iterator<Item = f64>, positions: &[f64]) -> Option<Self> {
        let count = positions.len();
        let times: Vec<f64> = times_s.take(count).collect();
        if count < 3 || times.len() < count {
            return None;
        }
        // Positions far from zero would cost digits.
        let origin = positions[0];
        let matrix = DMatrix::from_fn(count, 3, |row, power| times[row].powi(power as i32));
        let target = DVector::from_fn(count, |row, _| positions[row] - origin);
        let inverse = (matrix.transpose() * &matrix).try_inverse()?;
        let fit = &inverse * matrix.transpose() * &target;
        let variance = (&target - &matrix * &fit).norm_squared() / (count - 3).max(1) as f64;
        let error = |power: usize| (variance * inverse[(power, power)]).sqrt();
        Some(Self {
            state: [origin + fit[0], fit[1], 2.0 * fit[2]],
            standard_errors: [error(0), error(1), 2.0 * error(2)],
        })
    }

    /// The velocity; none that the scatter of the positions explains.
    pub fn significant_velocity(&self) -> Option<f64> {
        self.significant(1)
    }

    /// The acceleration; none that the scatter of the positions explains.
    pub fn significant_acceleration(&self) -> Option<f64> {
        self.significant(2)
    }

    fn significant(&self, order: usize) -> Option<f64> {
        let value = self.state[order];
        (value.abs() > Self::SIGNIFICANT * self.standard_errors[order]).then_some(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_parabola_comes_back() {
        let times: Vec<f64> = (-4..5).map(|k| 1e-3 * f64::from(k)).collect();
        let positions: Vec<f64> = times.iter().map(|t| 0.5 + 0.2 * t - 0.5 * 3.0 * t * t).collect();
        let found = Kinematics::fit(times.iter().copied(), &positions).unwrap();
        for (value, wanted) in found.state.iter().zip([0.5, 0.2, -3.0]) {
            assert!((value - wanted).abs() < 1e-9, "{found:?}");
        }
        assert!(found.significant_velocity().is_some() && found.significant_acceleration().is_some());
        let still = Kinematics::fit(times.iter().copied(), &[0.5; 9]).unwrap();
        assert_eq!((still.state, still.significant_velocity()), ([0.5, 0.0, 0.0], None));
    }

    /// Alternating errors of ±e on 2n + 1 samples around zero leave the slope's error at e·(Σt²)^(−½)·√(N/(N − 3)), near enough.
    #[test]
    fn exact_scatter_sets_the_standard_errors() {
        let times: Vec<f64> = (-50..51).map(f64::from).collect();
        let positions: Vec<f64> = (0..101).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let found = Kinematics::fit(times.iter().copied(), &positions).unwrap();
        let squares: f64 = times.iter().map(|t| t * t).sum();
        let wanted = (101.0_f64 / 98.0 / squares).sqrt();
        assert!((found.standard_errors[1] / wanted - 1.0).abs() < 1e-3, "{found:?} {wanted}");
        assert_eq!(found.significant_velocity(), None);
    }

    #[test]
    fn exact_what_does_not_determine_a_parabola_gives_none() {
        assert_eq!(Kinematics::fit([0.0, 1.0].into_iter(), &[0.0, 1.0]), None);
        assert_eq!(Kinematics::fit([1.0; 4].into_iter(), &[0.0, 1.0, 2.0, 3.0]), None);
        assert_eq!(Kinematics::fit([0.0, 1.0].into_iter(), &[0.0; 4]), None);
    }
}
