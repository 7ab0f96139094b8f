//! Frequency response of the machine and of its twins, with coherence.

use super::RunTraces;
use super::spectrum::density;
use super::traces::Trace;
use crate::identify::frequency_response::{Point, welch};
use crate::recording::Signal;

/// Output over input of one held-out run.
#[derive(Debug, Clone)]
pub struct Response {
    /// Input.
    pub input: Signal,
    /// Output.
    pub output: Signal,
    /// The run.
    pub run: String,
    /// Beyond this, in Hz, noise outweighs the motion, and a response in closed loop is the controller's.
    pub highest_hz: f64,
    /// Measured.
    pub measured: Vec<Point>,
    /// Of the twin as it is; empty where there is no twin.
    pub before: Vec<Point>,
    /// Of the twin with its causes; empty where there is no twin.
    pub after: Vec<Point>,
}

/// Samples that are looked at.
const MOST: usize = 40_000;
/// Segments overlap by half; so many make a coherence.
const SEGMENTS: usize = 7;
const LONGEST: usize = 2048;

/// Highest frequency in Hz at which the input holds more motion than what the twin misses; half the sample rate without a twin.
fn highest(input: &Trace, period_s: f64) -> f64 {
    let noise: Vec<f64> = input.measured.iter().zip(&input.after).map(|(m, p)| m - p).collect();
    let count = noise.len();
    let (motion, noise) = (density(&input.after, period_s), density(&noise, period_s));
    // A tenth of a decade is looked at together: single lines scatter, and motions have gaps in their spectrum.
    let (mut from, mut last) = (2, 2);
    while from < noise.len() {
        let to = (from + from / 4 + 1).min(noise.len());
        let sum = |lines: &[f64]| lines[from..to].iter().sum::<f64>();
        if sum(&motion) > sum(&noise) {
            last = to;
        }
        from = to;
    }
    if noise.is_empty() { 0.5 / period_s } else { last as f64 / (count as f64 * period_s) }
}

impl Response {
    /// The response from the motor's effort to the motion; none where either was not logged or too little was.
    pub fn of(runs: &[RunTraces]) -> Option<Self> {
        let run =
            runs.iter().filter(|run| run.is_held_out || runs.len() == 1).max_by_key(|run| run.samples())?;
        let find = |signals: &[Signal]| signals.iter().find_map(|signal| run.trace(*signal));
        let effort = if run.is_fed_forward { &[][..] } else { &[Signal::ControlEffort] };
        let input = find(effort).or_else(|| find(&[Signal::Current, Signal::Thrust]))?;
        let output = find(&[Signal::Velocity, Signal::Position])?;
        let samples = input.measured.len().min(MOST);
        let length = (samples / (SEGMENTS / 2 + 1)).min(LONGEST);
        let length = if length < 8 { return None } else { 1usize << length.ilog2() };
        let response = |of: fn(&Trace) -> &Vec<f64>| {
            let (u, y) = (of(input), of(output));
            let count = samples.min(u.len()).min(y.len());
            welch(&u[..count], &y[..count], run.period_s, length).unwrap_or_default()
        };
        let measured = response(|trace| &trace.measured);
        let highest_hz = highest(input, run.period_s).max(8.0 / (length as f64 * run.period_s));
        let below = |mut points: Vec<Point>| {
            points.retain(|point| point.frequency_hz <= highest_hz);
            points
        };
        (!measured.is_empty()).then(|| Self {
            input: input.signal,
            output: output.signal,
            run: run.name.clone(),
            highest_hz,
            before: below(response(|trace| &trace.before)),
            after: below(response(|trace| &trace.after)),
            measured: below(measured),
        })
    }
}
