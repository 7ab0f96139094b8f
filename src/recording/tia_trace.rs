//! Recordings of the trace function of TIA Portal (`.ttrecx`): SIMATIC S7-1200 and S7-1500 controllers, SINAMICS drives.
//!
//! # Layout
//! A ZIP archive. Its entry `Signals` lists what was recorded, its entry `Samples` holds the numbers, see [`samples`].
//! ```xml
//! <Signals version="1.0">
//!   <RecordSignal signalId="0">
//!     <ConfigurationSignal signalId="0"><Name>"Axis".ActualPosition</Name>…</ConfigurationSignal>
//!     <Unit>mm</Unit>
//!   </RecordSignal>
//! ```
//! A signal's column has its name without the quotation marks, `a[1]` as `a_1` (text in brackets is taken for a unit), and its
//! identifier where several have that name.

use std::collections::BTreeMap;
use std::io::{Cursor, Read as _};
use std::path::Path;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use zip::ZipArchive;

use super::decode::MOST_BYTES;
use super::loaded_table::{Content, LoadedTable};
use super::series::Series;
use super::tia_samples::samples;
use crate::error::toml_text::line_of;
use crate::error::{Error, ErrorKind, Result};

/// What a ZIP archive begins with.
pub(super) const MAGIC: &[u8] = b"PK\x03\x04";
const FORMAT: &str = "recording of TIA Portal's trace";

/// Reads a recording.
///
/// # Errors
/// An archive that is damaged or holds something else, a list of signals that is none, samples of another layout.
pub(super) fn read(path: &Path, bytes: &[u8], sha256: String) -> Result<LoadedTable> {
    let damaged = |error: &dyn std::fmt::Display| no_recording(format!("a damaged ZIP archive ({error})"));
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| damaged(&error))?;
    let mut entry = |name: &str| -> Result<Vec<u8>> {
        if archive.index_for_name(name).is_none() {
            return Err(no_recording(format!("a ZIP archive without an entry {name}")));
        }
        let entry = archive.by_name(name).map_err(|error| damaged(&error))?;
        let mut content = Vec::new();
        entry.take(MOST_BYTES + 1).read_to_end(&mut content).map_err(|error| damaged(&error))?;
        if content.len() as u64 > MOST_BYTES {
            return Err(no_recording(format!("more than 4 GiB in the entry {name}")));
        }
        Ok(content)
    };
    let told = listed(&String::from_utf8_lossy(&entry("Signals")?))?;
    let recorded = samples(&entry("Samples")?)?;
    let known = |identifier: &i32| told.get(identifier).cloned().unwrap_or_default();
    let names: Vec<String> = recorded.signals.iter().map(|(identifier, _)| known(identifier).name).collect();
    let column = |(identifier, values): &(i32, Vec<f64>)| {
        let name = known(identifier).name;
        let name = match names.iter().filter(|other| **other == name).count() {
            _ if name.is_empty() => format!("signal {identifier}"),
            1 => name,
            _ => format!("{name} {identifier}"),
        };
        Series { name, time_s: recorded.time_s.clone(), values: values.clone() }
    };
    let series: Vec<Series> = recorded.signals.iter().map(column).collect();
    let units = recorded.signals.iter().map(|(identifier, _)| known(identifier).unit).collect();
    Ok(LoadedTable::new(path, FORMAT, Content::Channels(series), units, sha256))
}

/// What the list says of a signal.
#[derive(Debug, Default, Clone, PartialEq)]
struct Told {
    name: String,
    unit: Option<String>,
}

impl Told {
    /// What an element says: the first name is the signal's own.
    fn hears(&mut self, element: &[u8], text: &str) {
        let text = text.trim();
        match element {
            b"Name" if self.name.is_empty() => self.name = column(text),
            b"Unit" if !text.is_empty() => self.unit = Some(text.to_owned()),
            _ => {}
        }
    }
}

/// Name and unit of each signal of the list, by its identifier.
fn listed(text: &str) -> Result<BTreeMap<i32, Told>> {
    let text = text.trim_start_matches('\u{feff}');
    let mut reader = Reader::from_str(text);
    let mut signals: BTreeMap<i32, Told> = BTreeMap::new();
    let mut current = None;
    loop {
        let at = usize::try_from(reader.buffer_position()).unwrap_or(0);
        let refuse = |found: String| no_list(found).row(line_of(text, at));
        match reader.read_event().map_err(|error| refuse(format!("what is no XML ({error})")))? {
            Event::Eof => return Ok(signals),
            Event::Start(element) if element.name().as_ref() == b"RecordSignal" => {
                let own = identifier(&element);
                let own = own.ok_or_else(|| refuse("a signal without signalId".to_owned()))?;
                signals.insert(own, Told::default());
                current = Some(own);
            }
            Event::Start(element) if matches!(element.name().as_ref(), b"Name" | b"Unit") => {
                let content = reader.read_text(element.name());
                let content = content.map_err(|error| refuse(format!("what is no XML ({error})")))?;
                let plain = quick_xml::escape::unescape(&content);
                let plain = plain.map_err(|error| refuse(format!("an entity that is none ({error})")))?;
                if let Some(told) = current.and_then(|own| signals.get_mut(&own)) {
                    told.hears(element.name().as_ref(), &plain);
                }
            }
            Event::End(element) if element.name().as_ref() == b"RecordSignal" => current = None,
            _ => {}
        }
    }
}

/// The name of a variable as that of a column.
fn column(name: &str) -> String {
    name.replace(['"', ']'], "").replace('[', "_")
}

/// The identifier of a signal.
fn identifier(element: &BytesStart) -> Option<i32> {
    let attribute = element.try_get_attribute("signalId").ok()??;
    std::str::from_utf8(&attribute.value).ok()?.trim().parse().ok()
}

fn no_list(found: String) -> Error {
    Error::new(ErrorKind::Syntax)
        .key("Signals")
        .found(found)
        .expected("the list of signals of a recording of TIA Portal's trace")
        .remedy("export the recording again, or as CSV")
}

fn no_recording(found: String) -> Error {
    Error::new(ErrorKind::Syntax)
        .found(found)
        .expected("a recording of TIA Portal's trace (.ttrecx) with the entries Signals and Samples")
        .remedy("unpack another archive and name the table in it; save the sheet of a workbook as CSV")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_names_and_units_are_those_of_the_list() {
        let text = "\u{feff}<?xml version=\"1.0\"?><Signals version=\"1.0\" nextSignalId=\"5\">
            <RecordSignal signalId=\"0\"><ConfigurationSignal signalId=\"0\"><Name>\"My axis\".Velocity</Name><Comment />
            </ConfigurationSignal><Visualisation displayColor=\"1,2,3,4\" /><Unit>mm/s²</Unit></RecordSignal>
            <RecordSignal signalId=\"4\"><ConfigurationSignal signalId=\"4\"><Name>a &amp; b[1].c</Name></ConfigurationSignal>
            <Unit /></RecordSignal></Signals>";
        let signals = listed(text).unwrap();
        let told =
            |name: &str, unit: Option<&str>| Told { name: name.to_owned(), unit: unit.map(str::to_owned) };
        assert_eq!(signals[&0], told("My axis.Velocity", Some("mm/s²")));
        assert_eq!(signals[&4], told("a & b_1.c", None));
        let error = listed("<Signals>\n<RecordSignal>").unwrap_err().to_string();
        assert!(error.contains("signalId") && error.contains('2'), "{error}");
        assert!(listed("<Signals><a></b>").unwrap_err().to_string().contains("no XML"));
    }
}
