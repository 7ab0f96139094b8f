//! Stability margins read off the frequency response of an open loop.

use std::f64::consts::TAU;

use nalgebra::Complex;
use serde::Serialize;

use crate::error::{Error, ErrorKind, Result};

/// Relative step at which a crossing counts as found; it converges faster than linearly, so what is left is far less.
const CROSSING_TOLERANCE: f64 = 1e-11;
/// Steps in which every crossing is found.
const MOST_STEPS: usize = 80;
/// Parabolas by which the nearest point is refined: each takes the error to about its power 1.3.
const PARABOLAS: usize = 8;
/// Imaginary part below which a response at the last frequency counts as real, as it is at half the sampling rate.
const REAL: f64 = 1e-9;

/// By how much the gain may change, at a phase crossover.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GainMargin {
    /// Factor on the loop's gain that brings it to the limit, in dB; negative where less gain does.
    pub margin_db: f64,
    /// Phase crossover in Hz, where L is real and negative.
    pub frequency_hz: f64,
}

/// By how much the phase may lag more, at a gain crossover.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PhaseMargin {
    /// 180° + arg L, between −180° and 180°.
    pub margin_deg: f64,
    /// Gain crossover in Hz, where |L| = 1.
    pub frequency_hz: f64,
}

/// How near L comes to −1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ModulusMargin {
    /// The least |1 + L|.
    pub margin: f64,
    /// Where, in Hz.
    pub frequency_hz: f64,
}

impl ModulusMargin {
    /// Ms, the largest sensitivity: one over the margin.
    pub fn largest_sensitivity(&self) -> f64 {
        1.0 / self.margin
    }
}

/// How much later the loop may act, at a gain crossover.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DelayMargin {
    /// In s.
    pub margin_s: f64,
    /// Gain crossover in Hz.
    pub frequency_hz: f64,
}

/// Stability margins of a loop with the open-loop response L; the loop closes with u = −L·u.
///
/// # Model
/// - gain margin: −20·log₁₀|L| at the phase crossovers (L real and negative); of several the nearest to 0 dB on each side
/// - phase margin: 180° + arg L at the gain crossovers (|L| = 1); of several the smallest
/// - modulus margin: min |1 + L|, the distance to −1; Ms = 1/margin is the largest sensitivity
/// - delay margin: φ/(2π·f) at each gain crossover with φ = 180° + arg L between 0 and 360°; of several the smallest
///
/// Each is none where its crossing does not exist.
///
/// # Validity
/// They are distances to instability for a loop that is stable; the response alone does not tell that it is. A loop whose
/// gain must also not fall (conditionally stable) has a downward gain margin. What happens between two frequencies of the grid
/// more than once is not seen. The delay margin takes the delay as e^(−iωd), also between the samples.
///
/// # Source
/// Åström, Murray (2008), *Feedback Systems*, section 9.3; modulus margin: Landau, Zito (2006), *Digital Control Systems*, section 2.6.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Margins {
    /// Upward gain margin, more than 0 dB.
    pub gain: Option<GainMargin>,
    /// Downward gain margin, less than 0 dB.
    pub gain_down: Option<GainMargin>,
    /// Phase margin.
    pub phase: Option<PhaseMargin>,
    /// Modulus margin.
    pub modulus: Option<ModulusMargin>,
    /// Delay margin.
    pub delay: Option<DelayMargin>,
}

impl Margins {
    /// From frequencies in Hz, ascending, and L there; between two of them magnitude (its logarithm) and phase are straight
    /// lines over the logarithm of frequency. There is no modulus margin where L is nearest to −1 at the first or last frequency.
    ///
    /// # Errors
    /// Fewer than two points, frequencies that do not ascend from above 0, responses that are not finite.
    pub fn of(points: &[(f64, Complex<f64>)]) -> Result<Self> {
        check(points)?;
        let between = |frequency: f64| {
            let next = points.partition_point(|(f, _)| *f < frequency).clamp(1, points.len() - 1);
            let ((f0, l0), (f1, l1)) = (points[next - 1], points[next]);
            if l0.norm() == 0.0 || l1.norm() == 0.0 {
                return l0;
            }
            let share = (frequency / f0).ln() / (f1 / f0).ln();
            l0 * Complex::from_polar((l1.norm() / l0.norm()).powf(share), share * (l1 / l0).arg())
        };
        let mut found = Self::refined(points, between);
        // At the edge of what was measured |1 + L| goes on falling unseen: that is no minimum.
        let ends = [points[0].0, points[points.len() - 1].0];
        found.modulus = found.modulus.filter(|modulus| !ends.contains(&modulus.frequency_hz));
        Ok(found)
    }

    /// From a grid of ascending frequencies in Hz above 0 with L there, the crossings refined with L itself.
    pub fn refined(points: &[(f64, Complex<f64>)], exact: impl Fn(f64) -> Complex<f64>) -> Self {
        let mut found = Self { gain: None, gain_down: None, phase: None, modulus: None, delay: None };
        for pair in points.windows(2) {
            found.between(pair[0], pair[1], &exact);
        }
        let is_real = |l: Complex<f64>| l.im.abs() <= REAL * l.norm();
        if let Some((frequency, value)) = points.last().filter(|(_, l)| l.re < 0.0 && is_real(*l)) {
            found.phase_crossover(*frequency, *value);
        }
        found.modulus = nearest(points, exact);
        found
    }

