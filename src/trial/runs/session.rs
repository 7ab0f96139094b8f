//! Sessions drawn: what one case records.

use super::bounds::{Bounds, FEED_SPREAD};
use super::{LEAD_S, Line, Move, Movement, TrialRun};
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::{Role, one_after_another};
use rand::RngExt;
use rand::rngs::StdRng;
use std::f64::consts::TAU;

/// A session of tests lasts at most so long, in s, …
pub const MOST_SESSION_S: f64 = 20.0;
/// … and one of production so long.
pub const MOST_PRODUCTION_S: f64 = 300.0;
/// Where it would be longer, strokes are this much shorter, …
const SHORTER: f64 = 0.75;
/// … at most so many times: standstills remain.
const MOST_SHORTER: usize = 12;
/// Lengths of jogs as shares of a stroke.
const JOGS: (f64, f64) = (0.05, 0.6);
/// Frequencies of sines and of multisines in Hz, at least [`LEAST_SAMPLES`] a period.
const SINES_HZ: (f64, f64) = (0.8, 5.0);
const LINES_HZ: (f64, f64) = (0.8, 12.0);
const LEAST_SAMPLES: f64 = 20.0;
/// Peaks of sines and multisines as shares of half a stroke.
const PEAKS: (f64, f64) = (0.3, 1.0);
/// Sampled peaks stay so far below what is allowed: amplitudes are rounded.
const FIT: f64 = 0.98;
/// How long production goes on, in s.
const PRODUCTION_S: (f64, f64) = (120.0, 0.95 * MOST_PRODUCTION_S);
/// Pieces that a production is cut to.
const PRODUCTION_PIECES: (usize, usize) = (8, 14);

/// How a session is made up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Layout {
    /// Strokes there and back at three feeds, as an acceptance test has them.
    AcceptanceStrokes,
    /// One run that holds everything.
    SingleRun,
    /// Three runs.
    ThreeRuns,
    /// Jogs and sines.
    JogsAndSine,
    /// Multisines and strokes.
    MultisineAndStrokes,
    /// Production cut to pieces.
    Production,
}

impl Layout {
    /// Every layout, with the share of cases that have it.
    pub const SHARES: [(Self, f64); 6] = [
        (Self::AcceptanceStrokes, 0.4),
        (Self::SingleRun, 0.15),
        (Self::ThreeRuns, 0.15),
        (Self::JogsAndSine, 0.1),
        (Self::MultisineAndStrokes, 0.1),
        (Self::Production, 0.1),
    ];

    /// A session lasts at most so long, in s.
    pub fn longest_s(self) -> f64 {
        if self == Self::Production { MOST_PRODUCTION_S } else { MOST_SESSION_S }
    }

    fn draw(random: &mut StdRng) -> Self {
        let mut left = random.random_range(0.0..1.0);
        for (layout, share) in Self::SHARES {
            if left < share {
                return layout;
            }
            left -= share;
        }
        Self::Production
    }
}

/// The runs of a case.
#[derive(Debug, Clone, PartialEq)]
pub struct Session {
    /// How it is made up.
    pub layout: Layout,
    /// Its runs, in the order in which they were recorded.
    pub runs: Vec<TrialRun>,
}

/// Draws the session of a case.
///
/// # Errors
/// An axis that cannot move far enough for a stroke.
pub fn draw(machine: &Machine, random: &mut StdRng) -> Result<Session> {
    let bounds = Bounds::of(machine)?;
    let layout = Layout::draw(random);
    let mut runs = Vec::new();
    for shorter in 0..MOST_SHORTER {
        let bounds = bounds.with_strokes(SHORTER.powi(shorter as i32));
        runs = Pen { machine, bounds, random }.runs(layout);
        let lengths_s: Vec<f64> = runs.iter().map(|run| run.length_s(machine)).collect();
        let whole_s: f64 = lengths_s.iter().sum();
        runs.iter_mut().zip(one_after_another(lengths_s)).for_each(|(run, begins_s)| run.begins_s = begins_s);
        if whole_s <= layout.longest_s() {
            break;
        }
    }
    Ok(Session { layout, runs })
}

