//! Implicit stick–slip: the friction force over one step, sticking included.

use super::step::{Coast, StepForce};

/// Friction force over one step with which the guide answers.
///
/// # Model
/// Dry friction is a set-valued law, `F ∈ −R(s, |v|)·Sgn(v)`: at rest any force up to the breakaway value
/// R(s, 0) holds. The other forces P move linearly over the step, as velocity and displacement without friction say; over
/// a share of the step the velocity changes by β times the mean of P and friction. In the step the axis
///
/// 1. keeps its direction s: `v₁ = v_free − s·β·R̄` with the mean R̄ of R over the velocities from v₀ to v₁ (Simpson's
///    rule), a scalar equation; exact for Coulomb friction; the force rises from −s·R(s, |v₀|) to −s·R(s, |v₁|);
/// 2. or slows down under the mean of R over the velocities from v₀ to 0 until it comes to rest at the share θ, rests as long as P stays within the breakaway
///    values, and goes on from where P leaves them, in the direction of P: rest, and both velocities, are resolved
///    inside the step.
///
/// The answer is the friction force as mean and rise: those with which the plant ends the step with that velocity after that
/// way. A stuck axis does not move at all, however the motor's force moves within the step. In a step that comes to
/// rest, the mean may point along v₀: the part that holds is then larger than the part that brakes.
///
/// `resistance(direction, speed)` is R ≥ 0, `step_s` the step h. Positive force acts along positive position.
///
/// # Validity
/// Resistance varying little over the velocity change of one step; one stop and one start a step at most.
///
/// # Source
/// Moreau's time stepping for dry friction (Acary, Brogliato 2008, ch. 10), with stop and start resolved inside
/// the step.
///
/// ```
/// use slideway::guide::{Coast, StepForce, stick_slip::friction};
/// let coulomb = |_direction: f64, _speed: f64| 10.0;
/// // Sliding: the full 10 N oppose. At rest below 10 N: friction balances the rest exactly.
/// // The force is a difference of velocities over β: rounding is 1e-16·v/β, some 1e-13 N here.
/// let near = |force: f64, expected: f64| (force - expected).abs() < 1e-9;
/// let sliding = Coast::of_mass(1.0, 1.0, 1e-3);
/// assert!(near(friction(sliding, 1e-3, coulomb).mean, -10.0));
/// let pushed = Coast::of_mass(1.0, 0.0, 1e-3).under(StepForce::held(5.0));
/// assert!(near(friction(pushed, 1e-3, coulomb).mean, -5.0));
/// ```
#[inline(always)]
pub fn friction(coast: Coast, step_s: f64, resistance: impl Fn(f64, f64) -> f64) -> StepForce {
    let Coast { velocity, free_velocity, response, .. } = coast;
    let mobility = response.mobility;
    let direction = velocity.signum();
    let speed = velocity * direction;
    if speed <= AT_REST * mobility * resistance(direction, 0.0) {
        return from_rest(coast, step_s, Stop { share: 0.0, travel: 0.0 }, resistance);
    }
    let sag = mobility * direction * coast.push(step_s).rise / 8.0;
    let begin = resistance(direction, speed);
    let slide = Slide { free_speed: direction * free_velocity, speed, mobility, sag, begin };
    let Onward { speed: onward, level, .. } = slide.solve(|w| resistance(direction, w));
    if onward >= 0.0 {
        let rise = direction * (begin - resistance(direction, onward));
        return StepForce { mean: -direction * level, rise };
    }
    // Simpson's rule over the velocities until rest.
    let level = |share: f64| resistance(direction, share * speed);
    let stop = stop(coast, step_s, (level(1.0) + 4.0 * level(0.5) + level(0.0)) / 6.0);
    from_rest(coast, step_s, stop, resistance)
}

/// What friction would take away within this share of a step counts as rest: far below rounding of the motion.
pub const AT_REST: f64 = 1e-12;

/// Where in the step the axis comes to rest.
#[derive(Debug, Clone, Copy)]
struct Stop {
    /// Share of the step.
    share: f64,
    /// Displacement until then.
    travel: f64,
}

