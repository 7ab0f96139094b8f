//! Which columns of one file hold which signals.

use std::collections::BTreeMap;

use super::columns::{ColumnMap, Source};
use super::signal::{Signal, TIME_KEY};
use crate::error::{Error, ErrorKind, Result, spelling};
use crate::units::{Dimension, Motion};

/// Names of a time column in s: ours, and the one that PlotJuggler writes.
const TIME_NAMES: [&str; 2] = [TIME_KEY, "__time"];

/// The signals of one file: the mapped ones, and the columns that bear a canonical name.
#[derive(Debug)]
pub(super) struct Resolved {
    pub(super) motion: Option<Motion>,
    pub(super) time: Option<Source>,
    pub(super) signals: BTreeMap<Signal, (String, Source)>,
    pub(super) ignored: Vec<String>,
}

impl Resolved {
    /// Gives each column the unit that the file states for it, where nothing else says one.
    ///
    /// # Errors
    /// A unit that is unknown, measures something else or contradicts the name of its column.
    pub(super) fn adopt_units(&mut self, names: &[String], units: &[Option<String>]) -> Result<()> {
        let motion = self.motion.unwrap_or(Motion::Prismatic);
        let time = self.time.iter_mut().map(|source| (TIME_KEY, source, Dimension::Time));
        let signals = self.signals.iter_mut();
        let signals = signals.map(|(signal, (key, source))| (key.as_str(), source, signal.dimension(motion)));
        for (key, source, dimension) in time.chain(signals) {
            let place = names.iter().position(|name| *name == source.column);
            if let Some(stated) = place.and_then(|place| units.get(place)?.as_ref()) {
                source.adopt(key, stated, dimension)?;
            }
        }
        Ok(())
    }
}

/// Finds the columns of a file that hold signals, and makes sure of the extra ones.
///
/// # Errors
/// A mapped or extra column that is not there or there twice, one column for two signals, keys of both motions.
pub(super) fn resolve(map: &ColumnMap, names: &[String], extra: &[String]) -> Result<Resolved> {
    let mut wanted: BTreeMap<String, Source> = map.signals.clone();
    for name in names {
        if let Some((signal, motion)) = Signal::from_key(name) {
            let dimension = signal.dimension(motion.unwrap_or(Motion::Prismatic));
            wanted.entry(name.clone()).or_insert_with(|| Source::canonical(name, dimension));
        }
    }
    let canonical_time = TIME_NAMES.into_iter().find(|known| names.iter().any(|name| name == known));
    let canonical_time = canonical_time.map(|name| Source::canonical(name, Dimension::Time));
    let time = map.time.clone().or(canonical_time);
    let motion = one_motion(wanted.keys())?;
    let mut used: BTreeMap<String, &str> = BTreeMap::new();
    for (key, column) in time
        .iter()
        .map(|source| (TIME_KEY, &source.column))
        .chain(wanted.iter().map(|(key, source)| (key.as_str(), &source.column)))
        .chain(extra.iter().map(|column| ("extra_columns", column)))
    {
        check_present(key, column, names)?;
        if let Some(other) = used.insert(column.clone(), key) {
            return Err(Error::new(ErrorKind::Inconsistent)
                .key(key)
                .found(format!("column `{column}`, which `{other}` reads too"))
                .expected("one column for each signal")
                .remedy("correct [columns], or leave out the signal that was not logged"));
        }
    }
    let ignored = names.iter().filter(|name| !used.contains_key(*name)).cloned().collect();
    let signals = wanted
        .into_iter()
        .filter_map(|(key, source)| Some((Signal::from_key(&key)?.0, (key, source))))
        .collect();
    Ok(Resolved { motion, time, signals, ignored })
}

fn one_motion<'a>(keys: impl Iterator<Item = &'a String>) -> Result<Option<Motion>> {
    let mut first: Option<(&str, Motion)> = None;
    for key in keys {
        let Some((_, Some(motion))) = Signal::from_key(key) else { continue };
        match first {
            Some((other, before)) if before != motion => {
                return Err(Error::new(ErrorKind::Inconsistent)
                    .key(key)
                    .found(format!("`{key}` ({motion}) beside `{other}` ({before})"))
                    .expected("signals of one motion: all in m and N, or all in rad and N·m")
                    .remedy("rename or map the columns to one motion"));
            }
            _ => first = Some((key, motion)),
        }
    }
    Ok(first.map(|(_, motion)| motion))
}

fn check_present(key: &str, column: &str, names: &[String]) -> Result<()> {
    let error = match names.iter().filter(|name| *name == column).count() {
        1 => return Ok(()),
        0 => Error::new(ErrorKind::Missing).found(format!("the columns {}", names.join(", "))).expected(
            format!(
                "a column `{column}` for `{key}`{}",
                spelling::hint(column, names.iter().map(String::as_str))
            ),
        ),
        several => Error::new(ErrorKind::Inconsistent)
            .found(format!("{several} columns named `{column}`"))
            .expected(format!("one, for `{key}`")),
    };
    Err(error.key(column).remedy("correct the header of the file or [columns] of recording.toml"))
}
