//! Weight and dry friction over one step, for several twins at once: they slide on, or stay stuck.

use crate::guide::stick_slip::{AT_REST, Onward, SLIDE_STEPS, Slide, friction_at_first};
use crate::guide::{Coast, GAUSS, Level, Response, StepForce};
use crate::solid::{SMALL_RAD, Weight};
use pulp::{Arch, Simd, WithSimd};
use std::array::from_fn;

/// What weight and dry friction of one step depend on.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlidingStep {
    /// The step under all else.
    pub coast: Coast,
    /// Position where the step begins, m or rad.
    pub position: f64,
    /// See [`Weight::numbers`].
    pub weight: [f64; 3],
    /// Level of friction at rest in the positive and the negative direction, without the part of the load, N or N·m.
    pub constant: [f64; 2],
    pub level: Level,
    /// Drag that the positive direction has more than the mean of both, N·s/m or N·m·s/rad.
    pub drag: f64,
}

const NUMBERS: usize = 25;
const ANSWERS: usize = 5;
/// Rows of the numbers that the weight changes.
const FREE_VELOCITY: usize = 1;
const FREE_TRAVEL: usize = 2;

impl SlidingStep {
    /// No twin: nothing moves, and nothing acts on it.
    fn none() -> Self {
        let coast = Coast::of_mass(1.0, 0.0, 1.0);
        let (weight, constant) = ([0.0; 3], [0.0; 2]);
        Self { coast, position: 0.0, weight, constant, level: Level::constant(0.0), drag: 0.0 }
    }

    #[inline(always)]
    fn numbers(&self) -> [f64; NUMBERS] {
        let Self { coast, position, weight, constant, level, drag } = *self;
        let [forward, backward, forward_peak, backward_peak, velocity, factor, local] = level.numbers();
        let [mobility, compliance, rise_mobility, rise_travel, i0, i1, i2, i3] = coast.response.numbers();
        [
            coast.velocity,
            coast.free_velocity,
            coast.free_travel,
            mobility,
            compliance,
            rise_mobility,
            rise_travel,
            i0,
            i1,
            i2,
            i3,
            position,
            weight[0],
            weight[1],
            weight[2],
            constant[0],
            constant[1],
            forward,
            backward,
            forward_peak,
            backward_peak,
            velocity,
            factor,
            local,
            drag,
        ]
    }

    #[inline(always)]
    fn of_numbers(numbers: [f64; NUMBERS]) -> Self {
        let [velocity, free_velocity, free_travel, rest @ ..] = numbers;
        let [mobility, compliance, rise_mobility, rise_travel, i0, i1, i2, i3, rest @ ..] = rest;
        let [position, constant_weight, by_cosine, by_sine, positive, negative, rest @ ..] = rest;
        let [forward, backward, forward_peak, backward_peak, peak_velocity, factor, local, drag] = rest;
        let response =
            Response::of_numbers([mobility, compliance, rise_mobility, rise_travel, i0, i1, i2, i3]);
        let level =
            Level::of_numbers([forward, backward, forward_peak, backward_peak, peak_velocity, factor, local]);
        Self {
            coast: Coast { velocity, free_velocity, free_travel, motor_force: [0.0; 2], response },
            position,
            weight: [constant_weight, by_cosine, by_sine],
            constant: [positive, negative],
            level,
            drag,
        }
    }

    /// R in a direction (±1) at a speed ≥ 0, N or N·m.
    #[inline(always)]
    fn resistance(&self, direction: f64, speed: f64) -> f64 {
        self.level.at(direction, speed) + direction * self.drag * speed
    }

    /// The weight over the step, the step under it, and whether it was taken near enough to where the step begins.
    ///
    /// The operations are those of a single twin, see `Laws::under_weight`.
    #[inline(always)]
    fn fall(&self, step_s: f64) -> (StepForce, Coast, bool) {
        let weight = Weight::of_numbers(self.weight);
        let near = weight.very_near(self.position);
        let falling = self.coast.under(self.coast.force_over(0.0, step_s, near));
        let held = friction_at_first(falling, step_s, self.constant);
        let slower = falling.under(StepForce::held(held));
        let weight = slower.force_over(0.0, step_s, near);
        let is_near = is_near(&self.coast, step_s) & is_near(&slower, step_s);
        (weight, self.coast.under(weight), is_near)
    }

