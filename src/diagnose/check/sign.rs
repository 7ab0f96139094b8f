//! Columns whose sign is swapped.

use super::inertia::{FORCE, Inertia};
use super::projection::{Basis, Coefficient, spread};
use super::smoothed::Smoothed;
use super::{Check, Finding};
use crate::diagnose::thresholds::{BEYOND_CHANCE, LARGELY, MOST};
use crate::machine::Machine;
use crate::recording::{Run, Signal};

/// The channels of a run that go the wrong way.
#[derive(Debug, Clone, Default)]
pub struct Signs {
    swapped: Vec<Swapped>,
}

/// A channel that goes the wrong way.
#[derive(Debug, Clone, Copy)]
struct Swapped {
    signal: Signal,
    /// What it goes against.
    against: Against,
    is_certain: bool,
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
        let mirrored =
            direction(Signal::Position, reference).is_some_and(|(way, _)| way == Direction::Against);
        let forces: Vec<(Signal, Inertia)> = FORCE
            .into_iter()
            .filter_map(|signal| Some((signal, Inertia::of(machine, smoothed, signal)?)))
            .filter(|(_, inertia)| is_known(inertia))
            .collect();
        let stated = machine.constants().moving_mass;
        // A sine beyond the loop's bandwidth goes against its reference too: a mass that is negative does not.
        let is_witness = |inertia: &Inertia| inertia.mass.value < 0.0 && is_stated_mass(inertia, stated);
        let is_settled = !mirrored || forces.iter().any(|(_, inertia)| is_witness(inertia));
        if mirrored {
            let against = Against::Reference;
            swapped.push(Swapped { signal: Signal::Position, against, is_certain: is_settled });
        }
        // A mirrored position mirrors all that is compared with it.
        let wrong = if mirrored { Direction::Along } else { Direction::Against };
        for (signal, other) in [(Signal::Velocity, &smoothed.velocity[..]), (Signal::LoadPosition, position)]
        {
            if let Some((_, share)) = direction(signal, other).filter(|(way, _)| *way == wrong) {
                let against = if mirrored { Against::Reference } else { Against::Position };
                let is_certain = is_settled && share >= LARGELY;
                swapped.push(Swapped { signal, against, is_certain });
            }
        }
        for (signal, inertia) in forces.iter().filter(|(_, i)| (i.mass.value < 0.0) != mirrored) {
            let is_certain = is_settled && is_stated_mass(inertia, stated);
            swapped.push(Swapped { signal: *signal, against: Against::Inertia, is_certain });
        }
        Self { swapped }
    }

    /// Whether the position goes against its reference: then all that is read off it is mirrored.
    pub fn position_is_swapped(&self) -> bool {
        self.swapped.iter().any(|swapped| swapped.signal == Signal::Position)
    }

    /// What to say of a run.
    pub fn findings(&self, run: &Run) -> Vec<Finding> {
        self.swapped.iter().map(|swapped| finding(run, *swapped)).collect()
    }
}

fn is_known(inertia: &Inertia) -> bool {
    inertia.mass.significance() >= BEYOND_CHANCE && inertia.explained >= MOST
}

/// Whether a force is what moves the stated mass, one way or the other: most of that, and not much more.
fn is_stated_mass(inertia: &Inertia, stated: f64) -> bool {
    let ratio = inertia.mass.value.abs() / stated;
    inertia.explained >= LARGELY && (MOST..1.0 / MOST).contains(&ratio)
}

fn finding(run: &Run, swapped: Swapped) -> Finding {
    let Swapped { signal, against, is_certain } = swapped;
    let key = signal.key(run.motion());
    let word = signal.word(run.motion());
    let seen = match against {
        Against::Reference => "it goes down where the reference goes up",
        Against::Position => "it goes against the position",
        Against::Inertia => "it pushes against the motion that it causes, as if mass were negative",
    };
    Finding::column(
        run,
        Check::SwappedSign,
        signal,
        is_certain,
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

/// Whether `y` is, for the most part (a badly predicted channel is not a swapped one), a positive or a negative multiple of `x` (each about its mean), and the share of it that is.
fn direction(y: &[f64], x: &[f64]) -> Option<(Direction, f64)> {
    let constant = Basis::of([vec![1.0; x.len()]]);
    let slope = Coefficient::of(x, &constant, y)?;
    let share = slope.value * slope.value * spread(x) / spread(y);
    let known = slope.significance() >= BEYOND_CHANCE && share >= MOST;
    known.then_some((if slope.value < 0.0 { Direction::Against } else { Direction::Along }, share))
}
