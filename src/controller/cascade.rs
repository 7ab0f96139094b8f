//! Cascade of a proportional position loop and a proportional-integral velocity loop.

use super::{AntiWindup, EffortLimit, Filter, Gains};
use serde::{Deserialize, Serialize};

/// Cascade control: position P, velocity PI, with optional velocity feed-forward.
///
/// # Model
/// ```text
///   e = Kp·(x_ref − x) + f·v_ref − v
///   I ← I + Kv·Ki·T·e
///   u = clip(Kv·e + I, ±u_max)         volts
/// ```
/// Positive effort drives the axis along its positive direction. `Ki = 0` gives the P–P cascade. Without u_max nothing is
/// clipped here; with it, [`AntiWindup`] says what I does meanwhile.
///
/// # Validity
/// I knows of the law's own limit only: it goes on when the amplifier clips below it. The position loop's output, a velocity,
/// is not limited.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cascade {
    /// Kp in 1/s.
    pub position_gain_per_s: f64,
    /// Kv in V·s/m, or V·s/rad for a revolute axis.
    #[serde(alias = "velocity_gain_v_s_per_rad")]
    pub velocity_gain_v_s_per_m: f64,
    /// Ki in 1/s.
    #[serde(default)]
    pub velocity_integral_per_s: f64,
    /// f, the share of the reference velocity fed forward.
    #[serde(default)]
    pub velocity_feedforward: f64,
    /// u_max in V; absent: the law does not clip.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effort_limit_v: Option<f64>,
    /// What the integral part does while the law clips.
    #[serde(default, skip_serializing_if = "is_none")]
    pub anti_windup: AntiWindup,
    /// Filters of the limited effort, in their order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub filter: Vec<Filter>,
}

fn is_none(anti_windup: &AntiWindup) -> bool {
    *anti_windup == AntiWindup::None
}

impl Cascade {
    pub(super) fn limit(&self) -> Option<EffortLimit> {
        let anti_windup = self.anti_windup;
        self.effort_limit_v.map(|effort_limit_v| EffortLimit { effort_limit_v, anti_windup })
    }

    pub(super) fn gains(&self, period_s: f64) -> Gains {
        let velocity = self.velocity_gain_v_s_per_m;
        Gains {
            position: self.position_gain_per_s,
            feedforward: self.velocity_feedforward,
            integral: velocity * self.velocity_integral_per_s * period_s,
            error: velocity,
            velocity: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Controller, Input};
    use super::*;

    #[test]
    fn exact_taking_over_repeats_the_effort() {
        let law = Controller::Cascade(Cascade {
            position_gain_per_s: 160.0,
            velocity_gain_v_s_per_m: 240.0,
            velocity_integral_per_s: 12.0,
            velocity_feedforward: 0.3,
            effort_limit_v: Some(10.0),
            anti_windup: AntiWindup::Clamping,
            filter: vec![Filter::LowPass { frequency_hz: 200.0, damping: None }],
        });
        let input =
            Input { position_reference: 0.01, velocity_reference: 0.2, position: 0.009, velocity: 0.15 };
        let mut memory = law.memory_for(3.5, input, 1e-3);
        assert!((law.effort_v(&mut memory, input, 1e-3) - 3.5).abs() < 1e-12);
    }
}
