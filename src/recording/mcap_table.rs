//! MCAP with ROS 2 messages, the exchange format of robotics: joint states and single numbers, each topic with its own clock.
//!
//! A joint's channels are `TOPIC/JOINT/position`, `velocity` and `effort`, a number's is `TOPIC/data`, as PlotJuggler names them.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};

use super::cdr::{FLOAT64, JOINT_STATE, JointState, encoded_float64, float64};
use super::loaded_table::{Content, LoadedTable};
use super::mcap_records::{Message, messages};
use super::run::Run;
use super::series::Series;
use super::signal::Signal;
use crate::error::{Error, ErrorKind, Result};

pub(super) const MAGIC: &[u8] = b"\x89MCAP0\r\n";
const FORMAT: &str = "MCAP";
/// Where a written run stands, and its joint.
const TOPIC: &str = "/machine";
const JOINT: &str = "axis";
const NS_PER_S: f64 = 1e9;
/// Stamps beyond this count from an epoch, and not from a start: 1973.
const EPOCH_NS: i64 = 100_000_000_000_000_000;

/// Why a file is refused.
struct Refused(Error);

impl From<String> for Refused {
    fn from(words: String) -> Self {
        Self(damaged(&words))
    }
}

/// Reads every joint and every number of a file.
///
/// # Errors
/// A damaged file (checksums of chunks are compared), no message of a known kind.
pub(super) fn read(path: &Path, bytes: &[u8], sha256: String) -> Result<LoadedTable> {
    let mut channels: BTreeMap<String, Vec<(i64, f64)>> = BTreeMap::new();
    let mut others: BTreeMap<String, String> = BTreeMap::new();
    messages(bytes, |message| -> std::result::Result<(), Refused> {
        let Message { topic, schema, encoding, data, .. } = message;
        let is_cdr = encoding == "cdr";
        let log_ns = i64::try_from(message.log_ns).unwrap_or(i64::MAX);
        let broken = || Refused(damaged(&"a message that does not follow its schema").key(topic));
        let mut add = |name: String, stamp: i64, value: f64| {
            channels.entry(name).or_default().push((stamp, value));
        };
        if is_cdr && schema == JOINT_STATE.0 {
            let state = JointState::decoded(data).ok_or_else(broken)?;
            let stamp = if state.stamp_ns == 0 { log_ns } else { state.stamp_ns };
            let parts =
                [("position", &state.position), ("velocity", &state.velocity), ("effort", &state.effort)];
            for (part, values) in parts {
                for (joint, value) in state.name.iter().zip(values) {
                    add(format!("{topic}/{joint}/{part}"), stamp, *value);
                }
            }
        } else if is_cdr && schema == FLOAT64.0 {
            add(format!("{topic}/data"), log_ns, float64(data).ok_or_else(broken)?);
        } else {
            others.insert(topic.to_owned(), schema.to_owned());
        }
        Ok(())
    })
    .map_err(|refused| refused.0)?;
    if channels.is_empty() {
        return Err(nothing(&others));
    }
    let first = channels.values().flatten().map(|(stamp, _)| *stamp).min().unwrap_or(0);
    let zero = if first > EPOCH_NS { first } else { 0 };
    let series = channels.into_iter().map(|(name, mut samples)| {
        samples.sort_by_key(|(stamp, _)| *stamp);
        // Nanoseconds are whole, so that this division is the only rounding.
        let (time_s, values) = samples.into_iter().map(|(t, v)| ((t - zero) as f64 / NS_PER_S, v)).unzip();
        Series { name, time_s, values }
    });
    Ok(LoadedTable::new(path, FORMAT, Content::Channels(series.collect()), Vec::new(), sha256))
}

/// The channel of a signal in a file that this program wrote.
pub(super) fn channel(signal: Signal, run: &Run) -> String {
    match signal {
        Signal::Position => format!("{TOPIC}/joint_states/{JOINT}/position"),
        Signal::Velocity if has_position(run) => format!("{TOPIC}/joint_states/{JOINT}/velocity"),
        Signal::Thrust if has_position(run) => format!("{TOPIC}/joint_states/{JOINT}/effort"),
        other => extra_channel(other.key(run.motion())),
    }
}

