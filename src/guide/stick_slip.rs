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
/// 2. It would come to rest at the fraction θ of the step and stay: v₁ = 0.
/// 3. It comes to rest and goes on in the other direction for the fraction 1 − θ.
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
/// let sliding = Coast { velocity: 1.0, free_velocity: 1.0, mobility: 1e-3 };
/// assert_eq!(friction(sliding, coulomb), -10.0);
/// let pushed = Coast { velocity: 0.0, free_velocity: 5e-3, mobility: 1e-3 };
/// assert_eq!(friction(pushed, coulomb), -5.0);
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
    let breakaway = resistance(-direction, 0.0);
    if pull <= breakaway {
        return stop;
    }
    let onward = (1.0 - until_rest) * mobility * (pull - breakaway);
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

    proptest! {
        /// Friction never adds energy and never exceeds its limit.
        #[test]
        fn exact_friction_dissipates(velocity in -1.0..1.0f64, push in -50.0..50.0f64, limit in 0.0..30.0f64) {
            let mobility = 1e-3;
            let coast = Coast { velocity, free_velocity: velocity + mobility * push, mobility };
            let force = friction(coast, |_, _| limit);
            let end = coast.free_velocity + mobility * force;
            prop_assert!(force.abs() <= limit * (1.0 + 1e-12) + 1e-9);
            prop_assert!(force * 0.5 * (velocity + end) <= 1e-9);
        }
    }
}
