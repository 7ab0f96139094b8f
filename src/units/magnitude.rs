//! How large a number may be, by the unit in its name.

/// Magnitudes that no machine reaches, by the ending of a key's name; the first that fits holds.
///
/// They are far beyond any axis, so that only a wrong unit or a slip meets them, and far below where arithmetic overflows.
const LARGEST: &[(&str, f64)] = &[
    ("delay_s", 1.0),
    ("sample_period_s", 1.0),
    ("_m_per_s", 1e4),
    ("_rad_per_s", 1e6),
    ("_per_s", 1e9),
    ("_kg_m2", 1e9),
    ("_kg", 1e9),
    ("_ohm", 1e6),
    ("_hz", 1e7),
    ("_ratio", 1e6),
];
/// The same for names without `_per_`.
const LARGEST_PLAIN: &[(&str, f64)] = &[
    ("_nm", 1e9),
    ("_rad", 1e6),
    ("_s", 1e4),
    ("_m", 1e4),
    ("_n", 1e9),
    ("_v", 1e6),
    ("_a", 1e6),
    ("_h", 1e3),
];
/// Every other number.
const LARGEST_OTHER: f64 = 1e12;

/// Smallest number that counts as more than zero: far below any resolution, far above where arithmetic underflows.
pub const SMALLEST: f64 = 1e-15;

/// The largest magnitude that a key with this name may have, in the unit that the name ends in.
///
/// ```
/// use slideway::units::largest;
/// assert_eq!(largest("amplifier.delay_s"), 1.0);
/// assert_eq!(largest("voltage_limit_v"), 1e6);
/// assert!(largest("motor.back_emf_v_s_per_m") > 1e9);
/// ```
pub fn largest(key: &str) -> f64 {
    let fits = |(ending, _): &&(&str, f64)| key.ends_with(ending);
    let plain = if key.contains("_per_") { &[][..] } else { LARGEST_PLAIN };
    LARGEST.iter().chain(plain).find(fits).map_or(LARGEST_OTHER, |(_, largest)| *largest)
}
