//! Friction in proportion to what the sliders carry or the transmission transmits.

use super::law::outside;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use serde::{Deserialize, Serialize};

/// Largest μ: from 1 on a transmission would hold any load by itself, and a guide carry its table up a wall.
pub const HIGHEST: f64 = 0.99;

/// Dry friction proportional to the loads of the four bearing sliders, or, on a machine without them, to what its transmission
/// transmits.
///
/// # Model
/// `F = −μ·N·sgn(v)`, sticking below that at rest. N is one of
/// - `Σ|N_i|` over the sliders A–D, with the loads of the rigid-body scene: weight, and the couple of motor force and
///   friction at their lines of action;
/// - the effort that comes into the [`Transmission`](crate::drive::transmission::Transmission), in N or N·m at the joint: at the
///   motor's side while that drives, at the load's side while the load drives it back. 1 − μ is then the efficiency, both ways:
///   `F_out = (1 − μ)·F_in`. It enters through the closed form of [`Transmitted`](crate::plant::Transmitted).
///
/// # Validity
/// Sliders: while every one stays pressed down and the carried mass does not change, Σ|N_i| is the weight: it is then exactly
/// Coulomb friction. They part when a slider lifts under acceleration, or between runs with different payload.
/// Transmission: one efficiency both ways; μ of 0.99 at most, from 1 on it would hold any load by itself. Other friction is left
/// aside in what comes in.
///
/// # Prior
/// μ of 0.002 to 0.02 on sliders, log-uniform: rolling guides, from balls to rollers with preload and seals. Of a transmission
/// 0.02 to 0.2, log-uniform: what efficiencies of 98 to 80 % leave. Catalogues of linear guides, such as those of THK and HIWIN;
/// catalogues of planetary, worm and servo gearboxes.
///
/// # Source
/// Amontons' law on each slider; loads from [`Supports`](crate::plant::rapier::Supports). Of a transmission: the definition of its
/// efficiency, what goes out over what comes in at one speed. Duclusaud et al., *Extended friction models for the physics
/// simulation of servo actuators*, ICRA 2025, take `|τ_motor − τ_load|` in their model M3, the sum of what comes in and what goes
/// out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadDependentFriction {
    /// μ; 0 to 0.99.
    pub coefficient: f64,
}

impl Law for LoadDependentFriction {
    const SITE: Site = Site::Guide;
    const PHRASE: &'static str = "friction proportional to load";
    const PARAMETERS: &'static [Parameter] = &[Parameter::same("coefficient", "1").within(0.0, HIGHEST)];
    // Where the loads do not change it is Coulomb friction, which says the same with less.
    const RARITY: f64 = 3.0;

    fn fault(&self) -> Option<String> {
        outside("coefficient", self.coefficient, 0.0..=HIGHEST)
    }

    fn alter(&self, constants: &mut Constants) {
        constants.friction.load_coefficient = self.coefficient;
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        vec![constants.friction.load_coefficient]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(constants: &Constants) -> Option<Lack> {
        (!(constants.has_slider_loads || constants.has_transmission)).then_some(Lack::NothingToChange)
    }

    const EQUATION: &'static str = "F = −μ·N·sgn(v)";
    const SYMBOLS: &'static [&'static str] = &["μ"];
    const SOURCE: &'static str = "Amontons; Duclusaud et al., ICRA 2025, model M3";
    const SHOWN_BY: &'static str = "Friction that grows with the load: runs with different payload, accelerations that lift a slider, effort through the transmission.";
    const EXAMPLE: &'static [f64] = &[0.03];
    const CONFUSABLE: &'static [Likeness] = &[Likeness::equal(
        EffectId::CoulombFriction,
        "where the sliders' loads do not change",
        |constants, _| constants.has_slider_loads,
    )];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let sliders = machine.constants.has_slider_loads;
        vec![if sliders { prior.log_uniform(0.002, 0.02) } else { prior.log_uniform(0.02, 0.2) }]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Bristles
    }

    const NOMINAL: Option<Nominal> = None;
}
