//! Words broken into lines.

/// No line is narrower, however little room there is.
const NARROWEST: usize = 8;

/// Number of columns that a text takes on a screen.
pub(super) fn columns(text: &str) -> usize {
    text.chars().count()
}

/// Words in lines: a word goes on the line before it where `fits(line, word)`.
pub(super) fn fill(
    words: impl IntoIterator<Item = impl AsRef<str>>,
    fits: impl Fn(&str, &str) -> bool,
) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words {
        let word = word.as_ref();
        match lines.last_mut() {
            Some(line) if fits(line, word) => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Whether a word behind a line stays within so many columns.
fn within(width: usize) -> impl Fn(&str, &str) -> bool {
    move |line, word| columns(line) + 1 + columns(word) <= width
}

/// Words in lines of at most `width` columns, or of one word.
pub(super) fn lines_of_words(text: &str, width: usize) -> Vec<String> {
    fill(text.split_whitespace(), within(width))
}

/// Words in lines of at most `width` columns; a word that is longer stands alone and is cut into pieces.
pub fn wrap(text: &str, width: usize) -> Vec<String> {
    let width = width.max(NARROWEST);
    let pieces = text.split_whitespace().flat_map(|word| {
        let letters: Vec<char> = word.chars().collect();
        letters.chunks(width).map(|piece| piece.iter().collect::<String>()).collect::<Vec<_>>()
    });
    fill(pieces, within(width))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_lines_fit() {
        assert_eq!(wrap("one two  three", 9), ["one two", "three"]);
        assert_eq!(wrap("abcdefghijkl mn", 8), ["abcdefgh", "ijkl mn"]);
        assert_eq!(wrap("ab cdefghijklmn o", 8), ["ab", "cdefghij", "klmn o"]);
        assert_eq!(wrap("", 9), [""; 0]);
        assert_eq!(lines_of_words("one abcdefghijkl two", 8), ["one", "abcdefghijkl", "two"]);
    }
}
