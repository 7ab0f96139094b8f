//! Numbers as a report writes them; what is not a number is a dash.

use crate::diagnose::verdict::Parameter;
use crate::units::engineering;

/// Stands for a number that is not there.
pub(super) const NONE: &str = "–";
/// Shares closer than this to 0 or 1 are only said to be so close.
const RESOLUTION: f64 = 1e-3;
/// Intervals whose halves differ by more than this share are written with both ends.
const LOPSIDED: f64 = 0.05;

/// A value in the unit an engineer would choose.
pub(super) fn value(value: f64, si_unit: &str) -> String {
    if value.is_finite() { engineering(value, si_unit) } else { NONE.to_owned() }
}

/// A share or probability in per cent, never rounded to certainty.
pub(super) fn percent(share: f64) -> String {
    let hundred = 100.0 * share;
    if !share.is_finite() {
        NONE.to_owned()
    } else if share == 0.0 {
        "0 %".to_owned()
    } else if share.abs() < RESOLUTION {
        "< 0.1 %".to_owned()
    } else if share >= 1.0 - RESOLUTION {
        "> 99.9 %".to_owned()
    } else if (0.1..0.98).contains(&share) || share < -0.1 {
        format!("{hundred:.0} %")
    } else {
        format!("{hundred:.1} %")
    }
}

/// A probability in per cent: one that has underflowed is small, not nothing.
pub(super) fn probability(p: f64) -> String {
    if p == 0.0 { "< 0.1 %".to_owned() } else { percent(p) }
}

/// Three significant digits without unit.
pub(super) fn plain(number: f64) -> String {
    value(number, "")
}

/// An angle of any size to a thousandth of a radian.
pub(super) fn angle(value_rad: f64) -> String {
    if value_rad.is_finite() { format!("{value_rad:.3} rad") } else { NONE.to_owned() }
}

/// How many SI units the engineering unit of a value is, and its symbol.
pub(super) fn engineering_unit(value: f64, si_unit: &str) -> (f64, String) {
    let text = engineering(value, si_unit);
    let (digits, symbol) = text.split_once(' ').unwrap_or((&text, ""));
    let number: f64 = digits.parse().unwrap_or(1.0);
    let decades = if number == 0.0 { 0.0 } else { (value / number).abs().log10().round() };
    if value == 0.0 || !decades.is_finite() {
        let pure = si_unit == "1";
        return (1.0, if pure { String::new() } else { si_unit.to_owned() });
    }
    (10f64.powi(decades as i32), symbol.to_owned())
}

/// Before and after, in the unit of the larger one: "113 → 2.90 µm".
pub(super) fn change(before: f64, after: f64, si_unit: &str) -> String {
    let largest =
        [before, after].into_iter().filter(|v| v.is_finite()).fold(0.0, |most: f64, v| most.max(v.abs()));
    let (size, symbol) = engineering_unit(largest, si_unit);
    format!("{} → {} {symbol}", plain(before / size), plain(after / size)).trim_end().to_owned()
}

/// From one value to another, in one unit and without idle zeros: "5 to 2000 Hz".
pub(super) fn range(from: f64, to: f64, si_unit: &str) -> String {
    if !(from.is_finite() && to.is_finite()) {
        return NONE.to_owned();
    }
    // An end that only rounding keeps from zero is zero.
    let [from, to] = [from, to].map(|end| if end.abs() < 1e-6 * (to - from).abs() { 0.0 } else { end });
    let (small, large) = (from.abs().min(to.abs()), from.abs().max(to.abs()));
    let of_small = engineering_unit(small, si_unit);
    let (size, symbol) =
        if small > 0.0 && large < 1e4 * of_small.0 { of_small } else { engineering_unit(large, si_unit) };
    let digits = |end: f64| format!("{:.2e}", end / size).parse().unwrap_or(end / size);
    let [from, to]: [f64; 2] = [digits(from), digits(to)];
    format!("{from} to {to} {symbol}").trim_end().to_owned()
}

