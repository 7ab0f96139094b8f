//! The friction of forged machines: bristles whose force depends on speed, direction and load.

use crate::guide::Coast;
use serde::{Deserialize, Serialize};

/// Friction that forged machines have on their guide, as the level that the bristles slide at.
///
/// # Model
/// LuGre, without its viscous term (drag is the guide's own):
/// ```text
///   ż = v − σ₀·|v|/g(v)·z        F = −(σ₀·z + σ₁·exp(−(|v|/v_d)^p)·ż)
/// ```
/// with `g` the sliding level in the direction of v, `σ₀ = g₀/δ` the stiffness that makes the bristles slide after a
/// deflection δ, and σ₁ a damping ratio times `2·√(σ₀·m)`, which fades above `v_d = s·g/σ₁`: a constant σ₁ would brake
/// many times harder than the level just after a reversal. Over a step, v is the mean of the velocities at its ends, for which the
/// deflection has a closed form: with `a = h·σ₀·|v|/g` and `z∞ = ±g/σ₀` it is `z₁ = z∞ + (z₀ − z∞)·e^(−a)` at the end and
/// `z∞ + (z₀ − z∞)·(1 − e^(−a))/a` on average. The force is that of the average: the error falls with the square of the step. The velocity at the
/// end solves the step's balance, which rises with it by at least one for two as long as σ₁ is below 0.6 of the mass over the step (p ≤ 3), so that a
/// bracket is known and the root is unique.
///
/// # Validity
/// A law of another kind than the diagnosing twin's: set-valued signum there, a deflecting bristle here.
///
/// # Source
/// Canudas de Wit, Olsson, Åström, Lischinsky (1995), *A new model for control of systems with friction*; damping that
/// fades with speed: Olsson (1996), *Control systems with friction*.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForgedBristle {
    /// σ₀ in N/m or N·m/rad.
    pub stiffness: f64,
    /// σ₁ in N·s/m or N·m·s/rad.
    pub damping: f64,
    /// How the damping fades.
    pub fading: Fading,
}

/// How the damping of bristles fades with speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Fading {
    /// s: it fades at the velocity where it would make this share of the sliding level.
    pub share: f64,
    /// p: how steeply.
    pub power: f64,
}

impl Fading {
    /// As a Gaussian, where it would make half of the sliding level.
    pub const HALF: Self = Self { share: 0.5, power: 2.0 };
}

impl Default for Fading {
    fn default() -> Self {
        Self::HALF
    }
}

/// Below this decay over a step the deflection changes evenly to nine digits, and its average in closed form would be a difference of
/// rounding errors.
const SMALL: f64 = 1e-4;
const MOST_ITERATIONS: usize = 60;
/// The velocity is known to this share of what the sliding level changes it by in a step.
const PRECISION: f64 = 1e-10;
/// Beyond this ratio to the velocity at which it fades less than e^(−40) of the damping is left (p ≥ 1): nothing beside the sliding level.
const GONE: f64 = 40.0;

impl ForgedBristle {
    /// Mean friction force over a step of `step_s` and the deflection at its end, from the deflection `begun`; `level`
    /// is the sliding level at a velocity.
    ///
    /// ```
    /// use slideway::guide::Coast;
    /// use slideway::trial::bristle::{Fading, ForgedBristle};
    /// let bristle = ForgedBristle { stiffness: 1e8, damping: 0.0, fading: Fading::default() };
    /// // Sliding steadily, the force is the level, against the motion.
    /// let (mut force, mut deflection) = (0.0, 0.0);
    /// let coast = Coast::of_mass(1e5, 0.1, 1e-4);
    /// for _ in 0..100 {
    ///     (force, deflection) = bristle.step(deflection, coast, 1e-4, |_| 12.0);
    /// }
    /// assert!((force + 12.0).abs() < 1e-6 && (deflection - 12.0 / 1e8).abs() < 1e-12);
    /// ```
    pub fn step(&self, begun: f64, coast: Coast, step_s: f64, level: impl Fn(f64) -> f64) -> (f64, f64) {
        let answer = |end: f64| {
            let velocity = 0.5 * (coast.velocity + end);
            let sliding = level(velocity).max(f64::MIN_POSITIVE);
            let decay = step_s * self.stiffness * velocity.abs() / sliding;
            // z₁ = z₀ + h·v·(1 − e^(−a))/a − z₀·(1 − e^(−a)), which holds at rest too.
            let gone = -(-decay).exp_m1();
            let share = if decay > 0.0 { gone / decay } else { 1.0 };
            let after = begun * (1.0 - gone) + step_s * velocity * share;
            let end = velocity.signum() * sliding / self.stiffness;
            let mean = if decay > SMALL { end + (begun - end) * share } else { 0.5 * (begun + after) };
            let faded = self.fading.left(velocity.abs() * self.damping / sliding);
            let force = -(self.stiffness * mean + self.damping * faded * (after - begun) / step_s);
            Answer { force, after }
        };
        let mobility = coast.response.mobility;
        let excess = |end: f64| {
            let answer = answer(end);
            (end - coast.free_velocity - mobility * answer.force, answer)
        };
        // Most steps end with nearly the force that the last one ended with.
        let start = coast.free_velocity - mobility * self.stiffness * begun;
        let precision = PRECISION * mobility * level(coast.velocity);
        let Answer { force, after } = root(excess, start, precision);
        (force, after)
    }
}

