//! Words as lines may be broken in them.

/// The words with numbers that no line may part from their units.
pub(super) fn unbroken(words: &str) -> String {
    let letters: Vec<char> = words.chars().collect();
    let around = |k: usize| (k.checked_sub(1).and_then(|b| letters.get(b)), letters.get(k + 1));
    let holds = |k: usize| match around(k) {
        (Some(before), Some(after)) => {
            let is_unit = "%µ±×→".contains(*after)
                || (after.is_alphabetic()
                    && letters[k + 1..].iter().take_while(|c| !c.is_whitespace()).count() <= 6);
            "<>±→×".contains(*before) || (before.is_ascii_digit() && is_unit)
        }
        _ => false,
    };
    // A minus is as wide as a digit and does not end a line.
    let is_minus = |k: usize| match around(k) {
        (before, Some(after)) => {
            before.is_none_or(|b| b.is_whitespace() || *b == '(') && after.is_ascii_digit()
        }
        _ => false,
    };
    let set = |(k, c): (usize, &char)| match c {
        ' ' if holds(k) => '\u{a0}',
        '-' if is_minus(k) => '−',
        other => *other,
    };
    letters.iter().enumerate().map(set).collect()
}
