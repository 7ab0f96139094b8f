//! Sizes calibrated by the gap that they make.

use super::engine::sketch;
use super::laws::Otherwise;
use super::runs::{TrialRun, shared_out};
use super::size::{Family, with_effects};
use crate::diagnose::evidence::Score;
use crate::diagnose::experiment::Experiment;
use crate::diagnose::noise::Floor;
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::{Run, Signal};
use crate::replay::Traces;
use crate::replay::recording::recorded;

/// Measures gaps on the runs of a case, in units of the noise that the machine's sensors are stated to have.
pub struct Gauge<'a> {
    machine: &'a Machine,
    otherwise: &'a Otherwise,
    /// Training runs and held-out runs, as a diagnosis shares them out; a single run by itself.
    roles: Vec<Vec<&'a TrialRun>>,
    logged: &'a [Signal],
    floor: Floor,
}

/// An effect of a certain size.
#[derive(Debug, Clone, PartialEq)]
pub struct Sized {
    /// The effect.
    pub effect: EffectId,
    /// Its parameters in the law's order.
    pub values: Vec<f64>,
    /// The gap that it alone makes beside what it modifies: G, 1 without it.
    pub gap: f64,
}

/// Steps of the search for a size.
const MOST_STEPS: usize = 18;
/// A gap within this share of the wanted one will do.
const PRECISION: f64 = 0.02;
/// A gap beyond this is a machine that does not work.
const BROKEN: f64 = 1e5;

impl<'a> Gauge<'a> {
    /// The gauge of a machine (as it really is, hidden effect aside) on its runs.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub fn new(
        machine: &'a Machine,
        otherwise: &'a Otherwise,
        runs: &'a [TrialRun],
        logged: &'a [Signal],
    ) -> Result<Self> {
        let (mut experiments, mut recorded) = (Vec::new(), Vec::new());
        for run in runs {
            let reference = run.reference(machine);
            let traces = sketch(machine, otherwise, &reference, run.begins_s)?;
            recorded.push(as_logged(run, machine, &reference, traces, logged)?);
        }
        for run in &recorded {
            experiments.push(Experiment::new(run, machine)?);
        }
        let floor = Floor::estimate(machine, &experiments.iter().collect::<Vec<_>>())?;
        let roles = shared_out(runs, recorded)?;
        Ok(Self { machine, otherwise, roles, logged, floor })
    }

    /// The gap between the machine with some effects and with others; infinite where it does not work with them. It is the
    /// smaller of those on training and on held-out runs: what no training run shows, nobody can find.
    pub fn gap(&self, effects: &[(EffectId, Vec<f64>)], others: &[(EffectId, Vec<f64>)]) -> f64 {
        let gap = self.try_gap(effects, others).unwrap_or(f64::INFINITY);
        if gap.is_finite() && gap < BROKEN { gap } else { f64::INFINITY }
    }

    fn try_gap(&self, effects: &[(EffectId, Vec<f64>)], others: &[(EffectId, Vec<f64>)]) -> Result<f64> {
        let machine = with_effects(self.machine, effects)?;
        let other = with_effects(self.machine, others)?;
        let mut least = f64::INFINITY;
        for runs in &self.roles {
            let (mut experiments, mut predicted) = (Vec::new(), Vec::new());
            for run in runs {
                let reference = run.reference(self.machine);
                let traces = sketch(&machine, self.otherwise, &reference, run.begins_s)?;
                let logged = as_logged(run, self.machine, &reference, traces, self.logged)?;
                experiments.push(Experiment::new(&logged, self.machine)?);
                predicted.push(sketch(&other, self.otherwise, &reference, run.begins_s)?);
            }
            let score = Score::of_traces(&experiments, &predicted, &self.floor);
            // Perfect sensors on both sides: noise adds one.
            least = least.min((1.0 + score.mean_square()).sqrt());
        }
        Ok(least)
    }

    /// The gap of a family at a size.
    fn gap_at(&self, family: &Family, size: f64) -> f64 {
        let with = |more: &[(EffectId, Vec<f64>)]| [&family.base[..], more].concat();
        self.gap(&with(&[(family.effect, family.values(size))]), &with(&family.reduced))
    }

    /// The family at the size whose gap lies at `share` (0 to 1) of the way from `least` to `largest`, on a logarithmic
    /// scale, as far as its range allows; what it reaches at most where that is below `least`.
    ///
    /// # Errors
    /// The largest gap that the family reaches, as the number in `Err`.
    pub fn sized(
        &self,
        family: &Family,
        (least, largest): (f64, f64),
        share: f64,
    ) -> std::result::Result<Sized, f64> {
        let (mut low, mut high) = family.range;
        let (at_low, at_high) = (self.gap_at(family, low), self.gap_at(family, high));
        if at_high < least {
            return Err(at_high);
        }
        // Constants with a tolerance have a least size, which may make a larger gap than was asked for.
        let from = least.max(at_low);
        let to = largest.max(1.5 * from).min(at_high.max(from));
        let wanted = from * (to / from).powf(share);
        let found = |size: f64, gap: f64| Sized { effect: family.effect, values: family.values(size), gap };
        if !wanted.is_finite() {
            return Err(f64::INFINITY);
        }
        let mut best = (low, at_low);
        for _ in 0..MOST_STEPS {
            let off = |gap: f64| (gap / wanted).ln().abs();
            if off(best.1) < PRECISION {
                break;
            }
            let size = (low * high).sqrt();
            let gap = self.gap_at(family, size);
            if off(gap) < off(best.1) || !best.1.is_finite() {
                best = (size, gap);
            }
            if gap < wanted { low = size } else { high = size }
        }
        Ok(found(best.0, best.1))
    }
}

/// The run that a logger would have made: measured signals as far as they are logged.
///
/// # Errors
/// Numbers that are not finite: the machine does not work.
pub fn as_logged(
    told: &TrialRun,
    machine: &Machine,
    reference: &[f64],
    traces: Traces,
    logged: &[Signal],
) -> Result<Run> {
    let whole = recorded(&told.name, machine, reference, traces)?;
    let signals = whole.signals().iter().filter(|(signal, _)| logged.contains(signal));
    let signals = signals.map(|(signal, samples)| (*signal, samples.clone())).collect();
    let mut run = Run::new(&told.name, whole.motion(), whole.sample_period_s(), signals)?;
    run.role = told.role;
    run.metadata = told.metadata(machine);
    run.begins_s = told.begins_s;
    Ok(run)
}
