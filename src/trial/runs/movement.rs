//! What the axis is told in a run.

use super::suffixes;
use crate::replay::{Motion, Stroke};
use crate::units;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// One move of a part program: to a position, then a standstill.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Move {
    /// Where to, in m or rad from where the movement begins.
    pub to: f64,
    /// Feed in m/s or rad/s.
    pub feed: f64,
    /// Standstill afterwards in s.
    pub dwell_s: f64,
}

/// One line of a multisine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Amplitude in m or rad.
    pub amplitude: f64,
    /// Frequency in Hz.
    pub frequency_hz: f64,
    /// Phase in rad.
    pub phase_rad: f64,
}

/// What the axis is told, from a standstill to a standstill.
///
/// # Model
/// ```text
/// sine        x(t) = e(t)·A·sin(2π·f·t)                   e fades in and out over one period
/// multisine   x(t) = e(t)·Σ A_j·sin(2π·f_j·t + φ_j)       e fades in and out over a quarter of the length
/// e rises and falls as (1 − cos)/2; all else moves with trapezoidal velocity, see Stroke
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Movement {
    /// There and back.
    Strokes {
        /// Distance there and back in m or rad, signed.
        stroke: f64,
        /// Feed in m/s or rad/s.
        feed: f64,
        /// Standstill after each stroke in s.
        dwell_s: f64,
    },
    /// Short moves of different lengths and directions.
    Jogs {
        /// The moves in their order.
        moves: Vec<Move>,
    },
    /// A sine about where the axis stands.
    Sine {
        /// Amplitude in m or rad.
        amplitude: f64,
        /// Frequency in Hz.
        frequency_hz: f64,
        /// Its periods, those of fading included.
        periods: usize,
        /// Standstill afterwards in s.
        dwell_s: f64,
    },
    /// Several sines at once about where the axis stands.
    Multisine {
        /// The sines.
        lines: Vec<Line>,
        /// How long it lasts, in s.
        duration_s: f64,
        /// Standstill afterwards in s.
        dwell_s: f64,
    },
    /// A piece of a production: part programs, one after the other.
    Production {
        /// The moves in their order.
        moves: Vec<Move>,
    },
    /// Movements one after the other, each from where the one before ended.
    Sequence {
        /// The movements in their order.
        parts: Vec<Movement>,
    },
}

/// Largest magnitudes of a movement, from where it begins.
pub(super) struct Peaks {
    /// In m or rad.
    pub position: f64,
    /// In m/s or rad/s.
    pub speed: f64,
    /// In m/s² or rad/s².
    pub acceleration: f64,
}

