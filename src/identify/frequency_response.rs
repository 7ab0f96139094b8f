//! Frequency response from a recording, without a model.

use nalgebra::Complex;
use realfft::RealFftPlanner;
use serde::Serialize;

use super::check;
use super::least_squares::student_quantile;
use crate::error::{Error, ErrorKind, Result};

/// Fewest segments for which a coherence means anything (with one segment it is 1 by construction).
pub const LEAST_SEGMENTS: usize = 4;
/// Correlation of two half-overlapping segments under a Hann window, squared.
const OVERLAP_CORRELATION_SQUARED: f64 = 1.0 / 36.0;
/// Below this share of the strongest line an input holds nothing.
const NOTHING: f64 = 1e-12;

/// The measured response at one frequency.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Point {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Real part of output over input.
    pub re: f64,
    /// Imaginary part of output over input.
    pub im: f64,
    /// Coherence γ², 0 to 1: the share of the output's power that the input explains linearly.
    pub coherence: f64,
    /// One standard deviation of the magnitude over the magnitude, and of the phase in rad.
    pub relative_sd: f64,
    /// Half width of the 95 % interval in standard deviations.
    pub quantile: f64,
}

impl Point {
    /// Output over input.
    pub fn response(&self) -> Complex<f64> {
        Complex::new(self.re, self.im)
    }

    /// 95 % interval of the magnitude.
    pub fn magnitude_ci95(&self) -> [f64; 2] {
        let (size, half) = (self.response().norm(), self.quantile * self.relative_sd);
        [size * (1.0 - half).max(0.0), size * (1.0 + half)]
    }

    /// Half width of the phase's 95 % interval in degrees; 180 where the phase is open.
    ///
    /// # Model
    /// arcsin of the magnitude's relative half width: the interval of the response is a disc around it.
    pub fn phase_half_width_deg(&self) -> f64 {
        let half = self.quantile * self.relative_sd;
        if half < 1.0 { half.asin().to_degrees() } else { 180.0 }
    }
}

/// Signals of one run from which a response is estimated, all sampled together.
#[derive(Debug, Clone, Copy)]
pub struct Signals<'a> {
    /// What was fed in from outside and depends on nothing in the loop; the input itself where no loop is closed.
    pub instrument: &'a [f64],
    /// Input of what is to be identified.
    pub input: &'a [f64],
    /// Its output.
    pub output: &'a [f64],
}

impl<'a> Signals<'a> {
    /// Signals without a loop: the input is its own instrument.
    pub fn direct(input: &'a [f64], output: &'a [f64]) -> Self {
        Self { instrument: input, input, output }
    }

    fn check(&self) -> Result<()> {
        check::same_length("input", self.input, "output", self.output)?;
        check::same_length("input", self.input, "instrument", self.instrument)?;
        check::finite("instrument", self.instrument)?;
        check::finite("input", self.input)?;
        check::finite("output", self.output)
    }
}

/// Frequency response H₁ of one run, see [`spectral`].
///
/// # Validity
/// Noise on the output only, no loop closed around the system: in closed loop H₁ leans towards the negative inverse of the
/// controller where the noise outweighs the excitation.
///
/// # Errors
/// As [`spectral`].
pub fn welch(
    input: &[f64],
    output: &[f64],
    sample_period_s: f64,
    segment_length: usize,
) -> Result<Vec<Point>> {
    spectral(&[Signals::direct(input, output)], sample_period_s, segment_length)
}

