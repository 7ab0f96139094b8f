//! A frequency response as it is drawn: magnitude in dB, and angle without jumps.

use crate::identify::frequency_response::Point;

/// 20·lg, of magnitudes.
pub(super) fn decibels(value: f64) -> f64 {
    20.0 * value.max(f64::MIN_POSITIVE).log10()
}

/// Frequency, and the 95 % interval of the magnitude in dB; a band down to nothing ends 60 dB below.
pub(super) fn magnitude_band(point: &Point) -> [f64; 3] {
    let [low, high] = point.magnitude_ci95();
    [point.frequency_hz, decibels(low.max(1e-3 * point.response().norm())), decibels(high)]
}

/// "dB", and of what where that has a unit.
pub(super) fn decibel_unit(unit: &str) -> String {
    if unit.is_empty() { "dB".to_owned() } else { format!("dB ({unit})") }
}

/// Angles in degrees without jumps of a whole turn; what is not a number is passed over.
pub(super) fn unwrapped(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let mut last = f64::NAN;
    for [_, angle] in &mut points {
        if last.is_finite() && angle.is_finite() {
            *angle -= 360.0 * ((*angle - last) / 360.0).round();
        }
        if angle.is_finite() {
            last = *angle;
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_angles_go_on_across_a_turn() {
        let points = vec![[1.0, -170.0], [2.0, f64::NAN], [3.0, 175.0], [4.0, -178.0]];
        let angles: Vec<f64> = unwrapped(points).into_iter().map(|p| p[1]).collect();
        assert_eq!([angles[0], angles[2], angles[3]], [-170.0, -185.0, -178.0]);
    }
}
