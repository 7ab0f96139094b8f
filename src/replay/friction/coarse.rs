//! Where the search begins: a grid of acceleration times and frictions, each stroke moved to where it was made.

use super::Numbers;
use super::profile::{Profile, Strokes};
use super::subject::Subject;
use crate::drive::motor::Circuit;
use crate::effect::Constants;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::twin::Sensing;

/// Acceleration times that are tried where the reference was not logged, in s.
const RAMPS_S: [f64; 6] = [5e-3, 1e-2, 2e-2, 4e-2, 8e-2, 0.16];
/// Frictions that are tried, as shares of the largest force.
const FRICTION_SHARES: [f64; 2] = [0.0, 0.05];
/// Times that the start of a stroke is corrected for each.
const ALIGNMENTS: usize = 2;

/// Start of the search.
pub(super) struct Coarse {
    pub(super) ramp_s: f64,
    pub(super) coulomb: f64,
    /// Starts of the strokes of each run.
    pub(super) starts: Vec<Vec<f64>>,
}

impl Coarse {
    /// The pair of acceleration time and friction that replays best.
    pub(super) fn of(subjects: &[Subject], machine: &Machine, force: f64) -> Result<Self> {
        let read = subjects.iter().find_map(|subject| match &subject.profile {
            Profile::Strokes(strokes) => strokes.read_s,
            Profile::Logged(_) => None,
        });
        let stated = machine.description().reference.acceleration_time_s;
        let ramps: Vec<f64> = match read {
            Some(read) => vec![read],
            None if subjects.iter().all(|subject| subject.unknown().is_none()) => vec![stated],
            None => RAMPS_S.to_vec(),
        };
        let mut best: Option<(f64, Self)> = None;
        for &ramp_s in &ramps {
            for share in FRICTION_SHARES {
                let coulomb = share * force;
                let (mut size, mut starts) = (0.0, Vec::new());
                for subject in subjects {
                    let numbers = aligned(subject, ramp_s, coulomb)?;
                    size += subject.residuals(&numbers)?.iter().map(|r| r * r).sum::<f64>();
                    starts.push(numbers.starts);
                }
                if best.as_ref().is_none_or(|(least, _)| size < *least) {
                    best = Some((size, Self { ramp_s, coulomb, starts }));
                }
            }
        }
        Ok(best.map_or(Self { ramp_s: stated, coulomb: 0.0, starts: Vec::new() }, |(_, coarse)| coarse))
    }
}

/// Numbers of a run with its strokes where the twin passes their middles when the machine did.
fn aligned(subject: &Subject, ramp_s: f64, coulomb: f64) -> Result<Numbers> {
    let mut numbers =
        Numbers { ramp_s, coulomb, viscous: None, starts: Vec::new(), base: 0.0, start_off: [0.0; 2] };
    let Profile::Strokes(strokes) = &subject.profile else { return Ok(numbers) };
    numbers.starts.clone_from(&strokes.start_s);
    numbers.base = strokes.base;
    if strokes.read_s.is_some() {
        return Ok(numbers);
    }
    let period_s = subject.run.sample_period_s();
    for _ in 0..ALIGNMENTS {
        let twin = subject.replay(&numbers, Sensing::Perfect)?;
        let before = numbers.starts.clone();
        for (j, start) in numbers.starts.iter_mut().enumerate() {
            let from = (before[j].max(0.0) / period_s) as usize;
            let passes = |position: &[f64]| middle(strokes, j, position, from);
            if let Some((made, predicted)) = passes(subject.recorded(0)).zip(passes(&twin.position)) {
                *start += (made as f64 - predicted as f64) * period_s;
            }
        }
    }
    Ok(numbers)
}

/// First sample from which a position has passed the middle of a stroke.
fn middle(strokes: &Strokes, j: usize, position: &[f64], from: usize) -> Option<usize> {
    let stroke = strokes.strokes[j].stroke;
    let begin = strokes.base + strokes.strokes[..j].iter().map(|s| s.stroke).sum::<f64>();
    let passed = |x: &f64| (x - begin) / stroke > 0.5;
    position.get(from..)?.iter().position(passed).map(|k| k + from)
}

/// The largest motor force of the runs in N, or N·m, from whatever tells it.
pub(super) fn largest_force(subjects: &[Subject], constants: &Constants) -> f64 {
    let per_unit = |signal: Signal| match (signal, &constants.circuit) {
        (Signal::Thrust, _) => 1.0,
        (Signal::Current, Circuit::Winding { force_constant, .. }) => *force_constant,
        (_, Circuit::Winding { force_constant, resistance_ohm, .. }) => force_constant / resistance_ohm,
        (_, Circuit::Direct { force_per_volt }) => *force_per_volt,
    };
    let of = |subject: &Subject| {
        let peak = subject.recorded(1).iter().fold(0.0_f64, |peak, x| peak.max(x.abs()));
        peak * per_unit(subject.signals[1]).abs()
    };
    subjects.iter().map(of).fold(f64::MIN_POSITIVE, f64::max)
}
