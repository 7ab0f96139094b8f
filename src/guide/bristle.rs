//! Presliding: bristles that deflect before they slide.

use super::step::{Coast, StepForce};

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

/// The exponent of Olsson's law.
pub const GAUSSIAN: f64 = 2.0;
const MOST_ITERATIONS: usize = 60;
/// The level is at least this share of its greatest value.
const LEAST_LEVEL: f64 = 1e-9;
/// Share of the bracket at which the displacement is known: near rounding.
const PRECISION: f64 = 1e-14;

/// What the bristles stand against over one step.
#[derive(Debug, Clone, Copy)]
pub struct Sliding<L> {
    /// Level in N or N·m by direction (±1) and speed; not negative, greatest at rest, and not zero in both directions.
    pub level: L,
    /// Drag in N·s/m or N·m·s/rad that the positive direction has more, and the negative one less, than the linear dynamics.
    pub drag: f64,
}

/// The bristles' answer to one displacement.
struct Answer {
    /// All of the guide's force.
    force: StepForce,
    /// Its derivatives by the displacement, the level held.
    slopes: [f64; 2],
    /// The bristles' own force at the end, and its derivative by the displacement.
    end: f64,
    end_slope: f64,
}

impl Answer {
    /// Force and bristles' force of a displacement that is larger by so little that the answer is straight.
    fn at(self, step: f64) -> (StepForce, f64) {
        let [mean, rise] = self.slopes.map(|slope| slope * step);
        (self.force + StepForce { mean, rise }, self.end + self.end_slope * step)
    }
}

impl Bristle {
    /// The guide's force over one step of `step_s` and the bristles' force at its end, from the force `begun` at its beginning.
    ///
    /// The displacement solves `Δ = Δ_free + κ·F̄(Δ) + ρ·F̂(Δ)` with mean F̄ and rise F̂ of the force, both of which fall with
    /// Δ; κ > 0 outweighs ρ < 0, so there is one solution as long as the level changes little over one step, which safeguarded
    /// Newton steps find however stiff the bristles are.
    ///
    /// ```
    /// use slideway::guide::{Bristle, Coast, Sliding};
    /// let bristle = Bristle { stiffness: 1e6, damping: 0.0, fading_factor: 1.0, fading_exponent: 2.0 };
    /// // Sliding far: Coulomb friction.
    /// let coulomb = Sliding { level: |_, _| 10.0, drag: 0.0 };
    /// let (force, end) = bristle.step(-10.0, Coast::of_mass(100.0, 0.1, 1e-3), 1e-3, coulomb);
    /// assert!((force.mean + 10.0).abs() < 1e-9 && (end + 10.0).abs() < 1e-9);
    /// ```
    pub fn step(
        &self,
        begun: f64,
        coast: Coast,
        step_s: f64,
        sliding: Sliding<impl Fn(f64, f64) -> f64>,
    ) -> (StepForce, f64) {
        // The root lies between the displacements under the extreme forces.
        let most = (sliding.level)(1.0, 0.0).max((sliding.level)(-1.0, 0.0)).max(begun.abs());
        // One direction alone may slide freely; its bristles then have to be soft, not absent.
        let level = |direction, speed| (sliding.level)(direction, speed).max(LEAST_LEVEL * most);
        let sliding = Sliding { level, drag: sliding.drag };
        let response = coast.response;
        let damped = 2.0 * most * self.damping / (self.stiffness * step_s);
        let dragged = sliding.drag.abs() * 2.0 * coast.free_travel.abs() / step_s;
        let reach = response.compliance * (most + damped + dragged) - response.rise_travel * 2.0 * most;
        let (mut low, mut high) = (coast.free_travel - reach, coast.free_travel + reach);
        // Not `clamp`: a replay that has diverged to infinity must come out as such, not stop the program.
        let mut travel = coast.travel_under(StepForce::held(begun)).max(low).min(high);
        let precision = PRECISION * (high - low);
        // Length of the Newton step that led here; 0 where none did.
        let mut before = 0.0;
        for _ in 0..MOST_ITERATIONS {
            let answer = self.over(begun, travel, step_s, &sliding);
            let [mean_slope, rise_slope] = answer.slopes;
            let excess = travel - coast.travel_under(answer.force);
            if excess > 0.0 {
                high = travel;
            } else {
                low = travel;
            }
            let slope = 1.0 - response.compliance * mean_slope - response.rise_travel * rise_slope;
            let step = -excess / slope;
            let newton = travel + step;
            // On one side of the reversal, steps that shrink by a ratio leave no more than that share of the last one. Seen before the
            // bracket is: the last steps of all end on its edge.
            let is_smooth = travel * newton > 0.0;
            if step.abs() <= precision || (is_smooth && step * step <= precision * before) {
                return answer.at(step);
            }
            let is_inside = newton > low && newton < high;
            (travel, before) = if is_inside { (newton, step.abs()) } else { (0.5 * (low + high), 0.0) };
        }
        self.over(begun, travel, step_s, &sliding).at(0.0)
    }

