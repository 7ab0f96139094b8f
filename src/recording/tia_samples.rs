//! The samples of a recording of TIA Portal's trace function.
//!
//! # Layout
//! Little-endian; a text is preceded by its length in one byte.
//!
//! | part | content |
//! |---|---|
//! | head | `"TSP:1.0"`, 1 byte, 4 bytes, time in ns (8 bytes), number of samples twice (4 bytes each), 16 bytes, signals: their number and the identifier of each (4 bytes each), types: their number and each (4 bytes each) |
//! | times | 4 bytes, `"TSSBL:1.0"`, a number and so many cycle counts (4 bytes each), a number and so many times in ns since 1970 (8 bytes each) |
//! | values | the number of signals (4 bytes), then of each: its type (4 bytes), `"TSSG:1.0"`, 4 bytes, a number and so many values |
//!
//! Types are those of .NET's `System.TypeCode`: 5 to 12 the integers from one to eight bytes, signed and unsigned in turn, 13 a float
//! of four bytes, 14 one of eight; 3 is a truth value of one byte.
//!
//! # Source
//! No specification is published. The layout is that of a public reader of such files, whose tests hold bytes of a controller's
//! recording with types 9 and 14; the other types follow from their code and are borne out, or refused, by the text that begins the
//! next part.

use crate::error::{Error, ErrorKind, Result};

/// What a file holds: when each sample was taken, and the values of each signal by its identifier.
#[derive(Debug, PartialEq)]
pub(super) struct Samples {
    /// From the first sample on.
    pub(super) time_s: Vec<f64>,
    pub(super) signals: Vec<(i32, Vec<f64>)>,
}

const HEAD: &[u8] = b"\x07TSP:1.0";
const TIMES: &[u8] = b"\x09TSSBL:1.0";
const VALUES: &[u8] = b"\x08TSSG:1.0";
const NS_PER_S: f64 = 1e9;

/// Reads the samples.
///
/// # Errors
/// With the byte: what is cut off or of another layout, a signal with more or fewer values than there are times.
pub(super) fn samples(bytes: &[u8]) -> Result<Samples> {
    let mut reader = Reader { bytes, at: 0 };
    reader.text(HEAD)?;
    reader.skip(1 + 4 + 8 + 4 + 4 + 16)?;
    let identifiers = reader.list(4)?.chunks_exact(4).map(|four| i32::from_le_bytes(array(four)));
    let identifiers: Vec<i32> = identifiers.collect();
    reader.list(4)?;
    reader.skip(4)?;
    reader.text(TIMES)?;
    reader.list(4)?;
    let times = reader.list(8)?.chunks_exact(8).map(|eight| u64::from_le_bytes(array(eight)));
    let times_ns: Vec<u64> = times.collect();
    let count = reader.number()?;
    if count != identifiers.len() {
        return Err(
            reader.refused(format!("values of {count} signals after a list of {}", identifiers.len()))
        );
    }
    let mut signals = Vec::new();
    for identifier in identifiers {
        let values = reader.values()?;
        if values.len() != times_ns.len() {
            let found = format!("{} values of signal {identifier} at {} times", values.len(), times_ns.len());
            return Err(reader.refused(found));
        }
        signals.push((identifier, values));
    }
    let first = times_ns.first().copied().unwrap_or(0);
    // A clock that was set back shows as times that do not increase, not as times of half a millennium.
    let since = |ns: u64| i128::from(ns) - i128::from(first);
    let time_s = times_ns.iter().map(|&ns| since(ns) as f64 / NS_PER_S).collect();
    Ok(Samples { time_s, signals })
}

/// What is read, and up to where.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn skip(&mut self, count: usize) -> Result<&'a [u8]> {
        let end = self.at.checked_add(count);
        let part = end.and_then(|end| self.bytes.get(self.at..end));
        let Some(part) = part else {
            let left = self.bytes.len() - self.at;
            return Err(self.refused(format!("{left} bytes where {count} are announced")));
        };
        self.at += count;
        Ok(part)
    }

    fn text(&mut self, wanted: &[u8]) -> Result<()> {
        let from = self.at;
        if self.skip(wanted.len()).is_ok_and(|found| found == wanted) {
            return Ok(());
        }
        self.at = from;
        let wanted = String::from_utf8_lossy(&wanted[1..]);
        Err(self.refused(format!("another part than \"{wanted}\"")))
    }

    fn number(&mut self) -> Result<usize> {
        let number = u32::from_le_bytes(array(self.skip(4)?));
        usize::try_from(number).map_err(|_| self.refused(format!("a number of {number}")))
    }

    /// The bytes of a list that begins with its length.
    fn list(&mut self, size: usize) -> Result<&'a [u8]> {
        let count = self.number()?;
        match count.checked_mul(size) {
            Some(bytes) => self.skip(bytes),
            None => Err(self.refused(format!("a list of {count}"))),
        }
    }

    /// The values of a signal.
    fn values(&mut self) -> Result<Vec<f64>> {
        let kind = self.number()?;
        self.text(VALUES)?;
        self.skip(4)?;
        match kind {
            3 | 6 => self.converted(|[byte]: [u8; 1]| f64::from(byte)),
            5 => self.converted(|byte: [u8; 1]| f64::from(i8::from_le_bytes(byte))),
            7 => self.converted(|two: [u8; 2]| f64::from(i16::from_le_bytes(two))),
            8 => self.converted(|two: [u8; 2]| f64::from(u16::from_le_bytes(two))),
            9 => self.converted(|four: [u8; 4]| f64::from(i32::from_le_bytes(four))),
            10 => self.converted(|four: [u8; 4]| f64::from(u32::from_le_bytes(four))),
            11 => self.converted(|eight: [u8; 8]| i64::from_le_bytes(eight) as f64),
            12 => self.converted(|eight: [u8; 8]| u64::from_le_bytes(eight) as f64),
            13 => self.converted(|four: [u8; 4]| f64::from(f32::from_le_bytes(four))),
            14 => self.converted(f64::from_le_bytes),
            _ => Err(self.refused(format!("values of type {kind}, which is not known"))),
        }
    }

    fn converted<const N: usize>(&mut self, value: impl Fn([u8; N]) -> f64) -> Result<Vec<f64>> {
        Ok(self.list(N)?.chunks_exact(N).map(|bytes| value(array(bytes))).collect())
    }

    fn refused(&self, found: String) -> Error {
        Error::new(ErrorKind::Syntax)
            .key("Samples")
            .found(format!("{found}, from byte {} on", self.at))
            .expected("samples as TIA Portal's trace writes them, version 1.0")
            .remedy("export the recording again, or as CSV")
    }
}

