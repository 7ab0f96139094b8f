//! Saturation of the commanded effort and what the integral part does meanwhile.

use super::{Gains, Input, Memory};
use serde::{Deserialize, Serialize};

/// What the integral part does while the effort is clipped.
///
/// # Model
/// With v the effort before it is clipped, u = clip(v, ±u_max) and ΔI the sample's increment of the integral part I:
/// - `none`: I ← I + ΔI always. It winds up, and the axis overshoots until it is wound down again.
/// - `clamping` (conditional integration): as `none`, but I stays where |v| > u_max and ΔI has the sign of v.
/// - `back_calculation`: I ← I + ΔI + T/T_t·(u − v). Clipped for long, v settles at u_max + T_t·ΔI/T.
///
/// # Validity
/// T_t not shorter than the sample period T (one period: v is brought back to the limit at once).
///
/// # Source
/// Åström, Hägglund, *PID Controllers: Theory, Design, and Tuning*, 2nd ed. (1995), section 3.5 (both laws; T_t about the
/// integral time). Drives that say what they do: the speed loop of Texas Instruments' MCF8315C and MCF8329A disables the
/// integrator while its output is at the current limit (data sheets, speed control), which is `clamping`, held also where the
/// error would unwind it. No drive's manual that names back-calculation was found; the controller of the drives in the
/// Modelica Standard Library, `LimitedPI`, is of that kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum AntiWindup {
    /// The integral part goes on.
    #[default]
    None,
    /// The integral part stays while it would only lead deeper into the limit.
    Clamping,
    /// The integral part follows what is clipped off.
    BackCalculation {
        /// T_t in s.
        tracking_time_s: f64,
    },
}

/// A limit of the commanded effort inside the controller.
///
/// # Model
/// `u = clip(v, ±u_max)`, v being what [`Gains`] command; see [`AntiWindup`] for the integral part. An injected disturbance
/// is added behind the limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffortLimit {
    /// u_max in V.
    pub effort_limit_v: f64,
    /// What the integral part does meanwhile.
    pub anti_windup: AntiWindup,
}

impl EffortLimit {
    /// The voltage commanded for this sample by a law with these gains.
    #[inline]
    pub fn effort_v(&self, gains: &Gains, memory: &mut Memory, input: Input, period_s: f64) -> f64 {
        let before = memory.integral_v;
        let wanted = gains.effort_v(memory, input);
        let clipped = wanted.max(-self.effort_limit_v).min(self.effort_limit_v);
        match self.anti_windup {
            AntiWindup::None => {}
            AntiWindup::Clamping => {
                if wanted != clipped && (memory.integral_v - before) * wanted > 0.0 {
                    memory.integral_v = before;
                }
            }
            AntiWindup::BackCalculation { tracking_time_s } => {
                memory.integral_v += period_s / tracking_time_s * (clipped - wanted);
            }
        }
        clipped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 2e-3;
    const GAINS: Gains = Gains { position: 0.0, feedforward: 1.0, integral: 0.1, error: 1.0, velocity: 0.0 };

    fn limit(anti_windup: AntiWindup) -> EffortLimit {
        EffortLimit { effort_limit_v: 2.0, anti_windup }
    }

    /// Efforts and integral parts on velocity errors.
    fn walk(limit: EffortLimit, errors: &[f64]) -> Vec<(f64, f64)> {
        let mut memory = Memory::default();
        let one = |error: &f64| {
            let input =
                Input { position_reference: 0.0, velocity_reference: *error, position: 0.0, velocity: 0.0 };
            (limit.effort_v(&GAINS, &mut memory, input, PERIOD_S), memory.integral_v)
        };
        errors.iter().map(one).collect()
    }

    #[test]
    fn exact_without_it_the_integral_part_winds_up() {
        let found = walk(limit(AntiWindup::None), &[10.0; 30]);
        // ΔI = 1 a sample.
        assert!((found[29].1 - 30.0).abs() < 1e-12 && found.iter().all(|(u, _)| *u == 2.0));
    }

    #[test]
    fn exact_clamping_holds_and_lets_go() {
        let found = walk(limit(AntiWindup::Clamping), &[[10.0; 30], [-0.5; 30]].concat());
        assert!(found[..30].iter().all(|(u, integral)| *u == 2.0 && *integral == 0.0));
        // The first error of the other sign acts at once: u = −0.05 − 0.5.
        assert!((found[30].0 + 0.55).abs() < 1e-12, "{}", found[30].0);
        // Deep in the limit by a wound-up integral part, an error that unwinds it is integrated.
        let (law, mut memory) =
            (limit(AntiWindup::Clamping), Memory { integral_v: 5.0, ..Memory::default() });
        let back = Input { position_reference: 0.0, velocity_reference: -1.0, position: 0.0, velocity: 0.0 };
        assert_eq!(law.effort_v(&GAINS, &mut memory, back, PERIOD_S), 2.0);
        assert!((memory.integral_v - 4.9).abs() < 1e-12);
    }

    #[test]
    fn exact_back_calculation_settles_where_its_equation_says() {
        let tracking_time_s = 20e-3;
        let found = walk(limit(AntiWindup::BackCalculation { tracking_time_s }), &[10.0; 400]);
        // v − u_max = T_t·ΔI/T = 10, with v = I_before + ΔI + 10 and I the value behind the tracking.
        let (_, integral) = found[399];
        assert!((integral + 10.0 + 1.0 - (2.0 + 10.0)).abs() < 1e-9, "{integral}");
        // One period of tracking brings v back to the limit at once.
        let at_once = walk(limit(AntiWindup::BackCalculation { tracking_time_s: PERIOD_S }), &[10.0; 3]);
        assert!(at_once.iter().all(|(_, integral)| (integral - (2.0 - 10.0)).abs() < 1e-12));
    }

    #[test]
    fn exact_inside_the_limit_every_law_is_the_linear_one() {
        let errors: Vec<f64> = (0..50).map(|k| 0.3 * f64::from(k).sin()).collect();
        let linear = walk(EffortLimit { effort_limit_v: f64::INFINITY, ..limit(AntiWindup::None) }, &errors);
        for kind in [AntiWindup::Clamping, AntiWindup::BackCalculation { tracking_time_s: 0.01 }] {
            assert_eq!(walk(limit(kind), &errors), linear);
        }
    }
}
