//! `[columns]`: which column holds which signal, in which unit, and the conversion to SI.

use std::collections::BTreeMap;
use std::fmt;

use super::document::{Document, Step, number, text_at};
use super::signal::{Signal, TIME_KEY};
use crate::error::{Error, ErrorKind, Result};
use crate::units::{Dimension, Motion, Unit};

pub(super) const KEYS: [&str; 4] = ["column", "unit", "scale", "offset"];

/// Where one signal comes from: si = (reading · numerator / denominator) · scale + offset.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Source {
    pub(super) column: String,
    /// The unit as it was written, or "n per count".
    unit: String,
    numerator: f64,
    denominator: f64,
    scale: f64,
    offset: f64,
    /// Whether [columns] or the column's name says the unit, rather than the file.
    is_stated: bool,
}

impl Source {
    /// A column with the canonical name and SI unit.
    pub(super) fn canonical(key: &str, dimension: Dimension) -> Self {
        Self {
            column: key.to_owned(),
            unit: dimension.si_symbol().to_owned(),
            numerator: 1.0,
            denominator: 1.0,
            scale: 1.0,
            offset: 0.0,
            is_stated: false,
        }
    }

    /// Takes the unit that the file states for the column, unless [columns] says one; a canonical name says SI itself.
    ///
    /// # Errors
    /// A unit that is unknown or measures something else, or that contradicts the name.
    pub(super) fn adopt(&mut self, key: &str, stated: &str, dimension: Dimension) -> Result<()> {
        if self.is_stated {
            return Ok(());
        }
        let unit = Unit::parse_as(stated, dimension).map_err(|error| {
            error.key(self.column.clone()).remedy(format!(
                "state its unit in [columns]: `{key} = {{ column = \"{}\", unit = \"…\" }}`",
                self.column
            ))
        })?;
        if key == self.column && unit.factor() != 1.0 {
            return Err(Error::new(ErrorKind::Inconsistent)
                .key(key)
                .found(format!("a column named `{key}` whose unit the file states as {stated}"))
                .expected(format!("{}, as the name says", dimension.si_symbol()))
                .remedy(format!(
                    "state in [columns] which of them holds: `{key} = {{ unit = \"{stated}\" }}`"
                )));
        }
        self.unit = unit.symbol().to_owned();
        (self.numerator, self.denominator) = unit.quotient();
        Ok(())
    }

    /// A column in a unit.
    pub(super) fn in_unit(column: &str, unit: Unit) -> Self {
        let (numerator, denominator) = unit.quotient();
        let unit = unit.symbol().to_owned();
        Self {
            column: column.to_owned(),
            unit,
            numerator,
            denominator,
            scale: 1.0,
            offset: 0.0,
            is_stated: true,
        }
    }

    /// Whether readings are taken over unchanged.
    fn is_plain(&self) -> bool {
        self.numerator == self.denominator && self.scale == 1.0 && self.offset == 0.0
    }

    /// Column and unit as `[columns]` states them; none where the canonical name and SI unit say it.
    pub(super) fn stated(&self, key: &str) -> Option<(&str, &str)> {
        (self.column != key || !self.is_plain()).then_some((self.column.as_str(), self.unit.as_str()))
    }

    /// Converts a column in place.
    pub(super) fn convert(&self, samples: &mut [f64]) {
        if self.is_plain() {
            return;
        }
        for sample in samples {
            *sample = (*sample * self.numerator / self.denominator) * self.scale + self.offset;
        }
    }
}

/// One conversion at the door, for reports: which column became which signal, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct Conversion {
    /// The canonical name.
    pub key: String,
    /// The SI unit of the signal.
    pub si_unit: &'static str,
    /// The column of the file.
    pub column: String,
    /// The unit in which the column was read.
    pub unit: String,
    /// SI units that one reading of 1 makes, the scale included.
    pub factor: f64,
    /// The scale in it that corrects the reading (1 when none was given).
    pub scale: f64,
    /// Added in SI afterwards.
    pub offset: f64,
    /// The runs that were read so.
    pub runs: Vec<String>,
}

impl Conversion {
    pub(super) fn new(key: &str, dimension: Dimension, source: &Source, run: &str) -> Self {
        Self {
            key: key.to_owned(),
            si_unit: dimension.si_symbol(),
            column: source.column.clone(),
            unit: source.unit.clone(),
            factor: source.numerator / source.denominator * source.scale,
            scale: source.scale,
            offset: source.offset,
            runs: vec![run.to_owned()],
        }
    }

    pub(super) fn is_needless(&self) -> bool {
        self.key == self.column && self.factor == 1.0 && self.offset == 0.0
    }

    pub(super) fn same_but_runs(&self, other: &Self) -> bool {
        let bare = |conversion: &Self| Self { runs: Vec::new(), ..conversion.clone() };
        bare(self) == bare(other)
    }
}

impl fmt::Display for Conversion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} from column `{}` [{}]", self.key, self.column, self.unit)?;
        if self.factor != 1.0 {
            write!(f, " × {} {}", self.factor, self.si_unit)?;
        }
        if self.scale != 1.0 {
            write!(f, " (a scale of {} in it)", self.scale)?;
        }
        if self.offset != 0.0 {
            write!(f, " + {} {}", self.offset, self.si_unit)?;
        }
        Ok(())
    }
}

