//! The motor: from the amplifier's output to force or torque.

pub use super::circuit::{Circuit, CircuitStep, StepCurrent};
use super::current_loop::CurrentLoop;
use serde::{Deserialize, Serialize};

/// How the motor turns what the amplifier gives into effort.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Motor {
    /// Voltage-fed winding with resistance and inductance.
    Winding(Winding),
    /// Torque-controlled amplifier: a current loop that follows its command with a lag.
    CurrentLoop(CurrentLoop),
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
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
    /// Pitch of the magnets (a north and a south pole) along the axis in m, or rad; a diagnosis tries it first.
    #[serde(default, skip_serializing_if = "Option::is_none", alias = "magnet_pitch_rad")]
    pub magnet_pitch_m: Option<f64>,
}

/// An effort that follows the commanded voltage without delay: `F = K·u`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Direct {
    /// K in N/V, or N·m/V for a revolute axis.
    #[serde(alias = "torque_nm_per_v")]
    pub force_n_per_v: f64,
    /// Points of the moving body's frame at which the force attacks, in m; each takes an equal share.
    #[serde(default)]
    pub lines_of_action_m: Vec<[f64; 3]>,
    /// Pitch of the magnets (a north and a south pole) along the axis in m, or rad; a diagnosis tries it first.
    #[serde(default, skip_serializing_if = "Option::is_none", alias = "magnet_pitch_rad")]
    pub magnet_pitch_m: Option<f64>,
}

impl Motor {
    /// Points of the moving body's frame at which the force attacks, in m.
    pub fn lines_of_action_m(&self) -> &[[f64; 3]] {
        match self {
            Self::Winding(winding) => &winding.lines_of_action_m,
            Self::CurrentLoop(current_loop) => &current_loop.lines_of_action_m,
            Self::Direct(direct) => &direct.lines_of_action_m,
        }
    }

    /// Pitch of the magnets along the axis in m or rad, where it is stated.
    pub fn magnet_pitch(&self) -> Option<f64> {
        match self {
            Self::Winding(winding) => winding.magnet_pitch_m,
            Self::CurrentLoop(current_loop) => current_loop.magnet_pitch_m,
            Self::Direct(direct) => direct.magnet_pitch_m,
        }
    }

    /// Whether the motor has a current that follows its command or voltage with a lag, and that a log may hold.
    pub fn has_current(&self) -> bool {
        match self {
            Self::Winding(_) | Self::CurrentLoop(_) => true,
            Self::Direct(_) => false,
        }
    }
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
            Motor::CurrentLoop(current_loop) => current_loop.circuit(),
            Motor::Direct(d) => Self::Direct { force_per_volt: d.force_n_per_v },
        }
    }
}
