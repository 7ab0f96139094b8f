//! Bare logs: table files without a `recording.toml`, their columns understood by header and unit.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::Recording;
use super::columns::{ColumnMap, Source};
use super::manifest::{FILE_NAME, Manifest, RunEntry};
use super::meaning::{Header, Meaning};
use super::outline;
use super::range::TimeRange;
use super::read::{Content, assembled};
use super::signal::Signal;
use super::table::{ENDINGS, Table, is_table};
use crate::error::{Error, ErrorKind, Result};
use crate::units::{Dimension, Motion, Unit};

/// What one column holds, given by hand: `pos_act=position_m:mm`, or `pos_act=-` for nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct MappedColumn {
    column: String,
    key: String,
    unit: Option<String>,
}

impl FromStr for MappedColumn {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let (column, target) = text.rsplit_once('=').ok_or_else(|| refuse_map(text))?;
        let (key, unit) = match target.split_once(':') {
            Some((key, unit)) => (key, Some(unit.trim().to_owned())),
            None => (target, None),
        };
        let (column, key) = (column.trim().to_owned(), key.trim().to_owned());
        let is_known = key == "-" || Signal::keys(None).contains(&key.as_str());
        if column.is_empty() || !is_known {
            return Err(refuse_map(text));
        }
        Ok(Self { column, key, unit })
    }
}

fn refuse_map(text: &str) -> Error {
    Error::new(ErrorKind::Syntax)
        .key("--map")
        .found(format!("`{text}`"))
        .expected(format!(
            "COLUMN=SIGNAL:UNIT, with a signal of {}, or - for none",
            Signal::keys(None).join(", ")
        ))
        .remedy("write it as --map 'pos_act=position_m:mm'")
}

/// What is known of bare logs beside themselves.
#[derive(Debug, Clone, Copy)]
pub struct LogContext<'a> {
    /// Columns mapped by hand.
    pub maps: &'a [MappedColumn],
    /// Whether the axis slides or turns.
    pub motion: Motion,
    /// The controller's sample period: that of a log without a time column.
    pub sample_period_s: f64,
}

impl Recording {
    /// Whether a path is a bare log, or a folder of such, and no recording.
    pub fn is_bare(path: &Path) -> bool {
        match path.is_dir() {
            true => !path.join(FILE_NAME).exists(),
            false => {
                path.is_file() && !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"))
            }
        }
    }

    /// Reads bare logs, a run each: files, or folders of them.
    ///
    /// # Model
    /// A column is what its canonical name, its mapping or the words of its header say, in the unit in brackets, at the end of its
    /// name or in a row of units below it. What is read as what stands in [`Recording::note`].
    ///
    /// # Errors
    /// A header that could mean two things, two columns for one signal, a column without unit, a mapping that fits no column: with
    /// the choices. Else as [`Recording::read`].
    pub fn read_logs(paths: &[PathBuf], context: &LogContext) -> Result<Self> {
        assembled(manifest(paths, context)?, Content::Measured)
    }

    /// What a `recording.toml` beside these logs says: text, and the files that it names by their file names.
    ///
    /// # Errors
    /// As [`Recording::read_logs`], before the samples are read.
    pub fn outline_of_logs(
        paths: &[PathBuf],
        context: &LogContext,
        machine: &str,
    ) -> Result<(String, Vec<PathBuf>)> {
        let manifest = manifest(paths, context)?;
        let files = manifest.runs.iter().map(|run| run.file.clone()).collect();
        Ok((outline::text(&manifest, machine), files))
    }
}

/// What a `recording.toml` would say of the logs.
fn manifest(paths: &[PathBuf], context: &LogContext) -> Result<Manifest> {
    let files = files(paths)?;
    let mut used = vec![false; context.maps.len()];
    let mut told: Vec<(String, Vec<String>)> = Vec::new();
    let mut entries = Vec::with_capacity(files.len());
    let mut has_time = true;
    let mut names: Vec<String> = Vec::new();
    for (index, file) in files.iter().enumerate() {
        let table = Table::open(file)?;
        let read = Columns::of(&table, context, &mut used).map_err(|error| error.file(file))?;
        has_time &= read.map.time.is_some();
        names.extend(table.names().iter().cloned());
        let name = file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        match told.iter_mut().find(|(text, _)| *text == read.told) {
            Some((_, names)) => names.push(name.clone()),
            None => told.push((read.told, vec![name.clone()])),
        }
        entries.push(RunEntry::bare(index, name, file.clone(), read.map));
    }
    if let Some((map, _)) = context.maps.iter().zip(&used).find(|(_, used)| !**used) {
        return Err(Error::new(ErrorKind::Missing)
            .key("--map")
            .found(format!("`{}`, a column that no log has", map.column))
            .expected(format!("one of {}", names.join(", ")))
            .remedy("write the name as the header has it, with or without the unit"));
    }
    let period = (!has_time).then_some(context.sample_period_s);
    let place = paths.first().cloned().unwrap_or_default();
    Manifest::bare(place, context.motion, period, note(&told, has_time, context), entries)
}

