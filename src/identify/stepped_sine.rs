//! Gain and phase from runs of one sine each: the settled part, by peaks or by the fundamental.

use std::f64::consts::{FRAC_PI_8, TAU};
use std::ops::Range;

use nalgebra::{Complex, DMatrix, DVector};

use super::check;
use super::frequency_response::Point;
use super::least_squares::student_quantile;
use crate::error::{Error, ErrorKind, Result};
use crate::recording::{Run, Signal};

/// Key of a run's metadata that states the frequency of its sine, in Hz.
pub const FREQUENCY_KEY: &str = "excitation_frequency_hz";

/// Share of a run at its end that is taken as settled.
const SETTLED_SHARE: f64 = 0.5;
/// Whole periods that the settled part must hold.
const LEAST_PERIODS: usize = 2;
/// Samples that a period must have.
const LEAST_SAMPLES: f64 = 6.0;
/// Relative change of an amplitude from one half of the settled part to the other that still counts as settled.
const STEADY: f64 = 5e-3;
/// And in standard errors of that change.
const STEADY_STANDARD_ERRORS: f64 = 5.0;
/// A sine is told to be one where it holds this share of the input's power.
const LEAST_SHARE: f64 = 0.5;

/// What the gain of a sine is taken from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gain {
    /// Half the distance of the highest and the lowest value of each period, averaged.
    Peaks,
    /// The component at the frequency of the sine.
    Fundamental,
}

/// One run of a sine.
#[derive(Debug, Clone, PartialEq)]
pub struct Sine {
    /// Name of the run.
    pub run: String,
    /// Gain and phase; the coherence is the share of the output's power that the sine holds.
    pub point: Point,
    /// Amplitude of the input, in its unit.
    pub input_amplitude: f64,
    /// Amplitude of the output, in its unit.
    pub output_amplitude: f64,
    /// Settled periods.
    pub periods: usize,
}

/// Gain and phase of runs that each hold one sine; by rising frequency.
///
/// # Model
/// The last half of a run, in whole periods. There both signals are fitted by least squares with
/// `c + d·t + a·cos ωt + b·sin ωt`; phase and [`Gain::Fundamental`] are those of the ratio. [`Gain::Peaks`] is the ratio of the
/// mean half distances of the extremes of each period, an extreme being the vertex of a parabola through the samples
/// within π/8 of it. ω is what the run states under [`FREQUENCY_KEY`], else what suits the input best.
///
/// # Validity
/// Steady state: refused where an amplitude still changes by more than 0.5 % (and its noise) over the settled part. Peaks and
/// fundamental agree for a linear system; with dry friction they do not. Noise raises peaks, a drift shifts them. With a loop closed around
/// the system the ratio is still that of the signals, as far as they are free of noise.
///
/// # Errors
/// Signals that are missing, uneven time stamps, runs that are too short, not settled, or no sine.
pub fn sines(runs: &[&Run], input: Signal, output: Signal, gain: Gain) -> Result<Vec<Sine>> {
    let mut found = runs.iter().map(|run| of_run(run, input, output, gain)).collect::<Result<Vec<_>>>()?;
    found.sort_by(|a, b| a.point.frequency_hz.total_cmp(&b.point.frequency_hz));
    Ok(found)
}

fn of_run(run: &Run, input: Signal, output: Signal, gain: Gain) -> Result<Sine> {
    run.require_even("a sweep")?;
    if [input, output].contains(&Signal::ControlEffort) {
        run.require_whole_effort("a sweep")?;
    }
    let (u, y) = (run.require(input)?, run.require(output)?);
    let period_s = run.sample_period_s();
    let stated = run.metadata.get(FREQUENCY_KEY).and_then(toml::Value::as_float);
    let named = |error: Error| {
        let keyed = error.key(format!("{}: {}", run.name(), input.key(run.motion())));
        if run.file.as_os_str().is_empty() { keyed } else { keyed.file(&run.file) }
    };
    let frequency_hz = match stated {
        Some(frequency) => frequency,
        None => frequency(u, period_s).ok_or_else(|| named(no_sine("a signal that does not oscillate")))?,
    };
    let sine = settled(u, y, period_s, frequency_hz, gain).map_err(named)?;
    Ok(Sine { run: run.name().to_owned(), ..sine })
}

