//! The motor: from applied voltage to force or torque.

use serde::{Deserialize, Serialize};

/// How the motor turns voltage into effort.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Motor {
    /// Voltage-fed winding with resistance and inductance.
    Winding(Winding),
    /// Current loop so fast that effort follows the command at once.
    Direct(Direct),
}

/// A voltage-fed winding: R–L circuit with force constant and optional back-EMF.
///
/// # Model
/// ```text
///   L·di/dt = u − R·i − Ke·v        F = Kt·i
/// ```
/// Voltage and axis velocity are held over the integration step (exact for Ke = 0), so
/// `i(t+h) = i∞ + (i − i∞)·e^(−R·h/L)` with `i∞ = (u − Ke·v)/R`. Positive current drives the axis along
/// its positive direction.
///
/// # Source
/// Liu, Lai, Yen (2009), eq. 7 in continuous time (its printed discretisation has a sign error, see
/// [`crate::drive::printed`]).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Winding {
    /// R in Ω.
    pub resistance_ohm: f64,
    /// L in H.
    pub inductance_h: f64,
    /// Kt in N/A, or N·m/A for a revolute axis.
    #[serde(alias = "torque_constant_nm_per_a")]
    pub force_constant_n_per_a: f64,
    /// Ke in V·s/m, or V·s/rad for a revolute axis.
    #[serde(default, alias = "back_emf_v_s_per_rad")]
    pub back_emf_v_s_per_m: f64,
    /// Points of the moving body's frame at which the force attacks, in m; each takes an equal share.
    #[serde(default)]
    pub lines_of_action_m: Vec<[f64; 3]>,
}

/// An effort that follows the commanded voltage without delay: `F = K·u`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Direct {
    /// K in N/V, or N·m/V for a revolute axis.
    #[serde(alias = "torque_nm_per_v")]
    pub force_n_per_v: f64,
    /// Points of the moving body's frame at which the force attacks, in m; each takes an equal share.
    #[serde(default)]
    pub lines_of_action_m: Vec<[f64; 3]>,
}

impl Motor {
    /// Points of the moving body's frame at which the force attacks, in m.
    pub fn lines_of_action_m(&self) -> &[[f64; 3]] {
        match self {
            Self::Winding(winding) => &winding.lines_of_action_m,
            Self::Direct(direct) => &direct.lines_of_action_m,
        }
    }
}

/// The electrical constants that a step needs, ready for one step length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Circuit {
    /// R–L circuit.
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

impl From<&Motor> for Circuit {
    fn from(motor: &Motor) -> Self {
        match motor {
            Motor::Winding(w) => Self::Winding {
                resistance_ohm: w.resistance_ohm,
                inductance_h: w.inductance_h,
                force_constant: w.force_constant_n_per_a,
                back_emf: w.back_emf_v_s_per_m,
            },
            Motor::Direct(d) => Self::Direct { force_per_volt: d.force_n_per_v },
        }
    }
}

/// Advances the current over a piece of time in which the voltage does not change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CircuitStep {
    duration_s: f64,
    decay: f64,
    mean_weight: f64,
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
        let settled = (voltage_v - self.back_emf * velocity) * self.inverse_resistance;
        let offset = *current - settled;
        *current = settled + offset * self.decay;
        settled + offset * self.mean_weight
    }
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
    fn exact_two_half_steps_are_one_step() {
        let (whole, half) = (CircuitStep::new(&CIRCUIT, 1e-3), CircuitStep::new(&CIRCUIT, 5e-4));
        let (mut a, mut b) = (0.4, 0.4);
        let mean = whole.advance(&mut a, 3.0, 0.2);
        let halves = 0.5 * (half.advance(&mut b, 3.0, 0.2) + half.advance(&mut b, 3.0, 0.2));
        assert!((a - b).abs() < 1e-14 && (mean - halves).abs() < 1e-14);
    }
}
