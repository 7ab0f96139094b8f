//! Feed-forward of the reference velocity other than stated.

use super::controller_gain::gain_is_absent;
use super::law::infinite;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::controller::Controller;
use serde::{Deserialize, Serialize};

/// The share of the reference velocity that the controller feeds forward, retuned after the machine file was written.
///
/// # Model
/// `e = k_x·(x_ref − x) + k_f·v_ref − v`; the share k_f itself is fitted, since it is often stated as zero.
///
/// # Validity
/// The law itself is the one stated.
///
/// # Prior
/// Where a share is stated, k_f is 0.5 to 1.5 times it, uniform; where none is, it is switched on: 0 to 1, uniform. Retuning by
/// half is within what tuning rules differ by: Åström, Hägglund (2006), *Advanced PID Control*.
///
/// # Source
/// [`Controller`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VelocityFeedforward {
    /// k_f, share of the reference velocity that is fed forward, in the place of the stated one.
    pub share: f64,
}

impl Law for VelocityFeedforward {
    const SITE: Site = Site::Controller;
    const PHRASE: &'static str = "a velocity feed-forward other than stated";
    const PARAMETERS: &'static [Parameter] = &[Parameter::same("share", "1")];
    const GROUP: Option<&'static str> = Some(super::CONTROLLER_GAIN);

    fn fault(&self) -> Option<String> {
        infinite("share", self.share)
    }

    fn alter(&self, constants: &mut Constants) {
        if let Some(law) = &mut constants.controller {
            *law = law.with_velocity_feedforward(self.share);
        }
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        vec![constants.controller.as_ref().map_or(0.0, Controller::velocity_feedforward)]
    }

    const STRETCH: Stretch = Stretch::Controller;

    fn lacks(constants: &Constants) -> Option<Lack> {
        gain_is_absent(constants, |law| law.with_velocity_feedforward(law.velocity_feedforward() + 1.0))
    }

    const EQUATION: &'static str = "e = k_x·(x_ref − x) + k_f·v_ref − v";
    const SYMBOLS: &'static [&'static str] = &["k_f"];
    const SOURCE: &'static str = "the control law that the machine file states";
    const SHOWN_BY: &'static str = "Control effort in proportion to the reference velocity. Without a logged effort: following error at constant speed, at several feeds.";
    const EXAMPLE: &'static [f64] = &[0.5];
    const CONFUSABLE: &'static [Likeness] = &[Likeness::similar(
        EffectId::PositionGain,
        "where no control effort is logged and the runs hardly accelerate",
    )];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let stated = Self::neutral(&machine.constants).first().copied().unwrap_or(0.0);
        vec![if stated == 0.0 { prior.uniform(0.0, 1.0) } else { stated * prior.uniform(0.5, 1.5) }]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
