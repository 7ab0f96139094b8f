//! Quantities and units: everything inside is SI, converted once at the door.
//!
//! [`Unit::parse`] reads the spellings that drives, oscilloscopes and data sheets use; [`engineering`] writes
//! an SI value back in the unit an engineer would choose.

mod engineering;
mod magnitude;

use std::f64::consts::{PI, TAU};
use std::fmt;

pub use engineering::engineering;
pub use magnitude::{SMALLEST, largest};
use serde::{Deserialize, Serialize};

use crate::error::{Error, ErrorKind, Result};

/// How the driven axis moves; decides whether its coordinate is in m or rad, its effort in N or N·m.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// Straight-line motion: position in m, effort in N.
    Prismatic,
    /// Rotation about one axis: position in rad, effort in N·m.
    Revolute,
}

impl fmt::Display for Motion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Prismatic => "prismatic",
            Self::Revolute => "revolute",
        })
    }
}

/// What a unit measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Dimension {
    /// A bare ratio.
    Ratio,
    /// Time in s.
    Time,
    /// Frequency in Hz.
    Frequency,
    /// Length in m.
    Length,
    /// Plane angle in rad.
    Angle,
    /// Velocity in m/s.
    Velocity,
    /// Angular velocity in rad/s.
    AngularVelocity,
    /// Acceleration in m/s².
    Acceleration,
    /// Angular acceleration in rad/s².
    AngularAcceleration,
    /// Voltage in V.
    Voltage,
    /// Current in A.
    Current,
    /// Force in N.
    Force,
    /// Torque in N·m.
    Torque,
    /// Mass in kg.
    Mass,
    /// Resistance in Ω.
    Resistance,
    /// Inductance in H.
    Inductance,
}

impl Dimension {
    /// The word for it: "length", "angular velocity".
    pub fn name(self) -> &'static str {
        match self {
            Self::Ratio => "ratio",
            Self::Time => "time",
            Self::Frequency => "frequency",
            Self::Length => "length",
            Self::Angle => "angle",
            Self::Velocity => "velocity",
            Self::AngularVelocity => "angular velocity",
            Self::Acceleration => "acceleration",
            Self::AngularAcceleration => "angular acceleration",
            Self::Voltage => "voltage",
            Self::Current => "current",
            Self::Force => "force",
            Self::Torque => "torque",
            Self::Mass => "mass",
            Self::Resistance => "resistance",
            Self::Inductance => "inductance",
        }
    }

    /// The SI unit that values of this dimension have inside.
    pub fn si_symbol(self) -> &'static str {
        match self {
            Self::Ratio => "1",
            Self::Time => "s",
            Self::Frequency => "Hz",
            Self::Length => "m",
            Self::Angle => "rad",
            Self::Velocity => "m/s",
            Self::AngularVelocity => "rad/s",
            Self::Acceleration => "m/s²",
            Self::AngularAcceleration => "rad/s²",
            Self::Voltage => "V",
            Self::Current => "A",
            Self::Force => "N",
            Self::Torque => "N·m",
            Self::Mass => "kg",
            Self::Resistance => "Ω",
            Self::Inductance => "H",
        }
    }

    /// The symbols of every unit known for this dimension, SI first.
    pub fn symbols(self) -> Vec<&'static str> {
        let mut symbols: Vec<_> =
            UNITS.iter().filter(|unit| unit.dimension == self).map(|unit| unit.symbol).collect();
        symbols.sort_by_key(|symbol| *symbol != self.si_symbol());
        symbols
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A unit of measurement: SI value = reading · numerator / denominator.
///
/// Kept as a quotient so that a decimal unit costs one rounding at most: 7.45 mm becomes the double nearest to
/// 0.00745 m.
///
/// ```
/// use slideway::units::{Dimension, Unit};
/// let millimetre = Unit::parse("mm")?;
/// assert_eq!(millimetre.to_si(7.45), 0.00745);
/// assert_eq!(millimetre.dimension(), Dimension::Length);
/// assert_eq!(Unit::parse("µm")?, Unit::parse("um")?);
/// assert!((Unit::parse("rpm")?.to_si(60.0) - std::f64::consts::TAU).abs() < 1e-15);
/// # Ok::<(), slideway::error::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    symbol: &'static str,
    dimension: Dimension,
    numerator: f64,
    denominator: f64,
    /// Further spellings, after the clean-up of [`normalise`], separated by blanks.
    spellings: &'static str,
}

const fn unit(
    symbol: &'static str,
    dimension: Dimension,
    numerator: f64,
    denominator: f64,
    spellings: &'static str,
) -> Unit {
    Unit { symbol, dimension, numerator, denominator, spellings }
}

