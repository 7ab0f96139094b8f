//! The displacement over one step of a guide on bristles, for one axis or for several at once.

use super::level::Level;
use super::step::StepForce;
use crate::elementary::{decay, power};
use pulp::{Arch, Simd, WithSimd};
use std::array::from_fn;

/// The exponent of Olsson's law.
pub const GAUSSIAN: f64 = 2.0;
const MOST_ITERATIONS: usize = 60;
/// The level is at least this share of its greatest value.
const LEAST_LEVEL: f64 = 1e-9;
/// Share of the bracket at which the displacement is known: near rounding.
const PRECISION: f64 = 1e-14;

/// The equation for the displacement of one step: what bristles and plant agree on.
///
/// # Model
/// `Δ = Δ_free + κ·F̄(Δ) + ρ·F̂(Δ)` with mean F̄ and rise F̂ of the force that [`Bristle`](super::Bristle) gives over Δ, both of which fall with
/// Δ; κ > 0 outweighs ρ < 0, so there is one solution as long as the level changes little over one step, which safeguarded
/// Newton steps find however stiff the bristles are.
#[derive(Debug, Clone, Copy)]
pub struct StepEquation {
    /// Force of the bristles at the beginning.
    pub(super) begun: f64,
    pub(super) free_travel: f64,
    pub(super) compliance: f64,
    pub(super) rise_travel: f64,
    pub(super) stiffness: f64,
    pub(super) damping: f64,
    pub(super) fading_factor: f64,
    pub(super) fading_exponent: f64,
    pub(super) level: Level,
    /// What the level is at least.
    pub(super) floor: f64,
    pub(super) drag: f64,
    pub(super) step_s: f64,
}

/// How far the search for the displacement is.
#[derive(Debug, Clone, Copy, Default)]
struct Search {
    /// Bounds of the displacement.
    low: f64,
    high: f64,
    /// Error of the displacement that does not matter.
    precision: f64,
    travel: f64,
    /// Length of the Newton step that led here; 0 where none did.
    before: f64,
    /// 1 once the displacement is found, else 0.
    is_found: f64,
    mean: f64,
    rise: f64,
    /// The bristles' force at the end.
    end: f64,
}

/// The bristles' answer to one displacement.
struct Answer {
    /// All of the guide's force.
    mean: f64,
    rise: f64,
    /// Their derivatives by the displacement, the level held.
    mean_slope: f64,
    rise_slope: f64,
    /// The bristles' own force at the end, and its derivative by the displacement.
    end: f64,
    end_slope: f64,
}

const NUMBERS: usize = 18;
const SEARCHED: usize = 9;
/// Row of [`Search::is_found`].
const IS_FOUND: usize = 5;

impl StepEquation {
    /// No axis: found at once.
    const NONE: Self = Self {
        begun: 0.0,
        free_travel: 0.0,
        compliance: 0.0,
        rise_travel: 0.0,
        stiffness: 1.0,
        damping: 0.0,
        fading_factor: 1.0,
        fading_exponent: GAUSSIAN,
        level: Level::constant(1.0),
        floor: 0.0,
        drag: 0.0,
        step_s: 1.0,
    };

    /// With a floor: one direction alone may slide freely; its bristles then have to be soft, not absent.
    #[inline]
    pub(super) fn with_floor(self) -> Self {
        Self { floor: LEAST_LEVEL * self.most(), ..self }
    }

    /// The guide's force over the step, and the bristles' force at its end.
    pub fn solve(&self) -> (StepForce, f64) {
        let mut one = StepEquations::<1>::default();
        one.set(0, self);
        one.solve();
        one.answer(0)
    }

    /// The greatest force of the bristles.
    fn most(&self) -> f64 {
        let [forward, backward] = self.level.at_rest();
        forward.max(backward).max(self.begun.abs())
    }

    /// The root lies between the displacements under the extreme forces.
    fn begin(&self) -> Search {
        let most = self.most();
        let damped = 2.0 * most * self.damping / (self.stiffness * self.step_s);
        let dragged = self.drag.abs() * 2.0 * self.free_travel.abs() / self.step_s;
        let reach = self.compliance * (most + damped + dragged) - self.rise_travel * 2.0 * most;
        let (low, high) = (self.free_travel - reach, self.free_travel + reach);
        // Not `clamp`: a replay that has diverged to infinity must come out as such, not stop the program.
        let travel = (self.free_travel + self.compliance * self.begun).max(low).min(high);
        Search { low, high, travel, precision: PRECISION * (high - low), ..Search::default() }
    }