/// The stop of an axis that friction of this level brakes.
#[inline(always)]
fn stop(coast: Coast, step_s: f64, braking: f64) -> Stop {
    let direction = coast.velocity.signum();
    let (speed, mobility) = (coast.velocity.abs(), coast.response.mobility);
    let push = Push::of(coast.push(step_s));
    // Against v₀: speed + β·((p₀ − R)·θ + Δp·θ²/2) = 0, its first root.
    let slope = mobility * (direction * push.begin - braking);
    let bend = mobility * direction * push.change();
    let root = (slope * slope - 2.0 * bend * speed).max(0.0).sqrt();
    let share = (2.0 * speed / (root - slope)).min(1.0);
    let way = share * (speed + share * (0.5 * slope + share * bend / 6.0));
    Stop { share, travel: direction * way * step_s }
}

/// The forces but friction at the beginning and the end of a step.
#[derive(Debug, Clone, Copy)]
struct Push {
    begin: f64,
    end: f64,
}

impl Push {
    #[inline(always)]
    fn of(force: StepForce) -> Self {
        Self { begin: force.mean - 0.5 * force.rise, end: force.mean + 0.5 * force.rise }
    }

    #[inline(always)]
    fn change(self) -> f64 {
        self.end - self.begin
    }

    #[inline(always)]
    fn at(self, share: f64) -> f64 {
        self.begin + share * self.change()
    }
}

/// The answer for an axis that rests from a share of the step on, until it breaks away.
#[inline(always)]
fn from_rest(coast: Coast, step_s: f64, stop: Stop, resistance: impl Fn(f64, f64) -> f64) -> StepForce {
    let push = Push::of(coast.push(step_s));
    let Some((share, direction)) = breakaway(push, stop.share, &resistance) else {
        return coast.force_to(0.0, stop.travel);
    };
    let left = 1.0 - share;
    let mean = direction * 0.5 * (push.at(share) + push.end);
    let mobility = left * coast.response.mobility;
    let sag = mobility * direction * (push.end - push.at(share)) / 8.0;
    let begin = resistance(direction, 0.0);
    let slide = Slide { free_speed: mobility * mean, speed: 0.0, mobility, sag, begin };
    let onward = slide.solve(|w| resistance(direction, w)).speed.max(0.0);
    // From rest under a force that moves linearly: a half of the end's speed, less a part that its rise delays.
    let delayed = mobility * direction * (push.end - push.at(share)) / 12.0;
    let way = (0.5 * onward - delayed).max(0.0) * left * step_s;
    coast.force_to(direction * onward, stop.travel + direction * way)
}

/// The share of the step, from `share` on, at which the push leaves what holds the axis, and its direction there.
#[inline(always)]
fn breakaway(push: Push, share: f64, resistance: &impl Fn(f64, f64) -> f64) -> Option<(f64, f64)> {
    let now = push.at(share);
    let leaves = |force: f64| force.abs() > resistance(force.signum(), 0.0);
    if leaves(now) {
        return Some((share, now.signum()));
    }
    if !leaves(push.end) {
        return None;
    }
    let direction = push.end.signum();
    let beyond = direction * resistance(direction, 0.0) - push.begin;
    Some(((beyond / push.change()).clamp(share, 1.0), direction))
}

/// Dry friction at the beginning of a step in N or N·m, positive in the joint's positive direction.
///
/// # Model
/// `−R₊` of an axis that moves in the positive direction, `R₋` in the negative one, with the levels of both in N or N·m. At rest friction holds the mean P of the other forces as far as it
/// can: `−max(min(P, R₊), −R₋)`.
///
/// # Validity
/// Without what depends on load, speed, place or time: it serves to find the way of a step, see `Laws::under_weight` in the twin.
///
/// # Source
/// Coulomb's law as a set-valued law, see [`friction`].
#[inline(always)]
pub fn friction_at_first(coast: Coast, step_s: f64, [positive, negative]: [f64; 2]) -> f64 {
    // What does not slide yet is held.
    let held = -coast.push(step_s).mean.min(positive).max(-negative);
    let backward = if coast.velocity < 0.0 { negative } else { held };
    if coast.velocity > 0.0 { -positive } else { backward }
}