    /// Force over a displacement gone through at an even pace.
    ///
    /// Of the exponential run of the force, `rise = 12·∫₀¹ (s − ½)·f ds`: the line with the same mean and first moment.
    fn over(
        &self,
        begun: f64,
        travel: f64,
        step_s: f64,
        sliding: &Sliding<impl Fn(f64, f64) -> f64>,
    ) -> Answer {
        let direction = if travel < 0.0 { -1.0 } else { 1.0 };
        let speed = travel.abs() / step_s;
        let level = (sliding.level)(direction, speed);
        let offset = begun + direction * level;
        let rate = self.stiffness / level;
        let a = rate * travel.abs();
        let gone = fallen(a);
        let ([share, moment], [share_slope, moment_slope]) = shape(a, gone);
        let left = 1.0 - gone;
        let end = if travel == 0.0 { begun } else { offset * left - direction * level };
        let damping = if self.damping == 0.0 {
            0.0
        } else {
            let ratio = speed * self.damping * self.fading_factor / level;
            let is_gaussian = self.fading_exponent == GAUSSIAN;
            let fading = if is_gaussian { ratio * ratio } else { ratio.powf(self.fading_exponent) };
            self.damping * (1.0 - fallen(fading)) / (self.stiffness * step_s)
        };
        let slope = rate * direction;
        Answer {
            force: StepForce {
                mean: -direction * level + offset * share + damping * (end - begun) - sliding.drag * speed,
                rise: 12.0 * offset * moment,
            },
            slopes: [
                offset * (share_slope - damping * left) * slope - sliding.drag * direction / step_s,
                12.0 * offset * moment_slope * slope,
            ],
            end,
            end_slope: -offset * left * slope,
        }
    }
}

/// 1 − e^(−a); from where on that is 1 to rounding, without the detour.
fn fallen(a: f64) -> f64 {
    const TO_ROUNDING: f64 = 40.0;
    if a > TO_ROUNDING { 1.0 } else { -(-a).exp_m1() }
}

/// Mean and first moment about the middle of e^(−a·s) for 0 ≤ s ≤ 1, and their derivatives by a; `fallen` is 1 − e^(−a).
fn shape(a: f64, fallen: f64) -> ([f64; 2], [f64; 2]) {
    // Below this, the closed forms take numbers near each other apart.
    const SERIES_BELOW: f64 = 1e-2;
    if a < SERIES_BELOW {
        let mean = 1.0 - a * (0.5 - a * (1.0 / 6.0 - a / 24.0));
        let mean_slope = -0.5 + a * (1.0 / 3.0 - a / 8.0);
        let moment = -a / 12.0 * (1.0 - a * (0.5 - a * 0.15));
        let moment_slope = -1.0 / 12.0 + a * (1.0 / 12.0 - a * 0.0375);
        return ([mean, moment], [mean_slope, moment_slope]);
    }
    let decay = 1.0 - fallen;
    let mean = fallen / a;
    let mean_slope = (decay * a - fallen) / (a * a);
    let first = (fallen - a * decay) / (a * a); // ∫ s·e^(−a·s) ds
    let second = (2.0 * fallen - 2.0 * a * decay - a * a * decay) / (a * a * a); // ∫ s²·e^(−a·s) ds
    ([mean, first - 0.5 * mean], [mean_slope, 0.5 * first - second])
}

