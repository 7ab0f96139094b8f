//! Cogging and force ripple of further pitches.

use super::law::FormNumber;
use super::wave::Wave;
use super::{
    Cogging, Constants, Door, EffectId, ForceRipple, Lack, Law, Likeness, Machinery, Nominal, Parameter,
    Prior, Site, Stretch, Unlike,
};
use serde::{Deserialize, Serialize};

/// A further pitch of a law that repeats along the axis, beside those that are there already.
macro_rules! further {
    ($name:ident, $law:ident, $modified:ident, $group:literal, $phrase:literal, $what:literal) => {
        #[doc = $what]
        ///
        /// # Model
        /// The law of the first pitch, with a pitch of its own, added to it. Motors have several: of the magnets, of the slots, of
        /// their least common multiple, and of a turn. Which of them is called the first is a matter of order: each has the harmonics of
        /// the law, as numbers and as form.
        ///
        /// # Validity
        /// As the law of the first pitch. It is looked for once the pitch before it is there.
        ///
        /// # Prior
        /// As the law of the first pitch, but never at a stated pitch: p is 10 to 60 mm, uniform, or 2π/n with 2 to 84 poles,
        /// slots or their least common multiple in a turn of the motor, log-uniform. Amplitudes alike: a second pitch is not
        /// always the smaller one. Boldea (2013), *Linear Electric Machines, Drives, and MAGLEVs Handbook*; catalogues of linear
        /// motors.
        ///
        /// # Source
        /// Gieras, Piech, Tomczuk (2011), *Linear Synchronous Motors*, section 3.8; Zhu, Howe (2000), *Influence of design
        /// parameters on cogging torque in permanent magnet machines*: orders of slots, poles and their least common multiple.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
        #[serde(transparent)]
        pub struct $name(pub $law);

        impl Law for $name {
            const SITE: Site = <$law as Law>::SITE;
            const PHRASE: &'static str = $phrase;
            const PARAMETERS: &'static [Parameter] = <$law as Law>::PARAMETERS;
            const MODIFIES: &'static [EffectId] = &[EffectId::$modified];
            const FOLLOWS: bool = true;
            const GROUP: Option<&'static str> = Some($group);
            const FORM: &'static [FormNumber] = <$law as Law>::FORM;
            const DOORS: &'static [Door] = <$law as Law>::DOORS;

            fn fault(&self) -> Option<String> {
                self.0.fault()
            }

            fn push_wave(&self) -> Option<Wave> {
                self.0.push_wave()
            }

            #[inline]
            fn motor_change(&self, position: f64, force: f64) -> f64 {
                self.0.motor_change(position, force)
            }

            fn neutral(constants: &Constants) -> Vec<f64> {
                $law::neutral(constants)
            }

            const STRETCH: Stretch = <$law as Law>::STRETCH;

            fn lacks(constants: &Constants) -> Option<Lack> {
                $law::lacks(constants)
            }

            const EQUATION: &'static str = <$law as Law>::EQUATION;
            const SYMBOLS: &'static [&'static str] = <$law as Law>::SYMBOLS;
            const SOURCE: &'static str = <$law as Law>::SOURCE;
            const SHOWN_BY: &'static str = <$law as Law>::SHOWN_BY;
            const EXAMPLE: &'static [f64] = <$law as Law>::EXAMPLE;
            const CONFUSABLE: &'static [Likeness] = &[];

            fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
                let pitch = prior.motor_pitch(machine);
                $law::of_pitch(pitch, machine, prior)
            }

            fn unlike(&self) -> Unlike {
                Unlike::Nothing
            }

            const NOMINAL: Option<Nominal> = None;
        }
    };
}

further!(
    SecondCogging,
    Cogging,
    Cogging,
    "cogging",
    "cogging of a second pitch",
    "Cogging of a second pitch."
);
further!(
    ThirdCogging,
    Cogging,
    SecondCogging,
    "cogging",
    "cogging of a third pitch",
    "Cogging of a third pitch."
);
further!(
    SecondForceRipple,
    ForceRipple,
    ForceRipple,
    "force_ripple",
    "force ripple of a second pitch",
    "Force ripple of a second pitch."
);
