//! Columns of a table file as they stand in it, before anything is mapped.

use std::ops::Range;

use crate::error::{Error, ErrorKind};

/// The columns that were asked for, as they stand in the file.
#[derive(Debug)]
pub(super) struct Columns {
    /// Row of the first sample: 2 below the header of a CSV file, 1 in a Parquet file.
    pub(super) first_row: u64,
    /// One vector a wanted column, all of one length, all finite.
    pub(super) values: Vec<Vec<f64>>,
    /// SHA-256 of the file.
    pub(super) sha256: String,
    /// What was done to read it so, in words; empty where it was plain.
    pub(super) remarks: Vec<String>,
}

impl Columns {
    /// Keeps these samples only; rows are still counted as in the file.
    pub(super) fn cut(&mut self, samples: Range<usize>) {
        for column in &mut self.values {
            column.truncate(samples.end);
            column.drain(..samples.start.min(column.len()));
        }
        self.first_row += samples.start as u64;
    }
}

/// The refusal of a file without a single row.
pub(super) fn no_rows() -> Error {
    Error::new(ErrorKind::TooLittleData)
        .found("a header without rows")
        .expected("at least one row of numbers")
        .remedy("take the run out of the recording, or record it again")
}
