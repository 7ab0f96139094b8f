//! What drives a replay in windows: the measured signal, sample by sample.

use super::{Input, Windowed};
use crate::drive::motor::{Circuit, CircuitStep};
use crate::effect::{Constants, Door, Effect};
use crate::machine::Machine;
use crate::recording::Signal;
use crate::replay::Traces;
use crate::sensor::LogScale;
use crate::twin::{Command, Sensing};
use rand::SeedableRng;
use rand::rngs::StdRng;
use rand_distr::{Distribution, StandardNormal};

/// What drives the twin, sample by sample.
pub(super) struct Drive {
    /// The input; for a current its force or torque.
    samples: Vec<f64>,
    /// Force or torque per ampere at each sample; empty for a voltage.
    per_ampere: Vec<f64>,
    /// Recorded supply voltage in V; empty where it was not.
    supply_v: Vec<f64>,
    /// Samples at which the drive is not enabled.
    disabled: Vec<bool>,
    /// Noise of the current sensor at each sample in A; empty where sensors are perfect.
    noise_a: Vec<f64>,
    /// Weights of a sample and the next one in the mean between them.
    weights: [f64; 2],
    /// Weight of their difference in the rise between them.
    rise_weight: f64,
    /// What comes beside an effort at each sample, in V; empty for nothing.
    feedforward_v: Vec<f64>,
    /// Scale of the logged current and effort.
    scale: LogScale,
}

/// Weights of the first and the last value in the mean over a period in which the voltage does not change, and of their
/// difference in the rise.
///
/// # Model
/// `i₁ = u∞ + (i₀ − u∞)·d`, mean `u∞ + (i₀ − u∞)·m`, first moment about the middle `(i₀ − u∞)·n`, with decay d, mean m and
/// moment n of a unit current over the period; a rise D has the first moment D/12.
fn period_weights(constants: &Constants) -> ([f64; 2], f64) {
    let step = CircuitStep::new(&constants.circuit, constants.sample_period_s);
    if !step.has_current() {
        return ([1.0, 0.0], 0.0);
    }
    let mut decay = 1.0;
    let over = step.over(&mut decay, 0.0, 0.0);
    let last = (1.0 - over.mean) / (1.0 - decay);
    ([1.0 - last, last], -12.0 * over.moment / (1.0 - decay))
}

impl Drive {
    pub fn of(windowed: &Windowed, machine: &Machine, sensing: Sensing) -> Self {
        let run = &windowed.run;
        let mut samples = run.signal(windowed.input.signal()).unwrap_or_default().to_vec();
        let constants = machine.constants();
        let (Circuit::Winding { force_constant: constant, .. }
        | Circuit::Direct { force_per_volt: constant }) = constants.circuit;
        let noise_a = current_noise(machine, sensing, samples.len());
        let supply_v = run.signal(Signal::SupplyVoltage).unwrap_or_default().to_vec();
        let disabled = windowed.disabled();
        let scale = constants.log_scale;
        if windowed.input == Input::Effort {
            samples.iter_mut().for_each(|effort_v| *effort_v /= scale.effort);
            return Self {
                samples,
                per_ampere: Vec::new(),
                supply_v,
                disabled,
                noise_a: Vec::new(),
                weights: [1.0, 0.0],
                rise_weight: 0.0,
                feedforward_v: windowed.feedforward_v.clone(),
                scale,
            };
        }
        let effects = machine.effects();
        let ripples: Vec<&Effect> = effects.iter().filter(|e| e.acts_through(Door::Ripple)).collect();
        let position = run.signal(Signal::Position).unwrap_or_default();
        let ripple = |x: &f64| 1.0 + ripples.iter().map(|effect| effect.ripple(*x)).sum::<f64>();
        let per_ampere: Vec<f64> = position.iter().map(|x| constant * ripple(x)).collect();
        if windowed.input == Input::Current {
            for (k, (sample, force)) in samples.iter_mut().zip(&per_ampere).enumerate() {
                *sample = force * (*sample + noise_a.get(k).unwrap_or(&0.0)) / scale.current;
            }
        }
        let (weights, rise_weight) = period_weights(&constants);
        let feedforward_v = Vec::new();
        Self { samples, per_ampere, supply_v, disabled, noise_a, weights, rise_weight, feedforward_v, scale }
    }

    pub fn command(&self, k: usize, input: Input) -> Command {
        let now = self.samples[k];
        let next = self.samples.get(k + 1).copied().unwrap_or(now);
        let mean = self.weights[0] * now + self.weights[1] * next;
        let (effort_v, thrust) = match input {
            Input::Effort => (now, None),
            Input::Current | Input::Thrust => (0.0, Some(mean)),
        };
        let thrust_rise = self.rise_weight * (next - now);
        Command {
            effort_v: Some(effort_v),
            feedforward_v: self.feedforward_v.get(k).copied().unwrap_or(0.0),
            supply_v: self.supply_v.get(k).copied(),
            // A measured current or force is what it is, enabled or not.
            is_enabled: input != Input::Effort || !self.disabled.get(k).copied().unwrap_or(false),
            thrust,
            thrust_rise,
            ..Command::follow(0.0, 0.0)
        }
    }

    /// Force and current at the samples themselves, where the twin's own winding did not make them.
    pub fn complete(&self, traces: &mut Traces, input: Input) {
        if input == Input::Effort {
            return;
        }
        traces.thrust.clone_from(&self.samples);
        for (k, current) in traces.current.iter_mut().enumerate() {
            let noise_a = self.noise_a.get(k).unwrap_or(&0.0);
            *current = self.scale.current * self.samples[k] / self.per_ampere[k] + noise_a;
        }
    }
}

/// Noise of the current sensor, drawn apart from the other sensors'.
fn current_noise(machine: &Machine, sensing: Sensing, samples: usize) -> Vec<f64> {
    let (sigma, Sensing::AsStated { seed }) = (machine.description().current_sensor.noise_a, sensing) else {
        return Vec::new();
    };
    let mut random = StdRng::seed_from_u64(!seed);
    (0..samples)
        .map(|_| {
            let noise: f64 = StandardNormal.sample(&mut random);
            sigma * noise
        })
        .collect()
}
