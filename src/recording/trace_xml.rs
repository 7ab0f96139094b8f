//! Traces of Siemens SINUMERIK controls: XML, the signals listed above records that hold a time and what changed.
//!
//! # Layout
//! ```xml
//! <traceSession version="…">
//!   <traceData dataFrames="1">
//!     <dataFrame>
//!       <frameHeader startTime="…" dropOuts="0"/>
//!       <dataSignal id="f1" name="/Nck/…[u1, 1]" description="…" interval="0.002" unitsType="…" datapointCount="…"/>
//!       <rec time="0" f1="12.5"/>
//! ```
//! Times and intervals are in s. A record leaves out a signal that did not change, and one whose own interval has not passed. No unit
//! is written: `unitsType` says the kind of quantity, its unit is that of the control's settings.
//!
//! # Source
//! No specification is published; the layout is the one that three independent public readers of such files agree on.

use std::collections::BTreeMap;
use std::path::Path;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::loaded_table::{Content, LoadedTable};
use super::series::Series;
use crate::error::toml_text::line_of;
use crate::error::{Error, ErrorKind, Result};

const FORMAT: &str = "SINUMERIK trace";
/// The element at the root, which stands near the beginning.
const ROOT: &[u8] = b"<traceSession";
const HEAD_BYTES: usize = 1024;
const EXPECTED: &str = "a SINUMERIK trace: <dataSignal> elements, then <rec> elements with a time and values";
/// Values from here on are the bit pattern of a number that is none, printed as an integer.
const NO_NUMBER: f64 = 9.218_868_437_227_4e18;
/// What the control adds to a description; in brackets, it would be taken for a unit.
const WIDTH: &str = "(64 bit)";
/// A signal has its own clock where its interval is so many times that of the records.
const SLOWER: f64 = 1.5;

/// Whether a text is such a trace.
pub(super) fn is_trace(text: &[u8]) -> bool {
    let head = &text[..text.len().min(HEAD_BYTES)];
    head.windows(ROOT.len()).any(|window| window == ROOT)
}

/// Reads a trace.
///
/// # Errors
/// With its line: what is no XML, a value that is no number, a second data frame; a trace without signals or records.
pub(super) fn read(path: &Path, text: &[u8], sha256: String) -> Result<LoadedTable> {
    let series = parse(&String::from_utf8_lossy(text))?.series()?;
    Ok(LoadedTable::new(path, FORMAT, Content::Channels(series), Vec::new(), sha256))
}

fn parse(text: &str) -> Result<Trace> {
    let mut trace = Trace::default();
    let mut reader = Reader::from_str(text);
    let mut open = 0_usize;
    loop {
        let at = usize::try_from(reader.buffer_position()).unwrap_or(0);
        let refuse = |found: String| malformed(found).row(line_of(text, at));
        match reader.read_event().map_err(|error| refuse(format!("what is no XML ({error})")))? {
            Event::Eof if open > 0 => return Err(refuse("a file that is cut off".to_owned())),
            Event::Eof => return Ok(trace),
            Event::Start(element) => {
                open += 1;
                trace.element(&element).map_err(|error| error.row(line_of(text, at)))?;
            }
            Event::Empty(element) => {
                trace.element(&element).map_err(|error| error.row(line_of(text, at)))?;
            }
            Event::End(_) => open = open.saturating_sub(1),
            _ => {}
        }
    }
}

/// A signal of the list.
struct Signal {
    id: String,
    name: String,
    description: String,
    interval_s: Option<f64>,
    /// What each record holds of it: nothing where it is left out.
    values: Vec<Option<f64>>,
}

#[derive(Default)]
struct Trace {
    frames: usize,
    signals: Vec<Signal>,
    time_s: Vec<f64>,
}

impl Trace {
    fn element(&mut self, element: &BytesStart) -> Result<()> {
        match element.name().as_ref() {
            b"dataFrame" => self.frame(),
            b"dataSignal" => self.signal(&attributes(element)?),
            b"rec" => self.record(&attributes(element)?),
            _ => Ok(()),
        }
    }

