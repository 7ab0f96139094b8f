//! Modes of a structure from the response of its position to a force.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, DVector};
use serde::Serialize;

use super::check;
use super::frequency_response::Point;
use super::least_squares::{Estimate, student_quantile};
use crate::error::{Error, ErrorKind, Result};

/// Alias bands to each side that a sampled response gathers; the next ones add less than 1e-5 even at half the sampling rate.
const ALIASES: i32 = 16;
/// Relative standard deviation below which no point counts as better known: rounding and the settling of the start.
const LEAST_RELATIVE_SD: f64 = 1e-5;
/// Modes that are looked for at most when their number is not given.
pub const MOST_MODES: usize = 12;
/// Iterations of Levenberg and Marquardt.
const MOST_ITERATIONS: usize = 100;
/// Damping ratio at which a new mode starts.
const START_DAMPING: f64 = 0.02;
/// Relative fall of the squared residual at which a fit has settled.
const SETTLED: f64 = 1e-10;

/// How the force runs between two samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Hold {
    /// Held: a staircase.
    Zero,
    /// Straight from sample to sample.
    Linear,
}

/// One mode found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FoundMode {
    /// Undamped natural frequency in Hz.
    pub frequency_hz: Estimate,
    /// Damping ratio.
    pub damping_ratio: Estimate,
    /// Modal mass at the driven point in kg (kg·m² for a turning axis).
    pub mass: Estimate,
}

/// The modes found, with the rigid part that they sit on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Modal {
    /// Moving mass in kg (inertia in kg·m²).
    pub moving_mass: Estimate,
    /// Viscous coefficient between moving part and base in N·s/m (N·m·s/rad).
    pub viscous: Estimate,
    /// The modes, by frequency.
    pub modes: Vec<FoundMode>,
    /// Root mean square of the residual over its stated standard deviation; 1 where the model leaves noise only.
    pub residual: f64,
    /// Points used.
    pub points: usize,
    parameters: Vec<f64>,
    hold: Hold,
    period_s: f64,
}

impl Modal {
    /// The fitted response at `frequency_hz`.
    pub fn response(&self, frequency_hz: f64) -> Complex<f64> {
        sampled(&self.parameters, frequency_hz, self.period_s, self.hold).0
    }
}