/// One sine of known frequency in plain signals.
///
/// # Errors
/// As [`sines`].
pub fn settled(u: &[f64], y: &[f64], period_s: f64, frequency_hz: f64, gain: Gain) -> Result<Sine> {
    check::sample_period(period_s)?;
    check::same_length("input", u, "output", y)?;
    check::finite("input", u)?;
    check::finite("output", y)?;
    let samples_per_period = 1.0 / (frequency_hz * period_s);
    if !(frequency_hz > 0.0 && samples_per_period >= LEAST_SAMPLES) {
        return Err(Error::new(ErrorKind::OutOfRange)
            .found(format!("a sine of {frequency_hz} Hz sampled every {period_s} s"))
            .expected(format!("a frequency above 0 and at least {LEAST_SAMPLES} samples a period"))
            .remedy("sample faster, or leave this frequency out"));
    }
    let periods = (SETTLED_SHARE * u.len() as f64 / samples_per_period).floor() as usize;
    if periods < LEAST_PERIODS {
        return Err(Error::new(ErrorKind::TooLittleData)
            .found(format!(
                "{periods} whole periods of {frequency_hz:.4} Hz in the last half of {} s",
                u.len() as f64 * period_s
            ))
            .expected(format!("at least {LEAST_PERIODS}: the first half is for the start to die away"))
            .remedy("record this frequency longer"));
    }
    let window = tail(u.len(), periods as f64 * samples_per_period);
    let omega = TAU * frequency_hz * period_s;
    let (input, output) =
        (Component::of(&u[window.clone()], omega), Component::of(&y[window.clone()], omega));
    if input.share < LEAST_SHARE {
        return Err(no_sine(&format!(
            "{:.0} % of the input's power at {frequency_hz:.4} Hz",
            100.0 * input.share
        )));
    }
    for (word, signal) in [("input", u), ("output", y)] {
        steady(word, &signal[window.clone()], omega)?;
    }
    let ratio = output.phasor / input.phasor;
    let [input_amplitude, output_amplitude] = match gain {
        Gain::Fundamental => [input.phasor.norm(), output.phasor.norm()],
        Gain::Peaks => [u, y].map(|signal| peaks(&signal[window.clone()], samples_per_period, periods)),
    };
    let size = output_amplitude / input_amplitude;
    let relative_sd = input.relative_sd.hypot(output.relative_sd);
    let response = Complex::from_polar(size, ratio.arg());
    Ok(Sine {
        run: String::new(),
        point: Point {
            frequency_hz,
            re: response.re,
            im: response.im,
            coherence: output.share,
            relative_sd,
            quantile: student_quantile(window.len().saturating_sub(4).max(1))?,
        },
        input_amplitude,
        output_amplitude,
        periods,
    })
}

fn no_sine(found: &str) -> Error {
    Error::new(ErrorKind::Undetermined)
        .found(found.to_owned())
        .expected("one sine a run, settled in its last half")
        .remedy(format!("state the frequency of each run under {FREQUENCY_KEY}; of other excitations `slideway identify response` finds the response"))
}

/// The last samples of a signal, as many as a length asks for.
fn tail(samples: usize, length: f64) -> Range<usize> {
    samples - (length.round() as usize).min(samples)..samples
}

/// A signal's component at one frequency.
struct Component {
    /// Amplitude and phase at the first sample.
    phasor: Complex<f64>,
    /// Share of the power about line and mean that it holds.
    share: f64,
    /// One standard deviation of the amplitude over the amplitude, for white noise.
    relative_sd: f64,
}

impl Component {
    /// Least squares of c + d·t + a·cos ωk + b·sin ωk.
    fn of(signal: &[f64], omega: f64) -> Self {
        let count = signal.len() as f64;
        let row = |k: usize| {
            let (sin, cos) = (omega * k as f64).sin_cos();
            [1.0, k as f64 / count - 0.5, cos, sin]
        };
        let mut normal: DMatrix<f64> = DMatrix::zeros(4, 4);
        let mut right: DVector<f64> = DVector::zeros(4);
        for (k, value) in signal.iter().enumerate() {
            let row = row(k);
            for i in 0..4 {
                right[i] += row[i] * value;
                (0..4).for_each(|j| normal[(i, j)] += row[i] * row[j]);
            }
        }
        let found = normal.cholesky().map_or_else(|| DVector::zeros(4), |triangle| triangle.solve(&right));
        let (mut power, mut left): (f64, f64) = (0.0, 0.0);
        for (k, value) in signal.iter().enumerate() {
            let [_, place, cos, sin] = row(k);
            let line = found[0] + found[1] * place;
            power += (value - line).powi(2);
            left += (value - line - found[2] * cos - found[3] * sin).powi(2);
        }
        let phasor = Complex::new(found[2], -found[3]);
        let share = if power > 0.0 { 1.0 - left / power } else { 0.0 };
        let variance = left / (count - 4.0).max(1.0);
        let relative_sd = (2.0 * variance / count).sqrt() / phasor.norm().max(f64::MIN_POSITIVE);
        Self { phasor, share, relative_sd }
    }
}

