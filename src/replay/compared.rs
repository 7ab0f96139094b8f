//! A recorded run beside what the machine's twin makes of it: how far each signal is off.

use super::{Cell, Figures, PlantChoice, Published, Recorded, Traces};
use crate::error::{Error, ErrorKind, Result};
use crate::machine::Machine;
use crate::plant::{axis::Axis, mujoco::MujocoRig, rapier::Rig};
use crate::recording::{Run, Signal};
use crate::twin::Sensing;
use crate::units::Motion;
use std::fmt;

/// Signals that are compared where they were logged, in the order in which an operator looks at them.
pub const COMPARED: [Signal; 6] = [
    Signal::Position,
    Signal::Velocity,
    Signal::Thrust,
    Signal::ControlEffort,
    Signal::Current,
    Signal::LoadPosition,
];
/// Sample periods of recording and machine agree to this fraction.
const PERIOD_AGREEMENT: f64 = 1e-6;

/// How far a predicted signal is off the recorded one, in SI.
///
/// # Model
/// e(k) = recorded(k) − predicted(k), k = 1 … N, r̄ = mean of the recorded signal:
/// ```text
///   MAE = Σ|e|/N     RMS = √(Σe²/N)     peak = max|e|     R² = 1 − Σe²/Σ(recorded − r̄)²
/// ```
///
/// # Validity
/// The sensor's noise is in all four: they do not fall below it. R² is 1 for a perfect prediction, 0 for one that is no
/// better than the mean, below 0 for a worse one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Agreement {
    /// Which signal.
    pub signal: Signal,
    /// Mean absolute error.
    pub mae: f64,
    /// Root mean square of the error.
    pub rms: f64,
    /// Largest error in either direction.
    pub peak: f64,
    /// Share of the recorded variance that the prediction explains; none where the recorded signal does not vary.
    pub r2: Option<f64>,
}

impl Agreement {
    /// Of the samples that both have.
    pub fn between(signal: Signal, recorded: &[f64], predicted: &[f64]) -> Self {
        let errors = || recorded.iter().zip(predicted).map(|(r, p)| r - p);
        let count = errors().count().max(1) as f64;
        let squares: f64 = errors().map(|e| e * e).sum();
        let mean = recorded.iter().sum::<f64>() / recorded.len().max(1) as f64;
        let spread: f64 = recorded.iter().map(|r| (r - mean) * (r - mean)).sum();
        Self {
            signal,
            mae: errors().map(f64::abs).sum::<f64>() / count,
            rms: (squares / count).sqrt(),
            peak: errors().fold(0.0, |peak: f64, e| peak.max(e.abs())),
            r2: (spread > 0.0).then(|| 1.0 - squares / spread),
        }
    }
}

/// What drives a machine along a recorded run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DrivenBy {
    /// The recorded position reference, the loop closed by the machine's controller.
    Reference,
    /// The recorded effort, in open loop from the recorded start: errors add up.
    Effort,
}

impl fmt::Display for DrivenBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Reference => "closed loop along the recorded reference",
            Self::Effort => "open loop under the recorded effort",
        })
    }
}

/// A recorded run beside the same run of the machine's twin.
#[derive(Debug, Clone)]
pub struct Compared {
    /// As recorded.
    pub run: Run,
    /// As replayed with perfect sensors from the recorded start.
    pub twin: Traces,
    /// What drove the twin.
    pub driven_by: DrivenBy,
    /// How far each logged signal is off.
    pub agreement: Vec<Agreement>,
    /// Figures of merit that the run states as published.
    pub published: Vec<Published>,
    /// Figures of recording and twin, where the run states stroke and feed and has a reference.
    pub figures: Option<[Figures; 2]>,
}

impl Compared {
    /// Replays a run with its settings, and with the feed-forward that it states, on a plant.
    ///
    /// # Errors
    /// A run without position, or with neither a reference that the machine's controller could follow nor an effort;
    /// another sample period or kind of motion than the machine's; a setting that the machine does not have; a
    /// feed-forward that cannot be told; stroke and feed that are none; published figures that are none; what the plant
    /// refuses.
    pub fn of(run: &Run, machine: &Machine, plant: PlantChoice) -> Result<Self> {
        check_motion(run, machine)?;
        // Uneven time stamps have no period to agree with: the twin is read at them.
        if run.instants_s().is_none() {
            check_period(run, machine)?;
        }
        let machine = as_set(run, machine)?;
        let (cell, published) = (Cell::of_run(run)?, Published::of(run)?);
        let (recorded, driven_by) = driven(run, &machine)?;
        let recorded = recorded.on_controller_clock(run, machine.description().sample_period_s);
        let sensing = Sensing::Perfect;
        let twin = match plant {
            PlantChoice::Rapier => recorded.replay(&machine, Rig::new(&machine)?, sensing),
            PlantChoice::Axis => recorded.replay(&machine, Axis::of(&machine.constants()), sensing),
            PlantChoice::Mujoco => recorded.replay(&machine, MujocoRig::new(&machine)?, sensing),
        };
        let agreement = agreement(run, &machine, &twin, driven_by);
        let figures = match cell {
            Some(cell) => figures(run, cell.stroke(run.motion())?.feed, &twin),
            None => None,
        };
        Ok(Self { run: run.clone(), twin, driven_by, agreement, published, figures })
    }

    /// Of one signal.
    pub fn of_signal(&self, signal: Signal) -> Option<&Agreement> {
        self.agreement.iter().find(|agreement| agreement.signal == signal)
    }
}

/// An error about a run: its file, its name and the key.
fn at(error: Error, run: &Run, key: &str) -> Error {
    let error = error.key(format!("{}.{key}", run.name()));
    if run.file.as_os_str().is_empty() { error } else { error.file(&run.file) }
}

