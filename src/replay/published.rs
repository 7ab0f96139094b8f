//! Figures of merit that others stated for a run, to be laid beside one's own.

use crate::error::{Error, ErrorKind, Result};
use crate::recording::{Run, Signal};
use crate::units::Unit;

/// The key of a run under which a recording states them.
pub const RUN_KEY: &str = "published";
const KEYS: [&str; 3] = ["unit", "mae", "r2"];

/// Figures of merit of one signal as they were stated:
/// ```toml
/// published.position_rad = { unit = "deg", mae = 0.3002, r2 = 1.0 }
/// ```
/// The unit is that of the mean absolute error; SI where there is none.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// Of which signal.
    pub signal: Signal,
    /// The unit in which they were stated, and in which one's own are shown.
    pub unit: Unit,
    /// Mean absolute error in that unit.
    pub mae: Option<f64>,
    /// Coefficient of determination.
    pub r2: Option<f64>,
}

impl Published {
    /// Those that a run states; none where it states none.
    ///
    /// # Errors
    /// A signal that there is none of, a unit that does not measure it, keys beyond those listed, numbers that are none.
    pub fn of(run: &Run) -> Result<Vec<Self>> {
        let Some(value) = run.metadata.get(RUN_KEY) else { return Ok(Vec::new()) };
        let expected =
            "a table a signal, such as published.position_rad = { unit = \"deg\", mae = 0.3, r2 = 1.0 }";
        let table = value.as_table().ok_or_else(|| refused(run, "", value, expected))?;
        table.iter().map(|(key, value)| Self::read(run, key, value)).collect()
    }

    fn read(run: &Run, key: &str, value: &toml::Value) -> Result<Self> {
        let motion = run.motion();
        let known =
            Signal::from_key(key).filter(|(signal, _)| signal.key(motion) == key && signal.is_measured());
        let Some((signal, _)) = known else {
            let measured = Signal::ALL.into_iter().filter(|signal| signal.is_measured());
            let keys: Vec<&str> = measured.map(|signal| signal.key(motion)).collect();
            return Err(refused(run, key, &key.into(), &format!("one of {}", keys.join(", "))));
        };
        let expected = "a table such as { unit = \"deg\", mae = 0.3, r2 = 1.0 }";
        let table = value.as_table().ok_or_else(|| refused(run, key, value, expected))?;
        if let Some(other) = table.keys().find(|name| !KEYS.contains(&name.as_str())) {
            return Err(refused(run, key, &other.as_str().into(), &format!("the keys {}", KEYS.join(", "))));
        }
        let dimension = signal.dimension(motion);
        let unit = match table.get("unit") {
            None => Unit::si(dimension),
            Some(unit) => {
                let text = unit
                    .as_str()
                    .ok_or_else(|| refused(run, &format!("{key}.unit"), unit, "a unit in quotes"))?;
                Unit::parse_as(text, dimension).map_err(|error| at(error, run, &format!("{key}.unit")))?
            }
        };
        let number = |name: &str| -> Result<Option<f64>> {
            let Some(value) = table.get(name) else { return Ok(None) };
            let number = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
            let number = number.filter(|number| number.is_finite());
            number.map(Some).ok_or_else(|| refused(run, &format!("{key}.{name}"), value, "a finite number"))
        };
        Ok(Self { signal, unit, mae: number("mae")?, r2: number("r2")? })
    }
}

/// An error about a run's key: its file, its name and the key.
fn at(error: Error, run: &Run, key: &str) -> Error {
    let key = format!("{}.{RUN_KEY}.{key}", run.name());
    let error = error.key(key.trim_end_matches('.'));
    if run.file.as_os_str().is_empty() { error } else { error.file(&run.file) }
}

fn refused(run: &Run, key: &str, value: &toml::Value, expected: &str) -> Error {
    at(Error::new(ErrorKind::Syntax), run, key)
        .found(value.to_string())
        .expected(expected)
        .remedy("correct the run's table in recording.toml, or leave it out")
}
