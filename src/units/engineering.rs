//! SI values in the unit an engineer would choose.

use super::normalise;

/// The ladder of readable units for an SI unit, smallest first.
fn ladder(si_unit: &str) -> &'static [(f64, &'static str)] {
    match normalise(si_unit).as_str() {
        "s" => &[(1e-9, "ns"), (1e-6, "µs"), (1e-3, "ms"), (1.0, "s")],
        "Hz" => &[(1e-3, "mHz"), (1.0, "Hz"), (1e3, "kHz")],
        "m" => &[(1e-9, "nm"), (1e-6, "µm"), (1e-3, "mm"), (1.0, "m")],
        "m/s" => &[(1e-9, "nm/s"), (1e-6, "µm/s"), (1e-3, "mm/s"), (1.0, "m/s")],
        "rad" => &[(1e-6, "µrad"), (1e-3, "mrad"), (1.0, "rad")],
        "rad/s" => &[(1e-6, "µrad/s"), (1e-3, "mrad/s"), (1.0, "rad/s")],
        "V" => &[(1e-6, "µV"), (1e-3, "mV"), (1.0, "V")],
        "A" => &[(1e-6, "µA"), (1e-3, "mA"), (1.0, "A")],
        "N" => &[(1e-3, "mN"), (1.0, "N"), (1e3, "kN")],
        "Nm" => &[(1e-6, "µN·m"), (1e-3, "mN·m"), (1.0, "N·m"), (1e3, "kN·m")],
        "kg" => &[(1e-3, "g"), (1.0, "kg")],
        "Ω" => &[(1e-3, "mΩ"), (1.0, "Ω"), (1e3, "kΩ")],
        "H" => &[(1e-6, "µH"), (1e-3, "mH"), (1.0, "H")],
        _ => &[],
    }
}

/// An SI value to three significant digits in the unit an engineer would choose.
///
/// ```
/// use slideway::units::engineering;
/// assert_eq!(engineering(1.13e-4, "m"), "113 µm");
/// assert_eq!(engineering(-0.0123, "m/s"), "-12.3 mm/s");
/// assert_eq!(engineering(203.5034, "N·s/m"), "204 N·s/m");
/// assert_eq!(engineering(0.979, "1"), "0.979"); // a pure number
/// ```
pub fn engineering(value: f64, si_unit: &str) -> String {
    let rounded = three_digits(value);
    let si_unit = if si_unit == "1" { "" } else { si_unit };
    if rounded == 0.0 || !rounded.is_finite() {
        return format!("{rounded} {si_unit}").trim_end().to_owned();
    }
    let steps = ladder(si_unit);
    // A hair below one, so that 1e-3 / 1e-6 does not fall to the step below by rounding.
    let reached = |&&(size, _): &&(f64, &str)| rounded.abs() >= size * (1.0 - 1e-9);
    let (size, symbol) = match steps.iter().rev().find(reached).or(steps.first()) {
        Some(&(size, symbol)) => (size, symbol),
        None => (1.0, si_unit),
    };
    format!("{} {symbol}", digits(three_digits(rounded / size))).trim_end().to_owned()
}

fn three_digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// Three significant digits as plain text, with an exponent where plain text would be all zeros.
fn digits(rounded: f64) -> String {
    const PLAIN: std::ops::Range<f64> = 1e-3..1e6;
    if !PLAIN.contains(&rounded.abs()) {
        return format!("{rounded:.2e}");
    }
    let decade = rounded.abs().log10().floor() as i32;
    format!("{rounded:.*}", usize::try_from(2 - decade).unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_engineering_units_are_chosen_by_size() {
        let cases = [
            (1.13e-4, "m", "113 µm"),
            (9.996e-4, "m", "1.00 mm"),
            (1e-3, "m", "1.00 mm"),
            (5e-8, "m", "50.0 nm"),
            (0.246, "m", "246 mm"),
            (12.0, "m", "12.0 m"),
            (0.0, "N", "0 N"),
            (1234.0, "N", "1.23 kN"),
            (0.0165, "N·m", "16.5 mN·m"),
            (0.0165, "Nm", "16.5 mN·m"),
            (250e-6, "s", "250 µs"),
            (-60.0, "rad/s", "-60.0 rad/s"),
            (1.6846e-4, "kg·m²", "1.68e-4 kg·m²"),
            (203.5, "N·s/m", "204 N·s/m"),
            (0.5, "", "0.500"),
        ];
        for (value, unit, text) in cases {
            assert_eq!(engineering(value, unit), text);
        }
    }
}
