//! A continuous transfer function fitted to the measured points of a frequency response.

use std::f64::consts::TAU;
use std::fmt;

use nalgebra::{Complex, DMatrix, DVector};
use serde::Serialize;

use super::excitation::Outcome;
use super::frequency_response::Point;
use super::least_squares::{Estimate, student_quantile};
use super::nonlinear::{Solution, Unknown, solve};
use super::{check, polynomial};
use crate::error::{Error, ErrorKind, Result};
use crate::singular::decomposed;

/// Most poles of a structure.
pub const MOST_POLES: usize = 6;
/// Rows (a gain or a phase) that each coefficient must be able to lean on.
const ROWS_PER_COEFFICIENT: usize = 3;
/// Repetitions of the linear fit, each weighted by the denominator before.
const REWEIGHTINGS: usize = 8;
/// Delays that are tried as starts: their distance in radians at the highest frequency, and their number. A start further off
/// than about a radian ends beside the solution.
const DELAY_STARTS: (f64, i32) = (0.25, 65);
/// Smallest relative standard deviation that weights a point.
const LEAST_RELATIVE_SD: f64 = 1e-6;
/// Step of the derivatives; the coefficients are scaled to the order of one.
const STEP: f64 = 1e-6;
const REMEDY: &str =
    "excite a band that reaches both sides of every corner, or ask for fewer poles and zeros";

/// A linear system in continuous time, from one input to one output.
///
/// # Model
/// ```text
///   T(s) = (b₀ + b₁·s + … + b_m·s^m)/(a₀ + a₁·s + … + s^n)·e^(−s·τ)        m ≤ n
/// ```
///
/// ```
/// use slideway::identify::continuous::ContinuousTransfer;
/// let lag = ContinuousTransfer { numerator: vec![6.0], denominator: vec![2.0, 1.0], delay_s: 0.0 };
/// let corner = lag.response(2.0 / std::f64::consts::TAU);
/// assert!((corner.norm() - lag.static_gain() / 2f64.sqrt()).abs() < 1e-12);
/// assert_eq!(lag.to_string(), "6 / (s + 2)");
/// let late = ContinuousTransfer { delay_s: 0.003, ..lag };
/// assert_eq!(late.to_string(), "6 / (s + 2) e^(-0.003 s)");
/// ```
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ContinuousTransfer {
    /// b₀, b₁, …
    pub numerator: Vec<f64>,
    /// a₀, a₁, … and the leading 1.
    pub denominator: Vec<f64>,
    /// τ in s.
    pub delay_s: f64,
}

impl ContinuousTransfer {
    /// T(i·2πf).
    pub fn response(&self, frequency_hz: f64) -> Complex<f64> {
        let s = Complex::new(0.0, TAU * frequency_hz);
        value(&self.numerator, s) / value(&self.denominator, s) * (-s * self.delay_s).exp()
    }

    /// T(0); infinite with an integrator.
    pub fn static_gain(&self) -> f64 {
        self.numerator.first().copied().unwrap_or(0.0) / self.denominator[0]
    }

    /// Poles in 1/s, the largest first.
    pub fn poles(&self) -> Vec<Complex<f64>> {
        let falling: Vec<f64> = self.denominator.iter().rev().copied().collect();
        polynomial::roots(&falling)
    }
}

fn value(coefficients: &[f64], s: Complex<f64>) -> Complex<f64> {
    coefficients.iter().rev().fold(Complex::default(), |sum, c| sum * s + *c)
}

impl fmt::Display for ContinuousTransfer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [numerator, denominator] = [&self.numerator, &self.denominator].map(|c| polynomial_text(c));
        let bracket = |(text, terms): (String, usize)| if terms > 1 { format!("({text})") } else { text };
        write!(f, "{} / {}", bracket(numerator), bracket(denominator))?;
        match self.delay_s {
            0.0 => Ok(()),
            delay => {
                let sign = if delay < 0.0 { "" } else { "-" };
                write!(f, " e^({sign}{} s)", digits(delay.abs()))
            }
        }
    }
}

fn digits(x: f64) -> String {
    let places = (4.0 - x.abs().max(f64::MIN_POSITIVE).log10().floor()).clamp(0.0, 12.0);
    let text = format!("{x:.*}", places as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The polynomial in falling powers of s, and its number of terms.
fn polynomial_text(coefficients: &[f64]) -> (String, usize) {
    let (mut text, mut terms) = (String::new(), 0);
    for (power, &c) in coefficients.iter().enumerate().rev().filter(|(_, c)| **c != 0.0) {
        text += match (terms, c < 0.0) {
            (0, false) => "",
            (0, true) => "-",
            (_, false) => " + ",
            (_, true) => " - ",
        };
        let factor = digits(c.abs());
        text += &match power {
            0 => factor,
            1 if c.abs() == 1.0 => "s".to_owned(),
            1 => format!("{factor} s"),
            _ if c.abs() == 1.0 => format!("s^{power}"),
            _ => format!("{factor} s^{power}"),
        };
        terms += 1;
    }
    (if terms == 0 { "0".to_owned() } else { text }, terms)
}

/// What a delay is known of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Delay {
    /// Its value in s.
    Known(f64),
    /// Nothing: it is found. A negative one says that the input was recorded late.
    Free,
}

/// What of the points is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compared {
    /// Gain and phase.
    GainAndPhase,
    /// The gain alone. The phase then only says where the search begins, and no delay is found.
    Gain,
}

