//! A report of paragraphs, tables and figures as a page.

use super::page::{Builder, Page, Part};
use super::replayed::version;
use super::{data, head, provenance};
use crate::report::sheet::{Item, Section, Sheet};

/// The report as a page; `command` is what was typed.
pub fn sheet(sheet: &Sheet, command: &str) -> Page {
    let Sheet { subject, kind, sentence, note, motion, sections } = sheet;
    let head = head::plain_head(subject, kind, sentence, note.as_deref());
    let mut page = Builder::new(&format!("{subject}: {kind}"), head);
    for (k, section) in sections.iter().enumerate() {
        page.section(&format!("part{}", k + 1), &section.title, part(section));
    }
    page.section("provenance", "Where this comes from", provenance::list(&[version()], command));
    page.finish(&data::of(*motion, &[], None))
}

/// A section's part of a page.
pub(super) fn part(section: &Section) -> Part {
    let mut part = Part::default();
    for item in &section.items {
        match item {
            Item::Words(text) => part.paragraph(text),
            Item::Remark(text) => part.remark(text),
            Item::Table { heads, rows, left } => {
                let head = |(k, head): (usize, &String)| {
                    if k < *left { head.clone() } else { format!(">{head}") }
                };
                let heads: Vec<String> = heads.iter().enumerate().map(head).collect();
                let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
                part.table(&heads, rows)
            }
            Item::Figure(figure) => part.figure((**figure).clone()),
        };
    }
    part
}
