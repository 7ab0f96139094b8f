//! Lines that fit the terminal.

/// A label ends before this column; what is folded goes on below its text.
const LABEL: usize = 26;

/// The text with lines of at most `width` columns, broken at blanks; what is to be copied (a command) stays whole.
pub(super) fn folded(text: &str, width: usize) -> String {
    let mut out = String::with_capacity(text.len() + text.len() / 16);
    for line in text.split_inclusive('\n') {
        let bare = line.trim_end_matches('\n');
        let is_copied = ["slideway ", "cargo ", "{"].iter().any(|head| bare.trim_start().starts_with(head));
        if is_copied || columns(bare) <= width {
            out += line;
            continue;
        }
        out += &fold(bare, width);
        out += &line[bare.len()..];
    }
    out
}

/// Characters on the screen: those of a colour's code take no room.
fn columns(text: &str) -> usize {
    let mut count = 0;
    let mut letters = text.chars();
    while let Some(letter) = letters.next() {
        if letter == '\u{1b}' {
            let _end = letters.by_ref().position(|letter| letter == 'm');
        } else {
            count += 1;
        }
    }
    count
}

fn fold(line: &str, width: usize) -> String {
    let indent = indent(line).min(width / 2);
    let begin = line.len() - line.trim_start().len();
    let mut out = line[..begin].to_owned();
    let mut used = begin;
    let mut is_first = true;
    for (k, word) in line[begin..].split(' ').enumerate() {
        let takes = columns(word);
        if !is_first && !word.is_empty() && used + 1 + takes > width && used > indent {
            out.truncate(out.trim_end().len());
            out += "\n";
            out += &" ".repeat(indent);
            used = indent;
        } else if k > 0 {
            out.push(' ');
            used += 1;
        }
        out += word;
        used += takes;
        is_first = is_first && word.is_empty();
    }
    out.truncate(out.trim_end().len());
    out
}

/// Where a line goes on: below the text behind its label, else two columns in.
fn indent(line: &str) -> usize {
    let letters: Vec<char> = line.chars().collect();
    let begin = letters.iter().take_while(|letter| **letter == ' ').count();
    let gap =
        (begin..letters.len().min(LABEL)).find(|&k| letters[k] == ' ' && letters.get(k + 1) == Some(&' '));
    let text = gap.map(|gap| gap + letters[gap..].iter().take_while(|letter| **letter == ' ').count());
    text.filter(|text| *text <= LABEL && *text < letters.len()).unwrap_or(begin + 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_lines_go_on_below_their_text() {
        let text = "  motor      kind = \"winding\", resistance_ohm = 1.3\nshort\n";
        let wanted = "  motor      kind =\n             \"winding\",\n             resistance_ohm\n             = 1.3\nshort\n";
        assert_eq!(folded(text, 28), wanted);
        assert_eq!(folded("a sentence of some words", 12), "a sentence\n  of some\n  words");
        assert_eq!(folded(text, 80), text);
    }

    #[test]
    fn exact_what_is_copied_stays_whole() {
        let command = "  slideway diagnose day1_axis --machine models/axis --html report.html\n";
        assert_eq!(folded(command, 40), command);
        assert_eq!(columns("\u{1b}[1;32mfour\u{1b}[0m"), 4);
    }
}
