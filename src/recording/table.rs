//! A table file, text, Parquet or one of other formats: column names first, then the columns that are wanted.

use std::path::Path;

use super::csv_table::CsvTable;
use super::file_columns::Columns;
use super::loaded_table::LoadedTable;
use super::parquet_table::ParquetTable;
use super::run::hex;
use super::{array_file, decode, mcap_table, scope_table, tia_trace, trace_xml};
use sha2::{Digest, Sha256};

use crate::error::{Error, ErrorKind, Result};

/// Endings of table files, of which a folder of logs is taken together.
pub(super) const ENDINGS: [&str; 13] =
    ["csv", "tsv", "txt", "asc", "gz", "parquet", "pq", "mcap", "mat", "h5", "hdf5", "xml", "ttrecx"];

/// What is in a table file before anything is mapped.
#[derive(Debug, Clone, PartialEq)]
pub struct TableLayout {
    /// What the file was read as, in words.
    pub format: String,
    /// The columns, each with the unit that the file states for it.
    pub columns: Vec<(String, Option<String>)>,
}

impl TableLayout {
    /// Looks at a file: text in any layout that is known, Parquet, MCAP, MAT, HDF5 or a recording of TIA Portal's trace.
    ///
    /// # Errors
    /// A file that cannot be opened, or whose header is not understood.
    pub fn of(path: impl AsRef<Path>) -> Result<Self> {
        let table = Table::open(path.as_ref())?;
        let unit = |place: usize| table.units().get(place).cloned().flatten();
        let columns = table.names().iter().enumerate().map(|(place, name)| (name.clone(), unit(place)));
        Ok(Self { format: table.format(), columns: columns.collect() })
    }
}

/// A table file whose header has been read.
#[derive(Debug)]
pub(super) enum Table {
    Csv(CsvTable),
    Parquet(ParquetTable),
    Loaded(LoadedTable),
}

impl Table {
    /// Opens a file: `.parquet` and `.pq` by their extension, others by their first bytes.
    pub(super) fn open(path: &Path) -> Result<Self> {
        if !path.is_file() {
            return Err(Error::new(ErrorKind::Missing)
                .file(path)
                .found(if path.is_dir() {
                    "a folder"
                } else if path.exists() {
                    "a device or pipe"
                } else {
                    "no such file"
                })
                .expected("the CSV or Parquet file of a run")
                .remedy(
                    "correct `file` in its [[run]]: it is relative to the TOML file, or to its data_folder, \
                     which the environment variable SLIDEWAY_DATA overrides",
                ));
        }
        let extension = path.extension().map(|text| text.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("parquet" | "pq") => ParquetTable::open(path).map(Self::Parquet),
            _ => text(path).map_err(|error| error.file(path)),
        }
    }

    /// What the file was read as.
    pub(super) fn format(&self) -> String {
        match self {
            Self::Csv(table) => table.format(),
            Self::Parquet(_) => "Parquet".to_owned(),
            Self::Loaded(table) => table.format().to_owned(),
        }
    }

    /// The units that the file states, by column; shorter than the names where it states none for the last ones.
    pub(super) fn units(&self) -> &[Option<String>] {
        match self {
            Self::Csv(table) => table.units(),
            Self::Parquet(_) => &[],
            Self::Loaded(table) => table.units(),
        }
    }

    /// The column names, in file order.
    pub(super) fn names(&self) -> &[String] {
        match self {
            Self::Csv(table) => table.names(),
            Self::Parquet(table) => table.names(),
            Self::Loaded(table) => table.names(),
        }
    }

    /// Reads the columns at the given places, of which one may be the time.
    pub(super) fn columns(&self, wanted: &[usize], time: Option<usize>) -> Result<Columns> {
        match self {
            Self::Csv(table) => table.columns(wanted, time),
            Self::Parquet(table) => table.columns(wanted),
            Self::Loaded(table) => table.columns(wanted),
        }
    }
}

/// What a file is, its first bytes tell: MCAP, a ZIP archive, MAT, HDF5, else text in any encoding, packed or not: a trace, a scope, CSV.
fn text(path: &Path) -> Result<Table> {
    let bytes = std::fs::read(path).map_err(|error| Error::io(path, &error))?;
    let sha256 = |bytes: &[u8]| {
        let mut hash = Sha256::new();
        hash.update(bytes);
        hex(hash)
    };
    // Plain text is hashed while it is read.
    let plain = std::str::from_utf8(&bytes).is_ok();
    let hash = (!plain).then(|| sha256(&bytes));
    if bytes.starts_with(mcap_table::MAGIC) {
        return mcap_table::read(path, &bytes, sha256(&bytes)).map(Table::Loaded);
    }
    if bytes.starts_with(tia_trace::MAGIC) {
        return tia_trace::read(path, &bytes, sha256(&bytes)).map(Table::Loaded);
    }
    if array_file::is_array_file(&bytes) {
        let hash = sha256(&bytes);
        return array_file::read(path, bytes, hash).map(Table::Loaded);
    }
    let (text, encoding) = decode::utf8(decode::unpacked(bytes)?);
    if scope_table::is_scope(&text) {
        let hash = hash.unwrap_or_else(|| sha256(&text));
        return scope_table::read(path, &text, hash).map(Table::Loaded);
    }
    if trace_xml::is_trace(&text) {
        let hash = hash.unwrap_or_else(|| sha256(&text));
        return trace_xml::read(path, &text, hash).map(Table::Loaded);
    }
    CsvTable::new(path, text, hash, encoding).map(Table::Csv)
}

/// Whether a file has the ending of a table.
pub(super) fn is_table(path: &Path) -> bool {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| ENDINGS.contains(&ending.as_str()))
}
