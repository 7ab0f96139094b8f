//! The page: one file with its style, its figures, its data and its script, nothing to be fetched.

use super::unbroken::unbroken;
use crate::report::figure::{self, Figure, Width, escape};

const TEMPLATE: &str = include_str!("../../../assets/report/page.html");
const STYLE: &str = include_str!("../../../assets/report/page.css");
const SCRIPTS: [&str; 5] = [
    include_str!("../../../assets/report/data.js"),
    include_str!("../../../assets/report/scope.js"),
    include_str!("../../../assets/report/traces.js"),
    include_str!("../../../assets/report/scene.js"),
    include_str!("../../../assets/report/page.js"),
];

/// A page and the figures in it.
#[derive(Debug, Clone)]
pub struct Page {
    /// The page as one file.
    pub html: String,
    /// Its figures, to be saved for papers.
    pub figures: Vec<Figure>,
}

/// A page under way.
#[derive(Debug, Default)]
pub(super) struct Builder {
    title: String,
    head: String,
    sections: Vec<(String, String, String)>,
    figures: Vec<Figure>,
}

impl Builder {
    /// A page of this title that begins with `head`.
    pub(super) fn new(title: &str, head: String) -> Self {
        Self { title: title.to_owned(), head, ..Self::default() }
    }

    /// Appends a section; nothing where it is empty.
    pub(super) fn section(&mut self, id: &str, title: &str, part: Part) {
        if !part.html.is_empty() {
            self.sections.push((id.to_owned(), title.to_owned(), part.html));
            self.figures.extend(part.figures);
        }
    }

    /// The page, with its data for the script.
    pub(super) fn finish(self, data: &serde_json::Value) -> Page {
        let mut body = self.head;
        body += "<nav aria-label=\"Sections\">";
        for (id, title, _) in &self.sections {
            body += &format!("<a href=\"#{id}\">{}</a>", escape(title));
        }
        body += "</nav>\n";
        for (id, title, html) in &self.sections {
            body += &format!("<section id=\"{id}\">\n<h2>{}</h2>\n{html}</section>\n", escape(title));
        }
        // What could end the element is written as an escape of JSON.
        let data = data.to_string().replace('<', "\\u003c").replace("\u{2028}", "\\u2028");
        let style = format!("{STYLE}\n{}", figure::STYLE.trim_end());
        let dark = include_str!("../../../assets/report/dark.css");
        let parts = [
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("title", escape(&self.title)),
            ("style", style + "\n" + dark),
            ("body", body),
            ("data", data),
            ("script", SCRIPTS.concat()),
        ];
        Page { html: filled(parts), figures: self.figures }
    }
}

/// The template with its places filled, in their order; what is filled in is not looked at again.
fn filled<const N: usize>(parts: [(&str, String); N]) -> String {
    let mut out = String::new();
    let mut rest = TEMPLATE;
    for (name, text) in parts {
        if let Some((before, after)) = rest.split_once(&format!("{{{{{name}}}}}")) {
            out += before;
            out += &text;
            rest = after;
        }
    }
    out + rest
}

/// A command whose words are not broken at their hyphens.
pub(super) fn command(line: &str) -> String {
    line.split(' ').map(|word| format!("<span>{}</span>", escape(word))).collect::<Vec<_>>().join(" ")
}

/// A part of a page: its text and the figures in it.
#[derive(Debug, Default)]
pub(super) struct Part {
    pub(super) html: String,
    pub(super) figures: Vec<Figure>,
}

impl Part {
    /// Appends markup.
    pub(super) fn raw(&mut self, html: &str) -> &mut Self {
        self.html += html;
        self
    }

    /// Appends a paragraph of plain words.
    pub(super) fn paragraph(&mut self, words: &str) -> &mut Self {
        self.html += &format!("<p>{}</p>\n", escape(words));
        self
    }

    /// Appends a remark.
    pub(super) fn remark(&mut self, words: &str) -> &mut Self {
        self.html += &format!("<p class=\"remark\">{}</p>\n", escape(words));
        self
    }

    /// Appends a figure in both widths.
    pub(super) fn figure(&mut self, figure: Figure) -> &mut Self {
        self.html += &format!(
            "<figure id=\"fig-{}\">\n{}{}<figcaption>{}</figcaption>\n</figure>\n",
            escape(&figure.name),
            figure.element(Width::Wide),
            figure.element(Width::Narrow),
            escape(&figure.caption)
        );
        self.figures.push(figure);
        self
    }

    /// Appends what a script replaces where there is one: the place of the live view, and what stands there without.
    pub(super) fn live(&mut self, view: &str, still: Self) -> &mut Self {
        self.html += &format!(
            "<div class=\"live\" data-view=\"{view}\"></div>\n<div class=\"still\">\n{}</div>\n",
            still.html
        );
        self.figures.extend(still.figures);
        self
    }

    /// Appends something folded.
    pub(super) fn folded(&mut self, summary: &str, part: Self) -> &mut Self {
        if !part.html.is_empty() {
            self.html +=
                &format!("<details>\n<summary>{}</summary>\n{}</details>\n", escape(summary), part.html);
            self.figures.extend(part.figures);
        }
        self
    }

    /// Appends a table; heads that begin with `>` are those of numbers.
    pub(super) fn table(&mut self, heads: &[&str], rows: &[Vec<String>]) -> &mut Self {
        if rows.is_empty() {
            return self;
        }
        let class = |head: &str| if head.starts_with('>') { " class=\"n\"" } else { "" };
        let word = |head: &str| escape(head.trim_start_matches('>'));
        self.html += "<table>\n<thead><tr>";
        for head in heads {
            self.html += &format!("<th{} scope=\"col\">{}</th>", class(head), word(head));
        }
        self.html += "</tr></thead>\n<tbody>\n";
        for row in rows {
            self.html += "<tr>";
            for (head, cell) in heads.iter().zip(row) {
                let (class, label) = (class(head), word(head));
                self.html += &format!("<td{class} data-label=\"{label}\">{}</td>", escape(&unbroken(cell)));
            }
            self.html += "</tr>\n";
        }
        self.html += "</tbody>\n</table>\n";
        self
    }
}