/// A parameter with its 95 % interval, to the digits that the interval allows: "15.0 ± 0.3 N".
pub(super) fn with_interval(parameter: &Parameter) -> String {
    let Parameter { value: estimate, ci95: [from, to], unit, .. } = parameter;
    let (below, above) = (estimate - from, to - estimate);
    let half = 0.5 * (below + above);
    if !(estimate.is_finite() && half.is_finite() && half > 0.0) {
        return value(*estimate, unit);
    }
    let (size, symbol) = engineering_unit(estimate.abs().max(half), unit);
    let places = places(half / size);
    let grain = grain(half / size);
    let coarse = |number: f64| if grain > 1.0 { (number / grain).round() * grain } else { number };
    let text = |number: f64| format!("{:.places$}", positive_zero(coarse(number / size), places));
    let number = text(*estimate);
    let symbol = if symbol.is_empty() { String::new() } else { format!(" {symbol}") };
    if (above - below).abs() > LOPSIDED * half * 2.0 {
        return format!("{number}{symbol} ({} to {})", text(*from), text(*to));
    }
    format!("{number} ± {}{symbol}", text(half))
}

/// To what a number with such a half interval is rounded, where that is thousands and more: its second digit.
fn grain(half: f64) -> f64 {
    if half < 1e3 { 1.0 } else { 10f64.powf(half.log10().floor() - 1.0) }
}

/// Digits that a sentence has room for.
const BRIEF: i32 = 4;

/// A parameter for a sentence: with its interval, or to four digits where the interval is finer than those.
pub(super) fn brief(parameter: &Parameter) -> String {
    let half = 0.5 * (parameter.ci95[1] - parameter.ci95[0]);
    let (size, symbol) = engineering_unit(parameter.value.abs().max(half), &parameter.unit);
    match shown(parameter.value / size, half / size) {
        Some(digits) => format!("{digits} {symbol}").trim_end().to_owned(),
        None => with_interval(parameter),
    }
}

/// What the twin has instead, for a sentence.
pub(super) fn brief_twin(parameter: &Parameter) -> String {
    let half = 0.5 * (parameter.ci95[1] - parameter.ci95[0]);
    let (size, symbol) = engineering_unit(parameter.twin, &parameter.unit);
    match shown(parameter.twin / size, half / size) {
        Some(digits) => format!("{digits} {symbol}").trim_end().to_owned(),
        None => twin(parameter),
    }
}

/// A number to four digits; none where its uncertainty allows no more than those.
fn shown(number: f64, half: f64) -> Option<String> {
    if !(number.is_finite() && number != 0.0 && half.is_finite() && half > 0.0) {
        return None;
    }
    let most = (BRIEF - 1 - number.abs().log10().floor() as i32).max(0) as usize;
    (places(half) > most).then(|| format!("{number:.most$}"))
}

/// What the twin has and what was found, to the digits that the interval allows, three at most: "973 → 165 N".
pub(super) fn moved(parameter: &Parameter) -> String {
    let Parameter { value: found, twin, unit, .. } = parameter;
    let half = 0.5 * (parameter.ci95[1] - parameter.ci95[0]);
    let (size, symbol) = engineering_unit(found.abs().max(twin.abs()), unit);
    let text = |number: f64| rounded(number / size, found.abs().max(twin.abs()) / size, half / size);
    format!("{} → {} {symbol}", text(*twin), text(*found)).trim_end().to_owned()
}

/// How many times a parameter is what the twin has, to the digits that the interval allows, three at most.
pub(super) fn ratio(parameter: &Parameter) -> String {
    let half = 0.5 * (parameter.ci95[1] - parameter.ci95[0]);
    let ratio = parameter.value / parameter.twin;
    rounded(ratio, ratio.abs(), half / parameter.twin.abs())
}

