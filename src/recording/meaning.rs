//! What a column of a bare log means, from the words and the unit of its header.

use super::signal::{Signal, TIME_KEY};
use crate::units::{Dimension, Motion, Unit};

/// What the header of a column says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Meaning {
    /// Time.
    Time,
    /// A signal of the axis.
    Signal(Signal),
    /// Nothing that an axis logs, or a quantity that has no signal: a following error, a set current.
    Nothing,
}

impl Meaning {
    /// The canonical key.
    pub(super) fn key(self, motion: Motion) -> &'static str {
        match self {
            Self::Time => TIME_KEY,
            Self::Signal(signal) => signal.key(motion),
            Self::Nothing => "-",
        }
    }

    /// What it measures.
    pub(super) fn dimension(self, motion: Motion) -> Dimension {
        match self {
            Self::Signal(signal) => signal.dimension(motion),
            _ => Dimension::Time,
        }
    }

    /// The meaning of a canonical key, or of `-` for nothing.
    pub(super) fn from_key(key: &str, motion: Motion) -> Option<Self> {
        match key {
            TIME_KEY => Some(Self::Time),
            "-" => Some(Self::Nothing),
            _ => {
                let (signal, own) = Signal::from_key(key)?;
                own.is_none_or(|own| own == motion).then_some(Self::Signal(signal))
            }
        }
    }
}

/// What is measured, before it is known whether it was told or measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Quantity {
    Time,
    Position,
    Velocity,
    Current,
    Effort,
    Force,
    Supply,
    Enable,
}

/// Words of a header, in English and German, and the quantity that they name; longer words first where one holds another.
const QUANTITIES: &[(Quantity, &[&str])] = &[
    (Quantity::Time, &["time", "timestamp", "t", "zeit", "clock", "seconds"]),
    (Quantity::Supply, &["supply", "vbus", "vdc", "dclink", "zwischenkreis"]),
    (Quantity::Enable, &["enable", "enabled", "torqueenabled", "freigabe"]),
    (
        Quantity::Position,
        &["position", "pos", "angle", "lage", "winkel", "istposition", "sollposition", "q", "x"],
    ),
    (
        Quantity::Velocity,
        &["velocity", "vel", "speed", "geschwindigkeit", "drehzahl", "omega", "feed", "v", "qd"],
    ),
    (Quantity::Current, &["current", "curr", "iq", "strom", "amps", "i"]),
    (
        Quantity::Effort,
        &["effort", "controleffort", "voltage", "dac", "spannung", "stellgroesse", "stellgröße", "u"],
    ),
    (Quantity::Force, &["force", "thrust", "torque", "trq", "moment", "drehmoment", "kraft", "tau", "f"]),
];
/// Words of what an axis was told, …
const TOLD: &[&str] = &[
    "reference",
    "ref",
    "command",
    "commanded",
    "cmd",
    "set",
    "setpoint",
    "soll",
    "target",
    "desired",
    "des",
    "demand",
    "sp",
    "sollposition",
    "sollgeschwindigkeit",
];
/// … of a second sensor at the load, …
const AT_LOAD: &[&str] = &["load", "scale", "external", "ext", "second", "linear", "maßstab", "massstab"];
/// … and of what is no signal of the list.
const OTHER: &[&str] = &[
    "error",
    "err",
    "following",
    "lag",
    "deviation",
    "diff",
    "schleppfehler",
    "schleppabstand",
    "temperature",
    "temp",
    "disturbance",
    "limit",
    "max",
    "min",
    "feedforward",
    "ff",
    "acceleration",
    "acc",
    "jerk",
    "power",
];

/// A header taken apart.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    /// Without the unit.
    pub(super) name: String,
    /// The unit as written, where one was.
    pub(super) unit: Option<String>,
}

impl Header {
    /// `pos_act [mm]`, `pos_act (mm)`, `pos_act/mm`, or `pos_act_mm`; a units row goes first.
    pub(super) fn of(column: &str, units_row: Option<&str>) -> Self {
        let column = column.trim();
        let own = |name: &str, unit: &str| Self {
            name: name.trim().to_owned(),
            unit: Some(unit.trim().to_owned()),
        };
        if let Some(unit) = units_row.map(bare).filter(|unit| !unit.is_empty()) {
            let name = in_brackets(column).map_or(column, |(name, _)| name);
            return own(name, unit);
        }
        if let Some((name, unit)) = in_brackets(column) {
            return own(name, unit);
        }
        for mark in ['/', '_', ' '] {
            if let Some((name, unit)) = column.rsplit_once(mark)
                && Unit::parse(unit).is_ok()
                && words(name).iter().any(|word| quantity(word).is_some())
            {
                return own(name, unit);
            }
        }
        Self { name: column.to_owned(), unit: None }
    }

