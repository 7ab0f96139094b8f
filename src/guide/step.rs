//! Forces over one step, and how the step would end without those of the guide.

use std::ops::Add;

/// A force over one step as mean and rise (first-order hold).
///
/// # Model
/// `F(t) = mean + rise·(t/h − ½)` for 0 ≤ t ≤ h. The mean sets the velocity at the end of the step; the rise moves the
/// position by about `−rise·h²/(12·m)` and leaves the velocity (nearly) as it is.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StepForce {
    /// Mean over the step, N or N·m.
    pub mean: f64,
    /// Force at the end less force at the beginning, N or N·m.
    pub rise: f64,
}

/// Shares of a step at which two values tell mean and first moment of a cubic: ½ ∓ √3/6.
pub const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

impl StepForce {
    /// No force.
    pub const ZERO: Self = Self { mean: 0.0, rise: 0.0 };

    /// A constant force.
    pub const fn held(mean: f64) -> Self {
        Self { mean, rise: 0.0 }
    }

    /// The force with these values at the two [`GAUSS`] points of the step (Gauss and Legendre's rule): exact in mean and
    /// first moment for a cubic run.
    #[inline(always)]
    pub fn at_gauss(first: f64, second: f64) -> Self {
        Self { mean: 0.5 * (first + second), rise: 3.0_f64.sqrt() * (second - first) }
    }

    /// The force that moves linearly from its value at the beginning to that at the end.
    pub fn between(begin: f64, end: f64) -> Self {
        Self { mean: 0.5 * (begin + end), rise: end - begin }
    }
}

impl Add for StepForce {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { mean: self.mean + other.mean, rise: self.rise + other.rise }
    }
}

/// What a [`StepForce`] changes of the end of a step.
///
/// # Model
/// Over one step a plant is linear in the guide's force:
/// ```text
///   Δv = mobility·mean   + rise_mobility·rise
///   Δx = compliance·mean + rise_travel·rise
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Change of the velocity at the end per unit of mean force; > 0.
    pub mobility: f64,
    /// Change of the displacement per unit of mean force; > 0.
    pub compliance: f64,
    /// Change of the velocity at the end per unit of rise; nearly 0.
    pub rise_mobility: f64,
    /// Change of the displacement per unit of rise; < 0.
    pub rise_travel: f64,
    /// The inverse, row by row.
    inverse: [f64; 4],
}

impl Response {
    /// The response with these four numbers.
    pub fn new(mobility: f64, compliance: f64, rise_mobility: f64, rise_travel: f64) -> Self {
        let determinant = mobility * rise_travel - compliance * rise_mobility;
        let inverse = [rise_travel, -rise_mobility, -compliance, mobility].map(|x| x / determinant);
        Self { mobility, compliance, rise_mobility, rise_travel, inverse }
    }

    /// Its numbers, the inverse last.
    #[inline(always)]
    pub(crate) fn numbers(&self) -> [f64; 8] {
        let Self { mobility, compliance, rise_mobility, rise_travel, inverse: [a, b, c, d] } = *self;
        [mobility, compliance, rise_mobility, rise_travel, a, b, c, d]
    }

    /// The response with these [`numbers`](Self::numbers).
    #[inline(always)]
    pub(crate) fn of_numbers(
        [mobility, compliance, rise_mobility, rise_travel, inverse @ ..]: [f64; 8],
    ) -> Self {
        Self { mobility, compliance, rise_mobility, rise_travel, inverse }
    }

    /// The inverse: mean by velocity and displacement, rise by velocity and displacement.
    pub fn inverse(&self) -> [f64; 4] {
        self.inverse
    }

    /// The force that changes velocity and displacement so.
    #[inline(always)]
    pub fn force(&self, velocity: f64, travel: f64) -> StepForce {
        StepForce {
            mean: self.inverse[0] * velocity + self.inverse[1] * travel,
            rise: self.inverse[2] * velocity + self.inverse[3] * travel,
        }
    }
}

