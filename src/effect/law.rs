//! What every law of the catalogue says of itself.

use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::wave::Wave;
use super::{Constants, EffectId, Lack, Likeness, Stretch};
use crate::units::{Motion, SMALLEST, largest};
use serde::Serialize;
use std::ops::RangeInclusive;

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
    /// Whether a fit leaves it where each of its starts puts it: a number that picks, or one that is read off
    /// the data.
    pub held: bool,
    /// Values that the law allows.
    pub limits: (f64, f64),
    /// Whether the limits themselves are not allowed.
    pub open: bool,
    /// Where machines usually have it; none where nothing is known of that.
    pub usual: Option<Usual>,
}

/// Where 95 % of machines have a number, normal in its logarithm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Usual {
    /// Within this factor of the stated value.
    Factor(f64),
    /// Between two values, on either kind of axis.
    Range {
        /// On a prismatic axis.
        prismatic: (f64, f64),
        /// On a revolute axis.
        revolute: (f64, f64),
    },
}

impl Usual {
    /// The two values between which 95 % of machines have the number, where their file states it as `stated` (no number, where it does not);
    /// none where that is not known. A number that is stated is known better than from what other machines have.
    pub fn range(self, motion: Motion, stated: f64) -> Option<(f64, f64)> {
        match (self, motion) {
            (Self::Factor(factor), _) => (stated > 0.0).then_some((stated / factor, stated * factor)),
            (Self::Range { .. }, _) if stated.is_finite() => None,
            (Self::Range { prismatic, .. }, Motion::Prismatic) => Some(prismatic),
            (Self::Range { revolute, .. }, Motion::Revolute) => Some(revolute),
        }
    }
}

impl Parameter {
    /// A parameter that has the same name and unit on both kinds of axis.
    pub const fn same(name: &'static str, unit: &'static str) -> Self {
        Self::differing(name, name, unit, unit)
    }

    /// A parameter whose name or unit depends on the kind of axis.
    pub const fn differing(
        name: &'static str,
        revolute_name: &'static str,
        unit: &'static str,
        revolute_unit: &'static str,
    ) -> Self {
        Self {
            name,
            revolute_name,
            unit,
            revolute_unit,
            held: false,
            limits: (f64::NEG_INFINITY, f64::INFINITY),
            open: false,
            usual: None,
        }
    }

    /// The parameter, which the law allows from one value to another.
    pub const fn within(self, from: f64, to: f64) -> Self {
        Self { limits: (from, to), ..self }
    }

    /// The parameter, which must lie between two values and be neither.
    pub const fn between(self, from: f64, to: f64) -> Self {
        Self { limits: (from, to), open: true, ..self }
    }

    /// The parameter, which must be more than zero.
    pub const fn positive(self) -> Self {
        self.between(0.0, f64::INFINITY)
    }

    /// The parameter, which must be zero or more.
    pub const fn not_negative(self) -> Self {
        self.within(0.0, f64::INFINITY)
    }

    /// The parameter, which 95 % of machines have within this factor of its stated value.
    pub const fn usually_within(self, factor: f64) -> Self {
        Self { usual: Some(Usual::Factor(factor)), ..self }
    }

    /// The parameter, which 95 % of machines have between two values, on a prismatic and on a revolute axis.
    pub const fn usually_between(self, prismatic: (f64, f64), revolute: (f64, f64)) -> Self {
        Self { usual: Some(Usual::Range { prismatic, revolute }), ..self }
    }

    /// The parameter, left by fits where each start puts it.
    pub const fn held(self) -> Self {
        Self { held: true, ..self }
    }

    /// A length that is an angle on a revolute axis.
    pub const fn length(name: &'static str, revolute_name: &'static str) -> Self {
        Self::differing(name, revolute_name, "m", "rad")
    }

    /// A force that is a torque on a revolute axis.
    pub const fn effort(name: &'static str, revolute_name: &'static str) -> Self {
        Self::differing(name, revolute_name, "N", "N·m")
    }