    /// The search for the speed at the end of the step, with the direction of motion, under the step's weight.
    #[inline(always)]
    fn slide(&self, step_s: f64) -> (f64, Slide) {
        let Coast { velocity, free_velocity, response, .. } = self.coast;
        let direction = if velocity < 0.0 { -1.0 } else { 1.0 };
        let (speed, mobility) = (velocity * direction, response.mobility);
        let sag = mobility * direction * self.coast.push(step_s).rise / 8.0;
        let begin = self.resistance(direction, speed);
        (direction, Slide { free_speed: direction * free_velocity, speed, mobility, sag, begin })
    }

    /// Mean and rise of the friction where the axis slides on to this speed under a mean resistance, or stays stuck; and whether it does either (1) or not (0).
    #[inline(always)]
    fn answer(&self, step_s: f64, direction: f64, slide: &Slide, [onward, level]: [f64; 2]) -> [f64; 3] {
        let [forward, backward] = self.level.at_rest();
        let limit = if direction < 0.0 { backward } else { forward };
        let rests = slide.speed <= AT_REST * slide.mobility * limit;
        let push = self.coast.push(step_s);
        let (begin, end) = (push.mean - 0.5 * push.rise, push.mean + 0.5 * push.rise);
        let holds_begin = begin.abs() <= if begin < 0.0 { backward } else { forward };
        let holds_end = end.abs() <= if end < 0.0 { backward } else { forward };
        let sticks = rests & holds_begin & holds_end;
        let slides = !rests & (onward >= 0.0);
        let held = self.coast.force_to(0.0, 0.0);
        let rise = direction * (slide.begin - self.resistance(direction, onward));
        let mean = if sticks { held.mean } else { -direction * level };
        let rise = if sticks { held.rise } else { rise };
        let is_free = (forward == 0.0) & (backward == 0.0) & (self.drag == 0.0);
        let is_answer = if is_free | sticks | slides { 1.0 } else { 0.0 };
        [if is_free { 0.0 } else { mean }, if is_free { 0.0 } else { rise }, is_answer]
    }
}

/// Whether the way of a step is as small as [`Weight::very_near`] takes it.
#[inline(always)]
fn is_near(coast: &Coast, step_s: f64) -> bool {
    let way = |share: f64| coast.free_travel_until(share, step_s).abs();
    (way(GAUSS[0]) <= SMALL_RAD) & (way(GAUSS[1]) <= SMALL_RAD)
}

/// Steps of N twins, number by number, and their answers.
///
/// Each comes out to the last bit as by itself: the operations are those of a single twin that slides on or stays stuck
/// ([`friction`](crate::guide::stick_slip::friction)), on all of them at once. A step in which a twin stops or breaks away has no answer here: it is left to the code of a single twin.
#[derive(Debug, Clone)]
pub(super) struct Slides<const N: usize> {
    given: [[f64; N]; NUMBERS],
    answers: [[f64; N]; ANSWERS],
    step_s: f64,
    /// Whether any twin has weight.
    has_weight: bool,
}

impl<const N: usize> Slides<N> {
    /// For steps of this length, N times no twin.
    pub fn new(step_s: f64) -> Self {
        Self {
            given: SlidingStep::none().numbers().map(|number| [number; N]),
            answers: [[0.0; N]; ANSWERS],
            step_s,
            has_weight: false,
        }
    }