    /// What the words say.
    pub(super) fn meaning(&self, motion: Motion) -> Meaning {
        let mut words = words(&self.name);
        // A unit behind a word that names no quantity names none either: `pulse_V` is no velocity.
        let last = self.name.rsplit(['_', ' ', '/']).next().filter(|last| Unit::parse(last).is_ok());
        if words.len() > 1 && last.is_some_and(|last| last.chars().all(char::is_uppercase)) {
            words.pop();
        }
        let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
        if has(OTHER) {
            return Meaning::Nothing;
        }
        // A unit decides where letters are used for several quantities.
        let dimension = self.unit.as_ref().and_then(|unit| Unit::parse(unit).ok()).map(Unit::dimension);
        let named = words.iter().filter_map(|word| quantity(word));
        let fits = |quantity: &Quantity| dimension.is_none_or(|d| quantity.measures(motion).contains(&d));
        let Some(quantity) = named.clone().find(fits).or_else(|| named.clone().next()) else {
            return Meaning::Nothing;
        };
        let (told, at_load) = (has(TOLD), has(AT_LOAD));
        let signal = match quantity {
            Quantity::Time => return Meaning::Time,
            Quantity::Position if told => Signal::PositionReference,
            Quantity::Position if at_load => Signal::LoadPosition,
            Quantity::Position => Signal::Position,
            Quantity::Velocity if told => Signal::VelocityReference,
            Quantity::Velocity if at_load => return Meaning::Nothing,
            Quantity::Velocity => Signal::Velocity,
            // A set current or torque is told to an inner loop; what the motor did is another signal.
            Quantity::Current | Quantity::Force if told => return Meaning::Nothing,
            Quantity::Current => Signal::Current,
            Quantity::Force => Signal::Thrust,
            Quantity::Effort => Signal::ControlEffort,
            Quantity::Supply => Signal::SupplyVoltage,
            Quantity::Enable => Signal::TorqueEnabled,
        };
        Meaning::Signal(signal)
    }
}

impl Quantity {
    fn measures(self, motion: Motion) -> Vec<Dimension> {
        let of = |signal: Signal| vec![signal.dimension(motion)];
        match self {
            Self::Time => vec![Dimension::Time],
            Self::Position => of(Signal::Position),
            Self::Velocity => of(Signal::Velocity),
            Self::Current => of(Signal::Current),
            Self::Effort => of(Signal::ControlEffort),
            Self::Force => of(Signal::Thrust),
            Self::Supply => of(Signal::SupplyVoltage),
            Self::Enable => of(Signal::TorqueEnabled),
        }
    }
}

fn quantity(word: &str) -> Option<Quantity> {
    QUANTITIES.iter().find(|(_, words)| words.contains(&word)).map(|(quantity, _)| *quantity)
}

/// A name and the unit in brackets behind it.
fn in_brackets(column: &str) -> Option<(&str, &str)> {
    [('[', ']'), ('(', ')')].iter().find_map(|&(open, close)| column.strip_suffix(close)?.rsplit_once(open))
}

/// A unit without brackets about it.
fn bare(unit: &str) -> &str {
    let unit = unit.trim();
    let inside = [('[', ']'), ('(', ')')];
    inside
        .iter()
        .find_map(|&(open, close)| unit.strip_prefix(open)?.strip_suffix(close))
        .unwrap_or(unit)
        .trim()
}

/// The words of a name in small letters: `ActPos`, `act_pos` and `Axis.Act pos` have the same last two.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for letter in name.chars() {
        let parts = !letter.is_alphabetic() || (letter.is_uppercase() && before.is_lowercase());
        if parts {
            words.push(String::new());
        }
        if let (true, Some(word)) = (letter.is_alphabetic(), words.last_mut()) {
            word.extend(letter.to_lowercase());
        }
        before = letter;
    }
    words.retain(|word| !word.is_empty());
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use Signal::{
        ControlEffort, Current, LoadPosition, Position, PositionReference, Thrust, Velocity,
        VelocityReference,
    };

    #[test]
    fn exact_headers_of_drives_are_understood() {
        let meant = |column: &str| {
            let header = Header::of(column, None);
            (header.meaning(Motion::Prismatic), header.unit.unwrap_or_default())
        };
        for (column, signal, unit) in [
            ("pos_act [mm]", Position, "mm"),
            ("Axis1.ActPos (µm)", Position, "µm"),
            ("Sollposition [mm]", PositionReference, "mm"),
            ("x_cmd_mm", PositionReference, "mm"),
            ("SetVelo velocity set [mm/s]", VelocityReference, "mm/s"),
            ("vel [m/min]", Velocity, "m/min"),
            ("Strom Iq [A]", Current, "A"),
            ("ControlEffort [V]", ControlEffort, "V"),
            ("motor force [N]", Thrust, "N"),
            ("scale position [mm]", LoadPosition, "mm"),
            ("position", Position, ""),
        ] {
            assert_eq!(meant(column), (Meaning::Signal(signal), unit.to_owned()), "{column}");
        }
        assert_eq!(meant("Time [ms]"), (Meaning::Time, "ms".to_owned()));
        assert_eq!(meant("time_s"), (Meaning::Time, "s".to_owned()));
        for column in ["following error [mm]", "iq_ref [A]", "Temperature [°C]", "digital input 3", "pulse_V"]
        {
            assert_eq!(meant(column).0, Meaning::Nothing, "{column}");
        }
    }

    #[test]
    fn exact_a_units_row_goes_first() {
        let header = Header::of("pos_act", Some("[mm]"));
        assert_eq!((header.name.as_str(), header.unit.as_deref()), ("pos_act", Some("mm")));
        assert_eq!(Header::of("pos_act", Some("")).unit, None);
    }
}
