//! Scales and their ticks.

/// An axis in the unit of the screen.
#[derive(Debug, Clone)]
pub struct Axis {
    /// What it counts, with its unit.
    pub label: String,
    /// From, to.
    pub range: [f64; 2],
    /// Whether it counts in decades.
    pub is_log: bool,
}

/// Share of the range that is left free beside the outermost value.
const MARGIN: f64 = 0.06;

impl Axis {
    /// A linear axis from one value to another.
    pub fn linear(label: impl Into<String>, [from, to]: [f64; 2]) -> Self {
        let good = from.is_finite() && to.is_finite() && to > from;
        Self { label: label.into(), range: if good { [from, to] } else { [0.0, 1.0] }, is_log: false }
    }

    /// A linear axis that holds all values, and a little more.
    pub fn holding(label: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Self {
        let [from, to] = extremes(values);
        let margin = MARGIN * (to - from);
        let margin = if margin > 0.0 { margin } else { (0.1 * to.abs()).max(1e-9) };
        Self::linear(label, [from - margin, to + margin])
    }

    /// A logarithmic axis that holds all values above zero.
    pub fn decades(label: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Self {
        let [from, to] = extremes(values.into_iter().filter(|v| *v > 0.0));
        let good = from > 0.0 && to >= from;
        let range = if good { [from / 1.15, to * 1.15] } else { [0.1, 10.0] };
        Self { label: label.into(), range, is_log: true }
    }

    /// Where a value lies, 0 to 1.
    pub fn place(&self, value: f64) -> f64 {
        let [from, to] = self.range;
        if self.is_log {
            (value.max(f64::MIN_POSITIVE) / from).ln() / (to / from).ln()
        } else {
            (value - from) / (to - from)
        }
    }

    /// Values to be marked, at most about so many, with their text.
    pub fn ticks(&self, most: usize) -> Vec<(f64, String)> {
        if self.is_log { self.decade_ticks(most) } else { self.linear_ticks(most) }
    }

    fn linear_ticks(&self, most: usize) -> Vec<(f64, String)> {
        let [from, to] = self.range;
        let raw = (to - from) / most.max(1) as f64;
        let decade = 10f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * decade).find(|s| *s >= raw * 0.8);
        let step = step.unwrap_or(raw);
        let first = (from / step).ceil() as i64;
        let last = (to / step).floor() as i64;
        let largest = first.unsigned_abs().max(last.unsigned_abs()) as f64 * step;
        (first..=last).map(|k| (k as f64 * step, label(k as f64 * step, step, largest))).collect()
    }

    fn decade_ticks(&self, most: usize) -> Vec<(f64, String)> {
        let [from, to] = self.range.map(f64::log10);
        let (first, last) = (from.ceil() as i32, to.floor() as i32);
        let count = (last - first + 1).max(0) as usize;
        if count < 2 {
            let steps = [1.0, 2.0, 5.0];
            let values = (first - 1..=last).flat_map(|d| steps.map(|s| s * 10f64.powi(d)));
            let inside = values.filter(|v| (self.range[0]..=self.range[1]).contains(v));
            let marked: Vec<(f64, String)> = inside.map(|v| (v, plain(v))).collect();
            // Inside less than an octave there may be none: then as on a linear scale.
            return if marked.len() < 2 { self.linear_ticks(most) } else { marked };
        }
        let every = count.div_ceil(most.max(1)).max(1);
        let shown = (first..=last).step_by(every);
        shown.map(|decade| (10f64.powi(decade), plain(10f64.powi(decade)))).collect()
    }
}

/// The text of a multiple of a linear step: as many places as the step has; a power of ten that all ticks share where the
/// largest of them is small or the step is large.
fn label(value: f64, step: f64, largest: f64) -> String {
    let decade = |size: f64| (size * (1.0 + 1e-9)).log10().floor() as i32;
    if value == 0.0 {
        "0".to_owned()
    } else if largest < LEAST_PLAIN || step >= MOST_PLAIN {
        let exponent = decade(largest);
        let places = (exponent - decade(step)).max(0) as usize;
        powered(value / 10f64.powi(exponent), exponent, places)
    } else {
        let places = (-decade(step)).max(0) as usize;
        format!("{value:.places$}").replace('-', "−")
    }
}

/// Ticks that are all smaller are written with a power of ten, and those of a larger step.
const LEAST_PLAIN: f64 = 1e-3;
const MOST_PLAIN: f64 = 1e6;

/// "2.5·10⁻⁷"; "10⁻⁷" where the mantissa is one.
fn powered(mantissa: f64, exponent: i32, places: usize) -> String {
    let digits: String = exponent.to_string().chars().map(raised).collect();
    match format!("{mantissa:.places$}").replace('-', "−").as_str() {
        "1" => format!("10{digits}"),
        "−1" => format!("−10{digits}"),
        mantissa => format!("{mantissa}·10{digits}"),
    }
}

/// One, two or five times a power of ten as people write it.
fn plain(value: f64) -> String {
    if (0.999e-3..1e5).contains(&value) {
        return format!("{}", (value * 1e6).round() / 1e6);
    }
    let exponent = (value.log10() + 1e-9).floor() as i32;
    powered(value / 10f64.powi(exponent), exponent, 0)
}

fn raised(letter: char) -> char {
    match letter {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' => '⁰',
        digit => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    }
}

/// Smallest and largest finite value; 0 to 1 where there is none.
pub fn extremes(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let start = [f64::INFINITY, f64::NEG_INFINITY];
    let [low, high] =
        values.into_iter().filter(|v| v.is_finite()).fold(start, |[low, high], v| [low.min(v), high.max(v)]);
    if low <= high { [low, high] } else { [0.0, 1.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_ticks_are_round_and_inside() {
        let axis = Axis::linear("t in s", [0.03, 1.27]);
        let ticks = axis.ticks(6);
        assert_eq!(ticks.first().unwrap().1, "0.2");
        assert!(ticks.len() <= 7 && ticks.iter().all(|(v, _)| (0.03..=1.27).contains(v)), "{ticks:?}");
        let log = Axis::decades("f in Hz", [0.5, 2000.0]);
        let texts: Vec<String> = log.ticks(6).into_iter().map(|(_, text)| text).collect();
        assert_eq!(texts, ["1", "10", "100", "1000"]);
        assert_eq!(plain(1e-7), "10⁻⁷");
    }

    /// Below 10⁻³ a tick says its own value, not the nearest power of ten.
    #[test]
    fn exact_small_ticks_say_their_value() {
        assert_eq!([2e-4, 5e-4, 1e-4, 1e-3, 5e5].map(plain), ["2·10⁻⁴", "5·10⁻⁴", "10⁻⁴", "0.001", "5·10⁵"]);
        let texts = |from: f64, to: f64| -> Vec<String> {
            Axis::linear("", [from, to]).ticks(4).into_iter().map(|(_, text)| text).collect()
        };
        assert_eq!(texts(-4.1e-7, 4.1e-7), ["−4·10⁻⁷", "−2·10⁻⁷", "0", "2·10⁻⁷", "4·10⁻⁷"]);
        assert_eq!(texts(0.0, 2.1e-6), ["0", "0.5·10⁻⁶", "1.0·10⁻⁶", "1.5·10⁻⁶", "2.0·10⁻⁶"]);
        assert_eq!(texts(0.0, 0.0062), ["0", "0.002", "0.004", "0.006"]);
        // A decade that is not full still has two ticks.
        let narrow = Axis { label: String::new(), range: [3.1e-5, 4.6e-5], is_log: true };
        assert!(narrow.ticks(6).len() >= 2, "{:?}", narrow.ticks(6));
    }

    #[test]
    fn exact_values_have_their_place() {
        assert!((Axis::linear("", [-2.0, 2.0]).place(1.0) - 0.75).abs() < 1e-12);
        let log = Axis { label: String::new(), range: [1.0, 100.0], is_log: true };
        assert!((log.place(10.0) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn exact_a_flat_line_still_has_an_axis() {
        for values in [vec![3.0; 5], vec![], vec![f64::NAN], vec![0.0]] {
            let axis = Axis::holding("x", values);
            assert!(axis.range[1] > axis.range[0] && axis.range.iter().all(|x| x.is_finite()));
        }
    }
}