    fn frame(&mut self) -> Result<()> {
        self.frames += 1;
        if self.frames == 1 {
            return Ok(());
        }
        Err(Error::new(ErrorKind::Inconsistent)
            .key("dataFrame")
            .found("a second data frame")
            .expected("one, from the start of the recording to its end")
            .remedy("save each recording of the trace as a file of its own: it is a run of its own"))
    }

    fn signal(&mut self, attributes: &BTreeMap<String, String>) -> Result<()> {
        let text = |key: &str| attributes.get(key).map(|text| text.trim().to_owned()).unwrap_or_default();
        let id = text("id");
        if id.is_empty() || self.signals.iter().any(|signal| signal.id == id) {
            return Err(malformed(format!("a <dataSignal> with the id \"{id}\"")).key("id"));
        }
        let interval_s = attributes.get("interval").and_then(|text| text.parse().ok());
        let interval_s = interval_s.filter(|interval: &f64| *interval > 0.0 && interval.is_finite());
        self.signals.push(Signal {
            id,
            name: text("name"),
            description: text("description").replace(WIDTH, "").trim().to_owned(),
            interval_s,
            values: Vec::new(),
        });
        Ok(())
    }

    fn record(&mut self, attributes: &BTreeMap<String, String>) -> Result<()> {
        let time = attributes.get("time").ok_or_else(|| malformed("a <rec> without time".to_owned()))?;
        self.time_s.push(number("time", time)?);
        for signal in &mut self.signals {
            let value = attributes.get(&signal.id).map(|text| number(&signal.id, text)).transpose()?;
            signal.values.push(value);
        }
        Ok(())
    }

    /// The channels, each on its own clock.
    fn series(&self) -> Result<Vec<Series>> {
        if self.signals.is_empty() || self.time_s.len() < 2 {
            return Err(Error::new(ErrorKind::TooLittleData)
                .found(format!("{} signals and {} records", self.signals.len(), self.time_s.len()))
                .expected(EXPECTED)
                .remedy("save the trace with its data, not its settings alone"));
        }
        let record_s = (self.time_s[self.time_s.len() - 1] - self.time_s[0]) / (self.time_s.len() - 1) as f64;
        let series = self.signals.iter().enumerate().map(|(k, signal)| {
            let own_s = signal.interval_s.filter(|interval| *interval > SLOWER * record_s);
            let (time_s, values) = signal.samples(&self.time_s, own_s, 0.5 * record_s);
            Series { name: self.column(k), time_s, values }
        });
        Ok(series.collect())
    }

    /// What a column is called: its description; with the axis in the brackets of its name where several have that description.
    fn column(&self, place: usize) -> String {
        let signal = &self.signals[place];
        let alike = |text: fn(&Signal) -> String| {
            self.signals.iter().filter(|other| text(other) == text(signal)).count() > 1
        };
        let plain: fn(&Signal) -> String = |signal| signal.description.clone();
        let with_axis: fn(&Signal) -> String = |signal| format!("{} {}", signal.description, signal.axis());
        match signal.description.is_empty() {
            false if !alike(plain) => plain(signal),
            false if !alike(with_axis) => with_axis(signal),
            _ if !signal.name.is_empty() => format!("{} {}", signal.name, signal.id),
            _ => signal.id.clone(),
        }
    }
}

impl Signal {
    /// "u1_1" of "/Nck/!SD/nckServoDataActPos[u1, 1]": text in brackets is taken for a unit.
    fn axis(&self) -> String {
        let inside = self.name.split_once('[').map_or("", |(_, rest)| rest);
        inside
            .split(|c: char| !c.is_alphanumeric())
            .filter(|part| !part.is_empty())
            .collect::<Vec<_>>()
            .join("_")
    }

    /// Its samples: a value that is left out is the one before it; what is no number is a lost sample. A slower signal has a sample
    /// at each of its own intervals.
    fn samples(&self, time_s: &[f64], own_s: Option<f64>, tolerance_s: f64) -> (Vec<f64>, Vec<f64>) {
        let mut last = None;
        let mut first_s = None;
        let mut samples = Vec::new();
        for (&time, value) in time_s.iter().zip(&self.values) {
            last = value.or(last);
            let Some(value) = last else { continue };
            let since = time - *first_s.get_or_insert(time);
            let is_due = own_s.is_none_or(|own| (since - own * (since / own).round()).abs() < tolerance_s);
            if is_due && value.is_finite() && value.abs() < NO_NUMBER {
                samples.push((time, value));
            }
        }
        samples.into_iter().unzip()
    }
}