/// How much each point counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weights {
    /// All alike: a relative error counts the same at every frequency.
    Equal,
    /// By one over the point's variance.
    ByNoise,
}

/// What is fitted, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Structure {
    /// m.
    pub zeros: usize,
    /// n.
    pub poles: usize,
    /// τ.
    pub delay: Delay,
    /// What is compared.
    pub compared: Compared,
    /// How much each point counts.
    pub weights: Weights,
}

/// A fitted transfer function with its uncertainty.
#[derive(Debug, Clone, Serialize)]
pub struct TransferFit {
    /// The fitted system.
    pub transfer: ContinuousTransfer,
    /// b₀, b₁, …
    pub numerator: Vec<Estimate>,
    /// a₀, a₁, … without the leading 1.
    pub denominator: Vec<Estimate>,
    /// τ in s, where it was to be found.
    pub delay_s: Option<Estimate>,
    /// T(0); none with an integrator.
    pub static_gain: Option<Estimate>,
    /// Root mean square of the relative deviation, the phase's in rad.
    pub deviation: f64,
    /// Points that were compared.
    pub points: usize,
    /// Condition number of the column-scaled Jacobian.
    pub condition: f64,
}

/// Fits a transfer function to the points of a frequency response.
///
/// # Model
/// θ = argmin Σ w_k·|ln(T(iω_k; θ)/H_k)|², real part the relative error of the gain, imaginary part that of the phase in rad;
/// w_k = 1, or one over the point's variance. The start is linear least squares of `N(iω) − H·D(iω)`, repeated with the
/// weight 1/|D|² of the solution before; from there Levenberg and Marquardt, see [`solve`]. 95 % intervals by Student's t
/// from s²·(JᵀJ)⁻¹, s² being the mean square of the weighted residual.
///
/// # Validity
/// Points with independent errors; a delay of at most 16 rad at the highest frequency. A structure that is wrong shows in the deviation, not in the intervals. A pole far outside the
/// band is told by its interval, which then reaches 0 or beyond twice its value.
///
/// # Source
/// Levy, *IRE Trans. Automatic Control* 4 (1959) 37; Sanathanan, Koerner, *IEEE Trans. Automatic Control* 8 (1963) 56;
/// Pintelon, Schoukens, *System Identification: A Frequency Domain Approach*, 2nd ed., chapter 9 (logarithmic least squares).
///
/// # Errors
/// More zeros than poles, too many poles; a free delay without phases; points that are not finite, at no frequency > 0 or
/// without gain; fewer than three gains and phases a coefficient.
pub fn fit(points: &[Point], structure: Structure) -> Result<Outcome<TransferFit>> {
    let problem = Problem::of(points, structure)?;
    let Some(start) = problem.start() else {
        return Err(Error::new(ErrorKind::Undetermined)
            .key("points")
            .found("points that no linear fit of this structure starts from")
            .expected("points at frequencies that tell the coefficients apart")
            .remedy(REMEDY));
    };
    let unknown = |(k, value): (usize, &f64)| Unknown {
        name: problem.name(k),
        start: *value,
        range: (f64::NEG_INFINITY, f64::INFINITY),
        step: STEP,
    };
    let unknowns: Vec<Unknown> = start.iter().enumerate().map(unknown).collect();
    match solve(&unknowns, REMEDY, |values| Ok(problem.residuals(values)))? {
        Outcome::NotExcited(why) => Ok(Outcome::NotExcited(why)),
        Outcome::Identified(solution) => problem.result(&solution).map(Outcome::Identified),
    }
}

/// Points and structure, scaled: frequencies by their geometric mean, gains by theirs.
struct Problem<'a> {
    points: &'a [Point],
    structure: Structure,
    omega_0: f64,
    gain_0: f64,
}

