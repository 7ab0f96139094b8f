//! `recording.toml`: which files hold the runs, and what their columns mean.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use super::columns::ColumnMap;
use super::document::{Document, Step, number, text_at};
use super::range::TimeRange;
use super::run::{FEEDFORWARD_KEY, Role};
use super::session::BEGIN_KEY;
use super::table::is_table;
use crate::confine;
use crate::error::{Error, ErrorKind, Result, spelling};
use crate::units::Motion;

/// The name of the file that makes a folder a recording.
pub(super) const FILE_NAME: &str = "recording.toml";
/// Bytes of it at most.
pub(super) const MOST_BYTES: u64 = 16 << 20;

/// Keys of the head of the file or of a column, which say nothing in a `[[run]]`.
const MISPLACED: [(&str, &str); 9] = [
    ("sample_period_s", "the head of the file"),
    ("motion", "the head of the file"),
    ("machine", "the head of the file"),
    ("note", "the head of the file"),
    ("data_folder", "the head of the file"),
    ("unit", "a column: position_m = { unit = \"mm\" } in [columns]"),
    ("scale", "a column: position_m = { scale = -1 } in [columns]"),
    ("offset", "a column: position_m = { offset = 0.1 } in [columns]"),
    ("column", "a column: position_m = { column = \"pos\" } in [columns]"),
];
pub(super) const KEYS: [&str; 7] =
    ["sample_period_s", "motion", "machine", "note", "data_folder", "run", "columns"];
pub(super) const RUN_KEYS: [&str; 8] =
    ["file", "name", "role", "set", "columns", "extra_columns", "from_s", "to_s"];

/// Metadata of a run that say when it was and what was fed forward.
const METADATA: [&str; 2] = [BEGIN_KEY, FEEDFORWARD_KEY];

/// One `[[run]]`.
#[derive(Debug)]
pub(super) struct RunEntry {
    pub(super) index: usize,
    pub(super) name: String,
    pub(super) file: PathBuf,
    pub(super) role: Option<Role>,
    pub(super) settings: BTreeMap<String, toml::Value>,
    pub(super) metadata: toml::Table,
    pub(super) columns: ColumnMap,
    pub(super) extra_columns: Vec<String>,
    pub(super) range: TimeRange,
}

/// A read and checked `recording.toml`; paths are resolved.
#[derive(Debug)]
pub(super) struct Manifest {
    pub(super) document: Document,
    pub(super) sample_period_s: Option<f64>,
    pub(super) motion: Option<Motion>,
    pub(super) machine: Option<PathBuf>,
    pub(super) note: Option<String>,
    pub(super) runs: Vec<RunEntry>,
}

impl Manifest {
    /// What a `recording.toml` would say of bare logs.
    pub(super) fn bare(
        path: PathBuf,
        motion: Motion,
        sample_period_s: Option<f64>,
        note: String,
        runs: Vec<RunEntry>,
    ) -> Result<Self> {
        let document = Document::parse(&path, String::new())?;
        let manifest =
            Self { document, sample_period_s, motion: Some(motion), machine: None, note: Some(note), runs };
        manifest.check_names()?;
        Ok(manifest)
    }

    /// Checks a parsed document. `data_variable` is the content of the environment variable, if set.
    pub(super) fn new(document: Document, data_variable: Option<OsString>) -> Result<Self> {
        if let Some(name) = document.values.keys().find(|name| !KEYS.contains(&name.as_str())) {
            return Err(document.unknown_key(&[Step::Key(name)], name, &KEYS));
        }
        let folder = document.path.parent().unwrap_or(Path::new("")).to_path_buf();
        let data_folder = match text_at(&document, &document.values, &[], "data_folder")? {
            Some(default) => data_variable.map_or_else(|| folder.join(default), PathBuf::from),
            None => folder.clone(),
        };
        let columns = ColumnMap::read(&document, &[Step::Key("columns")])?;
        let runs = read_runs(&document, &data_folder, &columns)?;
        let manifest = Self {
            sample_period_s: read_period(&document)?,
            motion: read_motion(&document)?,
            machine: text_at(&document, &document.values, &[], "machine")?
                .map(|machine| folder.join(machine)),
            note: text_at(&document, &document.values, &[], "note")?.map(str::to_owned),
            runs,
            document,
        };
        manifest.check_names()?;
        Ok(manifest)
    }

    fn check_names(&self) -> Result<()> {
        let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
        for run in &self.runs {
            if let Some(first) = seen.insert(&run.name, run.index) {
                return Err(self
                    .document
                    .refuse(ErrorKind::Inconsistent, &[Step::Key("run"), Step::Index(run.index)])
                    .found(format!("the run name `{}` a second time (first in run {})", run.name, first + 1))
                    .expected("run names that differ")
                    .remedy("drop the repeated [[run]], or give one a `name = \"…\"`"));
            }
        }
        Ok(())
    }
}