/// What was read as what, in words.
fn note(told: &[(String, Vec<String>)], has_time: bool, context: &LogContext) -> String {
    let texts = told.iter().map(|(text, names)| match told.len() {
        1 => text.clone(),
        _ => format!("{}: {text}", names.join(", ")),
    });
    let mut note = texts.collect::<Vec<_>>().join(". ");
    if !has_time {
        note += &format!(
            "; no time column: one sample every {} s, as the machine has it",
            context.sample_period_s
        );
    }
    note + ". Say so if wrong: --map 'COLUMN=SIGNAL:UNIT'"
}

/// The table files meant by paths, folders in alphabetical order.
fn files(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in paths {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let failed = |error: std::io::Error| Error::io(path, &error);
        let mut own: Vec<PathBuf> = Vec::new();
        for entry in std::fs::read_dir(path).map_err(failed)? {
            let file = entry.map_err(failed)?.path();
            if file.is_file() && is_table(&file) {
                own.push(file);
            }
        }
        own.sort();
        if own.is_empty() {
            return Err(Error::new(ErrorKind::Missing)
                .file(path)
                .found("a folder without recording.toml and without logs")
                .expected(format!("recording.toml, or files that end in {}", ENDINGS.join(", ")))
                .remedy("name the folder or the files of the log"));
        }
        files.extend(own);
    }
    Ok(files)
}

/// The columns of one log, understood.
struct Columns {
    map: ColumnMap,
    told: String,
}

/// A column with what it was taken for.
struct Read<'a> {
    column: &'a str,
    header: Header,
    meaning: Meaning,
    /// Given by hand or by a canonical name, not by words.
    is_certain: bool,
}

impl Columns {
    fn of(table: &Table, context: &LogContext, used: &mut [bool]) -> Result<Self> {
        let units = table.units();
        let mut read: Vec<Read<'_>> = Vec::new();
        for (place, column) in table.names().iter().enumerate() {
            read.push(Read::of(column, units.get(place).and_then(Option::as_ref), context, used)?);
        }
        let mut map = ColumnMap::default();
        let mut told = Vec::new();
        let by_meaning = read.iter().filter(|one| one.meaning != Meaning::Nothing);
        let mut meanings: BTreeMap<Meaning, Vec<&Read<'_>>> = BTreeMap::new();
        by_meaning.for_each(|one| meanings.entry(one.meaning).or_default().push(one));
        let mut taken = Vec::new();
        let mut faults = Vec::new();
        for (meaning, columns) in meanings {
            let understood = single(meaning, &columns, context.motion)
                .and_then(|one| Ok((one, one.source(context.motion)?)));
            let (one, source) = match understood {
                Ok(understood) => understood,
                Err(fault) => {
                    faults.push(fault);
                    continue;
                }
            };
            told.push(format!("{} read as {}", one.shown(), meaning.key(context.motion)));
            taken.push(one.column);
            match meaning {
                Meaning::Time => map.time = Some(source),
                _ => drop(map.signals.insert(meaning.key(context.motion).to_owned(), source)),
            }
        }
        if let Some(fault) = together(faults) {
            return Err(fault);
        }
        let ignored: Vec<&str> =
            read.iter().map(|one| one.column).filter(|column| !taken.contains(column)).collect();
        if !ignored.is_empty() {
            told.push(format!("not read: {}", ignored.join(", ")));
        }
        let position = Signal::Position.key(context.motion);
        if !map.signals.contains_key(position)
            && !map.signals.contains_key(Signal::LoadPosition.key(context.motion))
        {
            return Err(Error::new(ErrorKind::Missing)
                .key(position)
                .found(format!("the columns {}", table.names().join(", ")))
                .expected("a measured position, told by a header such as `pos_act [mm]`")
                .remedy(format!("say which column it is: --map 'COLUMN={position}:mm'")));
        }
        Ok(Self { map, told: told.join("; ") })
    }
}

