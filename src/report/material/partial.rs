//! What each cause takes up by itself, on what is left when the others are in the twin.

use super::force::{LawPair, Over, over};
use super::{Force, Machines};
use crate::diagnose::Diagnosis;
use crate::diagnose::experiment::Experiment;
use crate::diagnose::noise::Floor;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::twin::Sensing;

/// A cause's law, drawn where it acts.
#[derive(Debug, Clone)]
pub enum Partial {
    /// It acts as a force.
    Force(PartialForce),
    /// It exerts no force; what it does to a signal is drawn.
    Signal(PartialSignal),
}

/// A force over the samples of [`Force`], which it needs for its motion.
#[derive(Debug, Clone)]
pub struct PartialForce {
    /// Effect id.
    pub effect: String,
    /// What it takes up, in SI.
    pub law: Vec<f64>,
    /// What the twin lacks that has all causes but this one, in SI.
    pub lacking: Vec<f64>,
    /// The quantity that the law follows best, and its course over that; none where it follows none but time.
    pub over: Option<(Quantity, Over)>,
}

/// What a law is drawn over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Velocity.
    Velocity,
    /// Position.
    Position,
    /// Acceleration.
    Acceleration,
}

impl Quantity {
    /// The samples of it.
    pub fn of(self, force: &Force) -> &[f64] {
        match self {
            Self::Velocity => &force.velocity,
            Self::Position => &force.position,
            Self::Acceleration => &force.acceleration,
        }
    }
}

/// A signal of the first held-out run.
#[derive(Debug, Clone)]
pub struct PartialSignal {
    /// Effect id.
    pub effect: String,
    /// The signal that it moves most, in units of noise.
    pub signal: Signal,
    /// The run.
    pub run: String,
    /// From sample to sample in s.
    pub period_s: f64,
    /// Recorded less predicted by the twin that has all causes but this one, in SI.
    pub residual: Vec<f64>,
    /// What the cause adds to the prediction, in SI.
    pub law: Vec<f64>,
}

/// A force below this share of what is lacking before is none.
const NO_FORCE: f64 = 1e-6;
/// Another quantity is taken in the place of velocity where this much less lies beside the law's course over it.
const CLEARER: f64 = 0.5;

/// One partial residual a cause; a cause without which the twin cannot be built (another one modifies it) has none.
///
/// # Model
/// With the causes C in the twin, the partial residual of i is what the twin with C∖{i} and the calibration lacks, and its law
/// what i takes up of that: for a single cause the whole of what is lacking, less the calibration's part.
///
/// # Errors
/// What a replay refuses.
pub(super) fn partials(
    machines: &Machines,
    diagnosis: &Diagnosis,
    experiments: &[&Experiment],
    force: Option<&Force>,
    floor: &Floor,
) -> Result<Vec<Partial>> {
    let mut list = Vec::new();
    for cause in &diagnosis.causes {
        let Some(without) = without(machines, diagnosis, &cause.effect) else { continue };
        let own = force.map(|force| of_force(&cause.effect, force, &without, machines, experiments));
        match own.transpose()?.flatten() {
            Some(partial) => list.push(Partial::Force(partial)),
            None => list.extend(
                experiments
                    .first()
                    .map(|first| of_signal(&cause.effect, &without, &machines.improved, first, floor))
                    .transpose()?
                    .flatten()
                    .map(Partial::Signal),
            ),
        }
    }
    Ok(list)
}

/// The machine with the calibration and all causes but one; none where the others cannot stand alone.
fn without(machines: &Machines, diagnosis: &Diagnosis, effect: &str) -> Option<Machine> {
    let rest = Diagnosis {
        causes: diagnosis.causes.iter().filter(|cause| cause.effect != effect).cloned().collect(),
        ..diagnosis.clone()
    };
    rest.improved(&machines.stated).ok()
}

fn of_force(
    effect: &str,
    force: &Force,
    without: &Machine,
    machines: &Machines,
    experiments: &[&Experiment],
) -> Result<Option<PartialForce>> {
    let pair = LawPair::of(without, &machines.improved)?;
    let mut law = Vec::with_capacity(force.after.len());
    for experiment in experiments {
        law.extend(pair.law(experiment)?.into_iter().step_by(force.every));
    }
    let size = |list: &[f64]| list.iter().map(|x| x * x).sum::<f64>();
    if law.len() != force.after.len() || size(&law) <= NO_FORCE * NO_FORCE * size(&force.before) {
        return Ok(None);
    }
    let lacking = force.after.iter().zip(&law).map(|(after, law)| after + law).collect();
    Ok(Some(PartialForce { effect: effect.to_owned(), lacking, over: followed(force, &law), law }))
}

/// The quantity over which least of the law lies beside its course; velocity where others are not clearly better.
fn followed(force: &Force, law: &[f64]) -> Option<(Quantity, Over)> {
    let mut best: Option<(Quantity, Over)> = None;
    for quantity in [Quantity::Velocity, Quantity::Position, Quantity::Acceleration] {
        let Some(course) = over(force, law, quantity.of(force)) else { continue };
        if best.as_ref().is_none_or(|(_, known)| course.beside < CLEARER * known.beside - f64::EPSILON) {
            best = Some((quantity, course));
        }
    }
    best
}

fn of_signal(
    effect: &str,
    without: &Machine,
    improved: &Machine,
    experiment: &Experiment,
    floor: &Floor,
) -> Result<Option<PartialSignal>> {
    let lacks = experiment.predict(without, Sensing::Perfect)?;
    let has = experiment.predict(improved, Sensing::Perfect)?;
    let run = experiment.run();
    let mut best: Option<(f64, PartialSignal)> = None;
    for &signal in experiment.signals() {
        let (Some(measured), Some(lacks), Some(has)) =
            (run.signal(signal), lacks.signal(signal), has.signal(signal))
        else {
            continue;
        };
        let law: Vec<f64> = has.iter().zip(lacks).map(|(has, lacks)| has - lacks).collect();
        let moved =
            law.iter().map(|x| x * x).sum::<f64>().sqrt() / floor.sigma(signal).max(f64::MIN_POSITIVE);
        if moved > best.as_ref().map_or(0.0, |(known, _)| *known) {
            let residual = measured.iter().zip(lacks).map(|(m, p)| m - p).collect();
            let (effect, run_name) = (effect.to_owned(), run.name().to_owned());
            let period_s = run.sample_period_s();
            best = Some((moved, PartialSignal { effect, signal, run: run_name, period_s, residual, law }));
        }
    }
    Ok(best.map(|(_, partial)| partial))
}
