//! TwinCAT Scope exports: two blocks of key and value above the numbers, a time column before each channel or before each group
//! of channels with one sample time.
//!
//! Offset and scale of the channels are in the numbers already where "Scale values before export" was chosen, as it is by
//! default; they are not applied again.

use std::path::Path;

use super::dialect::decimal;
use super::loaded_table::{Content, LoadedTable};
use super::series::Series;
use crate::error::{Error, ErrorKind, Result};

const FORMAT: &str = "TwinCAT Scope export";
const FIRST_KEY: &[u8] = b"Name";
const START_KEY: &str = "Starttime of export";
const LAST_LINE: &str = "EOF";
/// Time stamps with so many digits count 100 ns since 1601 (FILETIME), others ms from the start of the export.
const FILETIME_DIGITS: usize = 15;
const FILETIME_S: f64 = 1e-7;

/// Whether a text is such an export: its first line is the name, its second or third the start.
pub(super) fn is_scope(text: &[u8]) -> bool {
    let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
    let mut lines = text.split(|byte| *byte == b'\n').take(5);
    lines.next().is_some_and(|first| first.starts_with(FIRST_KEY))
        && lines.any(|line| line.starts_with(START_KEY.as_bytes()))
}

/// The lines of an export, split into cells.
struct Export<'a> {
    lines: Vec<&'a str>,
    separator: u8,
    /// Key and cells of the lines above the numbers, one a property of the channels.
    header: Vec<(String, Vec<String>)>,
    /// Line behind the header.
    first: usize,
}

/// Reads an export.
///
/// # Errors
/// No time column, a cell that is no number, with its row (of the file, as an editor counts).
pub(super) fn read(path: &Path, text: &[u8], sha256: String) -> Result<LoadedTable> {
    let text = String::from_utf8_lossy(text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text));
    let export = Export::new(&text)?;
    let channels = export.channels();
    if channels.is_empty() {
        return Err(no_times("no time column"));
    }
    let series = export.series(&channels)?;
    let stated = export.property("Unit");
    let units = channels.iter().map(|(_, place)| stated.get(*place).and_then(|cell| unit(cell))).collect();
    Ok(LoadedTable::new(path, FORMAT, Content::Channels(series), units, sha256))
}

impl<'a> Export<'a> {
    fn new(text: &'a str) -> Result<Self> {
        let separator = text.as_bytes().get(FIRST_KEY.len()).copied().unwrap_or(b'\t');
        let lines: Vec<&str> = text.lines().collect();
        let mut export = Self { lines, separator, header: Vec::new(), first: 0 };
        let key = |line: &&str| export.cells(line).first().is_some_and(|cell| *cell == "Name");
        let begins = export.lines.iter().skip(1).position(key).map(|place| place + 1);
        let begins = begins.ok_or_else(|| no_times("no block of channels"))?;
        let rows = export.lines[begins..].iter().take_while(|line| !line.trim().is_empty());
        let owned =
            |line: &&str| -> Vec<String> { export.cells(line).into_iter().map(str::to_owned).collect() };
        let header = rows.map(owned).map(|cells| (cells.first().cloned().unwrap_or_default(), cells));
        export.header = header.collect();
        export.first = begins + export.header.len();
        Ok(export)
    }

    fn cells<'l>(&self, line: &'l str) -> Vec<&'l str> {
        line.split(char::from(self.separator)).map(str::trim).collect()
    }

    /// The cells of a property, one a column.
    fn property(&self, key: &str) -> &[String] {
        self.header.iter().find(|(name, _)| name == key).map_or(&[], |(_, cells)| cells)
    }

    /// The columns of the channels, each behind the column of its times.
    fn channels(&self) -> Vec<(usize, usize)> {
        // A time column bears the key of the line in every line; a channel called `Name` does not.
        let is_time = |place: usize| {
            self.header.iter().all(|(key, cells)| cells.get(place).is_some_and(|cell| cell == key))
        };
        let mut clock = None;
        let mut channels = Vec::new();
        for (place, name) in self.property("Name").iter().enumerate() {
            match (is_time(place), clock) {
                (true, _) => clock = Some(place),
                (false, Some(clock)) if !name.is_empty() => channels.push((clock, place)),
                _ => {}
            }
        }
        channels
    }

    /// The samples of the channels.
    fn series(&self, channels: &[(usize, usize)]) -> Result<Vec<Series>> {
        let start = self.lines.iter().find(|line| line.starts_with(START_KEY));
        let start = start.and_then(|line| self.cells(line).get(1)?.parse().ok());
        let names = self.property("Name");
        let empty =
            |place: usize| Series { name: names[place].clone(), time_s: Vec::new(), values: Vec::new() };
        let mut series: Vec<Series> = channels.iter().map(|(_, place)| empty(*place)).collect();
        let number =
            |cell: &str| decimal(cell.as_bytes(), self.separator).filter(|number| number.is_finite());
        for (row, line) in self.lines.iter().enumerate().skip(self.first) {
            if line.trim() == LAST_LINE {
                break;
            }
            let cells = self.cells(line);
            for (one, (clock, place)) in series.iter_mut().zip(channels) {
                let (Some(time), Some(value)) = (cells.get(*clock), cells.get(*place)) else { continue };
                if time.is_empty() || value.is_empty() {
                    continue;
                }
                let time_s = stamp_s(time, start).or_else(|| number(time).map(|ms| ms / 1000.0));
                let (Some(time_s), Some(value)) = (time_s, truth(value).or_else(|| number(value))) else {
                    return Err(no_number(row as u64 + 1, &one.name, time, value));
                };
                one.time_s.push(time_s);
                one.values.push(value);
            }
        }
        Ok(series)
    }
}

fn no_number(row: u64, name: &str, time: &str, value: &str) -> Error {
    Error::new(ErrorKind::Syntax)
        .row(row)
        .key(name)
        .found(format!("`{time}` and `{value}`"))
        .expected("a time and a number")
        .remedy("export the channels again, or delete the row")
}

/// A time stamp of type FILETIME in s from the start; whole numbers that long lose their last digits as floating point.
fn stamp_s(cell: &str, start: Option<u64>) -> Option<f64> {
    let is_filetime = cell.len() >= FILETIME_DIGITS && cell.bytes().all(|byte| byte.is_ascii_digit());
    let stamp: u64 = is_filetime.then(|| cell.parse().ok())??;
    Some(stamp.abs_diff(start.unwrap_or(0)) as f64 * FILETIME_S)
}

/// A BIT that is written as a word.
fn truth(cell: &str) -> Option<f64> {
    match cell {
        "True" | "TRUE" => Some(1.0),
        "False" | "FALSE" => Some(0.0),
        _ => None,
    }
}

/// `V (Voltage)` is V, `(None)` nothing.
fn unit(cell: &str) -> Option<String> {
    let symbol = cell.split(" (").next().unwrap_or_default().trim();
    super::dialect::unit(symbol)
}

fn no_times(found: &str) -> Error {
    Error::new(ErrorKind::Missing)
        .found(format!("a TwinCAT Scope export with {found}"))
        .expected("a time column before each channel or group of channels")
        .remedy("export again with Timelines \"All\" or \"For each sampletime\"")
}
