//! Columns whose sign is swapped.

use super::inertia::{FORCE, Inertia};
use super::projection::{Basis, Coefficient, spread};
use super::smoothed::Smoothed;
use super::{Check, Finding};
use crate::machine::Machine;
use crate::recording::{Run, Signal};

/// Share of a channel that its counterpart, negative, must explain: a badly predicted channel is not a swapped one.
const LEAST_EXPLAINED: f64 = 0.5;
/// And standard errors by which the coefficient must lie below zero.
const LEAST_SIGNIFICANCE: f64 = 5.0;

/// The channels of a run that go the wrong way.
#[derive(Debug, Clone, Default)]
pub struct Signs {
    /// Each with what it goes against.
    swapped: Vec<(Signal, Against)>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Against {
    Reference,
    Position,
    Inertia,
}

impl Signs {
    /// Compares position with its reference, velocity and load position with the position, and every channel that
    /// tells a force with the motion that it causes: a mass is positive.
    pub fn of(machine: &Machine, smoothed: &Smoothed) -> Self {
        let mut swapped = Vec::new();
        let position = smoothed.signal(Signal::Position).unwrap_or_default();
        let direction = |signal, other: &[f64]| {
            // One that was not logged says nothing.
            let samples = smoothed.signal(signal).filter(|samples| samples.len() == other.len())?;
            direction(&pick(samples, &smoothed.inner), &pick(other, &smoothed.inner))
        };
        let reference = smoothed.signal(Signal::PositionReference).unwrap_or_default();
        let mirrored = direction(Signal::Position, reference) == Some(Direction::Against);
        if mirrored {
            swapped.push((Signal::Position, Against::Reference));
        }
        // A mirrored position mirrors all that is compared with it.
        let wrong = if mirrored { Direction::Along } else { Direction::Against };
        for (signal, other) in [(Signal::Velocity, &smoothed.velocity[..]), (Signal::LoadPosition, position)]
        {
            if direction(signal, other) == Some(wrong) {
                swapped.push((signal, if mirrored { Against::Reference } else { Against::Position }));
            }
        }
        for signal in FORCE {
            let Some(inertia) = Inertia::of(machine, smoothed, signal) else { continue };
            let known =
                inertia.mass.significance() >= LEAST_SIGNIFICANCE && inertia.explained >= LEAST_EXPLAINED;
            if known && (inertia.mass.value < 0.0) != mirrored {
                swapped.push((signal, Against::Inertia));
            }
        }
        Self { swapped }
    }

    /// Whether the position goes against its reference: then all that is read off it is mirrored.
    pub fn position_is_swapped(&self) -> bool {
        self.swapped.iter().any(|(signal, _)| *signal == Signal::Position)
    }

    /// What to say of a run.
    pub fn findings(&self, run: &Run) -> Vec<Finding> {
        self.swapped.iter().map(|(signal, against)| finding(run, *signal, *against)).collect()
    }
}

fn finding(run: &Run, signal: Signal, against: Against) -> Finding {
    let key = signal.key(run.motion());
    let word = signal.word(run.motion());
    let seen = match against {
        Against::Reference => "it goes down where the reference goes up",
        Against::Position => "it goes against the position",
        Against::Inertia => "it pushes against the motion that it causes, as if mass were negative",
    };
    Finding::warning(
        run.name(),
        Check::SwappedSign,
        format!(
            "The {word} has the wrong sign: {seen}. Give `{key}` the entry `scale = -1` in [columns], or take \
             one out that is there."
        ),
    )
}

fn pick(samples: &[f64], at: &[usize]) -> Vec<f64> {
    at.iter().map(|k| samples[*k]).collect()
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Direction {
    Along,
    Against,
}

/// Whether `y` is, for the most part, a positive or a negative multiple of `x` (each about its mean).
fn direction(y: &[f64], x: &[f64]) -> Option<Direction> {
    let constant = Basis::of([vec![1.0; x.len()]]);
    let slope = Coefficient::of(x, &constant, y)?;
    let known = slope.significance() >= LEAST_SIGNIFICANCE
        && slope.value * slope.value * spread(x) >= LEAST_EXPLAINED * spread(y);
    known.then_some(if slope.value < 0.0 { Direction::Against } else { Direction::Along })
}
