//! The two commonest answers of dry friction, for several axes at once: it slides on, or it stays stuck.

use super::kernel::{LANES, Lane};
use crate::guide::stick_slip::AT_REST;
use pulp::{Simd, WithSimd};

/// Friction that does not depend on speed, on axes of which nothing else acts on the guide.
///
/// The operations are those of [`friction`](crate::guide::stick_slip::friction) for an axis that keeps its direction or does
/// not move within the step; any other is left to it.
pub(super) struct SlideOrStick<'a> {
    pub velocity: &'a Lane,
    pub free_velocity: &'a Lane,
    pub free_travel: &'a Lane,
    pub mobility: &'a Lane,
    /// See [`Response::force`](crate::guide::Response::force).
    pub inverse: &'a [Lane; 4],
    pub step_s: f64,
    /// Friction in the positive and the negative direction.
    pub level: &'a [Lane; 2],
}

/// Mean and rise of the friction, and whether that is the answer (1) or not (0).
pub(super) struct Answers {
    pub mean: Lane,
    pub rise: Lane,
    pub is_answer: Lane,
}

impl WithSimd for SlideOrStick<'_> {
    type Output = Answers;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Answers {
        // Values of their own, not places: nothing then keeps the loop from being vectors.
        let (velocity, free_velocity, free_travel) = (*self.velocity, *self.free_velocity, *self.free_travel);
        let (mobility, inverse, [forward, backward]) = (*self.mobility, *self.inverse, *self.level);
        let (mut mean, mut rise, mut is_answer) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for k in 0..LANES {
            let holds = |force: f64| force.abs() <= if force < 0.0 { backward[k] } else { forward[k] };
            let v = velocity[k];
            let direction = if v < 0.0 { -1.0 } else { 1.0 };
            let limit = if v < 0.0 { backward[k] } else { forward[k] };
            let rests = v * direction <= AT_REST * mobility[k] * limit;
            let onward = direction * free_velocity[k] - mobility[k] * limit;
            // The other forces at the beginning and the end of the step.
            let (dv, dx) = (free_velocity[k] - v, free_travel[k] - v * self.step_s);
            let push = inverse[0][k] * dv + inverse[1][k] * dx;
            let change = inverse[2][k] * dv + inverse[3][k] * dx;
            let sticks = rests & holds(push - 0.5 * change) & holds(push + 0.5 * change);
            let slides = !rests & (onward >= 0.0);
            let free = (forward[k] == 0.0) & (backward[k] == 0.0);
            let held = inverse[0][k] * (0.0 - free_velocity[k]) + inverse[1][k] * (0.0 - free_travel[k]);
            let swing = inverse[2][k] * (0.0 - free_velocity[k]) + inverse[3][k] * (0.0 - free_travel[k]);
            let answer = if sticks { held } else { -direction * limit };
            mean[k] = if free { 0.0 } else { answer };
            rise[k] = if sticks & !free { swing } else { 0.0 };
            is_answer[k] = if free | sticks | slides { 1.0 } else { 0.0 };
        }
        Answers { mean, rise, is_answer }
    }
}
