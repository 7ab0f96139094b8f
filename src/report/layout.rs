//! Paragraphs, tables, bars and colour of a report on a screen.

use super::Style;
use super::grid::grid;
use super::wrap::{columns, wrap};

/// Indent of everything below a heading.
pub(super) const INDENT: &str = "  ";

/// A part of the text that may be coloured.
#[derive(Debug, Clone, Copy)]
pub(super) enum Ink {
    Heading,
    Good,
    Bad,
    Warning,
    Faint,
}

impl Style {
    /// The text in its colour.
    pub(super) fn ink(self, ink: Ink, text: &str) -> String {
        let code = match ink {
            Ink::Heading => "1",
            Ink::Good => "1;32",
            Ink::Bad => "1;31",
            Ink::Warning => "33",
            Ink::Faint => "2",
        };
        if self.colour && !text.is_empty() {
            format!("\u{1b}[{code}m{text}\u{1b}[0m")
        } else {
            text.to_owned()
        }
    }

    /// A heading and what it holds, in capitals and in a faint remark.
    pub(super) fn heading(self, title: &str, remark: &str) -> String {
        let remark =
            if remark.is_empty() { String::new() } else { format!("  {}", self.ink(Ink::Faint, remark)) };
        format!("\n{}{remark}\n", self.ink(Ink::Heading, title))
    }
}

/// A label and a text behind it, further lines below the text.
pub(super) fn labelled(label: &str, label_width: usize, text: &str, style: Style) -> String {
    let begin = columns(INDENT) + label_width + 2;
    let mut out = String::new();
    for (row, line) in wrap(text, style.width.saturating_sub(begin)).iter().enumerate() {
        let label = if row == 0 { label } else { "" };
        out += &format!("{INDENT}{label:<label_width$}  {line}\n");
    }
    out
}

/// A text in indented lines.
pub(super) fn paragraph(text: &str, style: Style) -> String {
    wrap(text, style.width - columns(INDENT)).iter().map(|line| format!("{INDENT}{line}\n")).collect()
}

/// Where a column's cells stand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Align {
    Left,
    Right,
}

/// Columns that line up under their heads; the widest column to the left gives way where a line is too long.
#[derive(Debug)]
pub(super) struct Table {
    rows: Vec<Vec<String>>,
    align: Vec<Align>,
}

impl Table {
    /// A table with these column heads.
    pub(super) fn new(heads: &[(&str, Align)]) -> Self {
        Self {
            rows: vec![heads.iter().map(|(head, _)| (*head).to_owned()).collect()],
            align: heads.iter().map(|(_, align)| *align).collect(),
        }
    }

    /// Appends a row.
    pub(super) fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    fn widths(&self) -> Vec<usize> {
        let cell = |row: &Vec<String>, column: usize| row.get(column).map_or(0, |text| columns(text));
        (0..self.align.len())
            .map(|column| self.rows.iter().map(|row| cell(row, column)).max().unwrap_or_default())
            .collect()
    }

    /// Columns that the table takes on a screen.
    pub(super) fn width(&self) -> usize {
        let widths = self.widths();
        widths.iter().sum::<usize>() + 2 * widths.len().saturating_sub(1) + columns(INDENT)
    }

    /// The table in at most the style's width, its heads faint.
    pub(super) fn text(&self, style: Style) -> String {
        let is_left: Vec<bool> = self.align.iter().map(|align| *align == Align::Left).collect();
        let room = style.width.saturating_sub(columns(INDENT));
        let lines = grid(&self.rows, &is_left, room).into_iter().map(|(is_head, line)| {
            let line = if is_head { style.ink(Ink::Faint, &line) } else { line };
            format!("{INDENT}{line}\n")
        });
        lines.collect()
    }
}

/// A bar for a share of 1, in eighths of a column.
pub(super) fn bar(share: f64, width: usize) -> String {
    const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
    if !share.is_finite() {
        return String::new();
    }
    let eighths = (share.clamp(0.0, 1.0) * 8.0 * width as f64).round() as usize;
    format!("{}{}", "█".repeat(eighths / 8), EIGHTHS[eighths % 8])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_bars_are_proportional() {
        assert_eq!(
            (bar(0.5, 10), bar(0.0, 10), bar(1.0, 3)),
            ("█████".to_owned(), String::new(), "███".to_owned())
        );
        assert_eq!(
            (bar(2.0, 2), bar(f64::NAN, 2), bar(0.0625, 2)),
            ("██".to_owned(), String::new(), "▏".to_owned())
        );
    }
}
