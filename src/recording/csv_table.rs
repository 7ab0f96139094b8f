//! Delimited text as drives, oscilloscopes and spreadsheets write it.
//!
//! [`Dialect`] finds the layout: separator, lines before the header, a line of units, no header at all. Columns of several rates
//! have empty fields where they have no sample; blanks as separators are those of LinuxCNC's halsampler.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::dialect::{Dialect, decimal};
use super::file_columns::{Columns, no_rows};
use super::halscope;
use super::run::hex;
use super::series::{Series, together};
use crate::error::{Error, ErrorKind, Result, plain};

/// Columns with empty fields have so many values at least; fewer do not tell a rate.
const FEWEST_VALUES: usize = 10;
/// halsampler's note that samples were lost, in older versions without the mark.
const OVERRUN: [&[u8]; 2] = [b"!", b"overrun"];
/// Columns of a table at most.
const MOST_COLUMNS: usize = 4096;
/// Characters of a column's name at most.
const MOST_OF_NAME: usize = 200;

/// A text file in memory, its header understood.
#[derive(Debug)]
pub(super) struct CsvTable {
    path: PathBuf,
    bytes: Vec<u8>,
    dialect: Dialect,
    /// Where the table begins.
    start: usize,
    separator: u8,
    names: Vec<String>,
    /// SHA-256 of the file where these are not its bytes.
    sha256: Option<String>,
    remarks: Vec<String>,
}

impl CsvTable {
    /// A table of UTF-8 text, and the encoding that it was decoded from; the hash of the file where the text is not the file.
    pub(super) fn new(
        path: &Path,
        bytes: Vec<u8>,
        sha256: Option<String>,
        encoding: Option<&'static str>,
    ) -> Result<Self> {
        let mut remarks: Vec<String> =
            encoding.map(|name| format!("decoded from {name}")).into_iter().collect();
        let (bytes, sha256) = match halscope::table(&bytes) {
            None => (bytes, sha256),
            Some((text, remark)) => {
                remarks.push(remark);
                (text, Some(sha256.unwrap_or_else(|| hash_of(&bytes))))
            }
        };
        let dialect = Dialect::detect(&bytes);
        if dialect.preamble > 0 {
            remarks.push(format!("{} lines above the header left out", dialect.preamble));
        }
        let (start, separator) = (dialect.start, dialect.separator);
        let mut table = Self {
            path: path.to_path_buf(),
            bytes,
            start,
            separator,
            names: Vec::new(),
            dialect,
            sha256,
            remarks,
        };
        if separator == b' ' {
            table.join_blanks();
        }
        table.read_names()?;
        Ok(table)
    }

