//! Reading a recording: TOML, then every run, then what only all runs together tell.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use sha2::{Digest, Sha256};

use super::Recording;
use super::columns::{Conversion, Source};
use super::document::Document;
use super::file_columns::Columns;
use super::likely;
use super::lost::fill;
use super::manifest::{FILE_NAME, MOST_BYTES, Manifest, RunEntry};
use super::plausibility::plausibility;
use super::resolve::resolve;
use super::run::{Run, check_measured, hex};
use super::signal::{Signal, TIME_KEY};
use super::table::Table;
use super::timing::Timing;
use crate::confine::{self, DATA_VARIABLE};
use crate::error::{Error, ErrorKind, Result};
use crate::units::{Dimension, Motion};

const SMALLEST_MANIFEST: &str =
    "the smallest is `[[run]]` with `file = \"log.csv\"`, and `[columns]` where names differ";

/// What a run must hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    /// Something that was measured.
    Measured,
    /// Any signal: what an axis is to be told.
    Commands,
}

pub(super) fn recording(path: &Path, content: Content) -> Result<Recording> {
    assembled(Manifest::load(&manifest_path(path)?, std::env::var_os(DATA_VARIABLE))?, content)
}

/// Reads the runs that a manifest names.
pub(super) fn assembled(manifest: Manifest, content: Content) -> Result<Recording> {
    let read: Vec<Result<Reading>> = manifest
        .runs
        .par_iter()
        .map(|entry| Reading::new(&manifest, entry).map_err(|error| error.file(&entry.file)))
        .collect();
    // Gathered in file order, so that of several faults the same one is always told.
    let readings = read.into_iter().collect::<Result<Vec<_>>>()?;
    let motion = motion(&manifest, &readings)?;
    let mut units_read: Vec<Conversion> = Vec::new();
    let mut runs = Vec::with_capacity(readings.len());
    for (entry, mut reading) in manifest.runs.iter().zip(readings) {
        for conversion in std::mem::take(&mut reading.conversions) {
            match units_read.iter_mut().find(|known| known.same_but_runs(&conversion)) {
                Some(known) => known.runs.extend(conversion.runs),
                None => units_read.push(conversion),
            }
        }
        if content == Content::Measured {
            let checked = check_measured(&reading.signals, motion);
            checked.map_err(|error| error.key(entry.name.clone()).file(&entry.file))?;
        }
        runs.push(reading.into_run(entry, motion).map_err(|error| error.file(&entry.file))?);
    }
    let mut recording = Recording::new(runs).map_err(|error| error.file(&manifest.document.path))?;
    for run in recording.runs() {
        if let Some(finding) = plausibility(run).into_iter().next() {
            return Err(Error::from(finding).file(&run.file));
        }
    }
    if content == Content::Measured {
        likely::check(recording.runs())?;
    }
    recording.manifest_sha256 = manifest.document.sha256();
    recording.path.clone_from(&manifest.document.path);
    recording.note = manifest.note;
    recording.machine = manifest.machine;
    recording.units_read = units_read;
    Ok(recording)
}

fn manifest_path(path: &Path) -> Result<PathBuf> {
    let is_toml = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
    let file = if path.is_dir() { path.join(FILE_NAME) } else { path.to_path_buf() };
    let refuse = |found: &str| {
        Error::new(ErrorKind::Missing)
            .file(&file)
            .found(found)
            .expected("a folder with recording.toml, or such a TOML file")
            .remedy(SMALLEST_MANIFEST)
    };
    if !file.exists() {
        let remedy =
            if is_toml || path.extension().is_none() { SMALLEST_MANIFEST } else { "correct the path" };
        let expected = "a log, a folder with recording.toml, or such a TOML file";
        return Err(refuse("no such file").expected(expected).remedy(remedy));
    }
    if path.is_dir() || is_toml { Ok(file) } else { Err(refuse("a file that is not TOML")) }
}

