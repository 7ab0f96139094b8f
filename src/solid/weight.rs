//! Weight of the moving body, as an effort along the joint.

use super::{Joint, MassProperties};
use crate::elementary::sin_cos_turns;
use crate::units::Motion;
use std::f64::consts::TAU;

/// Standard gravity, downwards along −z of the base's frame, in m/s².
pub const GRAVITY_M_PER_S2: f64 = 9.806_65;

/// Share of the weight (of the weight at the radius of gyration) up to which an effort along the joint is rounding of the
/// solid model: a level guide, a balanced disc.
const ROUNDING: f64 = 1e-12;

/// The effort that gravity exerts along the joint, as a function of the joint's position.
///
/// # Model
/// With the joint's axis a, the centre of mass c of the moving body from a point on the axis at q = 0, its part c⊥ across the
/// axis, and gravity g, all in the joint's frame:
/// ```text
///   prismatic   W    = m·g·a                                          N
///   revolute    W(q) = a·(c(q) × m·g) = m·(g·(a × c⊥)·cos q − g·c⊥·sin q)      N·m
/// ```
/// for c(q) = c⊥·cos q + (a × c⊥)·sin q + a·(a·c). Positive along (about) the joint's positive direction: a part that weight
/// pulls towards larger q has W > 0. The base's frame is that of the URDF's root link with z upwards:
/// g = −9.80665 m/s² · z.
///
/// # Validity
/// The base stands still and level as its URDF says. Of a prismatic axis m is the whole moving mass, payload included; of a
/// revolute one a payload has weight where it states a lever.
///
/// # Source
/// Siciliano, Sciavicco, Villani, Oriolo (2009), *Robotics*, ch. 7: the gravity term g(q) of the equations of motion, −W
/// here.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weight {
    constant: f64,
    by_cosine: f64,
    by_sine: f64,
}

/// Angle up to which five terms of each series are exact to rounding: the first left out is 3·10⁻¹⁷ of the cosine.
pub const SMALL_RAD: f64 = 0.1;
/// Angle up to which three terms are: the first left out is 2·10⁻¹⁷ of the cosine.
const TINY_RAD: f64 = 5e-3;

/// Sine and cosine of an angle that is mostly small: that of one step.
#[inline(always)]
fn near_zero(angle: f64) -> (f64, f64) {
    if angle.abs() > SMALL_RAD {
        angle.sin_cos()
    } else if angle.abs() < TINY_RAD {
        tiny(angle)
    } else {
        small(angle)
    }
}

/// Those of an angle up to [`TINY_RAD`].
#[inline(always)]
fn tiny(angle: f64) -> (f64, f64) {
    let square = angle * angle;
    let sine = angle * (1.0 + square * (-1.0 / 6.0 + square * (1.0 / 120.0)));
    (sine, 1.0 + square * (-0.5 + square * (1.0 / 24.0)))
}

/// Those of an angle up to [`SMALL_RAD`].
#[inline(always)]
fn small(angle: f64) -> (f64, f64) {
    // Products in the place of divisions, each of which would wait for the one before.
    let square = angle * angle;
    let sine = angle
        * (1.0
            + square
                * (-1.0 / 6.0
                    + square * (1.0 / 120.0 + square * (-1.0 / 5040.0 + square * (1.0 / 362_880.0)))));
    let cosine =
        1.0 + square * (-0.5 + square * (1.0 / 24.0 + square * (-1.0 / 720.0 + square * (1.0 / 40_320.0))));
    (sine, cosine)
}

impl Weight {
    /// Weight along the joint of a body, in the joint's frame, that effort moves as `moving_inertia` says: kg, which is what a
    /// prismatic joint carries, or kg·m². None where there is nothing beyond rounding.
    pub fn of(joint: &Joint, body: &MassProperties, moving_inertia: f64) -> Option<Self> {
        let gravity = joint.gravity();
        let axis = joint.axis.into_inner();
        let (weight, least) = match joint.motion {
            Motion::Prismatic => {
                let constant = moving_inertia * gravity.dot(&axis);
                (Self { constant, by_cosine: 0.0, by_sine: 0.0 }, moving_inertia * GRAVITY_M_PER_S2)
            }
            Motion::Revolute => {
                let across = body.centre_m - axis * axis.dot(&body.centre_m);
                let weight = Self {
                    constant: 0.0,
                    by_cosine: body.mass_kg * gravity.dot(&axis.cross(&across)),
                    by_sine: -body.mass_kg * gravity.dot(&across),
                };
                let gyration_m = (moving_inertia / body.mass_kg).sqrt();
                (weight, body.mass_kg * GRAVITY_M_PER_S2 * gyration_m)
            }
        };
        (weight.largest() > ROUNDING * least).then_some(weight)
    }

