//! The confusion matrix of a blind trial: as text, and as a picture.

use crate::trial::confusion::Confusion;
use std::fmt::Write as _;

/// Side of a cell.
const CELL: f64 = 22.0;
/// Room for the rows' names, and above for the columns'.
const LEFT: f64 = 190.0;
const TOP: f64 = 200.0;
const MARGIN: f64 = 24.0;
const INK: &str = "#222222";
/// Okabe and Ito's blue where the hidden effect was named, their vermilion where another was.
const RIGHT: &str = "0,114,178";
const WRONG: &str = "213,94,0";

/// The matrix as SVG: hidden effects down, named ones across, cells shaded by their share of the row.
///
/// White ground, no scripts, no external address.
pub fn svg(confusion: &Confusion, title: &str) -> String {
    let width = (LEFT + CELL * confusion.columns.len() as f64 + MARGIN).max(480.0);
    let height = TOP + CELL * confusion.rows.len() as f64 + MARGIN;
    let mut out = String::new();
    let _ = write!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"Helvetica, Arial, sans-serif\" font-size=\"11\" role=\"img\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n\
         <text x=\"{MARGIN}\" y=\"26\" font-size=\"14\" fill=\"{INK}\">{}</text>\n\
         <text x=\"{MARGIN}\" y=\"44\" fill=\"{INK}\">hidden: rows; named: columns; numbers are cases</text>\n",
        escaped(title)
    );
    for (k, column) in confusion.columns.iter().enumerate() {
        let x = LEFT + CELL * (k as f64 + 0.65);
        let y = TOP - 6.0;
        let _ = writeln!(
            out,
            "<text transform=\"translate({x:.1} {y:.1}) rotate(-90)\" fill=\"{INK}\">{}</text>",
            escaped(column)
        );
    }
    for (j, (row, counts)) in confusion.rows.iter().zip(&confusion.counts).enumerate() {
        let y = TOP + CELL * j as f64;
        let _ = writeln!(
            out,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"{INK}\">{}</text>",
            LEFT - 6.0,
            y + 0.68 * CELL,
            escaped(row)
        );
        let total: usize = counts.iter().sum();
        for (k, (column, &count)) in confusion.columns.iter().zip(counts).enumerate() {
            let x = LEFT + CELL * k as f64;
            let share = count as f64 / total.max(1) as f64;
            let colour = if row == column { RIGHT } else { WRONG };
            let _ = writeln!(
                out,
                "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{CELL}\" height=\"{CELL}\" fill=\"rgba({colour},{:.2})\" stroke=\"#dddddd\"/>",
                0.75 * share
            );
            if count > 0 {
                let _ = writeln!(
                    out,
                    "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"{INK}\">{count}</text>",
                    x + 0.5 * CELL,
                    y + 0.68 * CELL
                );
            }
        }
    }
    out.push_str("</svg>\n");
    out
}

/// The matrix as text: hidden effects down; across, the numbers of the rows, then verdicts without causes.
pub fn table(confusion: &Confusion) -> String {
    let name = confusion.rows.iter().chain(&confusion.columns).map(|n| n.chars().count()).max().unwrap_or(0);
    let number =
        |column: &String| confusion.columns.iter().position(|c| c == column).map_or(0, |place| place + 1);
    let mut out = format!("  {:<1$}", "hidden ↓, named →", name + 3);
    for column in &confusion.columns {
        let _ = write!(out, "{:>4}", number(column));
    }
    out.push('\n');
    for (row, counts) in confusion.rows.iter().zip(&confusion.counts) {
        let _ = write!(out, "  {:>2} {row:<name$}", number(row));
        for (column, count) in confusion.columns.iter().zip(counts) {
            let cell = match (count, row == column) {
                (0, true) => "·".to_owned(),
                (0, false) => String::new(),
                (count, _) => count.to_string(),
            };
            let _ = write!(out, "{cell:>4}");
        }
        while out.ends_with(' ') {
            out.pop();
        }
        out.push('\n');
    }
    for column in confusion.columns.iter().filter(|column| !confusion.rows.contains(column)) {
        let _ = writeln!(out, "  {:>2} {column}", number(column));
    }
    out
}

fn escaped(words: &str) -> String {
    words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