/// Modes from a measured response of position to force.
///
/// # Model
/// ```text
///   R(s) = 1/(m·s²) + Σ 1/(M_j·(s² + 2ζ_j·ω_j·s + ω_j²)),    H(s) = R/(1 + c·s·R)
///   H(e^{iωT}) = Σ_k H(s_k)·h(s_k),   s_k = i(ω + 2πk/T)
/// ```
/// A force pushes the moving part and, with the opposite sign, the base; the position is that of the part relative to the
/// base, and drag acts between the two. h is the hold: (1 − e^{−sT})/(sT) for a force that is held over each sample,
/// e^{sT}·((1 − e^{−sT})/(sT))² for one that runs straight from sample to sample.
/// The logarithms of m, c, ω_j, ζ_j, M_j are found by weighted nonlinear least squares (Levenberg, Marquardt), each
/// point with the standard deviation of its magnitude. Modes enter one at a time, each at the largest peak of what is left, until
/// the residual is noise or `modes` are there.
///
/// # Validity
/// Modes well below half the sampling rate, 0 < ζ < 1; position sensor and motor act at the same two points. Standard deviations
/// below 1e-5 of the magnitude are taken as 1e-5. Intervals hold for independent points; where the residual is more than its stated
/// deviation they are as many times wider.
///
/// # Source
/// Ewins (2000), *Modal Testing*, sections 2.4 and 4.4; sampling: Åström, Wittenmark (1997), *Computer-Controlled Systems*, section 7.4.
///
/// # Errors
/// Too few points, a period that is not > 0; no peak above the noise; more modes asked for than there are peaks,
/// seen by a modal mass whose standard deviation is more than half of it.
pub fn modes(points: &[Point], period_s: f64, hold: Hold, number: Option<usize>) -> Result<Modal> {
    check::sample_period(period_s)?;
    let usable: Vec<Point> =
        points.iter().copied().filter(|p| p.relative_sd.is_finite() && p.response().norm() > 0.0).collect();
    let most = number.unwrap_or(MOST_MODES);
    let least = 2 * (2 + 3 * number.unwrap_or(1));
    if usable.len() < least {
        return Err(Error::new(ErrorKind::TooLittleData)
            .key("response")
            .found(format!("{} coherent points for {} modes", usable.len(), number.unwrap_or(1)))
            .expected(format!("at least {least}"))
            .remedy("excite a wider band or record longer"));
    }
    let data = Data { points: usable, period_s, hold };
    let mut fit = data.fitted(data.rigid_start());
    while fit.modes() < most {
        let Some(start) = data.peak(&fit).filter(|peak| number.is_some() || peak.is_above_noise) else {
            break;
        };
        let next = data.fitted([&fit.parameters[..], &start.parameters].concat());
        let gain = (fit.square - next.square) / (next.square / data.freedom(&next));
        // An added mode must explain far more than its three parameters would of noise.
        if number.is_none() && (gain < MODE_EVIDENCE || !data.is_plausible(&next))
            || next.parameters.len() + 4 > 2 * data.points.len()
        {
            break;
        }
        fit = next;
    }
    if fit.modes() == 0 {
        return Err(Error::new(ErrorKind::Undetermined)
            .key("modes")
            .found("a response that rigid part and drag explain: no peak above the noise")
            .expected("a band with at least one resonance, excited well above the noise")
            .remedy("excite the band of the resonances more strongly, or record longer"));
    }
    data.result(fit)
}

/// Fall of the weighted squared residual, in units of its mean, that a further mode must bring.
const MODE_EVIDENCE: f64 = 40.0;

/// Relative standard deviation of a modal mass from which on the mode is not told from noise.
const OPEN_MASS: f64 = 0.5;

struct Data {
    points: Vec<Point>,
    period_s: f64,
    hold: Hold,
}

struct Fit {
    /// ln m, ln c, then ln f, ln ζ, ln M of each mode.
    parameters: Vec<f64>,
    square: f64,
}

impl Fit {
    fn modes(&self) -> usize {
        (self.parameters.len() - 2) / 3
    }
}

struct Peak {
    parameters: [f64; 3],
    is_above_noise: bool,
}

impl Data {
    fn sd(&self, point: &Point) -> f64 {
        point.response().norm() * point.relative_sd.max(LEAST_RELATIVE_SD)
    }

    fn freedom(&self, fit: &Fit) -> f64 {
        (2.0 * self.points.len() as f64 - fit.parameters.len() as f64).max(1.0)
    }

    /// Mass by the median of |H|·ω², drag a tenth of its force at the lowest frequency.
    fn rigid_start(&self) -> Vec<f64> {
        let mut masses: Vec<f64> = self
            .points
            .iter()
            .map(|p| 1.0 / (p.response().norm() * (TAU * p.frequency_hz).powi(2)))
            .collect();
        masses.sort_by(f64::total_cmp);
        let mass = masses[masses.len() / 2];
        let lowest = self.points.iter().map(|p| p.frequency_hz).fold(f64::INFINITY, f64::min);
        vec![mass.ln(), (0.1 * mass * TAU * lowest).ln()]
    }

    fn square(&self, parameters: &[f64]) -> f64 {
        let one = |p: &Point| {
            let model = sampled(parameters, p.frequency_hz, self.period_s, self.hold).0;
            ((p.response() - model) / self.sd(p)).norm_sqr()
        };
        let square: f64 = self.points.iter().map(one).sum();
        if square.is_finite() { square } else { f64::INFINITY }
    }