/// What bristles do over a step that ends at some velocity.
#[derive(Debug, Clone, Copy)]
struct Answer {
    /// Mean force.
    force: f64,
    /// Deflection at the end.
    after: f64,
}

impl Fading {
    /// What is left of the damping where it would make this share of the sliding level.
    fn left(self, share: f64) -> f64 {
        let ratio = share / self.share;
        if ratio > GONE { 0.0 } else { (-ratio.powf(self.power)).exp() }
    }
}

/// What a function whose slope is at least a half gives beside its value at its root near `start`, which is known to `precision`: Illinois' method
/// in the bracket that the slope gives.
fn root<T>(function: impl Fn(f64) -> (f64, T), start: f64, precision: f64) -> T {
    let (at_start, given) = function(start);
    if at_start.abs() <= precision || !at_start.is_finite() {
        return given;
    }
    let (mut a, mut at_a) = (start, at_start);
    let mut b = start - 2.0 * at_start;
    let (mut at_b, mut given) = function(b);
    for _ in 0..MOST_ITERATIONS {
        if at_b.abs() <= precision || (b - a).abs() <= precision {
            break;
        }
        let next = b - at_b * (b - a) / (at_b - at_a);
        let next = if next.is_finite() { next } else { 0.5 * (a + b) };
        let (at_next, given_next) = function(next);
        if at_next * at_b < 0.0 {
            (a, at_a) = (b, at_b);
        } else {
            at_a *= 0.5;
        }
        (b, at_b, given) = (next, at_next, given_next);
    }
    given
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guide::StepForce;

    /// A push below the level deflects the bristles by the push over their stiffness, and the block stays.
    #[test]
    fn exact_small_push_is_held_elastically() {
        let (mass, step, push) = (50.0_f64, 31.25e-6, 6.0);
        let stiffness = 1e8;
        let bristle = ForgedBristle {
            stiffness,
            damping: 2.0 * 0.7 * (stiffness * mass).sqrt(),
            fading: Fading::default(),
        };
        let (mut velocity, mut deflection, mut position) = (0.0, 0.0, 0.0);
        for _ in 0..40_000 {
            let coast = Coast::of_mass(mass, velocity, step).under(StepForce::held(push));
            let (force, after) = bristle.step(deflection, coast, step, |_| 10.0);
            let end = coast.free_velocity + coast.response.mobility * force;
            position += 0.5 * step * (velocity + end);
            (velocity, deflection) = (end, after);
        }
        assert!((deflection - push / stiffness).abs() < 1e-12, "{deflection}");
        assert!(velocity.abs() < 1e-9 && position < 10.0 * push / stiffness, "{velocity} {position}");
    }

    /// A block thrown at 1 m/s against 2 N per kg stops after 0.25 m, as with Coulomb friction.
    #[test]
    fn exact_sliding_block_stops_where_energy_says() {
        let (step, level) = (1e-4, 2.0);
        let bristle = ForgedBristle {
            stiffness: level / 1e-6,
            damping: 2.0 * 0.7 * (level / 1e-6_f64).sqrt(),
            fading: Fading::default(),
        };
        let (mut velocity, mut deflection, mut position) = (1.0, 1e-6, 0.0);
        for _ in 0..10_000 {
            let coast = Coast::of_mass(1.0, velocity, step);
            let (force, after) = bristle.step(deflection, coast, step, |_| level);
            let end = velocity + step * force;
            position += 0.5 * step * (velocity + end);
            (velocity, deflection) = (end, after);
        }
        // The bristles' deflection of 1 µm is what is left open.
        assert!((position - 0.25).abs() < 1e-5 && velocity.abs() < 1e-3, "{position} {velocity}");
    }
}
