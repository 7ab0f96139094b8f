//! Writing a recording: all of it, or nothing.

use std::io::Write;
use std::path::{Component, Path, PathBuf};

use super::manifest::{FILE_NAME, Manifest};
use super::run::Run;
use super::signal::Signal;
use super::signal::TIME_KEY;
use super::{Recording, mcap_table, parquet_table};
use crate::error::{Error, ErrorKind, Result};
use crate::whole::{Build, probe};

/// How the names of folders under way begin.
const PREFIX: &str = ".recording-";

/// The file format of the runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Text with comma and point; numbers in the shortest form that reads back exactly.
    Csv,
    /// Parquet with 64-bit floats.
    Parquet,
    /// MCAP with ROS 2 messages: position, velocity and force as joint states, other signals as numbers.
    Mcap,
}

impl Format {
    fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
            Self::Mcap => "mcap",
        }
    }
}

/// What to do when the folder already holds a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// Refuse, and leave it untouched.
    Refuse,
    /// Put the new recording in its place.
    Replace,
}

impl Recording {
    /// Writes `recording.toml` and one file a run, with canonical names and SI units.
    ///
    /// The folder is built beside its place and renamed into it, so that a half-written recording is never seen.
    ///
    /// # Errors
    /// A folder that is not empty and is not a recording, or is one and `existing` says to refuse;
    /// whatever the file system refuses.
    pub fn write(&self, folder: impl AsRef<Path>, format: Format, existing: Existing) -> Result<()> {
        let folder = folder.as_ref();
        check_place(folder, existing)?;
        let build = Build::beside(folder, PREFIX)?;
        let fresh = build.fresh();
        for run in &self.runs {
            write_run(run, &fresh.join(file_name(run, format)), format)?;
        }
        let manifest = fresh.join(FILE_NAME);
        std::fs::write(&manifest, self.manifest_text(folder, format)?)
            .map_err(|error| Error::io(&manifest, &error))?;
        build.put(folder, existing == Existing::Replace)
    }

    /// Makes sure that a recording can be written there, before the work for it begins.
    ///
    /// # Errors
    /// As [`Recording::write`].
    pub fn check_place(folder: impl AsRef<Path>, existing: Existing) -> Result<()> {
        check_place(folder.as_ref(), existing)?;
        probe(folder.as_ref(), PREFIX)
    }

    fn manifest_text(&self, folder: &Path, format: Format) -> Result<String> {
        let mut top = toml::Table::new();
        // Uneven time stamps speak for themselves.
        if self.runs.iter().all(|run| run.instants_s().is_none()) {
            top.insert("sample_period_s".into(), self.sample_period_s.into());
        }
        top.insert("motion".into(), self.motion.to_string().into());
        if let Some(note) = &self.note {
            top.insert("note".into(), note.clone().into());
        }
        if let Some(machine) = &self.machine {
            top.insert("machine".into(), relative(folder, machine).to_string_lossy().into_owned().into());
        }
        let runs: Vec<toml::Value> = self.runs.iter().map(|run| run_table(run, format).into()).collect();
        top.insert("run".into(), runs.into());
        toml::to_string(&top).map_err(|error| {
            Error::new(ErrorKind::Syntax)
                .file(folder.join(FILE_NAME))
                .found(error.to_string())
                .expected("metadata that TOML can hold")
                .remedy("simplify the metadata of the runs")
        })
    }
}

fn file_name(run: &Run, format: Format) -> String {
    format!("{}.{}", run.name(), format.extension())
}

fn run_table(run: &Run, format: Format) -> toml::Table {
    let mut table = run.metadata.clone();
    table.insert("file".into(), file_name(run, format).into());
    // The file name cannot carry a name with a point in it: "feed0.8" would read back as "feed0".
    table.insert("name".into(), run.name().into());
    if let Some(role) = run.role {
        table.insert("role".into(), role.text().into());
    }
    if !run.extra_columns().is_empty() {
        let names: Vec<toml::Value> = run.extra_columns().keys().map(|name| name.as_str().into()).collect();
        table.insert("extra_columns".into(), names.into());
    }
    if format == Format::Mcap {
        table.insert("columns".into(), mcap_columns(run).into());
        let channels = run.extra_columns().keys().map(|name| mcap_table::extra_channel(name).into());
        if !run.extra_columns().is_empty() {
            table.insert("extra_columns".into(), toml::Value::Array(channels.collect()));
        }
    }
    if !run.settings.is_empty() {
        let settings: toml::Table = run.settings.clone().into_iter().collect();
        table.insert("set".into(), settings.into());
    }
    table
}

/// Which channel of an MCAP file holds which signal.
fn mcap_columns(run: &Run) -> toml::Table {
    let row =
        |signal: &Signal| (signal.key(run.motion()).to_owned(), mcap_table::channel(*signal, run).into());
    run.signals().keys().map(row).collect()
}

