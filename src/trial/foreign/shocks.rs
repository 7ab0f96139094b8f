//! Shocks from a neighbour.

use super::{digits, times};
use crate::effect::Prior;
use crate::guide::StepForce;
use rand::RngExt;
use rand::rngs::StdRng;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Shocks from a neighbouring press or lift, at random times of the session.
///
/// # Model
/// Each is a half sine on the moving part, in N or N·m:
/// ```text
///   F(t) = F̂·sin(π·(t − t₀)/ℓ)        t₀ ≤ t ≤ t₀ + ℓ        ∫F dt = 2·F̂·ℓ/π
/// ```
/// The reaction goes to the base, as that of every force of the guide. Over a step, mean and first moment are integrated in closed
/// form: a free mass ends where it should, whatever the step.
///
/// # Ranges
/// Largest amplitude 0.7–10 % of the rated force, each shock 70–100 % of it in either direction; length 2–20 ms, the same
/// for all; 0.5–3 shocks per s. Amplitudes and lengths are even on a logarithmic scale, times and rate on a plain one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shocks {
    /// Length ℓ of each in s.
    pub length_s: f64,
    /// The shocks, in the order of their begin.
    pub pulses: Vec<Pulse>,
}

/// One shock.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pulse {
    /// Time t₀ of the session in s at which it begins.
    pub begins_s: f64,
    /// Amplitude F̂ with its sign in N or N·m.
    pub force: f64,
}

/// Least share of the largest amplitude that a shock has.
const LEAST_SHARE: f64 = 0.7;
/// The largest amplitude as a share of the rated force.
const SHARES: (f64, f64) = (0.005 / LEAST_SHARE, 0.10);
const LENGTHS_S: (f64, f64) = (2e-3, 20e-3);
const RATES_PER_S: (f64, f64) = (0.5, 3.0);

impl Shocks {
    /// Draws the shocks of a session of `session_s`; at least one. `rated_force` in N or N·m.
    pub fn draw(rated_force: f64, session_s: f64, random: &mut StdRng) -> Self {
        let largest = rated_force * Prior::new(random).log_uniform(SHARES.0, SHARES.1);
        let length_s = digits(Prior::new(random).log_uniform(LENGTHS_S.0, LENGTHS_S.1));
        let rate_per_s: f64 = random.random_range(RATES_PER_S.0..RATES_PER_S.1);
        let begins = times(((rate_per_s * session_s) as usize).max(1), session_s, random);
        let pulse = |begins_s| {
            let force = digits(Prior::new(random).sign() * largest * random.random_range(LEAST_SHARE..1.0));
            Pulse { begins_s, force }
        };
        Self { length_s, pulses: begins.into_iter().map(pulse).collect() }
    }

    /// Force over a step of `step_s` from a time of the session on, in s: mean and first moment exact.
    pub fn push(&self, clock_s: f64, step_s: f64) -> StepForce {
        let first = self.pulses.partition_point(|pulse| pulse.begins_s + self.length_s <= clock_s);
        let reached = self.pulses[first..].iter().take_while(|pulse| pulse.begins_s < clock_s + step_s);
        reached.fold(StepForce::ZERO, |sum, pulse| sum + self.over(*pulse, clock_s, step_s))
    }

    /// One shock over a step.
    fn over(&self, pulse: Pulse, clock_s: f64, step_s: f64) -> StepForce {
        let begin = self.integrals(clock_s - pulse.begins_s);
        let end = self.integrals(clock_s + step_s - pulse.begins_s);
        let mean = (end[0] - begin[0]) / step_s;
        // ∫F·(t − h/2) dt by parts.
        let moment = 0.5 * step_s * (begin[0] + end[0]) - (end[1] - begin[1]);
        StepForce { mean: pulse.force * mean, rise: pulse.force * 12.0 * moment / (step_s * step_s) }
    }

    /// The first and the second integral of a shock of amplitude 1 from its begin until so long after, in s and s².
    fn integrals(&self, after_s: f64) -> [f64; 2] {
        let inside = after_s.clamp(0.0, self.length_s);
        let scale = self.length_s / PI;
        let angle = inside / scale;
        let past = (after_s - self.length_s).max(0.0);
        [scale * (1.0 - angle.cos()), scale * (inside - scale * angle.sin()) + 2.0 * scale * past]
    }

    /// Impulse of all shocks in N·s or N·m·s.
    ///
    /// ```
    /// use slideway::trial::foreign::{Pulse, Shocks};
    /// let shocks = Shocks { length_s: 0.01, pulses: vec![Pulse { begins_s: 1.0, force: 50.0 }] };
    /// assert!((shocks.impulse() - 1.0 / std::f64::consts::PI).abs() < 1e-15);
    /// ```
    pub fn impulse(&self) -> f64 {
        self.pulses.iter().map(|pulse| pulse.force).sum::<f64>() * 4.0 * self.length_s / TAU
    }
}
