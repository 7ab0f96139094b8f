//! Checks of the data before anything is solved: each finding in the words that a user needs.
//!
//! # Design
//! One concern a file. A check says only what the data show by themselves or against relations that hold
//! whatever the twin lacks: a velocity is the slope of its position, an effort is what the control law makes of
//! the readings, a mass is positive. What is merely predicted badly is no finding; that is the diagnosis' task.
//!
//! The checks run before anything is fitted. A finding is a note, a warning, or fatal: a fatal one withholds the verdict. Fatal is
//! only what no law of the catalogue and no noise could do instead: a wrong unit, a swapped sign, a late channel.

mod alignment;
mod clipping;
mod excitation;
mod inertia;
mod late;
mod law;
mod missing;
mod missing_term;
mod projection;
mod repeated;
mod second_sensor;
mod shift;
mod sign;
mod smoothed;
mod stuck;
mod timing;
mod travel;
mod unit;

use super::experiment::Experiment;
use crate::machine::Machine;
use crate::recording::{Run, Signal};
use crate::twin::LinearLoop;
use missing_term::Missing;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use smoothed::Smoothed;

/// What a finding is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Check {
    /// Samples that were not taken at an even pace.
    TimingJitter,
    /// Samples that are missing.
    GapInTime,
    /// A signal that ran into a limit.
    Clipping,
    /// A signal that does not change while the axis is told to move.
    StuckChannel,
    /// A signal that was sampled more slowly and held in between, or that repeats old readings where samples were lost.
    HeldChannel,
    /// A reference that never moves.
    NoMotion,
    /// A reference that moves in one direction only.
    MissingReversal,
    /// Motion that leaves parameters open.
    WeakExcitation,
    /// A recorded channel that is late, as opposed to a loop that is.
    ChannelDelay,
    /// A control law that is not the one that ran.
    ControlLaw,
    /// A column with the wrong sign.
    SwappedSign,
    /// A column in another unit than stated.
    ImplausibleUnit,
    /// Two position sensors that count from different zeros.
    SensorOffset,
    /// An encoder whose steps make noise of their own.
    CoarseReadings,
    /// A signal that was not logged, and what cannot be told without it.
    MissingSignal,
    /// A twin whose closed loop is not stable.
    UnstableLoop,
}

/// How much a finding matters; worst first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// Any verdict would be about it: a column that is certainly not what it is taken for.
    Fatal,
    /// The verdict may be wrong because of it.
    Warning,
    /// It limits what can be told.
    Note,
}

/// Something about the data that limits or colours what can be told from them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// The run concerned; empty for the recording as a whole.
    pub run: String,
    /// What it is about.
    pub check: Check,
    /// How much it matters.
    pub severity: Severity,
    /// The column in doubt, by its canonical name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signal: Option<String>,
    /// What was found and what follows, as a sentence.
    pub message: String,
}

impl Finding {
    fn new(run: &str, check: Check, severity: Severity, message: impl Into<String>) -> Self {
        Self { run: run.to_owned(), check, severity, signal: None, message: message.into() }
    }

    /// A finding about one column: fatal where it is certain, else a warning.
    fn column(run: &Run, check: Check, signal: Signal, is_certain: bool, message: impl Into<String>) -> Self {
        let severity = if is_certain { Severity::Fatal } else { Severity::Warning };
        let finding = Self::new(run.name(), check, severity, message);
        Self { signal: Some(signal.key(run.motion()).to_owned()), ..finding }
    }

    fn warning(run: &str, check: Check, message: impl Into<String>) -> Self {
        Self::new(run, check, Severity::Warning, message)
    }

    fn note(run: &str, check: Check, message: impl Into<String>) -> Self {
        Self::new(run, check, Severity::Note, message)
    }
}

/// What is to be known of residuals that the steps of the encoder account for, as noise.
pub fn coarse_readings() -> Finding {
    Finding::note(
        "",
        Check::CoarseReadings,
        "The steps of the encoder make noise of their own: a step read a moment earlier or later makes another course of what follows. The noise shown is that of the twin with these steps; it accounts for residuals, it does not make them smaller.",
    )
}

