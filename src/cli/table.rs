//! Columns of text that line up.

use std::io::{self, Write};

use slideway::report::grid;

use super::told_width;

/// A table with a header: the first column to the left, the others as numbers to the right.
pub(super) struct Table {
    rows: Vec<Vec<String>>,
    left: usize,
}

impl Table {
    /// A table with these column heads.
    pub(super) fn new<const N: usize>(heads: [&str; N]) -> Self {
        Self { rows: vec![heads.map(str::to_owned).to_vec()], left: 1 }
    }

    /// A table with so many column heads.
    pub(super) fn of(heads: Vec<String>) -> Self {
        Self { rows: vec![heads], left: 1 }
    }

    /// Appends a row of so many cells.
    pub(super) fn cells(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    /// The first `columns` columns to the left instead of the first one only.
    pub(super) fn left(mut self, columns: usize) -> Self {
        self.left = columns;
        self
    }

    /// Appends a row.
    pub(super) fn row<const N: usize>(&mut self, cells: [String; N]) {
        self.rows.push(cells.to_vec());
    }

    /// Writes the table, indented by two, within the terminal's width where it has one.
    pub(super) fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or_default();
        let is_left: Vec<bool> = (0..columns).map(|column| column < self.left).collect();
        let room = told_width().map_or(usize::MAX, |width| width.saturating_sub(2));
        grid(&self.rows, &is_left, room).iter().try_for_each(|(_, line)| writeln!(out, "  {line}"))
    }
}