/// The `[columns]` of a recording or of one run.
#[derive(Debug, Clone, Default)]
pub(super) struct ColumnMap {
    pub(super) time: Option<Source>,
    /// By canonical key, which fixes signal and motion.
    pub(super) signals: BTreeMap<String, Source>,
}

impl ColumnMap {
    /// Reads the table at `steps`, if it is there.
    pub(super) fn read(document: &Document, steps: &[Step<'_>]) -> Result<Self> {
        let mut map = Self::default();
        let Some(value) = find(&document.values, steps) else { return Ok(map) };
        let expected = "a table such as `position_m = { column = \"pos\", unit = \"mm\" }`";
        let table = value.as_table().ok_or_else(|| document.wrong_type(steps, value, expected))?;
        for (key, value) in table {
            let steps = [steps, &[Step::Key(key)]].concat();
            if key == TIME_KEY {
                map.time = Some(read_source(document, &steps, value, Dimension::Time)?);
                continue;
            }
            let Some((signal, motion)) = Signal::from_key(key) else {
                return Err(document.unknown_key(&steps, key, &Signal::keys(None)));
            };
            let dimension = signal.dimension(motion.unwrap_or(Motion::Prismatic));
            map.signals.insert(key.clone(), read_source(document, &steps, value, dimension)?);
        }
        Ok(map)
    }

    /// This map with what a run says instead.
    pub(super) fn overridden_by(&self, run: Self) -> Self {
        let mut merged = self.clone();
        merged.time = run.time.or(merged.time);
        merged.signals.extend(run.signals);
        merged
    }
}

fn find<'a>(table: &'a toml::Table, steps: &[Step<'_>]) -> Option<&'a toml::Value> {
    let (first, rest) = steps.split_first()?;
    let Step::Key(key) = first else { return None };
    rest.iter().try_fold(table.get(*key)?, |value, step| match step {
        Step::Key(key) => value.get(key),
        Step::Index(index) => value.get(index),
    })
}

fn read_source(
    document: &Document,
    steps: &[Step<'_>],
    value: &toml::Value,
    dimension: Dimension,
) -> Result<Source> {
    let mut source = Source::canonical("", dimension);
    let table = match value {
        toml::Value::String(column) => {
            source.column.clone_from(column);
            return Ok(source);
        }
        toml::Value::Table(table) => table,
        other => {
            let expected = "a column name in quotes, or a table such as { column = \"pos\", unit = \"mm\" }";
            return Err(document.wrong_type(steps, other, expected));
        }
    };
    if let Some(name) = table.keys().find(|name| !KEYS.contains(&name.as_str())) {
        return Err(document.unknown_key(&[steps, &[Step::Key(name)]].concat(), name, &KEYS));
    }
    // Without `column` the canonical name stands, so that `position_m = { unit = "mm" }` says it all.
    let own_name = match steps.last() {
        Some(Step::Key(key)) => *key,
        _ => "",
    };
    source.column = text_at(document, table, steps, "column")?.unwrap_or(own_name).to_owned();
    if let Some(unit) = table.get("unit") {
        read_unit(document, steps, unit, dimension, &mut source)?;
    }
    if let Some(scale) = finite(document, table, steps, "scale")? {
        if scale == 0.0 {
            let steps = [steps, &[Step::Key("scale")]].concat();
            return Err(document
                .refuse(ErrorKind::OutOfRange, &steps)
                .found("0")
                .expected("a factor that is not zero")
                .remedy("leave `scale` out, or give the factor that corrects the reading"));
        }
        source.scale = scale;
    }
    source.offset = finite(document, table, steps, "offset")?.unwrap_or(0.0);
    Ok(source)
}

fn read_unit(
    document: &Document,
    steps: &[Step<'_>],
    value: &toml::Value,
    dimension: Dimension,
    source: &mut Source,
) -> Result<()> {
    let steps = [steps, &[Step::Key("unit")]].concat();
    source.is_stated = true;
    if let Some(text) = value.as_str() {
        let unit = Unit::parse_as(text, dimension).map_err(|error| relocate(document, &steps, &error))?;
        source.unit = unit.symbol().to_owned();
        (source.numerator, source.denominator) = unit.quotient();
        return Ok(());
    }
    let per_count = number(value).filter(|factor| factor.is_finite() && *factor > 0.0).ok_or_else(|| {
        let si = dimension.si_symbol();
        document.wrong_type(
            &steps,
            value,
            &format!("a unit in quotes, or a positive number of {si} per count"),
        )
    })?;
    source.unit = format!("{per_count} {} per count", dimension.si_symbol());
    source.numerator = per_count;
    Ok(())
}

/// The same refusal with file, line and key in front.
fn relocate(document: &Document, steps: &[Step<'_>], error: &Error) -> Error {
    let located = document.refuse(error.kind(), steps);
    let (row, key) = (located.row_number(), located.key_name().unwrap_or_default().to_owned());
    let error = error.clone().file(&document.path).key(key);
    match row {
        Some(row) => error.row(row),
        None => error,
    }
}

fn finite(document: &Document, table: &toml::Table, steps: &[Step<'_>], key: &str) -> Result<Option<f64>> {
    let Some(value) = table.get(key) else { return Ok(None) };
    let steps = [steps, &[Step::Key(key)]].concat();
    let finite = number(value).filter(|number| number.is_finite());
    finite.map(Some).ok_or_else(|| document.wrong_type(&steps, value, "a finite number"))
}
