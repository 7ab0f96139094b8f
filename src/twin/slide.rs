//! The two commonest answers of dry friction, for several axes at once: it slides on, or it stays stuck.

use crate::guide::StepForce;
use crate::guide::stick_slip::AT_REST;
use crate::plant::axis::{Ahead, LANES, Lane};
use pulp::{Simd, WithSimd};

/// Friction that does not depend on speed, on axes of which nothing else acts on the guide.
///
/// The operations are those of [`friction`](crate::guide::stick_slip::friction) for an axis that keeps its direction or does
/// not move within the step; any other is left to it.
pub(super) struct SlideOrStick<'a> {
    pub ahead: Ahead<'a>,
    pub step_s: f64,
    /// Friction in the positive and the negative direction.
    pub level: &'a [Lane; 2],
}

/// Answers, and whether each is one.
pub(super) struct Answers {
    pub force: [StepForce; LANES],
    pub is_answer: [bool; LANES],
}

impl WithSimd for SlideOrStick<'_> {
    type Output = Answers;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Answers {
        let Self { ahead: Ahead { velocity, free_velocity, free_travel, mobility, inverse }, step_s, level } =
            self;
        let (mut mean, mut rise, mut known) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for k in 0..LANES {
            let holds = |force: f64| force.abs() <= if force < 0.0 { level[1][k] } else { level[0][k] };
            let v = velocity[k];
            let direction = if v < 0.0 { -1.0 } else { 1.0 };
            let limit = if v < 0.0 { level[1][k] } else { level[0][k] };
            let rests = v * direction <= AT_REST * mobility[k] * limit;
            let onward = direction * free_velocity[k] - mobility[k] * limit;
            // The other forces at the beginning and the end of the step.
            let (dv, dx) = (free_velocity[k] - v, free_travel[k] - v * step_s);
            let push = inverse[0][k] * dv + inverse[1][k] * dx;
            let change = inverse[2][k] * dv + inverse[3][k] * dx;
            let sticks = rests & holds(push - 0.5 * change) & holds(push + 0.5 * change);
            let slides = !rests & (onward >= 0.0);
            let free = (level[0][k] == 0.0) & (level[1][k] == 0.0);
            let held = inverse[0][k] * (0.0 - free_velocity[k]) + inverse[1][k] * (0.0 - free_travel[k]);
            let swing = inverse[2][k] * (0.0 - free_velocity[k]) + inverse[3][k] * (0.0 - free_travel[k]);
            mean[k] = if free {
                0.0
            } else if sticks {
                held
            } else {
                -direction * limit
            };
            rise[k] = if sticks & !free { swing } else { 0.0 };
            known[k] = if free | sticks | slides { 1.0 } else { 0.0 };
        }
        Answers {
            force: std::array::from_fn(|k| StepForce { mean: mean[k], rise: rise[k] }),
            is_answer: std::array::from_fn(|k| known[k] != 0.0),
        }
    }
}