    /// Where the rest is largest against its noise, as the mode that would make it.
    fn peak(&self, fit: &Fit) -> Option<Peak> {
        let rest =
            |p: &Point| p.response() - sampled(&fit.parameters, p.frequency_hz, self.period_s, self.hold).0;
        let against_noise = |p: &Point| (rest(p) / self.sd(p)).norm_sqr();
        let top = self.points.iter().max_by(|a, b| against_noise(a).total_cmp(&against_noise(b)))?;
        let omega = TAU * top.frequency_hz;
        let mass = 1.0 / (2.0 * START_DAMPING * omega * omega * rest(top).norm()).max(f64::MIN_POSITIVE);
        // The largest of n squared Rayleigh amplitudes.
        let limit = 2.0 * (100.0 * self.points.len() as f64).ln();
        Some(Peak {
            parameters: [top.frequency_hz.ln(), START_DAMPING.ln(), mass.ln()],
            is_above_noise: against_noise(top) > limit,
        })
    }

    /// Whether every mode lies in the band that was measured, with a damping that leaves a peak.
    fn is_plausible(&self, fit: &Fit) -> bool {
        let ends =
            |fold: fn(f64, f64) -> f64, start| self.points.iter().map(|p| p.frequency_hz).fold(start, fold);
        let band = ends(f64::min, f64::INFINITY)..=ends(f64::max, 0.0);
        fit.parameters[2..].chunks_exact(3).all(|mode| band.contains(&mode[0].exp()) && mode[1].exp() < 0.5)
    }

    /// Levenberg and Marquardt from a start.
    fn fitted(&self, mut parameters: Vec<f64>) -> Fit {
        let (mut square, mut damping) = (self.square(&parameters), 1e-3);
        for _ in 0..MOST_ITERATIONS {
            let (hessian, gradient) = self.normal(&parameters);
            let mut scaled = hessian.clone();
            for k in 0..parameters.len() {
                scaled[(k, k)] += damping * hessian[(k, k)].max(f64::MIN_POSITIVE);
            }
            let step = scaled.cholesky().map(|triangle| triangle.solve(&gradient));
            let Some(step) = step.filter(|step| step.iter().all(|x| x.is_finite())) else {
                damping *= 10.0;
                if damping > 1e12 { break } else { continue }
            };
            let next: Vec<f64> =
                parameters.iter().zip(step.iter()).map(|(p, s)| p + s.clamp(-1.0, 1.0)).collect();
            let reached = self.square(&next);
            if reached < square {
                let settled = square - reached <= SETTLED * square;
                (parameters, square, damping) = (next, reached, (0.2 * damping).max(1e-12));
                if settled {
                    break;
                }
            } else {
                damping *= 6.0;
                if damping > 1e12 {
                    break;
                }
            }
        }
        Fit { parameters, square }
    }

    /// JᵀJ and Jᵀr of the weighted residuals.
    fn normal(&self, parameters: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
        let n = parameters.len();
        let (mut hessian, mut gradient) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for point in &self.points {
            let (model, slopes) = sampled(parameters, point.frequency_hz, self.period_s, self.hold);
            let weight = 1.0 / self.sd(point).powi(2);
            let rest = point.response() - model;
            for i in 0..n {
                gradient[i] += weight * (slopes[i].conj() * rest).re;
                for j in 0..=i {
                    let product = weight * (slopes[i].conj() * slopes[j]).re;
                    hessian[(i, j)] += product;
                    if i != j {
                        hessian[(j, i)] += product;
                    }
                }
            }
        }
        (hessian, gradient)
    }

