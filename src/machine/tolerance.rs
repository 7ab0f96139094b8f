//! How far a stated constant may be off before that counts as a cause.

use super::bounds::zero_or_more;
use crate::error::Result;
use serde::{Deserialize, Serialize};

/// Tolerances of the stated constants, as fractions of their values; that of a zero in rad.
///
/// Inside its tolerance a deviation is *calibration*: estimated together with every hypothesis and reported
/// as such. Beyond it, it is a cause.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Tolerance {
    /// Moving mass or inertia.
    pub mass: f64,
    /// Viscous coefficient of the guide.
    pub viscous: f64,
    /// Force or torque constant of the motor.
    pub force_constant: f64,
    /// Resistance of the winding.
    pub resistance: f64,
    /// Inductance of the winding.
    pub inductance: f64,
    /// Zero of the encoder of a revolute axis that has weight, in rad. 0.01 where it is not stated: half a degree, as a lever is aligned by
    /// hand (engineering estimate).
    pub zero_rad: f64,
    /// Parameters of effects that the twin already has.
    pub effect: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self {
            mass: 0.03,
            viscous: 0.12,
            force_constant: 0.015,
            resistance: 0.03,
            inductance: 0.05,
            zero_rad: 0.01,
            effect: 0.10,
        }
    }
}

impl Tolerance {
    pub(super) fn check(&self) -> Result<()> {
        zero_or_more("tolerance.mass", self.mass)?;
        zero_or_more("tolerance.viscous", self.viscous)?;
        zero_or_more("tolerance.force_constant", self.force_constant)?;
        zero_or_more("tolerance.resistance", self.resistance)?;
        zero_or_more("tolerance.inductance", self.inductance)?;
        zero_or_more("tolerance.zero_rad", self.zero_rad)?;
        zero_or_more("tolerance.effect", self.effect)
    }
}