use Dimension as D;
/// Every unit known, by dimension; the SI unit has the quotient 1/1.
static UNITS: &[Unit] = &[
    unit("1", D::Ratio, 1.0, 1.0, "-"),
    unit("%", D::Ratio, 1.0, 100.0, "percent"),
    unit("s", D::Time, 1.0, 1.0, "sec second seconds"),
    unit("ms", D::Time, 1.0, 1e3, "msec"),
    unit("µs", D::Time, 1.0, 1e6, "usec"),
    unit("ns", D::Time, 1.0, 1e9, "nsec"),
    unit("min", D::Time, 60.0, 1.0, ""),
    unit("Hz", D::Frequency, 1.0, 1.0, "1/s s^-1"),
    unit("kHz", D::Frequency, 1e3, 1.0, ""),
    unit("m", D::Length, 1.0, 1.0, "metre meter metres meters"),
    unit("cm", D::Length, 1.0, 1e2, ""),
    unit("mm", D::Length, 1.0, 1e3, "millimetre millimeter"),
    unit("µm", D::Length, 1.0, 1e6, "micron"),
    unit("nm", D::Length, 1.0, 1e9, ""),
    unit("in", D::Length, 254.0, 1e4, "inch inches"),
    unit("rad", D::Angle, 1.0, 1.0, "radian radians"),
    unit("mrad", D::Angle, 1.0, 1e3, ""),
    unit("µrad", D::Angle, 1.0, 1e6, ""),
    unit("deg", D::Angle, PI, 180.0, "° degree degrees"),
    unit("mdeg", D::Angle, PI, 180e3, "m°"),
    unit("arcmin", D::Angle, PI, 10_800.0, ""),
    unit("arcsec", D::Angle, PI, 648_000.0, ""),
    unit("rev", D::Angle, TAU, 1.0, "turn turns revolution revolutions"),
    unit("m/s", D::Velocity, 1.0, 1.0, "mps ms^-1"),
    unit("mm/s", D::Velocity, 1.0, 1e3, "mmps"),
    unit("µm/s", D::Velocity, 1.0, 1e6, ""),
    unit("m/min", D::Velocity, 1.0, 60.0, ""),
    unit("mm/min", D::Velocity, 1.0, 6e4, ""),
    unit("in/s", D::Velocity, 254.0, 1e4, ""),
    unit("in/min", D::Velocity, 254.0, 6e5, "ipm"),
    unit("rad/s", D::AngularVelocity, 1.0, 1.0, ""),
    unit("mrad/s", D::AngularVelocity, 1.0, 1e3, ""),
    unit("deg/s", D::AngularVelocity, PI, 180.0, "°/s"),
    unit("rpm", D::AngularVelocity, TAU, 60.0, "RPM r/min rev/min 1/min min^-1 U/min"),
    unit("rev/s", D::AngularVelocity, TAU, 1.0, "rps r/s"),
    unit("m/s²", D::Acceleration, 1.0, 1.0, "m/s2 m/s^2"),
    unit("mm/s²", D::Acceleration, 1.0, 1e3, "mm/s2 mm/s^2"),
    unit("g0", D::Acceleration, 980_665.0, 1e5, "gn"),
    unit("rad/s²", D::AngularAcceleration, 1.0, 1.0, "rad/s2 rad/s^2"),
    unit("V", D::Voltage, 1.0, 1.0, "volt volts"),
    unit("mV", D::Voltage, 1.0, 1e3, ""),
    unit("kV", D::Voltage, 1e3, 1.0, ""),
    unit("A", D::Current, 1.0, 1.0, "amp ampere amperes"),
    unit("mA", D::Current, 1.0, 1e3, ""),
    unit("N", D::Force, 1.0, 1.0, "newton newtons"),
    unit("mN", D::Force, 1.0, 1e3, ""),
    unit("kN", D::Force, 1e3, 1.0, ""),
    unit("lbf", D::Force, 4.448_221_615_260_5, 1.0, ""),
    unit("N·m", D::Torque, 1.0, 1.0, ""),
    unit("mN·m", D::Torque, 1.0, 1e3, ""),
    unit("N·mm", D::Torque, 1.0, 1e3, ""),
    unit("N·cm", D::Torque, 1.0, 1e2, ""),
    unit("kN·m", D::Torque, 1e3, 1.0, ""),
    unit("kg", D::Mass, 1.0, 1.0, ""),
    unit("g", D::Mass, 1.0, 1e3, "gram grams"),
    unit("t", D::Mass, 1e3, 1.0, "tonne"),
    unit("Ω", D::Resistance, 1.0, 1.0, "ohm Ohm"),
    unit("mΩ", D::Resistance, 1.0, 1e3, "mohm mOhm"),
    unit("H", D::Inductance, 1.0, 1.0, "henry"),
    unit("mH", D::Inductance, 1.0, 1e3, ""),
    unit("µH", D::Inductance, 1.0, 1e6, ""),
];

