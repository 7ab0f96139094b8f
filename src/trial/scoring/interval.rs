//! Numbers with 95 % intervals.

use crate::diagnose::evidence::bootstrap;
use serde::Serialize;

/// 97.5 % quantile of the normal distribution.
const NORMAL_975: f64 = 1.959_963_984_540_054;
/// Draws of the bootstrap.
const DRAWS: usize = 1000;

/// How often something came true.
///
/// # Model
/// Wilson's interval: with p = hits/of and z = 1.96,
/// `(p + z²/2n ± z·√(p(1−p)/n + z²/4n²)) / (1 + z²/n)`.
///
/// # Source
/// Wilson (1927), *Probable inference, the law of succession, and statistical inference*.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rate {
    /// How often it came true.
    pub hits: usize,
    /// Of how many.
    pub of: usize,
    /// The share; none of none is no number.
    pub value: Option<f64>,
    /// 95 % interval.
    pub ci95: Option<[f64; 2]>,
}

impl Rate {
    /// Counts.
    ///
    /// ```
    /// use slideway::trial::scoring::interval::Rate;
    /// let none_of_ten = Rate::new(0, 10);
    /// // z²/(n + z²)
    /// assert!((none_of_ten.ci95.unwrap()[1] - 3.8415 / 13.8415).abs() < 1e-4);
    /// ```
    pub fn new(hits: usize, of: usize) -> Self {
        if of == 0 {
            return Self { hits, of, value: None, ci95: None };
        }
        let (n, z) = (of as f64, NORMAL_975);
        let p = hits as f64 / n;
        let centre = p + z * z / (2.0 * n);
        let half = z * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
        let scale = 1.0 + z * z / n;
        let ci95 = [((centre - half) / scale).max(0.0), ((centre + half) / scale).min(1.0)];
        Self { hits, of, value: Some(p), ci95: Some(ci95) }
    }

    /// Counts what holds.
    pub fn count(all: impl IntoIterator<Item = bool>) -> Self {
        let (mut hits, mut of) = (0, 0);
        for one in all {
            of += 1;
            hits += usize::from(one);
        }
        Self::new(hits, of)
    }
}

/// A mean or median of several numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Level {
    /// The number; none of none.
    pub value: Option<f64>,
    /// 95 % interval, by bootstrap.
    pub ci95: Option<[f64; 2]>,
    /// Of how many.
    pub of: usize,
}

impl Level {
    /// The mean.
    pub fn mean(values: &[f64]) -> Self {
        Self::of(values, |drawn| drawn.iter().sum::<f64>() / drawn.len() as f64)
    }

    /// The median.
    pub fn median(values: &[f64]) -> Self {
        Self::of(values, |drawn| quantile(drawn, 0.5))
    }

    fn of(values: &[f64], statistic: impl Fn(&[f64]) -> f64) -> Self {
        if values.is_empty() {
            return Self { value: None, ci95: None, of: 0 };
        }
        let draws: Vec<f64> = bootstrap(values.len(), DRAWS)
            .iter()
            .map(|weights| {
                let times = |(value, weight): (&f64, &f64)| vec![*value; *weight as usize];
                let drawn: Vec<f64> = values.iter().zip(weights).flat_map(times).collect();
                statistic(&drawn)
            })
            .collect();
        let ci95 = [quantile(&draws, 0.025), quantile(&draws, 0.975)];
        Self { value: Some(statistic(values)), ci95: Some(ci95), of: values.len() }
    }
}

/// The number below which a share of the values lies; the mean of the two next to it.
fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = share * (sorted.len() - 1) as f64;
    let at = |place: f64| sorted.get(place as usize).copied().unwrap_or(f64::NAN);
    0.5 * (at(place.floor()) + at(place.ceil()))
}