/// Frequency response with coherence and 95 % band by averaged windowed periodograms (Welch), segments overlapping by half,
/// over one run or several.
///
/// # Model
/// ```text
///   H = S_ry/S_ru,   γ² = min(|S_ry|²/(S_rr·S_yy), |S_ru|²/(S_rr·S_uu))
///   ε² = S_ee·S_rr/(2·(n − 1)·|S_ry|²),   S_ee = S_yy − 2·Re(H*·S_uy) + |H|²·S_uu
/// ```
/// from segments of `segment_length` samples less their mean under a Hann window; r is the instrument, u the input, y the output.
/// Where r is u this is H₁ and ε² = (1 − γ²)/(2·γ²·(n − 1)). n counts independent segments: of K that overlap by half,
/// K/(1 + 2ρ²(K − 1)/K) with ρ = 1/6. ε is the relative standard deviation of magnitude and, in rad, of phase; the quantile is
/// Student's with 2(n − 1) degrees of freedom. Frequencies m/(segment_length·T) for m = 1 … segment_length/2.
///
/// # Validity
/// Segments much longer than the impulse response. In closed loop r must not depend on the loop's noise: an injected voltage or
/// the reference, never the input itself. Look at the coherence first: where the instrument holds nothing the response is noise
/// over nothing.
///
/// # Source
/// Welch, IEEE Trans. Audio Electroacoust. 15, 1967; Bendat, Piersol, *Random Data*, 4th ed., sections 6.1 and 9.2; in closed
/// loop the indirect estimate of Ljung, *System Identification*, 2nd ed., section 13.5.
///
/// # Errors
/// No run, signals of unequal length, numbers that are not finite, fewer than four segments in all, segments below 8 samples.
pub fn spectral(runs: &[Signals], sample_period_s: f64, segment_length: usize) -> Result<Vec<Point>> {
    check::sample_period(sample_period_s)?;
    runs.iter().try_for_each(Signals::check)?;
    let lengths: Vec<usize> = runs.iter().map(|run| run.input.len()).collect();
    let starts = segment_starts(&lengths, segment_length)?;
    let window: Vec<f64> = (0..segment_length)
        .map(|k| (std::f64::consts::PI * k as f64 / segment_length as f64).sin().powi(2))
        .collect();
    let transform = Transform::new(segment_length);
    let mut sums = vec![Spectra::default(); segment_length / 2];
    for (run, start) in &starts {
        let cut = |signal: &[f64]| transform.of(&windowed(&signal[*start..start + segment_length], &window));
        let run = &runs[*run];
        let (r, u, y) = (cut(run.instrument)?, cut(run.input)?, cut(run.output)?);
        for (bin, sum) in sums.iter_mut().enumerate() {
            sum.add(r[bin + 1], u[bin + 1], y[bin + 1]);
        }
    }
    let count = starts.len() as f64;
    let independent = count / (1.0 + 2.0 * OVERLAP_CORRELATION_SQUARED * (count - 1.0) / count);
    let quantile = student_quantile((2.0 * (independent - 1.0)).round().max(1.0) as usize)?;
    let step_hz = 1.0 / (segment_length as f64 * sample_period_s);
    let strongest = sums.iter().map(|sum| sum.rr).fold(0.0, f64::max);
    let point = |(bin, sum): (usize, &Spectra)| {
        sum.point((bin + 1) as f64 * step_hz, independent, quantile, strongest)
    };
    Ok(sums.iter().enumerate().map(point).collect())
}

/// Sums of products of transforms over segments.
#[derive(Debug, Clone, Copy, Default)]
struct Spectra {
    rr: f64,
    uu: f64,
    yy: f64,
    ru: Complex<f64>,
    ry: Complex<f64>,
    uy: Complex<f64>,
}

impl Spectra {
    fn add(&mut self, r: Complex<f64>, u: Complex<f64>, y: Complex<f64>) {
        self.rr += r.norm_sqr();
        self.uu += u.norm_sqr();
        self.yy += y.norm_sqr();
        self.ru += r.conj() * u;
        self.ry += r.conj() * y;
        self.uy += u.conj() * y;
    }

    fn point(&self, frequency_hz: f64, independent: f64, quantile: f64, strongest: f64) -> Point {
        let nothing =
            Point { frequency_hz, re: 0.0, im: 0.0, coherence: 0.0, relative_sd: f64::INFINITY, quantile };
        if self.ru.norm() == 0.0 || self.ry.norm() == 0.0 || self.rr <= NOTHING * NOTHING * strongest {
            return nothing;
        }
        let response = self.ry / self.ru;
        let share = |cross: Complex<f64>, power: f64| (cross.norm_sqr() / (self.rr * power)).min(1.0);
        let coherence = share(self.ry, self.yy).min(share(self.ru, self.uu));
        let error = self.yy - 2.0 * (response.conj() * self.uy).re + response.norm_sqr() * self.uu;
        let variance = error.max(0.0) * self.rr / (2.0 * (independent - 1.0) * self.ry.norm_sqr());
        Point { re: response.re, im: response.im, coherence, relative_sd: variance.sqrt(), ..nothing }
    }
}

/// Frequency response at the lines of a periodic excitation, without leakage, with a band from the scatter of the periods.
///
/// # Model
/// With U_p, Y_p the discrete Fourier transforms of P whole periods at an excited line, over all runs:
/// ```text
///   H = ΣY_p·ū*/ΣU_p·ū*     (one run: mean of Y over mean of U)
///   s² = Σ|Y_p − H·U_p|²/(P − 1),   ε² = s²/(2·P·|H·Ū|²),   γ² = 1/(1 + s²/|H·Ū|²)
/// ```
/// The runs' means are weighted with their input. Noise of the loop averages out of Ū and Ȳ alike: the estimate holds in closed
/// loop too. Quantile: Student's with 2(P − 1) degrees of freedom.
///
/// # Validity
/// Steady periodic motion: the start must have died away before the first period that is used. Nothing drifts.
///
/// # Source
/// Pintelon, Schoukens (2012), *System Identification: A Frequency Domain Approach*, 2nd ed., sections 2.5 and 2.6.
///
/// # Errors
/// As [`spectral`]; fewer than two whole periods behind the `skipped` ones; a line outside 1 … period/2.
pub fn periodic(
    runs: &[(&[f64], &[f64])],
    sample_period_s: f64,
    period: usize,
    lines: &[usize],
    skipped: usize,
) -> Result<Vec<Point>> {
    check::sample_period(sample_period_s)?;
    for (input, output) in runs {
        Signals::direct(input, output).check()?;
    }
    check_lines(period, lines)?;
    let transform = Transform::new(period);
    let mut pairs = Vec::new();
    for (run, (input, output)) in runs.iter().enumerate() {
        let whole = input.chunks_exact(period).zip(output.chunks_exact(period)).skip(skipped);
        for (u, y) in whole {
            pairs.push((run, transform.of(u)?, transform.of(y)?));
        }
    }
    let count = pairs.len();
    if count < runs.len() + 1 || count < 2 {
        return Err(Error::new(ErrorKind::TooLittleData)
            .key("period")
            .found(format!("{count} whole periods of {period} samples in {} runs", runs.len()))
            .expected("at least two behind those in which the start dies away")
            .remedy("record more periods of the excitation"));
    }
    let quantile = student_quantile(2 * (count - 1))?;
    let step_hz = 1.0 / (period as f64 * sample_period_s);
    Ok(lines
        .iter()
        .map(|line| line_point(&pairs, runs.len(), *line, *line as f64 * step_hz, quantile))
        .collect())
}

