//! The constants of the twin's linear parts, gathered so that effects can move them.

use crate::base::Modes;
use crate::drive::motor::Circuit;

/// The numbers of the twin's linear parts, along the driven joint.
///
/// Mass means inertia and force means torque on a revolute axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Constants {
    /// Moving mass in kg, or inertia about the joint's axis in kg·m².
    pub moving_mass: f64,
    /// Viscous coefficient of the guide in N·s/m, or N·m·s/rad.
    pub viscous: f64,
    /// Symmetric Coulomb friction of the guide in N, or N·m; it acts through its effect.
    pub coulomb: f64,
    /// Motor circuit.
    pub circuit: Circuit,
    /// Symmetric limit of the amplifier's voltage in V, if it has one.
    pub voltage_limit_v: Option<f64>,
    /// Delay between commanded and applied voltage in s.
    pub delay_s: f64,
    /// Modes of the base at the point that receives the reaction.
    pub modes: Modes,
    /// Sample period in s.
    pub sample_period_s: f64,
}
