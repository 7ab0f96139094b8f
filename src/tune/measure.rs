//! Settings of a controller measured on strokes.

use super::criteria::Values;
use super::{Criterion, Knob, Limits};
use crate::error::Result;
use crate::identify::margins::Margins;
use crate::machine::Machine;
use crate::plant::axis::{Axis, LANES};
use crate::replay::crosscheck::ramp_s;
use crate::replay::{Cell, Figures, Motion, Traces, follow, planned_reference, run, run_together};
use crate::twin::{Command, Driven, LinearLoop, LinearPlant, Sensing, Twin};
use rayon::prelude::*;
use std::sync::Arc;

/// Time in which an axis that something pushes comes to rest under control, s.
const STANDING_S: f64 = 2.0;
/// An axis this many strokes away from its reference has run away.
const RUN_AWAY: f64 = 10.0;
/// Two lengths or forces that differ by less than this share are the same.
const SAME: f64 = 1e-6;

/// Figures of merit of one stroke, in the order of [`Criterion::ALL`].
type OfStroke = [f64; Criterion::OF_STROKE];

/// A setting and what it does.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// A value a knob.
    pub values: Vec<f64>,
    /// Figures of every stroke, the first seven of [`Criterion::ALL`]; settling time is infinite where it does not settle.
    pub strokes: Vec<[f64; 7]>,
    /// Gain margin in dB, phase margin in degrees, modulus margin; infinite where there is none to lose.
    pub margins: [f64; 3],
    /// Whether the linear loop is stable.
    pub is_stable: bool,
}

impl Setting {
    /// The worst of all strokes, and the margins.
    pub fn worst(&self) -> Values {
        std::array::from_fn(|k| match k.checked_sub(Criterion::OF_STROKE) {
            Some(margin) => self.margins[margin],
            None => self.strokes.iter().map(|stroke| stroke[k]).fold(f64::NEG_INFINITY, f64::max),
        })
    }

    /// Mean of a criterion over the strokes; a margin as it is.
    pub fn mean(&self, criterion: Criterion) -> f64 {
        let k = criterion as usize;
        match k.checked_sub(Criterion::OF_STROKE) {
            Some(margin) => self.margins[margin],
            None => self.strokes.iter().map(|stroke| stroke[k]).sum::<f64>() / self.strokes.len() as f64,
        }
    }

    /// Excess over the limits, summed over strokes and margins; more than any number for an unstable loop.
    pub fn excess(&self, limits: &Limits) -> f64 {
        self.excess_of_margins(limits) + self.excess_of_strokes(limits)
    }

    /// By how much the margins fall short of their bounds; more than any number for an unstable loop.
    pub fn excess_of_margins(&self, limits: &Limits) -> f64 {
        if !self.is_stable {
            return f64::INFINITY;
        }
        let of_loop = Criterion::ALL[Criterion::OF_STROKE..].iter().zip(self.margins);
        of_loop.map(|(criterion, value)| limits.excess(*criterion, value)).sum()
    }

    /// By how much the strokes exceed their limits, all strokes together.
    pub fn excess_of_strokes(&self, limits: &Limits) -> f64 {
        let of_stroke = |stroke: &OfStroke| {
            Criterion::ALL.into_iter().zip(stroke).map(|(c, value)| limits.excess(c, *value)).sum::<f64>()
        };
        self.strokes.iter().map(of_stroke).sum()
    }

