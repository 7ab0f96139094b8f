//! A torque-controlled amplifier: a closed current loop around the winding.

use super::amplifier::Amplifier;
use super::circuit::Circuit;
use serde::{Deserialize, Serialize};

/// A current loop of first order with the torque constant of the motor behind it.
///
/// # Model
/// ```text
///   τ·di/dt = clip(k·u, ±i_max) − i        F = Kt·i
/// ```
/// u is the control effort in V, the drive's analogue current command; k its scale in A/V. Where a drive takes its command
/// in A, k = 1 A/V and a stored volt stands for one ampere. Positive effort drives the axis along its positive direction.
///
/// `L·di/dt = u − R·i` with `R = 1/k` and `L = τ/k` is the same equation, so the loop runs as a
/// [`Circuit::Winding`] with these two and without back-EMF: exactly, on every plant. R and L are not those of the copper,
/// and what is known of a winding (tolerances, R and L off nominal, back-EMF) does not apply to them.
///
/// # Validity
/// The current controller has the voltage that it needs: back-EMF and R, L of the copper are hidden inside the loop. Not
/// near the speed at which the supply is used up. The limit acts on the command, so i never exceeds it.
///
/// # Source
/// Leonhard, *Control of Electrical Drives*, 3rd ed. (2001): the closed current loop as a first-order lag, for the design
/// of the speed loop around it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurrentLoop {
    /// k in A/V.
    #[serde(default = "one_ampere")]
    pub command_a_per_v: f64,
    /// τ in s; for a loop of bandwidth f_c, 1/(2π·f_c).
    pub time_constant_s: f64,
    /// Kt in N/A, or N·m/A for a revolute axis.
    #[serde(alias = "torque_constant_nm_per_a")]
    pub force_constant_n_per_a: f64,
    /// i_max in A; absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub current_limit_a: Option<f64>,
    /// Points of the moving body's frame at which the force attacks, in m; each takes an equal share.
    #[serde(default)]
    pub lines_of_action_m: Vec<[f64; 3]>,
    /// Pitch of the magnets (a north and a south pole) along the axis in m, or rad; a diagnosis tries it first.
    #[serde(default, skip_serializing_if = "Option::is_none", alias = "magnet_pitch_rad")]
    pub magnet_pitch_m: Option<f64>,
}

fn one_ampere() -> f64 {
    1.0
}

impl CurrentLoop {
    /// The circuit with the loop's equation.
    pub fn circuit(&self) -> Circuit {
        let Self { command_a_per_v: k, time_constant_s: tau, force_constant_n_per_a, .. } = *self;
        Circuit::Winding {
            resistance_ohm: 1.0 / k,
            inductance_h: tau / k,
            force_constant: force_constant_n_per_a,
            back_emf: 0.0,
        }
    }

    /// The amplifier with the current limit as one of the command: ±i_max/k in V.
    #[must_use]
    pub fn limited(&self, mut amplifier: Amplifier) -> Amplifier {
        let own = self.current_limit_a.map(|limit| limit / self.command_a_per_v);
        amplifier.voltage_limit_v = match (own, amplifier.voltage_limit_v) {
            (Some(own), Some(stated)) => Some(own.min(stated)),
            (own, stated) => own.or(stated),
        };
        amplifier
    }
}

#[cfg(test)]
mod tests {
    use super::super::circuit::CircuitStep;
    use super::*;

    const LOOP: CurrentLoop = CurrentLoop {
        command_a_per_v: 0.9,
        time_constant_s: 0.7e-3,
        force_constant_n_per_a: 0.5,
        current_limit_a: Some(6.0),
        lines_of_action_m: Vec::new(),
        magnet_pitch_m: None,
    };

    #[test]
    fn exact_step_of_a_first_order_loop() {
        for step_s in [50e-6, 0.7e-3, 2e-3, 20e-3] {
            let step = CircuitStep::new(&LOOP.circuit(), step_s);
            let mut current = 0.3;
            // Speed does not reach the current.
            let mean = step.advance(&mut current, 2.0, 1234.5);
            let (decay, settled) = ((-step_s / 0.7e-3f64).exp(), 1.8);
            assert!((current - (settled + (0.3 - settled) * decay)).abs() < 1e-13, "{step_s}: {current}");
            let expected = settled + (0.3 - settled) * (1.0 - decay) * 0.7e-3 / step_s;
            assert!((mean - expected).abs() < 1e-13, "{step_s}: {mean} {expected}");
        }
        assert_eq!(CircuitStep::new(&LOOP.circuit(), 1e-3).effort_constant(), 0.5);
    }

    #[test]
    fn exact_limit_is_one_of_the_current() {
        let amplifier = LOOP.limited(Amplifier::default());
        let step = CircuitStep::new(&LOOP.circuit(), 1.0);
        for command_v in [-100.0, 7.0, 1e6] {
            let mut current = 0.0;
            step.advance(&mut current, amplifier.output_v(command_v), 0.0);
            assert!((current.abs() - 6.0).abs() < 1e-12, "{current}");
        }
        let tighter = Amplifier { voltage_limit_v: Some(2.0), ..Amplifier::default() };
        assert_eq!(LOOP.limited(tighter).voltage_limit_v, Some(2.0));
        let open = CurrentLoop { current_limit_a: None, ..LOOP };
        assert_eq!(open.limited(Amplifier::default()), Amplifier::default());
    }
}
