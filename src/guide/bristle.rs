//! Presliding: bristles that deflect before they slide.

use super::level::Level;
use super::step::{Coast, StepForce};
use super::step_equation::StepEquation;

/// The bristles of dry friction.
///
/// # Model
/// LuGre, by its force f = −σ₀·z and over the way instead of time, with the level g(s, |v|) at which the guide slides in the
/// direction s at this speed:
/// ```text
///   df/dx = −σ₀·(1 + sgn(v)·f/g)        F = f + (σ₁(v)/σ₀)·df/dt
///   σ₁(v) = σ₁·exp(−(v/v_d)^p)         v_d = e^(−λ)·g/σ₁
/// ```
/// so that f runs from any value towards −g·sgn(v) within a displacement of about g/σ₀. Over a displacement Δ at a steady
/// level, exactly: `f₁ = −s·g + (f₀ + s·g)·exp(−σ₀|Δ|/g)` with s = sgn Δ; g is taken at the step's mean speed. The damping
/// fades where it would come near the level: a constant σ₁ would brake many times harder than the level just after a reversal.
/// At λ = 0 it fades where it would reach the level; with p = 2 as a Gaussian.
///
/// # Validity
/// The bristles have no rate of their own but σ₁; hysteresis loops close. σ₀ → ∞ is the set-valued law.
///
/// # Source
/// Canudas de Wit, Olsson, Åström, Lischinsky (1995), *A new model for control of systems with friction*; damping that fades
/// with speed: Olsson (1996), *Control systems with friction*; with g constant and σ₁ = 0: Dahl (1968), *A solid friction
/// model*, exponent 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bristle {
    /// σ₀ in N/m or N·m/rad; more than zero.
    pub stiffness: f64,
    /// σ₁ in N·s/m or N·m·s/rad; not negative.
    pub damping: f64,
    /// e^λ: velocity at which the damping would reach the level, over that at which it fades; more than zero.
    pub fading_factor: f64,
    /// p: how steeply the damping fades; more than zero.
    pub fading_exponent: f64,
}

/// What the bristles stand against over one step.
#[derive(Debug, Clone, Copy)]
pub struct Sliding {
    /// Not negative, greatest at rest, and not zero in both directions.
    pub level: Level,
    /// Drag in N·s/m or N·m·s/rad that the positive direction has more, and the negative one less, than the linear dynamics.
    pub drag: f64,
}

impl Bristle {
    /// The guide's force over one step of `step_s` and the bristles' force at its end, from the force `begun` at its beginning.
    ///
    /// ```
    /// use slideway::guide::{Bristle, Coast, Level, Sliding};
    /// let bristle = Bristle { stiffness: 1e6, damping: 0.0, fading_factor: 1.0, fading_exponent: 2.0 };
    /// // Sliding far: Coulomb friction.
    /// let coulomb = Sliding { level: Level::constant(10.0), drag: 0.0 };
    /// let (force, end) = bristle.step(-10.0, Coast::of_mass(100.0, 0.1, 1e-3), 1e-3, coulomb);
    /// assert!((force.mean + 10.0).abs() < 1e-9 && (end + 10.0).abs() < 1e-9);
    /// ```
    pub fn step(&self, begun: f64, coast: Coast, step_s: f64, sliding: Sliding) -> (StepForce, f64) {
        self.step_equation(begun, coast, step_s, sliding).solve()
    }

