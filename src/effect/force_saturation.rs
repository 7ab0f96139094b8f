//! Saturation: a force constant that falls with current.

use super::law::negative;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, Door, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use serde::{Deserialize, Serialize};

/// Saturation of the motor: its force grows less than in proportion to the current.
///
/// # Model
/// `F = F₀/(1 + s·|F₀|)` with `F₀ = Kt·i`, or K·u of a direct motor; at the joint. The force cannot exceed 1/s, and at F₀ = 1/s half
/// of it is lost. Where the motor has ripple as well, the relative changes of the force add up.
///
/// # Validity
/// One curve for both directions, without hysteresis. Back-EMF and inductance keep their constants. It is told where the motor's force
/// changes: at one force it is a force constant off by 1/(1 + s·|F₀|). A drive whose duty cycle or current command gives less than in
/// proportion, and a transmission whose losses grow faster than its load, look alike without a force signal.
///
/// # Prior
/// Loss at four times the rated force, the peak force of servo motors, of 3 to 40 %, log-uniform. Force over current in
/// catalogues of iron-core linear motors and of servo motors.
///
/// # Source
/// Frölich's curve of magnetisation, `B = H/(a + b·|H|)` (O. Frölich, 1881; Fitzgerald, Kingsley, Umans, *Electric Machinery*).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ForceSaturation {
    /// s in 1/N, or 1/(N·m) for a revolute axis; zero or more, 0: none.
    #[serde(alias = "saturation_per_nm")]
    pub saturation_per_n: f64,
}

impl Law for ForceSaturation {
    const SITE: Site = Site::Motor;
    const PHRASE: &'static str = "a motor force that saturates";
    const PARAMETERS: &'static [Parameter] =
        &[Parameter::differing("saturation_per_n", "saturation_per_nm", "1/N", "1/(N·m)").not_negative()];
    const DOORS: &'static [Door] = &[Door::MotorForce];

    fn fault(&self) -> Option<String> {
        negative("saturation_per_n", self.saturation_per_n)
    }

    #[inline]
    fn motor_change(&self, _position: f64, force: f64) -> f64 {
        let relative = self.saturation_per_n * force.abs();
        -relative / (1.0 + relative)
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![0.0]
    }

    const STRETCH: Stretch = Stretch::MotorForce;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "F = F₀/(1 + s·|F₀|) with F₀ = Kt·i";
    const SYMBOLS: &'static [&'static str] = &["s"];
    const SOURCE: &'static str =
        "Frölich's curve of magnetisation (1881); Fitzgerald, Kingsley, Umans, Electric Machinery";
    const SHOWN_BY: &'static str = "Motor force beside current. Without a force signal: accelerations and held weights of several sizes, which take more current than in proportion.";
    const EXAMPLE: &'static [f64] = &[5e-4];
    const CONFUSABLE: &'static [Likeness] = &[
        Likeness::similar(EffectId::ForceConstant, "where the motor's force hardly changes"),
        Likeness::similar(
            EffectId::LoadDependentFriction,
            "of a transmission that the load never drives back",
        ),
    ];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let (peak, loss) = (PEAK * machine.rated_force, prior.log_uniform(LOSS.0, LOSS.1));
        vec![loss / (1.0 - loss) / peak]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}

/// Peak force of servo motors over their rated force.
const PEAK: f64 = 4.0;
/// Share of the force in proportion to current that is lost at the peak.
const LOSS: (f64, f64) = (0.03, 0.40);

#[cfg(test)]
mod tests {
    use super::*;

    /// Half is lost at 1/s, nothing at no force, the same in both directions; the force rises with F₀ up to 1/s.
    #[test]
    fn exact_half_of_the_force_is_lost_at_its_saturation() {
        let law = ForceSaturation { saturation_per_n: 0.01 };
        let force = |f: f64| f * (1.0 + law.motor_change(0.3, f));
        assert_eq!(force(0.0), 0.0);
        assert!((force(100.0) - 50.0).abs() < 1e-12 && (force(-100.0) + 50.0).abs() < 1e-12);
        assert!((force(1e9) - 100.0).abs() < 1e-4);
        assert!((1..100).all(|k| force(f64::from(k)) > force(f64::from(k) - 1.0)));
    }
}
