//! Delimited text as drives, oscilloscopes and spreadsheets write it.
//!
//! Separator comma, semicolon or tab (the most frequent in the header line); decimal comma where the separator
//! is not a comma; UTF-8 byte-order mark, quoted fields, and `#` lines before the header.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::dialect::Layout;
use super::run::hex;
use super::table::{Columns, no_rows};
use crate::error::{Error, ErrorKind, Result};

const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// A text file in memory, its header understood.
#[derive(Debug)]
pub(super) struct CsvTable {
    path: PathBuf,
    bytes: Vec<u8>,
    /// Where the header line starts.
    start: usize,
    separator: u8,
    names: Vec<String>,
    /// The row below the header, where it holds units.
    units: Option<Vec<String>>,
}

impl CsvTable {
    pub(super) fn open(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|error| Error::io(path, &error))?;
        Self::new(path, bytes).map_err(|error| error.file(path))
    }

    /// A file that may have a preamble above its header and a row of units below it.
    pub(super) fn open_bare(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|error| Error::io(path, &error))?;
        let layout = header_start(&bytes).map(|start| Layout::of(&bytes, start));
        match layout.map_err(|error| error.file(path))? {
            Some(layout) => Self::laid_out(path, bytes, layout).map_err(|error| error.file(path)),
            None => Self::new(path, bytes).map_err(|error| error.file(path)),
        }
    }

    fn new(path: &Path, bytes: Vec<u8>) -> Result<Self> {
        let start = header_start(&bytes)?;
        let body = bytes.get(start..).unwrap_or_default();
        let line = body.split(|byte| *byte == b'\n').next().unwrap_or_default();
        let separator = separator(line);
        Self::laid_out(path, bytes, Layout { start, separator, units: None })
    }

    fn laid_out(path: &Path, bytes: Vec<u8>, layout: Layout) -> Result<Self> {
        let Layout { start, separator, units } = layout;
        let mut table = Self { path: path.to_path_buf(), start, separator, names: Vec::new(), units, bytes };
        let mut header = csv::ByteRecord::new();
        let read = table.reader().read_byte_record(&mut header);
        if !read.map_err(|error| syntax(&error))? {
            return Err(Error::new(ErrorKind::TooLittleData)
                .found("an empty file")
                .expected("a header line with column names, and rows of numbers")
                .remedy("take the run out of the recording, or record it again"));
        }
        table.names = header.iter().map(|field| String::from_utf8_lossy(field).trim().to_owned()).collect();
        let is_number = |name: &String| decimal(name.as_bytes(), table.separator).is_some();
        if table.names.iter().all(is_number) {
            return Err(Error::new(ErrorKind::Syntax)
                .row(1)
                .found(format!("the numbers {}", table.names.join(", ")))
                .expected("a header line with column names")
                .remedy("put a line with the column names above the numbers"));
        }
        Ok(table)
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

    pub(super) fn units(&self) -> Option<&[String]> {
        self.units.as_deref()
    }

    pub(super) fn columns(&self, wanted: &[usize]) -> Result<Columns> {
        let hash = || {
            let mut hash = Sha256::new();
            hash.update(&self.bytes);
            hex(hash)
        };
        let (sha256, values) = rayon::join(hash, || self.values(wanted));
        let values = values.map_err(|error| error.file(&self.path))?;
        Ok(Columns { first_row: 2 + u64::from(self.units.is_some()), values, sha256 })
    }

    fn values(&self, wanted: &[usize]) -> Result<Vec<Vec<f64>>> {
        let mut reader = self.reader();
        let mut record = csv::ByteRecord::new();
        reader.read_byte_record(&mut record).map_err(|error| syntax(&error))?;
        let row_bytes = record.as_slice().len().max(16);
        let guess = self.bytes.len() / row_bytes;
        let mut values: Vec<Vec<f64>> = wanted.iter().map(|_| Vec::with_capacity(guess)).collect();
        let mut row = 1;
        if self.units.is_some() {
            row += 1;
            reader.read_byte_record(&mut record).map_err(|error| syntax(&error))?;
        }
        let head = row;
        while reader.read_byte_record(&mut record).map_err(|error| syntax(&error))? {
            row += 1;
            self.check_shape(&record, row)?;
            for (column, &place) in values.iter_mut().zip(wanted) {
                let field = record.get(place).unwrap_or_default();
                match decimal(field, self.separator) {
                    Some(value) if value.is_finite() => column.push(value),
                    read => return Err(self.not_a_number(&record, place, row, read)),
                }
            }
        }
        if row == head { Err(no_rows()) } else { Ok(values) }
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
        let error = Error::new(match (read, field.is_empty()) {
            (Some(_), _) => ErrorKind::NotFinite,
            (None, true) => ErrorKind::Missing,
            (None, false) => ErrorKind::Syntax,
        });
        let error = error.row(row).key(name).expected("a finite number");
        let no_number = |field: &[u8]| !field.is_empty() && decimal(field, self.separator).is_none();
        if row == 2 && record.iter().all(no_number) {
            let fields: Vec<_> = record.iter().map(String::from_utf8_lossy).collect();
            return error
                .found(format!("a second header line ({})", fields.join(", ")))
                .expected("numbers below one header line")
                .remedy("delete that line, and state the units in [columns] of recording.toml");
        }
        let error =
            if field.is_empty() { error.found("an empty field") } else { error.found(format!("`{field}`")) };
        match read {
            None if field.contains(',') => error
                .remedy("thousands separators are not read; write plain numbers, with a point or a comma"),
            _ => error.remedy("repair the row, or split the run there and leave it out"),
        }
    }
}

