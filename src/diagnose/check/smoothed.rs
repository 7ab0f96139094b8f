//! A run's signals smoothed alike, so that they can be compared sample by sample.

use super::super::experiment::Experiment;
use crate::controller::ReferenceDelay;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::twin::Command;
use std::collections::BTreeMap;

/// Half width of one pass of the smoothing in s: three passes leave what is slower than about 60 Hz, below most
/// structural modes and above most strokes.
const HALF_WIDTH_S: f64 = 2e-3;
/// Passes of the moving mean.
const PASSES: usize = 3;
/// Longest shift between channels that is looked for, in s: fieldbus and logger delays stay below it.
const LONGEST_SHIFT_S: f64 = 10e-3;
/// But at least and at most so many samples.
const SHIFTS: (usize, usize) = (8, 64);
/// Below this share of the run's top speed the axis may stick, and friction is anything.
const SLOW: f64 = 0.02;

/// Smoothed signals of one run and the motion read off its position.
///
/// # Model
/// Every signal passes the same three moving means (no phase); velocity and acceleration are the central
/// differences of the smoothed position.
#[derive(Debug, Clone)]
pub struct Smoothed {
    /// Sample period in s.
    pub period_s: f64,
    /// Longest shift that the margins leave room for, in samples.
    pub most_shift: usize,
    /// Every logged signal, smoothed.
    pub signals: BTreeMap<Signal, Vec<f64>>,
    /// Position and velocity reference as the controller acts on them, as late as the machine states, smoothed; empty where they are not known sample by
    /// sample.
    pub acted_on: [Vec<f64>; 2],
    /// Sign of the commanded velocity, smoothed.
    pub direction: Vec<f64>,
    /// What was fed forward beside the effort in V, smoothed.
    feedforward_v: Vec<f64>,
    /// Velocity in m/s or rad/s.
    pub velocity: Vec<f64>,
    /// Acceleration in m/s² or rad/s².
    pub acceleration: Vec<f64>,
    /// Samples that any shift keeps clear of the ends.
    pub inner: Vec<usize>,
    /// Those of them in which the axis moves well clear of standstill and reversal.
    pub moving: Vec<usize>,
}

impl Smoothed {
    /// Smooths a run of a machine.
    pub fn of(experiment: &Experiment, machine: &Machine) -> Self {
        let run = experiment.run();
        let period_s = run.sample_period_s();
        let half = ((HALF_WIDTH_S / period_s).round() as usize).max(1);
        let reach = PASSES * half + 1;
        let most_shift = ((LONGEST_SHIFT_S / period_s).ceil() as usize).clamp(SHIFTS.0, SHIFTS.1);
        let signals: BTreeMap<Signal, Vec<f64>> =
            run.signals().iter().map(|(signal, samples)| (*signal, smooth(samples, half))).collect();
        let position = signals.get(&Signal::Position).cloned().unwrap_or_default();
        let (velocity, acceleration) = differences(&position, period_s);
        let margin = reach + most_shift + 1;
        let inner: Vec<usize> = (margin..run.len().saturating_sub(margin)).collect();
        let fastest = inner.iter().fold(0.0, |most: f64, k| most.max(velocity[*k].abs()));
        let slow: Vec<bool> = velocity.iter().map(|v| v.abs() <= SLOW * fastest).collect();
        let clear = |k: &usize| slow[k - reach..=k + reach].iter().all(|slow| !slow);
        let moving = inner.iter().copied().filter(clear).collect();
        let commanded = |of: fn(&Command) -> f64| -> Vec<f64> {
            smooth(&experiment.recorded().commands().iter().map(of).collect::<Vec<f64>>(), half)
        };
        let feedforward_v = commanded(|command| command.feedforward_v);
        let direction = commanded(|command| sign(command.velocity_reference));
        let acted_on = late_references(experiment, machine).map(|reference| smooth(&reference, half));
        Self {
            period_s,
            most_shift,
            signals,
            feedforward_v,
            velocity,
            acceleration,
            inner,
            moving,
            acted_on,
            direction,
        }
    }

    /// A smoothed signal, if it was logged.
    pub fn signal(&self, signal: Signal) -> Option<&[f64]> {
        self.signals.get(&signal).map(Vec::as_slice)
    }

    /// A smoothed signal as it tells the motor's force: an effort with what was fed forward beside it.
    pub fn driving(&self, signal: Signal) -> Option<Vec<f64>> {
        let samples = self.signal(signal)?;
        if signal != Signal::ControlEffort {
            return Some(samples.to_vec());
        }
        Some(samples.iter().zip(&self.feedforward_v).map(|(effort, fed)| effort + fed).collect())
    }

