//! What an identified first-order lag says about the axis: moving inertia and viscous coefficient.

use serde::Serialize;

use super::arx::ArxModel;
use super::least_squares::{Estimate, student_quantile};
use crate::error::{Error, ErrorKind, Result};

/// Inertia and viscous coefficient behind W(z) = b z^−d / (1 − p z⁻¹) from effort to velocity.
///
/// # Model
/// m·dv/dt = F − c·v, F held over each sample Ts; with s output units in one SI unit of velocity:
/// ```text
/// p = exp(−c·Ts/m),  b = s·(1 − p)/c   ⇔   c/m = −ln(p)/Ts,  c = s·(1 − p)/b,  m = c·Ts/(−ln p)
/// ```
/// Standard errors by the delta method from the covariance of (a₁, b).
///
/// # Validity
/// 0 < p < 1. The decay rate follows from the pole alone; inertia and viscous coefficient need the right
/// sample period *and* output unit: read at a period a hundred times shorter, the same W(z) describes a
/// hundredth of the inertia.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FirstOrder {
    /// p, the pole.
    pub pole: Estimate,
    /// c/m, 1/s.
    pub decay_rate_per_s: Estimate,
    /// c: N·s/m of a prismatic, N·m·s/rad of a revolute axis.
    pub viscous_coefficient: Estimate,
    /// m: kg of a prismatic, kg·m² of a revolute axis.
    pub inertia: Estimate,
}

impl FirstOrder {
    /// Reads a model with one coefficient in A(z) and one in B(z).
    ///
    /// `output_units_per_si` is how many units of the output make 1 m/s or 1 rad/s: 1000 for mm/s.
    ///
    /// # Errors
    /// Other orders; a pole outside (0, 1), which no lag has; a gain of 0; a unit factor that is not > 0.
    pub fn of(model: &ArxModel, output_units_per_si: f64) -> Result<Self> {
        if !(output_units_per_si.is_finite() && output_units_per_si > 0.0) {
            return Err(Error::new(ErrorKind::OutOfRange)
                .key("output_units_per_si")
                .found(output_units_per_si.to_string())
                .expected("a finite number > 0")
                .remedy("give 1 for m/s or rad/s, 1000 for mm/s"));
        }
        let ([a], [b]) = (&model.a[..], &model.b[..]) else {
            return Err(Error::new(ErrorKind::Inconsistent)
                .key("orders")
                .found(format!("na = {}, nb = {}", model.orders.na, model.orders.nb))
                .expected("na = 1, nb = 1")
                .remedy("identify with one coefficient each to read inertia and viscous coefficient"));
        };
        let p = -a.value;
        if !(p > 0.0 && p < 1.0) || b.value == 0.0 {
            return Err(Error::new(ErrorKind::OutOfRange)
                .key("pole")
                .found(format!("pole {p}, gain {}", b.value))
                .expected("a pole between 0 and 1 and a gain other than 0")
                .remedy(
                    "the output is not the velocity of an inertia with viscous drag at this sample period",
                ));
        }
        Self::interpret(model, p, b.value, output_units_per_si)
    }

    fn interpret(model: &ArxModel, p: f64, b: f64, s: f64) -> Result<Self> {
        let ts = model.transfer.sample_period_s();
        let quantile = student_quantile(model.degrees_of_freedom)?;
        let covariance = &model.covariance;
        // the covariance is that of (a₁, b) and a₁ = −p
        let (var_p, var_b, cov_pb) = (covariance[(0, 0)], covariance[(1, 1)], -covariance[(0, 1)]);
        let estimate = |value: f64, by_p: f64, by_b: f64| {
            let variance = by_p * by_p * var_p + 2.0 * by_p * by_b * cov_pb + by_b * by_b * var_b;
            Estimate::new(value, variance.max(0.0).sqrt(), quantile)
        };
        let decay = -p.ln();
        let c = s * (1.0 - p) / b;
        let m = c * ts / decay;
        Ok(Self {
            pole: estimate(p, 1.0, 0.0),
            decay_rate_per_s: estimate(decay / ts, -1.0 / (p * ts), 0.0),
            viscous_coefficient: estimate(c, -s / b, -c / b),
            inertia: estimate(m, ts * (c / (p * decay * decay) - s / (b * decay)), -m / b),
        })
    }
}
