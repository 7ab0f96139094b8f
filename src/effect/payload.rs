//! A moving mass or inertia off its stated value.

use super::law::{infinite, not_positive};
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use serde::{Deserialize, Serialize};

/// Mass carried beside the solid model's: a workpiece, a fixture, coolant, or a model that weighs wrong.
///
/// # Model
/// ```text
///   prismatic:  m = m_solid + Δm                 rigidly fixed at the moving part's centre of mass
///   revolute:   J = J_solid + ΔJ + m_l·l²        W(q) = W_solid(q) + g⊥·(m_l·l + u)·sin(q_h − q)
/// ```
/// What has weight on a revolute axis is a mass m_l in kg whose centre lies at a lever l in m from the axis and hangs straight
/// below it at q = q_h; ΔJ in kg·m² is then its inertia about its own centre. g⊥ in m/s² is the part of gravity across the axis.
/// Without q_h the mass lies in the direction of the moving part's own centre. 0.5 kg at 0.2 m is
/// `{ inertia_kg_m2 = 0.0, lever_mass_kg = 0.5, lever_m = 0.2 }`.
///
/// # What a recording tells of a lever
/// A body of mass M with its centre at a distance L from the axis, and inertia J_c about that centre, adds to the equation of
/// motion, torques about the axis taken positive towards larger q,
/// ```text
///   (J_solid + J_c + M·L²)·q̈ = τ + W_solid(q) + g⊥·M·L·sin(q_h − q)
/// ```
/// since its weight M·g⊥ acts at the arm L·sin(q_h − q) and turns it back to where it hangs. M, L and J_c enter through two
/// numbers only, the inertia J_c + M·L² and the moment M·L. These two are fitted: ΔJ, and the moment u in kg·m, beside
/// what m_l and l state. A fitted payload is the point mass u²/ΔJ at the lever ΔJ/u; one with an extent has a smaller lever.
/// `{ inertia_kg_m2 = 0.02, lever_moment_kg_m = 0.1 }` is the payload above. u > 0 hangs below the axis at q_h, u < 0 above it
/// (or mass is missing below).
///
/// # Validity
/// Δm > −m_solid. Positive and negative alike; where the load attaches flexibly, it is a mode instead. m_l, l and q_h are
/// stated and stay as they are. u is fitted where it is a torque: on a revolute axis that is not upright, where q_h is stated
/// or the moving part has a place where it hangs. Elsewhere the lever acts through J alone, which ΔJ already is. u has no
/// mass of its own: what the bearings carry is left as it was.
///
/// # Prior
/// Four times in five something is put on: Δm of 0 to 100 % of the moving mass, uniform, from a light workpiece to one as heavy
/// as what moves; inertia on a revolute axis alike, where sizing guides ask for no more than a few times the rotor's. Else a
/// fixture is taken off: 0 to 20 % of the mass beside the rotor's, uniform. Permissible table loads in machine-tool data sheets;
/// inertia ratios in catalogues of servo motors.
///
/// # Source
/// Newton's second law; Siciliano, Sciavicco, Villani, Oriolo (2009), *Robotics*, section 7.2.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
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
    /// u in kg·m; of a revolute axis only.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub lever_moment_kg_m: f64,
    /// q_h in rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hangs_at_rad: Option<f64>,
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

impl Payload {
    /// Whether it has weight at a lever.
    pub fn has_lever(&self) -> bool {
        self.lever_mass_kg != 0.0 || self.lever_moment_kg_m != 0.0
    }

    /// Key path by which its lever is stated.
    pub fn lever_key(&self) -> &'static str {
        if self.lever_mass_kg == 0.0 && self.lever_moment_kg_m != 0.0 {
            "effect.payload.lever_moment_kg_m"
        } else {
            "effect.payload.lever_m"
        }
    }

    /// Whether it says anything of a lever: what only a revolute axis may have.
    pub fn tells_of_lever(&self) -> bool {
        self.has_lever() || self.hangs_at_rad.is_some()
    }
}

impl Law for Payload {
    const SITE: Site = Site::Structure;
    const PHRASE: &'static str = "a moving mass or inertia off its stated value";
    const PARAMETERS: &'static [Parameter] =
        &[Parameter::differing("mass_kg", "inertia_kg_m2", "kg", "kg·m²")];
    const FURTHER: &'static [Parameter] = &[Parameter::same("lever_moment_kg_m", "kg·m")];

    fn fault(&self) -> Option<String> {
        let hangs_at = self.hangs_at_rad.and_then(|angle| infinite("hangs_at_rad", angle));
        let lever = match self.lever_mass_kg != 0.0 {
            true => not_positive("lever_m", self.lever_m),
            false if self.lever_m != 0.0 => {
                Some("a lever without a mass at it, expected lever_mass_kg beside lever_m".to_owned())
            }
            false => None,
        };
        infinite("mass_kg", self.mass_kg)
            .or_else(|| infinite("lever_mass_kg", self.lever_mass_kg))
            .or_else(|| infinite("lever_moment_kg_m", self.lever_moment_kg_m))
            .or(lever)
            .or(hangs_at)
    }

    fn alter(&self, constants: &mut Constants) {
        constants.moving_mass += self.mass_kg + self.lever_mass_kg * self.lever_m * self.lever_m;
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![0.0]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "prismatic:  m = m_solid + Δm\nrevolute:  J = J_solid + ΔJ + m_l·l²\nW(q) = W_solid(q) + g⊥·(m_l·l + u)·sin(q_h − q)";
    const SYMBOLS: &'static [&'static str] = &["Δm", "u"];
    const SOURCE: &'static str =
        "Newton's second law; Siciliano, Sciavicco, Villani, Oriolo (2009), Robotics, section 7.2";
    const SHOWN_BY: &'static str = "Force in proportion to acceleration: starts and stops at several accelerations. A lever: torque that goes with the angle, over a quarter turn.";
    const EXAMPLE: &'static [f64] = &[6.0];
    const CONFUSABLE: &'static [Likeness] = &[
        Likeness::similar(EffectId::ConstantForce, "with its lever, where the axis hardly turns"),
        Likeness::similar(
            EffectId::CableSpring,
            "with its lever, where the axis turns less than half a radian",
        ),
    ];

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
