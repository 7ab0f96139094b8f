//! Channels that do not change while the axis is told to move, or change only now and then.

use super::super::experiment::Experiment;
use super::{Check, Finding};
use crate::recording::{Run, Signal};
use crate::units::engineering;

/// Changes of a signal from which a regular pattern is no chance: 20 changes that all fall on one of m phases
/// happen by chance once in m¹⁹.
const LEAST_CHANGES: usize = 20;
/// A position that stays the same while its reference travels this share of its range has not merely stuck.
const FROZEN_TRAVEL: f64 = 0.25;

/// Stuck and held channels of a run.
pub fn stuck(experiment: &Experiment) -> Vec<Finding> {
    let run = experiment.run();
    let reference = run.signal(Signal::PositionReference).unwrap_or_default();
    if range(reference) == 0.0 {
        return Vec::new();
    }
    let measured = run.signals().iter().filter(|(signal, _)| signal.is_measured());
    let find = |(signal, samples): (&Signal, &Vec<f64>)| {
        constant(run, *signal, samples)
            .or_else(|| frozen(run, *signal, samples, reference))
            .or_else(|| held(run, *signal, samples, reference))
    };
    measured.filter_map(find).collect()
}

fn range(samples: &[f64]) -> f64 {
    let (low, high) =
        samples.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    if high > low { high - low } else { 0.0 }
}

fn constant(run: &Run, signal: Signal, samples: &[f64]) -> Option<Finding> {
    (range(samples) == 0.0).then(|| {
        let value = engineering(samples[0], signal.si_unit(run.motion()));
        Finding::warning(
            run.name(),
            Check::StuckChannel,
            format!(
                "The {} stays at {value} while the reference moves: the channel is dead, or the column is the \
                 wrong one. Take it out of the recording or log it again.",
                signal.word(run.motion())
            ),
        )
    })
}

/// A position that stops changing for a while.
fn frozen(run: &Run, signal: Signal, samples: &[f64], reference: &[f64]) -> Option<Finding> {
    if !matches!(signal, Signal::Position | Signal::LoadPosition) {
        return None;
    }
    let (mut from, mut worst) = (0, (0.0, 0, 0));
    for k in 1..=samples.len() {
        if k < samples.len() && samples[k] == samples[k - 1] {
            continue;
        }
        let travel = range(&reference[from..k]);
        if travel > worst.0 {
            worst = (travel, from, k);
        }
        from = k;
    }
    let (travel, from, to) = worst;
    (travel > FROZEN_TRAVEL * range(reference)).then(|| {
        Finding::warning(
            run.name(),
            Check::StuckChannel,
            format!(
                "The {} stays the same from sample {from} to {} while the reference travels {}: the channel \
                 froze, or the axis was blocked. Cut the run there.",
                signal.word(run.motion()),
                to - 1,
                engineering(travel, signal.si_unit(run.motion()))
            ),
        )
    })
}

/// A signal that changes at every m-th sample only, while the reference changes at others too.
fn held(run: &Run, signal: Signal, samples: &[f64], reference: &[f64]) -> Option<Finding> {
    let every = stride(samples)?;
    (stride(reference) != Some(every)).then(|| {
        let period = engineering(every as f64 * run.sample_period_s(), "s");
        Finding::warning(
            run.name(),
            Check::HeldChannel,
            format!(
                "The {} changes only at every {every}th sample: it was sampled every {period} and held, which \
                 makes it late by {:.1} samples on average. Log it at the controller's rate.",
                signal.word(run.motion()),
                0.5 * (every - 1) as f64
            ),
        )
    })
}

/// The largest m ≥ 2 such that all changes lie a multiple of m apart.
fn stride(samples: &[f64]) -> Option<usize> {
    let changes: Vec<usize> = (1..samples.len()).filter(|k| samples[*k] != samples[k - 1]).collect();
    let divisor = changes.windows(2).map(|pair| pair[1] - pair[0]).fold(0, common_divisor);
    (changes.len() >= LEAST_CHANGES && divisor >= 2).then_some(divisor)
}

fn common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { common_divisor(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_stride_of_a_held_signal() {
        let held = |every: usize| (0..400).map(|k| ((k / every) as f64 * 0.1).sin()).collect::<Vec<f64>>();
        assert_eq!(stride(&held(1)), None);
        assert_eq!(stride(&held(4)), Some(4));
        // A coarse staircase changes where the signal wants.
        let coarse: Vec<f64> = (0..400).map(|k| (8.0 * (f64::from(k) * 0.02).sin()).round()).collect();
        assert_eq!(stride(&coarse), None);
    }
}
