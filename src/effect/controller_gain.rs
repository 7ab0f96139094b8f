//! Gains of the controller that are not those stated, each an effect of its own.

use super::law::{negative, not_positive};
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::controller::Controller;
use serde::{Deserialize, Serialize};

/// The group of effects that are gains of the controller.
pub const CONTROLLER_GAIN: &str = "controller_gain";

/// What is missing where no stated control law is another one once it is retuned.
pub(super) fn gain_is_absent(
    constants: &Constants,
    retuned: impl Fn(&Controller) -> Controller,
) -> Option<Lack> {
    match &constants.controller {
        None => Some(Lack::Controller),
        Some(law) => (retuned(law) == *law).then_some(Lack::Gain),
    }
}

/// One gain of the controller: its name and what it is, phrase, factors of position, velocity and integral gain with f in the
/// place of its own, the fault of f, its parameter, what shows it.
macro_rules! gain {
    ($name:ident, $what:literal, $phrase:literal, |$f:ident| $factors:expr, $fault:ident, $parameter:expr, $shown_by:literal) => {
        #[doc = $what]
        ///
        /// # Model
        /// `K = f·K_stated`. Where the gain is an integer register n, the register in force is the integer nearest to f·n.
        ///
        /// # Validity
        /// The law itself is the one stated, and states this gain other than zero.
        ///
        /// # Prior
        /// f of 0.5 to 1.5, uniform. Tuning rules differ by as much, and gain margins of two and more allow it: Åström, Hägglund
        /// (2006), *Advanced PID Control*; Altintas et al. (2011), *Machine tool feed drives*.
        ///
        /// # Source
        /// [`Controller`](crate::controller::Controller).
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            /// f, factor of the stated gain.
            pub factor: f64,
        }

        impl Law for $name {
            const SITE: Site = Site::Controller;
            const PHRASE: &'static str = $phrase;
            const PARAMETERS: &'static [Parameter] = &[$parameter];
            const GROUP: Option<&'static str> = Some(CONTROLLER_GAIN);

            fn fault(&self) -> Option<String> {
                $fault("factor", self.factor)
            }

            fn alter(&self, constants: &mut Constants) {
                let $f = self.factor;
                if let Some(law) = &mut constants.controller {
                    *law = law.with_gains($factors);
                }
            }

            fn neutral(_constants: &Constants) -> Vec<f64> {
                vec![1.0]
            }

            const STRETCH: Stretch = Stretch::Controller;

            fn lacks(constants: &Constants) -> Option<Lack> {
                let $f = 2.0;
                gain_is_absent(constants, |law| law.with_gains($factors))
            }

            const EQUATION: &'static str = "K = f·K_stated";
            const SYMBOLS: &'static [&'static str] = &["f"];
            const SOURCE: &'static str = "the control law that the machine file states";
            const SHOWN_BY: &'static str = $shown_by;
            const EXAMPLE: &'static [f64] = &[1.1];
            const CONFUSABLE: &'static [Likeness] = &[];

            fn draw(_machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
                vec![prior.uniform(0.5, 1.5)]
            }

            fn unlike(&self) -> Unlike {
                Unlike::Nothing
            }

            const NOMINAL: Option<Nominal> = None;
        }
    };
}

gain!(
    PositionGain,
    "Gain of the position loop, retuned after the machine file was written; its factor is more than zero.",
    "a position gain other than stated",
    |f| [f, 1.0, 1.0],
    not_positive,
    Parameter::same("factor", "1").positive(),
    "Control effort beside the position error, in closed loop. Without a logged effort: following error at constant speed, and settling."
);
gain!(
    VelocityGain,
    "Gain of the velocity loop (proportional, or derivative), retuned after the machine file was written; its factor is more \
     than zero.",
    "a velocity gain other than stated",
    |f| [1.0, f, 1.0],
    not_positive,
    Parameter::same("factor", "1").positive(),
    "Control effort beside the velocity, in closed loop. Without a logged effort: overshoot, and damping of the settling."
);
gain!(
    IntegralGain,
    "Integral gain, retuned after the machine file was written; its factor is zero where the integral part is switched off.",
    "an integral gain other than stated",
    |f| [1.0, 1.0, f],
    negative,
    Parameter::same("factor", "1").not_negative(),
    "Control effort that grows while an error lasts, in closed loop. Without a logged effort: settling after a stop."
);
