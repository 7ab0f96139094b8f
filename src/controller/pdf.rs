//! Pseudo-derivative feedback with integer gains.

use super::integer::{IntegerGain, Scale};
use super::{Filter, Gains};
use serde::{Deserialize, Serialize};

/// Pseudo-derivative-feedback (PDF) velocity loop with integer gains, inside a proportional position
/// loop with velocity feed-forward.
///
/// # Model
/// ```text
///   e = s·( Kv·(x_ref − x) + f·v_ref − v )        s: controller velocity units per SI unit
///   I ← I + n_i·k1·T·e
///   u = I − n_p·k2·s·v                            volts
/// ```
/// with the register values n_i (`integral`) and n_p (`proportional`). Positive effort drives the axis
/// along its positive direction. The proportional part acts on the measured velocity only: that is what
/// distinguishes PDF from PI, and why u falls when v rises (the paper's eq. 8 prints the opposite sign).
///
/// # Validity
/// Floating-point accumulation; the registers saturate at 16 bits, the effort at the amplifier.
///
/// # Source
/// Liu, Lai, Yen (2009), section 3, eqs. 1–9, with the sign of C2 corrected; position loop and
/// feed-forward are assumed (they reproduce section 5 of that paper).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pdf {
    /// Register n_i of the integral gain.
    pub integral: IntegerGain,
    /// Register n_p of the proportional gain.
    pub proportional: IntegerGain,
    /// k1: V/s per controller velocity unit and count of `integral`.
    pub integral_gain_per_count: f64,
    /// k2: V per controller velocity unit and count of `proportional`.
    pub proportional_gain_per_count: f64,
    /// s: controller velocity units in one SI unit (1000 when it computes in mm/s).
    pub velocity_units_per_si: f64,
    /// Kv of the position loop in 1/s.
    pub position_gain_per_s: f64,
    /// f, the share of the reference velocity fed forward.
    pub velocity_feedforward: f64,
    /// Filters of the effort, in their order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub filter: Vec<Filter>,
}

impl Pdf {
    /// n_i·k1·s in V/m (V/rad).
    pub fn integral_gain_si(&self) -> f64 {
        self.scale(self.integral_gain_per_count).si(self.integral)
    }

    /// n_p·k2·s in V·s/m (V·s/rad).
    pub fn proportional_gain_si(&self) -> f64 {
        self.scale(self.proportional_gain_per_count).si(self.proportional)
    }

    fn scale(&self, gain_per_count: f64) -> Scale {
        Scale { gain_per_count, velocity_units_per_si: self.velocity_units_per_si }
    }

    pub(super) fn gains(&self, period_s: f64) -> Gains {
        Gains {
            position: self.position_gain_per_s,
            feedforward: self.velocity_feedforward,
            integral: self.integral_gain_si() * period_s,
            error: 0.0,
            velocity: self.proportional_gain_si(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Input, Memory};
    use super::*;

    fn law() -> Pdf {
        Pdf {
            integral: IntegerGain::saturating(19),
            proportional: IntegerGain::saturating(260),
            integral_gain_per_count: 6.942e-2,
            proportional_gain_per_count: 2.359e-4,
            velocity_units_per_si: 1000.0,
            position_gain_per_s: 6.5,
            velocity_feedforward: 0.7,
            filter: Vec::new(),
        }
    }

    #[test]
    fn ref_published_gains() {
        // Physics sheet 1.1 point 4: 19·k1 = 1.319 1/s and 260·k2 = 0.0613, per mm/s.
        assert!((law().integral_gain_si() / 1000.0 - 1.319).abs() < 5e-4);
        assert!((law().proportional_gain_si() / 1000.0 - 0.0613).abs() < 5e-5);
    }

    #[test]
    fn exact_positive_velocity_lowers_the_effort() {
        let still = Input { position_reference: 0.0, velocity_reference: 0.0, position: 0.0, velocity: 0.0 };
        let moving = Input { velocity: 0.1, ..still };
        let gains = law().gains(250e-6);
        let (mut a, mut b) = (Memory::default(), Memory::default());
        assert!(gains.effort_v(&mut b, moving) < gains.effort_v(&mut a, still));
    }
}