fn rounded(number: f64, largest: f64, half: f64) -> String {
    if number == 0.0 {
        return "0".to_owned();
    }
    if !(number.is_finite() && half.is_finite() && half > 0.0 && largest > 0.0) {
        return plain(number);
    }
    let most = (2 - largest.log10().floor() as i32).max(0) as usize;
    let places = places(half).min(most);
    format!("{:.places$}", positive_zero(number, places))
}

/// A parameter to the digits that its interval allows, without it.
pub(super) fn estimate(parameter: &Parameter) -> String {
    as_precise(parameter.value, parameter)
}

/// What the twin has instead of a parameter, to as many digits.
pub(super) fn twin(parameter: &Parameter) -> String {
    if parameter.twin == 0.0 { value(0.0, &parameter.unit) } else { as_precise(parameter.twin, parameter) }
}

fn as_precise(number: f64, parameter: &Parameter) -> String {
    let half = 0.5 * (parameter.ci95[1] - parameter.ci95[0]);
    if !(number.is_finite() && parameter.value.is_finite() && half.is_finite() && half > 0.0) {
        return value(number, &parameter.unit);
    }
    let (size, symbol) = engineering_unit(parameter.value.abs().max(half), &parameter.unit);
    let places = places(half / size);
    format!("{:.places$} {symbol}", positive_zero(number / size, places)).trim_end().to_owned()
}

/// The ends of a parameter's 95 % interval.
pub(super) fn interval(parameter: &Parameter) -> String {
    let [from, to] = parameter.ci95;
    if !(from.is_finite() && to.is_finite()) {
        return NONE.to_owned();
    }
    let (size, symbol) = engineering_unit(from.abs().max(to.abs()), &parameter.unit);
    let places = places(0.5 * (to - from) / size);
    let text = |number: f64| format!("{:.places$}", positive_zero(number / size, places));
    format!("{} to {} {symbol}", text(from), text(to)).trim_end().to_owned()
}

/// Decimal places to which a number with this uncertainty is known: one digit of it, two behind a leading 1.
fn places(uncertainty: f64) -> usize {
    if !(uncertainty.is_finite() && uncertainty > 0.0) {
        return 3;
    }
    let decade = uncertainty.log10().floor();
    let leading = uncertainty / 10f64.powf(decade);
    let places = -decade + if leading < 1.95 { 1.0 } else { 0.0 };
    places.clamp(0.0, 8.0) as usize
}

/// No "-0.0".
fn positive_zero(number: f64, places: usize) -> f64 {
    if number.abs() < 0.5 * 10f64.powi(-(places as i32)) { 0.0 } else { number }
}

/// A coefficient of determination, rounded down: 0.99999 is not 1.
pub(super) fn determination(r2: f64) -> String {
    if !r2.is_finite() {
        return NONE.to_owned();
    }
    if r2 < -9.0 {
        return plain(r2);
    }
    format!("{:.5}", (r2 * 1e5).floor() / 1e5)
}

