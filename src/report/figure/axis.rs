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
        let places = (-step.log10().floor()).max(0.0) as usize;
        let first = (from / step).ceil() as i64;
        let last = (to / step).floor() as i64;
        (first..=last)
            .map(|k| {
                let value = k as f64 * step;
                let text = if step >= 1e6 { format!("{value:.0e}") } else { format!("{value:.places$}") };
                (value, text.replace('-', "−"))
            })
            .collect()
    }

    fn decade_ticks(&self, most: usize) -> Vec<(f64, String)> {
        let [from, to] = self.range.map(f64::log10);
        let (first, last) = (from.ceil() as i32, to.floor() as i32);
        let count = (last - first + 1).max(0) as usize;
        if count < 2 {
            let steps = [1.0, 2.0, 5.0];
            let values = (first - 1..=last).flat_map(|d| steps.map(|s| s * 10f64.powi(d)));
            let inside = values.filter(|v| (self.range[0]..=self.range[1]).contains(v));
            return inside.map(|v| (v, plain(v))).collect();
        }
        let every = count.div_ceil(most.max(1)).max(1);
        let shown = (first..=last).step_by(every);
        shown.map(|decade| (10f64.powi(decade), plain(10f64.powi(decade)))).collect()
    }
}

/// A power of ten as people write it.
fn plain(value: f64) -> String {
    if (1e-3..1e5).contains(&value) {
        return format!("{}", (value * 1e6).round() / 1e6);
    }
    let exponent = value.log10().round() as i32;
    let digits: String = exponent.to_string().chars().map(raised).collect();
    format!("10{digits}")
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
