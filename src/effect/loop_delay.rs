//! Time between commanded and applied voltage.

use super::law::negative;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use serde::{Deserialize, Serialize};

/// Dead time between the controller's effort and the voltage at the motor, beyond what is stated.
///
/// # Model
/// `u_applied(t) = u_commanded(t − τ)`, with the commanded voltage a staircase; τ need not be a whole
/// number of sample periods.
///
/// # Validity
/// 0 ≤ τ. Computation, bus and PWM dead time. A delay of a *recorded channel* moves that channel only and
/// is another finding.
///
/// # Prior
/// τ of 0 to 4 sample periods, uniform: computation takes up to one, a field bus one or two, and the bridge holds its voltage for
/// another half. Åström, Wittenmark, *Computer-Controlled Systems*; cycle times of drive and field-bus manuals.
///
/// # Source
/// Åström, Wittenmark, *Computer-Controlled Systems*, section 2.3 (fractional delay under a zero-order hold).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoopDelay {
    /// τ in s; not negative.
    pub delay_s: f64,
}

impl Law for LoopDelay {
    const SITE: Site = Site::Amplifier;
    const PHRASE: &'static str = "a delay between effort and voltage";
    const PARAMETERS: &'static [Parameter] = &[Parameter::same("delay_s", "s").not_negative()];

    fn fault(&self) -> Option<String> {
        negative("delay_s", self.delay_s)
    }

    fn alter(&self, constants: &mut Constants) {
        constants.amplifier.delay_s += self.delay_s;
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![0.0]
    }

    const STRETCH: Stretch = Stretch::Drive;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "u_applied(t) = u_commanded(t − τ)";
    const SYMBOLS: &'static [&'static str] = &["τ"];
    const SOURCE: &'static str = "Åström, Wittenmark, Computer-Controlled Systems, section 2.3";
    const SHOWN_BY: &'static str = "Current or motor force behind the control effort where accelerations begin and end. Without them: less damping of the closed loop.";
    const EXAMPLE: &'static [f64] = &[4e-4];
    const CONFUSABLE: &'static [Likeness] = &[
        Likeness::similar(EffectId::WindingInductance, "where no current is logged"),
        Likeness::similar(EffectId::VelocityFilter, "where no control effort is logged"),
    ];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        vec![prior.uniform(0.0, 4.0) * machine.constants.sample_period_s]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