/// Periods of samples, in s.
const SHORTEST_PERIOD_S: f64 = 1e-9;
const LONGEST_PERIOD_S: f64 = 1e3;
const RANGE: &str = "1e-9 s to 1000 s, such as 250e-6";

fn read_period(document: &Document) -> Result<Option<f64>> {
    let steps = [Step::Key("sample_period_s")];
    let Some(value) = document.values.get("sample_period_s") else { return Ok(None) };
    let expected = "a positive number of seconds, such as 250e-6";
    let period = number(value).ok_or_else(|| document.wrong_type(&steps, value, expected))?;
    if (SHORTEST_PERIOD_S..=LONGEST_PERIOD_S).contains(&period) {
        return Ok(Some(period));
    }
    let expected = if period > 0.0 && period.is_finite() { RANGE } else { expected };
    Err(document
        .refuse(ErrorKind::OutOfRange, &steps)
        .found(period.to_string())
        .expected(expected)
        .remedy("correct it, or leave it out when the files have a time column"))
}

fn read_motion(document: &Document) -> Result<Option<Motion>> {
    match text_at(document, &document.values, &[], "motion")? {
        None => Ok(None),
        Some("prismatic") => Ok(Some(Motion::Prismatic)),
        Some("revolute") => Ok(Some(Motion::Revolute)),
        Some(other) => Err(document
            .refuse(ErrorKind::Syntax, &[Step::Key("motion")])
            .found(format!("{other:?}"))
            .expected("\"prismatic\" or \"revolute\"")
            .remedy("write one of the two, or leave the key out where the signals tell")),
    }
}

fn read_runs(document: &Document, data_folder: &Path, common: &ColumnMap) -> Result<Vec<RunEntry>> {
    let steps = [Step::Key("run")];
    let remedy = "add a [[run]] with `file = \"…\"` for each CSV or Parquet file";
    let none = |error: Error| error.expected("at least one [[run]]").remedy(remedy);
    let Some(value) = document.values.get("run") else {
        return Err(none(document.refuse(ErrorKind::Missing, &[]).key("run").found("no [[run]]")));
    };
    let expected = "an array of tables, each headed [[run]]";
    let list = value.as_array().ok_or_else(|| document.wrong_type(&steps, value, expected))?;
    if list.is_empty() {
        return Err(none(document.refuse(ErrorKind::Missing, &steps).found("an empty list")));
    }
    let read = |(index, value): (usize, &toml::Value)| {
        let steps = [Step::Key("run"), Step::Index(index)];
        let table = value.as_table().ok_or_else(|| document.wrong_type(&steps, value, expected))?;
        read_run(document, index, table, data_folder, common)
    };
    list.iter().enumerate().map(read).collect()
}

/// Refuses slips of keys, and keys that say nothing in a `[[run]]`.
fn check_run_keys(document: &Document, base: &[Step; 2], table: &toml::Table) -> Result<()> {
    let known: Vec<&str> = RUN_KEYS.into_iter().chain(METADATA).collect();
    for name in table.keys() {
        let is_slip = known.iter().any(|key| spelling::is_slip(name, key));
        if is_slip && !known.contains(&name.as_str()) {
            return Err(document.unknown_key(&[base[0], base[1], Step::Key(name)], name, &known));
        }
    }
    let misplaced = MISPLACED.into_iter().find(|(name, _)| table.contains_key(*name));
    misplaced.map_or(Ok(()), |(name, place)| {
        Err(document
            .refuse(ErrorKind::UnknownKey, &[base[0], base[1], Step::Key(name)])
            .found(format!("`{name}` in a [[run]], where it says nothing"))
            .expected(format!("`{name}` at {place}"))
            .remedy("move it there"))
    })
}

fn read_run(
    document: &Document,
    index: usize,
    table: &toml::Table,
    data_folder: &Path,
    common: &ColumnMap,
) -> Result<RunEntry> {
    let base = [Step::Key("run"), Step::Index(index)];
    let at = |key: &'static str| [base[0], base[1], Step::Key(key)];
    check_run_keys(document, &base, table)?;
    let Some(file) = text_at(document, table, &base, "file")?.filter(|file| !file.is_empty()) else {
        return Err(document
            .refuse(ErrorKind::Missing, &base)
            .found("a [[run]] without `file`")
            .expected("the CSV or Parquet file of the run")
            .remedy("add `file = \"…\"`"));
    };
    let path = data_folder.join(file);
    let folder = document.path.parent().unwrap_or(Path::new(""));
    check_confined(&path, folder, data_folder).map_err(|error| relocated(document, &at("file"), &error))?;
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let name = text_at(document, table, &base, "name")?.map(str::to_owned).or(stem).unwrap_or_default();
    let role = match text_at(document, table, &base, "role")? {
        None => None,
        Some(text) => Some(Role::from_text(text).ok_or_else(|| {
            document
                .refuse(ErrorKind::Syntax, &at("role"))
                .found(format!("{text:?}"))
                .expected("\"training\" or \"held_out\"")
                .remedy("write one of the two, or leave `role` out and let the split decide")
        })?),
    };
    let mut settings = BTreeMap::new();
    if let Some(set) = table.get("set") {
        let expected = "a table of machine settings, such as { \"controller.integral\" = 22 }";
        let set = set.as_table().ok_or_else(|| document.wrong_type(&at("set"), set, expected))?;
        flatten(set, "", &mut settings);
    }
    let columns = common.overridden_by(ColumnMap::read(document, &at("columns"))?);
    let metadata = table.iter().filter(|(key, _)| !RUN_KEYS.contains(&key.as_str()));
    let metadata = metadata.map(|(key, value)| (key.clone(), value.clone())).collect();
    let extra_columns = read_extra_columns(document, &at("extra_columns"), table)?;
    let range = TimeRange::read(document, &base, table)?;
    Ok(RunEntry { index, name, file: path, role, settings, metadata, columns, extra_columns, range })
}

