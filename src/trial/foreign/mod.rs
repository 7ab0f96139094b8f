//! What no law of the catalogue describes: disturbances that are foreign to the axis.
//!
//! Each is drawn once and stored with all its times, so that the truth alone gives the recording again. The diagnosing twin
//! has none of them.

mod clock;
mod missed;
mod shocks;
mod warming;

pub use clock::DriftingClock;
pub use missed::{Burst, MissedSamples, Rows};
pub use shocks::{Pulse, Shocks};
pub use warming::{WarmSensor, WarmingScale};

use crate::error::Result;
use crate::guide::StepForce;
use crate::machine::Machine;
use crate::recording::{Run, Signal};
use crate::sensor::rounded;
use crate::units::Motion;
use rand::RngExt;
use rand::rngs::StdRng;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// A disturbance that no law of the catalogue describes.
///
/// # Model
/// - [`Shocks`] are forces: the forged plant applies them.
/// - [`WarmingScale`] is what a sensor shows: inside the loop where the loop is closed on that sensor.
/// - [`MissedSamples`] and [`DriftingClock`] change what is logged of a run, and nothing that the controller sees.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Foreign {
    /// A neighbouring press or lift strikes the axis.
    Shocks(Shocks),
    /// The logger misses samples.
    MissedSamples(MissedSamples),
    /// The sensors are logged by a device with a clock of its own.
    DriftingClock(DriftingClock),
    /// A linear scale or a screw grows as it warms.
    WarmingScale(WarmingScale),
}

/// The kind of a [`Foreign`] disturbance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ForeignKind {
    /// See [`Shocks`].
    Shocks,
    /// See [`MissedSamples`].
    MissedSamples,
    /// See [`DriftingClock`].
    DriftingClock,
    /// See [`WarmingScale`].
    WarmingScale,
}

impl ForeignKind {
    /// The word in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shocks => "shocks",
            Self::MissedSamples => "missed_samples",
            Self::DriftingClock => "drifting_clock",
            Self::WarmingScale => "warming_scale",
        }
    }

    /// Whether the disturbance can be seen in recordings of a machine.
    ///
    /// Every kind can but one: a warming scale needs a second sensor at the load of a linear axis. Alone in the loop it is
    /// followed by the axis, and all that is left of it are forces that are off by some hundred ppm. A graduated ring that
    /// grows shows the same angle.
    pub fn shows(self, machine: &Machine) -> bool {
        self != Self::WarmingScale
            || (machine.description().load_sensor.is_some() && machine.motion() == Motion::Prismatic)
    }
}

impl fmt::Display for ForeignKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Foreign {
    /// Every kind.
    pub const ALL_KINDS: [ForeignKind; 4] = [
        ForeignKind::Shocks,
        ForeignKind::MissedSamples,
        ForeignKind::DriftingClock,
        ForeignKind::WarmingScale,
    ];

    /// Draws a disturbance of a machine for a session of `session_s` from time 0 on; `rated_force` in N or N·m is what
    /// shocks are measured by.
    pub fn draw(
        kind: ForeignKind,
        machine: &Machine,
        rated_force: f64,
        session_s: f64,
        random: &mut StdRng,
    ) -> Self {
        match kind {
            ForeignKind::Shocks => Self::Shocks(Shocks::draw(rated_force, session_s, random)),
            ForeignKind::MissedSamples => {
                let period_s = machine.description().sample_period_s;
                Self::MissedSamples(MissedSamples::draw(period_s, session_s, random))
            }
            ForeignKind::DriftingClock => Self::DriftingClock(DriftingClock::draw(random)),
            ForeignKind::WarmingScale => {
                Self::WarmingScale(WarmingScale::draw(WarmSensor::of(machine), session_s, random))
            }
        }
    }

    /// Its kind.
    pub fn kind(&self) -> ForeignKind {
        match self {
            Self::Shocks(_) => ForeignKind::Shocks,
            Self::MissedSamples(_) => ForeignKind::MissedSamples,
            Self::DriftingClock(_) => ForeignKind::DriftingClock,
            Self::WarmingScale(_) => ForeignKind::WarmingScale,
        }
    }

    /// The word for its kind in files and tables.
    pub fn name(&self) -> &'static str {
        self.kind().name()
    }

    /// Force on the moving part in N or N·m over a step from a time of the session on, both in s.
    pub fn push(&self, clock_s: f64, step_s: f64) -> StepForce {
        match self {
            Self::Shocks(shocks) => shocks.push(clock_s, step_s),
            _ => StepForce::ZERO,
        }
    }

    /// The scale that the position loop is closed on, where it warms.
    pub(super) fn in_loop(&self) -> Option<&WarmingScale> {
        match self {
            Self::WarmingScale(scale) if scale.sensor.is_in_loop() => Some(scale),
            _ => None,
        }
    }

    /// What is logged of a run that was simulated with the disturbance; role, settings and the place in the session stay.
    ///
    /// `machine` gives the steps of the sensors, onto which changed readings are rounded again.
    ///
    /// # Errors
    /// A run with uneven time stamps.
    pub fn logged(&self, run: Run, machine: &Machine) -> Result<Run> {
        run.require_even("a disturbance of the logger")?;
        match self {
            Self::Shocks(_) => Ok(run),
            Self::MissedSamples(missed) => missed.logged(&run),
            Self::DriftingClock(clock) => clock.logged(&run, machine),
            Self::WarmingScale(scale) => scale.logged(&run, machine),
        }
    }
}

/// The run with other samples, everything else kept.
fn remade(
    run: &Run,
    signals: BTreeMap<Signal, Vec<f64>>,
    extra_columns: BTreeMap<String, Vec<f64>>,
) -> Result<Run> {
    let mut remade = run.with_signals(signals)?.with_extra_columns(extra_columns)?;
    (remade.role, remade.start_s) = (run.role, run.start_s);
    remade.ignored_columns.clone_from(&run.ignored_columns);
    Ok(remade)
}

/// Steps in m or rad that the readings of a signal lie on; a step of 0 leaves them.
fn reading_steps(signal: Signal, machine: &Machine) -> [f64; 2] {
    let description = machine.description();
    match (signal, &description.load_sensor) {
        (Signal::Position, _) => [description.encoder.resolution_m, machine.constants().reading_step],
        (Signal::LoadPosition, Some(sensor)) => [sensor.resolution_m, 0.0],
        _ => [0.0; 2],
    }
}

/// A reading on its steps.
fn on_steps(reading: f64, steps: [f64; 2]) -> f64 {
    steps.into_iter().fold(reading, rounded)
}

/// Nine digits, which files give back exactly.
fn digits(value: f64) -> f64 {
    format!("{value:.8e}").parse().unwrap_or(value)
}

/// So many times of a session in s, in their order.
fn times(count: usize, session_s: f64, random: &mut StdRng) -> Vec<f64> {
    let mut times: Vec<f64> = (0..count).map(|_| session_s * random.random_range(0.0..1.0)).collect();
    times.sort_by(f64::total_cmp);
    times.into_iter().map(digits).collect()
}