impl<'a> Problem<'a> {
    fn of(points: &'a [Point], structure: Structure) -> Result<Self> {
        let Structure { zeros, poles, delay, compared, .. } = structure;
        if zeros > poles || !(1..=MOST_POLES).contains(&poles) {
            return Err(Error::new(ErrorKind::OutOfRange)
                .key("order")
                .found(format!("{zeros} zeros over {poles} poles"))
                .expected(format!("1 to {MOST_POLES} poles and no more zeros than poles"))
                .remedy("ask for one pole and no zero first"));
        }
        if delay == Delay::Free && compared == Compared::Gain {
            return Err(Error::new(ErrorKind::Inconsistent)
                .key("delay")
                .found("a delay to be found from gains alone")
                .expected("gains and phases: a delay does not change a gain")
                .remedy("state the delay, or compare phases too"));
        }
        let numbers: Vec<f64> = points.iter().flat_map(|p| [p.frequency_hz, p.re, p.im]).collect();
        check::finite("points", &numbers)?;
        let is_empty = |p: &Point| p.frequency_hz <= 0.0 || p.response().norm() == 0.0;
        if let Some(k) = points.iter().position(is_empty) {
            return Err(Error::new(ErrorKind::OutOfRange)
                .key("points")
                .found(format!(
                    "{} Hz with a gain of {}",
                    points[k].frequency_hz,
                    points[k].response().norm()
                ))
                .expected("frequencies and gains above 0")
                .remedy("leave this point out"));
        }
        let coefficients = zeros + 1 + poles + usize::from(delay == Delay::Free);
        let rows = points.len() * if compared == Compared::Gain { 1 } else { 2 };
        check::enough_rows(rows, ROWS_PER_COEFFICIENT * coefficients, coefficients)?;
        let mean = |of: &dyn Fn(&Point) -> f64| {
            (points.iter().map(|p| of(p).ln()).sum::<f64>() / points.len() as f64).exp()
        };
        let (omega_0, gain_0) = (mean(&|p| TAU * p.frequency_hz), mean(&|p| p.response().norm()));
        Ok(Self { points, structure, omega_0, gain_0 })
    }

    fn name(&self, k: usize) -> String {
        let numerator = self.structure.zeros + 1;
        match k {
            k if k < numerator => format!("b{k}"),
            k if k < numerator + self.structure.poles => format!("a{}", k - numerator),
            _ => "delay".to_owned(),
        }
    }

    /// Scaled: s in units of ω₀, so that i·x stands for i·ω.
    fn s(&self, point: &Point) -> Complex<f64> {
        Complex::new(0.0, TAU * point.frequency_hz / self.omega_0)
    }

    /// Scaled delay: ω₀·τ.
    fn delay(&self, values: &[f64]) -> f64 {
        match self.structure.delay {
            Delay::Known(delay_s) => delay_s * self.omega_0,
            Delay::Free => values[self.structure.zeros + 1 + self.structure.poles],
        }
    }

    fn model(&self, values: &[f64], s: Complex<f64>) -> Complex<f64> {
        let (numerator, rest) = values.split_at(self.structure.zeros + 1);
        let leading = s.powu(self.structure.poles as u32);
        let denominator = leading + value(&rest[..self.structure.poles], s);
        value(numerator, s) / denominator * (-s * self.delay(values)).exp()
    }

    fn weight(&self, point: &Point) -> f64 {
        match self.structure.weights {
            Weights::Equal => 1.0,
            Weights::ByNoise => 1.0 / point.relative_sd.max(LEAST_RELATIVE_SD),
        }
    }

    fn residuals(&self, values: &[f64]) -> DVector<f64> {
        let both = self.points.iter().flat_map(|point| {
            let ratio = self.model(values, self.s(point)) * self.gain_0 / point.response();
            let weight = self.weight(point);
            // A gain of nothing is as wrong as can be, not infinitely so.
            let gain = ratio.norm().max(f64::MIN_POSITIVE).ln();
            let phase = match self.structure.compared {
                Compared::GainAndPhase => Some(weight * ratio.arg()),
                Compared::Gain => None,
            };
            std::iter::once(weight * gain).chain(phase)
        });
        DVector::from_iterator(self.rows(), both)
    }

    fn rows(&self) -> usize {
        self.points.len() * if self.structure.compared == Compared::Gain { 1 } else { 2 }
    }

