//! Implicit stick–slip: the friction force over one step, sticking included.

/// How the guide would move over one step, and how much a force changes that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coast {
    /// Velocity of the moving part relative to the base at the beginning of the step.
    pub velocity: f64,
    /// Velocity at the end of the step without guide friction.
    pub free_velocity: f64,
    /// Change of the velocity at the end of the step per unit of force held over the step; > 0.
    pub mobility: f64,
}

/// Friction force, held over the step, that the guide answers with.
///
/// # Model
/// Dry friction is a set-valued law, `F ∈ −R(s, |v|)·Sgn(v)`: at rest any force up to the breakaway value
/// R(s, 0) holds. Over one step of a plant that is linear otherwise, velocity ends at
/// `v₁ = v_free + β·F`. Three cases:
///
/// 1. The axis keeps its direction s: `v₁ = v_free − s·β·R(s, ½(|v₀| + |v₁|))`, a scalar equation (midpoint
///    speed makes it second order in the step; exact for Coulomb friction).
/// 2. It comes to rest at the fraction `θ = |v₀|/(β·(P + R(s, ½|v₀|)))` of the step, where P is the mean of the
///    other forces against s, and P ≤ R(−s, 0) holds it there: v₁ = 0.
/// 3. It comes to rest at θ and goes on in the other direction:
///    `v₁ = −s·(1 − θ)·β·(P − R(−s, ½|v₁|))`.
///
/// The answer is the mean of the friction force over the step, in [−R(s), R(−s)]. In a step that comes to rest,
/// it may point along v₀: the part that holds is then larger than the part that brakes.
///
/// `resistance(direction, speed)` is R ≥ 0. Positive force acts along positive position.
///
/// # Validity
/// Resistance varying little over the velocity change of one step; direction changes at most once a step.
///
/// # Source
/// Moreau's time stepping for dry friction (Acary, Brogliato 2008, ch. 10), with the reversal resolved inside
/// the step.
///
/// ```
/// use slideway::guide::stick_slip::{friction, Coast};
/// let coulomb = |_direction: f64, _speed: f64| 10.0;
/// // Sliding: the full 10 N oppose. At rest below 10 N: friction balances the rest exactly.
/// // The force is a difference of velocities over β: rounding is 1e-16·v/β, some 1e-13 N here.
/// let near = |force: f64, expected: f64| (force - expected).abs() < 1e-9;
/// let sliding = Coast { velocity: 1.0, free_velocity: 1.0, mobility: 1e-3 };
/// assert!(near(friction(sliding, coulomb), -10.0));
/// let pushed = Coast { velocity: 0.0, free_velocity: 5e-3, mobility: 1e-3 };
/// assert!(near(friction(pushed, coulomb), -5.0));
/// ```
#[inline]
pub fn friction(coast: Coast, resistance: impl Fn(f64, f64) -> f64) -> f64 {
    let Coast { velocity, free_velocity, mobility } = coast;
    let stop = -free_velocity / mobility;
    if velocity == 0.0 {
        return from_rest(coast, stop, &resistance);
    }
    let direction = velocity.signum();
    let speed = velocity * direction;
    let onward = slide(direction * free_velocity, speed, mobility, |w| resistance(direction, w));
    if onward >= 0.0 {
        return (direction * onward - free_velocity) / mobility;
    }
    // It comes to rest inside the step, at the fraction `until_rest` of it (velocity falls linearly).
    let until_rest = speed / (speed - onward);
    let pull = direction * (velocity - free_velocity) / mobility; // the other forces, against the old motion
    if pull <= resistance(-direction, 0.0) {
        return stop;
    }
    let rest_of_step = (1.0 - until_rest) * mobility;
    let onward = slide(rest_of_step * pull, 0.0, rest_of_step, |w| resistance(-direction, w)).max(0.0);
    (-direction * onward - free_velocity) / mobility
}

fn from_rest(coast: Coast, stop: f64, resistance: &impl Fn(f64, f64) -> f64) -> f64 {
    let Coast { free_velocity, mobility, .. } = coast;
    let direction = free_velocity.signum();
    if stop.abs() <= resistance(direction, 0.0) {
        return stop;
    }
    let onward = slide(direction * free_velocity, 0.0, mobility, |w| resistance(direction, w)).max(0.0);
    (direction * onward - free_velocity) / mobility
}

/// Speed at the end of a step that keeps its direction; negative when it would not.
fn slide(free_speed: f64, speed: f64, mobility: f64, resistance: impl Fn(f64) -> f64) -> f64 {
    const ITERATIONS: usize = 4;
    let mut end = free_speed - mobility * resistance(speed);
    for _ in 0..ITERATIONS {
        let middle = 0.5 * (speed + end.max(0.0));
        let next = free_speed - mobility * resistance(middle);
        // Fixed-point steps contract by β·|R'|/2, which is 10⁻² and less at servo sample rates.
        if (next - end).abs() <= 1e-15 * speed.max(free_speed.abs()) {
            return next;
        }
        end = next;
    }
    end
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
            let coast = Coast { velocity, free_velocity: velocity, mobility: step / mass };
            let end = velocity + coast.mobility * friction(coast, |_, _| force);
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
            let coast = Coast { velocity, free_velocity: velocity + gravity * step, mobility: step / mass };
            velocity += gravity * step + coast.mobility * friction(coast, |_, _| force);
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
                let coast = Coast { velocity, free_velocity: velocity + push * step, mobility: step };
                velocity += push * step + step * friction(coast, resistance);
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

    proptest! {
        /// A step under a constant push is the closed form: slide, stop, stick or reverse.
        #[test]
        fn exact_coulomb_step_is_the_closed_form(
            velocity in velocities(),
            push in -50.0..50.0f64,
            positive in 0.0..30.0f64,
            negative in 0.0..30.0f64,
        ) {
            let coast = Coast { velocity, free_velocity: velocity + MOBILITY * push, mobility: MOBILITY };
            let force = friction(coast, |direction, _| if direction > 0.0 { positive } else { negative });
            let (expected, _) = coulomb_step(velocity, push, positive, negative);
            let end = coast.free_velocity + MOBILITY * force;
            prop_assert!((end - expected).abs() <= ROUNDING, "{} against {}", end, expected);
            let rounding = ROUNDING / MOBILITY;
            prop_assert!(-positive - rounding <= force && force <= negative + rounding, "{}", force);
        }

        /// Friction never makes the axis faster than both ends of the motion without it, never turns it by
        /// itself (only a push against the motion and above the limit does), and takes energy:
        /// ½·v₁² − ½·v₀² ≤ push·travel (mass 1/β), with the travel of the motion in pieces.
        #[test]
        fn exact_friction_dissipates(velocity in velocities(), push in -50.0..50.0f64, limit in 0.0..30.0f64) {
            let coast = Coast { velocity, free_velocity: velocity + MOBILITY * push, mobility: MOBILITY };
            let end = coast.free_velocity + MOBILITY * friction(coast, |_, _| limit);
            prop_assert!(end.abs() <= velocity.abs().max(coast.free_velocity.abs()) + ROUNDING);
            let turned = push * velocity < 0.0 && push.abs() > limit;
            prop_assert!(turned || end * velocity.signum() >= -ROUNDING || velocity == 0.0, "{}", end);
            let (_, travel) = coulomb_step(velocity, push, limit, limit);
            let gained = (end * end - velocity * velocity) / (2.0 * MOBILITY);
            prop_assert!(gained <= push * travel + ROUNDING / MOBILITY, "{} against {}", gained, push * travel);
        }
    }
}
