//! A table file, CSV or Parquet: column names first, then the columns that are wanted.

use std::ops::Range;
use std::path::Path;

use super::csv_table::CsvTable;
use super::parquet_table::ParquetTable;
use crate::error::{Error, ErrorKind, Result};

/// The columns that were asked for, as they stand in the file.
#[derive(Debug)]
pub(super) struct Columns {
    /// Row of the first sample: 2 below the header of a CSV file, 1 in a Parquet file.
    pub(super) first_row: u64,
    /// One vector a wanted column, all of one length, all finite.
    pub(super) values: Vec<Vec<f64>>,
    /// SHA-256 of the file.
    pub(super) sha256: String,
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

/// A table file whose header has been read.
#[derive(Debug)]
pub(super) enum Table {
    Csv(CsvTable),
    Parquet(ParquetTable),
}

impl Table {
    /// Opens a file by its extension: `.parquet` or `.pq`, else text.
    pub(super) fn open(path: &Path) -> Result<Self> {
        if !path.is_file() {
            return Err(Error::new(ErrorKind::Missing)
                .file(path)
                .found("no such file")
                .expected("the CSV or Parquet file of a run")
                .remedy(
                    "correct `file` in its [[run]]: it is relative to the TOML file, or to its data_folder, \
                     which the environment variable SLIDEWAY_DATA overrides",
                ));
        }
        match is_parquet(path) {
            true => ParquetTable::open(path).map(Self::Parquet),
            false => CsvTable::open(path).map(Self::Csv),
        }
    }

    /// The same of a file that may have a preamble above its header and a row of units below it.
    pub(super) fn open_bare(path: &Path) -> Result<Self> {
        match path.is_file() && !is_parquet(path) {
            true => CsvTable::open_bare(path).map(Self::Csv),
            false => Self::open(path),
        }
    }

    /// The units of the columns, where a row of the file states them.
    pub(super) fn units(&self) -> Option<&[String]> {
        match self {
            Self::Csv(table) => table.units(),
            Self::Parquet(_) => None,
        }
    }

    /// The column names, in file order.
    pub(super) fn names(&self) -> &[String] {
        match self {
            Self::Csv(table) => table.names(),
            Self::Parquet(table) => table.names(),
        }
    }

    /// Reads the columns at the given places.
    pub(super) fn columns(&self, wanted: &[usize]) -> Result<Columns> {
        match self {
            Self::Csv(table) => table.columns(wanted),
            Self::Parquet(table) => table.columns(wanted),
        }
    }
}

fn is_parquet(path: &Path) -> bool {
    let extension = path.extension().map(|text| text.to_string_lossy().to_lowercase());
    matches!(extension.as_deref(), Some("parquet" | "pq"))
}

/// The refusal of a file without a single row.
pub(super) fn no_rows() -> Error {
    Error::new(ErrorKind::TooLittleData)
        .found("a header without rows")
        .expected("at least one row of numbers")
        .remedy("take the run out of the recording, or record it again")
}
