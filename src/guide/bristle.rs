//! Presliding: bristles that deflect before they slide.

use super::stick_slip::Coast;

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

impl Bristle {
    /// Mean friction force over one step of `step_s` and the bristles' force at its end, from the force `begun` at
    /// its beginning.
    ///
    /// The displacement solves `Δ = h/2·(v₀ + v_free + β·f̄(Δ))`; f̄ falls with Δ, so there is one solution, which
    /// safeguarded Newton steps find however stiff the bristles are.
    ///
    /// ```
    /// use slideway::guide::{Bristle, stick_slip::Coast};
    /// let bristle = Bristle { force: 10.0, stiffness: 1e6 };
    /// // Sliding far: Coulomb friction.
    /// let sliding = Coast { velocity: 0.1, free_velocity: 0.1, mobility: 1e-5 };
    /// let (mean, end) = bristle.step(-10.0, sliding, 1e-3);
    /// assert!((mean + 10.0).abs() < 1e-9 && (end + 10.0).abs() < 1e-9);
    /// ```
    pub fn step(&self, begun: f64, coast: Coast, step_s: f64) -> (f64, f64) {
        let half = 0.5 * step_s;
        let target = |mean: f64| half * (coast.velocity + coast.free_velocity + coast.mobility * mean);
        // The root lies between the displacements under the extreme mean forces.
        let (mut low, mut high) = (target(-self.force), target(self.force));
        // Not `clamp`: a replay that has diverged to infinity must come out as such, not stop the program.
        let mut travel = target(begun).max(low).min(high);
        for _ in 0..MOST_ITERATIONS {
            let (mean, slope) = self.mean(begun, travel);
            let excess = travel - target(mean);
            if excess > 0.0 {
                high = travel;
            } else {
                low = travel;
            }
            let newton = travel - excess / (1.0 - half * coast.mobility * slope);
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            let arrived = (next - travel).abs() <= 1e-12 * (high - low).abs().max(travel.abs());
            travel = next;
            if arrived || excess == 0.0 {
                break;
            }
        }
        (self.mean(begun, travel).0, self.after(begun, travel))
    }

    /// The force after a displacement.
    pub fn after(&self, begun: f64, travel: f64) -> f64 {
        let settled = -self.force * travel.signum();
        if travel == 0.0 {
            return begun;
        }
        settled + (begun - settled) * (-self.stiffness * travel.abs() / self.force).exp()
    }

    /// Mean force over a displacement, and its derivative by the displacement.
    fn mean(&self, begun: f64, travel: f64) -> (f64, f64) {
        let direction = if travel < 0.0 { -1.0 } else { 1.0 };
        let offset = begun + direction * self.force;
        let rate = self.stiffness / self.force;
        let a = rate * travel.abs();
        let (share, share_slope) = if a < 1e-4 {
            (1.0 - 0.5 * a, -0.5 + a / 3.0)
        } else {
            let fallen = -(-a).exp_m1();
            (fallen / a, ((-a).exp() * a - fallen) / (a * a))
        };
        (-direction * self.force + offset * share, offset * share_slope * rate * direction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Small steps of the closed form against one step, the displacement given (no mobility).
    #[test]
    fn exact_deflection_follows_the_closed_form() {
        let bristle = Bristle { force: 8.0, stiffness: 2e6 };
        let (step, velocity) = (1e-3, 2e-3);
        let coast = Coast { velocity, free_velocity: velocity, mobility: 0.0 };
        let (_, end) = bristle.step(3.0, coast, step);
        let expected = -8.0 + 11.0 * (-2e6 * velocity * step / 8.0_f64).exp();
        assert!((end - expected).abs() < 1e-9, "{end} against {expected}");
    }

    /// A fit may try values with which the replay diverges: the program goes on.
    #[test]
    fn exact_a_diverged_axis_is_no_panic() {
        let bristle = Bristle { force: 8.0, stiffness: 2e6 };
        for velocity in [f64::INFINITY, f64::NAN] {
            let coast = Coast { velocity, free_velocity: -velocity, mobility: 1e-5 };
            let _ = bristle.step(3.0, coast, 1e-3);
        }
    }

    /// A push below the friction force deflects the bristles by an amount that holds it: the axis stops.
    #[test]
    fn exact_a_small_push_is_held() {
        let bristle = Bristle { force: 10.0, stiffness: 1e6 };
        let (mass, step, drag) = (50.0, 250e-6, 4e3);
        let (mut velocity, mut force, mut position) = (0.0_f64, 0.0, 0.0);
        for _ in 0..40_000 {
            let coast = Coast {
                velocity,
                free_velocity: velocity + step / mass * (6.0 - drag * velocity),
                mobility: step / mass,
            };
            let (mean, end) = bristle.step(force, coast, step);
            let after = coast.free_velocity + coast.mobility * mean;
            position += 0.5 * step * (velocity + after);
            (velocity, force) = (after, end);
        }
        // From rest, −f = F_c·(1 − e^(−σx/F_c)) = 6 N.
        let expected = -10.0 / 1e6 * (1.0 - 0.6_f64).ln();
        assert!(velocity.abs() < 1e-9 && (force + 6.0).abs() < 1e-4, "{velocity} {force}");
        // Ringing on its way takes the loop a little beyond: it creeps no further than the first peak.
        assert!(position > 0.9 * expected && position < 2.5 * expected, "{position} against {expected}");
    }
}
