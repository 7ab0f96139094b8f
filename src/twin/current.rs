//! The motor's force within a step, between those at its ends.

use crate::drive::motor::Circuit;

/// Of times shorter than so many time constants of the winding the ramp is taken by its series.
const FEW_DECAYS: f64 = 0.1;

/// What the motor's force is at one point of a step.
///
/// # Model
/// At the share s of a step h, with F₀ and F₁ at its ends as they would be without other forces, Δv what the velocity changes by under the motor's
/// force, and Δw what the other forces add to that:
/// ```text
///   F(s) = F₀ + c·(F₁ − F₀) + (r(s) − c·r(1))·Δv + r(s)·Δw
///   c = (1 − e^(−s·d))/(1 − e^(−d))      d = R·h/L
///   r(s) = −(Kt·Ke·h/L)·(s·d − 1 + e^(−s·d))/d²
/// ```
/// c is the share of its change that the current makes under a held voltage; r is the change of the motor's force at s per change of velocity over the step, and negative. Of a plant
/// whose F₁ includes what the other forces do, Δw counts as Δv does.
///
/// # Validity
/// Voltage and acceleration are constant over the step. The force of a direct motor is linear between its ends.
///
/// # Source
/// L·di/dt = u − R·i − Ke·v with v linear in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CurrentWithin {
    /// c.
    pub changed: f64,
    /// r(s) − c·r(1), in N·s/m or N·m·s/rad.
    pub bow: f64,
    /// r(s), in N·s/m or N·m·s/rad; r(s) − c·r(1) where F₁ includes what the other forces do.
    pub by_velocity: f64,
}

impl CurrentWithin {
    /// At a share of a step of `step_s`, in s; `includes_others`: F₁ includes what the other forces do.
    pub fn of(circuit: &Circuit, share: f64, step_s: f64, includes_others: bool) -> Self {
        let Circuit::Winding { resistance_ohm, inductance_h, force_constant, back_emf } = *circuit else {
            return Self { changed: share, bow: 0.0, by_velocity: 0.0 };
        };
        let decays = resistance_ohm / inductance_h * step_s;
        let taken = |share: f64| -force_constant * back_emf * step_s / inductance_h * ramp(share, decays);
        let changed = changed(share, decays);
        let bow = taken(share) - changed * taken(1.0);
        Self { changed, bow, by_velocity: if includes_others { bow } else { taken(share) } }
    }
}

/// (1 − e^(−s·d))/(1 − e^(−d)).
fn changed(share: f64, decays: f64) -> f64 {
    if decays == 0.0 { share } else { (-decays * share).exp_m1() / (-decays).exp_m1() }
}

/// (s·d − 1 + e^(−s·d))/d².
fn ramp(share: f64, decays: f64) -> f64 {
    let x = share * decays;
    if x < FEW_DECAYS {
        share * share * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x / 120.0)))
    } else {
        (x + (-x).exp_m1()) / (decays * decays)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A winding under a held voltage on an axis of constant acceleration, integrated by the midpoint rule in ten thousand steps, whose error is below 10⁻⁵ of what back-EMF does.
    #[test]
    fn exact_the_force_within_a_step_is_that_of_the_winding() {
        let (step_s, resistance_ohm, force_constant, back_emf) = (250e-6, 3.1, 52.0, 34.0);
        let (voltage, velocity, change, current) = (20.0, 0.1, 0.02, 1.5);
        for inductance_h in [40e-3, 3.4e-3, 0.3e-3] {
            let circuit = Circuit::Winding { resistance_ohm, inductance_h, force_constant, back_emf };
            let force = |until: f64, change: f64| {
                const STEPS: u32 = 10_000;
                let h = until * step_s / f64::from(STEPS);
                let rate = |i: f64, t: f64| {
                    (voltage - resistance_ohm * i - back_emf * (velocity + change * t / step_s))
                        / inductance_h
                };
                let mut i = current;
                for k in 0..STEPS {
                    let t = f64::from(k) * h;
                    let middle = i + 0.5 * h * rate(i, t);
                    i += h * rate(middle, t + 0.5 * h);
                }
                force_constant * i
            };
            for (share, added) in [(0.2113, 0.0), (0.7887, 0.0), (0.2113, -0.015), (0.7887, -0.015)] {
                let within = CurrentWithin::of(&circuit, share, step_s, false);
                let [begin, end] = [force(0.0, change), force(1.0, change)];
                let told =
                    begin + within.changed * (end - begin) + within.bow * change + within.by_velocity * added;
                let exact = force(share, change + added);
                let bow = within.bow.abs() * change + within.by_velocity.abs() * added.abs();
                assert!((told - exact).abs() < 1e-4 * bow, "{inductance_h} H: {told} against {exact}");
                let with_others = CurrentWithin::of(&circuit, share, step_s, true);
                let end = force(1.0, change + added);
                let told = begin
                    + with_others.changed * (end - begin)
                    + with_others.bow * change
                    + with_others.by_velocity * added;
                assert!((told - exact).abs() < 1e-4 * bow, "with the others: {told} against {exact}");
            }
        }
    }
}