    /// Whether it is no worse than another setting, stroke by stroke: inside the limits no figure with a limit counts,
    /// beyond them it may not be worse; settling time and following error may not be worse at all (by more than a sample,
    /// by more than rounding).
    pub fn is_at_least_as_good_as(&self, other: &Self, limits: &Limits, period_s: f64) -> bool {
        let no_worse = |criterion: Criterion, mine: f64, theirs: f64| {
            let bound = limits.bound(criterion);
            match criterion {
                _ if criterion.is_margin() => bound.is_none_or(|bound| mine >= theirs.min(bound)),
                Criterion::SettlingTime => mine <= theirs + 1.5 * period_s,
                Criterion::FollowingError => mine <= theirs * (1.0 + SAME),
                _ => bound.is_none_or(|bound| mine <= theirs.max(bound)),
            }
        };
        let strokes = self.strokes.iter().zip(&other.strokes).all(|(mine, theirs)| {
            Criterion::ALL.into_iter().zip(mine.iter().zip(theirs)).all(|(c, (a, b))| no_worse(c, *a, *b))
        });
        let of_loop =
            Criterion::ALL[Criterion::OF_STROKE..].iter().zip(self.margins.iter().zip(&other.margins));
        self.is_stable && strokes && of_loop.into_iter().all(|(c, (a, b))| no_worse(*c, *a, *b))
    }
}

/// A stroke as it is commanded.
#[derive(Debug)]
struct Planned {
    motion: Motion,
    reference: Vec<f64>,
    commands: Vec<Command>,
}

impl Planned {
    /// Whether the axis has run away.
    fn diverges(&self, figures: &OfStroke) -> bool {
        let travel = self.motion.strokes.iter().map(|stroke| stroke.stroke.abs()).sum::<f64>();
        let error = figures[Criterion::FollowingError as usize];
        let is_finite = Criterion::ALL.into_iter().zip(figures);
        let is_finite = is_finite.into_iter().all(|(c, x)| x.is_finite() || c == Criterion::SettlingTime);
        !is_finite || error > RUN_AWAY * travel
    }
}

/// A machine on which settings are measured.
#[derive(Debug)]
pub struct Bench<'a> {
    machine: &'a Machine,
    knobs: &'a [Knob],
    axis: Axis,
    plant: Arc<LinearPlant>,
    strokes: Vec<Planned>,
    /// Samples that the axis stands before each stroke: none where nothing pushes it.
    standing: usize,
    period_s: f64,
}

impl<'a> Bench<'a> {
    /// A machine, its knobs, and strokes with a standstill after each.
    ///
    /// # Errors
    /// A stroke beyond the travel.
    pub fn new(machine: &'a Machine, knobs: &'a [Knob], cells: &[Cell], dwell_s: f64) -> Result<Self> {
        let period_s = machine.description().sample_period_s;
        let planned = |cell: &Cell| {
            let stroke = cell.stroke(machine.motion())?;
            let ramp_s = ramp_s(machine, &stroke);
            let motion = Motion { strokes: vec![stroke], lead_s: 0.0, dwell_s, ramp_s };
            let reference = planned_reference(machine, &motion)?;
            // A first sample at rest: the reference starts from zero.
            let reference: Vec<f64> = [0.0].into_iter().chain(reference).collect();
            let commands = follow(&reference, period_s).collect();
            Ok(Planned { motion, reference, commands })
        };
        let strokes = cells.iter().map(planned).collect::<Result<_>>()?;
        let axis = Axis::of(&machine.constants());
        let standing = standing(machine, &axis, period_s);
        Ok(Self {
            machine,
            knobs,
            axis,
            plant: Arc::new(LinearPlant::of(machine)),
            strokes,
            standing,
            period_s,
        })
    }

    /// The machine.
    pub fn machine(&self) -> &Machine {
        self.machine
    }

    /// Sample period of the controller, s.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Measures settings, a value a knob each; `each` is told how many more are done.
    ///
    /// # Errors
    /// A value that the machine refuses.
    pub fn measure(&self, settings: &[Vec<f64>], each: &(impl Fn(usize) + Sync)) -> Result<Vec<Setting>> {
        let measured = settings
            .par_chunks(LANES)
            .map(|chunk| {
                let measured = self.measure_together(chunk);
                each(chunk.len());
                measured
            })
            .collect::<Result<Vec<_>>>()?;
        Ok(measured.concat())
    }

