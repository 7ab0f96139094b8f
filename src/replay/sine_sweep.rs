//! Sines of rising frequency into the drive of a machine's twin, its loops open: one run a frequency.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::{PlantChoice, Traces, run_seed};
use crate::error::{Error, ErrorKind, Result};
use crate::identify::stepped_sine::FREQUENCY_KEY;
use crate::machine::Machine;
use crate::plant::{Plant, axis::Axis, mujoco::MujocoRig, rapier::Rig};
use crate::recording::{Run, Signal};
use crate::twin::{Command, Sensing, Twin};

/// Periods over which the amplitude rises.
const RAMP_PERIODS: f64 = 2.0;
/// Periods that are compared to tell whether the motion has settled.
const COMPARED_PERIODS: usize = 3;
/// Largest relative change of their swings and, against the swing, of their middles.
const SETTLED: f64 = 1e-3;
/// Periods after which a motion that does not settle ends in any case.
const MOST_PERIODS: usize = 4000;
/// Samples a period at the highest frequency.
const LEAST_SAMPLES: f64 = 8.0;
/// Most frequencies.
const MOST_POINTS: usize = 500;

/// Sines of one amplitude at logarithmically spaced frequencies.
///
/// # Model
/// ```text
///   u(t) = A·min(t/t_r, 1)·sin 2πft        t_r: two periods
/// ```
/// in place of the controller's effort: velocity and position loop are off, a current loop inside the motor is not. Each
/// frequency begins at standstill and lasts twice as long as the velocity takes to settle: swing and middle of three
/// successive periods within 0.1 % of the swing.
///
/// # Validity
/// No travel is looked at: the axis must be free to turn or slide as far as its speed takes it.
#[derive(Debug, Clone, PartialEq)]
pub struct SineSweep {
    /// Frequencies in Hz, rising.
    pub frequencies_hz: Vec<f64>,
    /// A in V of control effort.
    pub amplitude_v: f64,
}

impl SineSweep {
    /// So many frequencies from end to end of a band, evenly over its decades.
    ///
    /// # Errors
    /// A band that does not rise from above 0, fewer than two frequencies or too many, an amplitude that is not above 0.
    pub fn logarithmic([from, to]: [f64; 2], points: usize, amplitude_v: f64) -> Result<Self> {
        if !(from > 0.0 && from < to && to.is_finite()) {
            return Err(refused("--band", format!("{from}..{to} Hz"), "two frequencies, 0 < from < to")
                .remedy("write for instance 0.2..60rad/s"));
        }
        if !(2..=MOST_POINTS).contains(&points) {
            return Err(refused("--points", points.to_string(), &format!("2 to {MOST_POINTS} frequencies"))
                .remedy("give for instance 30"));
        }
        if !(amplitude_v > 0.0 && amplitude_v.is_finite()) {
            return Err(refused("--peak-to-peak", (2.0 * amplitude_v).to_string(), "more than 0 V")
                .remedy("give for instance 0.2"));
        }
        let at = |k: usize| from * (to / from).powf(k as f64 / (points - 1) as f64);
        Ok(Self { frequencies_hz: (0..points).map(at).collect(), amplitude_v })
    }

    /// The machine's twin under each sine, its sensors as stated; `each` is told after every run how many are done.
    ///
    /// # Errors
    /// A frequency with fewer than eight samples a period; what the scene refuses; a joint with end stops that is driven
    /// beyond them.
    pub fn runs(
        &self,
        machine: &Machine,
        plant: PlantChoice,
        mut each: impl FnMut(usize),
    ) -> Result<Vec<Run>> {
        let period_s = machine.description().sample_period_s;
        let highest = self.frequencies_hz.iter().copied().fold(0.0, f64::max);
        if highest * period_s * LEAST_SAMPLES > 1.0 {
            return Err(refused(
                "--band",
                format!("{highest} Hz at a sample period of {period_s} s"),
                &format!("at least {LEAST_SAMPLES} samples a period"),
            )
            .remedy(format!("stay below {:.1} Hz", 1.0 / (LEAST_SAMPLES * period_s))));
        }
        let mut runs = Vec::with_capacity(self.frequencies_hz.len());
        for (k, frequency_hz) in self.frequencies_hz.iter().enumerate() {
            let name = format!("sine{:03}", k + 1);
            let sensing = Sensing::AsStated { seed: run_seed(1, &name) };
            let traces = match plant {
                PlantChoice::Rapier => self.driven(machine, Rig::new(machine)?, sensing, *frequency_hz),
                PlantChoice::Axis => {
                    self.driven(machine, Axis::of(&machine.constants()), sensing, *frequency_hz)
                }
                PlantChoice::Mujoco => self.driven(machine, MujocoRig::new(machine)?, sensing, *frequency_hz),
            };
            super::travel::check_travel(machine, &traces.position)?;
            runs.push(recorded(machine, name, traces, *frequency_hz)?);
            each(k + 1);
        }
        Ok(runs)
    }

    fn driven<P: Plant>(&self, machine: &Machine, plant: P, sensing: Sensing, frequency_hz: f64) -> Traces {
        let mut twin = Twin::new(machine, plant, sensing);
        let period_s = twin.period_s();
        let samples_per_period = 1.0 / (frequency_hz * period_s);
        let mut traces = Traces::default();
        let mut step = |traces: &mut Traces| {
            let turns = traces.len() as f64 / samples_per_period;
            let effort_v = self.amplitude_v * (turns / RAMP_PERIODS).min(1.0) * (TAU * turns).sin();
            traces.push(twin.step(Command { effort_v: Some(effort_v), ..Command::follow(0.0, 0.0) }));
        };
        let mut swings: Vec<[f64; 2]> = Vec::new();
        for period in 1..=MOST_PERIODS {
            let from = traces.len();
            while (traces.len() as f64) < period as f64 * samples_per_period {
                step(&mut traces);
            }
            swings.push(swing(&traces.velocity[from..]));
            if period as f64 > RAMP_PERIODS && is_settled(&swings) {
                break;
            }
        }
        let until = 2 * traces.len();
        while traces.len() < until {
            step(&mut traces);
        }
        traces
    }
}

fn refused(key: &str, found: String, expected: &str) -> Error {
    Error::new(ErrorKind::OutOfRange).key(key).found(found).expected(expected)
}

/// Swing and middle of a period.
fn swing(period: &[f64]) -> [f64; 2] {
    let highest = period.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lowest = period.iter().copied().fold(f64::INFINITY, f64::min);
    [highest - lowest, 0.5 * (highest + lowest)]
}

fn is_settled(swings: &[[f64; 2]]) -> bool {
    let Some(last) = swings.last() else { return false };
    let compared = swings.iter().rev().take(COMPARED_PERIODS);
    swings.len() > COMPARED_PERIODS
        && compared.flat_map(|s| [s[0] - last[0], s[1] - last[1]]).all(|off| off.abs() <= SETTLED * last[0])
}

fn recorded(machine: &Machine, name: String, traces: Traces, frequency_hz: f64) -> Result<Run> {
    let mut signals = BTreeMap::from([
        (Signal::ControlEffort, traces.effort_v),
        (Signal::Thrust, traces.thrust),
        (Signal::Position, traces.position),
        (Signal::Velocity, traces.velocity),
    ]);
    if machine.description().motor.has_current() {
        signals.insert(Signal::Current, traces.current);
    }
    let mut run = Run::new(name, machine.motion(), machine.description().sample_period_s, signals)?;
    run.metadata.insert(FREQUENCY_KEY.to_owned(), frequency_hz.into());
    Ok(run)
}