    /// One Newton step, or one halving of the bracket where that leads out of it.
    #[inline(always)]
    fn advance(&self, search: Search, is_alone: bool) -> Search {
        let Search { travel, before, precision, is_found, .. } = search;
        let answer = self.over(travel, is_alone);
        let excess =
            travel - (self.free_travel + self.compliance * answer.mean + self.rise_travel * answer.rise);
        let (high, low) = if excess > 0.0 { (travel, search.low) } else { (search.high, travel) };
        let slope = 1.0 - self.compliance * answer.mean_slope - self.rise_travel * answer.rise_slope;
        let step = -excess / slope;
        let newton = travel + step;
        // On one side of the reversal, steps that shrink by a ratio leave no more than that share of the last one. Seen before the
        // bracket is: the last steps of all end on its edge. What is not a number has arrived: nothing will become of it.
        let is_smooth = travel * newton > 0.0;
        let is_small = (step.abs() <= precision) | step.is_nan();
        let has_arrived = is_small | (is_smooth & (step * step <= precision * before));
        let last = if has_arrived { step } else { 0.0 };
        let is_inside = (newton > low) & (newton < high);
        let was_found = is_found != 0.0;
        let next = if is_inside { newton } else { 0.5 * (low + high) };
        Search {
            low,
            high,
            precision,
            travel: next,
            before: if is_inside { step.abs() } else { 0.0 },
            is_found: if was_found | has_arrived { 1.0 } else { 0.0 },
            // Of a displacement that is larger by so little that the answer is straight.
            mean: if was_found { search.mean } else { answer.mean + answer.mean_slope * last },
            rise: if was_found { search.rise } else { answer.rise + answer.rise_slope * last },
            end: if was_found { search.end } else { answer.end + answer.end_slope * last },
        }
    }

    /// Force over a displacement gone through at an even pace.
    ///
    /// Of the exponential run of the force, `rise = 12·∫₀¹ (s − ½)·f ds`: the line with the same mean and first moment.
    ///
    /// An axis that is alone leaves out what comes out as nothing; among others, all are gone through.
    #[inline(always)]
    fn over(&self, travel: f64, is_alone: bool) -> Answer {
        let (begun, step_s) = (self.begun, self.step_s);
        let direction = if travel < 0.0 { -1.0 } else { 1.0 };
        let speed = travel.abs() / step_s;
        let is_even = is_alone && self.level.peak == [0.0; 2];
        let level =
            if is_even { self.level.without_peak(direction) } else { self.level.at(direction, speed) };
        let level = if level > self.floor { level } else { self.floor };
        let offset = begun + direction * level;
        let rate = self.stiffness / level;
        let a = rate * travel.abs();
        let [left, gone] = decay(a);
        let ([share, moment], [share_slope, moment_slope]) = shape(a, [left, gone]);
        let end = if travel == 0.0 { begun } else { offset * left - direction * level };
        let damping = if is_alone && self.damping == 0.0 {
            0.0
        } else {
            self.damping_at(speed, level) / (self.stiffness * step_s)
        };
        let slope = rate * direction;
        Answer {
            mean: -direction * level + offset * share + damping * (end - begun) - self.drag * speed,
            rise: 12.0 * offset * moment,
            mean_slope: offset * (share_slope - damping * left) * slope - self.drag * direction / step_s,
            rise_slope: 12.0 * offset * moment_slope * slope,
            end,
            end_slope: -offset * left * slope,
        }
    }

    /// σ₁ at a speed, in N·s/m or N·m·s/rad.
    #[inline(always)]
    fn damping_at(&self, speed: f64, level: f64) -> f64 {
        let ratio = speed * self.damping * self.fading_factor / level;
        let is_gaussian = self.fading_exponent == GAUSSIAN;
        let fading = if is_gaussian { ratio * ratio } else { power(ratio, self.fading_exponent) };
        self.damping * decay(fading)[0]
    }

    #[inline(always)]
    fn numbers(&self) -> [f64; NUMBERS] {
        let [forward, backward, forward_peak, backward_peak, velocity, factor, local] = self.level.numbers();
        [
            self.begun,
            self.free_travel,
            self.compliance,
            self.rise_travel,
            self.stiffness,
            self.damping,
            self.fading_factor,
            self.fading_exponent,
            forward,
            backward,
            forward_peak,
            backward_peak,
            velocity,
            factor,
            local,
            self.floor,
            self.drag,
            self.step_s,
        ]
    }