/// The machine as it was set in a run.
///
/// # Errors
/// A setting that the machine does not have or that it refuses.
pub fn as_set(run: &Run, machine: &Machine) -> Result<Machine> {
    let settings = run.settings.iter();
    let settings = settings.map(|(path, value)| (path.as_str(), machine.on_top(path, value.clone())));
    machine.with_settings(settings).map_err(|error| {
        let key = error.key_name().unwrap_or_default().to_owned();
        at(error, run, format!("set {key}").trim_end())
    })
}

/// Refuses a run of another kind of axis than the machine's, at another sample period, or with uneven time stamps.
///
/// # Errors
/// Such a run.
pub fn check(run: &Run, machine: &Machine) -> Result<()> {
    check_motion(run, machine)?;
    run.require_even("what is asked for")?;
    check_period(run, machine)
}

fn check_motion(run: &Run, machine: &Machine) -> Result<()> {
    if run.motion() != machine.motion() {
        let kind = |motion| if motion == Motion::Prismatic { "slides" } else { "turns" };
        return Err(at(Error::new(ErrorKind::Inconsistent), run, "motion")
            .found(format!("an axis that {}", kind(run.motion())))
            .expected(format!("one that {}, as does the machine", kind(machine.motion())))
            .remedy("name the machine that was recorded, or correct the signals' names"));
    }
    Ok(())
}

fn check_period(run: &Run, machine: &Machine) -> Result<()> {
    let period_s = machine.description().sample_period_s;
    if (run.sample_period_s() / period_s - 1.0).abs() > PERIOD_AGREEMENT {
        return Err(at(Error::new(ErrorKind::Inconsistent), run, "sample_period_s")
            .found(format!("{} s in the recording and {period_s} s in the machine", run.sample_period_s()))
            .expected("the controller's sample period in both")
            .remedy("correct sample_period_s of machine.toml, or record at the controller's rate"));
    }
    Ok(())
}

/// What of a run drives a machine: its position reference where the machine has a controller, else its effort.
///
/// # Errors
/// A run with neither.
pub fn driven_by(run: &Run, machine: &Machine) -> Result<DrivenBy> {
    let has_controller = machine.description().controller.is_some();
    if has_controller && run.signal(Signal::PositionReference).is_some() {
        return Ok(DrivenBy::Reference);
    }
    if run.signal(Signal::ControlEffort).is_some() {
        return Ok(DrivenBy::Effort);
    }
    let motion = run.motion();
    let reference_key = Signal::PositionReference.key(motion);
    let effort_key = Signal::ControlEffort.key(motion);
    let logged: Vec<_> = run.signals().keys().map(|signal| signal.key(motion)).collect();
    let (key, found) = if has_controller {
        (reference_key, format!("a run with {}", logged.join(", ")))
    } else {
        (effort_key, format!("a run with {}, and a machine without a controller", logged.join(", ")))
    };
    Err(at(Error::new(ErrorKind::Missing), run, key)
        .found(found)
        .expected("what moved the axis: a position reference and a stated controller, or the effort")
        .remedy(format!("log {reference_key} or {effort_key}, or state [controller] in the machine file")))
}

/// Commands and start, and what they are.
fn driven(run: &Run, machine: &Machine) -> Result<(Recorded, DrivenBy)> {
    let driven_by = driven_by(run, machine)?;
    let reference = run.signal(Signal::PositionReference);
    let along = reference.map_or_else(|| run.require(Signal::Position), Ok)?;
    let recorded = Recorded::along(run, along, machine)?;
    Ok(match driven_by {
        DrivenBy::Reference => (recorded, driven_by),
        DrivenBy::Effort => (recorded.driven_by(run.require(Signal::ControlEffort)?), driven_by),
    })
}

fn agreement(run: &Run, machine: &Machine, twin: &Traces, driven_by: DrivenBy) -> Vec<Agreement> {
    let description = machine.description();
    let is_predicted = |signal: &Signal| match signal {
        Signal::Current => description.motor.has_current(),
        Signal::LoadPosition => description.load_sensor.is_some(),
        // What drives the twin is no prediction of it.
        Signal::ControlEffort => driven_by == DrivenBy::Reference,
        _ => true,
    };
    let of = |signal| Some(Agreement::between(signal, run.signal(signal)?, twin.signal(signal)?));
    COMPARED.into_iter().filter(is_predicted).filter_map(of).collect()
}

fn figures(run: &Run, feed: f64, twin: &Traces) -> Option<[Figures; 2]> {
    let reference = run.signal(Signal::PositionReference)?;
    let logged = |signal| run.signal(signal).map(<[f64]>::to_vec);
    let recorded = Traces {
        position: logged(Signal::Position)?,
        velocity: logged(Signal::Velocity)?,
        thrust: logged(Signal::Thrust).unwrap_or_default(),
        effort_v: logged(Signal::ControlEffort).unwrap_or_default(),
        ..Traces::default()
    };
    let of = |traces: &Traces| Figures::along(reference, feed, run.sample_period_s(), traces);
    Some([of(&recorded)?, of(twin)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_errors_by_hand() {
        let found = Agreement::between(Signal::Position, &[1.0, 2.0, 3.0, 6.0], &[1.0, 3.0, 3.0, 3.0]);
        assert!((found.mae - 1.0).abs() < 1e-15 && (found.peak - 3.0).abs() < 1e-15);
        assert!((found.rms - 2.5f64.sqrt()).abs() < 1e-15);
        // Spread about the mean 3: 4 + 1 + 0 + 9.
        assert!((found.r2.unwrap() - (1.0 - 10.0 / 14.0)).abs() < 1e-15);
        assert_eq!(Agreement::between(Signal::Position, &[2.0; 3], &[2.0; 3]).r2, None);
    }
}