impl Movement {
    /// Its word in metadata.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Strokes { .. } => "strokes",
            Self::Jogs { .. } => "jogs",
            Self::Sine { .. } => "sine",
            Self::Multisine { .. } => "multisine",
            Self::Production { .. } => "production",
            Self::Sequence { .. } => "sequence",
        }
    }

    /// Positions in m or rad from where the axis stands, the first one a sample period after the beginning; ramps from
    /// rest to feed take `ramp_s`.
    pub fn samples(&self, period_s: f64, ramp_s: f64) -> Vec<f64> {
        match self {
            Self::Strokes { stroke, feed, dwell_s } => {
                let to = |to: f64| Move { to, feed: *feed, dwell_s: *dwell_s };
                moved(&[to(*stroke), to(0.0)], period_s, ramp_s)
            }
            Self::Jogs { moves } | Self::Production { moves } => moved(moves, period_s, ramp_s),
            Self::Sine { amplitude, frequency_hz, periods, dwell_s } => {
                let duration_s = *periods as f64 / frequency_hz;
                let fade_s = (1.0 / frequency_hz).min(0.5 * duration_s);
                let wave = |t: f64| amplitude * (TAU * frequency_hz * t).sin();
                faded(wave, [duration_s, fade_s, *dwell_s], period_s)
            }
            Self::Multisine { lines, duration_s, dwell_s } => {
                let one = |t: f64, l: &Line| l.amplitude * (TAU * l.frequency_hz * t + l.phase_rad).sin();
                let wave = |t: f64| lines.iter().map(|line| one(t, line)).sum();
                faded(wave, [*duration_s, 0.25 * duration_s, *dwell_s], period_s)
            }
            Self::Sequence { parts } => {
                let (mut samples, mut from) = (Vec::new(), 0.0);
                for part in parts {
                    samples.extend(part.samples(period_s, ramp_s).into_iter().map(|x| from + x));
                    from += part.end();
                }
                samples
            }
        }
    }

    /// Where it ends, in m or rad from where it begins.
    fn end(&self) -> f64 {
        match self {
            Self::Strokes { .. } | Self::Sine { .. } | Self::Multisine { .. } => 0.0,
            Self::Jogs { moves } | Self::Production { moves } => moves.last().map_or(0.0, |last| last.to),
            Self::Sequence { parts } => parts.iter().map(Self::end).sum(),
        }
    }

    /// A sine or multisine with so many times its amplitudes; else the same.
    #[must_use]
    pub(super) fn scaled(mut self, factor: impl Fn(f64) -> f64) -> Self {
        match &mut self {
            Self::Sine { amplitude, .. } => *amplitude = factor(*amplitude),
            Self::Multisine { lines, .. } => {
                lines.iter_mut().for_each(|line| line.amplitude = factor(line.amplitude));
            }
            _ => {}
        }
        self
    }

    /// Its largest magnitudes as it is sampled.
    pub(super) fn peaks(&self, period_s: f64, ramp_s: f64) -> Peaks {
        let samples = [vec![0.0; 2], self.samples(period_s, ramp_s)].concat();
        let largest =
            |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |most: f64, x| most.max(x.abs()));
        let mut first = samples.windows(2).map(|x| (x[1] - x[0]) / period_s);
        let mut second = samples.windows(3).map(|x| (x[2] - 2.0 * x[1] + x[0]) / (period_s * period_s));
        Peaks {
            position: largest(&mut samples.iter().copied()),
            speed: largest(&mut first),
            acceleration: largest(&mut second),
        }
    }

    /// What a recording keeps of it.
    pub(super) fn metadata(&self, motion: units::Motion) -> toml::Table {
        let (length, speed, per) = suffixes(motion);
        let named = ("movement".to_owned(), self.name().into());
        let entries: Vec<(String, toml::Value)> = match self {
            Self::Strokes { stroke, feed, .. } => {
                vec![
                    (format!("stroke_{length}"), (*stroke).into()),
                    (format!("feed_{speed}"), (per * feed).into()),
                ]
            }
            Self::Jogs { moves } | Self::Production { moves } => {
                vec![named, ("moves".to_owned(), (moves.len() as i64).into())]
            }
            Self::Sine { amplitude, frequency_hz, .. } => vec![
                named,
                (format!("amplitude_{length}"), (*amplitude).into()),
                ("frequency_hz".to_owned(), (*frequency_hz).into()),
            ],
            Self::Multisine { lines, .. } => {
                vec![named, ("lines".to_owned(), (lines.len() as i64).into())]
            }
            Self::Sequence { parts } => {
                let names: Vec<&str> = parts.iter().map(Self::name).collect();
                vec![named, ("parts".to_owned(), names.join(", ").into())]
            }
        };
        entries.into_iter().collect()
    }
}

/// Moves one after the other, each with its standstill.
fn moved(moves: &[Move], period_s: f64, ramp_s: f64) -> Vec<f64> {
    let (mut samples, mut from) = (Vec::new(), 0.0);
    for one in moves {
        let way = Stroke { stroke: one.to - from, feed: one.feed };
        // A move to where the axis stands already takes no time.
        let strokes = if way.stroke == 0.0 { Vec::new() } else { vec![way] };
        let lead_s = if strokes.is_empty() { one.dwell_s } else { 0.0 };
        let motion = Motion { strokes, lead_s, dwell_s: one.dwell_s, ramp_s };
        // Where it ends is exact: a joint may end there.
        let place = |x: f64| if x == way.stroke { one.to } else { from + x };
        samples.extend(motion.reference(period_s).into_iter().map(place));
        from = one.to;
    }
    samples
}

/// A wave that fades in and out, then a standstill: length, fading and standstill in s.
fn faded(wave: impl Fn(f64) -> f64, [duration_s, fade_s, dwell_s]: [f64; 3], period_s: f64) -> Vec<f64> {
    let count = |seconds: f64| (seconds / period_s).round() as usize;
    let sample = |k: usize| {
        let t = (k as f64 + 1.0) * period_s;
        let edge = (t.min(duration_s - t) / fade_s).clamp(0.0, 1.0);
        if edge > 0.0 { 0.5 * (1.0 - (PI * edge).cos()) * wave(t) } else { 0.0 }
    };
    (0..count(duration_s)).map(sample).chain(std::iter::repeat_n(0.0, count(dwell_s))).collect()
}
