//! Transfer functions of sampled systems.

use std::f64::consts::TAU;
use std::fmt;

use nalgebra::Complex;
use serde::Serialize;

use super::{check, polynomial};
use crate::error::{Error, ErrorKind, Result};

/// Significant digits of a coefficient when no precision is asked for.
const SIGNIFICANT_DIGITS: usize = 6;

/// A linear sampled system from one input to one output, as a ratio of polynomials in z⁻¹.
///
/// # Model
/// ```text
///        b₀ + b₁ z⁻¹ + … + bₙ z⁻ⁿ
/// G(z) = ─────────────────────────,   y(k) = Σ bⱼ u(k−j) − Σ aᵢ y(k−i)
///         1 + a₁ z⁻¹ + … + aₘ z⁻ᵐ
/// ```
/// Numerator and denominator are stored in powers of z⁻¹ from the zeroth on; the denominator's first entry is
/// 1.
///
/// ```
/// use slideway::identify::transfer::TransferFunction;
/// let lag = TransferFunction::new(vec![0.0, 0.45], vec![1.0, -0.85], 0.025)?;
/// assert_eq!(lag.to_string(), "0.45 z^-1 / (1 - 0.85 z^-1)");
/// assert!((lag.dc_gain() - 3.0).abs() < 1e-12);
/// assert!(lag.is_stable());
/// # Ok::<(), slideway::error::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TransferFunction {
    numerator: Vec<f64>,
    denominator: Vec<f64>,
    sample_period_s: f64,
}

impl TransferFunction {
    /// From coefficients in powers of z⁻¹; both are divided by the denominator's first entry.
    ///
    /// # Errors
    /// An empty polynomial, a coefficient that is not finite, a denominator beginning with 0 (the system
    /// would answer before it is asked), a sample period that is not > 0.
    pub fn new(numerator: Vec<f64>, denominator: Vec<f64>, sample_period_s: f64) -> Result<Self> {
        check::sample_period(sample_period_s)?;
        check::finite("numerator", &numerator)?;
        check::finite("denominator", &denominator)?;
        if numerator.is_empty() {
            return Err(refusal("numerator", "no coefficient", "at least one coefficient"));
        }
        let lead = match denominator.first() {
            Some(&lead) if lead != 0.0 => lead,
            Some(_) => {
                return Err(refusal(
                    "denominator",
                    "0 as first coefficient",
                    "a first coefficient other than 0",
                ));
            }
            None => return Err(refusal("denominator", "no coefficient", "at least the coefficient 1")),
        };
        let divide = |c: Vec<f64>| c.into_iter().map(|x| x / lead).collect();
        Ok(Self { numerator: divide(numerator), denominator: divide(denominator), sample_period_s })
    }

    /// Coefficients b₀, b₁, … of z⁰, z⁻¹, …
    pub fn numerator(&self) -> &[f64] {
        &self.numerator
    }

    /// Coefficients 1, a₁, … of z⁰, z⁻¹, …
    pub fn denominator(&self) -> &[f64] {
        &self.denominator
    }

    /// Time between two samples, s.
    pub fn sample_period_s(&self) -> f64 {
        self.sample_period_s
    }

    /// Poles other than those at z = 0 (which only delay), largest modulus first.
    pub fn poles(&self) -> Vec<Complex<f64>> {
        polynomial::roots(&self.denominator)
    }

    /// Finite zeros other than those at z = 0, largest modulus first.
    pub fn zeros(&self) -> Vec<Complex<f64>> {
        polynomial::roots(&self.numerator)
    }

    /// Whether every pole lies inside the unit circle; an integrator is not stable.
    pub fn is_stable(&self) -> bool {
        self.poles().iter().all(|p| p.norm() < 1.0)
    }

    /// Steady output for a constant input of 1; infinite where a pole lies at z = 1.
    pub fn dc_gain(&self) -> f64 {
        self.numerator.iter().sum::<f64>() / self.denominator.iter().sum::<f64>()
    }

    /// The two systems in series.
    ///
    /// # Errors
    /// Different sample periods.
    pub fn multiply(&self, other: &Self) -> Result<Self> {
        if self.sample_period_s != other.sample_period_s {
            return Err(Error::new(ErrorKind::Inconsistent)
                .key("sample_period_s")
                .found(format!("{} s and {} s", self.sample_period_s, other.sample_period_s))
                .expected("systems sampled at one period")
                .remedy("sample one of them again at the other's period"));
        }
        Ok(Self {
            numerator: product(&self.numerator, &other.numerator),
            denominator: product(&self.denominator, &other.denominator),
            sample_period_s: self.sample_period_s,
        })
    }

