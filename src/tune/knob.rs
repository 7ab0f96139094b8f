//! A number of the controller that may be turned.

use crate::controller::Controller;
use crate::error::{Error, ErrorKind, Result};
use crate::machine::{Machine, turned};
use std::str::FromStr;

/// Values of a knob that was given without a step.
const VALUES: f64 = 60.0;
/// What a real number is at last turned by, as a share of its range.
const FINEST: f64 = 1e-3;
/// Range of a knob of which nothing is stated, as factors of its present value.
const USUAL: [f64; 2] = [0.4, 2.0];

/// A number of the machine's controller, by key path, and the range in which it is turned. Integers stay integers.
#[derive(Debug, Clone, PartialEq)]
pub struct Knob {
    /// Key path below the machine file's root, `controller.integral` say.
    pub key: String,
    /// Smallest value.
    pub from: f64,
    /// Largest value.
    pub to: f64,
    /// Step of the map.
    pub step: f64,
    /// Whether the machine file holds an integer there.
    pub is_integer: bool,
}

impl Knob {
    /// A knob of a machine; without a step at most sixty values.
    ///
    /// # Errors
    /// A key that is no number of the machine's controller, a range that is none, a step that is not positive.
    pub fn new(machine: &Machine, key: &str, [from, to]: [f64; 2], step: Option<f64>) -> Result<Self> {
        let is_integer = machine.is_integer(key);
        let usual = (to - from) / (VALUES - 1.0);
        let usual = if is_integer { usual.ceil().max(1.0) } else { usual };
        let knob = Self { key: key.to_owned(), from, to, step: step.unwrap_or(usual), is_integer };
        knob.check(machine)?;
        Ok(knob)
    }

    /// The gains that an operator turns first, over the usual range: the registers of a PDF law; position and velocity
    /// gain of a cascade, and its integral gain where it has one; the gains of a P or PD law.
    ///
    /// # Errors
    /// As [`Knob::new`].
    pub fn usual(machine: &Machine) -> Result<Vec<Self>> {
        let keys: &[&str] = match &machine.description().controller {
            None => &[],
            Some(Controller::Pdf(_)) => &["integral", "proportional"],
            Some(law @ Controller::Cascade(_)) if law.integrates() => {
                &["position_gain_per_s", "velocity_gain_v_s_per_m", "velocity_integral_per_s"]
            }
            Some(Controller::Cascade(_)) => &["position_gain_per_s", "velocity_gain_v_s_per_m"],
            Some(Controller::Pd(law)) if law.derivative_gain_v_s_per_m != 0.0 => {
                &["position_gain_v_per_m", "derivative_gain_v_s_per_m"]
            }
            Some(Controller::Pd(_)) => &["position_gain_v_per_m"],
        };
        let own = |key: &&str| {
            let mut key = format!("controller.{key}");
            if machine.number(&key).is_none() {
                key = key.replace("_per_m", "_per_rad");
            }
            key
        };
        let knob = |key: String| {
            let now = machine.number(&key).unwrap_or(0.0);
            let [from, to] = USUAL.map(|factor| factor * now);
            let range = if machine.is_integer(&key) { [from.round(), to.round()] } else { [from, to] };
            Self::new(machine, &key, range, None)
        };
        keys.iter().map(own).map(knob).collect()
    }

    /// The value that the machine states.
    ///
    /// # Errors
    /// A key at which it states no number.
    pub fn stated(&self, machine: &Machine) -> Result<f64> {
        machine.number(&self.key).ok_or_else(|| self.refusal(machine, "a key without a number".to_owned()))
    }

    pub(super) fn check(&self, machine: &Machine) -> Result<()> {
        if !self.key.starts_with("controller.") {
            return Err(self.refusal(machine, "a key that is not of the controller".to_owned()));
        }
        self.stated(machine)?;
        let Self { from, to, step, .. } = *self;
        if !(from.is_finite() && to.is_finite() && from < to && step.is_finite() && step > 0.0) {
            return Err(self.refusal(machine, format!("the range {from}..{to} in steps of {step}")));
        }
        if self.is_integer && [from, to, step].iter().any(|x| x.fract() != 0.0) {
            return Err(self.refusal(machine, format!("the range {from}..{to}:{step} of an integer")));
        }
        [from, to].into_iter().try_for_each(|end| self.check_value(machine, end))
    }

    /// Refuses a value that it cannot have.
    pub(super) fn check_value(&self, machine: &Machine, value: f64) -> Result<()> {
        machine.check_turned(&self.key, value).map_err(|error| error.key(self.key.clone()))
    }

    fn refusal(&self, machine: &Machine, found: String) -> Error {
        Error::new(ErrorKind::OutOfRange)
            .file(machine.file())
            .key(self.key.clone())
            .found(found)
            .expected("a number that stands below [controller], with a range from less to more")
            .remedy("write for instance --vary controller.integral=6..65 or --vary controller.position_gain_per_s=3..12:0.5")
    }

    /// A setting of it as the machine file holds it.
    pub fn value(&self, value: f64) -> toml::Value {
        turned(value, self.is_integer)
    }

    /// The last step of a search.
    pub(super) fn finest(&self) -> f64 {
        if self.is_integer { 1.0 } else { FINEST * (self.to - self.from) }
    }

    /// The nearest value inside the range.
    pub(super) fn inside(&self, value: f64) -> f64 {
        let value = value.clamp(self.from, self.to);
        if self.is_integer { value.round() } else { value }
    }
}

/// `KEY=FROM..TO` or `KEY=FROM..TO:STEP`, before it is known which machine it is of.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// Key path.
    pub key: String,
    /// From, to.
    pub range: [f64; 2],
    /// Step, where one is written.
    pub step: Option<f64>,
}

impl FromStr for Written {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let example = "write for instance controller.integral=6..65 or controller.proportional=100..395:5";
        let refuse = || format!("`{text}` is not KEY=FROM..TO; {example}");
        let (key, range) = text.split_once('=').ok_or_else(refuse)?;
        let (range, step) = match range.split_once(':') {
            Some((range, step)) => (range, Some(step.trim().parse::<f64>().map_err(|_| refuse())?)),
            None => (range, None),
        };
        let (from, to) = range.split_once("..").ok_or_else(refuse)?;
        let number = |text: &str| text.trim().parse::<f64>().map_err(|_| refuse());
        Ok(Self { key: key.trim().to_owned(), range: [number(from)?, number(to)?], step })
    }
}
