//! Presliding: bristles that deflect before they slide.

use super::step::{Coast, StepForce};

/// Dahl's bristles.
///
/// # Model
/// The friction force f on the moving part follows its displacement:
/// ```text
///   df/dx = −σ·(1 + sgn(v)·f/F_c)
/// ```
/// so that f runs from any value towards −F_c·sgn(v) within a displacement of about F_c/σ. Over a displacement Δ,
/// exactly: `f₁ = −s·F_c + (f₀ + s·F_c)·exp(−σ|Δ|/F_c)` with s = sgn Δ.
///
/// # Validity
/// No stiction peak, no dependence on speed; hysteresis loops close. σ → ∞ is Coulomb friction.
///
/// # Source
/// Dahl (1968), *A solid friction model*, exponent 1; Åström, Canudas de Wit (2008), *Revisiting the LuGre model*.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bristle {
    /// F_c in N or N·m; more than zero.
    pub force: f64,
    /// σ in N/m or N·m/rad; more than zero.
    pub stiffness: f64,
}

const MOST_ITERATIONS: usize = 40;
/// Share of the bracket at which the displacement is known: near rounding.
const PRECISION: f64 = 1e-14;

impl Bristle {
    /// Friction force over one step and the bristles' force at its end, from the force `begun` at its beginning.
    ///
    /// The displacement solves `Δ = Δ_free + κ·f̄(Δ) + ρ·f̂(Δ)` with mean f̄ and rise f̂ of the force, both of which fall with
    /// Δ; κ > 0 outweighs ρ < 0, so there is one solution, which safeguarded Newton steps find however stiff the bristles are.
    ///
    /// ```
    /// use slideway::guide::{Bristle, Coast};
    /// let bristle = Bristle { force: 10.0, stiffness: 1e6 };
    /// // Sliding far: Coulomb friction.
    /// let (force, end) = bristle.step(-10.0, Coast::of_mass(100.0, 0.1, 1e-3));
    /// assert!((force.mean + 10.0).abs() < 1e-9 && (end + 10.0).abs() < 1e-9);
    /// ```
    pub fn step(&self, begun: f64, coast: Coast) -> (StepForce, f64) {
        // The root lies between the displacements under the extreme forces.
        let extreme = 2.0 * self.force;
        let reach = coast.response.compliance * self.force - coast.response.rise_travel * extreme;
        let (mut low, mut high) = (coast.free_travel - reach, coast.free_travel + reach);
        // Not `clamp`: a replay that has diverged to infinity must come out as such, not stop the program.
        let mut travel = coast.travel_under(StepForce::held(begun)).max(low).min(high);
        let precision = PRECISION * (high - low);
        for _ in 0..MOST_ITERATIONS {
            let (force, [mean_slope, rise_slope]) = self.over(begun, travel);
            let excess = travel - coast.travel_under(force);
            if excess > 0.0 {
                high = travel;
            } else {
                low = travel;
            }
            let slope =
                1.0 - coast.response.compliance * mean_slope - coast.response.rise_travel * rise_slope;
            let newton = travel - excess / slope;
            // Seen before the bracket is: the last steps of all end on its edge.
            if (newton - travel).abs() <= precision {
                travel = newton;
                break;
            }
            travel = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        }
        (self.over(begun, travel).0, self.after(begun, travel))
    }

    /// The force after a displacement.
    pub fn after(&self, begun: f64, travel: f64) -> f64 {
        let settled = -self.force * travel.signum();
        if travel == 0.0 {
            return begun;
        }
        settled + (begun - settled) * (-self.stiffness * travel.abs() / self.force).exp()
    }

