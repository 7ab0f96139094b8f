//! Feed-forward: what the controller adds because it knows the motion beforehand.

use crate::controller::ReferenceDelay;
use crate::drive::motor::Circuit;
use crate::error::{Error, ErrorKind, Result, toml_text};
use crate::machine::Machine;
use crate::recording::{FEEDFORWARD_KEY, Run, Signal};
use crate::solid::Weight;
use crate::twin::Command;
use serde::{Deserialize, Serialize};

/// Inverse-dynamics feed-forward: the force that the reference motion needs, added to the controller's effort.
///
/// # Model
/// ```text
///   F = m·a_ref + c·v_ref + F_c·sgn(v) − W(q_ref)        sgn(0) = 0
/// ```
/// with a_ref and v_ref the differences of the position reference q_ref as the controller sees it, v as [`Direction`]
/// says, and W the weight along the joint as the machine file states it ([`crate::solid::Weight`]), where `weight` asks for
/// it. It becomes a voltage by the steady state of the motor as stated: `F/K` for a direct motor, `R·F/Kt + Ke·v_ref` for a
/// winding. Positive force acts along positive position.
///
/// The voltage is added between controller and amplifier. The effort that is logged and predicted is the controller's own.
///
/// # Validity
/// Feed-forward computed once a sample, behind the controller's own limit. A winding's inductance is not inverted.
///
/// # Source
/// Siciliano, Sciavicco, Villani, Oriolo, *Robotics*, sections 8.3 (decentralised feed-forward compensation) and 8.5.1
/// (gravity compensation).
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Feedforward {
    /// m in kg, or inertia in kg·m² for a revolute axis.
    #[serde(alias = "inertia_kg_m2")]
    pub mass_kg: f64,
    /// c in N·s/m, or N·m·s/rad for a revolute axis.
    #[serde(alias = "viscous_nm_s_per_rad")]
    pub viscous_n_s_per_m: f64,
    /// F_c in N, or N·m for a revolute axis.
    #[serde(alias = "coulomb_nm")]
    pub coulomb_n: f64,
    /// Which velocity tells the direction of the Coulomb part.
    pub direction: Direction,
    /// Whether the machine's weight along the joint is held at the reference position.
    pub weight: bool,
}

/// Which velocity tells the direction of a Coulomb feed-forward.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// The reference's.
    #[default]
    Reference,
    /// The controller's estimate from the encoder: of a recorded run the logged one, of a twin its own of the sample before.
    Measured,
}

impl Feedforward {
    /// The feed-forward that a recorded run states under the key `feedforward`; none where it states none.
    ///
    /// # Errors
    /// Anything but a table of this type's fields, or a number that is not finite.
    pub fn of(run: &Run) -> Result<Self> {
        let Some(stated) = run.metadata.get(FEEDFORWARD_KEY) else { return Ok(Self::default()) };
        let place = |kind| {
            let error = Error::new(kind).key(format!("{}.{FEEDFORWARD_KEY}", run.name()));
            if run.file.as_os_str().is_empty() { error } else { error.file(&run.file) }
        };
        let read: Self = stated.clone().try_into().map_err(|e: toml::de::Error| {
            let unknown = e.message().starts_with("unknown");
            let kind = if unknown { ErrorKind::UnknownKey } else { ErrorKind::Syntax };
            toml_text::explained(place(kind), e.message()).remedy(
                "state mass_kg, viscous_n_s_per_m, coulomb_n, direction and weight, as far as they were fed forward",
            )
        })?;
        match [read.mass_kg, read.viscous_n_s_per_m, read.coulomb_n].into_iter().find(|x| !x.is_finite()) {
            None => Ok(read),
            Some(number) => Err(place(ErrorKind::NotFinite)
                .found(number.to_string())
                .expected("finite numbers")
                .remedy("correct the feed-forward of this run in recording.toml")),
        }
    }

