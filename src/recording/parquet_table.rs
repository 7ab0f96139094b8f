//! Parquet tables, as pandas, Polars or this program write them.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{
    Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, UInt8Type, UInt16Type, UInt32Type,
    UInt64Type,
};
use arrow_array::{Array, ArrayRef, Float64Array, RecordBatch};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::arrow_reader::{ArrowReaderMetadata, ParquetRecordBatchReaderBuilder};
use parquet::arrow::{ArrowWriter, ProjectionMask};
use parquet::basic::Compression;
use parquet::file::properties::WriterProperties;

use super::run::file_sha256;
use super::table::{Columns, no_rows};
use crate::error::{Error, ErrorKind, Result, plain};

/// A Parquet file whose schema has been read.
#[derive(Debug)]
pub(super) struct ParquetTable {
    path: PathBuf,
    metadata: ArrowReaderMetadata,
    names: Vec<String>,
}

impl ParquetTable {
    pub(super) fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(|error| Error::io(path, &error))?;
        let metadata = ArrowReaderMetadata::load(&file, Default::default())
            .map_err(|error| unreadable(&error).file(path))?;
        let names = metadata.schema().fields().iter().map(|field| plain(field.name(), 200)).collect();
        Ok(Self { path: path.to_path_buf(), metadata, names })
    }

    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    pub(super) fn columns(&self, wanted: &[usize]) -> Result<Columns> {
        let (sha256, values) = rayon::join(|| file_sha256(&self.path), || self.values(wanted));
        let values = values.map_err(|error| error.file(&self.path))?;
        Ok(Columns { first_row: 1, values, sha256: sha256?, remarks: Vec::new() })
    }

    fn values(&self, wanted: &[usize]) -> Result<Vec<Vec<f64>>> {
        let file = File::open(&self.path).map_err(|error| Error::io(&self.path, &error))?;
        let builder = ParquetRecordBatchReaderBuilder::new_with_metadata(file, self.metadata.clone());
        let mask = ProjectionMask::roots(builder.parquet_schema(), wanted.iter().copied());
        let reader = builder.with_projection(mask).build().map_err(|error| unreadable(&error))?;
        let mut values: Vec<Vec<f64>> = vec![Vec::new(); wanted.len()];
        for batch in reader {
            let batch = batch.map_err(|error| unreadable(&error))?;
            for (column, &place) in values.iter_mut().zip(wanted) {
                let name = self.names.get(place).map_or("", String::as_str);
                append(column, &batch, name).map_err(|error| error.key(name))?;
            }
        }
        if values.first().is_none_or(Vec::is_empty) { Err(no_rows()) } else { Ok(values) }
    }
}

fn append(column: &mut Vec<f64>, batch: &RecordBatch, name: &str) -> Result<()> {
    let Some(array) = batch.column_by_name(name) else { return Ok(()) };
    let row = |index: usize| (column.len() + index + 1) as u64;
    if let Some(index) = (0..array.len()).find(|index| array.null_count() > 0 && array.is_null(*index)) {
        return Err(Error::new(ErrorKind::Missing)
            .row(row(index))
            .found(format!("null ({} in this part of the file)", array.null_count()))
            .expected("a finite number")
            .remedy("fill the gap, or split the run there"));
    }
    let samples = numbers(array)?;
    if let Some(index) = samples.iter().position(|sample| !sample.is_finite()) {
        return Err(Error::new(ErrorKind::NotFinite)
            .row(row(index))
            .found(samples[index].to_string())
            .expected("a finite number")
            .remedy("repair the row, or split the run there and leave it out"));
    }
    column.extend(samples);
    Ok(())
}

fn numbers(array: &ArrayRef) -> Result<Vec<f64>> {
    macro_rules! widened {
        ($kind:ty) => {
            array.as_primitive::<$kind>().values().iter().map(|value| f64::from(*value)).collect()
        };
    }
    Ok(match array.data_type() {
        DataType::Float64 => array.as_primitive::<Float64Type>().values().to_vec(),
        DataType::Float32 => widened!(Float32Type),
        DataType::Int8 => widened!(Int8Type),
        DataType::Int16 => widened!(Int16Type),
        DataType::Int32 => widened!(Int32Type),
        DataType::UInt8 => widened!(UInt8Type),
        DataType::UInt16 => widened!(UInt16Type),
        DataType::UInt32 => widened!(UInt32Type),
        // Counts beyond 2^53 would round; no encoder counts so far.
        DataType::Int64 => {
            array.as_primitive::<Int64Type>().values().iter().map(|value| *value as f64).collect()
        }
        DataType::UInt64 => {
            array.as_primitive::<UInt64Type>().values().iter().map(|value| *value as f64).collect()
        }
        other => {
            return Err(Error::new(ErrorKind::Syntax)
                .found(format!("a column of type {other}"))
                .expected("a column of numbers (floating point or integer)")
                .remedy("convert the column before writing the file; time as seconds, not as a time stamp"));
        }
    })
}

/// Writes columns of 64-bit floats, without nulls.
pub(super) fn write(path: &Path, columns: Vec<(&str, Vec<f64>)>) -> Result<()> {
    let fields: Vec<_> =
        columns.iter().map(|(name, _)| Field::new(*name, DataType::Float64, false)).collect();
    let schema = Arc::new(Schema::new(fields));
    let arrays: Vec<ArrayRef> =
        columns.into_iter().map(|(_, samples)| Arc::new(Float64Array::from(samples)) as ArrayRef).collect();
    let failed = |text: String| {
        Error::new(ErrorKind::Io)
            .file(path)
            .found(text)
            .expected("a Parquet file that can be written")
            .remedy("check the folder and the space on it")
    };
    let file = File::create(path).map_err(|error| Error::io(path, &error))?;
    let batch =
        RecordBatch::try_new(Arc::clone(&schema), arrays).map_err(|error| failed(error.to_string()))?;
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer =
        ArrowWriter::try_new(file, schema, Some(properties)).map_err(|error| failed(error.to_string()))?;
    writer.write(&batch).map_err(|error| failed(error.to_string()))?;
    writer.close().map_err(|error| failed(error.to_string()))?;
    Ok(())
}

fn unreadable(error: &dyn std::fmt::Display) -> Error {
    Error::new(ErrorKind::Syntax)
        .found(error.to_string())
        .expected("a Parquet file, uncompressed or compressed with Snappy or Zstandard")
        .remedy("write it again, `to_parquet(…, compression=\"snappy\")` in pandas")
}