    /// Frequency response at `frequency_hz`: G(exp(i·2πf·Ts)).
    pub fn response(&self, frequency_hz: f64) -> Complex<f64> {
        let delay = Complex::from_polar(1.0, -TAU * frequency_hz * self.sample_period_s);
        let value = |c: &[f64]| c.iter().rev().fold(Complex::new(0.0, 0.0), |sum, &c| sum * delay + c);
        value(&self.numerator) / value(&self.denominator)
    }

    /// Output for an input that was 0, as was the output, before the first sample.
    pub fn simulate(&self, input: &[f64]) -> Vec<f64> {
        self.simulate_from(input, &[])
    }

    /// Free run that starts from the given first outputs; inputs and outputs before the first sample are 0.
    pub fn simulate_from(&self, input: &[f64], first_outputs: &[f64]) -> Vec<f64> {
        let given = first_outputs.len().min(input.len());
        let mut output = Vec::with_capacity(input.len());
        output.extend_from_slice(&first_outputs[..given]);
        for k in given..input.len() {
            output.push(self.recurrence(input, &output, k));
        }
        output
    }

    /// One-step prediction: each output from the measured inputs and the measured outputs before it.
    ///
    /// The first [`memory`](Self::memory) samples, which lack a past, are the measured ones.
    pub fn predict(&self, input: &[f64], output: &[f64]) -> Vec<f64> {
        let known = self.memory().min(output.len());
        let ahead = (known..output.len().min(input.len())).map(|k| self.recurrence(input, output, k));
        output[..known].iter().copied().chain(ahead).collect()
    }

    /// How many samples into the past the recurrence reaches.
    pub fn memory(&self) -> usize {
        self.numerator.len().max(self.denominator.len()) - 1
    }

    fn recurrence(&self, input: &[f64], output: &[f64], k: usize) -> f64 {
        let forced: f64 = self.numerator.iter().zip(input[..=k].iter().rev()).map(|(b, u)| b * u).sum();
        let fed_back: f64 =
            self.denominator[1..].iter().zip(output[..k].iter().rev()).map(|(a, y)| a * y).sum();
        forced - fed_back
    }
}

fn refusal(key: &str, found: &str, expected: &str) -> Error {
    Error::new(ErrorKind::OutOfRange)
        .key(key)
        .found(found)
        .expected(expected)
        .remedy("list the coefficients of z^0, z^-1, and so on")
}

fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut c = vec![0.0; a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            c[i + j] += x * y;
        }
    }
    c
}

/// In powers of z⁻¹; `{:.3}` sets the decimals, without it six significant digits.
impl fmt::Display for TransferFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (numerator, terms) = polynomial_text(&self.numerator, f.precision());
        if terms > 1 {
            write!(f, "({numerator})")?
        } else {
            write!(f, "{numerator}")?
        }
        match polynomial_text(&self.denominator, f.precision()) {
            (_, 1) => Ok(()),
            (denominator, _) => write!(f, " / ({denominator})"),
        }
    }
}

/// The polynomial's text and its number of terms. A leading 1 of z⁰ is written without decimals.
fn polynomial_text(coefficients: &[f64], decimals: Option<usize>) -> (String, usize) {
    let mut text = String::new();
    let mut terms = 0;
    for (power, &c) in coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0) {
        text += match (terms, c < 0.0) {
            (0, false) => "",
            (0, true) => "-",
            (_, false) => " + ",
            (_, true) => " - ",
        };
        let unit = c.abs() == 1.0;
        match (power, unit) {
            (0, true) => text += "1",
            (0, false) => text += &number_text(c.abs(), decimals),
            (_, true) => text += &format!("z^-{power}"),
            (_, false) => text += &format!("{} z^-{power}", number_text(c.abs(), decimals)),
        }
        terms += 1;
    }
    if terms == 0 { ("0".into(), 1) } else { (text, terms) }
}

fn number_text(value: f64, decimals: Option<usize>) -> String {
    if let Some(decimals) = decimals {
        return format!("{value:.decimals$}");
    }
    let scientific = format!("{value:.*e}", SIGNIFICANT_DIGITS - 1);
    let rounded: f64 = scientific.parse().unwrap_or(value);
    if (1e-4..1e7).contains(&rounded) { rounded.to_string() } else { format!("{rounded:e}") }
}
