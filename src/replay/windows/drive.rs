//! What drives a replay in windows: the measured signal, sample by sample.

use super::{Input, Windowed};
use crate::drive::motor::{Circuit, CircuitStep};
use crate::effect::{Constants, Door, Effect, motor_factor};
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
        let acts = |effect: &Effect| effect.acts_through(Door::MotorForce);
        let changes: Vec<Effect> = effects.into_iter().filter(acts).collect();
        let position = run.signal(Signal::Position).unwrap_or_default();
        let factor = |position: f64, proportional: f64| motor_factor(&changes, position, proportional);
        let is_current = windowed.input == Input::Current;
        let mut per_ampere = Vec::with_capacity(samples.len());
        for (k, (sample, x)) in samples.iter_mut().zip(position).enumerate() {
            if is_current {
                let proportional = constant * (*sample + noise_a.get(k).unwrap_or(&0.0)) / scale.current;
                per_ampere.push(constant * factor(*x, proportional));
                *sample = proportional * factor(*x, proportional);
            } else {
                per_ampere.push(constant * factor(*x, proportional_to(*sample, |force| factor(*x, force))));
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

/// The force in proportion to the current, F₀, of which `factor` leaves `force`: `F = F₀·factor(F₀)`.
///
/// Two rounds of Aitken's extrapolation of `F₀ = F/factor(F₀)`, which is linear in F₀ for a motor that saturates: exact there, and
/// where the factor does not depend on F₀. No current gives a force beyond the largest one of the motor; F₀ is then large.
fn proportional_to(force: f64, factor: impl Fn(f64) -> f64) -> f64 {
    let next = |proportional: f64| force / factor(proportional);
    (0..2).fold(force, |from, _| {
        let (first, second) = (next(from), next(next(from)));
        let slope = if first == from { 0.0 } else { (second - first) / (first - from) };
        from + (first - from) / (1.0 - slope.clamp(-STEEPEST, STEEPEST))
    })
}

/// Steepest slope of `F/factor(F₀)` that is extrapolated: at a slope of 1 no current gives the force.
const STEEPEST: f64 = 0.99;

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

#[cfg(test)]
mod tests {
    use super::*;

    /// The inverse of a saturation of 0.01 per newton, of a constant factor, and of both together.
    #[test]
    fn exact_the_force_before_its_losses_is_found() {
        let saturated = |f: f64| 1.0 / (1.0 + 0.01 * f.abs());
        for proportional in [-150.0, -1.0, 0.0, 30.0, 100.0] {
            let found = proportional_to(proportional * saturated(proportional), saturated);
            assert!((found - proportional).abs() < 1e-9, "{found} for {proportional}");
            assert!((proportional_to(0.9 * proportional, |_| 0.9) - proportional).abs() < 1e-9);
            let both = |f: f64| saturated(f) + 0.02;
            let found = proportional_to(proportional * both(proportional), both);
            assert!((found - proportional).abs() <= 1e-3 * proportional.abs(), "{found} for {proportional}");
        }
    }
}