    #[inline(always)]
    fn of_numbers(numbers: [f64; NUMBERS]) -> Self {
        let [begun, free_travel, compliance, rise_travel, stiffness, damping, rest @ ..] = numbers;
        let [fading_factor, fading_exponent, forward, backward, forward_peak, backward_peak, rest @ ..] =
            rest;
        let [velocity, factor, local, floor, drag, step_s] = rest;
        let level =
            Level::of_numbers([forward, backward, forward_peak, backward_peak, velocity, factor, local]);
        Self {
            begun,
            free_travel,
            compliance,
            rise_travel,
            stiffness,
            damping,
            fading_factor,
            fading_exponent,
            level,
            floor,
            drag,
            step_s,
        }
    }
}

impl Search {
    #[inline(always)]
    fn numbers(self) -> [f64; SEARCHED] {
        let Self { low, high, precision, travel, before, is_found, mean, rise, end } = self;
        [low, high, precision, travel, before, is_found, mean, rise, end]
    }

    #[inline(always)]
    fn of_numbers(numbers: [f64; SEARCHED]) -> Self {
        let [low, high, precision, travel, before, is_found, mean, rise, end] = numbers;
        Self { low, high, precision, travel, before, is_found, mean, rise, end }
    }
}

/// The equations of N axes, number by number.
///
/// Each comes out to the last bit as by itself: the operations are those of one axis, on all of them at once, until the last one is found.
#[derive(Debug, Clone)]
pub struct StepEquations<const N: usize> {
    given: [[f64; N]; NUMBERS],
    searched: [[f64; N]; SEARCHED],
}

impl<const N: usize> Default for StepEquations<N> {
    /// N times no axis.
    fn default() -> Self {
        let found = Search { is_found: 1.0, ..Search::default() }.numbers();
        Self {
            given: StepEquation::NONE.numbers().map(|number| [number; N]),
            searched: found.map(|number| [number; N]),
        }
    }
}

impl<const N: usize> StepEquations<N> {
    /// Puts the equation of an axis in.
    pub fn set(&mut self, lane: usize, equation: &StepEquation) {
        self.given.iter_mut().zip(equation.numbers()).for_each(|(row, number)| row[lane] = number);
        let begun = equation.begin().numbers();
        self.searched.iter_mut().zip(begun).for_each(|(row, number)| row[lane] = number);
    }

    /// Takes an axis out: it counts as found.
    pub fn clear(&mut self, lane: usize) {
        self.searched[IS_FOUND][lane] = 1.0;
    }

    /// Finds the displacements, in the vector instructions of the processor at hand.
    pub fn solve_together(&mut self, arch: Arch) {
        arch.dispatch(Together(self));
    }

    /// The guide's force of one axis, and its bristles' force at the end; once the displacements are found.
    pub fn answer(&self, lane: usize) -> (StepForce, f64) {
        let Search { mean, rise, end, .. } = Search::of_numbers(from_fn(|i| self.searched[i][lane]));
        (StepForce { mean, rise }, end)
    }

    #[inline(always)]
    fn solve(&mut self) {
        let Self { given, searched } = self;
        // A value of its own, not a place: nothing then keeps the loop from being vectors.
        let mut now = *searched;
        for _ in 0..MOST_ITERATIONS {
            for k in 0..N {
                let equation = StepEquation::of_numbers(from_fn(|i| given[i][k]));
                let search = equation.advance(Search::of_numbers(from_fn(|i| now[i][k])), N == 1);
                let numbers = search.numbers();
                for i in 0..SEARCHED {
                    now[i][k] = numbers[i];
                }
            }
            if !now[IS_FOUND].contains(&0.0) {
                break;
            }
        }
        *searched = now;
    }
}

struct Together<'a, const N: usize>(&'a mut StepEquations<N>);

impl<const N: usize> WithSimd for Together<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        self.0.solve();
    }
}