    /// Acceleration, velocity and direction for either direction, position and a constant at the moving samples:
    /// whatever mass, friction, spring and weight need.
    pub fn motion_columns(&self, machine: &Machine, at: &[usize]) -> MotionColumns {
        let pick = |value: &dyn Fn(usize) -> f64| at.iter().map(|k| value(*k)).collect::<Vec<f64>>();
        let position = self.signal(Signal::Position).unwrap_or_default();
        let mut others = vec![
            vec![1.0; at.len()],
            pick(&|k| self.velocity[k].max(0.0)),
            pick(&|k| self.velocity[k].min(0.0)),
            pick(&|k| self.velocity[k].signum()),
            pick(&|k| position[k]),
        ];
        // A pendulum's weight of any size and place of the centre.
        if machine.weight().is_some_and(|weight| !weight.is_constant()) {
            others.extend([pick(&|k| position[k].cos()), pick(&|k| position[k].sin())]);
        }
        MotionColumns { acceleration: pick(&|k| self.acceleration[k]), others }
    }
}

/// Columns of the inverse dynamics.
pub struct MotionColumns {
    /// Of the mass.
    pub acceleration: Vec<f64>,
    /// Of friction, spring and weight.
    pub others: Vec<Vec<f64>>,
}

/// Three moving means over 2·half + 1 samples; at the ends over what there is.
fn smooth(samples: &[f64], half: usize) -> Vec<f64> {
    let mut smooth = samples.to_vec();
    for _ in 0..PASSES {
        let mut sums = Vec::with_capacity(smooth.len() + 1);
        // About the first sample: sums of a far-travelled position would lose the digits of its noise.
        let base = smooth.first().copied().unwrap_or_default();
        sums.push(0.0);
        for sample in &smooth {
            sums.push(sums[sums.len() - 1] + (sample - base));
        }
        let count = smooth.len();
        for (k, sample) in smooth.iter_mut().enumerate() {
            let (from, to) = (k.saturating_sub(half), (k + half + 1).min(count));
            *sample = base + (sums[to] - sums[from]) / (to - from) as f64;
        }
    }
    smooth
}

/// The position and velocity reference of a run, as late as the machine states.
fn late_references(experiment: &Experiment, machine: &Machine) -> [Vec<f64>; 2] {
    let (run, commands) = (experiment.run(), experiment.recorded().commands());
    if run.signal(Signal::PositionReference).is_none() || commands.len() != run.len() {
        return [Vec::new(), Vec::new()];
    }
    let mut delay = ReferenceDelay::new(machine.description().reference.delay_s, run.sample_period_s());
    let acted_on = commands.iter().map(|command| {
        let [position, velocity] = [command.position_reference, command.velocity_reference];
        delay.as_mut().map_or([position, velocity], |delay| delay.pass(position, velocity))
    });
    let [position, velocity]: [Vec<f64>; 2] =
        acted_on.map(|[position, velocity]| (position, velocity)).unzip().into();
    [position, velocity]
}

/// −1, 0 or 1.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// First and second central differences; zero at the ends.
pub fn differences(position: &[f64], period_s: f64) -> (Vec<f64>, Vec<f64>) {
    let (mut first, mut second) = (vec![0.0; position.len()], vec![0.0; position.len()]);
    for (k, x) in position.windows(3).enumerate() {
        first[k + 1] = (x[2] - x[0]) / (2.0 * period_s);
        second[k + 1] = (x[2] - 2.0 * x[1] + x[0]) / (period_s * period_s);
    }
    (first, second)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_lines_pass_unchanged_and_parabolas_keep_their_curvature() {
        let line: Vec<f64> = (0..200).map(|k| 3.0 - 0.25 * f64::from(k)).collect();
        let smooth_line = smooth(&line, 4);
        assert!((20..180).all(|k| (smooth_line[k] - line[k]).abs() < 1e-12));
        let parabola: Vec<f64> = (0..200).map(|k| 0.5 * (f64::from(k) * 1e-3).powi(2)).collect();
        let (velocity, acceleration) = differences(&smooth(&parabola, 4), 1e-3);
        assert!((20..180).all(|k| (acceleration[k] - 1.0).abs() < 1e-6));
        assert!((20..180).all(|k| (velocity[k] - k as f64 * 1e-3).abs() < 1e-10));
    }
}
