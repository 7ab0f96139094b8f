//! Arrays by name: MATLAB's MAT files of versions 5 to 7 and, in HDF5, 7.3; other HDF5 files with data sets at their top.

use std::path::Path;

use matfile::{MatFile, NumericData};

use super::loaded_table::{Content, LoadedTable};
use crate::error::guarded::guarded;
use crate::error::{Error, ErrorKind, Result};

const MAT_5: &[u8] = b"MATLAB 5.0 MAT-file";
const MAT_7_3: &[u8] = b"MATLAB 7.3 MAT-file";
const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";

/// Whether a file begins as one of these does.
pub(super) fn is_array_file(bytes: &[u8]) -> bool {
    [MAT_5, MAT_7_3, HDF5].iter().any(|mark| bytes.starts_with(mark))
}

/// Reads the vectors of a file, and matrices column by column; numbers alone and what is no number are left aside.
///
/// # Errors
/// A file that is damaged, or that holds no vector.
pub(super) fn read(path: &Path, bytes: Vec<u8>, sha256: String) -> Result<LoadedTable> {
    let (format, arrays) = if bytes.starts_with(MAT_5) {
        ("MAT file, version 5 to 7", guarded("MAT file", || mat_5(&bytes))?)
    } else if bytes.starts_with(MAT_7_3) {
        ("MAT file, version 7.3", guarded("MAT file", || hdf5(bytes, true))?)
    } else {
        ("HDF5", guarded("HDF5 file", || hdf5(bytes, false))?)
    };
    let arrays: Vec<(String, Vec<f64>)> = arrays.into_iter().flat_map(vectors).collect();
    if arrays.is_empty() {
        return Err(Error::new(ErrorKind::Missing)
            .found(format!("a {format} without a vector of numbers"))
            .expected("time and signals as arrays at the top of the file")
            .remedy("save the fields of a structure as variables: `save(file, \"-struct\", \"name\")`"));
    }
    Ok(LoadedTable::new(path, format, Content::Arrays(arrays), Vec::new(), sha256))
}

/// An array, first index fastest.
struct Array {
    name: String,
    size: Vec<usize>,
    values: Vec<f64>,
}

fn mat_5(bytes: &[u8]) -> Result<Vec<Array>> {
    // The parser takes a file that is cut off for a shorter one.
    if !is_whole(bytes) {
        return Err(damaged(&"a file that is cut off"));
    }
    let file = MatFile::parse(bytes).map_err(|error| damaged(&error))?;
    let array = |array: &matfile::Array| Array {
        name: array.name().to_owned(),
        size: array.size().clone(),
        values: real(array.data()),
    };
    Ok(file.arrays().iter().map(array).collect())
}

/// Whether the last element of a MAT file ends where the file does: a header of 128 bytes, then elements with type and length.
fn is_whole(bytes: &[u8]) -> bool {
    let word = |at: usize| -> Option<usize> {
        let word: [u8; 4] = bytes.get(at..at + 4)?.try_into().ok()?;
        let little = bytes.get(126..128) == Some(b"IM");
        Some(if little { u32::from_le_bytes(word) } else { u32::from_be_bytes(word) } as usize)
    };
    let mut at = 128;
    while at < bytes.len() {
        match word(at + 4).and_then(|length| at.checked_add(8 + length)) {
            Some(end) if end <= bytes.len() => at = end,
            _ => return false,
        }
    }
    true
}

fn real(data: &NumericData) -> Vec<f64> {
    match data {
        NumericData::Int8 { real, .. } => real.iter().map(|v| f64::from(*v)).collect(),
        NumericData::UInt8 { real, .. } => real.iter().map(|v| f64::from(*v)).collect(),
        NumericData::Int16 { real, .. } => real.iter().map(|v| f64::from(*v)).collect(),
        NumericData::UInt16 { real, .. } => real.iter().map(|v| f64::from(*v)).collect(),
        NumericData::Int32 { real, .. } => real.iter().map(|v| f64::from(*v)).collect(),
        NumericData::UInt32 { real, .. } => real.iter().map(|v| f64::from(*v)).collect(),
        // Counts beyond 2^53 would round; no encoder counts so far.
        NumericData::Int64 { real, .. } => real.iter().map(|v| *v as f64).collect(),
        NumericData::UInt64 { real, .. } => real.iter().map(|v| *v as f64).collect(),
        NumericData::Single { real, .. } => real.iter().map(|v| f64::from(*v)).collect(),
        NumericData::Double { real, .. } => real.clone(),
    }
}

/// The data sets of numbers at the top; MATLAB stores the first index fastest, others the last.
fn hdf5(bytes: Vec<u8>, first_fastest: bool) -> Result<Vec<Array>> {
    let file = hdf5_pure::File::from_bytes(bytes).map_err(|error| damaged(&error))?;
    let names = file.root().datasets().map_err(|error| damaged(&error))?;
    let mut arrays = Vec::new();
    for name in names {
        let set = file.dataset(&name).map_err(|error| damaged(&error).key(name.clone()))?;
        let size = set.shape().map_err(|error| damaged(&error).key(name.clone()))?;
        // Texts, references and structures are no numbers.
        let Ok(values) = set.read_f64() else { continue };
        let mut size: Vec<usize> = size.iter().map(|n| *n as usize).collect();
        let values = match (first_fastest, size.as_slice()) {
            (true, _) => {
                size.reverse();
                values
            }
            (false, &[rows, columns]) if values.len() == rows * columns => (0..columns)
                .flat_map(|c| (0..rows).map(move |r| r * columns + c))
                .map(|k| values[k])
                .collect(),
            (false, _) => values,
        };
        arrays.push(Array { name, size, values });
    }
    Ok(arrays)
}

/// The vectors that an array holds: itself, or the columns (or rows, where they are longer) of a matrix.
fn vectors(array: Array) -> Vec<(String, Vec<f64>)> {
    let Array { name, size, values } = array;
    let long: Vec<usize> = size.iter().copied().filter(|n| *n > 1).collect();
    match (long.as_slice(), size.as_slice()) {
        ([n], _) if values.len() == *n => vec![(name, values)],
        (&[_, _], &[rows, columns]) if values.len() == rows * columns => {
            if rows >= columns {
                let column =
                    |c: usize| (format!("{name}(:,{})", c + 1), values[c * rows..(c + 1) * rows].to_vec());
                (0..columns).map(column).collect()
            } else {
                let row = |r: usize| values.iter().skip(r).step_by(rows).copied().collect();
                (0..rows).map(|r| (format!("{name}({},:)", r + 1), row(r))).collect()
            }
        }
        _ => Vec::new(),
    }
}

fn damaged(error: &dyn std::fmt::Display) -> Error {
    Error::new(ErrorKind::Syntax)
        .found(error.to_string())
        .expected("a MAT or HDF5 file with arrays of numbers")
        .remedy("save the file again (`save(file, \"-v7\")` in MATLAB), or export CSV")
}