/// Refuses a file outside of the recording's folder, unless it is a table in a folder that `data_folder` names relative to it.
///
/// Shipped machines and measured data lie side by side, so that a relative `data_folder` may lead out. Who is handed a
/// recording expects it to read logs there and nothing else: what has no ending of a table is not opened.
fn check_confined(path: &Path, folder: &Path, data_folder: &Path) -> Result<()> {
    let own = confine::check(path, &[folder]);
    let is_stated = data_folder.is_relative() || data_folder.starts_with(folder);
    let Err(outside) = own else { return Ok(()) };
    if !is_stated {
        return Err(outside);
    }
    confine::check(path, &[folder, data_folder])?;
    if is_table(path) {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Inconsistent)
        .found(format!(
            "the path {}, which leads out of the folder and has no ending of a table",
            path.display()
        ))
        .expected("a file in the folder of the recording, or a table (.csv, .parquet, …) in its data_folder")
        .remedy(
            "move the file into the recording's folder, or name the folder it is in: --allow-outside DIR",
        ))
}

/// A refusal with file, line and key of the place that caused it.
fn relocated(document: &Document, steps: &[Step<'_>], error: &Error) -> Error {
    let place = document.refuse(error.kind(), steps);
    let error = error.clone().file(&document.path).key(place.key_name().unwrap_or_default());
    place.row_number().map_or(error.clone(), |row| error.row(row))
}

fn read_extra_columns(document: &Document, steps: &[Step<'_>], table: &toml::Table) -> Result<Vec<String>> {
    let Some(value) = table.get("extra_columns") else { return Ok(Vec::new()) };
    let names = value.as_array().and_then(|list| {
        list.iter().map(|name| name.as_str().map(str::to_owned)).collect::<Option<Vec<String>>>()
    });
    names.ok_or_else(|| document.wrong_type(steps, value, "a list of column names in quotes"))
}

/// `controller.integral = 22` and `"controller.integral" = 22` are the same key path.
fn flatten(table: &toml::Table, prefix: &str, settings: &mut BTreeMap<String, toml::Value>) {
    for (key, value) in table {
        let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
        match value {
            toml::Value::Table(inner) => flatten(inner, &path, settings),
            plain => {
                settings.insert(path, plain.clone());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(toml: &str, data_variable: Option<&str>) -> Vec<PathBuf> {
        let document = Document::parse(Path::new("/models/slide/recording.toml"), toml.to_owned()).unwrap();
        let manifest = Manifest::new(document, data_variable.map(OsString::from)).unwrap();
        manifest.runs.into_iter().map(|run| run.file).collect()
    }

    #[test]
    fn exact_data_folder_yields_to_the_environment_variable() {
        let elsewhere = "data_folder = \"../data\"\n[[run]]\nfile = \"a/log.csv\"\n";
        assert_eq!(files(elsewhere, None), [Path::new("/models/slide/../data/a/log.csv")]);
        assert_eq!(files(elsewhere, Some("/measured")), [Path::new("/measured/a/log.csv")]);
        let here = "[[run]]\nfile = \"log.csv\"\n";
        assert_eq!(files(here, Some("/measured")), [Path::new("/models/slide/log.csv")]);
    }

    #[test]
    fn exact_lines_of_nested_keys_are_found() {
        let text = "[[run]]\nfile = \"a\"\n[run.columns]\ncurrent_a = \"i\"\n\n[[run]]\nfile = 3\n";
        let document = Document::parse(Path::new("r.toml"), text.to_owned()).unwrap();
        let refuse = |steps: &[Step<'_>]| document.refuse(ErrorKind::Syntax, steps).row_number();
        let (run, columns) = (Step::Key("run"), Step::Key("columns"));
        assert_eq!(refuse(&[run, Step::Index(0), columns, Step::Key("current_a")]), Some(4));
        assert_eq!(refuse(&[run, Step::Index(1), Step::Key("file")]), Some(7));
        assert_eq!(refuse(&[run, Step::Index(1)]), Some(6));
    }
}
