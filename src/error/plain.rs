//! Texts from files and command lines as they may be shown: one line, no control characters, no endless numbers.

/// Digits that a number may have before it is written with an exponent.
const MOST_DIGITS: usize = 24;

/// The text on one line: control characters as escapes, long numbers with an exponent, its middle left out beyond so many
/// characters.
pub(crate) fn plain(text: &str, most: usize) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(letter) = rest.chars().next() {
        let number = rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len());
        if number > MOST_DIGITS {
            out += &shortened(&rest[..number]);
            rest = &rest[number..];
        } else if number > 0 {
            out += &rest[..number];
            rest = &rest[number..];
        } else {
            push(&mut out, letter);
            rest = &rest[letter.len_utf8()..];
        }
        // What is left out below need not be escaped.
        if out.len() > 16 * most {
            break;
        }
    }
    if out.chars().count() <= most {
        return out;
    }
    let (head, tail) = (most * 2 / 3, most / 4);
    let count = text.chars().count();
    let start: String = out.chars().take(head).collect();
    let end: String = if rest.is_empty() { tail_of(&out, tail) } else { String::new() };
    format!("{start} … {end} ({count} characters)")
}

fn tail_of(text: &str, letters: usize) -> String {
    let count = text.chars().count();
    text.chars().skip(count.saturating_sub(letters)).collect()
}

fn push(out: &mut String, letter: char) {
    // Characters that turn the direction of writing hide what stands there.
    let turns = matches!(letter, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    match letter {
        '\n' | '\t' => out.push(' '),
        _ if letter.is_control() || turns => out.extend(letter.escape_unicode()),
        _ => out.push(letter),
    }
}

fn shortened(digits: &str) -> String {
    match digits.parse::<f64>() {
        Ok(number) if number.is_finite() => format!("{number:e}"),
        _ => format!("{}… ({} digits)", digits.get(..6).unwrap_or_default(), digits.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_texts_are_shown_on_one_line() {
        assert_eq!(plain("position_m = 0.25", 80), "position_m = 0.25");
        assert_eq!(plain("\u{1b}[31mred\n\u{7}", 80), "\\u{1b}[31mred \\u{7}");
        assert_eq!(plain(&format!("{} m", 1e300), 80), "1e300 m");
        assert_eq!(plain(&"1".repeat(1000), 80), "111111… (1000 digits)");
        let long = plain(&"ab ".repeat(1000), 80);
        assert!(long.len() < 120 && long.ends_with("(3000 characters)"), "{long}");
    }
}