    /// Force or torque in N or N·m for a reference motion and a velocity that tells the direction, in SI.
    pub fn force(&self, acceleration: f64, velocity: f64, direction: f64) -> f64 {
        let sign = if direction == 0.0 { 0.0 } else { direction.signum() };
        self.mass_kg * acceleration + self.viscous_n_s_per_m * velocity + self.coulomb_n * sign
    }

    /// The voltages that a recorded run was fed beside its logged effort, a number a sample; none where it states no
    /// feed-forward. The machine is as it was set in the run.
    ///
    /// # Errors
    /// As [`of`](Self::of); uneven time stamps; a Coulomb part by a measured velocity that was not logged.
    pub(super) fn recorded_v(run: &Run, commands: &[Command], machine: &Machine) -> Result<Option<Vec<f64>>> {
        if !run.metadata.contains_key(FEEDFORWARD_KEY) {
            return Ok(None);
        }
        run.require_even("a feed-forward")?;
        let forward = Self::of(run)?;
        let measured = match forward.direction {
            Direction::Measured if forward.coulomb_n != 0.0 => Some(run.require(Signal::Velocity)?),
            _ => None,
        };
        let course = Course::of(forward, commands, machine);
        let voltage = |k: usize| course.voltage(k, measured.map_or(0.0, |velocity| velocity[k]));
        Ok(Some((0..commands.len()).map(voltage).collect()))
    }
}

/// A feed-forward along the references of a run.
pub(super) struct Course {
    forward: Feedforward,
    circuit: Circuit,
    /// Volts applied per volt of command.
    gain: f64,
    weight: Option<Weight>,
    /// Position and velocity as they reach the controller.
    references: Vec<[f64; 2]>,
    period_s: f64,
}

impl Course {
    pub(super) fn of(forward: Feedforward, commands: &[Command], machine: &Machine) -> Self {
        let period_s = machine.description().sample_period_s;
        let mut delay = ReferenceDelay::new(machine.description().reference.delay_s, period_s);
        let seen = |command: &Command| {
            let stated = [command.position_reference, command.velocity_reference];
            delay.as_mut().map_or(stated, |delay| delay.pass(stated[0], stated[1]))
        };
        Self {
            forward,
            circuit: machine.stated_constants().circuit,
            gain: machine.stated_constants().amplifier.gain(),
            weight: machine.weight().filter(|_| forward.weight),
            references: commands.iter().map(seen).collect(),
            period_s,
        }
    }

    /// Voltage at a sample; `measured` is the velocity that the controller estimates.
    pub(super) fn voltage(&self, k: usize, measured: f64) -> f64 {
        let Some(&[position, velocity]) = self.references.get(k) else { return 0.0 };
        let direction = match self.forward.direction {
            Direction::Reference => velocity,
            Direction::Measured => measured,
        };
        let held = self.weight.map_or(0.0, |weight| weight.effort(position));
        let force = self.forward.force(self.acceleration(k), velocity, direction) - held;
        steady_command(&self.circuit, self.gain, force, velocity)
    }

    /// Acceleration of the reference at sample k: the velocity reference looks back one period, so the difference to the
    /// next one is centred on the sample.
    fn acceleration(&self, k: usize) -> f64 {
        let last = self.references.len() - 1;
        let (from, to) = if k < last { (k, k + 1) } else { (k.saturating_sub(1), k) };
        (self.references[to][1] - self.references[from][1]) / self.period_s
    }
}

/// Command to an amplifier of so many volts per volt of command that holds a force at a velocity in the steady state.
pub(super) fn steady_command(circuit: &Circuit, gain: f64, force: f64, velocity: f64) -> f64 {
    let voltage_v = match *circuit {
        Circuit::Direct { force_per_volt } => force / force_per_volt,
        Circuit::Winding { resistance_ohm, force_constant, back_emf, .. } => {
            resistance_ohm * force / force_constant + back_emf * velocity
        }
    };
    voltage_v / gain
}