/// Bytes whose number is known; those of a list have it.
fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
    let mut array = [0; N];
    array.copy_from_slice(bytes);
    array
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// The samples of three signals: doubles, 32-bit integers and truth values.
    pub(in crate::recording) fn written(times_ns: &[u64], doubles: &[f64]) -> Vec<u8> {
        let count = u32::try_from(times_ns.len()).unwrap().to_le_bytes();
        let mut bytes = [HEAD, &[1], &[0; 4], &times_ns[0].to_le_bytes(), &count, &count, &[0; 16]].concat();
        let list = |numbers: [u32; 3]| [3, numbers[0], numbers[1], numbers[2]].map(u32::to_le_bytes).concat();
        bytes.extend(list([0, 4, 61]));
        bytes.extend(list([14, 9, 3]));
        bytes.extend([&[1, 0, 0, 0], TIMES, &count].concat());
        bytes.extend((0..times_ns.len()).flat_map(|k| u32::try_from(k).unwrap().to_le_bytes()));
        bytes.extend(count);
        bytes.extend(times_ns.iter().flat_map(|ns| ns.to_le_bytes()));
        bytes.extend([3, 0, 0, 0]);
        let block = |kind: u8| [&[kind, 0, 0, 0], VALUES, &[0; 4], &count].concat();
        bytes.extend(block(14));
        bytes.extend(doubles.iter().flat_map(|value| value.to_le_bytes()));
        bytes.extend(block(9));
        bytes.extend((0..times_ns.len()).flat_map(|k| (-i32::try_from(k).unwrap()).to_le_bytes()));
        bytes.extend(block(3));
        bytes.extend((0..times_ns.len()).map(|k| u8::from(k % 2 == 1)));
        bytes
    }

    /// The head of a controller's recording with 30 signals and 500 samples, as the reader that the layout is from holds it.
    #[test]
    fn ref_the_head_of_a_controllers_recording_is_read() {
        let mut bytes =
            b"\x07TSP:1.0\x01\x9f\x6c\x48\x00\x1b\xf2\xf0\x8d\x70\x3a\x52\x18\xf4\x01\0\0\xf4\x01\0\0"
                .to_vec();
        bytes.extend([0; 16]);
        bytes.extend(30_u32.to_le_bytes());
        bytes.extend((0..29_u32).chain([61]).flat_map(u32::to_le_bytes));
        bytes.extend(30_u32.to_le_bytes());
        bytes.extend(std::iter::repeat_n(14_u32, 28).chain([9, 9]).flat_map(u32::to_le_bytes));
        assert_eq!(bytes.len(), 293);
        // What is missing is noticed where the times should begin.
        let error = samples(&bytes).unwrap_err().to_string();
        assert!(error.contains("from byte 293 on"), "{error}");
    }

    #[test]
    fn exact_times_and_values_are_those_written() {
        let times = [1_752_527_459_096_670_491, 1_752_527_459_100_670_491, 1_752_527_459_104_670_491];
        let read = samples(&written(&times, &[22.956, -1.0, f64::MIN_POSITIVE])).unwrap();
        assert_eq!(read.time_s, [0.0, 4e-3, 8e-3]);
        let signals = [
            (0, vec![22.956, -1.0, f64::MIN_POSITIVE]),
            (4, vec![0.0, -1.0, -2.0]),
            (61, vec![0.0, 1.0, 0.0]),
        ];
        assert_eq!(read.signals, signals);
    }

    #[test]
    fn exact_what_is_cut_off_or_of_another_kind_is_refused_where_it_is() {
        let whole = written(&[0, 1], &[1.0, 2.0]);
        for end in 0..whole.len() {
            let error = samples(&whole[..end]).unwrap_err().to_string();
            assert!(error.contains("from byte"), "{end}: {error}");
        }
        let refused = |from: &[u8], to: &[u8]| {
            let at = whole.windows(from.len()).rposition(|part| part == from).unwrap();
            let mut bytes = whole.clone();
            bytes[at..at + from.len()].copy_from_slice(to);
            samples(&bytes).unwrap_err().to_string()
        };
        let kind = [&[3, 0, 0, 0], VALUES].concat();
        let error = refused(&kind, &[&[18, 0, 0, 0], VALUES].concat());
        assert!(error.contains("values of type 18"), "{error}");
        // Truth values taken for others of eight bytes do not fit.
        let error = refused(&kind, &[&[14, 0, 0, 0], VALUES].concat());
        assert!(error.contains("are announced"), "{error}");
        let error = refused(b"\x02\0\0\0\0\x01", b"\x01\0\0\0\0\x01");
        assert!(error.contains("1 values of signal 61 at 2 times"), "{error}");
    }
}
