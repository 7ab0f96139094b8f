//! Plant, open loop, closed loop and structure from the recorded signals of a loop.

use nalgebra::Complex;

use super::frequency_response::{Point, Signals, periodic, spectral};
use crate::error::{Error, ErrorKind, Result};
use crate::recording::{Run, Signal};

/// Key of a run's metadata that states the period of a periodic excitation, in s.
pub const PERIOD_KEY: &str = "excitation_period_s";
/// Key of a run's metadata that states the band of an excitation, in Hz.
pub const BAND_KEY: &str = "excitation_band_hz";

/// Time in which the start of a periodic excitation dies away, in s, as far as the run is long enough.
const START_S: f64 = 2.0;
/// Segments that there are about in all where no resolution is asked for.
const SEGMENTS: usize = 8;
/// Longest segment where no resolution is asked for, in samples.
const LONGEST_SEGMENT: usize = 8192;
/// Fewest samples of a segment.
const LEAST_SEGMENT: f64 = 8.0;
/// Coherence from which on a point belongs to a measured response.
pub const COHERENT: f64 = 0.8;

/// Which response of the loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// G: effort to position.
    Plant,
    /// L: effort to what the controller answers, its sign turned.
    OpenLoop,
    /// Position reference to position.
    ClosedLoop,
    /// Motor force to position.
    Structure,
}

impl Part {
    /// What it is called.
    pub fn word(self) -> &'static str {
        match self {
            Self::Plant => "plant",
            Self::OpenLoop => "open loop",
            Self::ClosedLoop => "closed loop",
            Self::Structure => "structure",
        }
    }
}

/// A measured response and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// The response, by frequency.
    pub points: Vec<Point>,
    /// What was fed in from outside.
    pub instrument: Signal,
    /// Whether whole periods of a periodic excitation were averaged; windowed segments otherwise.
    pub is_periodic: bool,
}

impl Measured {
    /// The response in series with another one that is known exactly: bands and coherence stay.
    #[must_use]
    pub fn times(mut self, known: impl Fn(f64) -> Complex<f64>) -> Self {
        for point in &mut self.points {
            let product = point.response() * known(point.frequency_hz);
            (point.re, point.im) = (product.re, product.im);
        }
        self
    }

    /// The longest part of the band without a gap in coherence.
    pub fn coherent(&self) -> &[Point] {
        let runs = self.points.split(|p| p.coherence < COHERENT || !p.relative_sd.is_finite());
        runs.max_by_key(|run| run.len()).unwrap_or_default()
    }
}

/// A response of the loop from its recorded runs.
///
/// # Model
/// - plant: S_rx/S_ru, from effort u to position x, with r as instrument
/// - open loop: S_ra/S_ru with a = d − u, what the controller answers to the effort u, d being the injected voltage
/// - closed loop: position over position reference
/// - structure: S_rx/S_rF with the motor's force F
///
/// r is the injected voltage where every run has one that moves, otherwise the position reference. Where every run states the
/// period of its excitation whole periods are averaged, see [`periodic`]; otherwise windowed segments, see [`spectral`],
/// of all signals differenced once where r is a reference: its ends would leak, and what is common to all signals cancels.
///
/// # Validity
/// r must not depend on the loop's noise. Strokes hold little above some ten Hz: look at coherence and band.
///
/// # Source
/// Ljung, *System Identification: Theory for the User*, 2nd ed., section 13.5 (indirect and joint input-output identification).
///
/// # Errors
/// No run; a signal that is missing; nothing that excites; an open loop without injected voltage; too short runs; a resolution
/// that is not > 0 or that the runs do not have.
pub fn measured(runs: &[&Run], part: Part, resolution_hz: Option<f64>) -> Result<Measured> {
    let Some(first) = runs.first() else {
        return Err(Error::new(ErrorKind::TooLittleData).key("run").found("no run").expected("at least one"));
    };
    if let Some(resolution) =
        resolution_hz.filter(|resolution| !(resolution.is_finite() && *resolution > 0.0))
    {
        return Err(Error::new(ErrorKind::OutOfRange)
            .key("--resolution")
            .found(resolution.to_string())
            .expected("a distance of the frequencies in Hz above 0")
            .remedy("give for instance 0.5"));
    }
    let instrument = instrument(runs, part)?;
    let triples = runs.iter().map(|run| signals(run, part, instrument)).collect::<Result<Vec<_>>>()?;
    let period_s = first.sample_period_s();
    if let Some((period, lines)) = period_of(runs) {
        let skipped = skipped(runs, period);
        let pairs: Vec<(&[f64], &[f64])> = triples.iter().map(|[_, u, y]| (&u[..], &y[..])).collect();
        let points = periodic(&pairs, period_s, period, &lines, skipped)?;
        return Ok(Measured { points, instrument, is_periodic: true });
    }
    let differenced = |signal: &Vec<f64>| -> Vec<f64> {
        match instrument {
            Signal::PositionReference => signal.windows(2).map(|pair| pair[1] - pair[0]).collect(),
            _ => signal.clone(),
        }
    };
    let triples: Vec<[Vec<f64>; 3]> = triples.iter().map(|three| three.each_ref().map(differenced)).collect();
    let lengths = || triples.iter().map(|[r, ..]| r.len());
    let (total, shortest) = (lengths().sum::<usize>(), lengths().min().unwrap_or_default());
    let length = match resolution_hz {
        Some(resolution) => segment(resolution, period_s, shortest)?,
        // Strokes begin and end at rest: a segment as long as a run leaks least.
        None => (2 * total / (SEGMENTS + 1)).min(shortest).min(LONGEST_SEGMENT),
    };
    let signals: Vec<Signals> =
        triples.iter().map(|[r, u, y]| Signals { instrument: r, input: u, output: y }).collect();
    Ok(Measured { points: spectral(&signals, period_s, length)?, instrument, is_periodic: false })
}