    /// Puts the step of a twin in.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, step: &SlidingStep) {
        self.has_weight |= step.weight != [0.0; 3];
        self.given.iter_mut().zip(step.numbers()).for_each(|(row, number)| row[lane] = number);
    }

    /// Finds weight and friction, in the vector instructions of the processor at hand.
    pub fn solve_together(&mut self, arch: Arch) {
        arch.dispatch(Together(self));
    }

    /// Weight and friction of one twin over the step, where it slides on or stays stuck.
    #[inline(always)]
    pub fn answer(&self, lane: usize) -> Option<[StepForce; 2]> {
        let [weight, weight_rise, mean, rise, is_answer] = from_fn(|i| self.answers[i][lane]);
        let weight = StepForce { mean: weight, rise: weight_rise };
        (is_answer != 0.0).then_some([weight, StepForce { mean, rise }])
    }

    #[inline(always)]
    fn solve(&mut self) {
        let step_s = self.step_s;
        // Values of their own, not places: nothing then keeps the loops from being vectors.
        let mut given = self.given;
        let step = |given: &[[f64; N]; NUMBERS], k: usize| SlidingStep::of_numbers(from_fn(|i| given[i][k]));
        let mut answers = [[0.0; N]; ANSWERS];
        let mut is_near = [1.0; N];
        if self.has_weight {
            for k in 0..N {
                let (weight, coast, near) = step(&given, k).fall(step_s);
                answers[0][k] = weight.mean;
                answers[1][k] = weight.rise;
                is_near[k] = if near { 1.0 } else { 0.0 };
                given[FREE_VELOCITY][k] = coast.free_velocity;
                given[FREE_TRAVEL][k] = coast.free_travel;
            }
        }
        let (mut direction, mut slides) = ([0.0; N], [[0.0; N]; 5]);
        let (mut speed, mut level, mut is_found) = ([0.0; N], [0.0; N], [0.0; N]);
        for k in 0..N {
            let (towards, slide) = step(&given, k).slide(step_s);
            direction[k] = towards;
            let numbers = [slide.free_speed, slide.speed, slide.mobility, slide.sag, slide.begin];
            for i in 0..5 {
                slides[i][k] = numbers[i];
            }
            let begun = slide.first();
            speed[k] = begun.speed;
            level[k] = begun.level;
        }
        let slide = |k: usize| {
            let [free_speed, speed, mobility, sag, begin] = from_fn(|i| slides[i][k]);
            Slide { free_speed, speed, mobility, sag, begin }
        };
        for _ in 0..SLIDE_STEPS {
            for k in 0..N {
                let step = step(&given, k);
                let from = Onward { speed: speed[k], level: level[k], is_found: false };
                let next = slide(k).advance(from, |w| step.resistance(direction[k], w));
                let was_found = is_found[k] != 0.0;
                speed[k] = if was_found { from.speed } else { next.speed };
                level[k] = if was_found { from.level } else { next.level };
                is_found[k] = if was_found | next.is_found { 1.0 } else { 0.0 };
            }
            if !is_found.contains(&0.0) {
                break;
            }
        }
        for k in 0..N {
            let step = step(&given, k);
            let [mean, rise, is_answer] = step.answer(step_s, direction[k], &slide(k), [speed[k], level[k]]);
            answers[2][k] = mean;
            answers[3][k] = rise;
            answers[4][k] = is_answer * is_near[k];
        }
        self.answers = answers;
    }
}

struct Together<'a, const N: usize>(&'a mut Slides<N>);

impl<const N: usize> WithSimd for Together<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        self.0.solve();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guide::stick_slip::friction;

    /// Twins that slide on, stay stuck, stop and break away, with a Stribeck curve and drag of one direction: what has an answer has that of a twin by itself, and what slides on or
    /// stays stuck has one.
    #[test]
    fn exact_what_slides_on_or_stays_stuck_is_found_together() {
        let step_s = 1e-3;
        let step = |velocity: f64, push: f64| {
            let level =
                Level { base: [9.0, 7.0], peak: [4.0, 3.0], velocity: 0.01, factor: 1.1, local: -0.4 };
            let coast =
                Coast::of_mass(2.0, velocity, step_s).under(StepForce { mean: push, rise: 0.1 * push });
            let (weight, constant) = ([0.0; 3], [13.0, 10.0]);
            SlidingStep { coast, position: 0.0, weight, constant, level, drag: 5.0 }
        };
        // Four that slide on, two that stay stuck, one that stops, one that breaks away.
        let all = [
            (0.5, 0.0),
            (-0.3, 2.0),
            (0.02, 30.0),
            (-0.01, -25.0),
            (0.0, 3.0),
            (0.0, -9.0),
            (1e-4, 0.0),
            (0.0, 40.0),
        ];
        let mut together = Slides::<8>::new(step_s);
        for (lane, (velocity, push)) in all.into_iter().enumerate() {
            together.set(lane, &step(velocity, push));
        }
        together.solve_together(Arch::new());
        for (lane, (velocity, push)) in all.into_iter().enumerate() {
            let step = step(velocity, push);
            let alone = friction(step.coast, step_s, |direction, speed| step.resistance(direction, speed));
            match together.answer(lane) {
                Some([_, found]) => assert_eq!(found, alone, "{velocity} {push}"),
                None => assert!(lane >= 6, "{velocity} {push}"),
            }
        }
    }
}
