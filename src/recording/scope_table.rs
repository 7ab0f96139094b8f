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

/// Reads an export.
///
/// # Errors
/// No time column, a cell that is no number, with its row (of the file, as an editor counts).
pub(super) fn read(path: &Path, text: &[u8], sha256: String) -> Result<LoadedTable> {
    let text = String::from_utf8_lossy(text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text));
    let separator = text.as_bytes().get(FIRST_KEY.len()).copied().unwrap_or(b'\t');
    let cells = |line: &str| -> Vec<String> {
        line.split(char::from(separator)).map(|cell| cell.trim().to_owned()).collect()
    };
    let lines: Vec<&str> = text.lines().collect();
    let key_of = |line: &str| line.split(char::from(separator)).next().unwrap_or_default().trim().to_owned();
    let begins = lines.iter().skip(1).position(|line| key_of(line) == "Name").map(|place| place + 1);
    let Some(begins) = begins else { return Err(no_times("no block of channels")) };
    let header: Vec<(String, Vec<String>)> = lines[begins..]
        .iter()
        .take_while(|line| !line.trim().is_empty())
        .map(|line| (key_of(line), cells(line)))
        .collect();
    let row_of = |key: &str| header.iter().find(|(name, _)| name == key).map(|(_, cells)| cells.as_slice());
    let names = row_of("Name").unwrap_or_default();
    // A time column bears the key of the line in every line; a channel called `Name` does not.
    let is_time = |place: usize| {
        header.iter().all(|(key, cells)| cells.get(place).is_some_and(|cell| cell == key))
            && !header.is_empty()
    };
    let mut clock = None;
    let mut channels: Vec<(usize, usize)> = Vec::new();
    for (place, name) in names.iter().enumerate() {
        match (is_time(place), clock) {
            (true, _) => clock = Some(place),
            (false, Some(clock)) if !name.is_empty() => channels.push((clock, place)),
            _ => {}
        }
    }
    if channels.is_empty() {
        return Err(no_times("no time column"));
    }
    let start = lines
        .iter()
        .find(|line| line.starts_with(START_KEY))
        .and_then(|line| cells(line).get(1)?.parse().ok());
    let mut series: Vec<Series> = channels
        .iter()
        .map(|(_, place)| Series { name: names[*place].clone(), time_s: Vec::new(), values: Vec::new() })
        .collect();
    let first = begins + header.len();
    for (row, line) in lines.iter().enumerate().skip(first) {
        if line.trim().is_empty() || line.trim() == LAST_LINE {
            continue;
        }
        let cells: Vec<&str> = line.split(char::from(separator)).map(str::trim).collect();
        for (one, (clock, place)) in series.iter_mut().zip(&channels) {
            let (Some(time), Some(value)) = (cells.get(*clock), cells.get(*place)) else { continue };
            if time.is_empty() || value.is_empty() {
                continue;
            }
            let number = |cell: &str| decimal(cell.as_bytes(), separator).filter(|number| number.is_finite());
            let time_s = stamp_s(time, start).or_else(|| number(time).map(|ms| ms / 1000.0));
            let (Some(time_s), Some(value)) = (time_s, truth(value).or_else(|| number(value))) else {
                return Err(Error::new(ErrorKind::Syntax)
                    .row(row as u64 + 1)
                    .key(one.name.clone())
                    .found(format!("`{time}` and `{value}`"))
                    .expected("a time and a number")
                    .remedy("export the channels again, or delete the row"));
            };
            one.time_s.push(time_s);
            one.values.push(value);
        }
    }
    let stated = row_of("Unit").unwrap_or_default();
    let units = channels.iter().map(|(_, place)| stated.get(*place).and_then(|cell| unit(cell))).collect();
    Ok(LoadedTable::new(path, FORMAT, Content::Channels(series), units, sha256))
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