    /// A viscous coefficient.
    pub const fn viscous(name: &'static str, revolute_name: &'static str) -> Self {
        Self::differing(name, revolute_name, "N·s/m", "N·m·s/rad")
    }

    /// The values that the law allows, in words.
    pub fn allowed(&self) -> String {
        let (least, most) = self.limits;
        match (least.is_finite(), most.is_finite(), self.open) {
            (false, false, _) => "any number".to_owned(),
            (true, false, true) => format!("more than {least}"),
            (true, false, false) => format!("{least} or more"),
            (false, true, true) => format!("less than {most}"),
            (false, true, false) => format!("{most} or less"),
            (true, true, true) => format!("more than {least} and less than {most}"),
            (true, true, false) => format!("{least} to {most}"),
        }
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

/// A number of a law's form that machine files rarely state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FormNumber {
    /// The number.
    pub parameter: Parameter,
    /// What it is where the file does not state it.
    pub usual: f64,
    /// How far it may be off that, or off what the file states: inside that it is calibration, and it is never a cause.
    pub tolerance: f64,
}

/// A nominal parameter of a machine with a tolerance of its own: inside it a deviation is calibration, beyond it a cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Nominal {
    /// Moving mass or inertia.
    MovingMass,
    /// Viscous coefficient of the guide.
    Viscous,
    /// Force or torque constant.
    ForceConstant,
    /// Resistance of the winding.
    Resistance,
    /// Inductance of the winding.
    Inductance,
    /// Zero of the encoder.
    EncoderZero,
}

/// A way in which a law acts on the twin, beside moving its constants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Door {
    /// [`Law::push`].
    Push,
    /// [`Law::shake`].
    Shake,
    /// [`Law::motor_change`].
    MotorForce,
    /// [`Law::stops`].
    Transmission,
    /// [`Law::read`].
    Reading,
}

/// A law of the catalogue.
///
/// A law acts through any of several doors, each neutral unless overridden: it moves constants of the twin, its dry friction
/// among them ([`alter`](Law::alter)), or acts along the path while the twin runs, through the doors that it lists in
/// [`DOORS`](Law::DOORS). Forces are positive along the axis' positive direction; N for a prismatic, N·m for a
/// revolute axis.
pub trait Law: Sized {
    /// Where it sits on the signal path.
    const SITE: Site;
    /// Its parameters, in the order of [`neutral`](Law::neutral) and of all lists of their values.
    const PARAMETERS: &'static [Parameter];
    /// Numbers that a fit chooses beside the parameters where the recording tells them; elsewhere they stay as the machine file
    /// states them. Zero leaves the twin as it is.
    const FURTHER: &'static [Parameter] = &[];
    /// Numbers of its form: calibrated where the machine's file states the effect. Zero is the usual form.
    const FORM: &'static [FormNumber] = &[];
    /// What it is, in a phrase that fits into "It lacked …".
    const PHRASE: &'static str;
    /// Of a feature: the effects of which it modifies one or several. Without any of them it does nothing, and is
    /// neither stated nor looked for.
    const MODIFIES: &'static [EffectId] = &[];
    /// Of a feature: whether it is looked for only beside what it modifies, once that has been found.
    const FOLLOWS: bool = false;
    /// The group that it belongs to, where several effects are numbers of one thing.
    const GROUP: Option<&'static str> = None;
    /// How much rarer than others it is, as the logarithm of odds: what decides where data cannot, because the law
    /// is another one's equal on them.
    const RARITY: f64 = 0.0;
    /// Whether what it does to the motion is in part beyond any prediction, as noise is: a twin with it has a noise floor of
    /// its own.
    const MAKES_NOISE: bool = false;
    /// The doors that it overrides.
    const DOORS: &'static [Door] = &[];

    /// What is wrong with the parameters, if anything.
    fn fault(&self) -> Option<String> {
        None
    }

    /// Moves constants of the twin.
    fn alter(&self, _constants: &mut Constants) {}

    /// The wave that [`push`](Self::push) is, of a force that repeats along the axis.
    fn push_wave(&self) -> Option<Wave> {
        None
    }

