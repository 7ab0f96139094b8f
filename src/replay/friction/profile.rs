//! The commanded motion of a run: strokes as their run states them, when they begin, what the logged reference tells.

use super::super::{Cell, Stroke};
use super::refused;
use crate::error::{ErrorKind, Result};
use crate::identify::nonlinear::{Unknown, solve};
use crate::recording::{Run, Signal};
use nalgebra::DVector;

/// An axis faster than this share of the feed moves.
const MOVES: f64 = 0.1;
/// Velocity is taken over so long to each side, in s.
const HALF_WIDTH_S: f64 = 5e-3;
/// A movement that covers less than this share of the stroke is no stroke: it settles.
const LEAST_SHARE: f64 = 0.5;
/// A stroke that is longer or shorter than stated by this share is another one.
const STROKE_TOLERANCE: f64 = 0.2;
/// A reference that is off a trapezoid of velocity by this share of the stroke (RMS) is none.
const TRAPEZOID: f64 = 1e-3;
/// Speeds of a reference that differ by less than this share are one.
const ONE_SPEED: f64 = 0.05;
/// What separates friction from what grows with speed.
const SPEEDS: &str = "record whole strokes from standstill to standstill; friction and viscous drag are not separable at one speed";

/// The commanded motion of a run.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Profile {
    /// Strokes with trapezoidal velocity whose acceleration time is to be found.
    Strokes(Strokes),
    /// The logged reference, whatever its shape.
    Logged(Vec<f64>),
}

/// Strokes of a run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Strokes {
    /// The strokes, those back with a negative sign.
    pub(super) strokes: Vec<Stroke>,
    /// When each begins, in s from the first sample: read off the reference, or a first guess.
    pub(super) start_s: Vec<f64>,
    /// Reference before the first stroke, m or rad.
    pub(super) base: f64,
    /// Acceleration time as the logged reference has it; starts and base are then its as well.
    pub(super) read_s: Option<f64>,
}

impl Strokes {
    /// The position reference with an acceleration time, starts and a base.
    pub(super) fn reference(&self, ramp_s: f64, starts: &[f64], base: f64, run: &Run) -> Vec<f64> {
        let period_s = run.sample_period_s();
        let at = |k: usize| {
            let time = k as f64 * period_s;
            let travelled =
                self.strokes.iter().zip(starts).map(|(s, start)| s.position(time - start, ramp_s));
            base + travelled.sum::<f64>()
        };
        (0..run.len()).map(at).collect()
    }
}

impl Profile {
    /// What a run states and logs of its commanded motion.
    pub(super) fn of(run: &Run, ramp_s: f64) -> Result<Self> {
        let logged = run.signal(Signal::PositionReference);
        let Some(cell) = Cell::of_run(run)? else {
            let reference = logged.ok_or_else(|| {
                refused(run, ErrorKind::Missing, Signal::PositionReference.key(run.motion()))
                    .found("a run with neither stroke and feed nor a position reference")
                    .expected("what the axis was told to do")
                    .remedy("state stroke and feed in its [[run]] (stroke_m and feed_m_per_min, or stroke_rad and feed_rad_per_s), or log the position reference")
            })?;
            check_speeds(run, reference)?;
            return Ok(Self::Logged(reference.to_vec()));
        };
        let stroke = cell.stroke(run.motion())?;
        let position = run.require(Signal::Position)?;
        let moves = movements(run, position, stroke)?;
        let middle = |(middle_s, sign): &(f64, f64)| {
            let stroke = Stroke { stroke: stroke.stroke.abs() * sign, feed: stroke.feed };
            (stroke, middle_s - 0.5 * stroke.duration_s(ramp_s))
        };
        let (strokes, start_s) = moves.iter().map(middle).unzip();
        let guess = Strokes { strokes, start_s, base: position[0], read_s: None };
        let Some(reference) = logged else { return Ok(Self::Strokes(guess)) };
        match read(run, reference, &guess, ramp_s)? {
            Some(read) => Ok(Self::Strokes(read)),
            None => {
                check_speeds(run, reference)?;
                Ok(Self::Logged(reference.to_vec()))
            }
        }
    }
}