impl Manifest {
    /// Reads and checks a `recording.toml`.
    pub(super) fn load(path: &Path, data_variable: Option<std::ffi::OsString>) -> Result<Self> {
        let text = confine::read_text(path, MOST_BYTES)?;
        Self::new(Document::parse(path, text)?, data_variable)
    }
}

impl Document {
    fn sha256(&self) -> String {
        let mut hash = Sha256::new();
        hash.update(self.text());
        hex(hash)
    }
}

/// The declared motion, or the one that the signals of all runs imply.
fn motion(manifest: &Manifest, readings: &[Reading]) -> Result<Motion> {
    let mut known = manifest.motion.map(|motion| (motion, &manifest.document.path));
    for (entry, reading) in manifest.runs.iter().zip(readings) {
        match (known, reading.motion) {
            (Some((before, place)), Some(motion)) if before != motion => {
                return Err(Error::new(ErrorKind::Inconsistent)
                    .file(&entry.file)
                    .key("motion")
                    .found(format!("signals of a {motion} axis"))
                    .expected(format!("a {before} one, as {} says", place.display()))
                    .remedy("correct the column names, or make a recording for each axis"));
            }
            (None, Some(motion)) => known = Some((motion, &entry.file)),
            _ => {}
        }
    }
    known.map(|(motion, _)| motion).ok_or_else(|| {
        Error::new(ErrorKind::Missing)
            .file(&manifest.document.path)
            .key("motion")
            .found("signals that do not tell whether the axis slides or turns")
            .expected("\"prismatic\" or \"revolute\"")
            .remedy("add `motion = \"prismatic\"` to the file, or map a position")
    })
}

/// One run before its motion is known.
struct Reading {
    motion: Option<Motion>,
    signals: BTreeMap<Signal, Vec<f64>>,
    extra_columns: BTreeMap<String, Vec<f64>>,
    timing: Timing,
    start_s: f64,
    /// Times of the samples, where they are uneven.
    instants_s: Option<Vec<f64>>,
    sha256: String,
    ignored_columns: Vec<String>,
    conversions: Vec<Conversion>,
    remarks: Vec<String>,
}

impl Reading {
    fn new(manifest: &Manifest, entry: &RunEntry) -> Result<Self> {
        let table = Table::open(&entry.file)?;
        let mut resolved = resolve(&entry.columns, table.names(), &entry.extra_columns)?;
        resolved.adopt_units(table.names(), table.units())?;
        if resolved.time.is_none() && manifest.sample_period_s.is_none() {
            return Err(no_time(table.names()));
        }
        // Signals, extra columns, then time: taken apart in the same order below.
        let wanted = (resolved.signals.values().map(|(_, source)| &source.column))
            .chain(&entry.extra_columns)
            .chain(resolved.time.as_ref().map(|source| &source.column));
        let place = |column: &String| table.names().iter().position(|name| name == column);
        let places: Vec<usize> = wanted.filter_map(place).collect();
        if resolved.signals.is_empty() {
            return Err(no_signals(table.names()));
        }
        let last = places.len().checked_sub(1).filter(|_| resolved.time.is_some());
        let mut columns = table.columns(&places, last)?;
        let mut conversions = Vec::new();
        let declared = manifest.sample_period_s;
        let time = resolved.time.as_ref().and_then(|source| Some((source, columns.values.pop()?)));
        if let Some((source, _)) = &time {
            conversions.push(Conversion::new(TIME_KEY, Dimension::Time, source, &entry.name));
        }
        let (timing, start_s, instants_s) = timed(time, &mut columns, entry, declared)?;
        let extra = columns.values.split_off(resolved.signals.len());
        let extra_columns = entry.extra_columns.iter().cloned().zip(extra).collect();
        let mut signals = BTreeMap::new();
        for ((signal, (key, source)), mut samples) in
            resolved.signals.iter().zip(std::mem::take(&mut columns.values))
        {
            source.convert(&mut samples);
            let dimension = signal.dimension(resolved.motion.unwrap_or(Motion::Prismatic));
            likely::check_size(&samples, dimension, columns.first_row, &source.column)?;
            conversions.push(Conversion::new(key, dimension, source, &entry.name));
            signals.insert(*signal, samples);
        }
        conversions.retain(|conversion| !conversion.is_needless());
        Ok(Self {
            motion: resolved.motion,
            signals,
            extra_columns,
            timing,
            start_s,
            instants_s,
            sha256: std::mem::take(&mut columns.sha256),
            ignored_columns: resolved.ignored,
            conversions,
            remarks: columns.remarks,
        })
    }