/// How a step would end without friction and position forces of the guide, and what the guide's force changes of that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coast {
    /// Velocity of the moving part relative to the base at the beginning of the step.
    pub velocity: f64,
    /// Velocity at the end of the step.
    pub free_velocity: f64,
    /// Displacement over the step.
    pub free_travel: f64,
    /// The motor's own force at the beginning and at the end of the step, N or N·m.
    pub motor_force: [f64; 2],
    /// What a force of the guide changes.
    pub response: Response,
}

/// Displacement in m or rad until a share of a step of `step_s`, of a motion with these velocities (m/s or rad/s) at the step's ends: that of the parabola with these velocities,
/// shifted to the step's own displacement `travel` in proportion to the share.
#[inline(always)]
pub(crate) fn travel_until(share: f64, step_s: f64, [begin, end]: [f64; 2], travel: f64) -> f64 {
    share * (travel - 0.5 * (1.0 - share) * (end - begin) * step_s)
}

impl Coast {
    /// A body of this mass (or inertia) that moves freely at a velocity, over a step of `step_s`.
    ///
    /// ```
    /// use slideway::guide::Coast;
    /// let coast = Coast::of_mass(2.0, 0.1, 1e-3);
    /// assert_eq!((coast.velocity, coast.free_velocity), (0.1, 0.1));
    /// assert!((coast.response.mobility - 5e-4).abs() < 1e-18);
    /// assert!((coast.response.compliance - 2.5e-7).abs() < 1e-18);
    /// ```
    pub fn of_mass(mass: f64, velocity: f64, step_s: f64) -> Self {
        let square = step_s * step_s / mass;
        Self {
            velocity,
            free_velocity: velocity,
            free_travel: velocity * step_s,
            motor_force: [0.0; 2],
            response: Response::new(step_s / mass, 0.5 * square, 0.0, -square / 12.0),
        }
    }

    /// Displacement until a share of a step of `step_s`, without friction: that of the parabola with the same velocities at
    /// its ends.
    #[inline(always)]
    pub fn free_travel_until(&self, share: f64, step_s: f64) -> f64 {
        travel_until(share, step_s, [self.velocity, self.free_velocity], self.free_travel)
    }

    /// A force of position over the step, which begins at `position`, taken at the [`GAUSS`] points of the way as it would
    /// be without friction.
    #[inline(always)]
    pub fn force_over(&self, position: f64, step_s: f64, force: impl Fn(f64) -> f64) -> StepForce {
        let at = |share: f64| force(position + self.free_travel_until(share, step_s));
        StepForce::at_gauss(at(GAUSS[0]), at(GAUSS[1]))
    }

    /// The same step with a force more that acts whatever the guide does; the motor's own force is not told apart any more.
    #[must_use]
    #[inline(always)]
    pub fn under(self, force: StepForce) -> Self {
        Self {
            free_velocity: self.velocity_under(force),
            free_travel: self.travel_under(force),
            motor_force: [0.0; 2],
            ..self
        }
    }

    /// Velocity at the end of the step under a guide force.
    #[inline(always)]
    pub fn velocity_under(&self, force: StepForce) -> f64 {
        self.free_velocity + self.response.mobility * force.mean + self.response.rise_mobility * force.rise
    }

    /// Displacement over the step under a guide force.
    #[inline(always)]
    pub fn travel_under(&self, force: StepForce) -> f64 {
        self.free_travel + self.response.compliance * force.mean + self.response.rise_travel * force.rise
    }

    /// The guide force that ends the step with this velocity after this displacement.
    #[inline(always)]
    pub fn force_to(&self, velocity: f64, travel: f64) -> StepForce {
        self.response.force(velocity - self.free_velocity, travel - self.free_travel)
    }

    /// The forces but the guide's, as those that make of an even motion what the step is without the guide's.
    #[inline(always)]
    pub fn push(&self, step_s: f64) -> StepForce {
        self.response.force(self.free_velocity - self.velocity, self.free_travel - self.velocity * step_s)
    }
}