    fn result(&self, fit: Fit) -> Result<Modal> {
        let freedom = self.freedom(&fit);
        // Each complex point has two parts, each of that standard deviation.
        let residual = (fit.square / freedom).sqrt();
        // A residual beyond the stated deviations widens the intervals; one within them does not narrow them.
        let variance = residual.powi(2).max(1.0);
        let failed = || {
            Error::new(ErrorKind::Undetermined)
                .key("modes")
                .found("modes that this response does not tell apart")
                .expected("a peak for each mode")
                .remedy("ask for fewer modes, or excite the band more finely")
        };
        let (hessian, _) = self.normal(&fit.parameters);
        let inverse = hessian.cholesky().ok_or_else(failed)?.inverse();
        let quantile = student_quantile(freedom as usize)?;
        let estimate = |k: usize| {
            let value = fit.parameters[k].exp();
            Estimate::new(value, value * (inverse[(k, k)] * variance).sqrt(), quantile)
        };
        // A mode whose mass is open to a factor is none that this response shows.
        let is_told = |j: usize| (inverse[(4 + 3 * j, 4 + 3 * j)] * variance).sqrt() < OPEN_MASS;
        if !(0..fit.modes()).all(is_told) {
            return Err(failed());
        }
        let mode = |j: usize| FoundMode {
            frequency_hz: estimate(2 + 3 * j),
            damping_ratio: estimate(3 + 3 * j),
            mass: estimate(4 + 3 * j),
        };
        let mut modes: Vec<FoundMode> = (0..fit.modes()).map(mode).collect();
        modes.sort_by(|a, b| a.frequency_hz.value.total_cmp(&b.frequency_hz.value));
        Ok(Modal {
            moving_mass: estimate(0),
            viscous: estimate(1),
            modes,
            residual,
            points: self.points.len(),
            parameters: fit.parameters,
            hold: self.hold,
            period_s: self.period_s,
        })
    }
}

/// The sampled response and its derivatives by the logarithms.
fn sampled(
    parameters: &[f64],
    frequency_hz: f64,
    period_s: f64,
    hold: Hold,
) -> (Complex<f64>, Vec<Complex<f64>>) {
    let mut value = Complex::default();
    let mut slopes = vec![Complex::default(); parameters.len()];
    for k in -ALIASES..=ALIASES {
        let s = Complex::new(0.0, TAU * (frequency_hz + f64::from(k) / period_s));
        let step = s * period_s;
        // e^{−sT} is the same at every alias.
        let held = (Complex::from(1.0) - Complex::from_polar(1.0, -TAU * frequency_hz * period_s)) / step;
        let shape = match hold {
            Hold::Zero => held,
            Hold::Linear => held * held * Complex::from_polar(1.0, TAU * frequency_hz * period_s),
        };
        continuous(parameters, s, |k, slope| match k {
            None => value += shape * slope,
            Some(k) => slopes[k] += shape * slope,
        });
    }
    (value, slopes)
}

/// The continuous response (none) and its derivative by each logarithm (its place), each handed to `give`.
fn continuous(parameters: &[f64], s: Complex<f64>, mut give: impl FnMut(Option<usize>, Complex<f64>)) {
    let rigid = (s * s * parameters[0].exp()).inv();
    let term = |mode: &[f64]| {
        let (omega, damping, mass) = (TAU * mode[0].exp(), mode[1].exp(), mode[2].exp());
        let dynamic = s * s + s * (2.0 * damping * omega) + omega * omega;
        ((dynamic * mass).inv(), dynamic, omega, damping)
    };
    let modes = || parameters[2..].chunks_exact(3);
    let free: Complex<f64> = rigid + modes().map(|mode| term(mode).0).sum::<Complex<f64>>();
    let drag = s * parameters[1].exp();
    let closed = (Complex::from(1.0) + drag * free).inv();
    let slope = closed * closed;
    give(None, free * closed);
    give(Some(0), -rigid * slope);
    give(Some(1), -drag * free * free * slope);
    for (j, mode) in modes().enumerate() {
        let (receptance, dynamic, omega, damping) = term(mode);
        let by_dynamic = -receptance / dynamic * slope;
        give(Some(2 + 3 * j), by_dynamic * (s * (2.0 * damping * omega) + 2.0 * omega * omega));
        give(Some(3 + 3 * j), by_dynamic * s * (2.0 * damping * omega));
        give(Some(4 + 3 * j), -receptance * slope);
    }
}