    fn into_run(self, entry: &RunEntry, motion: Motion) -> Result<Run> {
        let mut run =
            Run::of_file(entry.name.clone(), motion, self.timing.sample_period_s, self.signals, self.sha256)?
                .with_extra_columns(self.extra_columns)?;
        run.role = entry.role;
        run.start_s = self.start_s;
        run.metadata.clone_from(&entry.metadata);
        run.settings.clone_from(&entry.settings);
        run.file.clone_from(&entry.file);
        run.timing = self.timing;
        if let Some(instants_s) = self.instants_s {
            run.set_instants_s(instants_s);
        }
        run.ignored_columns = self.ignored_columns;
        run.remarks = self.remarks;
        Ok(run)
    }
}

/// Timing, start and, where they are uneven, the instants of a run, with its columns cut to its range and lost samples filled in.
fn timed(
    time: Option<(&Source, Vec<f64>)>,
    columns: &mut Columns,
    entry: &RunEntry,
    declared: Option<f64>,
) -> Result<(Timing, f64, Option<Vec<f64>>)> {
    let Some((source, mut time_s)) = time else {
        let period = declared.unwrap_or_default();
        let count = columns.values.first().map_or(0, Vec::len);
        let used = entry.range.of(count, |k| k as f64 * period)?;
        columns.cut(used.clone());
        return Ok((Timing::declared(period), used.start as f64 * period, None));
    };
    source.convert(&mut time_s);
    let used = entry.range.of(time_s.len(), |k| time_s[k])?;
    columns.cut(used.clone());
    time_s.truncate(used.end);
    time_s.drain(..used.start);
    columns.remarks.extend(fill(&mut time_s, &mut columns.values, declared, columns.first_row));
    let timing = Timing::of_column(&time_s, declared, columns.first_row)
        .map_err(|error| error.key(source.column.clone()))?;
    let start_s = time_s.first().copied().unwrap_or_default();
    let instants = || time_s.iter().map(|t| t - start_s).collect();
    let instants_s = timing.is_uneven().then(instants);
    Ok((timing, start_s, instants_s))
}

fn no_time(names: &[String]) -> Error {
    let hint = crate::error::spelling::hint(TIME_KEY, names.iter().map(String::as_str));
    Error::new(ErrorKind::Missing)
        .key(TIME_KEY)
        .found(format!("the columns {}", names.join(", ")))
        .expected(format!("a time column, or sample_period_s in recording.toml{hint}"))
        .remedy("add `sample_period_s = …`, or `time_s = { column = \"…\", unit = \"s\" }` under [columns]")
}

fn no_signals(names: &[String]) -> Error {
    let is_measured = |key: &&str| Signal::from_key(key).is_some_and(|(signal, _)| signal.is_measured());
    let measured: Vec<_> = Signal::keys(None).into_iter().filter(is_measured).collect();
    Error::new(ErrorKind::Missing)
        .key("columns")
        .found(format!("the columns {}", names.join(", ")))
        .expected(format!("at least one of {}", measured.join(", ")))
        .remedy("map the columns in [columns] of recording.toml: `position_m = { column = \"…\", unit = \"mm\" }`")
}
