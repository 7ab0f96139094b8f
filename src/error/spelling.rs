//! Likely meant names: the closest of a list, and slips of the finger.

use strsim::levenshtein as distance;

/// The closest name, if one is close enough to have been meant.
pub(crate) fn closest<'a>(name: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = name.to_lowercase();
    let reach = (wanted.chars().count() / 2).max(2);
    let scored = names.into_iter().map(|candidate| {
        let candidate_low = candidate.to_lowercase();
        let stem = wanted.len() >= 3
            && candidate_low.len() >= 3
            && (candidate_low.contains(&wanted) || wanted.contains(&candidate_low));
        // A name that contains the other ("pos_meas" in "pos_meas_m") was meant whatever its length.
        (if stem { 1 } else { distance(&wanted, &candidate_low) }, candidate)
    });
    scored.filter(|(far, _)| *far <= reach).min_by_key(|(far, _)| *far).map(|(_, candidate)| candidate)
}

/// Whether `name` is `key` with one letter too many, one missing, two swapped, or in capitals.
///
/// A replaced letter does not count: "tile" beside "file" is a word of its own.
pub(crate) fn is_slip(name: &str, key: &str) -> bool {
    let low = name.to_lowercase();
    let sorted = |text: &str| {
        let mut letters: Vec<char> = text.chars().collect();
        letters.sort_unstable();
        letters
    };
    let one_off = low.len().abs_diff(key.len()) == 1 && distance(&low, key) == 1;
    name != key && (low == key || one_off || sorted(&low) == sorted(key))
}

/// " (did you mean `x`?)" or nothing.
pub(crate) fn hint<'a>(name: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    closest(name, names).map_or_else(String::new, |near| format!(" (did you mean `{near}`?)"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_closest_and_slips() {
        assert_eq!(closest("pos_mes", ["t_s", "pos_meas_m", "cmd"]), Some("pos_meas_m"));
        assert_eq!(closest("pos_maes_m", ["t_s", "pos_meas_m", "cmd"]), Some("pos_meas_m"));
        assert_eq!(closest("temperature", ["t_s", "cmd"]), None);
        assert!(is_slip("roel", "role") && is_slip("files", "file") && is_slip("Role", "role"));
        assert!(!is_slip("tile", "file") && !is_slip("role", "role") && !is_slip("feed", "file"));
    }
}
