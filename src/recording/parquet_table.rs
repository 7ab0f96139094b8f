//! Parquet tables, as pandas, Polars or this program write them.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::{DataType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::metadata::FileMetaData;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use rayon::prelude::*;

use super::file_columns::{Columns, no_rows};
use super::parquet_pages::{SoundPages, lies_inside};
use super::run::file_sha256;
use crate::error::guarded::guarded;
use crate::error::{Error, ErrorKind, Result, plain};

/// What is read here.
const FORMAT: &str = "Parquet file";
/// Samples of a column that are decoded at a time.
const BATCH: usize = 1 << 16;
/// Rows of a row group that is written, as other programs write them.
const GROUP_ROWS: usize = 1 << 20;

/// A Parquet file whose schema has been read.
#[derive(Debug)]
pub(super) struct ParquetTable {
    path: PathBuf,
    names: Vec<String>,
}

impl ParquetTable {
    pub(super) fn open(path: &Path) -> Result<Self> {
        let reader = guarded(FORMAT, || opened(path)).map_err(|error| error.file(path))?;
        let schema = reader.metadata().file_metadata().schema();
        let names = schema.get_fields().iter().map(|field| plain(field.name(), 200)).collect();
        Ok(Self { path: path.to_path_buf(), names })
    }

    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    pub(super) fn columns(&self, wanted: &[usize]) -> Result<Columns> {
        let read = || wanted.par_iter().map(|place| self.column(*place)).collect::<Result<Vec<_>>>();
        let (sha256, values) = rayon::join(|| file_sha256(&self.path), read);
        let values = values.and_then(|values| self.checked(values, wanted));
        let values = values.map_err(|error| error.file(&self.path))?;
        Ok(Columns { first_row: 1, values, sha256: sha256?, remarks: Vec::new() })
    }

    /// Columns of one length, with rows in them: each is stored by itself.
    fn checked(&self, values: Vec<Vec<f64>>, wanted: &[usize]) -> Result<Vec<Vec<f64>>> {
        let length = values.first().map_or(0, Vec::len);
        if length == 0 {
            return Err(no_rows());
        }
        let other = values.iter().zip(wanted).find(|(column, _)| column.len() != length);
        other.map_or(Ok(()), |(column, place)| {
            let found = format!("{} values in a column of a table of {length} rows", column.len());
            Err(unreadable(&found).key(&self.names[*place]))
        })?;
        Ok(values)
    }

    fn column(&self, place: usize) -> Result<Vec<f64>> {
        let name = self.names.get(place).map_or("", String::as_str);
        guarded(FORMAT, || self.values(place)).map_err(|error| error.key(name))
    }

    /// The values of a column that is one of numbers.
    fn values(&self, place: usize) -> Result<Vec<f64>> {
        // A file of its own: columns are read side by side, and clones of a file share their place in it.
        let reader = opened(&self.path)?;
        let about = reader.metadata().file_metadata();
        let field = about.schema().get_fields().get(place).ok_or_else(|| no_number("that is gone"))?;
        let is_signed = number(field, about)?;
        let mut columns = 0..about.schema_descr().num_columns();
        let leaf = columns.find(|leaf| about.schema_descr().get_column_root_idx(*leaf) == place);
        let leaf = leaf.ok_or_else(|| no_number("without values"))?;
        let mut column = Vec::new();
        let length = std::fs::metadata(&self.path).map_err(|error| Error::io(&self.path, &error))?.len();
        for group in 0..reader.num_row_groups() {
            let group = reader.get_row_group(group).map_err(|error| unreadable(&error))?;
            let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
            if !lies_inside(group.metadata().column(leaf), length) {
                return Err(unreadable(&"a column whose pages lie outside the file"));
            }
            let pages = group.get_column_page_reader(leaf).map_err(|error| unreadable(&error))?;
            let stored =
                get_column_reader(about.schema_descr().column(leaf), Box::new(SoundPages::of(pages)));
            let into = &mut column;
            match stored {
                ColumnReader::DoubleColumnReader(stored) => append(into, stored, rows, |value| *value),
                ColumnReader::FloatColumnReader(stored) => append(into, stored, rows, |v| f64::from(*v)),
                ColumnReader::Int32ColumnReader(stored) if is_signed => {
                    append(into, stored, rows, |value| f64::from(*value))
                }
                ColumnReader::Int32ColumnReader(stored) => {
                    append(into, stored, rows, |value| f64::from(value.cast_unsigned()))
                }
                // Counts beyond 2^53 would round; no encoder counts so far.
                ColumnReader::Int64ColumnReader(stored) if is_signed => {
                    append(into, stored, rows, |value| *value as f64)
                }
                ColumnReader::Int64ColumnReader(stored) => {
                    append(into, stored, rows, |value| value.cast_unsigned() as f64)
                }
                _ => Err(no_number("that the file does not state to be numbers")),
            }?;
        }
        Ok(column)
    }
}

fn opened(path: &Path) -> Result<SerializedFileReader<File>> {
    let file = File::open(path).map_err(|error| Error::io(path, &error))?;
    SerializedFileReader::new(file).map_err(|error| unreadable(&error))
}

