//! A mode that the twin does not list.

use super::law::not_positive;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::base::{Mode, Modes};
use serde::{Deserialize, Serialize};

/// A flexible mode that is not listed: of the base, or of a load that is not rigidly attached to what the motor drives.
///
/// # Model
/// One mode more at the driven point: `M·(η̈ + 2ζω·η̇ + ω²·η) = −F`, and the axis accelerates by −η̈ beside F/m. A load m₂ on
/// a spring and a driven part m₁, measured where it is driven, is the same equation with `M = m₁·(m₁ + m₂)/m₂` and ω its
/// free frequency.
///
/// # Validity
/// Linear; the sensor sits where the motor drives (collocated). 0 < ζ < 1.
///
/// # Prior
/// ω/2π of 8 to 400 Hz, log-uniform, below a fifth of the sample rate. M of 2 to 100 times the moving mass, log-uniform: a ratio
/// of 1 to 50 %. ζ of 0.005 to 0.06, log-uniform: from welded steel to bolted and greased joints. Altintas et al. (2011),
/// *Machine tool feed drives*; Ewins (2000), *Modal Testing*; Rivin (2003), *Passive Vibration Isolation*, for machines on
/// mounts.
///
/// # Source
/// Modal form of the drive-point receptance, Ewins (2000), *Modal Testing*, section 2.4.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FlexibleMode {
    /// ω/2π in Hz; more than zero.
    pub frequency_hz: f64,
    /// M in kg, or kg·m² for a revolute axis; more than zero.
    #[serde(alias = "inertia_kg_m2")]
    pub mass_kg: f64,
    /// ζ.
    pub damping_ratio: f64,
}

/// Highest frequency of a mode in Hz, and the same as a share of the sample rate.
pub(crate) const HIGHEST_HZ: f64 = 400.0;
pub(crate) const HIGHEST_OF_RATE: f64 = 0.2;
/// Damping ratios of modes: from welded steel to bolted and greased joints.
pub(crate) const DAMPING_RATIOS: (f64, f64) = (0.005, 0.06);

impl Law for FlexibleMode {
    const SITE: Site = Site::Structure;
    const PHRASE: &'static str = "a flexible mode that is not listed";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::same("frequency_hz", "Hz").positive(),
        Parameter::differing("mass_kg", "inertia_kg_m2", "kg", "kg·m²").positive(),
        Parameter::same("damping_ratio", "1").between(0.0, 1.0),
    ];

    fn fault(&self) -> Option<String> {
        not_positive("frequency_hz", self.frequency_hz)
            .or_else(|| not_positive("mass_kg", self.mass_kg))
            .or_else(|| {
                let damped = self.damping_ratio > 0.0 && self.damping_ratio < 1.0;
                (!damped).then(|| {
                    format!("damping_ratio = {}, expected more than 0 and less than 1", self.damping_ratio)
                })
            })
    }

    fn alter(&self, constants: &mut Constants) {
        let mode = Mode::new(self.frequency_hz, self.mass_kg, self.damping_ratio);
        let stated = constants.modes.as_slice().iter().copied();
        constants.modes = Modes::new(stated.chain(mode.ok()).collect());
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![f64::NAN, f64::INFINITY, f64::NAN]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(constants: &Constants) -> Option<Lack> {
        // No plant has a rotor that turns while its base moves.
        (constants.rotor_inertia != 0.0).then_some(Lack::RotorTurns)
    }

    const EQUATION: &'static str = "M·(η̈ + 2ζω·η̇ + ω²·η) = −F";
    const SYMBOLS: &'static [&'static str] = &["ω/2π", "M", "ζ"];
    const SOURCE: &'static str = "Ewins (2000), Modal Testing, section 2.4";
    const SHOWN_BY: &'static str = "Ringing after changes of the acceleration, at a frequency that no stated mode has: quick strokes with dwells.";
    const EXAMPLE: &'static [f64] = &[45.0, 600.0, 0.03];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let most = (HIGHEST_OF_RATE / machine.constants.sample_period_s).min(HIGHEST_HZ);
        let frequency = prior.log_uniform((0.5 * most).min(8.0), most);
        let mass = machine.constants.moving_mass / prior.log_uniform(0.01, 0.5);
        vec![frequency, mass, prior.log_uniform(DAMPING_RATIOS.0, DAMPING_RATIOS.1)]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