/// One spelling out of many: no blanks or brackets, one micro sign, one product dot (or none).
fn normalise(text: &str) -> String {
    let bare = text.trim();
    let bare = [('[', ']'), ('(', ')')]
        .iter()
        .find_map(|&(open, close)| bare.strip_prefix(open)?.strip_suffix(close))
        .unwrap_or(bare);
    bare.chars()
        .filter_map(|letter| match letter {
            letter if letter.is_whitespace() => None,
            '·' | '*' | '.' | '⋅' | '∙' => None,
            'µ' | 'μ' => Some('u'),
            '\u{2126}' => Some('Ω'),
            letter => Some(letter),
        })
        .collect()
}

impl Unit {
    /// Reads a unit in any of the usual spellings ("µm", "um", "N·m", "Nm", "N*m", "[mm/min]").
    ///
    /// Upper and lower case matter: mN and MN differ.
    ///
    /// # Errors
    /// [`ErrorKind::Unit`] when the spelling is not known, with every known unit.
    pub fn parse(text: &str) -> Result<Self> {
        Self::find(text).ok_or_else(|| {
            let all = UNITS.iter().map(|unit| unit.symbol).collect::<Vec<_>>().join(", ");
            unknown(text, &format!("one of {all}"))
        })
    }

    /// Reads a unit that must measure `dimension`.
    ///
    /// # Errors
    /// [`ErrorKind::Unit`] when the spelling is unknown or measures something else; lists the units that fit.
    pub fn parse_as(text: &str, dimension: Dimension) -> Result<Self> {
        let fitting = format!("a unit of {dimension}: {}", dimension.symbols().join(", "));
        let unit = Self::find(text).ok_or_else(|| unknown(text, &fitting))?;
        if unit.dimension == dimension {
            return Ok(unit);
        }
        Err(Error::new(ErrorKind::Unit)
            .found(format!("unit `{text}`, a unit of {}", unit.dimension))
            .expected(fitting)
            .remedy("correct the unit, or map the column to the signal that it really holds"))
    }

    fn find(text: &str) -> Option<Self> {
        let wanted = normalise(text);
        let fits = |unit: &&Unit| {
            normalise(unit.symbol) == wanted || unit.spellings.split(' ').any(|word| word == wanted)
        };
        if wanted.is_empty() { None } else { UNITS.iter().find(fits).copied() }
    }

    /// The SI unit of a dimension.
    pub fn si(dimension: Dimension) -> Self {
        unit(dimension.si_symbol(), dimension, 1.0, 1.0, "")
    }

    /// The symbol as printed in reports.
    pub fn symbol(self) -> &'static str {
        self.symbol
    }

    /// What the unit measures.
    pub fn dimension(self) -> Dimension {
        self.dimension
    }

    /// How many SI units one of these is.
    pub fn factor(self) -> f64 {
        self.numerator / self.denominator
    }

    /// Numerator and denominator of the factor, each exact or one rounding off.
    pub fn quotient(self) -> (f64, f64) {
        (self.numerator, self.denominator)
    }

    /// A reading in this unit, in SI.
    pub fn to_si(self, reading: f64) -> f64 {
        reading * self.numerator / self.denominator
    }

    /// An SI value, in this unit.
    pub fn from_si(self, value: f64) -> f64 {
        value * self.denominator / self.numerator
    }
}

fn unknown(text: &str, expected: &str) -> Error {
    let wanted = normalise(text).to_lowercase();
    let near = UNITS.iter().find(|unit| normalise(unit.symbol).to_lowercase() == wanted);
    let remedy = match near {
        Some(unit) => format!("upper and lower case matter: `{}` was probably meant", unit.symbol),
        None => "write one of these, or give the number of SI units that one count is".to_owned(),
    };
    Error::new(ErrorKind::Unit).found(format!("unknown unit `{text}`")).expected(expected).remedy(remedy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_every_unit_is_found_by_all_its_spellings() {
        for unit in UNITS {
            assert_eq!(Unit::parse(unit.symbol).unwrap().symbol, unit.symbol);
            for word in unit.spellings.split(' ').filter(|word| !word.is_empty()) {
                assert_eq!(Unit::parse(word).unwrap().symbol, unit.symbol, "{word}");
            }
        }
    }

    #[test]
    fn exact_no_spelling_means_two_units() {
        let mut seen = std::collections::BTreeMap::new();
        for unit in UNITS {
            let own = normalise(unit.symbol);
            let words = unit.spellings.split(' ').map(str::to_owned).filter(|word| !word.is_empty());
            for word in std::iter::once(own).chain(words) {
                assert_eq!(seen.insert(word.clone(), unit.symbol), None, "{word}");
            }
        }
    }

    #[test]
    fn exact_every_dimension_has_its_si_unit_with_factor_one() {
        for unit in UNITS {
            let si = Unit::parse_as(unit.dimension.si_symbol(), unit.dimension).unwrap();
            assert_eq!(si.factor(), 1.0);
            assert_eq!(unit.dimension.symbols()[0], unit.dimension.si_symbol());
        }
    }
}
