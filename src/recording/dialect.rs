//! How a text file sets out its table: separator, decimal sign, what stands before the numbers.

use crate::units::Unit;

const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";
/// Lines before the header that are looked through.
const MOST_PREAMBLE: usize = 80;
/// Unit fields that state none.
const NO_UNIT: [&str; 5] = ["", "-", "1", "none", "(none)"];

/// The layout of a table of text, as it was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Dialect {
    /// Sign between two fields; a blank stands for any number of blanks.
    pub separator: u8,
    /// Where the header begins, or the numbers where there is none, in bytes.
    pub start: usize,
    /// Lines before that which are neither empty nor comments.
    pub preamble: usize,
    /// Whether a line with the names of the columns stands above the numbers.
    pub has_header: bool,
    /// The units in a line below the header, by column.
    pub units: Vec<Option<String>>,
}

impl Dialect {
    /// Finds the layout of a text. Where nothing tells another one, the first line that is neither empty nor a comment (`#`) is
    /// the header.
    pub fn detect(text: &[u8]) -> Self {
        let lines = lines(text);
        let told = lines.first().and_then(|(_, line)| stated_separator(line));
        let lines = &lines[usize::from(told.is_some()).min(lines.len())..];
        let candidate = |place: usize| {
            let line = lines.get(place)?.1;
            let separator = told.unwrap_or_else(|| separator(line));
            let (fields, below) = (fields(line, separator), lines.get(place + 1)?.1);
            let matches = |other: &[u8]| {
                let other = self::fields(other, separator);
                other.len() == fields.len() && numbers(&other, separator)
            };
            let two_below = lines.get(place + 2).map(|(_, line)| *line);
            let is_header = !numbers(&fields, separator) && fields.iter().any(|field| !field.is_empty());
            let begins = matches(below) && (is_header || numbers(&fields, separator));
            let with_units = || is_header && is_units(below, separator) && two_below.is_some_and(matches);
            // A line above with as many fields is a header or a row of the same table, not a preamble.
            let stands_alone = || {
                lines[..place].iter().all(|(_, above)| self::fields(above, separator).len() != fields.len())
            };
            let fits = fields.len() > 1 && (begins || with_units()) && stands_alone();
            fits.then_some((place, separator))
        };
        let (place, separator) = (0..lines.len()).find_map(candidate).unwrap_or_else(|| {
            (0, told.unwrap_or_else(|| lines.first().map_or(b',', |(_, line)| self::separator(line))))
        });
        let Some((start, line)) = lines.get(place) else {
            return Self { separator, start: text.len(), preamble: 0, has_header: true, units: Vec::new() };
        };
        let fields = fields(line, separator);
        let has_header = fields.is_empty() || !numbers(&fields, separator);
        let below = lines.get(place + 1).map(|(_, line)| *line).filter(|_| has_header);
        let units = below
            .filter(|line| is_units(line, separator))
            .map(|line| self::fields(line, separator).iter().map(|field| unit(field)).collect());
        Self { separator, start: *start, preamble: place, has_header, units: units.unwrap_or_default() }
    }

    /// The sign between two fields in words.
    pub fn separator_word(&self) -> &'static str {
        match self.separator {
            b';' => "semicolon",
            b'\t' => "tab",
            b' ' => "blanks",
            _ => "comma",
        }
    }
}

/// The first lines that are neither empty nor comments, each with the place where it begins.
fn lines(text: &[u8]) -> Vec<(usize, &[u8])> {
    let mut start = if text.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 };
    let mut found = Vec::new();
    while start < text.len() && found.len() < MOST_PREAMBLE {
        let rest = &text[start..];
        let end = rest.iter().position(|byte| *byte == b'\n').map_or(rest.len(), |at| at + 1);
        let line = rest[..end].trim_ascii_end();
        if !(line.trim_ascii().is_empty() || line.trim_ascii_start().starts_with(b"#")) {
            found.push((start, line));
        }
        start += end;
    }
    found
}

/// The separator that a first line `sep=;` states, as Excel reads it.
fn stated_separator(line: &[u8]) -> Option<u8> {
    let line = line.trim_ascii();
    let line = line.strip_prefix(b"\"").and_then(|line| line.strip_suffix(b"\"")).unwrap_or(line);
    match line.to_ascii_lowercase().strip_prefix(b"sep=") {
        Some([separator]) => Some(*separator),
        // A tab is gone with the blanks at the end of the line.
        Some([]) => Some(b'\t'),
        _ => None,
    }
}

/// The most frequent of semicolon, tab and comma outside quotes; blanks where there is none of them.
fn separator(line: &[u8]) -> u8 {
    let mut counts = [(b';', 0), (b'\t', 0), (b',', 0)];
    let mut quoted = false;
    for byte in line {
        quoted ^= *byte == b'"';
        for (separator, count) in &mut counts {
            *count += usize::from(!quoted && byte == separator);
        }
    }
    let most = counts.iter().map(|(_, count)| *count).max().unwrap_or(0);
    let blanks = line.split(|byte| *byte == b' ').filter(|part| !part.is_empty());
    let all_numbers = || blanks.clone().all(|part| decimal(part, b' ').is_some());
    let listed = counts.iter().find(|(_, count)| *count == most && most > 0).map(|(separator, _)| *separator);
    match listed {
        // A decimal comma between blanks: `0,1 0,2`.
        Some(b',') if blanks.clone().count() > 1 && all_numbers() => b' ',
        Some(separator) => separator,
        None if blanks.clone().count() > 1 && all_numbers() => b' ',
        None => b',',
    }
}

/// The fields of a line, quotes taken off.
fn fields(line: &[u8], separator: u8) -> Vec<String> {
    let field = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().trim_matches('"').trim().to_owned();
    if separator == b' ' {
        return line.split(u8::is_ascii_whitespace).filter(|part| !part.is_empty()).map(field).collect();
    }
    let mut quoted = false;
    let parts = line.split(|byte| {
        quoted ^= *byte == b'"';
        !quoted && *byte == separator
    });
    parts.map(field).collect()
}

/// Whether every field is a number or empty, and one is a number.
fn numbers(fields: &[String], separator: u8) -> bool {
    let number = |field: &String| decimal(field.as_bytes(), separator).is_some();
    fields.iter().all(|field| field.is_empty() || number(field)) && fields.iter().any(number)
}

/// Whether a line holds units: no number, and a unit that is known.
fn is_units(line: &[u8], separator: u8) -> bool {
    let fields = fields(line, separator);
    let is_known = |field: &String| Unit::parse(field).is_ok() && field != "-" && field != "1";
    !fields.iter().any(|field| decimal(field.as_bytes(), separator).is_some() && field != "1")
        && fields.iter().any(is_known)
        && fields.iter().all(|field| field.chars().count() < 12)
}

/// What a field of a line of units states.
pub(super) fn unit(field: &str) -> Option<String> {
    let field = field.trim();
    let bare = field.trim_matches(|sign| "[]".contains(sign)).trim();
    (!NO_UNIT.contains(&bare.to_lowercase().as_str())).then(|| bare.to_owned())
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