/// Samples of a segment that resolves so finely.
fn segment(resolution_hz: f64, period_s: f64, shortest: usize) -> Result<usize> {
    let samples = 1.0 / (resolution_hz * period_s);
    if (LEAST_SEGMENT..=shortest as f64).contains(&samples.round()) {
        return Ok(samples.round() as usize);
    }
    let [finest, coarsest] = [shortest as f64, LEAST_SEGMENT].map(|samples| 1.0 / (samples * period_s));
    Err(Error::new(ErrorKind::OutOfRange)
        .key("--resolution")
        .found(format!("{resolution_hz}"))
        .expected(format!("a distance in Hz from {finest:.3} (the shortest run) to {coarsest:.1}"))
        .remedy("leave --resolution out to have it chosen by the recording's length"))
}

/// What excites the loop from outside in every run.
fn instrument(runs: &[&Run], part: Part) -> Result<Signal> {
    let moves = |signal: Signal| {
        runs.iter().all(|run| {
            run.signal(signal).is_some_and(|samples| samples.windows(2).any(|pair| pair[0] != pair[1]))
        })
    };
    let wanted: &[Signal] = match part {
        Part::Plant | Part::Structure => &[Signal::DisturbanceVoltage, Signal::PositionReference],
        Part::OpenLoop => &[Signal::DisturbanceVoltage],
        Part::ClosedLoop => &[Signal::PositionReference],
    };
    wanted.iter().copied().find(|signal| moves(*signal)).ok_or_else(|| {
        let motion = runs[0].motion();
        let keys: Vec<&str> = wanted.iter().map(|signal| signal.key(motion)).collect();
        Error::new(ErrorKind::Missing)
            .file(&runs[0].file)
            .key(keys[0])
            .found(format!(
                "runs without a {} that moves, so nothing excites the {}",
                keys.join(" or "),
                part.word()
            ))
            .expected("a signal fed in from outside, recorded with the others")
            .remedy("record a multisine (slideway identify multisine), or ask for another response with --of")
    })
}

/// Instrument, input and output of a run.
fn signals(run: &Run, part: Part, instrument: Signal) -> Result<[Vec<f64>; 3]> {
    run.require_even("a frequency response")?;
    let [r, x] = [run.require(instrument)?, run.require(Signal::Position)?].map(<[f64]>::to_vec);
    if part != Part::Structure {
        run.require_whole_effort("a frequency response of plant or loop")?;
    }
    Ok(match part {
        Part::Plant => [r, run.require(Signal::ControlEffort)?.to_vec(), x],
        Part::Structure => [r, run.require(Signal::Thrust)?.to_vec(), x],
        Part::ClosedLoop => [r.clone(), r, x],
        Part::OpenLoop => {
            let effort = run.require(Signal::ControlEffort)?.to_vec();
            let answered = r.iter().zip(&effort).map(|(d, u)| d - u).collect();
            [r, effort, answered]
        }
    })
}

/// Samples of the stated period and its lines in the stated band, where all runs state the same.
fn period_of(runs: &[&Run]) -> Option<(usize, Vec<usize>)> {
    let stated = |run: &Run| -> Option<(f64, [f64; 2])> {
        let number = |value: &toml::Value| value.as_float().or(value.as_integer().map(|n| n as f64));
        let band = run.metadata.get(BAND_KEY)?.as_array()?;
        Some((number(run.metadata.get(PERIOD_KEY)?)?, [number(band.first()?)?, number(band.get(1)?)?]))
    };
    let (period_s, [from, to]) = stated(runs.first()?)?;
    let is_same = runs.iter().all(|run| stated(run) == Some((period_s, [from, to])));
    let samples = (period_s / runs[0].sample_period_s()).round();
    if !is_same || !(8.0..1e8).contains(&samples) {
        return None;
    }
    let lines =
        ((from * period_s - 1e-6).ceil().max(1.0) as usize)..=((to * period_s + 1e-6).floor() as usize);
    let lines: Vec<usize> = lines.filter(|line| *line <= samples as usize / 2).collect();
    (!lines.is_empty()).then_some((samples as usize, lines))
}

/// Periods at the beginning in which the start dies away; two are always left.
fn skipped(runs: &[&Run], period: usize) -> usize {
    let shortest = runs.iter().map(|run| run.len() / period).min().unwrap_or_default();
    let start = (START_S / (period as f64 * runs[0].sample_period_s())).ceil() as usize;
    start.min(shortest.saturating_sub(2))
}