    /// Effort at a position of the joint, in N or N·m.
    #[inline]
    pub fn effort(&self, position: f64) -> f64 {
        if self.is_constant() {
            return self.constant;
        }
        let (sine, cosine) = position.sin_cos();
        self.by_cosine * cosine + self.by_sine * sine
    }

    /// The effort near a position, by the displacement from there.
    #[inline(always)]
    pub fn near(&self, position: f64) -> impl Fn(f64) -> f64 + Copy {
        let [constant, here, slope] = self.about(position);
        move |way: f64| {
            let (sine, cosine) = near_zero(way);
            constant + here * cosine + slope * sine
        }
    }

    /// The same for displacements up to [`SMALL_RAD`], without a branch: several axes go through it together.
    #[inline(always)]
    pub fn very_near(&self, position: f64) -> impl Fn(f64) -> f64 + Copy {
        let [constant, here, slope] = self.about(position);
        move |way: f64| {
            let (tiny, small) = (tiny(way), small(way));
            let is_tiny = way.abs() < TINY_RAD;
            let sine = if is_tiny { tiny.0 } else { small.0 };
            let cosine = if is_tiny { tiny.1 } else { small.1 };
            constant + here * cosine + slope * sine
        }
    }

    /// What is the same everywhere, what a cosine and what a sine of the displacement from a position makes beside it.
    #[inline(always)]
    fn about(&self, position: f64) -> [f64; 3] {
        let [sine, cosine] = sin_cos_turns(position / TAU);
        let here = self.by_cosine * cosine + self.by_sine * sine;
        [self.constant, here, self.by_sine * cosine - self.by_cosine * sine]
    }

    /// Its numbers: what is the same everywhere, what goes with the cosine and with the sine of the position.
    #[inline(always)]
    pub fn numbers(&self) -> [f64; 3] {
        [self.constant, self.by_cosine, self.by_sine]
    }

    /// The weight with these [`numbers`](Self::numbers).
    #[inline(always)]
    pub fn of_numbers([constant, by_cosine, by_sine]: [f64; 3]) -> Self {
        Self { constant, by_cosine, by_sine }
    }

    /// Whether it is the same at every position: that of a prismatic axis.
    #[inline]
    pub fn is_constant(&self) -> bool {
        self.constant != 0.0
    }

    /// Largest magnitude over all positions, in N or N·m.
    pub fn largest(&self) -> f64 {
        self.constant.abs().max(self.by_cosine.hypot(self.by_sine))
    }

    /// The position about which a revolute axis hangs at rest, in rad from −π to π; none for a prismatic axis.
    pub fn hanging_rad(&self) -> Option<f64> {
        // W(q) = A·sin(q₀ − q) with A > 0.
        (!self.is_constant()).then(|| self.by_cosine.atan2(-self.by_sine))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_the_effort_near_a_position_is_that_there() {
        let weight = Weight { constant: 0.0, by_cosine: 0.3, by_sine: -0.4 };
        for position in [-7.0, 0.0, 1.1, 2.9_f64] {
            for way in [0.0, 1e-9, -3e-3, 4.999e-3, -5.001e-3, 0.0999, -0.1, 0.2, 3.0_f64] {
                let (near, there) = (weight.near(position)(way), weight.effort(position + way));
                assert!((near - there).abs() < 5e-16, "{position} {way}: {near} against {there}");
            }
        }
        let constant = Weight { constant: 5.0, by_cosine: 0.0, by_sine: 0.0 };
        assert_eq!(constant.near(0.3)(1.0), 5.0);
    }
}
