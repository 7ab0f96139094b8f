//! Cuts of the signal path: stretches between two logged signals, each replayed alone from its measured input.
//!
//! A stretch whose own replay shows no gap is not where the gap comes from, whatever the closed loop makes of it:
//! effects that act in it are no explanation.

mod at_rest;
pub mod contradiction;
mod residual;
mod scales;
mod stated;

pub use stated::{Stated, stated};

use super::experiment::Experiment;
use super::motion::Motion;
use super::thresholds::ADEQUATE_GAP;
use super::visibility::NotExamined;
use crate::effect::{EffectId, Stretch};
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use rayon::prelude::*;
use residual::{controller_residual, drive_residual, force_residual};
use scales::Scales;
use std::collections::BTreeMap;

/// A stretch of the signal path between two logged signals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cut {
    /// From reference and position to effort: control law and velocity estimate.
    Controller,
    /// From effort to current, or to thrust where no current is logged: amplifier and circuit.
    Drive,
    /// From current to thrust: force constant and its ripple.
    Force,
    /// From motor force to position: guide, structure, sensor.
    Mechanics,
}

impl Cut {
    const ALL: [Self; 4] = [Self::Controller, Self::Drive, Self::Force, Self::Mechanics];

    /// The stretch in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Controller => "from reference and position to effort",
            Self::Drive => "from effort to current or thrust",
            Self::Force => "from current to thrust",
            Self::Mechanics => "from motor force to position",
        }
    }

    /// The cut in which an effect shows, given which signals were logged; none for one that shows in several.
    fn of(effect: EffectId, has_current: bool, has_thrust: bool) -> Option<Self> {
        match effect.stretch() {
            Stretch::Controller | Stretch::VelocityEstimate => Some(Self::Controller),
            Stretch::Drive => Some(Self::Drive),
            Stretch::MotorForce => Some(match (has_current, has_thrust) {
                (true, true) => Self::Force,
                (false, true) => Self::Drive,
                (_, false) => Self::Mechanics,
            }),
            Stretch::Mechanics | Stretch::Rounding => Some(Self::Mechanics),
            Stretch::Log => None,
        }
    }
}

/// A stretch whose noise is above this share of what the closed loop is off by cannot be judged by it.
const SHARP: f64 = 0.2;
/// A stretch whose residual is below this share of what the closed loop is off by is not where that comes from.
const NEGLIGIBLE: f64 = 0.01;

/// The stretches that show no gap of their own.
///
/// # Model
/// Each stretch's residual on the recorded runs is compared with the same residual on replays of the twin as it is, noise
/// as stated: that is what the stretch looks like with nothing wrong in it. They are compared over 1, 4, 16, … samples: what
/// stays below the noise of each sample, an offset say, shows in the mean of many, and the closed loop adds it up. No runs have none.
///
/// # Errors
/// Whatever a replay refuses.
pub fn clean(runs: &[Stated]) -> Result<Vec<Cut>> {
    let of_run = |run: &Stated| -> Result<BTreeMap<Cut, [Vec<f64>; 3]>> {
        let mut residuals = BTreeMap::new();
        for cut in Cut::ALL {
            let Some(measured) = residual(cut, run.experiment, &run.machine)? else { continue };
            let Some(made) = residual(cut, &run.imagined, &run.machine)? else { continue };
            residuals.insert(cut, [measured, made, closed_loop(cut, run)]);
        }
        Ok(residuals)
    };
    let all: Vec<_> = runs.par_iter().map(of_run).collect::<Result<_>>()?;
    let mut sums: BTreeMap<Cut, Sums> = BTreeMap::new();
    for (cut, [measured, made, closed_loop]) in all.into_iter().flatten() {
        let sums = sums.entry(cut).or_default();
        sums.measured.add(&measured);
        sums.made.add(&made);
        sums.closed_loop.add(&closed_loop);
        sums.runs += 1;
    }
    let is_clean = |(_, sums): &(&Cut, &Sums)| sums.runs == runs.len() && sums.are_clean();
    Ok(sums.iter().filter(is_clean).map(|(cut, _)| *cut).collect())
}