/// Run, and transforms of input and output over one period.
type Period = (usize, Vec<Complex<f64>>, Vec<Complex<f64>>);

fn line_point(pairs: &[Period], runs: usize, line: usize, frequency_hz: f64, quantile: f64) -> Point {
    let mut means: Vec<Complex<f64>> = vec![Complex::default(); runs];
    pairs.iter().for_each(|(run, u, _)| means[*run] += u[line]);
    let (mut ru, mut ry): (Complex<f64>, Complex<f64>) = Default::default();
    let mut power = 0.0;
    for (run, u, y) in pairs {
        ru += means[*run].conj() * u[line];
        ry += means[*run].conj() * y[line];
        power += u[line].norm_sqr();
    }
    let nothing =
        Point { frequency_hz, re: 0.0, im: 0.0, coherence: 0.0, relative_sd: f64::INFINITY, quantile };
    if ru.norm() == 0.0 || ry.norm() == 0.0 {
        return nothing;
    }
    let (response, count): (Complex<f64>, f64) = (ry / ru, pairs.len() as f64);
    let apart = |(_, u, y): &Period| -> f64 { (y[line] - response * u[line]).norm_sqr() };
    let scatter: f64 = pairs.iter().map(apart).sum();
    let scatter = scatter / (count - 1.0);
    let size = response.norm_sqr() * power / count;
    Point {
        re: response.re,
        im: response.im,
        coherence: 1.0 / (1.0 + scatter / size),
        relative_sd: (scatter / (2.0 * count * size)).sqrt(),
        ..nothing
    }
}

fn check_lines(period: usize, lines: &[usize]) -> Result<()> {
    match lines.iter().find(|line| !(1..=period / 2).contains(*line)) {
        None if !lines.is_empty() => Ok(()),
        wrong => {
            Err(Error::new(ErrorKind::OutOfRange)
                .key("lines")
                .found(wrong.map_or("no line".to_owned(), |line| {
                    format!("line {line} of a period of {period} samples")
                }))
                .expected(format!("lines from 1 to {}", period / 2))
                .remedy("name the lines that the excitation holds"))
        }
    }
}

/// Run and first sample of every segment.
fn segment_starts(lengths: &[usize], segment_length: usize) -> Result<Vec<(usize, usize)>> {
    let refuse = |kind, found: String, expected: String| {
        Err(Error::new(kind)
            .key("segment_length")
            .found(found)
            .expected(expected)
            .remedy("record longer, or ask for shorter segments (coarser frequency steps)"))
    };
    if segment_length < 8 {
        return refuse(ErrorKind::OutOfRange, segment_length.to_string(), "at least 8 samples".into());
    }
    let hop = segment_length / 2;
    let of_run = |(run, samples): (usize, &usize)| {
        let samples = *samples;
        (0..).map(move |m| m * hop).take_while(move |s| s + segment_length <= samples).map(move |s| (run, s))
    };
    let starts: Vec<_> = lengths.iter().enumerate().flat_map(of_run).collect();
    if starts.len() < LEAST_SEGMENTS {
        let samples: usize = lengths.iter().sum();
        return refuse(
            ErrorKind::TooLittleData,
            format!("{} segments of {segment_length} in {samples} samples", starts.len()),
            format!("at least {LEAST_SEGMENTS} half-overlapping segments"),
        );
    }
    Ok(starts)
}

fn windowed(segment: &[f64], window: &[f64]) -> Vec<f64> {
    let mean = segment.iter().sum::<f64>() / segment.len() as f64;
    segment.iter().zip(window).map(|(x, w)| (x - mean) * w).collect()
}

/// The discrete Fourier transform of real signals of one length.
struct Transform(std::sync::Arc<dyn realfft::RealToComplex<f64>>);

impl Transform {
    fn new(length: usize) -> Self {
        Self(RealFftPlanner::new().plan_fft_forward(length))
    }

    fn of(&self, signal: &[f64]) -> Result<Vec<Complex<f64>>> {
        let mut samples = signal.to_vec();
        let mut spectrum = self.0.make_output_vec();
        self.0.process(&mut samples, &mut spectrum).map_err(|error| {
            Error::new(ErrorKind::Inconsistent).found(error.to_string()).expected("segments of one length")
        })?;
        Ok(spectrum)
    }
}
