//! What every law of the catalogue says of itself.

use super::{Constants, EffectId, Screen};
use crate::units::Motion;
use serde::Serialize;

/// A place on the signal path, in hardware order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Site {
    /// What computes the effort.
    Controller,
    /// What turns the commanded into the applied voltage.
    Amplifier,
    /// What turns voltage into force or torque.
    Motor,
    /// What the moving part slides or turns on.
    Guide,
    /// Moving part and base.
    Structure,
    /// What measures.
    Sensor,
}

impl Site {
    /// Every site, in hardware order.
    pub const ALL: [Self; 6] =
        [Self::Controller, Self::Amplifier, Self::Motor, Self::Guide, Self::Structure, Self::Sensor];

    /// The word used in reports and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Controller => "controller",
            Self::Amplifier => "amplifier",
            Self::Motor => "motor",
            Self::Guide => "guide",
            Self::Structure => "structure",
            Self::Sensor => "sensor",
        }
    }
}

/// One parameter of a law: its key in machine files and reports and its unit, for either kind of axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Key for a prismatic axis; the field's name.
    pub name: &'static str,
    /// Key for a revolute axis, an alias of the field.
    pub revolute_name: &'static str,
    /// Unit for a prismatic axis.
    pub unit: &'static str,
    /// Unit for a revolute axis.
    pub revolute_unit: &'static str,
}

impl Parameter {
    /// A parameter that has the same name and unit on both kinds of axis.
    pub const fn same(name: &'static str, unit: &'static str) -> Self {
        Self { name, revolute_name: name, unit, revolute_unit: unit }
    }

    /// A force that is a torque on a revolute axis.
    pub const fn effort(name: &'static str, revolute_name: &'static str) -> Self {
        Self { name, revolute_name, unit: "N", revolute_unit: "N·m" }
    }

    /// A viscous coefficient.
    pub const fn viscous(name: &'static str, revolute_name: &'static str) -> Self {
        Self { name, revolute_name, unit: "N·s/m", revolute_unit: "N·m·s/rad" }
    }

    /// The key for this kind of axis.
    pub fn key(&self, motion: Motion) -> &'static str {
        match motion {
            Motion::Prismatic => self.name,
            Motion::Revolute => self.revolute_name,
        }
    }

    /// The unit for this kind of axis.
    pub fn unit(&self, motion: Motion) -> &'static str {
        match motion {
            Motion::Prismatic => self.unit,
            Motion::Revolute => self.revolute_unit,
        }
    }
}

/// A law of the catalogue.
///
/// A law acts through any of three doors, each neutral unless overridden: it moves a constant of the twin
/// ([`alter`](Law::alter)), resists the guide's motion ([`resistance`](Law::resistance)) or pushes the
/// moving part ([`push`](Law::push)). Forces are positive along the axis' positive direction; N for a
/// prismatic, N·m for a revolute axis.
pub trait Law: Sized {
    /// Where it sits on the signal path.
    const SITE: Site;
    /// Its parameters, in the order of [`start`](Law::start), [`range`](Law::range) and
    /// [`neutral`](Law::neutral).
    const PARAMETERS: &'static [Parameter];
    /// What it is, in a phrase that fits into "… causes 94 % of the gap".
    const PHRASE: &'static str;
    /// Effects whose say it takes over.
    const SUPERSEDES: &'static [EffectId] = &[];
    /// Whether [`resistance`](Law::resistance) is overridden.
    const RESISTS: bool = false;
    /// Whether [`push`](Law::push) is overridden.
    const PUSHES: bool = false;

    /// Whether the first parameter found by screening comes on top of what the twin states already.
    const CUMULATIVE: bool = false;

    /// What is wrong with the parameters, if anything.
    fn fault(&self) -> Option<String> {
        None
    }

    /// Moves constants of the twin.
    fn alter(&self, _constants: &mut Constants) {}

    /// Magnitude of the friction that opposes motion at `speed` ≥ 0 in `direction` (±1); at zero speed, the
    /// force up to which the guide sticks. Less than zero only for a law that has more drag than its own in the
    /// linear dynamics (a mean over both directions, say).
    fn resistance(&self, _direction: f64, _speed: f64) -> f64 {
        0.0
    }

    /// Force on the moving part as a single-valued function of position and velocity.
    fn push(&self, _position: f64, _velocity: f64) -> f64 {
        0.0
    }

    /// Parameter values that leave the twin as `constants` state it.
    fn neutral(constants: &Constants) -> Vec<f64>;

    /// Starting values of a fit: one or several sets, from what screening found.
    fn start(screen: &Screen) -> Vec<Vec<f64>>;

    /// The range in which a fit may look for each parameter.
    fn range(screen: &Screen) -> Vec<(f64, f64)>;
}

/// The sentence for a parameter that must be finite and not negative.
pub(super) fn negative(name: &str, value: f64) -> Option<String> {
    (!(value.is_finite() && value >= 0.0)).then(|| format!("{name} = {value}, expected zero or more"))
}

/// The sentence for a parameter that must be finite.
pub(super) fn infinite(name: &str, value: f64) -> Option<String> {
    (!value.is_finite()).then(|| format!("{name} = {value}, expected a finite number"))
}