    fn between(
        &mut self,
        (f0, l0): (f64, Complex<f64>),
        (f1, l1): (f64, Complex<f64>),
        exact: &impl Fn(f64) -> Complex<f64>,
    ) {
        if l0.im.signum() != l1.im.signum() && l0.re.min(l1.re) < 0.0 {
            let (frequency, value) = crossing([f0, f1], [l0.im, l1.im], exact, |l| l.im);
            // The positive real axis is no phase crossover; nor is a jump through infinity.
            if value.re < 0.0 && value.im.abs() < 1e-3 * value.norm() {
                self.phase_crossover(frequency, value);
            }
        }
        let excess = |l: Complex<f64>| l.norm_sqr() - 1.0;
        if excess(l0).signum() != excess(l1).signum() {
            let (frequency, value) = crossing([f0, f1], [excess(l0), excess(l1)], exact, excess);
            self.gain_crossover(frequency, value);
        }
    }

    fn phase_crossover(&mut self, frequency_hz: f64, value: Complex<f64>) {
        let margin_db = -20.0 * value.norm().log10();
        let side = if margin_db > 0.0 { &mut self.gain } else { &mut self.gain_down };
        if side.is_none_or(|known| margin_db.abs() < known.margin_db.abs()) {
            *side = Some(GainMargin { margin_db, frequency_hz });
        }
    }

    fn gain_crossover(&mut self, frequency_hz: f64, value: Complex<f64>) {
        let angle = (-value).arg();
        let margin_deg = angle.to_degrees();
        if self.phase.is_none_or(|known| margin_deg.abs() < known.margin_deg.abs()) {
            self.phase = Some(PhaseMargin { margin_deg, frequency_hz });
        }
        let margin_s = angle.rem_euclid(TAU) / (TAU * frequency_hz);
        if self.delay.is_none_or(|known| margin_s < known.margin_s) {
            self.delay = Some(DelayMargin { margin_s, frequency_hz });
        }
    }
}

/// Where L comes nearest to −1: the grid's nearest point, refined by the parabola through it and its neighbours, repeatedly.
fn nearest(points: &[(f64, Complex<f64>)], exact: impl Fn(f64) -> Complex<f64>) -> Option<ModulusMargin> {
    let square = |l: Complex<f64>| (l + 1.0).norm_sqr();
    let least = points.iter().enumerate().min_by(|a, b| square(a.1.1).total_cmp(&square(b.1.1)))?.0;
    let around = least.saturating_sub(1)..(least + 2).min(points.len());
    let mut three: Vec<[f64; 2]> = points[around].iter().map(|(f, l)| [*f, square(*l)]).collect();
    for _ in 0..PARABOLAS {
        let &[[f0, d0], [f1, d1], [f2, d2]] = &three[..] else { break };
        let (left, right) = ((d1 - d0) / (f1 - f0), (d2 - d1) / (f2 - f1));
        let vertex = 0.5 * (f0 + f1) - 0.5 * left * (f2 - f0) / (right - left);
        if !(f0 < vertex && vertex < f2) || vertex == f1 {
            break;
        }
        let new = [vertex, square(exact(vertex))];
        let (low, high) = if vertex < f1 { (new, three[1]) } else { (three[1], new) };
        three = if low[1] < high[1] { vec![three[0], low, high] } else { vec![low, high, three[2]] };
    }
    let [frequency_hz, square] = *three.iter().min_by(|a, b| a[1].total_cmp(&b[1]))?;
    Some(ModulusMargin { margin: square.sqrt(), frequency_hz })
}

/// Where `of` changes its sign between two frequencies, and the response there, by regula falsi (Illinois).
fn crossing(
    [mut from, mut to]: [f64; 2],
    [mut low, mut high]: [f64; 2],
    exact: &impl Fn(f64) -> Complex<f64>,
    of: impl Fn(Complex<f64>) -> f64,
) -> (f64, Complex<f64>) {
    let mut frequency = to;
    let mut value = exact(frequency);
    for _ in 0..MOST_STEPS {
        let next = (from * high - to * low) / (high - low);
        if !(from..=to).contains(&next) {
            break;
        }
        let step = (next - frequency).abs();
        frequency = next;
        value = exact(frequency);
        let here = of(value);
        if here == 0.0 || step <= CROSSING_TOLERANCE * frequency {
            break;
        }
        if here.signum() == high.signum() {
            (to, high, low) = (frequency, here, 0.5 * low);
        } else {
            (from, low, high) = (frequency, here, 0.5 * high);
        }
    }
    (frequency, value)
}

fn check(points: &[(f64, Complex<f64>)]) -> Result<()> {
    let refuse = |kind, found: String, expected: &str, remedy: &str| {
        Err(Error::new(kind).key("open_loop").found(found).expected(expected).remedy(remedy))
    };
    if points.len() < 2 {
        return refuse(
            ErrorKind::TooLittleData,
            format!("a response at {} frequencies", points.len()),
            "at least two",
            "estimate the response over a band around the crossover",
        );
    }
    if let Some((frequency, _)) =
        points.iter().find(|(f, l)| !(f.is_finite() && l.re.is_finite() && l.im.is_finite()))
    {
        return refuse(
            ErrorKind::NotFinite,
            format!("a response that is not finite at {frequency} Hz"),
            "finite numbers",
            "leave out frequencies that were not excited",
        );
    }
    let ascend = points[0].0 > 0.0 && points.windows(2).all(|pair| pair[0].0 < pair[1].0);
    if !ascend {
        return refuse(
            ErrorKind::Inconsistent,
            "frequencies that do not ascend from above 0".to_owned(),
            "each frequency once, ascending, in Hz",
            "sort the points by frequency",
        );
    }
    Ok(())
}
