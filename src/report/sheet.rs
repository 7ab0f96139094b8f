//! A report of paragraphs, tables and figures, the same on a terminal and as a page.

use super::Style;
use super::figure::Figure;
use super::layout::{Align, Ink, Table, paragraph};
use crate::units::Motion;

/// A report: what it is about, its answer, its sections.
#[derive(Debug, Clone)]
pub struct Sheet {
    /// Machine or recording.
    pub subject: String,
    /// What was done, in a word or two.
    pub kind: &'static str,
    /// The answer, in a sentence.
    pub sentence: String,
    /// Where the data come from.
    pub note: Option<String>,
    /// Kind of axis.
    pub motion: Motion,
    /// In the order in which they are read.
    pub sections: Vec<Section>,
}

/// A section of a [`Sheet`].
#[derive(Debug, Clone)]
pub struct Section {
    /// Its heading.
    pub title: String,
    /// What stands in it.
    pub items: Vec<Item>,
}

/// What a section is made of.
#[derive(Debug, Clone)]
pub enum Item {
    /// A paragraph.
    Words(String),
    /// How something is counted or meant.
    Remark(String),
    /// A table: heads, then rows; the first `left` columns are words, the others numbers.
    Table {
        /// Heads of the columns.
        heads: Vec<String>,
        /// One a row, as many cells as heads.
        rows: Vec<Vec<String>>,
        /// Columns of words.
        left: usize,
    },
    /// A figure, on pages only.
    Figure(Box<Figure>),
}

impl Section {
    /// An empty section.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), items: Vec::new() }
    }

    /// Appends a paragraph.
    pub fn words(mut self, text: impl Into<String>) -> Self {
        self.items.push(Item::Words(text.into()));
        self
    }

    /// Appends a remark.
    pub fn remark(mut self, text: impl Into<String>) -> Self {
        self.items.push(Item::Remark(text.into()));
        self
    }

    /// Appends a table whose first column is words.
    pub fn table(self, heads: &[&str], rows: Vec<Vec<String>>) -> Self {
        self.table_with(heads, rows, 1)
    }

    /// Appends a table whose first `left` columns are words.
    pub fn table_with(mut self, heads: &[&str], rows: Vec<Vec<String>>, left: usize) -> Self {
        let heads = heads.iter().map(|head| (*head).to_owned()).collect();
        self.items.push(Item::Table { heads, rows, left });
        self
    }

    /// Appends a figure.
    pub fn figure(mut self, figure: Figure) -> Self {
        self.items.push(Item::Figure(Box::new(figure)));
        self
    }

    /// The section as text, under its heading; nothing where it has nothing to say on a terminal.
    pub fn text(&self, style: Style) -> String {
        let body = self.body(style);
        // A key path stays as it is written.
        let title = if self.title.contains('_') { self.title.clone() } else { self.title.to_uppercase() };
        if body.is_empty() { body } else { style.heading(&title, "") + &body }
    }

    fn body(&self, style: Style) -> String {
        let item = |item: &Item| match item {
            Item::Words(text) => paragraph(text, style),
            Item::Remark(text) => {
                paragraph(text, style).lines().map(|line| style.ink(Ink::Faint, line) + "\n").collect()
            }
            Item::Table { heads, rows, left } => table(heads, rows, *left, style),
            Item::Figure(_) => String::new(),
        };
        self.items.iter().map(item).collect()
    }
}

fn table(heads: &[String], rows: &[Vec<String>], left: usize, style: Style) -> String {
    let align = |k: usize| if k < left { Align::Left } else { Align::Right };
    let heads: Vec<(&str, Align)> =
        heads.iter().enumerate().map(|(k, head)| (head.as_str(), align(k))).collect();
    let mut table = Table::new(&heads);
    rows.iter().for_each(|row| table.row(row.clone()));
    table.text(style)
}

impl Sheet {
    /// The report as text.
    pub fn text(&self, style: Style) -> String {
        let mut out = format!("{}\n", style.ink(Ink::Heading, &self.subject));
        out += &paragraph(&self.sentence, style);
        if let Some(note) = &self.note {
            out += &paragraph(&format!("Data: {note}"), style);
        }
        out + &self.sections.iter().map(|section| section.text(style)).collect::<String>()
    }
}