    /// Force over a displacement gone through at an even pace, and the derivatives of its mean and rise by the displacement.
    ///
    /// Of the exponential run of the force, `rise = 12·∫₀¹ (s − ½)·f ds`: the line with the same mean and first moment.
    fn over(&self, begun: f64, travel: f64) -> (StepForce, [f64; 2]) {
        let direction = if travel < 0.0 { -1.0 } else { 1.0 };
        let offset = begun + direction * self.force;
        let rate = self.stiffness / self.force;
        let a = rate * travel.abs();
        let ([share, moment], [share_slope, moment_slope]) = shape(a);
        let force =
            StepForce { mean: -direction * self.force + offset * share, rise: 12.0 * offset * moment };
        (force, [share_slope, 12.0 * moment_slope].map(|slope| offset * slope * rate * direction))
    }
}

/// Mean and first moment about the middle of e^(−a·s) for 0 ≤ s ≤ 1, and their derivatives by a.
fn shape(a: f64) -> ([f64; 2], [f64; 2]) {
    // Below this, the closed forms take numbers near each other apart.
    const SERIES_BELOW: f64 = 1e-2;
    if a < SERIES_BELOW {
        let mean = 1.0 - a * (0.5 - a * (1.0 / 6.0 - a / 24.0));
        let mean_slope = -0.5 + a * (1.0 / 3.0 - a / 8.0);
        let moment = -a / 12.0 * (1.0 - a * (0.5 - a * 0.15));
        let moment_slope = -1.0 / 12.0 + a * (1.0 / 12.0 - a * 0.0375);
        return ([mean, moment], [mean_slope, moment_slope]);
    }
    let fallen = -(-a).exp_m1();
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

    /// Small steps of the closed form against one step, the displacement given (no mobility).
    #[test]
    fn exact_deflection_follows_the_closed_form() {
        let bristle = Bristle { force: 8.0, stiffness: 2e6 };
        let (step, velocity) = (1e-3, 2e-3);
        // Heavy enough for the displacement to be given.
        let coast = Coast::of_mass(1e30, velocity, step);
        let (_, end) = bristle.step(3.0, coast);
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
            let ([mean, moment], slopes) = shape(a);
            assert!((mean - integral(&|s| (-a * s).exp())).abs() < 1e-8);
            assert!((moment - integral(&|s| (s - 0.5) * (-a * s).exp())).abs() < 1e-8);
            assert!((slopes[0] + integral(&|s| s * (-a * s).exp())).abs() < 1e-6);
            assert!((slopes[1] + integral(&|s| s * (s - 0.5) * (-a * s).exp())).abs() < 1e-6);
        }
    }

    /// A fit may try values with which the replay diverges: the program goes on.
    #[test]
    fn exact_a_diverged_axis_is_no_panic() {
        let bristle = Bristle { force: 8.0, stiffness: 2e6 };
        for velocity in [f64::INFINITY, f64::NAN] {
            let _ = bristle.step(3.0, Coast::of_mass(100.0, velocity, 1e-3));
        }
    }

    /// A push below the friction force deflects the bristles by an amount that holds it: the axis stops.
    #[test]
    fn exact_a_small_push_is_held() {
        let bristle = Bristle { force: 10.0, stiffness: 1e6 };
        let (mass, step, drag) = (50.0, 250e-6, 4e3);
        let (mut velocity, mut force, mut position) = (0.0_f64, 0.0, 0.0);
        for _ in 0..40_000 {
            let push = StepForce::held(6.0 - drag * velocity);
            let coast = Coast::of_mass(mass, velocity, step).under(push);
            let (answer, end) = bristle.step(force, coast);
            position += coast.travel_under(answer);
            (velocity, force) = (coast.velocity_under(answer), end);
        }
        // From rest, −f = F_c·(1 − e^(−σx/F_c)) = 6 N.
        let expected = -10.0 / 1e6 * (1.0 - 0.6_f64).ln();
        assert!(velocity.abs() < 1e-9 && (force + 6.0).abs() < 1e-4, "{velocity} {force}");
        // Ringing on its way takes the loop a little beyond: it creeps no further than the first peak.
        assert!(position > 0.9 * expected && position < 2.5 * expected, "{position} against {expected}");
    }
}
