//! Replay with a feed-forward: what the controller adds because it knows the motion beforehand.

use super::{Recorded, Traces};
use crate::drive::motor::Circuit;
use crate::error::{Error, ErrorKind, Result, toml_text};
use crate::machine::Machine;
use crate::plant::Plant;
use crate::recording::Run;
use crate::twin::{Command, Sensing};
use serde::{Deserialize, Serialize};

/// The key of a run under which a recording states its feed-forward.
pub const RUN_KEY: &str = "feedforward";

/// Inverse-dynamics feed-forward: the force that the reference motion needs, added to the controller's effort.
///
/// # Model
/// ```text
///   F = m·a_ref + c·v_ref + F_c·sgn(v)        sgn(0) = 0
/// ```
/// with a_ref and v_ref the differences of the position reference, and v as [`Direction`] says. It becomes a
/// voltage by the motor's steady state: `F/K` for a direct motor, `R·F/Kt + Ke·v_ref` for a winding.
/// Positive force acts along positive position.
///
/// # Validity
/// Feed-forward computed once a sample. On the measured velocity it uses the estimate of the sample before, so it
/// changes sign one sample late. A winding's inductance is not inverted.
///
/// # Source
/// Siciliano, Sciavicco, Villani, Oriolo, *Robotics*, section 8.3 (decentralised feed-forward compensation).
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
}

/// Which velocity tells the direction of a Coulomb feed-forward.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// The reference's.
    #[default]
    Reference,
    /// The controller's estimate from the encoder.
    Measured,
}

/// A replay with a feed-forward: the traces, and what of the effort was fed forward.
#[derive(Debug, Clone, PartialEq)]
pub struct Compensated {
    /// What the replay yields; the effort is the whole one.
    pub traces: Traces,
    /// What was fed forward in V, a number a sample.
    pub feedforward_v: Vec<f64>,
}

impl Compensated {
    /// The effort that the controller's feedback was left to command, in V.
    pub fn feedback_v(&self) -> Vec<f64> {
        self.traces.effort_v.iter().zip(&self.feedforward_v).map(|(whole, forward)| whole - forward).collect()
    }
}

impl Feedforward {
    /// The feed-forward that a recorded run states under the key `feedforward`; none where it states none.
    ///
    /// # Errors
    /// Anything but a table of this type's fields, or a number that is not finite.
    pub fn of(run: &Run) -> Result<Self> {
        let Some(stated) = run.metadata.get(RUN_KEY) else { return Ok(Self::default()) };
        let place = |kind| {
            let error = Error::new(kind).key(format!("{}.{RUN_KEY}", run.name()));
            if run.file.as_os_str().is_empty() { error } else { error.file(&run.file) }
        };
        let read: Self = stated.clone().try_into().map_err(|e: toml::de::Error| {
            let unknown = e.message().starts_with("unknown");
            let kind = if unknown { ErrorKind::UnknownKey } else { ErrorKind::Syntax };
            toml_text::explained(place(kind), e.message()).remedy(
                "state mass_kg, viscous_n_s_per_m, coulomb_n and direction, as far as they were fed forward",
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

    /// Replays a recorded run in closed loop on a plant, with this feed-forward beside the controller.
    pub fn replay<P: Plant>(
        &self,
        recorded: &Recorded,
        machine: &Machine,
        plant: P,
        sensing: Sensing,
    ) -> Compensated {
        let mut twin = recorded.twin(machine, plant, sensing);
        let circuit = machine.constants().circuit;
        let commands = recorded.commands();
        let mut traces = Traces::with_capacity(commands.len());
        let mut feedforward_v = Vec::with_capacity(commands.len());
        let mut measured = recorded.start().velocity;
        for (k, &command) in commands.iter().enumerate() {
            let velocity = command.velocity_reference;
            let direction = match self.direction {
                Direction::Reference => velocity,
                Direction::Measured => measured,
            };
            let acceleration = acceleration(commands, k, twin.period_s());
            let forward_v = voltage(&circuit, self.force(acceleration, velocity, direction), velocity);
            let sample = twin.step(Command { disturbance_v: command.disturbance_v + forward_v, ..command });
            measured = sample.velocity;
            traces.push(sample);
            feedforward_v.push(forward_v);
        }
        Compensated { traces, feedforward_v }
    }
}

/// Acceleration of the reference at sample k: the velocity reference looks back one period, so the difference to
/// the next one is centred on the sample.
fn acceleration(commands: &[Command], k: usize, period_s: f64) -> f64 {
    let last = commands.len().saturating_sub(1);
    let (from, to) = if k < last { (k, k + 1) } else { (k.saturating_sub(1), k) };
    (commands[to].velocity_reference - commands[from].velocity_reference) / period_s
}

/// Voltage that holds a force at a velocity in the steady state.
fn voltage(circuit: &Circuit, force: f64, velocity: f64) -> f64 {
    match *circuit {
        Circuit::Direct { force_per_volt } => force / force_per_volt,
        Circuit::Winding { resistance_ohm, force_constant, back_emf, .. } => {
            resistance_ohm * force / force_constant + back_emf * velocity
        }
    }
}