    /// Blanks become single tabs; lines that say that samples were lost go.
    fn join_blanks(&mut self) {
        let body = self.bytes.get(self.start..).unwrap_or_default();
        let mut tabbed = Vec::with_capacity(body.len());
        let mut overruns = 0;
        for line in body.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii) {
            if OVERRUN.iter().any(|mark| line.starts_with(mark)) {
                overruns += 1;
                continue;
            }
            let mut fields = line.split(u8::is_ascii_whitespace).filter(|field| !field.is_empty());
            tabbed.extend(fields.next().unwrap_or_default());
            fields.for_each(|field| {
                tabbed.push(b'\t');
                tabbed.extend(field);
            });
            tabbed.push(b'\n');
        }
        if overruns > 0 {
            self.remarks.push(format!("{overruns} overruns in the log: samples are lost there"));
        }
        self.sha256.get_or_insert_with(|| hash_of(&self.bytes));
        (self.bytes, self.start, self.separator) = (tabbed, 0, b'\t');
    }

    fn read_names(&mut self) -> Result<()> {
        let mut header = csv::ByteRecord::new();
        let read = self.reader().read_byte_record(&mut header);
        if !read.map_err(|error| syntax(&error))? {
            return Err(Error::new(ErrorKind::TooLittleData)
                .found("an empty file")
                .expected("a header line with column names, and rows of numbers")
                .remedy("take the run out of the recording, or record it again"));
        }
        if header.as_slice().contains(&0) {
            return Err(Error::new(ErrorKind::Syntax)
                .row(1)
                .found("a zero byte, as binary files have")
                .expected("a header line with column names")
                .remedy("name a CSV file, or a Parquet file with the ending .parquet"));
        }
        if header.len() > MOST_COLUMNS {
            return Err(Error::new(ErrorKind::OutOfRange)
                .row(1)
                .found(format!("{} columns", header.len()))
                .expected(format!("at most {MOST_COLUMNS}"))
                .remedy(
                    "export the columns of this axis only; a row stands for a sample, a column for a signal",
                ));
        }
        let name = |field: &[u8]| plain(String::from_utf8_lossy(field).trim(), MOST_OF_NAME);
        self.names = if self.dialect.has_header {
            header.iter().map(name).collect()
        } else {
            self.remarks.push("no header: columns are called column_1, column_2, …".to_owned());
            (1..=header.len()).map(|place| format!("column_{place}")).collect()
        };
        Ok(())
    }

    /// What the file was read as.
    pub(super) fn format(&self) -> String {
        format!("text, separated by {}", self.dialect.separator_word())
    }

    /// The units that a line below the header states, by column.
    pub(super) fn units(&self) -> &[Option<String>] {
        &self.dialect.units
    }

    fn reader(&self) -> csv::Reader<&[u8]> {
        let body = self.bytes.get(self.start..).unwrap_or_default();
        csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(self.separator)
            .from_reader(body)
    }

    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    /// Lines above the first row of numbers, from the header on.
    fn heading(&self) -> u64 {
        u64::from(self.dialect.has_header) + u64::from(!self.dialect.units.is_empty())
    }

    pub(super) fn columns(&self, wanted: &[usize], time: Option<usize>) -> Result<Columns> {
        let hash = || self.sha256.clone().unwrap_or_else(|| hash_of(&self.bytes));
        let (sha256, values) = rayon::join(hash, || self.values(wanted));
        let values = values.and_then(|values| self.on_one_clock(values, wanted, time));
        let (values, joined) = values.map_err(|error| error.file(&self.path))?;
        let remarks = self.remarks.iter().cloned().chain(joined).collect();
        Ok(Columns { first_row: self.heading() + 1, values, sha256, remarks })
    }

    /// Columns with empty fields, which are NaN here, at the instants of the slowest of them.
    ///
    /// # Errors
    /// An empty field where no time column tells what belongs there, or in a column with few values.
    fn on_one_clock(
        &self,
        values: Vec<Vec<f64>>,
        wanted: &[usize],
        time: Option<usize>,
    ) -> Result<(Vec<Vec<f64>>, Option<String>)> {
        let Some((holed, hole)) = values
            .iter()
            .enumerate()
            .find_map(|(place, column)| Some((place, column.iter().position(|value| value.is_nan())?)))
        else {
            return Ok((values, None));
        };
        let enough =
            |column: &Vec<f64>| column.iter().filter(|value| !value.is_nan()).count() >= FEWEST_VALUES;
        let clock = time.filter(|time| !values[*time].iter().any(|t| t.is_nan()));
        let Some(clock) = clock.filter(|_| values.iter().all(enough)) else {
            let name = self.names.get(wanted[holed]).cloned().unwrap_or_default();
            return Err(empty_field(self.heading() + 1 + hole as u64, name));
        };
        let series = |place: usize| {
            let pairs = values[clock].iter().zip(&values[place]).filter(|(_, value)| !value.is_nan());
            let (time_s, values) = pairs.unzip();
            Series { name: self.names.get(wanted[place]).cloned().unwrap_or_default(), time_s, values }
        };
        let others: Vec<Series> = (0..values.len()).filter(|place| *place != clock).map(series).collect();
        let joined = together(&others)?;
        let mut columns = joined.columns;
        columns.insert(clock, joined.time_s);
        Ok((columns, joined.remark))
    }

    fn values(&self, wanted: &[usize]) -> Result<Vec<Vec<f64>>> {
        let mut reader = self.reader();
        let mut record = csv::ByteRecord::new();
        for _ in 0..self.heading() {
            reader.read_byte_record(&mut record).map_err(|error| syntax(&error))?;
        }
        let row_bytes = record.as_slice().len().max(16);
        let guess = self.bytes.len() / row_bytes;
        let mut values: Vec<Vec<f64>> = wanted.iter().map(|_| Vec::with_capacity(guess)).collect();
        let mut row = self.heading();
        while reader.read_byte_record(&mut record).map_err(|error| syntax(&error))? {
            row += 1;
            self.check_shape(&record, row)?;
            for (column, &place) in values.iter_mut().zip(wanted) {
                let field = record.get(place).unwrap_or_default();
                match decimal(field, self.separator) {
                    None if field.trim_ascii().is_empty() => column.push(f64::NAN),
                    Some(value) if value.is_finite() => column.push(value),
                    read => return Err(self.not_a_number(&record, place, row, read)),
                }
            }
        }
        if row == self.heading() { Err(no_rows()) } else { Ok(values) }
    }

    /// Rows have as many fields as the header, and no empty line stands between them (it would shift the
    /// row numbers of every later message).
    fn check_shape(&self, record: &csv::ByteRecord, row: u64) -> Result<()> {
        if self.blank_line_before(record) {
            return Err(Error::new(ErrorKind::Syntax)
                .row(row)
                .found("an empty line")
                .expected("a row of numbers")
                .remedy("remove the empty line, or split the run there if it marks an interruption"));
        }
        if record.len() == self.names.len() {
            return Ok(());
        }
        Err(Error::new(ErrorKind::Syntax)
            .row(row)
            .found(format!("{} fields", record.len()))
            .expected(format!("{}, as many as the header has", self.names.len()))
            .remedy("repair the row; a cut-off last row can be deleted"))
    }

    fn blank_line_before(&self, record: &csv::ByteRecord) -> bool {
        let Some(position) = record.position() else { return false };
        let Ok(offset) = usize::try_from(position.byte()) else { return false };
        let at = |place: usize| self.bytes.get(self.start + place).copied();
        // The reader ends a record at '\r' and leaves the '\n' of the pair to the next one.
        let own_newline = at(offset) == Some(b'\n') && offset > 0 && at(offset - 1) == Some(b'\r');
        matches!(at(offset + usize::from(own_newline)), Some(b'\r' | b'\n'))
    }

    fn not_a_number(&self, record: &csv::ByteRecord, place: usize, row: u64, read: Option<f64>) -> Error {
        let field = String::from_utf8_lossy(record.get(place).unwrap_or_default()).trim().to_owned();
        let name = self.names.get(place).cloned().unwrap_or_default();
        let error = Error::new(if read.is_some() { ErrorKind::NotFinite } else { ErrorKind::Syntax });
        let error = error.row(row).key(name).expected("a finite number");
        let no_number = |field: &[u8]| !field.is_empty() && decimal(field, self.separator).is_none();
        if row == 2 && record.iter().all(no_number) {
            let fields: Vec<_> = record.iter().map(String::from_utf8_lossy).collect();
            return error
                .found(format!("a second header line ({})", fields.join(", ")))
                .expected("numbers below one header line")
                .remedy("delete that line, and state the units in [columns] of recording.toml");
        }
        let error = error.found(format!("`{field}`"));
        match read {
            None if field.contains(',') => error
                .remedy("thousands separators are not read; write plain numbers, with a point or a comma"),
            _ => error.remedy("repair the row, or split the run there and leave it out"),
        }
    }
}

fn hash_of(bytes: &[u8]) -> String {
    let mut hash = Sha256::new();
    hash.update(bytes);
    hex(hash)
}

fn empty_field(row: u64, name: String) -> Error {
    Error::new(ErrorKind::Missing)
        .row(row)
        .key(name)
        .found("an empty field")
        .expected("a finite number")
        .remedy("repair the row, or split the run there and leave it out")
}

fn syntax(error: &csv::Error) -> Error {
    Error::new(ErrorKind::Syntax)
        .found(error.to_string())
        .expected("delimited text")
        .remedy("export the file again as plain CSV")
}