/// Middle in s and direction of each stroke that the measured position shows.
fn movements(run: &Run, position: &[f64], stroke: Stroke) -> Result<Vec<(f64, f64)>> {
    let period_s = run.sample_period_s();
    let half = ((HALF_WIDTH_S / period_s).round() as usize).max(1);
    let last = position.len() - 1;
    let velocity = |k: usize| {
        let (from, to) = (k.saturating_sub(half), (k + half).min(last));
        (position[to] - position[from]) / ((to - from).max(1) as f64 * period_s)
    };
    let sign = |k: usize| {
        let v = velocity(k);
        if v.abs() > MOVES * stroke.feed { v.signum() } else { 0.0 }
    };
    let signs: Vec<f64> = (0..position.len()).map(sign).collect();
    let (mut found, mut from) = (Vec::new(), 0);
    for stretch in signs.chunk_by(|a, b| a == b) {
        let to = from + stretch.len();
        let travelled = position[to.min(last)] - position[from];
        if stretch[0] != 0.0 && travelled.abs() > LEAST_SHARE * stroke.stroke.abs() {
            if from <= half || to + half > last {
                return Err(refused(run, ErrorKind::Undetermined, "position")
                    .found("a stroke whose beginning or end lies outside the run, or one speed all the time")
                    .expected("strokes from standstill to standstill")
                    .remedy(SPEEDS));
            }
            let middle =
                position[from..to].iter().position(|x| (x - position[from]).abs() > 0.5 * travelled.abs());
            found.push(((from + middle.unwrap_or(0)) as f64 * period_s, stretch[0], travelled.abs()));
        }
        from = to;
    }
    let Some(longest) = found.iter().map(|(.., travelled)| *travelled).reduce(f64::max) else {
        return Err(refused(run, ErrorKind::Undetermined, "position")
            .found("an axis that does not make the stated stroke at anything like the stated feed")
            .expected(format!("a stroke of {} at {} (SI)", stroke.stroke, stroke.feed))
            .remedy(
                "friction does not show at standstill: record strokes, or correct stroke and feed of the run",
            ));
    };
    if (longest / stroke.stroke.abs() - 1.0).abs() > STROKE_TOLERANCE {
        return Err(refused(run, ErrorKind::Inconsistent, "stroke")
            .found(format!("an axis that travels {longest:.4} and a stated stroke of {}", stroke.stroke))
            .expected("the same distance")
            .remedy("correct stroke and feed of the run, or the unit of the position column"));
    }
    Ok(found.into_iter().map(|(middle, sign, _)| (middle, sign)).collect())
}

/// Acceleration time, starts and base as the logged reference has them, by least squares; none where it is no trapezoid.
fn read(run: &Run, reference: &[f64], guess: &Strokes, ramp_s: f64) -> Result<Option<Strokes>> {
    let period_s = run.sample_period_s();
    let begins = starts(reference, guess.strokes.len());
    let Some(begins) = begins else { return Ok(None) };
    let unknown = |name: &str, start, range, step| Unknown { name: name.to_owned(), start, range, step };
    let end = run.duration_s();
    let shortest = guess.strokes.iter().map(|s| s.stroke.abs() / s.feed).fold(f64::INFINITY, f64::min);
    let mut unknowns =
        vec![unknown("acceleration time", ramp_s, (period_s, 10.0 * shortest), 0.1 * period_s)];
    unknowns.extend(
        begins.iter().map(|k| unknown("start", (*k as f64 - 1.0) * period_s, (-end, end), 0.1 * period_s)),
    );
    let residuals = |values: &[f64]| {
        let model = guess.reference(values[0], &values[1..], reference[0], run);
        Ok(DVector::from_iterator(model.len(), model.iter().zip(reference).map(|(m, r)| m - r)))
    };
    let Some(found) = solve(&unknowns, SPEEDS, residuals)?.identified() else { return Ok(None) };
    let rms = found.residuals.norm() / (reference.len() as f64).sqrt();
    let longest = guess.strokes.iter().map(|s| s.stroke.abs()).fold(0.0, f64::max);
    Ok((rms < TRAPEZOID * longest).then(|| Strokes {
        strokes: guess.strokes.clone(),
        start_s: found.values[1..].to_vec(),
        base: reference[0],
        read_s: Some(found.values[0]),
    }))
}

/// First moving sample of each of so many strokes; none where the reference makes another number of them.
fn starts(reference: &[f64], strokes: usize) -> Option<Vec<usize>> {
    let (mut found, mut before) = (Vec::new(), 0.0);
    for (k, pair) in reference.windows(2).enumerate() {
        let step = pair[1] - pair[0];
        if step != 0.0 && step * before <= 0.0 {
            found.push(k + 1);
        }
        before = step;
    }
    (found.len() == strokes).then_some(found)
}

/// Refuses a reference that stands still or moves at one speed.
fn check_speeds(run: &Run, reference: &[f64]) -> Result<()> {
    let steps = || reference.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let (least, most) = steps().fold((f64::INFINITY, 0.0_f64), |(a, b), step| (a.min(step), b.max(step)));
    if most > 0.0 && least < (1.0 - ONE_SPEED) * most {
        return Ok(());
    }
    let found = if most > 0.0 { "a reference of one speed" } else { "a reference that stands still" };
    Err(refused(run, ErrorKind::Undetermined, Signal::PositionReference.key(run.motion()))
        .found(found)
        .expected("a motion at several speeds")
        .remedy(SPEEDS))
}