/// A step that keeps its direction: friction and the speed at its end belong together.
///
/// # Model
/// `w₁ = w_free − β·R̄`, with the mean R̄ of the resistance over the speeds from w₀ to w₁ by Simpson's rule, solved by fixed-point steps, which contract
/// by β·|R'|/2: 10⁻² and less at servo sample rates. Straight-line arithmetic, so that several axes can take each step together.
#[derive(Debug, Clone, Copy)]
pub struct Slide {
    /// Speed at the end of the step without friction, along the direction of motion, m/s or rad/s.
    pub free_speed: f64,
    /// Speed at its beginning, m/s or rad/s; ≥ 0.
    pub speed: f64,
    /// β, what a unit of mean force changes of the speed at the end, (m/s)/N or (rad/s)/(N·m); > 0.
    pub mobility: f64,
    /// What the speed in the middle of the step lacks to the mean of those at its ends, since the push rises.
    pub sag: f64,
    /// Resistance at the beginning, N or N·m; ≥ 0.
    pub begin: f64,
}

/// Where a fixed-point step of a [`Slide`] has come.
#[derive(Debug, Clone, Copy)]
pub struct Onward {
    /// Speed at the end of the step, m/s or rad/s; negative where it would not keep its direction.
    pub speed: f64,
    /// Mean resistance, N or N·m.
    pub level: f64,
    /// Whether the last step changed the speed by no more than rounding.
    pub is_found: bool,
}

/// Fixed-point steps of a [`Slide`], at most.
pub const SLIDE_STEPS: usize = 4;

impl Slide {
    /// Where the search begins: with the resistance of the step's beginning.
    #[inline(always)]
    pub fn first(&self) -> Onward {
        let speed = self.free_speed - self.mobility * self.begin;
        Onward { speed, level: self.begin, is_found: false }
    }

    /// One fixed-point step.
    #[inline(always)]
    pub fn advance(&self, from: Onward, resistance: impl Fn(f64) -> f64) -> Onward {
        let Self { free_speed, speed, mobility, sag, begin } = *self;
        let last = from.speed.max(0.0);
        let middle = resistance((0.5 * (speed + last) - sag).max(0.0));
        let level = middle + (begin - 2.0 * middle + resistance(last)) / 6.0;
        let next = free_speed - mobility * level;
        let is_found = (next - from.speed).abs() <= 1e-15 * speed.max(free_speed.abs());
        Onward { speed: next, level, is_found }
    }