/// Skips a byte-order mark and the comment and empty lines before the header.
fn header_start(bytes: &[u8]) -> Result<usize> {
    if bytes.starts_with(b"\xFF\xFE") || bytes.starts_with(b"\xFE\xFF") {
        return Err(Error::new(ErrorKind::Syntax)
            .found("UTF-16 text")
            .expected("UTF-8 or ASCII")
            .remedy("save the file as UTF-8"));
    }
    let mut start = if bytes.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 };
    loop {
        let rest = bytes.get(start..).unwrap_or_default();
        let end = rest.iter().position(|byte| *byte == b'\n').map_or(rest.len(), |at| at + 1);
        let line = rest.get(..end).unwrap_or_default().trim_ascii();
        if rest.is_empty() || !(line.is_empty() || line.starts_with(b"#")) {
            return Ok(start);
        }
        start += end;
    }
}

/// The most frequent of semicolon, tab and comma outside quotes.
pub(super) fn separator(header: &[u8]) -> u8 {
    let mut counts = [(b';', 0), (b'\t', 0), (b',', 0)];
    let mut quoted = false;
    for byte in header {
        quoted ^= *byte == b'"';
        for (separator, count) in &mut counts {
            *count += usize::from(!quoted && byte == separator);
        }
    }
    let most = counts.iter().map(|(_, count)| *count).max().unwrap_or(0);
    counts.iter().find(|(_, count)| *count == most && most > 0).map_or(b',', |(separator, _)| *separator)
}

/// A number; with a decimal comma where the separator is another sign.
pub(super) fn decimal(field: &[u8], separator: u8) -> Option<f64> {
    const LONGEST: usize = 64;
    let field = field.trim_ascii();
    if separator != b',' && field.contains(&b',') && field.len() <= LONGEST {
        let mut pointed = [0_u8; LONGEST];
        for (to, from) in pointed.iter_mut().zip(field) {
            *to = if *from == b',' { b'.' } else { *from };
        }
        return std::str::from_utf8(pointed.get(..field.len())?).ok()?.parse().ok();
    }
    std::str::from_utf8(field).ok()?.parse().ok()
}

fn syntax(error: &csv::Error) -> Error {
    Error::new(ErrorKind::Syntax)
        .found(error.to_string())
        .expected("delimited text")
        .remedy("export the file again as plain CSV")
}
