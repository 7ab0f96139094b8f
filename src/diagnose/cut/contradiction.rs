//! What the log says against an explanation: a stretch of the signal path, replayed alone from its measured input, does not give its measured output.

use super::at_rest::Rest;
use super::scales::Scales;
use super::{Cut, Stated, residual};
use crate::diagnose::experiment::Experiment;
use crate::diagnose::fit::Fit;
use crate::diagnose::free::Free;
use crate::diagnose::parameter::NORMAL_975;
use crate::diagnose::thresholds::{ADEQUATE_GAP, LARGELY};
use crate::effect::{EffectId, Site, Stretch};
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;

/// Why the log contradicts an explanation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contradiction {
    /// At rest its control law reproduces the effort worse than the law as stated.
    AtRest,
    /// A stretch is off by more than the closed loop of the twin as it is.
    Open(Cut),
}

/// Stretches without a plant in them whose replay holds every effect that acts there: between two logged signals they leave what their noise makes.
const CUTS: [Cut; 2] = [Cut::Controller, Cut::Drive];

/// What the stretches of the twin as it is leave of the log.
#[derive(Debug, Clone)]
pub struct StatedStretches {
    at_rest: Rest,
    stretches: Vec<StatedStretch>,
}

#[derive(Debug, Clone)]
struct StatedStretch {
    cut: Cut,
    /// What the stretch leaves.
    left: Scales,
    /// What it leaves of a log that the twin as it is makes, noise as stated.
    made: Scales,
    /// By what the closed loop misses its output.
    closed_loop: Scales,
}

/// The first scale that counts: over 16 samples rounding of the log averages out.
const SMOOTH: usize = 2;

impl StatedStretches {
    /// Those of these runs of a machine; none are told of no runs.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub fn of(machine: &Machine, runs: &[Stated]) -> Result<Self> {
        let experiments: Vec<&Experiment> = runs.iter().map(|run| run.experiment).collect();
        let mut stretches = Vec::new();
        for cut in CUTS.into_iter().filter(|_| !runs.is_empty()) {
            let Some(left) = left(cut, machine, &experiments)? else { continue };
            let (mut made, mut missed) = (Scales::default(), Scales::default());
            for Stated { experiment, machine, imagined, predicted } in runs {
                if let Some(residual) = residual(cut, imagined, machine)? {
                    made.add(&logged(cut, machine, residual));
                }
                let log = |signal| experiment.run().signal(signal).zip(predicted.signal(signal));
                let off = log(output(cut)).map(|(logged, replayed)| difference(logged, replayed));
                missed.add(&off.unwrap_or_default());
            }
            stretches.push(StatedStretch { cut, left, made, closed_loop: missed });
        }
        Ok(Self { at_rest: at_rest(machine, &experiments)?, stretches })
    }

    /// What contradicts a fit, if anything does.
    ///
    /// # Model
    /// No plant lies in these stretches: the one that ran leaves of its output what noise makes of it, whatever the plant is. With r₀ and r₁ what a stretch as stated
    /// and as fitted leaves, and e₀ by what the closed loop of the twin as it is misses its output:
    ///
    /// - *The controller at rest* passes on noise and steps of its readings, which are in the log. A fit that changes the law is contradicted where it leaves
    ///   more there, r₁ > 1.25·r₀·max(1, u₁/u₀). The last factor is what the laws make of the position: a law that passes on more makes more of a
    ///   log that is coarser than the controller's readings.
    /// - *Throughout*, in means over 16, 64, … samples, a stretch that misses its output by more than the closed loop does, r₁ > 1.25·e₀, and by more than stated
    ///   noise makes, is not the one that ran, unless the fit closes nine tenths of the power of r₀: no effect elsewhere can change what is
    ///   left of it.
    ///
    /// A number whose 95 % interval holds the twin's own value is left at that: how far a fit puts it beside is chance.
    ///
    /// # Validity
    /// Input and output of a stretch logged at even times. With an effect between motor and reading the drive is not asked: the speed of its motor is then not what
    /// the log shows. Where the position stands still between two steps of its sensor, the first says nothing.
    ///
    /// # Errors
    /// A setting of a run that the machine does not have.
    pub fn contradiction(
        &self,
        machine: &Machine,
        fit: &Fit,
        experiments: &[Experiment],
    ) -> Result<Option<Contradiction>> {
        if fit.hypothesis.effects.is_empty() || self.stretches.is_empty() {
            return Ok(None);
        }
        let experiments: Vec<&Experiment> = experiments.iter().collect();
        let fitted = fit.hypothesis.machine(machine, &significant(fit))?;
        let is_changed = |cut| fit.hypothesis.effects.iter().any(|effect| changes(*effect, cut));
        if is_changed(Cut::Controller) && at_rest(&fitted, &experiments)?.leaves_more_than(&self.at_rest) {
            return Ok(Some(Contradiction::AtRest));
        }
        let moves_reading = fit.hypothesis.effects.iter().any(|effect| changes_reading(*effect));
        for stretch in self.stretches.iter().filter(|stretch| stretch.cut != Cut::Drive || !moves_reading) {
            let changed =
                if is_changed(stretch.cut) { left(stretch.cut, &fitted, &experiments)? } else { None };
            if stretch.stays_open(changed.as_ref().unwrap_or(&stretch.left)) {
                return Ok(Some(Contradiction::Open(stretch.cut)));
            }
        }
        Ok(None)
    }
}

