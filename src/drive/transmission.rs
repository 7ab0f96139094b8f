//! The transmission between motor and joint: gearbox, belt or screw.

use super::motor::Circuit;
use serde::{Deserialize, Serialize};

/// A rigid transmission with what turns on the motor's side of it.
///
/// # Model
/// With n motor angle per joint displacement, motor torque τ and rotor inertia J about the motor's axis:
/// ```text
///   F = n·τ        motor speed = n·q̇        inertia at the joint = J·n²
/// ```
/// F in N or N·m at the joint; positive torque drives the joint along its positive direction. So Kt and Ke of the motor, per
/// ampere and per rad/s of its own shaft, count n times at the joint. J·n² is accelerated with the moving part and has no weight.
/// What is transmitted is the motor's effort less what accelerates the rotor; with m the inertia of the load's side and W what
/// pulls at the load (weight), and friction left aside:
/// ```text
///   F_t = F − J·n²·q̈ = (m·F − J·n²·W)/(m + J·n²)
/// ```
///
/// # Validity
/// No play, no compliance (both are effects), no base that moves under the axis.
///
/// # Source
/// Siciliano, Sciavicco, Villani, Oriolo (2009), *Robotics*, section 5.2 (transmissions), 7.2 (reflected rotor inertia).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Transmission {
    /// n in rad/rad, or rad/m for a sliding axis: 2π over the lead of a screw.
    #[serde(default = "direct", alias = "ratio_rad_per_m")]
    pub ratio: f64,
    /// J in kg·m², about the motor's axis.
    #[serde(default)]
    pub rotor_inertia_kg_m2: f64,
}

fn direct() -> f64 {
    1.0
}

impl Transmission {
    /// Travel of the joint in a turn of the motor, 2π/n, in m or rad: the lead of a screw.
    pub fn turn(&self) -> f64 {
        std::f64::consts::TAU / self.ratio.abs()
    }

    /// J·n²: kg·m², or kg for a sliding axis.
    pub fn inertia_at_joint(&self) -> f64 {
        self.rotor_inertia_kg_m2 * self.ratio * self.ratio
    }

    /// The motor's circuit as the joint sees it.
    #[must_use]
    pub fn at_joint(&self, circuit: Circuit) -> Circuit {
        match circuit {
            Circuit::Winding { resistance_ohm, inductance_h, force_constant, back_emf } => Circuit::Winding {
                resistance_ohm,
                inductance_h,
                force_constant: self.ratio * force_constant,
                back_emf: self.ratio * back_emf,
            },
            Circuit::Direct { force_per_volt } => {
                Circuit::Direct { force_per_volt: self.ratio * force_per_volt }
            }
        }
    }
}