#[cfg(test)]
mod tests {
    use super::*;

    const DAHL: Bristle =
        Bristle { stiffness: 2e6, damping: 0.0, fading_factor: 1.0, fading_exponent: GAUSSIAN };

    fn coulomb(level: f64) -> Sliding<impl Fn(f64, f64) -> f64> {
        Sliding { level: move |_, _| level, drag: 0.0 }
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

    /// Mean, moment and derivatives against sums, on both sides of the series' end.
    #[test]
    fn exact_shape_of_a_decay() {
        for a in [1e-5, 0.009_99, 0.010_01, 0.3, 4.0] {
            let steps = 40_000;
            let at = |k: i32| (f64::from(k) + 0.5) / f64::from(steps);
            let integral =
                |f: &dyn Fn(f64) -> f64| (0..steps).map(|k| f(at(k))).sum::<f64>() / f64::from(steps);
            let ([mean, moment], slopes) = shape(a, fallen(a));
            assert!((mean - integral(&|s| (-a * s).exp())).abs() < 1e-8);
            assert!((moment - integral(&|s| (s - 0.5) * (-a * s).exp())).abs() < 1e-8);
            assert!((slopes[0] + integral(&|s| s * (-a * s).exp())).abs() < 1e-6);
            assert!((slopes[1] + integral(&|s| s * (s - 0.5) * (-a * s).exp())).abs() < 1e-6);
        }
    }

    /// A fit may try values with which the replay diverges: the program goes on.
    #[test]
    fn exact_a_diverged_axis_is_no_panic() {
        for velocity in [f64::INFINITY, f64::NAN] {
            let _ = DAHL.step(3.0, Coast::of_mass(100.0, velocity, 1e-3), 1e-3, coulomb(8.0));
        }
    }

    /// The force is that of the displacement which it leaves, whatever the level depends on and wherever the step goes.
    #[test]
    fn exact_force_and_displacement_belong_together() {
        let step = 250e-6;
        let levels: [fn(f64, f64) -> f64; 2] =
            [|_, _| 8.0, |direction, speed| 8.0 + direction + 4.0 * (-(speed / 0.004).powi(2)).exp()];
        for (stiffness, damping, level) in [1e5, 1e7, 1e9]
            .into_iter()
            .flat_map(|k| [0.0, 1e4].map(|d| (k, d)))
            .flat_map(|(k, d)| levels.map(|l| (k, d, l)))
        {
            let bristle = Bristle { stiffness, damping, fading_factor: 1.0, fading_exponent: GAUSSIAN };
            for velocity in [0.0, 1e-7, -1e-5, 1e-3, -0.003, 0.1] {
                for begun in [-9.0, -2.0, 0.0, 5.0, 7.0] {
                    let sliding = Sliding { level, drag: 20.0 };
                    let coast = Coast::of_mass(50.0, velocity, step);
                    let (force, end) = bristle.step(begun, coast, step, sliding);
                    let answer = bristle.over(begun, coast.travel_under(force), step, &sliding);
                    let off = (force.mean - answer.force.mean).abs() + (end - answer.end).abs();
                    assert!(off < 1e-7, "{stiffness} {damping} {velocity} {begun}: {off}");
                }
            }
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
        let level =
            |direction: f64, speed: f64| 10.0 + 2.0 * direction + 6.0 * (-(speed / 0.004).powi(2)).exp();
        for velocity in [0.002, -0.002, 0.1, -0.1_f64] {
            let coast = Coast::of_mass(1e30, velocity, 1e-3);
            let (mut force, mut all) = (0.0, StepForce::ZERO);
            for _ in 0..1000 {
                (all, force) = bristle.step(force, coast, 1e-3, Sliding { level, drag: 30.0 });
            }
            let direction = velocity.signum();
            let expected = -direction * level(direction, velocity.abs()) - 30.0 * velocity.abs();
            assert!((all.mean - expected).abs() < 1e-9, "{velocity}: {} against {expected}", all.mean);
        }
    }
}