/// Draws where the axis stands before a run, and its movement.
type Draw<T> = fn(&mut T) -> (f64, Movement);
/// What a run is, before it has its name and its place in the session.
type Drawn = (Option<Role>, f64, Movement);

/// Draws movements for a machine.
struct Pen<'a> {
    machine: &'a Machine,
    bounds: Bounds,
    random: &'a mut StdRng,
}

impl Pen<'_> {
    fn runs(&mut self, layout: Layout) -> Vec<TrialRun> {
        let drawn = match layout {
            Layout::AcceptanceStrokes => self.acceptance(),
            Layout::SingleRun => vec![(None, 0.0, self.everything())],
            Layout::ThreeRuns => self.three(),
            Layout::JogsAndSine => {
                let sines = self.count(1, 2);
                let training = self.both(Role::Training, [2, sines], [Self::jogs_from_zero, Self::sine]);
                let held_out = self.both(Role::HeldOut, [1, 1], [Self::jogs_from_zero, Self::sine]);
                [training, held_out].concat()
            }
            Layout::MultisineAndStrokes => {
                let counts = [self.count(1, 2), self.count(2, 3)];
                let training = self.both(Role::Training, counts, [Self::multisine, Self::some_strokes]);
                let held_out = self.both(Role::HeldOut, [1, 1], [Self::multisine, Self::some_strokes]);
                [training, held_out].concat()
            }
            Layout::Production => self.production(),
        };
        let run = |(k, (role, from, movement)): (usize, Drawn)| {
            let name = format!("run{:02}", k + 1);
            TrialRun { name, role, begins_s: 0.0, from, movement }
        };
        drawn.into_iter().enumerate().map(run).collect()
    }

    fn between(&mut self, (least, most): (f64, f64)) -> f64 {
        self.random.random_range(least..most)
    }

    fn count(&mut self, least: usize, most: usize) -> usize {
        self.random.random_range(least..=most)
    }

    fn log_between(&mut self, (least, most): (f64, f64)) -> f64 {
        least * (most / least).powf(self.random.random_range(0.0..1.0))
    }

    /// A standstill in s, to a hundredth.
    fn dwell_s(&mut self, range: (f64, f64)) -> f64 {
        (100.0 * self.between(range)).round() / 100.0
    }

    /// A length of a stroke in m or rad, signed.
    fn stroke(&mut self) -> f64 {
        self.bounds.side * rounded(self.between(self.bounds.strokes))
    }

    /// A feed near the slow, middle or fast one.
    fn feed(&mut self, which: usize) -> f64 {
        let spread = self.between((1.0 - FEED_SPREAD, 1.0 + FEED_SPREAD));
        rounded(self.bounds.feeds[which] * spread)
    }

    fn any_feed(&mut self) -> f64 {
        let which = self.count(0, 2);
        self.feed(which)
    }

    fn strokes(&mut self, which: usize) -> Movement {
        let (feed, stroke) = (self.feed(which), self.stroke());
        Movement::Strokes { stroke, feed, dwell_s: self.dwell_s((0.22, 0.38)) }
    }

    /// Strokes at any feed, with where the axis stands before.
    fn some_strokes(&mut self) -> (f64, Movement) {
        let which = self.count(0, 2);
        (0.0, self.strokes(which))
    }

    /// With every feed among those for training; one held-out run is fast.
    fn acceptance(&mut self) -> Vec<Drawn> {
        let training = self.count(3, 5);
        (0..training + 2)
            .map(|k| {
                let which = match k {
                    0..3 => k,
                    _ if k == training => 2,
                    _ => self.count(0, 2),
                };
                let role = if k < training { Role::Training } else { Role::HeldOut };
                (Some(role), 0.0, self.strokes(which))
            })
            .collect()
    }

    fn three(&mut self) -> Vec<Drawn> {
        let runs = match self.count(0, 2) {
            0 => [0, 1, 2].map(|which| (0.0, self.strokes(which))),
            1 => [0; 3].map(|_| self.jogs_from_zero()),
            _ => [self.some_strokes(), self.jogs_from_zero(), self.sine()],
        };
        let is_stated = self.random.random_range(0.0..1.0) < 0.5;
        let roles = [Role::Training, Role::Training, Role::HeldOut].map(|role| is_stated.then_some(role));
        roles.into_iter().zip(runs).map(|(role, (from, movement))| (role, from, movement)).collect()
    }

    /// So many runs of each of two kinds.
    fn both(&mut self, role: Role, counts: [usize; 2], kinds: [Draw<Self>; 2]) -> Vec<Drawn> {
        let mut drawn = Vec::new();
        for (count, kind) in counts.into_iter().zip(kinds) {
            for _ in 0..count {
                let (from, movement) = kind(self);
                drawn.push((Some(role), from, movement));
            }
        }
        drawn
    }

    /// Slow and fast strokes, jogs, and in half of the cases a sine.
    fn everything(&mut self) -> Movement {
        let mut parts = vec![self.strokes(0), self.strokes(2)];
        if self.random.random_range(0.0..1.0) < 0.5 {
            let (centre, sine) = self.sine();
            parts.extend([self.jogs(Some(centre)), sine, self.move_by(-centre)]);
        } else {
            parts.push(self.jogs(Some(0.0)));
        }
        parts.push(self.strokes(1));
        Movement::Sequence { parts }
    }

    fn move_by(&mut self, to: f64) -> Movement {
        let (feed, dwell_s) = (self.feed(1), self.dwell_s((0.22, 0.38)));
        Movement::Jogs { moves: vec![Move { to, feed, dwell_s }] }
    }

    fn jogs_from_zero(&mut self) -> (f64, Movement) {
        (0.0, self.jogs(None))
    }

    /// Short moves between zero and a stroke; the last one ends where asked.
    fn jogs(&mut self, end: Option<f64>) -> Movement {
        let (stroke, count) = (self.stroke().abs(), self.count(4, 7));
        let mut moves: Vec<Move> = Vec::new();
        let mut at = 0.0;
        for _ in 0..count {
            let length = stroke * self.log_between(JOGS);
            let forward = self.random.random_range(0.0..1.0) < 0.5;
            let ways = if forward { [at + length, at - length] } else { [at - length, at + length] };
            let within = ways.into_iter().find(|to| (0.0..=stroke).contains(to));
            let farther_end = if at > 0.5 * stroke { 0.0 } else { stroke };
            at = rounded(within.unwrap_or(farther_end));
            moves.push(self.move_to(self.bounds.side * at, (0.15, 0.35)));
        }
        if let Some(end) = end {
            moves.push(self.move_to(end, (0.22, 0.38)));
        }
        Movement::Jogs { moves }
    }

    fn move_to(&mut self, to: f64, dwell_s: (f64, f64)) -> Move {
        Move { to, feed: self.any_feed(), dwell_s: self.dwell_s(dwell_s) }
    }

    /// A sine about the middle of a stroke, with where that is.
    fn sine(&mut self) -> (f64, Movement) {
        let frequency_hz = rounded(self.log_between(self.sampled(SINES_HZ)));
        let wanted_s = self.between((1.2, 3.0));
        let periods = ((wanted_s * frequency_hz).round() as usize).clamp(3, 12);
        let dwell_s = self.dwell_s((0.22, 0.38));
        self.fitted(Movement::Sine { amplitude: 1.0, frequency_hz, periods, dwell_s })
    }

    fn multisine(&mut self) -> (f64, Movement) {
        let count = self.count(4, 8);
        let range = self.sampled(LINES_HZ);
        let mut line = || {
            let frequency_hz = rounded(self.log_between(range));
            let phase_rad = rounded(self.between((0.0, TAU)));
            Line { amplitude: range.0 / frequency_hz, frequency_hz, phase_rad }
        };
        let lines = (0..count).map(|_| line()).collect();
        let (duration_s, dwell_s) = (rounded(self.between((2.0, 3.5))), self.dwell_s((0.22, 0.38)));
        self.fitted(Movement::Multisine { lines, duration_s, dwell_s })
    }

    /// Frequencies of which the controller samples a period often enough.
    fn sampled(&self, (least, most): (f64, f64)) -> (f64, f64) {
        let highest = 1.0 / (LEAST_SAMPLES * self.machine.description().sample_period_s);
        (least.min(0.5 * highest), most.min(highest))
    }

    /// A wave about the middle of a stroke whose peaks are as drawn, or less where speed and acceleration ask for it.
    fn fitted(&mut self, wave: Movement) -> (f64, Movement) {
        let centre = rounded(0.5 * self.stroke());
        let wanted = centre.abs() * self.between(PEAKS);
        let description = self.machine.description();
        let peaks = wave.peaks(description.sample_period_s, description.reference.acceleration_time_s);
        let factor = [
            wanted / peaks.position,
            self.bounds.speed / peaks.speed,
            self.bounds.acceleration / peaks.acceleration,
        ];
        let factor = FIT * factor.into_iter().fold(f64::INFINITY, f64::min);
        (centre, wave.scaled(|amplitude| rounded(factor * amplitude)))
    }

    /// Part programs one after the other, cut at standstills.
    fn production(&mut self) -> Vec<Drawn> {
        let programs: Vec<Vec<Move>> = (0..self.count(2, 3)).map(|_| self.program()).collect();
        let most_s = self.between(PRODUCTION_S);
        let pieces = self.count(PRODUCTION_PIECES.0, PRODUCTION_PIECES.1);
        let ramp_s = self.machine.description().reference.acceleration_time_s;
        let (mut moves, mut length_s): (Vec<Move>, f64) = (Vec::new(), 0.0);
        while length_s < most_s {
            let which = self.random.random_range(0..programs.len());
            for one in &programs[which] {
                let from = moves.last().map_or(0.0, |last| last.to);
                let way = crate::replay::Stroke { stroke: one.to - from, feed: one.feed };
                length_s += one.dwell_s + if way.stroke == 0.0 { 0.0 } else { way.duration_s(ramp_s) };
                if length_s < most_s || moves.len() < pieces {
                    moves.push(*one);
                }
            }
        }
        self.pieces(&moves, pieces)
    }

    /// A part program: positions within a stroke, each with its feed and standstill.
    fn program(&mut self) -> Vec<Move> {
        let (stroke, count) = (self.stroke(), self.count(3, 6));
        let position = |pen: &mut Self| rounded(stroke * pen.between((0.05, 1.0)));
        let to: Vec<f64> = (0..count).map(|_| position(self)).collect();
        to.into_iter().chain([0.0]).map(|to| self.move_to(to, (0.25, 0.8))).collect()
    }

    /// So many pieces, the last quarter of them held out. The standstill before a cut lasts into the next piece.
    fn pieces(&self, moves: &[Move], pieces: usize) -> Vec<Drawn> {
        let held_out = (pieces / 4).max(1);
        let cut = |k: usize| k * moves.len() / pieces;
        let mut from = 0.0;
        (0..pieces)
            .map(|k| {
                let mut moves: Vec<Move> = moves[cut(k)..cut(k + 1)].to_vec();
                let begins_at = from;
                if let Some(last) = moves.last_mut() {
                    from = last.to;
                    last.dwell_s = (100.0 * (last.dwell_s - LEAD_S)).round() / 100.0;
                }
                moves.iter_mut().for_each(|one| one.to -= begins_at);
                let role = if k + held_out < pieces { Role::Training } else { Role::HeldOut };
                (Some(role), begins_at, Movement::Production { moves })
            })
            .collect()
    }
}

/// Four digits, towards zero: a number that an operator could have typed, and that keeps a limit.
fn rounded(value: f64) -> f64 {
    let nearest = |value: f64| format!("{value:.3e}").parse().unwrap_or(value);
    let near: f64 = nearest(value);
    if near.abs() <= value.abs() { near } else { nearest(value * (1.0 - 1e-3)) }
}
