//! The confusion matrix of a blind trial: as text, and as a picture.

use super::wrap::wrap;
use crate::trial::scoring::confusion::Confusion;
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
/// Head of the first column of the text.
const HIDDEN: &str = "hidden";

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

/// The matrix as text, a line a hidden effect: how many cases, how many named right, and what was named instead.
pub fn table(confusion: &Confusion, width: usize) -> String {
    let name = confusion.rows.iter().map(|row| row.chars().count()).max().unwrap_or(0).max(HIDDEN.len());
    let mut out = format!("  {HIDDEN:<name$}  cases  right  instead\n");
    let indent = name + 18;
    for (row, counts) in confusion.rows.iter().zip(&confusion.counts) {
        let cells = || confusion.columns.iter().zip(counts).filter(|(_, count)| **count > 0);
        let right: usize = cells().filter(|(column, _)| *column == row).map(|(_, count)| count).sum();
        let total: usize = counts.iter().sum();
        let mut wrong: Vec<_> = cells().filter(|(column, _)| *column != row).collect();
        wrong.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
        let wrong: Vec<String> = wrong.iter().map(|(column, count)| format!("{column} {count}")).collect();
        let lines = wrap(&wrong.join(", "), width.saturating_sub(indent));
        let begun =
            format!("  {row:<name$}  {total:>5}  {right:>5}  {}", lines.first().map_or("", String::as_str));
        let _ = writeln!(out, "{}", begun.trim_end());
        for line in lines.iter().skip(1) {
            let _ = writeln!(out, "{:indent$}{line}", "");
        }
    }
    out
}

fn escaped(words: &str) -> String {
    words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