/// Effects of the catalogue that act in none of the clean stretches.
pub fn left(catalogue: &[EffectId], clean: &[Cut], experiments: &[Experiment]) -> Vec<EffectId> {
    let stretch = clean_stretch(clean, experiments);
    catalogue.iter().copied().filter(|effect| stretch(*effect).is_none()).collect()
}

/// The others, with the reason.
pub fn ruled_out(catalogue: &[EffectId], clean: &[Cut], experiments: &[Experiment]) -> Vec<NotExamined> {
    let stretch = clean_stretch(clean, experiments);
    let out = catalogue.iter().filter_map(|effect| Some((effect, stretch(*effect)?)));
    out.map(|(effect, cut)| NotExamined {
        effect: effect.name().to_owned(),
        reason: format!(
            "The stretch {}, replayed alone from its measured input, shows no gap of its own.",
            cut.words()
        ),
    })
    .collect()
}

/// The clean stretch in which an effect would show, given what all of these runs logged; none where it is not clean.
fn clean_stretch(clean: &[Cut], experiments: &[Experiment]) -> impl Fn(EffectId) -> Option<Cut> {
    let logged = |signal| experiments.iter().all(|e| e.run().signal(signal).is_some());
    let (current, thrust) = (logged(Signal::Current), logged(Signal::Thrust));
    move |effect| Cut::of(effect, current, thrust).filter(|cut| clean.contains(cut))
}

#[derive(Default)]
struct Sums {
    measured: Scales,
    made: Scales,
    closed_loop: Scales,
    runs: usize,
}

impl Sums {
    /// Whether the stretch shows no more than noise, or nothing that matters beside the closed loop, over any number of samples.
    fn are_clean(&self) -> bool {
        // Noise hides nothing that matters only where it is far below what the closed loop is off by.
        let sharp = self.made.power(0) <= SHARP * SHARP * self.closed_loop.power(0);
        (0..self.measured.0.len()).all(|scale| {
            let measured = self.measured.power(scale);
            let limit = (ADEQUATE_GAP * ADEQUATE_GAP).max(self.measured.chance(scale));
            let noise = sharp && measured <= limit * self.made.power(scale);
            noise || measured <= NEGLIGIBLE * NEGLIGIBLE * self.closed_loop.power(scale)
        })
    }
}

/// What is left of a stretch's output, in N or N·m (V for the controller).
fn residual(cut: Cut, experiment: &Experiment, machine: &Machine) -> Result<Option<Vec<f64>>> {
    let run = experiment.run();
    Ok(match cut {
        Cut::Controller => controller_residual(experiment, machine),
        Cut::Drive => drive_residual(experiment, &machine.constants()),
        Cut::Force => force_residual(experiment, &machine.constants()),
        Cut::Mechanics => {
            let has_force = run.signal(Signal::Thrust).or(run.signal(Signal::Current)).is_some();
            let motion = Motion::of(experiment, machine)?;
            (has_force && !motion.missing_force.is_empty()).then_some(motion.missing_force)
        }
    })
}

/// By what the closed loop misses the stretch's output, in the residual's unit.
fn closed_loop(cut: Cut, Stated { experiment, machine, predicted, .. }: &Stated) -> Vec<f64> {
    let run = experiment.run();
    let off = |signal: Signal, trace: &[f64], scale: f64| -> Vec<f64> {
        let pairs = run.signal(signal).unwrap_or_default().iter().zip(trace);
        pairs.map(|(m, p)| scale * (m - p)).collect()
    };
    match cut {
        Cut::Controller => off(Signal::ControlEffort, &predicted.effort_v, 1.0),
        _ if run.signal(Signal::Thrust).is_some() => off(Signal::Thrust, &predicted.thrust, 1.0),
        _ => off(Signal::Current, &predicted.current, machine.constants().force_constant()),
    }
}