/// Refuses a signal whose amplitude changes from one half to the other.
fn steady(word: &str, signal: &[f64], omega: f64) -> Result<()> {
    let (early, late) = signal.split_at(signal.len() / 2);
    let (early, late) = (Component::of(early, omega), Component::of(late, omega));
    let change = late.phasor.norm() / early.phasor.norm() - 1.0;
    let allowed = STEADY + STEADY_STANDARD_ERRORS * early.relative_sd.hypot(late.relative_sd);
    if change.abs() <= allowed {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Undetermined)
        .found(format!(
            "an amplitude of the {word} that changes by {:+.2} % over the last half of the run",
            100.0 * change
        ))
        .expected(format!("a settled sine: less than {:.2} %", 100.0 * allowed))
        .remedy("record this frequency longer, with its amplitude constant"))
}

/// Mean half distance of the extremes of each period.
fn peaks(signal: &[f64], samples_per_period: f64, periods: usize) -> f64 {
    let half = (FRAC_PI_8 / TAU * samples_per_period).max(1.5);
    let one = |period: usize| {
        let from = (period as f64 * samples_per_period).round() as usize;
        let to = (((period + 1) as f64 * samples_per_period).round() as usize).min(signal.len());
        let highest = (from..to).max_by(|a, b| signal[*a].total_cmp(&signal[*b])).unwrap_or(from);
        let lowest = (from..to).min_by(|a, b| signal[*a].total_cmp(&signal[*b])).unwrap_or(from);
        0.5 * (vertex(signal, highest, half) - vertex(signal, lowest, half))
    };
    (0..periods).map(one).sum::<f64>() / periods as f64
}

/// The extreme value near a sample: the vertex of the parabola through its surroundings.
fn vertex(signal: &[f64], middle: usize, half: f64) -> f64 {
    let reach = half.round() as usize;
    // The surroundings are as wide to one side as to the other: a period may end beside its extreme.
    let reach = reach.min(middle).min(signal.len() - 1 - middle);
    if reach == 0 {
        return signal[middle];
    }
    let (mut moments, mut right): (DMatrix<f64>, DVector<f64>) = (DMatrix::zeros(3, 3), DVector::zeros(3));
    for (k, value) in signal.iter().enumerate().take(middle + reach + 1).skip(middle - reach) {
        let x = (k as f64 - middle as f64) / reach as f64;
        let row = [1.0, x, x * x];
        for i in 0..3 {
            right[i] += row[i] * value;
            (0..3).for_each(|j| moments[(i, j)] += row[i] * row[j]);
        }
    }
    match moments.cholesky().map(|triangle| triangle.solve(&right)) {
        Some(c) if c[2] != 0.0 && (0.5 * c[1] / c[2]).abs() <= 1.0 => c[0] - 0.25 * c[1] * c[1] / c[2],
        _ => signal[middle],
    }
}

/// Standing above this share of the largest value counts as high, below its negative as low.
const SWING: f64 = 0.3;
/// Steps of the golden section.
const SECTIONS: usize = 40;

/// The frequency in Hz of the sine that suits the last half of a signal best; none where it does not oscillate.
fn frequency(signal: &[f64], period_s: f64) -> Option<f64> {
    let part = &signal[signal.len() / 2..];
    let mean = part.iter().sum::<f64>() / part.len().max(1) as f64;
    let largest = part.iter().fold(0.0, |most: f64, x| most.max((x - mean).abs()));
    let (mut rises, mut is_low) = (Vec::new(), false);
    for (k, value) in part.iter().enumerate() {
        let value = value - mean;
        if is_low && value > SWING * largest {
            rises.push(k);
            is_low = false;
        }
        is_low |= value < -SWING * largest;
    }
    let (first, last) = (rises.first()?, rises.last()?);
    if rises.len() < LEAST_PERIODS {
        return None;
    }
    let coarse = (rises.len() - 1) as f64 / (last - first) as f64;
    let width = 0.5 / part.len() as f64;
    let left = |turns: f64| 1.0 - Component::of(part, TAU * turns).share;
    let (mut low, mut high) = ((coarse - width).max(0.1 * coarse), coarse + width);
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..SECTIONS {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if left(a) < left(b) { high = b } else { low = a }
    }
    Some(0.5 * (low + high) / period_s)
}
