//! Where the header of a bare log stands: below a preamble, above a row of units.

use super::csv_table::{decimal, separator};
use crate::units::Unit;

/// Rows among which the first row of numbers is looked for.
const HEAD_ROWS: usize = 100;

/// The layout of a text file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    /// Where the header line begins.
    pub(super) start: usize,
    pub(super) separator: u8,
    /// The row below the header, where it holds units.
    pub(super) units: Option<Vec<String>>,
}

impl Layout {
    /// The layout of a file, from `start` on: the first row of numbers, a row of units above it if there is one, and the header
    /// above that. None where no row of numbers stands below a header.
    pub(super) fn of(bytes: &[u8], start: usize) -> Option<Self> {
        let mut lines: Vec<(usize, &[u8])> = Vec::new();
        let mut at = start;
        for line in bytes.get(start..)?.split_inclusive(|byte| *byte == b'\n').take(HEAD_ROWS) {
            let text = line.trim_ascii_end();
            if !text.trim_ascii().is_empty() {
                lines.push((at, text));
            }
            at += line.len();
        }
        let first = (1..lines.len()).find(|&row| {
            let separator = separator(lines[row - 1].1);
            let fields = fields(lines[row].1, separator);
            let width = fields.len() == self::fields(lines[row - 1].1, separator).len();
            width && fields.iter().all(|field| decimal(field.as_bytes(), separator).is_some())
        })?;
        let separator = separator(lines[first - 1].1);
        let above = fields(lines[first - 1].1, separator);
        let header = (first >= 2).then(|| fields(lines[first - 2].1, separator));
        let has_units = header.is_some_and(|header| header.len() == above.len()) && is_units(&above);
        let start = lines[if has_units { first - 2 } else { first - 1 }].0;
        Some(Self { start, separator, units: has_units.then_some(above) })
    }
}

/// Whether every field is a unit or empty, and one is a unit.
fn is_units(fields: &[String]) -> bool {
    let is_unit = |field: &String| Unit::parse(field).is_ok();
    let is_empty = |field: &String| ["", "-", "[]", "[-]"].contains(&field.as_str());
    fields.iter().all(|field| is_empty(field) || is_unit(field)) && fields.iter().any(is_unit)
}

fn fields(line: &[u8], separator: u8) -> Vec<String> {
    let text = String::from_utf8_lossy(line);
    text.split(char::from(separator)).map(|field| field.trim().trim_matches('"').trim().to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_preamble_and_units_row_are_told_from_the_header() {
        let text = "sep=;\nDrive;X1\n\nt;pos\n[ms];[mm]\n0;1,5\n1;2,5\n";
        let layout = Layout::of(text.as_bytes(), 0).unwrap();
        assert!(text[layout.start..].starts_with("t;pos"));
        assert_eq!((layout.separator, layout.units), (b';', Some(vec!["[ms]".into(), "[mm]".into()])));
        let plain = Layout::of(b"time_s,position_m\n0,1\n", 0).unwrap();
        assert_eq!((plain.start, plain.separator, plain.units), (0, b',', None));
        assert_eq!(Layout::of(b"a,b\nx,y\n", 0), None);
    }
}
