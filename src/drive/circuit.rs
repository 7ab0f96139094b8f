//! The electrical circuit of a motor: current and effort over a step with a held voltage.

/// The electrical constants that a step needs, ready for one step length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Circuit {
    /// R–L circuit, or the first-order current loop that has its equation.
    Winding {
        /// R in Ω.
        resistance_ohm: f64,
        /// L in H.
        inductance_h: f64,
        /// Kt in N/A or N·m/A.
        force_constant: f64,
        /// Ke in V·s/m or V·s/rad.
        back_emf: f64,
    },
    /// Effort proportional to voltage.
    Direct {
        /// K in N/V or N·m/V.
        force_per_volt: f64,
    },
}

/// Advances the current over a piece of time in which the voltage does not change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CircuitStep {
    duration_s: f64,
    decay: f64,
    mean_weight: f64,
    moment_weight: f64,
    inverse_resistance: f64,
    back_emf: f64,
    effort_constant: f64,
    electrical: bool,
}

impl CircuitStep {
    /// Prepares steps of `duration_s`.
    pub fn new(circuit: &Circuit, duration_s: f64) -> Self {
        match *circuit {
            Circuit::Winding { resistance_ohm, inductance_h, force_constant, back_emf } => {
                let ratio = resistance_ohm * duration_s / inductance_h;
                Self {
                    duration_s,
                    decay: (-ratio).exp(),
                    // Mean of e^(−R·t/L) over the step: (1 − e^−ratio)/ratio, 1 in the limit of a zero step.
                    mean_weight: if ratio > 0.0 { -(-ratio).exp_m1() / ratio } else { 1.0 },
                    moment_weight: moment(ratio),
                    inverse_resistance: 1.0 / resistance_ohm,
                    back_emf,
                    effort_constant: force_constant,
                    electrical: true,
                }
            }
            Circuit::Direct { force_per_volt } => Self {
                duration_s,
                decay: 0.0,
                mean_weight: 0.0,
                moment_weight: 0.0,
                inverse_resistance: 1.0,
                back_emf: 0.0,
                effort_constant: force_per_volt,
                electrical: false,
            },
        }
    }

    /// Length of the step in s.
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Whether a current exists in this motor model.
    pub fn has_current(&self) -> bool {
        self.electrical
    }

    /// N/A (N·m/A), or N/V (N·m/V) for a direct motor.
    pub fn effort_constant(&self) -> f64 {
        self.effort_constant
    }

    /// Moves `current` (A; the voltage itself for a direct motor) over the step and returns its mean.
    ///
    /// Mean current, not final current, times the force constant is the impulse that the table receives.
    #[inline]
    pub fn advance(&self, current: &mut f64, voltage_v: f64, velocity: f64) -> f64 {
        self.over(current, voltage_v, velocity).mean
    }

    /// The same with the first moment of the current over the step.
    #[inline]
    pub fn over(&self, current: &mut f64, voltage_v: f64, velocity: f64) -> StepCurrent {
        let settled = (voltage_v - self.back_emf * velocity) * self.inverse_resistance;
        let offset = *current - settled;
        *current = settled + offset * self.decay;
        StepCurrent { mean: settled + offset * self.mean_weight, moment: offset * self.moment_weight }
    }
}

/// Current (voltage, for a direct motor) over a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepCurrent {
    /// Mean over the step.
    pub mean: f64,
    /// First moment about the middle of the step, in units of its length: `∫₀¹ (s − ½)·i(s) ds`.
    pub moment: f64,
}

/// `∫₀¹ (s − ½)·e^(−a·s) ds`.
fn moment(a: f64) -> f64 {
    // Below this, the closed form takes numbers near each other apart; the series is exact to 1e-9 of its value.
    const SERIES_BELOW: f64 = 0.05;
    if a < SERIES_BELOW {
        return -a / 12.0 * (1.0 - a * (0.5 - a * (0.15 - a * (1.0 / 30.0 - a / 168.0))));
    }
    let (decay, fallen) = ((-a).exp(), -(-a).exp_m1());
    (fallen - a * decay) / (a * a) - 0.5 * fallen / a
}

#[cfg(test)]
mod tests {
    use super::*;

    const CIRCUIT: Circuit =
        Circuit::Winding { resistance_ohm: 1.3, inductance_h: 8e-3, force_constant: 83.1, back_emf: 0.0 };

    #[test]
    fn ref_zero_order_hold_pole_of_the_published_winding() {
        let step = CircuitStep::new(&CIRCUIT, 250e-6);
        let mut current = 1.0;
        step.advance(&mut current, 0.0, 0.0);
        assert!((current - 0.96019).abs() < 5e-6, "pole {current}");
    }

    #[test]
    fn exact_moment_of_a_decay_is_continuous_where_the_series_ends() {
        for a in [1e-6, 1e-3, 0.049_999, 0.050_001, 0.5, 3.0] {
            let steps = 20_000;
            let at = |k: i32| (f64::from(k) + 0.5) / f64::from(steps);
            let sum: f64 = (0..steps).map(|k| (at(k) - 0.5) * (-a * at(k)).exp()).sum();
            let numeric = sum / f64::from(steps);
            assert!((moment(a) / numeric - 1.0).abs() < 1e-6, "{a}: {} {numeric}", moment(a));
        }
        assert!((moment(0.049_999_999) / moment(0.050_000_001) - 1.0).abs() < 2e-7);
    }

    #[test]
    fn exact_two_half_steps_are_one_step() {
        let (whole, half) = (CircuitStep::new(&CIRCUIT, 1e-3), CircuitStep::new(&CIRCUIT, 5e-4));
        let (mut a, mut b) = (0.4, 0.4);
        let mean = whole.advance(&mut a, 3.0, 0.2);
        let halves = 0.5 * (half.advance(&mut b, 3.0, 0.2) + half.advance(&mut b, 3.0, 0.2));
        assert!((a - b).abs() < 1e-14 && (mean - halves).abs() < 1e-14);
    }
}