/// Appends what a row group holds of a column.
fn append<T: DataType>(
    column: &mut Vec<f64>,
    mut stored: ColumnReaderImpl<T>,
    rows: usize,
    widened: impl Fn(&T::T) -> f64,
) -> Result<()> {
    let end = column.len() + rows;
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    while column.len() < end {
        levels.clear();
        values.clear();
        let most = BATCH.min(end - column.len());
        let (read, filled, _) = stored
            .read_records(most, Some(&mut levels), None, &mut values)
            .map_err(|error| unreadable(&error))?;
        let row = |index: usize| (column.len() + index + 1) as u64;
        if filled < read {
            let index = levels.iter().position(|level| *level == 0).unwrap_or(0);
            return Err(Error::new(ErrorKind::Missing)
                .row(row(index))
                .found(format!("null ({} in this part of the file)", read - filled))
                .expected("a finite number")
                .remedy("fill the gap, or split the run there"));
        }
        if read == 0 {
            let found = format!("{} values where the file states {end}", column.len());
            return Err(unreadable(&found));
        }
        let samples: Vec<f64> = values.iter().map(&widened).collect();
        if let Some(index) = samples.iter().position(|sample| !sample.is_finite()) {
            return Err(Error::new(ErrorKind::NotFinite)
                .row(row(index))
                .found(samples[index].to_string())
                .expected("a finite number")
                .remedy("repair the row, or split the run there and leave it out"));
        }
        column.extend(samples);
    }
    Ok(())
}

/// Whether the numbers of a column have signs.
///
/// # Errors
/// A column that holds no numbers: texts, stamps, lists.
fn number(field: &Type, about: &FileMetaData) -> Result<bool> {
    let told = field.get_basic_info();
    if !field.is_primitive() || told.repetition() == Repetition::REPEATED {
        return Err(no_number("of lists or structures"));
    }
    let meant = match told.logical_type_ref() {
        None => None,
        Some(LogicalType::Integer(integer)) => return Ok(integer.is_signed),
        Some(LogicalType::Float16) => Some("of floats with 16 bits"),
        Some(LogicalType::Timestamp(_)) => Some("of time stamps"),
        Some(LogicalType::Time(_) | LogicalType::Date) => Some("of dates or times of day"),
        Some(LogicalType::Decimal(_)) => Some("of decimals"),
        Some(LogicalType::Unknown) => Some("of nulls"),
        Some(_) => Some("of text or bytes"),
    };
    let stored = match (told.converted_type(), field.get_physical_type()) {
        (
            ConvertedType::UINT_8 | ConvertedType::UINT_16 | ConvertedType::UINT_32 | ConvertedType::UINT_64,
            _,
        ) => {
            return Ok(false);
        }
        (ConvertedType::INT_8 | ConvertedType::INT_16 | ConvertedType::INT_32 | ConvertedType::INT_64, _) => {
            None
        }
        (ConvertedType::TIMESTAMP_MILLIS | ConvertedType::TIMESTAMP_MICROS, _) | (_, Physical::INT96) => {
            Some("of time stamps")
        }
        (_, Physical::BOOLEAN) => Some("of true and false"),
        (_, Physical::BYTE_ARRAY | Physical::FIXED_LEN_BYTE_ARRAY) => Some("of text or bytes"),
        (ConvertedType::NONE, Physical::INT64) if is_duration(field.name(), about) => Some("of durations"),
        (ConvertedType::NONE, _) => None,
        _ => Some("of dates, times of day or decimals"),
    };
    meant.or(stored).map_or(Ok(true), |what| Err(no_number(what)))
}

/// Whether pandas says that a column of bare integers is one of durations.
fn is_duration(name: &str, about: &FileMetaData) -> bool {
    let told = about.key_value_metadata().into_iter().flatten().find(|told| told.key == "pandas");
    let told = told.and_then(|told| serde_json::from_str::<serde_json::Value>(told.value.as_ref()?).ok());
    let columns = told.as_ref().and_then(|told| told["columns"].as_array()).into_iter().flatten();
    let mut columns = columns.filter(|column| column["name"] == name);
    columns.any(|column| column["pandas_type"].as_str().is_some_and(|kind| kind.starts_with("timedelta")))
}

fn no_number(what: &str) -> Error {
    Error::new(ErrorKind::Syntax)
        .found(format!("a column {what}"))
        .expected("a column of numbers (floating point or integer)")
        .remedy("convert the column before writing the file; time as seconds, not as a time stamp")
}

/// Writes columns of 64-bit floats, without nulls.
pub(super) fn write(path: &Path, columns: &[(&str, &[f64])]) -> Result<()> {
    let file = File::create(path).map_err(|error| Error::io(path, &error))?;
    write_to(file, columns).map_err(|error| {
        Error::new(ErrorKind::Io)
            .file(path)
            .found(error.to_string())
            .expected("a Parquet file that can be written")
            .remedy("check the folder and the space on it")
    })
}

fn write_to(file: File, columns: &[(&str, &[f64])]) -> std::result::Result<(), ParquetError> {
    let field = |(name, _): &(&str, &[f64])| {
        let field = Type::primitive_type_builder(name, Physical::DOUBLE);
        field.with_repetition(Repetition::REQUIRED).build().map(Arc::new)
    };
    let fields = columns.iter().map(field).collect::<std::result::Result<_, _>>()?;
    let schema = Type::group_type_builder("schema").with_fields(fields).build()?;
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))?;
    let rows = columns.first().map_or(0, |(_, samples)| samples.len());
    for first in (0..rows).step_by(GROUP_ROWS) {
        let end = (first + GROUP_ROWS).min(rows);
        let mut group = writer.next_row_group()?;
        for (_, samples) in columns {
            let Some(mut column) = group.next_column()? else { break };
            column.typed::<DoubleType>().write_batch(&samples[first..end], None, None)?;
            column.close()?;
        }
        group.close()?;
    }
    writer.close().map(drop)
}

fn unreadable(error: &dyn std::fmt::Display) -> Error {
    Error::new(ErrorKind::Syntax)
        .found(error.to_string())
        .expected("a Parquet file, uncompressed or compressed with Snappy or Zstandard")
        .remedy("write it again, `to_parquet(…, compression=\"snappy\")` in pandas")
}
