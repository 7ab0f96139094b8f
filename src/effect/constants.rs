//! The constants of the twin, gathered so that effects can move them.

use crate::base::Modes;
use crate::controller::Controller;
use crate::drive::amplifier::Amplifier;
use crate::drive::motor::Circuit;
use crate::guide::DryFriction;
use crate::sensor::{LogScale, VelocityEstimate};

/// The numbers of the twin, along the driven joint.
///
/// Mass means inertia and force means torque on a revolute axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Constants {
    /// Control law; none where it is not known.
    pub controller: Option<Controller>,
    /// Amplifier.
    pub amplifier: Amplifier,
    /// Motor circuit.
    pub circuit: Circuit,
    /// Pitches at which something may repeat, as the machine file states them: of the magnets, of a screw, of a turn of the
    /// motor; m or rad.
    pub stated_pitches: Vec<f64>,
    /// Whether the circuit is a winding fed with voltage, not a current loop with the equation of one.
    pub has_voltage_fed_winding: bool,
    /// Moving mass in kg, or inertia about the joint's axis in kg·m².
    pub moving_mass: f64,
    /// Share of it that is the rotor's, seen from the joint, and has no weight, in kg or kg·m².
    pub rotor_inertia: f64,
    /// Whether a transmission lies between motor and joint.
    pub has_transmission: bool,
    /// Whether weight along the joint changes with its position: a revolute axis whose moving part is off its centre.
    pub has_turning_weight: bool,
    /// Viscous coefficient of the guide in N·s/m, or N·m·s/rad.
    pub viscous: f64,
    /// Dry friction of the guide; effects state it.
    pub friction: DryFriction,
    /// Whether the guide has four bearing sliders whose loads are known.
    pub has_slider_loads: bool,
    /// Modes of the base at the point that receives the reaction.
    pub modes: Modes,
    /// Whether a sensor sees the load's end of the drive train.
    pub sees_load: bool,
    /// Whether both ends of the drive train have their own sensor.
    pub sees_both_ends: bool,
    /// Step to which every encoder reading is rounded in all replays, in m or rad; 0: none.
    pub reading_step: f64,
    /// Stated step of the encoder in m or rad; 0: none.
    pub encoder_step: f64,
    /// Scale of the logged current and effort.
    pub log_scale: LogScale,
    /// How velocity is estimated from encoder readings.
    pub velocity: VelocityEstimate,
    /// Sample period in s.
    pub sample_period_s: f64,
}

impl Constants {
    /// Motor force per ampere (per volt of a direct motor), N/A or N·m/A.
    pub fn force_constant(&self) -> f64 {
        match self.circuit {
            Circuit::Winding { force_constant, .. } => force_constant,
            Circuit::Direct { force_per_volt } => force_per_volt,
        }
    }

    /// Magnitude of the effort in V beyond which controller or amplifier clip it; none where neither does.
    pub fn effort_limit_v(&self) -> Option<f64> {
        let own = self.controller.as_ref().and_then(|law| law.limit()).map(|limit| limit.effort_limit_v);
        [own, self.amplifier.voltage_limit_v].into_iter().flatten().reduce(f64::min)
    }

    /// Motor force per volt of effort in the steady state at standstill, N/V or N·m/V.
    pub fn force_per_volt(&self) -> f64 {
        match self.circuit {
            Circuit::Winding { resistance_ohm, force_constant, .. } => {
                self.amplifier.gain() * force_constant / resistance_ohm
            }
            Circuit::Direct { force_per_volt } => self.amplifier.gain() * force_per_volt,
        }
    }
}