/// The same of a column of another name.
pub(super) fn extra_channel(name: &str) -> String {
    format!("{TOPIC}/{name}/data")
}

fn has_position(run: &Run) -> bool {
    run.signal(Signal::Position).is_some()
}

/// Writes a run: position, velocity and force as a joint, each other signal as a number on a topic of its own.
pub(super) fn write(path: &Path, run: &Run) -> Result<()> {
    let failed = |error: mcap::McapError| {
        Error::new(ErrorKind::Io)
            .file(path)
            .found(error.to_string())
            .expected("an MCAP file that can be written")
            .remedy("check the folder and the space on it")
    };
    let file = File::create(path).map_err(|error| Error::io(path, &error))?;
    let options = WriteOptions::new().profile("ros2").compression(Some(Compression::Zstd));
    let mut writer = Writer::with_options(BufWriter::new(file), options).map_err(failed)?;
    let none = BTreeMap::new();
    let joint = if has_position(run) {
        let schema = writer.add_schema(JOINT_STATE.0, "ros2msg", JOINT_STATE.1.as_bytes()).map_err(failed)?;
        Some(writer.add_channel(schema, &format!("{TOPIC}/joint_states"), "cdr", &none).map_err(failed)?)
    } else {
        None
    };
    let schema = writer.add_schema(FLOAT64.0, "ros2msg", FLOAT64.1.as_bytes()).map_err(failed)?;
    let in_joint = |signal: &Signal| {
        joint.is_some() && matches!(signal, Signal::Position | Signal::Velocity | Signal::Thrust)
    };
    let signals = run.signals().iter().filter(|(signal, _)| !in_joint(signal));
    let signals = signals.map(|(signal, samples)| (signal.key(run.motion()), samples));
    let extra = run.extra_columns().iter().map(|(name, samples)| (name.as_str(), samples));
    let mut numbers = Vec::new();
    for (name, samples) in signals.chain(extra) {
        let id = writer.add_channel(schema, &format!("{TOPIC}/{name}"), "cdr", &none).map_err(failed)?;
        numbers.push((id, samples));
    }
    let of = |signal: Signal, k: usize| run.signal(signal).map(|samples| samples[k]).into_iter().collect();
    let zero_s = run.start_s.min(0.0);
    for k in 0..run.len() {
        let stamp_ns = ((run.start_s - zero_s + run.time_s(k)) * NS_PER_S).round() as i64;
        let at = |channel_id: u16| MessageHeader {
            channel_id,
            sequence: k as u32,
            log_time: stamp_ns.unsigned_abs(),
            publish_time: stamp_ns.unsigned_abs(),
        };
        if let Some(id) = joint {
            let state = JointState {
                stamp_ns,
                name: vec![JOINT.to_owned()],
                position: of(Signal::Position, k),
                velocity: of(Signal::Velocity, k),
                effort: of(Signal::Thrust, k),
            };
            writer.write_to_known_channel(&at(id), &state.encoded()).map_err(failed)?;
        }
        for (id, samples) in &numbers {
            writer.write_to_known_channel(&at(*id), &encoded_float64(samples[k])).map_err(failed)?;
        }
    }
    writer.finish().map_err(failed)?;
    Ok(())
}

fn nothing(others: &BTreeMap<String, String>) -> Error {
    let listed: Vec<String> = others.iter().map(|(topic, kind)| format!("{topic} ({kind})")).collect();
    let found =
        if listed.is_empty() { "no message".to_owned() } else { format!("the topics {}", listed.join(", ")) };
    Error::new(ErrorKind::Missing)
        .found(found)
        .expected("sensor_msgs/msg/JointState or std_msgs/msg/Float64 in CDR, as ROS 2 records them")
        .remedy("record the joint states, or convert the file")
}

fn damaged(error: &dyn std::fmt::Display) -> Error {
    Error::new(ErrorKind::Syntax)
        .found(error.to_string())
        .expected("a whole MCAP file, uncompressed or compressed with Zstandard or LZ4")
        .remedy("repair it with `mcap recover`, or record it again")
}