/// Mean and first moment about the middle of e^(−a·s) for 0 ≤ s ≤ 1, and their derivatives by a; `left` is e^(−a), `fallen` 1 − e^(−a).
#[inline(always)]
fn shape(a: f64, [left, fallen]: [f64; 2]) -> ([f64; 2], [f64; 2]) {
    // Below this, the closed forms take numbers near each other apart.
    const SERIES_BELOW: f64 = 1e-2;
    let is_small = a < SERIES_BELOW;
    let choose = |small: f64, large: f64| if is_small { small } else { large };
    let over = 1.0 / a;
    let over_square = over * over;
    let mean = fallen * over;
    let first = (fallen - a * left) * over_square; // ∫ s·e^(−a·s) ds
    let second = (2.0 * fallen - 2.0 * a * left - a * a * left) * (over_square * over); // ∫ s²·e^(−a·s) ds
    let mean = choose(1.0 - a * (0.5 - a * (1.0 / 6.0 - a / 24.0)), mean);
    let mean_slope = choose(-0.5 + a * (1.0 / 3.0 - a / 8.0), -first);
    let moment = choose(-a / 12.0 * (1.0 - a * (0.5 - a * 0.15)), first - 0.5 * mean);
    let moment_slope = choose(-1.0 / 12.0 + a * (1.0 / 12.0 - a * 0.0375), 0.5 * first - second);
    ([mean, moment], [mean_slope, moment_slope])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guide::{Bristle, Coast, Sliding};

    /// Mean, moment and derivatives against sums, on both sides of the series' end.
    #[test]
    fn exact_shape_of_a_decay() {
        for a in [1e-5, 0.009_99, 0.010_01, 0.3, 4.0] {
            let steps = 40_000;
            let at = |k: i32| (f64::from(k) + 0.5) / f64::from(steps);
            let integral =
                |f: &dyn Fn(f64) -> f64| (0..steps).map(|k| f(at(k))).sum::<f64>() / f64::from(steps);
            let ([mean, moment], slopes) = shape(a, decay(a));
            assert!((mean - integral(&|s| (-a * s).exp())).abs() < 1e-8);
            assert!((moment - integral(&|s| (s - 0.5) * (-a * s).exp())).abs() < 1e-8);
            assert!((slopes[0] + integral(&|s| s * (-a * s).exp())).abs() < 1e-6);
            assert!((slopes[1] + integral(&|s| s * (s - 0.5) * (-a * s).exp())).abs() < 1e-6);
        }
    }

    /// The force is that of the displacement which it leaves, whatever the level depends on and wherever the step goes.
    #[test]
    fn exact_force_and_displacement_belong_together() {
        let step = 250e-6;
        let peaked = Level { base: [9.0, 7.0], peak: [4.0; 2], velocity: 0.004, ..Level::constant(0.0) };
        let levels = [Level::constant(8.0), peaked];
        for (stiffness, damping, level) in [1e5, 1e7, 1e9]
            .into_iter()
            .flat_map(|k| [0.0, 1e4].map(|d| (k, d)))
            .flat_map(|(k, d)| levels.map(|l| (k, d, l)))
        {
            let bristle = Bristle { stiffness, damping, fading_factor: 1.0, fading_exponent: GAUSSIAN };
            for velocity in [0.0, 1e-7, -1e-5, 1e-3, -0.003, 0.1] {
                for begun in [-9.0, -2.0, 0.0, 5.0, 7.0] {
                    let coast = Coast::of_mass(50.0, velocity, step);
                    let equation = bristle.step_equation(begun, coast, step, Sliding { level, drag: 20.0 });
                    let (force, end) = equation.solve();
                    let answer = equation.over(coast.travel_under(force), true);
                    let off = (force.mean - answer.mean).abs() + (end - answer.end).abs();
                    assert!(off < 1e-7, "{stiffness} {damping} {velocity} {begun}: {off}");
                }
            }
        }
    }

    /// Axes of which some are found at once and some late, and one that is none, against each by itself.
    #[test]
    fn exact_several_axes_are_each_of_them() {
        let step = 250e-6;
        let equation = |k: usize| {
            let power = 4.0 + 0.7 * k as f64;
            let (damping, fading_exponent) = if k < 3 { (0.0, GAUSSIAN) } else { (300.0 * k as f64, 1.4) };
            let peak = if k.is_multiple_of(2) { 0.0 } else { 4.0 };
            let stiffness = 10.0_f64.powf(power);
            let bristle = Bristle { stiffness, damping, fading_factor: 0.7, fading_exponent };
            let level = Level {
                base: [9.0, 7.0 + k as f64],
                peak: [peak; 2],
                velocity: 0.01,
                factor: 1.1,
                local: -0.3,
            };
            let velocity = 0.02 * (k as f64 - 2.5);
            let coast = Coast::of_mass(50.0, velocity, step);
            bristle.step_equation(3.0 - k as f64, coast, step, Sliding { level, drag: 5.0 })
        };
        let mut together = StepEquations::<8>::default();
        (0..7).for_each(|k| together.set(k, &equation(k)));
        together.solve_together(Arch::new());
        for k in 0..7 {
            assert_eq!(together.answer(k), equation(k).solve(), "{k}");
        }
        assert_eq!(together.answer(7), (StepForce::ZERO, 0.0));
    }
}
