//! A moving mass or inertia off its stated value.

use super::law::{infinite, not_positive};
use super::prior::{Machinery, Prior};
use super::sizing::{Absorbed, BEYOND, Drawn, Scale, Sizes, Unlike};
use super::{Constants, Law, Likeness, Nominal, Parameter, Site, Stretch};
use serde::{Deserialize, Serialize};

/// Mass carried beside the solid model's: a workpiece, a fixture, coolant, or a model that weighs wrong.
///
/// # Model
/// ```text
///   prismatic:  m = m_solid + Δm                 rigidly fixed at the moving part's centre of mass
///   revolute:   J = J_solid + ΔJ + m_l·l²        W(q) = W_solid(q) + m_l·g⊥·l·sin(q_h − q)
/// ```
/// On a revolute axis ΔJ is an inertia without weight. What has weight is a mass m_l whose centre lies at a lever l from the
/// axis and hangs straight below it at q = q_h; ΔJ is then its inertia about its own centre. g⊥ is the part of gravity across
/// the axis. Without q_h the mass lies in the direction of the moving part's own centre. 0.5 kg at 0.2 m is
/// `{ inertia_kg_m2 = 0.0, lever_mass_kg = 0.5, lever_m = 0.2 }`.
///
/// # Validity
/// Δm > −m_solid. Positive and negative alike; where the load attaches flexibly, it is a mode instead. m_l, l and q_h are
/// stated: a diagnosis fits ΔJ beside them and leaves them as they are.
///
/// # Prior
/// Four times in five something is put on: Δm of 0 to 100 % of the moving mass, uniform, from a light workpiece to one as heavy
/// as what moves; inertia on a revolute axis alike, where sizing guides ask for no more than a few times the rotor's. Else a
/// fixture is taken off: 0 to 20 % of the mass beside the rotor's, uniform. Permissible table loads in machine-tool data sheets;
/// inertia ratios in catalogues of servo motors.
///
/// # Source
/// Newton's second law; Siciliano, Sciavicco, Villani, Oriolo (2009), *Robotics*, section 7.2.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Payload {
    /// Δm in kg, or ΔJ about the joint's axis in kg·m².
    #[serde(alias = "inertia_kg_m2")]
    pub mass_kg: f64,
    /// m_l in kg; of a revolute axis only.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub lever_mass_kg: f64,
    /// l in m.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub lever_m: f64,
    /// q_h in rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hangs_at_rad: Option<f64>,
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

impl Payload {
    /// Whether a mass at a lever is stated.
    pub fn has_lever(&self) -> bool {
        self.lever_mass_kg != 0.0
    }
}

impl Law for Payload {
    const SITE: Site = Site::Structure;
    const PHRASE: &'static str = "a moving mass off its stated value";
    const PARAMETERS: &'static [Parameter] =
        &[Parameter::differing("mass_kg", "inertia_kg_m2", "kg", "kg·m²")];

    fn fault(&self) -> Option<String> {
        let hangs_at = self.hangs_at_rad.and_then(|angle| infinite("hangs_at_rad", angle));
        let lever = match self.has_lever() {
            true => not_positive("lever_m", self.lever_m),
            false if self.lever_m != 0.0 || self.hangs_at_rad.is_some() => {
                Some("a lever without a mass at it, expected lever_mass_kg beside lever_m".to_owned())
            }
            false => None,
        };
        infinite("mass_kg", self.mass_kg)
            .or_else(|| infinite("lever_mass_kg", self.lever_mass_kg))
            .or(lever)
            .or(hangs_at)
    }

    fn alter(&self, constants: &mut Constants) {
        constants.moving_mass += self.mass_kg;
        if self.has_lever() {
            constants.moving_mass += self.lever_mass_kg * self.lever_m * self.lever_m;
        }
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![0.0]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(_constants: &Constants) -> Option<&'static str> {
        None
    }

    const EQUATION: &'static str = "prismatic:  m = m_solid + Δm\nrevolute:  J = J_solid + ΔJ + m_l·l²";
    const SYMBOLS: &'static [&'static str] = &["Δm"];
    const SOURCE: &'static str =
        "Newton's second law; Siciliano, Sciavicco, Villani, Oriolo (2009), Robotics, section 7.2";
    const SHOWN_BY: &'static str =
        "Force in proportion to acceleration: starts and stops at several accelerations.";
    const EXAMPLE: &'static [f64] = &[6.0];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn sizes(scale: &Scale, absorbed: &Absorbed, drawn: Drawn) -> Sizes {
        let mass = scale.constants.moving_mass;
        Sizes::one((BEYOND * absorbed.mass, 0.5), move |s| drawn.sign * s * mass)
    }

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let constants = &machine.constants;
        let carried = constants.moving_mass - constants.rotor_inertia;
        let is_removed = prior.chance(0.2);
        vec![if is_removed {
            -prior.uniform(0.0, 0.2) * carried
        } else {
            prior.uniform(0.0, 1.0) * constants.moving_mass
        }]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = Some(Nominal::MovingMass);
}
