//! A base mode off its stated value.

use super::law::not_positive;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::base::{Mode, Modes};
use serde::{Deserialize, Serialize};

/// A mode of the base whose frequency or modal mass is not the stated one: other feet, a loose bolt, another floor.
///
/// # Model
/// Mode j of the stated ones has `f_j = a·f_j,stated` and `M_j = b·M_j,stated`; its damping ratio stays.
///
/// # Validity
/// One mode is off; which one is tried in turn. A mode that is not listed at all is another effect.
///
/// # Prior
/// j any of the stated modes; a of 0.6 to 1.4, uniform: a support down to a third as stiff, or up to twice, as a loose foot or
/// another floor makes it. b of 0.8 to 1.25, log-uniform: the shape changes with the support. Rivin (2003), *Passive Vibration
/// Isolation*, on mounts and their stiffness; Altintas et al. (2011), *Machine tool feed drives*, on modes of 8 to 400 Hz.
///
/// # Source
/// [`Modes`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BaseModeShift {
    /// j, counted from 1 in the order of the machine file.
    pub mode: f64,
    /// a, factor of the frequency; more than zero.
    pub frequency_factor: f64,
    /// b, factor of the modal mass; more than zero.
    pub mass_factor: f64,
}

impl Law for BaseModeShift {
    const SITE: Site = Site::Structure;
    const PHRASE: &'static str = "a base mode off its stated value";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::same("mode", "1").held().within(1.0, f64::INFINITY),
        Parameter::same("frequency_factor", "1").positive(),
        Parameter::same("mass_factor", "1").positive(),
    ];

    fn fault(&self) -> Option<String> {
        let counts = self.mode >= 1.0 && self.mode.fract() == 0.0;
        (!counts)
            .then(|| format!("mode = {}, expected a whole number from 1", self.mode))
            .or_else(|| not_positive("frequency_factor", self.frequency_factor))
            .or_else(|| not_positive("mass_factor", self.mass_factor))
    }

    fn alter(&self, constants: &mut Constants) {
        let moved = |(k, mode): (usize, &Mode)| {
            let (frequency, mass) = if k + 1 == self.mode as usize {
                (self.frequency_factor, self.mass_factor)
            } else {
                (1.0, 1.0)
            };
            let (frequency, mass) = (mode.frequency_hz() * frequency, mode.mass_kg() * mass);
            // A factor that `fault` lets through leaves a mode that is one.
            Mode::new(frequency, mass, mode.damping_ratio()).unwrap_or(*mode)
        };
        constants.modes = Modes::new(constants.modes.as_slice().iter().enumerate().map(moved).collect());
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![f64::NAN, 1.0, 1.0]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(constants: &Constants) -> Option<Lack> {
        constants.modes.is_empty().then_some(Lack::NothingToChange)
    }

    const EQUATION: &'static str = "f_j = a·f_j,stated\nM_j = b·M_j,stated";
    const SYMBOLS: &'static [&'static str] = &["j", "a", "b"];
    const SOURCE: &'static str = "the modes that the machine file states";
    const SHOWN_BY: &'static str = "Ringing after changes of the acceleration, at another frequency or size than stated: quick strokes with dwells.";
    const EXAMPLE: &'static [f64] = &[1.0, 0.6, 1.0];
    const CONFUSABLE: &'static [Likeness] = &[Likeness::similar(
        EffectId::FlexibleMode,
        "in most recordings: a shifted mode and one mode more ring at the same frequency",
    )];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let modes = u32::try_from(machine.constants.modes.len()).unwrap_or(1);
        vec![prior.integer(1, modes), prior.uniform(0.6, 1.4), prior.log_uniform(0.8, 1.25)]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