/// Looks through the runs: findings of each run in turn, then those of the recording as a whole.
pub fn check(machine: &Machine, training: &[Experiment], held_out: &[Experiment]) -> Vec<Finding> {
    let all: Vec<&Experiment> = training.iter().chain(held_out).collect();
    let looked: Vec<Look> = all.par_iter().map(|experiment| Look::at(experiment, machine)).collect();
    let late = alignment::consensus(looked.iter().map(|look| look.late.as_slice()));
    let mut findings = Vec::new();
    for ((experiment, look), late) in all.iter().zip(&looked).zip(late) {
        findings.extend(look.findings.iter().cloned());
        findings.extend(late.iter().map(|late| late.finding(experiment.run())));
    }
    findings.extend(travel::of_recording(training));
    let smoothed: Vec<&Smoothed> = looked[..training.len()].iter().map(|look| &look.smoothed).collect();
    findings.extend(excitation::excitation(machine, training, &smoothed));
    findings.extend(missing::missing(&all));
    let terms: Vec<Option<Missing>> = looked.iter().map(|look| look.missing).collect();
    findings.extend(all.first().and_then(|first| missing_term::finding(&terms, first.run().motion())));
    let unstable = LinearLoop::warning(machine);
    findings.extend(unstable.map(|text| Finding::warning("", Check::UnstableLoop, text)));
    agreed(&mut findings, &all);
    findings
}

/// Leaves fatal only what most of the runs show that could show it, and what is about a column that a replay uses: a column is
/// mapped once for all runs, and one that nothing is compared with spoils no verdict.
fn agreed(findings: &mut [Finding], all: &[&Experiment]) {
    let is_used = |experiment: &&&Experiment, key: &str| {
        let run = experiment.run();
        let command = [Signal::PositionReference, Signal::Position];
        let used = experiment.signals().iter().chain(&command).copied();
        let used = used.chain(experiment.input().map(|input| input.signal()));
        used.filter(|signal| run.signal(*signal).is_some()).any(|signal| signal.key(run.motion()) == key)
    };
    let fatal: Vec<(Check, Option<String>)> = findings
        .iter()
        .filter(|finding| finding.severity == Severity::Fatal)
        .map(|finding| (finding.check, finding.signal.clone()))
        .collect();
    for finding in findings.iter_mut().filter(|finding| finding.severity == Severity::Fatal) {
        let could = finding.signal.as_ref().map_or(0, |key| all.iter().filter(|e| is_used(e, key)).count());
        let did = fatal.iter().filter(|other| **other == (finding.check, finding.signal.clone())).count();
        if 2 * did <= could || could == 0 {
            finding.severity = Severity::Warning;
        }
    }
}

/// What one run shows.
struct Look {
    findings: Vec<Finding>,
    late: Vec<late::Late>,
    missing: Option<Missing>,
    smoothed: Smoothed,
}

impl Look {
    fn at(experiment: &Experiment, machine: &Machine) -> Self {
        let run = experiment.run();
        // A setting that the machine does not have is refused where the run is replayed.
        let machine = &experiment.machine(machine).unwrap_or_else(|_| machine.clone());
        let smoothed = Smoothed::of(experiment, machine);
        let mut findings = timing::timing(run);
        findings.extend(travel::of_run(experiment));
        findings.extend(stuck::stuck(experiment));
        findings.extend(repeated::repeated(run));
        findings.extend(clipping::clipping(experiment, machine));
        let signs = sign::Signs::of(machine, &smoothed);
        findings.extend(signs.findings(run));
        findings.extend(unit::unit(run, machine, &smoothed));
        findings.extend(second_sensor::offset(run, machine));
        let late = if signs.position_is_swapped() { Vec::new() } else { alignment::late(machine, &smoothed) };
        let missing = if late.is_empty() { missing_term::missing(machine, &smoothed) } else { None };
        Self { findings, late, missing, smoothed }
    }
}
