//! Proportional position control, with or without a derivative part.

use super::{Filter, Gains};
use serde::{Deserialize, Serialize};

/// Position control without a velocity loop: P, or PD with the derivative on the velocity error.
///
/// # Model
/// ```text
///   u = Kp·(x_ref − x) + Kd·(f·v_ref − v)        volts
/// ```
/// Positive effort drives the axis along its positive direction. Kd = 0 is the P law of a hobby servo, f = 0 a derivative that
/// acts on the measured velocity only, f = 1 one on the error's. Where the amplifier takes a duty cycle
/// ([`supply_v`](crate::drive::amplifier::Amplifier::supply_v)), one volt of effort stands for a duty of 1 and Kp is in 1/m or 1/rad.
///
/// # Validity
/// No integral part: a constant load leaves a standing error of load/(Kp·force per volt).
///
/// # Source
/// Åström, Hägglund, *PID Controllers: Theory, Design, and Tuning*, 2nd ed. (1995), section 3.4 (set-point weight of the
/// derivative).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pd {
    /// Kp in V/m, or V/rad for a revolute axis.
    #[serde(alias = "position_gain_v_per_rad")]
    pub position_gain_v_per_m: f64,
    /// Kd in V·s/m, or V·s/rad for a revolute axis.
    #[serde(default, alias = "derivative_gain_v_s_per_rad")]
    pub derivative_gain_v_s_per_m: f64,
    /// f, the share of the reference velocity in the derivative part.
    #[serde(default)]
    pub velocity_feedforward: f64,
    /// Filters of the effort, in their order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub filter: Vec<Filter>,
}

impl Pd {
    pub(super) fn gains(&self) -> Gains {
        let derivative = self.derivative_gain_v_s_per_m;
        // e = Kp·(x_ref − x) + Kd·f·v_ref − v; what e has of the velocity too much or too little stands beside it.
        Gains {
            position: self.position_gain_v_per_m,
            feedforward: derivative * self.velocity_feedforward,
            integral: 0.0,
            error: 1.0,
            velocity: derivative - 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Controller, Input, Memory};
    use super::*;

    #[test]
    fn exact_effort_by_hand() {
        let law = |derivative: f64, share: f64| {
            Controller::Pd(Pd {
                position_gain_v_per_m: 40.0,
                derivative_gain_v_s_per_m: derivative,
                velocity_feedforward: share,
                filter: Vec::new(),
            })
        };
        let input = Input { position_reference: 0.5, velocity_reference: 2.0, position: 0.3, velocity: 1.5 };
        for (law, expected) in
            [(law(0.0, 0.0), 8.0), (law(0.2, 0.0), 8.0 - 0.3), (law(0.2, 1.0), 8.1), (law(0.0, 1.0), 8.0)]
        {
            let effort = law.effort_v(&mut Memory::default(), input, 1e-3);
            assert!((effort - expected).abs() < 1e-12, "{effort} for {expected}");
        }
    }
}
