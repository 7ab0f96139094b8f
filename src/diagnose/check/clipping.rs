//! Signals that ran into a limit: a stated one, or one that shows in the data.

use super::super::experiment::Experiment;
use super::{Check, Finding};
use crate::controller::Controller;
use crate::machine::Machine;
use crate::recording::{Run, Signal};
use crate::units::engineering;

/// Share of samples at the voltage limit above which clipping is mentioned.
const CLIPPED: f64 = 0.001;
/// Equal samples in a row that are no chance where a signal else changes from sample to sample.
const LEAST_EQUAL: usize = 3;
/// Share of the signal's range by which a clipped signal still rises in the last step before its limit; one that
/// levels off by itself hardly does.
const ENTRY: f64 = 1e-3;
/// Steps of resolution by which a signal must rise into its limit to have gone beyond it: a rounded top of a smooth
/// signal, entered with slope s and n samples wide, hides s·n/4, which is one step, and two or three by rounding.
const HIDDEN_STEPS: f64 = 8.0;
/// Equal samples at other values than the extreme must be this many times rarer, or the signal is just coarse.
const RARER: usize = 5;

/// Clipping of the effort, the current and the thrust.
pub fn clipping(experiment: &Experiment, machine: &Machine) -> Vec<Finding> {
    let run = experiment.run();
    let mut findings: Vec<Finding> = stated(experiment, machine).into_iter().collect();
    let known = !findings.is_empty();
    let moving: Vec<bool> =
        experiment.recorded().commands().iter().map(|command| command.velocity_reference != 0.0).collect();
    for signal in [Signal::ControlEffort, Signal::Current, Signal::Thrust] {
        let Some(samples) = run.signal(signal) else { continue };
        if signal == Signal::ControlEffort && known {
            continue;
        }
        findings.extend(Plateaus::of(samples, &moving).and_then(|plateaus| plateaus.finding(run, signal)));
    }
    findings
}

/// The controller limits its own effort, the amplifier that with what is fed forward beside it.
fn stated(experiment: &Experiment, machine: &Machine) -> Option<Finding> {
    let (run, constants) = (experiment.run(), machine.constants());
    let limit = constants.effort_limit_v()?;
    let effort = run.signal(Signal::ControlEffort)?;
    let own_limit = constants.controller.as_ref().and_then(Controller::limit).map(|own| own.effort_limit_v);
    let reaches = |u: f64, limit: Option<f64>| limit.is_some_and(|limit| u.abs() >= limit);
    let commanded = experiment.recorded().commanded_v(effort);
    let pairs = effort.iter().zip(&commanded);
    let at_limit = pairs.filter(|(u, whole)| {
        reaches(**u, own_limit) || reaches(**whole, constants.amplifier.voltage_limit_v)
    });
    let clipped = at_limit.count() as f64 / effort.len() as f64;
    (clipped > CLIPPED).then(|| {
        Finding::warning(
            run.name(),
            Check::Clipping,
            format!(
                "The effort is at the stated limit of {limit} V in {:.1} % of the samples: the loop is open \
                 there.",
                100.0 * clipped
            ),
        )
    })
}

/// Stretches of a signal with exactly one value, entered with a step.
#[derive(Debug, Default, PartialEq)]
struct Plateaus {
    /// Samples at the highest value, and that value; likewise at the lowest.
    at_extremes: Vec<(f64, usize)>,
    /// Samples of plateaus elsewhere.
    elsewhere: usize,
    count: usize,
}

impl Plateaus {
    fn of(samples: &[f64], moving: &[bool]) -> Option<Self> {
        let (low, high) =
            samples.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
        if high <= low {
            return None;
        }
        let mut found = Self { at_extremes: vec![(high, 0), (low, 0)], elsewhere: 0, count: samples.len() };
        let steps = samples.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 0.0);
        let resolution = steps.fold(f64::INFINITY, f64::min);
        let mut from = 0;
        for k in 1..=samples.len() {
            if k < samples.len() && samples[k] == samples[from] {
                continue;
            }
            let entered = from > 1 && {
                let slope = 0.5 * (samples[from] - samples[from - 2]).abs();
                let hidden = 0.25 * slope * (k - from) as f64;
                slope > ENTRY * (high - low) && hidden > HIDDEN_STEPS * resolution
            };
            // Standstill is not clipping, but an axis that is told to move and brakes may be at its limit.
            let commanded = moving[from..k].iter().any(|moving| *moving);
            if k - from >= LEAST_EQUAL && commanded {
                match found.at_extremes.iter_mut().find(|(value, _)| *value == samples[from]) {
                    Some((_, number)) if entered => *number += k - from,
                    Some(_) => {}
                    None => found.elsewhere += k - from,
                }
            }
            from = k;
        }
        Some(found)
    }

    fn finding(&self, run: &Run, signal: Signal) -> Option<Finding> {
        let clipped: usize = self.at_extremes.iter().map(|(_, number)| number).sum();
        if clipped == 0 || clipped <= RARER * self.elsewhere {
            return None;
        }
        let at: Vec<String> = self
            .at_extremes
            .iter()
            .filter(|(_, number)| *number > 0)
            .map(|(value, _)| engineering(*value, signal.si_unit(run.motion())))
            .collect();
        let share = 100.0 * clipped as f64 / self.count as f64;
        let consequence = if signal == Signal::ControlEffort {
            "If the amplifier limits it, state amplifier.voltage_limit_v; the loop is open there."
        } else {
            "What lies beyond was cut off by the drive or by the logger's range, and the twin knows neither."
        };
        Some(Finding::warning(
            run.name(),
            Check::Clipping,
            format!(
                "The {} does not go beyond {} and stays exactly there in {share:.1} % of the samples: it is \
                 clipped. {consequence}",
                signal.word(run.motion()),
                at.join(" and ")
            ),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clipped(samples: &[f64]) -> usize {
        let plateaus = Plateaus::of(samples, &vec![true; samples.len()]).unwrap();
        let at: usize = plateaus.at_extremes.iter().map(|(_, number)| number).sum();
        if at > RARER * plateaus.elsewhere { at } else { 0 }
    }

    fn wave(amplitude: f64) -> Vec<f64> {
        (0..1000).map(|k| amplitude * (f64::from(k) * 0.037).sin()).collect()
    }

    #[test]
    fn exact_cut_tops_are_clipping() {
        let cut: Vec<f64> = wave(3.0).iter().map(|x| x.clamp(-2.0, 2.5)).collect();
        assert!(clipped(&cut) > 300);
    }

    #[test]
    fn exact_whole_waves_and_coarse_ones_are_not() {
        assert_eq!(clipped(&wave(3.0)), 0);
        for levels in [10.0, 100.0, 2000.0] {
            let coarse: Vec<f64> = wave(1.0).iter().map(|x| (x * levels).round() / levels).collect();
            assert_eq!(clipped(&coarse), 0, "{levels}");
        }
        // A signal that settles at its largest value levels off.
        let settling: Vec<f64> = (0..1000).map(|k| 1.0 - (-f64::from(k) * 0.05).exp()).collect();
        assert_eq!(clipped(&settling), 0);
    }
}