/// A TOML number to the digits that the interval allows, and two to spare.
pub(super) fn toml_number(parameter: &Parameter) -> String {
    let half = 0.5 * (parameter.ci95[1] - parameter.ci95[0]);
    let digits = match (parameter.value / half).abs().log10() {
        spread if spread.is_finite() => (spread.ceil().max(0.0) as usize + 2).min(15),
        _ => 6,
    };
    let rounded: f64 = format!("{:.digits$e}", parameter.value).parse().unwrap_or(parameter.value);
    format!("{rounded:?}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(value: f64, ci95: [f64; 2], unit: &str) -> Parameter {
        Parameter { value, ci95, unit: unit.to_owned(), twin: 0.0 }
    }

    #[test]
    fn exact_shares_are_never_rounded_to_certainty() {
        let cases = [
            (0.99996, "> 99.9 %"),
            (1.0, "> 99.9 %"),
            (1.03, "> 99.9 %"),
            (0.9949, "99.5 %"),
            (0.942, "94 %"),
            (0.9849, "98.5 %"),
            (0.0412, "4.1 %"),
            (1e-9, "< 0.1 %"),
            (0.0, "0 %"),
            (-0.31, "-31 %"),
            (f64::NAN, "–"),
            (f64::INFINITY, "–"),
        ];
        for (share, text) in cases {
            assert_eq!(percent(share), text, "{share}");
        }
        assert_eq!(probability(0.0), "< 0.1 %");
    }

    #[test]
    fn exact_intervals_decide_the_digits() {
        let cases = [
            (15.02, [14.71, 15.33], "N", "15.0 ± 0.3 N"),
            (15.0234, [15.0111, 15.0357], "N", "15.023 ± 0.012 N"),
            (2.5e-4, [2.4e-4, 2.6e-4], "s", "250 ± 10 µs"),
            (333.0, [321.0, 345.0], "N·s/m", "333 ± 12 N·s/m"),
            (1_021_269.0, [787_970.0, 1_254_568.0], "N/m", "1020000 ± 230000 N/m"),
            (-0.001, [-0.5, 0.498], "kg", "-1 ± 499 g"),
            (15.0, [14.9, 15.4], "N", "15.0 N (14.9 to 15.4)"),
            (15.0, [f64::NEG_INFINITY, f64::INFINITY], "N", "15.0 N"),
            (f64::NAN, [f64::NAN, f64::NAN], "N", "–"),
            (0.3, [0.2, 0.4], "", "0.30 ± 0.10"),
        ];
        for (value, ci95, unit, text) in cases {
            assert_eq!(with_interval(&parameter(value, ci95, unit)), text);
        }
    }

    #[test]
    fn exact_sentences_have_four_digits() {
        let cases = [
            (15.00005, 0.00015, "N", "15.00 N"),
            (0.999_82e-3, 3e-7, "s", "0.9998 ± 0.0003 ms"),
            (0.011_999_98, 3e-8, "m", "12.00 mm"),
            (15.02, 0.31, "N", "15.0 ± 0.3 N"),
            (12_345.678, 0.2, "", "12346"),
        ];
        for (value, half, unit, text) in cases {
            assert_eq!(brief(&parameter(value, [value - half, value + half], unit)), text);
        }
        let gain = Parameter { twin: 1.0, ..parameter(3.0912, [1.8, 4.4], "1") };
        assert_eq!([moved(&gain), ratio(&gain), brief_twin(&gain)], ["1.0 → 3.1", "3.1", "1.0"]);
        let play = Parameter { twin: 0.0, ..parameter(3.3e-4, [3.1e-4, 3.5e-4], "m") };
        assert_eq!(moved(&play), "0 → 330 µm");
    }

    #[test]
    fn exact_pairs_share_a_unit() {
        assert_eq!(change(1.13e-4, 2.9e-6, "m"), "113 → 2.90 µm");
        assert_eq!(change(1.13e-4, f64::NAN, "m"), "113 → – µm");
        assert_eq!(change(0.0, 0.0, "m"), "0 → 0 m");
        assert_eq!(range(-1e-12, 2.1e-3, "m"), "0 to 2.1 mm");
        assert_eq!(range(5.0, 2000.0, "Hz"), "5 to 2000 Hz");
        assert_eq!(range(-4e-4, 2e-2, "m"), "-0.4 to 20 mm");
        assert_eq!(determination(0.999_998_9), "0.99999");
    }

    #[test]
    fn exact_toml_numbers_read_back_within_the_interval() {
        for (value, half) in [(15.0234, 0.3), (2.5e-4, 1e-6), (-333.3, 12.0), (7e-9, 1e-10), (0.0, 1.0)] {
            let text = toml_number(&parameter(value, [value - half, value + half], "N"));
            let table: toml::Table = format!("x = {text}").parse().unwrap();
            let read = table["x"].as_float().unwrap();
            assert!((read - value).abs() <= 0.01 * half, "{text} for {value}");
        }
    }
}