    /// The equation for the displacement of that step.
    #[inline]
    pub fn step_equation(&self, begun: f64, coast: Coast, step_s: f64, sliding: Sliding) -> StepEquation {
        let Sliding { level, drag } = sliding;
        let Self { stiffness, damping, fading_factor, fading_exponent } = *self;
        StepEquation {
            begun,
            free_travel: coast.free_travel,
            compliance: coast.response.compliance,
            rise_travel: coast.response.rise_travel,
            stiffness,
            damping,
            fading_factor,
            fading_exponent,
            level,
            floor: 0.0,
            drag,
            step_s,
        }
        .with_floor()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guide::GAUSSIAN;

    const DAHL: Bristle =
        Bristle { stiffness: 2e6, damping: 0.0, fading_factor: 1.0, fading_exponent: GAUSSIAN };

    fn coulomb(level: f64) -> Sliding {
        Sliding { level: Level::constant(level), drag: 0.0 }
    }

    /// Small steps of the closed form against one step, the displacement given (no mobility).
    #[test]
    fn exact_deflection_follows_the_closed_form() {
        let (step, velocity) = (1e-3, 2e-3);
        // Heavy enough for the displacement to be given.
        let coast = Coast::of_mass(1e30, velocity, step);
        let (_, end) = DAHL.step(3.0, coast, step, coulomb(8.0));
        let expected = -8.0 + 11.0 * (-2e6 * velocity * step / 8.0_f64).exp();
        assert!((end - expected).abs() < 1e-9, "{end} against {expected}");
    }

    /// A fit may try values with which the replay diverges: the program goes on.
    #[test]
    fn exact_a_diverged_axis_is_no_panic() {
        for velocity in [f64::INFINITY, f64::NAN] {
            let _ = DAHL.step(3.0, Coast::of_mass(100.0, velocity, 1e-3), 1e-3, coulomb(8.0));
        }
    }

    /// A push below the friction force deflects the bristles by an amount that holds it: the axis stops.
    #[test]
    fn exact_a_small_push_is_held() {
        let bristle = Bristle { stiffness: 1e6, damping: 0.0, fading_factor: 1.0, fading_exponent: 2.0 };
        let (mass, step, drag) = (50.0, 250e-6, 4e3);
        let (mut velocity, mut force, mut position) = (0.0_f64, 0.0, 0.0);
        for _ in 0..40_000 {
            let push = StepForce::held(6.0 - drag * velocity);
            let coast = Coast::of_mass(mass, velocity, step).under(push);
            let (answer, end) = bristle.step(force, coast, step, coulomb(10.0));
            position += coast.travel_under(answer);
            (velocity, force) = (coast.velocity_under(answer), end);
        }
        // From rest, −f = F_c·(1 − e^(−σx/F_c)) = 6 N.
        let expected = -10.0 / 1e6 * (1.0 - 0.6_f64).ln();
        assert!(velocity.abs() < 1e-9 && (force + 6.0).abs() < 1e-4, "{velocity} {force}");
        // Ringing on its way takes the loop a little beyond: it creeps no further than the first peak.
        assert!(position > 0.9 * expected && position < 2.5 * expected, "{position} against {expected}");
    }

    /// A body on bristles that never slide is a damped oscillator: ζ = σ₁/(2·√(σ₀·m)).
    #[test]
    fn exact_small_motion_rings_with_the_damping_of_the_bristles() {
        let (mass, stiffness, ratio) = (50.0, 2e6_f64, 0.05);
        let bristle = Bristle {
            stiffness,
            damping: 2.0 * ratio * (stiffness * mass).sqrt(),
            fading_factor: 1.0,
            fading_exponent: GAUSSIAN,
        };
        let omega = (stiffness / mass).sqrt();
        let damped = omega * (1.0 - ratio * ratio).sqrt();
        let error = |steps: u32| {
            let end = 1.75 * std::f64::consts::TAU / damped;
            let step = end / f64::from(steps);
            // 1e-6 of the level: linear to that.
            let (mut velocity, mut force, mut position) = (1e-6_f64, 0.0, 0.0);
            for _ in 0..steps {
                let coast = Coast::of_mass(mass, velocity, step);
                let (answer, after) = bristle.step(force, coast, step, coulomb(1e3));
                position += coast.travel_under(answer);
                (velocity, force) = (coast.velocity_under(answer), after);
            }
            let exact = 1e-6 / damped * (-ratio * omega * end).exp() * (damped * end).sin();
            (position - exact).abs() / exact.abs()
        };
        let [coarse, fine] = [error(400), error(800)];
        assert!(fine < 1e-3 && coarse / fine > 3.0, "{coarse} {fine}");
    }

    /// The damping's part of the force at a given speed: σ₁(v)/σ₀·df/dt, with σ₁(v) = σ₁·exp(−(v·σ₁·e^λ/g)^p).
    #[test]
    fn exact_damping_fades_where_it_is_stated() {
        let (stiffness, sigma, level, step, velocity) = (2e6, 600.0, 8.0, 1e-3, 4e-3_f64);
        let coast = Coast::of_mass(1e30, velocity, step);
        let answer = |damping: f64, fading_factor: f64, fading_exponent: f64| {
            Bristle { stiffness, damping, fading_factor, fading_exponent }.step(
                0.0,
                coast,
                step,
                coulomb(level),
            )
        };
        for (lambda, exponent) in [(-1.2, 2.0), (0.0, 2.0), (0.7_f64, 2.0), (0.7, 1.0), (-1.2, 3.0)] {
            let (elastic, end) = answer(0.0, lambda.exp(), exponent);
            let damped = answer(sigma, lambda.exp(), exponent).0.mean - elastic.mean;
            let fade = (-(velocity * sigma * lambda.exp() / level).powf(exponent)).exp();
            let expected = sigma * fade / stiffness * end / step;
            assert!(
                (damped / expected - 1.0).abs() < 1e-9,
                "{lambda}, {exponent}: {damped} against {expected}"
            );
        }
    }

    /// At a steady speed the force is the level at that speed and direction, with the direction's drag.
    #[test]
    fn exact_steady_sliding_is_the_level() {
        let bristle =
            Bristle { stiffness: 1e6, damping: 500.0, fading_factor: 1.0, fading_exponent: GAUSSIAN };
        let level = Level { base: [12.0, 8.0], peak: [6.0; 2], velocity: 0.004, ..Level::constant(0.0) };
        for velocity in [0.002, -0.002, 0.1, -0.1_f64] {
            let coast = Coast::of_mass(1e30, velocity, 1e-3);
            let (mut force, mut all) = (0.0, StepForce::ZERO);
            for _ in 0..1000 {
                (all, force) = bristle.step(force, coast, 1e-3, Sliding { level, drag: 30.0 });
            }
            let direction = velocity.signum();
            let expected = -direction * level.at(direction, velocity.abs()) - 30.0 * velocity.abs();
            assert!((all.mean - expected).abs() < 1e-9, "{velocity}: {} against {expected}", all.mean);
        }
    }
}
