//! Runs of a machine's twin that is excited for its frequency response.

use std::collections::BTreeMap;

use clap::ValueEnum;
use slideway::error::Error;
use slideway::identify::loop_response::{BAND_KEY, PERIOD_KEY};
use slideway::machine::Machine;
use slideway::recording::{Run, Signal};
use slideway::replay::crosscheck::cells_of;
use slideway::replay::multisine::{Injection, Limits, Multisine, Request, Wave};
use slideway::replay::recording::recorded;
use slideway::replay::{Motion, PlantChoice, Stroke, Traces, run_seed, simulate};
use slideway::twin::{LinearLoop, Sensing};

use super::band::Band;

/// Periods that are simulated.
const PERIODS: usize = 8;
/// Distance of the lines in Hz where none is asked for.
pub(super) const RESOLUTION_HZ: f64 = 0.5;
/// Highest frequency excited by default, in shares of half the sampling rate, and at most.
const SHARE_OF_NYQUIST: f64 = 0.4;
const HIGHEST_HZ: f64 = 300.0;
/// Share of the machine's limits that an excitation uses by default.
pub(super) const SHARE: f64 = 0.25;

/// How the twin is excited.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Excitation {
    /// All frequencies of the band at once
    Multisine,
    /// One frequency after the other
    Sweep,
    /// Strokes forth and back: those of the machine file's table [crosscheck]
    Strokes,
}

/// What is to be simulated.
pub(super) struct Plan {
    pub(super) excitation: Excitation,
    pub(super) plant: PlantChoice,
    pub(super) by_reference: bool,
    pub(super) band: Option<Band>,
    pub(super) resolution_hz: Option<f64>,
}

/// What was simulated, and how, in words.
pub(super) struct Excited {
    pub(super) runs: Vec<Run>,
    pub(super) note: String,
}

/// The band where none is asked for.
pub(super) fn default_band(machine: &Machine) -> [f64; 2] {
    let nyquist = 0.5 / machine.description().sample_period_s;
    let to = (SHARE_OF_NYQUIST * nyquist).min(HIGHEST_HZ);
    [to / 60.0, to]
}

/// The twin's runs under an excitation, its sensors as stated.
pub(super) fn excited(machine: &Machine, plan: &Plan) -> Result<Excited, Error> {
    let wave = match plan.excitation {
        Excitation::Multisine => Wave::Multisine,
        Excitation::Sweep => Wave::Sweep,
        Excitation::Strokes => return strokes(machine, plan.plant),
    };
    let Band(band_hz) = plan.band.unwrap_or(Band(default_band(machine)));
    let injection = if plan.by_reference { Injection::Reference } else { Injection::Voltage };
    let request = Request {
        band_hz,
        resolution_hz: plan.resolution_hz.unwrap_or(RESOLUTION_HZ),
        injection,
        wave,
        limits: Limits::of(machine, SHARE),
    };
    request.check_length(PERIODS, machine.description().sample_period_s)?;
    let design = Multisine::design(machine, &request)?;
    let sensing = Sensing::AsStated { seed: run_seed(1, "response") };
    let traces = design.excite(machine, plan.plant, sensing, PERIODS)?;
    let mut run = excited_run(machine, &design, traces)?;
    run.metadata.insert(PERIOD_KEY.to_owned(), design.duration_s().into());
    run.metadata.insert(BAND_KEY.to_owned(), toml::Value::Array(band_hz.map(toml::Value::Float).to_vec()));
    let word = if wave == Wave::Sweep { "sine sweep" } else { "multisine" };
    let note = format!(
        "simulated, not measured: {word} {:.2}..{:.0} Hz on the {}, sensors as stated",
        band_hz[0], band_hz[1], plan.plant
    );
    Ok(Excited { runs: vec![run], note })
}

fn excited_run(machine: &Machine, design: &Multisine, traces: Traces) -> Result<Run, Error> {
    let command = design.command(PERIODS);
    let run = recorded("response", machine, &design.reference(PERIODS), traces)?;
    if design.injection == Injection::Reference {
        return Ok(run);
    }
    let mut signals: BTreeMap<Signal, Vec<f64>> = run.signals().clone();
    signals.insert(Signal::DisturbanceVoltage, command);
    Run::new("response", machine.motion(), machine.description().sample_period_s, signals)
}

fn strokes(machine: &Machine, plant: PlantChoice) -> Result<Excited, Error> {
    LinearLoop::of(machine)?.check_stable(machine)?;
    let mut runs = Vec::new();
    for cell in cells_of(machine)? {
        let there = cell.stroke(machine.motion())?;
        let back = Stroke { stroke: -there.stroke, feed: there.feed };
        let motion = Motion {
            strokes: vec![there, back],
            lead_s: 0.1,
            dwell_s: 0.6,
            ramp_s: machine.description().reference.acceleration_time_s,
        };
        let reference = motion.reference(machine.description().sample_period_s);
        let name = cell.name(machine.motion());
        let sensing = Sensing::AsStated { seed: run_seed(1, &name) };
        let traces = simulate(machine, plant, sensing, &reference, |_| ())?;
        runs.push(recorded(&name, machine, &reference, traces)?);
    }
    let note = format!(
        "simulated, not measured: {} strokes forth and back on the {plant}, sensors as stated",
        runs.len()
    );
    Ok(Excited { runs, note })
}