    /// The best of the linear fits over the delays that are tried.
    fn start(&self) -> Option<Vec<f64>> {
        let highest = self.points.iter().map(|p| self.s(p).im).fold(0.0, f64::max);
        let delays: Vec<f64> = match self.structure.delay {
            Delay::Known(delay_s) => vec![delay_s * self.omega_0],
            Delay::Free => {
                let (distance, count) = DELAY_STARTS;
                (0..count).map(|k| f64::from(k) * distance / highest).collect()
            }
        };
        let fits = delays.into_iter().filter_map(|delay| {
            let mut values = self.linear(delay)?;
            if self.structure.delay == Delay::Free {
                values.push(delay);
            }
            let square = self.residuals(&values).norm_squared();
            square.is_finite().then_some((values, square))
        });
        fits.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(values, _)| values)
    }

    /// Repeated linear least squares of N − H·D with a given delay.
    fn linear(&self, delay: f64) -> Option<Vec<f64>> {
        let Structure { zeros, poles, .. } = self.structure;
        let columns = zeros + 1 + poles;
        let mut values: Option<Vec<f64>> = None;
        for _ in 0..REWEIGHTINGS {
            let mut matrix = DMatrix::zeros(2 * self.points.len(), columns);
            let mut target = DVector::zeros(2 * self.points.len());
            for (k, point) in self.points.iter().enumerate() {
                let s = self.s(point);
                let measured = point.response() / self.gain_0 * (s * delay).exp();
                let size = match &values {
                    None => 1.0,
                    Some(found) => (s.powu(poles as u32) + value(&found[zeros + 1..], s)).norm(),
                };
                let factor = self.weight(point) / (size * measured.norm()).max(f64::MIN_POSITIVE);
                let numerator = (0..=zeros).map(|j| s.powu(j as u32));
                let denominator = (0..poles).map(|j| -measured * s.powu(j as u32));
                for (j, entry) in numerator.chain(denominator).enumerate() {
                    (matrix[(2 * k, j)], matrix[(2 * k + 1, j)]) = (factor * entry.re, factor * entry.im);
                }
                let right = measured * s.powu(poles as u32) * factor;
                (target[2 * k], target[2 * k + 1]) = (right.re, right.im);
            }
            let solution = decomposed(matrix)?.solve(&target, f64::EPSILON).ok()?;
            let next: Vec<f64> = solution.iter().copied().collect();
            if next.iter().any(|x| !x.is_finite()) {
                return None;
            }
            values = Some(next);
        }
        values
    }

    fn result(&self, solution: &Solution) -> Result<TransferFit> {
        let Structure { zeros, poles, delay, .. } = self.structure;
        let (rows, columns) = solution.jacobian.shape();
        let degrees = rows - columns;
        let quantile = student_quantile(degrees)?;
        let variance = solution.residuals.norm_squared() / degrees as f64;
        let normal = solution.jacobian.tr_mul(&solution.jacobian);
        let inverse = inverse_of(&normal).ok_or_else(|| {
            Error::new(ErrorKind::Undetermined).key("points").found("a singular Jacobian").remedy(REMEDY)
        })?;
        let covariance = inverse * variance;
        let estimate = |k: usize, unit: f64| {
            Estimate::new(
                unit * solution.values[k],
                unit.abs() * covariance[(k, k)].max(0.0).sqrt(),
                quantile,
            )
        };
        let power = |j: usize| self.omega_0.powi(poles as i32 - j as i32);
        let numerator: Vec<Estimate> = (0..=zeros).map(|j| estimate(j, self.gain_0 * power(j))).collect();
        let denominator: Vec<Estimate> = (0..poles).map(|j| estimate(zeros + 1 + j, power(j))).collect();
        let delay_s = (delay == Delay::Free).then(|| estimate(zeros + 1 + poles, 1.0 / self.omega_0));
        let of = |estimates: &[Estimate]| estimates.iter().map(|e| e.value).collect::<Vec<f64>>();
        let transfer = ContinuousTransfer {
            numerator: of(&numerator),
            denominator: [of(&denominator), vec![1.0]].concat(),
            delay_s: self.delay(&solution.values) / self.omega_0,
        };
        let (b, a, place) = (solution.values[0], solution.values[zeros + 1], zeros + 1);
        let static_gain = (a != 0.0).then(|| {
            // Of b/a by b and by a.
            let (by_b, by_a) = (1.0 / a, -b / (a * a));
            let spread = by_b * by_b * covariance[(0, 0)]
                + 2.0 * by_b * by_a * covariance[(0, place)]
                + by_a * by_a * covariance[(place, place)];
            Estimate::new(self.gain_0 * b / a, self.gain_0 * spread.max(0.0).sqrt(), quantile)
        });
        let plain = Self { structure: Structure { weights: Weights::Equal, ..self.structure }, ..*self };
        let deviation = plain.residuals(&solution.values).norm() / (rows as f64).sqrt();
        let (points, condition) = (self.points.len(), solution.condition);
        Ok(TransferFit {
            transfer,
            numerator,
            denominator,
            delay_s,
            static_gain,
            deviation,
            points,
            condition,
        })
    }
}

/// Inverse of a symmetric positive matrix whose columns may be of very different size.
fn inverse_of(normal: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scale = DVector::from_fn(normal.nrows(), |k, _| normal[(k, k)].max(f64::MIN_POSITIVE).sqrt().recip());
    let scaled = DMatrix::from_diagonal(&scale) * normal * DMatrix::from_diagonal(&scale);
    let inverse = scaled.cholesky()?.inverse();
    Some(DMatrix::from_diagonal(&scale) * inverse * DMatrix::from_diagonal(&scale))
}