    /// Force on the moving part as a single-valued function of position and velocity.
    #[inline]
    fn push(&self, position: f64, _velocity: f64) -> f64 {
        self.push_wave().map_or(0.0, |wave| wave.at(position))
    }

    /// Force on the moving part as a function of the session's time in s.
    fn shake(&self, _time_s: f64) -> f64 {
        0.0
    }

    /// Relative change of the motor's force at a position, from what it would be: `Kt·i`, or K·u, in N or N·m.
    fn motor_change(&self, _position: f64, _force: f64) -> f64 {
        0.0
    }

    /// Stops between which the drive train holds the load, `[rear, front]`, from those before this law: the rear one pushes
    /// the load forward, the front one backward. Without play they are one place.
    fn stops(&self, stops: [f64; 2]) -> [f64; 2] {
        stops
    }

    /// Share of the motor's travel by which the load is carried along between the stops.
    fn carried(&self) -> f64 {
        0.0
    }

    /// By which share of half its play the motor's end stands ahead of the middle where a run begins, −1 to 1.
    fn initial_share(&self) -> f64 {
        0.0
    }

    /// What the encoder reads at a position.
    fn read(&self, position: f64) -> f64 {
        position
    }

    /// Parameter values that leave the twin as `constants` state it.
    fn neutral(constants: &Constants) -> Vec<f64>;

    /// Where it comes between signals that a log may hold.
    const STRETCH: Stretch;

    /// What a machine with these constants lacks to have the effect at all; none where it can have it.
    fn lacks(constants: &Constants) -> Option<Lack>;

    /// Its equation as its documentation has it, one line a case.
    const EQUATION: &'static str;

    /// The symbols of its parameters in that equation, then those of [`FURTHER`](Law::FURTHER) and
    /// [`FORM`](Law::FORM).
    const SYMBOLS: &'static [&'static str];

    /// Where the equation is from.
    const SOURCE: &'static str;

    /// What shows it, as a sentence or two: signals and motion.
    const SHOWN_BY: &'static str;

    /// Values of the parameters of a plausible size, for a machine file's table.
    const EXAMPLE: &'static [f64];

    /// The effects that it is confusable with, as far as their laws do not say so.
    const CONFUSABLE: &'static [Likeness];

    /// Draws its parameters, in the law's order, as machines have them, whatever a diagnosis finds of it: from the distribution under
    /// `Prior` in its documentation. They are allowed values on every machine that [can have](Self::lacks) the effect.
    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64>;

    /// What a machine of a blind trial does otherwise.
    fn unlike(&self) -> Unlike;

    /// The nominal parameter that it moves, where a machine file states a tolerance for that.
    const NOMINAL: Option<Nominal>;
}

/// The sentence for a parameter that must be finite and more than zero.
pub(super) fn not_positive(name: &str, value: f64) -> Option<String> {
    let most = largest(name);
    (!(SMALLEST..=most).contains(&value))
        .then(|| format!("{name} = {value}, expected more than zero, at most {most:e}"))
}

/// The sentence for a parameter that must be finite and not negative.
pub(super) fn negative(name: &str, value: f64) -> Option<String> {
    let most = largest(name);
    (!(0.0..=most).contains(&value))
        .then(|| format!("{name} = {value}, expected zero or more, at most {most:e}"))
}

/// The sentence for a parameter that may be so large at most, either way.
pub(super) fn beyond(name: &str, value: f64, most: f64) -> Option<String> {
    outside(name, value, -most..=most)
}

/// The sentence for a parameter that lies in a range.
pub(super) fn outside(name: &str, value: f64, range: RangeInclusive<f64>) -> Option<String> {
    let (least, most) = (range.start(), range.end());
    (!range.contains(&value)).then(|| format!("{name} = {value}, expected {least} to {most}"))
}

/// Whether a number is what it is where a file does not state it.
pub(super) fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

/// The sentence for a parameter that must be finite.
pub(super) fn infinite(name: &str, value: f64) -> Option<String> {
    let most = largest(name);
    (!(-most..=most).contains(&value))
        .then(|| format!("{name} = {value}, expected a finite number, at most {most:e}"))
}