fn attributes(element: &BytesStart) -> Result<BTreeMap<String, String>> {
    let mut all = BTreeMap::new();
    for attribute in element.attributes() {
        let attribute =
            attribute.map_err(|error| malformed(format!("an attribute that is none ({error})")))?;
        let value = attribute.unescape_value();
        let value = value.map_err(|error| malformed(format!("an attribute with an entity ({error})")))?;
        all.insert(String::from_utf8_lossy(attribute.key.as_ref()).into_owned(), value.into_owned());
    }
    Ok(all)
}

fn number(key: &str, text: &str) -> Result<f64> {
    let number = text.trim().parse::<f64>().ok().filter(|number| key != "time" || number.is_finite());
    number.ok_or_else(|| malformed(format!("{key}=\"{text}\"")).key(key.to_owned()))
}

fn malformed(found: String) -> Error {
    Error::new(ErrorKind::Syntax)
        .found(found)
        .expected(EXPECTED)
        .remedy("correct that line, or save the trace again")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(body: &str) -> Result<Vec<Series>> {
        let text = format!(
            "<?xml version=\"1.0\"?><traceSession version=\"3\"><traceData><dataFrame>{body}</dataFrame></traceData></traceSession>"
        );
        parse(&text)?.series()
    }

    #[test]
    fn exact_a_value_that_is_left_out_is_the_one_before_it_and_a_slow_signal_has_its_own_clock() {
        let mut body = String::from(
            "<dataSignal id='f1' name='/a[u1, 1]' description='Position' interval='0.002'/>\
             <dataSignal id='f2' name='/b[u1, 1]' description='Load' interval='0.006'/>",
        );
        for k in 0..13 {
            let slow = if k % 3 == 0 && k != 6 { format!(" f2='{k}'") } else { String::new() };
            let fast = if k == 4 { String::new() } else { format!(" f1='{}'", 10 * k) };
            body += &format!("<rec time='{}'{fast}{slow}/>", f64::from(k) * 2e-3);
        }
        let series = trace(&body).unwrap();
        assert_eq!((series[0].values.len(), series[0].values[4]), (13, 30.0));
        // At 12 ms the load did not change: it is still that of 6 ms.
        assert_eq!(series[1].values, [0.0, 3.0, 3.0, 9.0, 12.0]);
        assert_eq!(series[1].time_s.len(), 5);
    }

    #[test]
    fn exact_what_is_no_number_is_a_lost_sample() {
        let body = "<dataSignal id='f1' description='Position' interval='0.002'/>\
                    <rec time='0' f1='9221120237041090560'/><rec time='0.002' f1='1'/><rec time='0.004' f1='2'/>";
        let series = trace(body).unwrap();
        assert_eq!(
            (series[0].time_s.clone(), series[0].values.clone()),
            (vec![0.002, 0.004], vec![1.0, 2.0])
        );
        let error = trace("<dataSignal id='f1'/><rec time='0' f1='x'/>").unwrap_err().to_string();
        assert!(error.contains("f1=\"x\""), "{error}");
    }

    #[test]
    fn exact_columns_of_several_axes_are_told_apart() {
        let body = "<dataSignal id='f1' name='/a[u1, 1]' description='Position'/>\
                    <dataSignal id='f2' name='/a[u1, 2]' description='Position'/>\
                    <dataSignal id='f3' name='/c[u1, 1]' description='Torque'/>\
                    <rec time='0' f1='0' f2='0' f3='0'/><rec time='1' f1='0'/>";
        let names: Vec<String> = trace(body).unwrap().into_iter().map(|one| one.name).collect();
        assert_eq!(names, ["Position u1_1", "Position u1_2", "Torque"]);
    }
}