/// Columns of a run as they are written: time first, then signals in signal-path order, then the extra ones.
fn write_run(run: &Run, path: &Path, format: Format) -> Result<()> {
    let time: Vec<f64> = (0..run.len()).map(|k| run.start_s + run.time_s(k)).collect();
    let signals = run.signals().iter().map(|(signal, samples)| (signal.key(run.motion()), samples));
    let extra = run.extra_columns().iter().map(|(name, samples)| (name.as_str(), samples));
    let columns = [(TIME_KEY, &time)].into_iter().chain(signals).chain(extra);
    let columns: Vec<(&str, &[f64])> = columns.map(|(name, samples)| (name, &samples[..])).collect();
    match format {
        Format::Parquet => parquet_table::write(path, &columns),
        Format::Mcap => mcap_table::write(path, run),
        Format::Csv => write_csv(path, &columns).map_err(|error| Error::io(path, &error)),
    }
}

fn write_csv(path: &Path, columns: &[(&str, &[f64])]) -> std::io::Result<()> {
    let mut out = std::io::BufWriter::with_capacity(1 << 16, std::fs::File::create(path)?);
    let names: Vec<_> = columns.iter().map(|(name, _)| *name).collect();
    writeln!(out, "{}", names.join(","))?;
    let rows = columns.first().map_or(0, |(_, samples)| samples.len());
    for row in 0..rows {
        for (place, (_, samples)) in columns.iter().enumerate() {
            let comma = if place == 0 { "" } else { "," };
            // `{:?}` is the shortest text that reads back to the same number, with an exponent where shorter.
            write!(out, "{comma}{:?}", samples[row])?;
        }
        writeln!(out)?;
    }
    out.flush()
}

/// Refuses to touch a folder that is not empty, unless it is a recording and nothing else.
fn check_place(folder: &Path, existing: Existing) -> Result<()> {
    let refuse = |found: String, remedy: &str| {
        Err(Error::new(ErrorKind::Io)
            .file(folder)
            .found(found)
            .expected("a new or empty folder")
            .remedy(remedy))
    };
    if folder.as_os_str().is_empty() {
        return refuse("an empty path".to_owned(), "name a folder");
    }
    if !folder.exists() {
        return Ok(());
    }
    if !folder.is_dir() {
        return refuse("a file".to_owned(), "name a folder");
    }
    let entries = std::fs::read_dir(folder).map_err(|error| Error::io(folder, &error))?;
    let names: Vec<String> =
        entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    if names.is_empty() {
        return Ok(());
    }
    if !names.iter().any(|name| name == FILE_NAME) {
        return refuse(
            format!("a folder with {} files that is not a recording", names.len()),
            "name another folder",
        );
    }
    if existing == Existing::Refuse {
        return refuse("a recording".to_owned(), "name another folder, or ask to replace it (--replace)");
    }
    let own = own_files(folder)?;
    match names.iter().find(|name| !own.contains(name)) {
        Some(foreign) => refuse(
            format!("`{foreign}`, which the recording there does not name"),
            "move it away first: replacing would delete it",
        ),
        None => Ok(()),
    }
}

/// The files in a folder that belong to the recording in it.
fn own_files(folder: &Path) -> Result<Vec<String>> {
    let manifest = Manifest::load(&folder.join(FILE_NAME), None)?;
    let here = manifest.runs.iter().filter(|run| run.file.parent() == Some(folder));
    let names = here.filter_map(|run| Some(run.file.file_name()?.to_string_lossy().into_owned()));
    Ok(names.chain([FILE_NAME.to_owned()]).collect())
}

/// The way from a folder to a path, so that both can be moved together.
fn relative(from: &Path, to: &Path) -> PathBuf {
    let (Ok(from), Ok(to)) = (absolute(from), absolute(to)) else { return to.to_path_buf() };
    let (from, to): (Vec<_>, Vec<_>) = (from.components().collect(), to.components().collect());
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = from.iter().skip(shared).map(|_| Component::ParentDir);
    up.chain(to.iter().skip(shared).copied()).collect()
}

/// An absolute path without links, `.` and `..`; its last part need not exist.
fn absolute(path: &Path) -> std::io::Result<PathBuf> {
    if let Ok(real) = path.canonicalize() {
        return Ok(real);
    }
    let path = std::path::absolute(path)?;
    match (path.parent(), path.components().next_back()) {
        (Some(parent), Some(Component::Normal(name))) => Ok(absolute(parent)?.join(name)),
        (Some(parent), Some(Component::ParentDir)) => {
            Ok(absolute(parent)?.parent().map_or(path.clone(), Path::to_path_buf))
        }
        _ => Ok(path),
    }
}