/// Whether an effect lies between the motor and the reading, from whose rate the back-EMF of a drive that is replayed alone is taken.
fn changes_reading(effect: EffectId) -> bool {
    matches!(effect.site(), Site::Structure | Site::Sensor)
}

/// Whether an effect changes what a stretch leaves.
fn changes(effect: EffectId, cut: Cut) -> bool {
    match effect.stretch() {
        Stretch::Log => true,
        Stretch::Controller | Stretch::VelocityEstimate => cut == Cut::Controller,
        Stretch::Drive | Stretch::MotorForce => cut == Cut::Drive,
        Stretch::Mechanics | Stretch::Rounding => false,
    }
}

impl StatedStretch {
    fn stays_open(&self, left: &Scales) -> bool {
        (SMOOTH..left.0.len()).any(|scale| {
            let limit = (ADEQUATE_GAP * ADEQUATE_GAP).max(left.chance(scale));
            let known = self.closed_loop.power(scale).max(self.made.power(scale));
            let may_stay = (1.0 - LARGELY) * self.left.power(scale);
            left.power(scale) > (limit * known).max(may_stay)
        })
    }
}

/// The numbers of a fit, with the twin's own value in the place of those that cannot be told from it.
fn significant(fit: &Fit) -> Vec<f64> {
    let numbers = fit.hypothesis.free.iter().zip(&fit.values).zip(&fit.standard_errors);
    let own = |((free, value), error): ((&Free, &f64), &f64)| {
        let is_chance = (value - free.neutral).abs() <= NORMAL_975 * error;
        if is_chance && !free.neutral.is_nan() { free.neutral } else { *value }
    };
    numbers.map(own).collect()
}

/// What a stretch of a machine leaves of its output; none where a run does not tell. The drive's is the current: between it and a thrust, ripple and saturation
/// act, which the replay of the stretch does not have.
fn left(cut: Cut, machine: &Machine, experiments: &[&Experiment]) -> Result<Option<Scales>> {
    let mut left = Scales::default();
    let has_current = machine.description().motor.has_current();
    for experiment in experiments {
        let is_known = has_current && experiment.run().signal(Signal::Current).is_some();
        if cut == Cut::Drive && !is_known {
            return Ok(None);
        }
        let Some(residual) = residual(cut, experiment, &experiment.machine(machine)?)? else {
            return Ok(None);
        };
        left.add(&logged(cut, &experiment.machine(machine)?, residual));
    }
    Ok(Some(left))
}

/// The signal that a stretch ends in.
fn output(cut: Cut) -> Signal {
    match cut {
        Cut::Controller => Signal::ControlEffort,
        _ => Signal::Current,
    }
}

/// A residual of a stretch in the unit of its output's log, V or A: a fit that scales the log must not scale its noise.
fn logged(cut: Cut, machine: &Machine, mut residual: Vec<f64>) -> Vec<f64> {
    let constants = machine.constants();
    let scale = match cut {
        Cut::Controller => constants.log_scale.effort,
        _ => constants.log_scale.current / constants.force_constant(),
    };
    residual.iter_mut().for_each(|sample| *sample *= scale);
    residual
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn at_rest(machine: &Machine, experiments: &[&Experiment]) -> Result<Rest> {
    let mut rest = Rest::default();
    for experiment in experiments {
        rest.add(experiment, &experiment.machine(machine)?);
    }
    Ok(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scales(level: f64) -> Scales {
        let mut scales = Scales::default();
        scales.add(&vec![level; 4096]);
        scales
    }

    fn stretch(left: f64, missed: f64, made: f64) -> StatedStretch {
        StatedStretch { cut: Cut::Drive, left: scales(left), made: scales(made), closed_loop: scales(missed) }
    }

    /// A stretch that leaves 10 V where the closed loop misses its output by 1 V is contradicted by what leaves 4 V of it, and not by what leaves 3 V; where the
    /// closed loop misses it by 5 V, or stated noise makes 5 V, by neither.
    #[test]
    fn exact_what_is_left_of_a_stretch_is_told() {
        let is_open =
            |left: f64, missed: f64, made: f64| stretch(10.0, missed, made).stays_open(&scales(left));
        assert!(is_open(10.0, 1.0, 0.0) && is_open(4.0, 1.0, 0.0) && !is_open(3.0, 1.0, 0.0));
        assert!(!is_open(4.0, 5.0, 0.0) && !is_open(4.0, 1.0, 5.0) && is_open(40.0, 5.0, 5.0));
    }

    /// Rounding of the log that is as large averages out over 16 samples.
    #[test]
    fn exact_rounding_is_no_contradiction() {
        let mut rounding = Scales::default();
        rounding.add(&(0..4096).map(|k| if k % 2 == 0 { 10.0 } else { -10.0 }).collect::<Vec<f64>>());
        assert!(!stretch(0.0, 1.0, 0.0).stays_open(&rounding));
    }

    /// An encoder that errs shows a speed that the motor does not have: its back-EMF is not that of the log. Friction leaves the reading as it is.
    #[test]
    fn exact_what_lies_between_motor_and_reading_changes_the_speed_of_the_log() {
        assert!(
            [EffectId::EncoderPeriodicError, EffectId::EncoderScale, EffectId::ScrewError]
                .map(changes_reading)
                == [true; 3]
        );
        assert!(
            [EffectId::CoulombFriction, EffectId::DeadZone, EffectId::VelocityGain].map(changes_reading)
                == [false; 3]
        );
    }
}