/// Several faults as one, so that all are mended at once; of a single one itself.
fn together(mut faults: Vec<Error>) -> Option<Error> {
    if faults.len() < 2 {
        return faults.pop();
    }
    let first = faults.first()?.kind();
    let found: Vec<String> = faults.iter().map(Error::statement).collect();
    let remedies: Vec<&str> = faults.iter().filter_map(Error::remedy_text).collect();
    Some(
        Error::new(first)
            .found(format!("{} columns that are not understood: {}", faults.len(), found.join("; ")))
            .expected("each signal once, with its unit")
            .remedy(remedies.join("; ")),
    )
}

impl<'a> Read<'a> {
    fn of(
        column: &'a str,
        units_row: Option<&String>,
        context: &LogContext,
        used: &mut [bool],
    ) -> Result<Self> {
        let header = Header::of(column, units_row.map(String::as_str));
        for (map, used) in context.maps.iter().zip(used) {
            if map.column != column && map.column != header.name {
                continue;
            }
            *used = true;
            let meaning = Meaning::from_key(&map.key, context.motion).ok_or_else(|| {
                Error::new(ErrorKind::Inconsistent)
                    .key("--map")
                    .found(format!("`{}` for a {} axis", map.key, context.motion))
                    .expected(format!("one of {}", Signal::keys(Some(context.motion)).join(", ")))
                    .remedy("name the signal of the machine's motion")
            })?;
            // Without any unit the signal's own stands.
            let own = || {
                header.unit.clone().or_else(|| Some(meaning.dimension(context.motion).si_symbol().to_owned()))
            };
            let unit = map.unit.clone().or_else(own);
            return Ok(Self { column, header: Header { unit, ..header }, meaning, is_certain: true });
        }
        if let Some(meaning) = Meaning::from_key(column, context.motion) {
            let unit = Some(meaning.dimension(context.motion).si_symbol().to_owned());
            return Ok(Self { column, header: Header { unit, ..header }, meaning, is_certain: true });
        }
        let meaning = header.meaning(context.motion);
        Ok(Self { column, header, meaning, is_certain: false })
    }

    /// Column and unit as a sentence has them.
    fn shown(&self) -> String {
        format!("{} [{}]", self.header.name, self.header.unit.as_deref().unwrap_or("1"))
    }

    fn source(&self, motion: Motion) -> Result<Source> {
        let dimension = self.meaning.dimension(motion);
        let key = self.meaning.key(motion);
        let Some(unit) = &self.header.unit else {
            if dimension == Dimension::Ratio {
                return Ok(Source::in_unit(self.column, Unit::si(dimension)));
            }
            let units = dimension.symbols().join(", ");
            return Err(Error::new(ErrorKind::Unit)
                .key(self.column)
                .found(format!("a column without unit, by its name {key}"))
                .expected(format!("a unit of {dimension}: {units}"))
                .remedy(format!("say which: --map '{}={key}:{}'", self.column, dimension.si_symbol())));
        };
        let unit = Unit::parse_as(unit, dimension).map_err(|error| {
            let ignore =
                format!("--map '{}={key}:UNIT', or --map '{}=-' to leave it out", self.column, self.column);
            error.key(self.column).remedy(ignore)
        })?;
        Ok(Source::in_unit(self.column, unit))
    }
}

/// The one column of a meaning; of several the one that is certain.
fn single<'a, 'b>(meaning: Meaning, columns: &[&'b Read<'a>], motion: Motion) -> Result<&'b Read<'a>> {
    let certain: Vec<&&Read<'_>> = columns.iter().filter(|one| one.is_certain).collect();
    if let ([one], _) | ([], [one]) = (&certain[..], &columns.iter().collect::<Vec<_>>()[..]) {
        return Ok(**one);
    }
    let key = meaning.key(motion);
    let names: Vec<&str> = columns.iter().map(|one| one.column).collect();
    let choice = |name: &&str| format!("--map '{name}={key}'");
    Err(Error::new(ErrorKind::Inconsistent)
        .key(key)
        .found(format!("{} columns that could be it: {}", names.len(), names.join(", ")))
        .expected("one")
        .remedy(format!("choose: {}", names.iter().map(choice).collect::<Vec<_>>().join(" or "))))
}

impl RunEntry {
    /// A log as a run without anything stated.
    fn bare(index: usize, name: String, file: PathBuf, columns: ColumnMap) -> Self {
        Self {
            index,
            name,
            file,
            role: None,
            settings: BTreeMap::new(),
            metadata: toml::Table::new(),
            columns,
            extra_columns: Vec::new(),
            range: TimeRange::whole(),
        }
    }
}