    #[inline(always)]
    fn solve(&self, resistance: impl Fn(f64) -> f64) -> Onward {
        let mut onward = self.first();
        for _ in 0..SLIDE_STEPS {
            onward = self.advance(onward, &resistance);
            if onward.is_found {
                break;
            }
        }
        onward
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A block of mass 1 thrown at 1 m/s against 2 N of friction stops after 0.5 s and 0.25 m.
    #[test]
    fn exact_sliding_block_stops_where_energy_says() {
        let (step, mass, force) = (1e-3, 1.0, 2.0);
        let (mut position, mut velocity) = (0.0, 1.0);
        for _ in 0..1000 {
            let coast = Coast::of_mass(mass, velocity, step);
            let end = coast.velocity_under(friction(coast, step, |_, _| force));
            position += 0.5 * (velocity + end) * step;
            velocity = end;
        }
        assert_eq!(velocity, 0.0);
        assert!((position - 0.25).abs() < 1e-9, "{position}");
    }

    /// Thrown uphill against gravity and friction, it comes back with the energy that friction left.
    #[test]
    fn exact_reversal_inside_a_step() {
        let (mass, gravity, force, step) = (1.0, -5.0, 1.0, 1e-3);
        let (mut velocity, mut time) = (1.0, 0.0);
        while time < 0.5 - 1e-12 {
            let coast = Coast::of_mass(mass, velocity, step).under(StepForce::held(gravity * mass));
            velocity = coast.velocity_under(friction(coast, step, |_, _| force));
            time += step;
        }
        // Up: deceleration 6 for 1/6 s; down: acceleration 4 for the rest. Reversal falls inside a step.
        assert!((velocity + 4.0 * (0.5 - 1.0 / 6.0)).abs() < 1e-9, "{velocity}");
    }

    /// Velocity at `time` under `push` of a body of mass 1 with Coulomb and viscous resistance of its own in
    /// each direction, thrown upward and pushed back: two exponentials that meet at rest.
    fn thrown(velocity: f64, push: f64, up: (f64, f64), down: (f64, f64), time: f64) -> f64 {
        let ((up_n, up_c), (down_n, down_c)) = (up, down);
        let terminal = (push - up_n) / up_c;
        let until_rest = (1.0 - velocity / terminal).ln() / up_c;
        if time < until_rest {
            return terminal + (velocity - terminal) * (-up_c * time).exp();
        }
        (push + down_n) / down_c * -(-down_c * (time - until_rest)).exp_m1()
    }

    /// Resistance that differs by direction and grows with speed, through a reversal: second order in the step.
    #[test]
    fn exact_reversal_is_second_order_with_asymmetric_resistance_that_depends_on_speed() {
        let (initial, push, up, down, end) = (1.0, -5.0, (1.0, 0.8), (2.0, 0.3), 0.5);
        let exact = thrown(initial, push, up, down, end);
        let resistance = |direction: f64, speed: f64| {
            let (coulomb, viscous) = if direction > 0.0 { up } else { down };
            coulomb + viscous * speed
        };
        let error = |steps: u32| {
            let step = end / f64::from(steps);
            let mut velocity = initial;
            for _ in 0..steps {
                let coast = Coast::of_mass(1.0, velocity, step).under(StepForce::held(push));
                velocity += push * step + step * friction(coast, step, resistance).mean;
            }
            (velocity - exact).abs()
        };
        // Where in its step the axis reverses adds a third-order part: the ratio is 4 up to that.
        for steps in [50, 100, 200, 400] {
            let ratio = error(steps) / error(2 * steps);
            assert!((ratio - 4.0).abs() < SECOND_ORDER_TOLERANCE, "{steps} steps: ratio {ratio}");
        }
    }

    /// Share of the third-order part at 50 steps: h = 10 ms is 2 % of the motion.
    const SECOND_ORDER_TOLERANCE: f64 = 0.2;

    /// Length of the step and rounding of a velocity in the property tests; rounding of a force is 1/β of it.
    const MOBILITY: f64 = 1e-3;
    const ROUNDING: f64 = 1e-14;

    /// Velocity at the end of a unit step and travel within it, by solving the motion piece by piece: constant
    /// force while it slides, then rest or constant force the other way.
    fn coulomb_step(velocity: f64, push: f64, positive: f64, negative: f64) -> (f64, f64) {
        let acceleration = |direction: f64| {
            let limit = if direction > 0.0 { positive } else { negative };
            MOBILITY * (push - direction * limit)
        };
        let from_rest = |time: f64| {
            let onward = if push > positive { acceleration(1.0) } else { acceleration(-1.0) };
            let moves = push > positive || -push > negative;
            if moves { (onward * time, 0.5 * onward * time * time) } else { (0.0, 0.0) }
        };
        if velocity == 0.0 {
            return from_rest(1.0);
        }
        let braked = acceleration(velocity.signum());
        let until_rest = if braked * velocity < 0.0 { -velocity / braked } else { f64::INFINITY };
        if until_rest >= 1.0 {
            return (velocity + braked, velocity + 0.5 * braked);
        }
        let (end, back) = from_rest(1.0 - until_rest);
        (end, 0.5 * velocity * until_rest + back)
    }

    /// Velocities of which one in four is zero, and most small enough for pushes to stop them within a step.
    fn velocities() -> impl Strategy<Value = f64> {
        prop_oneof![Just(0.0), -0.05..0.05f64, -0.01..0.01f64, -1.0..1.0f64]
    }

    /// A stuck axis stays where it is while the motor's force moves within the step.
    #[test]
    fn exact_a_stuck_axis_does_not_move_under_a_changing_force() {
        let (mass, step) = (51.28, 250e-6);
        let pushed = Coast::of_mass(mass, 0.0, step).under(StepForce::between(2.0, 9.0));
        let answer = friction(pushed, step, |_, _| 10.0);
        assert!(pushed.velocity_under(answer).abs() < 1e-18 && pushed.travel_under(answer).abs() < 1e-20);
        assert!((answer.mean + 5.5).abs() < 1e-9 && (answer.rise + 7.0).abs() < 1e-6, "{answer:?}");
    }

    /// A push that rises through the breakaway force within the step: the body moves from there on only.
    #[test]
    fn exact_breakaway_inside_a_step() {
        let (mass, step) = (2.0, 1e-3);
        let coast = Coast::of_mass(mass, 0.0, step).under(StepForce::between(6.0, 14.0));
        let answer = friction(coast, step, |_, _| 10.0);
        // From half of the step on, 0 to 4 N: v = ½·4 N·½h/m, x = 4 N·(½h)²/(6·m).
        let left = 0.5 * step;
        assert!((coast.velocity_under(answer) - 0.5 * 4.0 * left / mass).abs() < 1e-15);
        assert!((coast.travel_under(answer) - 4.0 * left * left / (6.0 * mass)).abs() < 1e-18);
    }

    /// Friction that stops a body under a falling push, then holds it: the way is that of the cubic until it rests.
    #[test]
    fn exact_stop_under_a_changing_push() {
        let (mass, step, velocity) = (1.0, 1e-2, 0.02);
        let coast = Coast::of_mass(mass, velocity, step).under(StepForce::between(4.0, -4.0));
        let answer = friction(coast, step, |_, _| 9.0);
        // v(t) = v + (4 − 9)·t − 8·t²/(2h) = 0
        let time = (-5.0 + (25.0 + 2.0 * 8.0 / step * velocity).sqrt()) / (8.0 / step);
        let way = velocity * time - 2.5 * time * time - 8.0 / step * time.powi(3) / 6.0;
        assert!(coast.velocity_under(answer).abs() < 1e-15);
        assert!((coast.travel_under(answer) - way).abs() < 1e-15, "{way}");
    }

    proptest! {
        /// A step under a constant push is the closed form: slide, stop, stick or reverse.
        #[test]
        fn exact_coulomb_step_is_the_closed_form(
            velocity in velocities(),
            push in -50.0..50.0f64,
            positive in 0.0..30.0f64,
            negative in 0.0..30.0f64,
        ) {
            let coast = Coast::of_mass(1.0 / MOBILITY, velocity, 1.0).under(StepForce::held(push));
            let limit = |direction: f64, _: f64| if direction > 0.0 { positive } else { negative };
            let answer = friction(coast, 1.0, limit);
            let (expected, travel) = coulomb_step(velocity, push, positive, negative);
            let end = coast.velocity_under(answer);
            prop_assert!((end - expected).abs() <= ROUNDING, "{} against {}", end, expected);
            let gone = coast.travel_under(answer);
            prop_assert!((gone - travel).abs() <= ROUNDING, "{} against {}", gone, travel);
            let (force, rounding) = (answer.mean, ROUNDING / MOBILITY);
            prop_assert!(-positive - rounding <= force && force <= negative + rounding, "{}", force);
        }

        /// Friction never makes the axis faster than both ends of the motion without it, never turns it by
        /// itself (only a push against the motion and above the limit does), and takes energy:
        /// ½·v₁² − ½·v₀² ≤ push·travel (mass 1/β), with the travel of the motion in pieces.
        #[test]
        fn exact_friction_dissipates(velocity in velocities(), push in -50.0..50.0f64, limit in 0.0..30.0f64) {
            let coast = Coast::of_mass(1.0 / MOBILITY, velocity, 1.0).under(StepForce::held(push));
            let end = coast.velocity_under(friction(coast, 1.0, |_, _| limit));
            prop_assert!(end.abs() <= velocity.abs().max(coast.free_velocity.abs()) + ROUNDING);
            let turned = push * velocity < 0.0 && push.abs() > limit;
            prop_assert!(turned || end * velocity.signum() >= -ROUNDING || velocity == 0.0, "{}", end);
            let (_, travel) = coulomb_step(velocity, push, limit, limit);
            let gained = (end * end - velocity * velocity) / (2.0 * MOBILITY);
            prop_assert!(gained <= push * travel + ROUNDING / MOBILITY, "{} against {}", gained, push * travel);
        }
    }
}
