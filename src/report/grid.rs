//! Columns that line up within a width: texts go on below, heads stand in several lines, and what is wider still goes on in a
//! second block under its first column.

use super::wrap::{columns, lines_of_words};

/// Between columns.
const GAP: usize = 2;
/// A column of text does not give way beyond this.
const NARROWEST: usize = 12;

/// Lines of a table, and whether they belong to its heads; the first row is the heads.
pub fn grid(rows: &[Vec<String>], is_left: &[bool], width: usize) -> Vec<(bool, String)> {
    let every: Vec<usize> = (0..is_left.len()).collect();
    let widths = fitted(rows, is_left, width);
    let mut lines = Vec::new();
    let mut rest = &every[1.min(every.len())..];
    loop {
        // The first column stands before each block; at least one other goes with it.
        let mut taken = 0;
        let mut room = width.saturating_sub(widths.first().copied().unwrap_or_default());
        while let Some(column) = rest.get(taken) {
            let needs = GAP + widths[*column];
            if taken > 0 && needs > room {
                break;
            }
            room = room.saturating_sub(needs);
            taken += 1;
        }
        let (block, later) = rest.split_at(taken);
        let chosen: Vec<usize> = every.iter().take(1).chain(block).copied().collect();
        for (k, row) in rows.iter().enumerate() {
            lines.extend(row_lines(row, &chosen, &widths, is_left).into_iter().map(|line| (k == 0, line)));
        }
        rest = later;
        if rest.is_empty() {
            return lines;
        }
    }
}

/// Widths of the columns: as they are where they fit; else heads break at their blanks, then the widest texts give way.
fn fitted(rows: &[Vec<String>], is_left: &[bool], width: usize) -> Vec<usize> {
    let cell = |row: &Vec<String>, column: usize| row.get(column).map_or(0, |text| columns(text));
    let word = |text: &String| text.split_whitespace().map(columns).max().unwrap_or_default();
    let mut widths: Vec<usize> = (0..is_left.len())
        .map(|column| rows.iter().map(|row| cell(row, column)).max().unwrap_or_default())
        .collect();
    let excess =
        |widths: &[usize]| (widths.iter().sum::<usize>() + GAP * (widths.len() - 1)).saturating_sub(width);
    if widths.is_empty() || excess(&widths) == 0 {
        return widths;
    }
    let head = |column: usize| rows.first().and_then(|row| row.get(column)).map_or(0, word);
    for column in (0..is_left.len()).filter(|column| !is_left[*column]) {
        let longest = rows.iter().skip(1).map(|row| cell(row, column)).max().unwrap_or_default();
        let spared = excess(&widths).min(widths[column] - longest.max(head(column)).min(widths[column]));
        widths[column] -= spared;
    }
    // Words stay whole.
    let least = |column: usize| {
        let longest = rows.iter().filter_map(|row| row.get(column)).map(word).max().unwrap_or_default();
        longest.max(NARROWEST)
    };
    let mut texts: Vec<usize> = (0..is_left.len()).filter(|column| is_left[*column]).collect();
    texts.sort_by_key(|column| std::cmp::Reverse(widths[*column]));
    for column in texts {
        let spared = excess(&widths).min(widths[column].saturating_sub(least(column)));
        widths[column] -= spared;
    }
    widths
}

fn row_lines(row: &[String], chosen: &[usize], widths: &[usize], is_left: &[bool]) -> Vec<String> {
    let cells: Vec<Vec<String>> = chosen
        .iter()
        .map(|&column| row.get(column).map_or_else(Vec::new, |text| cell(text, widths[column])))
        .collect();
    let height = cells.iter().map(Vec::len).max().unwrap_or_default().max(1);
    (0..height)
        .map(|line| {
            let pieces = cells.iter().zip(chosen).map(|(cell, &column)| {
                let (text, width) = (cell.get(line).map_or("", String::as_str), widths[column]);
                if is_left[column] { format!("{text:<width$}") } else { format!("{text:>width$}") }
            });
            pieces.collect::<Vec<_>>().join(&" ".repeat(GAP)).trim_end().to_owned()
        })
        .collect()
}

/// A text that fits as it is, with its blanks; else its words in lines.
fn cell(text: &str, width: usize) -> Vec<String> {
    if columns(text) <= width { vec![text.to_owned()] } else { lines_of_words(text, width) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Vec<Vec<String>> {
        let row = |cells: [&str; 4]| cells.map(str::to_owned).to_vec();
        vec![
            row(["signal", "column", "lowest value", "in runs"]),
            row(["velocity reference", "velocity_reference_m_per_s", "-16.000 m/min", "4 of 4"]),
            row(["position", "position_m", "0 m", "4 of 4"]),
        ]
    }

    fn text(width: usize) -> Vec<String> {
        let lines = grid(&table(), &[true, true, false, false], width);
        assert!(lines.iter().all(|(_, line)| line.chars().count() <= width), "{lines:?}");
        lines.into_iter().map(|(_, line)| line).collect()
    }

    #[test]
    fn exact_a_table_that_fits_is_left_alone() {
        let lines = text(80);
        assert_eq!(lines.len(), 3);
        assert_eq!(lines[2], "position            position_m                            0 m   4 of 4");
    }

    #[test]
    fn exact_texts_give_way_before_columns_do() {
        let lines = text(64);
        assert_eq!(lines.len(), 5, "{lines:#?}");
        assert_eq!((lines[1].trim(), &lines[3][..9]), ("runs", "reference"));
    }

    #[test]
    fn exact_what_is_wider_still_goes_on_under_its_first_column() {
        let lines = text(44);
        assert!(lines.iter().filter(|line| line.starts_with("position")).count() > 1, "{lines:#?}");
        assert!(lines.iter().any(|line| line.contains("velocity_reference_m_per_s")), "{lines:#?}");
    }
}
