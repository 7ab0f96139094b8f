//! Viscous friction of the guide off its stated value.

use super::law::negative;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use serde::{Deserialize, Serialize};

/// Viscous friction whose coefficient is not the stated one.
///
/// # Model
/// `F(v) = −c·v`, with c taking the place of the guide's stated coefficient.
/// Positive force acts along positive position.
///
/// # Validity
/// Hydrodynamic drag of grease, seals and wipers at constant temperature. Part of the twin's linear
/// dynamics, so it is integrated exactly.
///
/// # Prior
/// With probability one half, where a coefficient is stated, grease of another temperature or kind: c is 0.4 to 2.5 times it,
/// log-uniform. Else a seal or wiper drags beside what is stated, and takes 0.2 to 20 % of the rated force at the largest feed,
/// log-uniform. Bittencourt, Gunnarsson (2012), *Static friction in a robot joint*, on temperature; friction in catalogues of
/// linear guides and rolling bearings with seals.
///
/// # Source
/// Any text on servo axes; Janot, Gautier, Brunot (2019), eq. 2, term `Fv·q̇`.
///
/// ```
/// use slideway::effect::{EffectId, Site};
/// assert_eq!(EffectId::ViscousFriction.site(), Site::Guide);
/// assert_eq!(EffectId::ViscousFriction.parameters()[0].unit, "N·s/m");
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ViscousFriction {
    /// c in N·s/m, or N·m·s/rad for a revolute axis; not negative.
    #[serde(alias = "viscous_nm_s_per_rad")]
    pub viscous_n_s_per_m: f64,
}

impl Law for ViscousFriction {
    const SITE: Site = Site::Guide;
    const PHRASE: &'static str = "viscous friction off its stated value";
    const PARAMETERS: &'static [Parameter] =
        &[Parameter::viscous("viscous_n_s_per_m", "viscous_nm_s_per_rad").not_negative()];

    fn fault(&self) -> Option<String> {
        negative("viscous_n_s_per_m", self.viscous_n_s_per_m)
    }

    fn alter(&self, constants: &mut Constants) {
        constants.viscous = self.viscous_n_s_per_m;
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        vec![constants.viscous]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "F(v) = −c·v";
    const SYMBOLS: &'static [&'static str] = &["c"];
    const SOURCE: &'static str = "Janot, Gautier, Brunot (2019), eq. 2, term Fv·q̇";
    const SHOWN_BY: &'static str = "Force in proportion to speed: constant speed at several feeds.";
    const EXAMPLE: &'static [f64] = &[500.0];
    const CONFUSABLE: &'static [Likeness] =
        &[Likeness::similar(EffectId::CoulombFriction, "where all runs move at one speed")];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let stated = machine.constants.viscous;
        vec![if stated > 0.0 && prior.chance(0.5) {
            stated * prior.log_uniform(0.4, 2.5)
        } else {
            stated + prior.log_uniform(0.002, 0.20) * machine.rated_force / machine.speed
        }]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = Some(Nominal::Viscous);
}