    fn measure_together(&self, settings: &[Vec<f64>]) -> Result<Vec<Setting>> {
        let set = |values: &Vec<f64>| {
            let pairs =
                self.knobs.iter().zip(values).map(|(knob, value)| (knob.key.as_str(), knob.value(*value)));
            self.machine.with_settings(pairs)
        };
        let machines: Vec<Machine> = settings.iter().map(set).collect::<Result<_>>()?;
        let mut measured: Vec<Setting> =
            machines.iter().zip(settings).map(|(m, v)| self.of_loop(m, v)).collect();
        for stroke in &self.strokes {
            for (setting, traces) in measured.iter_mut().zip(self.replay(&machines, stroke)) {
                let figures = self.figures(stroke, &traces);
                setting.is_stable &= !stroke.diverges(&figures);
                setting.strokes.push(figures);
            }
        }
        Ok(measured)
    }

    /// Margins and stability of a setting.
    fn of_loop(&self, machine: &Machine, values: &[f64]) -> Setting {
        let gains = machine.constants().controller.map(|law| law.gains(self.period_s));
        let closed = gains.map(|gains| LinearLoop::new(Arc::clone(&self.plant), gains));
        let margins = closed.as_ref().map(|closed| lost(&closed.margins())).unwrap_or([f64::NAN; 3]);
        Setting {
            values: values.to_vec(),
            strokes: Vec::with_capacity(self.strokes.len()),
            margins,
            is_stable: closed.is_some_and(|closed| closed.is_stable()),
        }
    }

    /// A stroke of several settings in one pass.
    fn replay(&self, machines: &[Machine], stroke: &Planned) -> Vec<Traces> {
        let samples = stroke.commands.len();
        let twins = machines.iter().map(|m| Twin::new(m, self.axis.clone(), Sensing::Perfect)).collect();
        let mut traces: Vec<Traces> = machines.iter().map(|_| Traces::with_capacity(samples)).collect();
        let rest = Command::follow(0.0, 0.0);
        run_together(
            twins,
            Driven::ByControllers,
            self.standing + samples,
            |_, k| k.checked_sub(self.standing).map_or(rest, |k| stroke.commands[k]),
            |_| None,
            |twin, _, sample| traces[twin].push(sample),
        );
        for of_twin in &mut traces {
            of_twin.forget(self.standing + 1);
        }
        traces
    }

    fn figures(&self, stroke: &Planned, traces: &Traces) -> OfStroke {
        let figures = Figures::of(&stroke.motion, self.period_s, traces);
        let errors = stroke.reference[1..].iter().zip(&traces.position).map(|(r, x)| (r - x).abs());
        [
            figures.overshoot,
            figures.peak_velocity.max(0.0),
            (-figures.most_negative_velocity).max(0.0),
            figures.settling_s.unwrap_or(f64::INFINITY),
            errors.fold(0.0, f64::max),
            figures.peak_thrust,
            figures.peak_effort_v,
        ]
    }
}

/// Margins as numbers: without a crossing there is none to lose.
fn lost(margins: &Margins) -> [f64; 3] {
    [
        margins.gain.map_or(f64::INFINITY, |gain| gain.margin_db),
        margins.phase.map_or(f64::INFINITY, |phase| phase.margin_deg),
        margins.modulus.map_or(f64::INFINITY, |modulus| modulus.margin),
    ]
}

/// How long the axis must stand before a stroke: not at all where it keeps still by itself.
fn standing(machine: &Machine, axis: &Axis, period_s: f64) -> usize {
    let samples = (STANDING_S / period_s).round() as usize;
    let mut twin = Twin::new(machine, axis.clone(), Sensing::Perfect);
    let reference = vec![0.0; samples.min(64)];
    let traces = run(&mut twin, follow(&reference, period_s), |_| ());
    let is_still = |trace: &[f64]| trace.iter().all(|x| *x == 0.0);
    if is_still(&traces.position) && is_still(&traces.effort_v) { 0 } else { samples }
}
