//! A table file that is read as a whole: channels with clocks of their own, or arrays.

use std::path::{Path, PathBuf};

use super::file_columns::{Columns, no_rows};
use super::series::{Series, together};
use super::signal::TIME_KEY;
use crate::error::{Error, ErrorKind, Result, plain};

/// Characters of a column's name.
const LONGEST_NAME: usize = 200;

/// What such a file holds.
#[derive(Debug)]
pub(super) enum Content {
    /// Channels with their times; the table has a column `time_s` before them.
    Channels(Vec<Series>),
    /// Arrays of numbers by name.
    Arrays(Vec<(String, Vec<f64>)>),
}

/// A file in memory.
#[derive(Debug)]
pub(super) struct LoadedTable {
    path: PathBuf,
    format: &'static str,
    names: Vec<String>,
    units: Vec<Option<String>>,
    content: Content,
    sha256: String,
}

impl LoadedTable {
    /// A file with the units of its channels or arrays, where it states any.
    pub(super) fn new(
        path: &Path,
        format: &'static str,
        content: Content,
        mut units: Vec<Option<String>>,
        sha256: String,
    ) -> Self {
        let names: Vec<String> = match &content {
            Content::Channels(series) => {
                units.insert(0, None);
                let names = series.iter().map(|one| one.name.clone());
                std::iter::once(TIME_KEY.to_owned()).chain(names).collect()
            }
            Content::Arrays(arrays) => arrays.iter().map(|(name, _)| name.clone()).collect(),
        };
        let names = names.iter().map(|name| plain(name, LONGEST_NAME)).collect();
        Self { path: path.to_path_buf(), format, names, units, content, sha256 }
    }

    pub(super) fn format(&self) -> &'static str {
        self.format
    }

    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    pub(super) fn units(&self) -> &[Option<String>] {
        &self.units
    }

    pub(super) fn columns(&self, wanted: &[usize]) -> Result<Columns> {
        let (values, remark) = match &self.content {
            Content::Channels(series) => channels(series, wanted)?,
            Content::Arrays(arrays) => (columns(arrays, wanted)?, None),
        };
        if values.first().is_none_or(Vec::is_empty) {
            return Err(no_rows().file(&self.path));
        }
        let remarks = std::iter::once(format!("read as {}", self.format)).chain(remark).collect();
        Ok(Columns { first_row: 1, values, sha256: self.sha256.clone(), remarks })
    }
}

type Read = (Vec<Vec<f64>>, Option<String>);

/// Channels on one clock, and that clock where it is wanted.
fn channels(series: &[Series], wanted: &[usize]) -> Result<Read> {
    let chosen: Vec<Series> =
        wanted.iter().filter_map(|place| series.get(place.checked_sub(1)?)).cloned().collect();
    let together = together(&chosen)?;
    let mut columns = together.columns.into_iter();
    let values = wanted
        .iter()
        .filter_map(|place| if *place == 0 { Some(together.time_s.clone()) } else { columns.next() })
        .collect();
    Ok((values, together.remark))
}

fn columns(arrays: &[(String, Vec<f64>)], wanted: &[usize]) -> Result<Vec<Vec<f64>>> {
    let chosen: Vec<&(String, Vec<f64>)> = wanted.iter().filter_map(|place| arrays.get(*place)).collect();
    let length = chosen.first().map_or(0, |(_, values)| values.len());
    for (name, values) in &chosen {
        if values.len() != length {
            return Err(Error::new(ErrorKind::Inconsistent)
                .key(name.clone())
                .found(format!("{} numbers", values.len()))
                .expected(format!("{length}, as `{}` has", chosen[0].0))
                .remedy("map arrays of one length, sampled together"));
        }
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            return Err(Error::new(ErrorKind::NotFinite)
                .key(name.clone())
                .row(at as u64 + 1)
                .found(values[at].to_string())
                .expected("a finite number")
                .remedy("leave those samples out before saving"));
        }
    }
    Ok(chosen.into_iter().map(|(_, values)| values.clone()).collect())
}
