//! Logs of LinuxCNC's halscope before version 2.9: the sampling period in the first line, then a name before every value.
//!
//! # Source
//! LinuxCNC, `src/hal/utils/scope_files.c`, `write_log_file` and `write_sample` (later versions write plain CSV).

/// First words of such a log.
const HEAD: &[u8] = b"Sampling period is ";
/// What halscope calls a channel that is switched off.
const OFF: &str = "(null)";

/// The log as a table with a header and a time column, and what was done to it; none where it is no such log.
///
/// The program writes one row more than it has samples, read from behind its buffer: that row is left out.
pub(super) fn table(bytes: &[u8]) -> Option<(Vec<u8>, String)> {
    let rest = bytes.strip_prefix(HEAD)?;
    let end = rest.iter().position(|byte| *byte == b'\n')?;
    let period_ns = period(std::str::from_utf8(&rest[..end]).ok()?)?;
    let body = String::from_utf8_lossy(&rest[end + 1..]);
    let mut rows: Vec<Vec<&str>> = Vec::new();
    for line in body.lines() {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        if !words.is_empty() {
            rows.push(words);
        }
    }
    rows.pop();
    let first = rows.first()?;
    let is_on = |place: &usize| first[*place] != OFF;
    let places: Vec<usize> = (0..first.len()).step_by(2).filter(is_on).collect();
    let mut text = String::from("time_s");
    for place in &places {
        text += "\t";
        text += first[*place];
    }
    for (k, row) in rows.iter().enumerate() {
        text += &format!("\n{}", k as f64 * period_ns * 1e-9);
        // A field that a cut-off row lacks is missing in the table too, and refused there.
        for value in places.iter().filter_map(|place| row.get(place + 1)) {
            text += "\t";
            text += value;
        }
    }
    text += "\n";
    let remark = format!(
        "halscope log at {} µs; its last row lies behind the record and was left out",
        period_ns * 1e-3
    );
    Some((text.into_bytes(), remark))
}

/// "1000000 nSec", later "1000000 ns".
fn period(words: &str) -> Option<f64> {
    let (number, unit) = words.trim().split_once(' ')?;
    let period: f64 = number.parse().ok()?;
    (matches!(unit.trim(), "nSec" | "ns") && period > 0.0 && period.is_finite()).then_some(period)
}
