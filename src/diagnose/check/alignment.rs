//! Recorded channels that lie behind the others: a delay of the channel, told apart from one of the loop.
//!
//! # Model
//! Three relations hold whatever the loop's delay is, because nothing of the loop lies between their two sides:
//! the velocity is the estimate from the position; the effort is what the control law makes of reference and
//! position; the motor's force is what the motion takes (inertia, friction, spring, weight, all of free size).
//! A late channel breaks the relations that it is part of and no others. A late *loop* (effort to force) breaks
//! none of them.

use super::late::{Late, What};
use super::law::{Says, VelocitySource, estimated, law};
use super::projection::{Basis, spread};
use super::shift::{Shift, is_a_row};
use super::smoothed::Smoothed;
use crate::diagnose::thresholds::{BEYOND_CHANCE, LARGELY, MOST};
use crate::drive::motor::Circuit;
use crate::machine::Machine;
use crate::recording::Signal;

/// Shifts of one channel in several runs count as one when they agree to so many samples.
const AGREE_SAMPLES: f64 = 0.25;
/// A staircase acts half a sample after it is commanded.
const STAIRCASE: f64 = 0.5;

/// The channels of a run that are late.
pub fn late(machine: &Machine, smoothed: &Smoothed) -> Vec<Late> {
    let mut late: Vec<Late> = load(smoothed).into_iter().collect();
    // Unmodelled forces are left beside a shift. Where they are most of it a shift may be their doing; where they are a small part (backlash, ripple,
    // yielding parts) the force is late.
    let forces: Vec<(Signal, f64, bool)> = [Signal::Current, Signal::Thrust]
        .into_iter()
        .filter_map(|signal| Some((signal, force(machine, smoothed, signal)?)))
        .filter(|(_, shift)| shift.is_real() && shift.explains() >= MOST)
        .map(|(signal, shift)| (signal, shift.samples, shift.explains() >= LARGELY))
        .collect();
    let (loop_says, mut velocity, is_stated) = loop_and_velocity(machine, smoothed);
    // By how much the position itself is late, where that is known.
    let position = match &loop_says {
        Says::InTime => Some(0.0),
        Says::Late(channels) => {
            let logged = velocity.is_none() && smoothed.signal(Signal::Velocity).is_some();
            let found = of_law(channels, logged, |samples| witness(machine, smoothed, samples));
            let samples = match &found {
                Some(found) if found.signal == Signal::Position => found.samples,
                _ => 0.0,
            };
            if found.is_none() {
                // Not the position, then: law and velocity share another estimate than the stated one.
                velocity = None;
            }
            late.extend(found);
            Some(samples)
        }
        Says::Silent => None,
    };
    let is_law_known = position.is_some();
    let first = forces.iter().map(|(_, samples, _)| *samples).fold(0.0, f64::min);
    if position.is_none() && is_a_row(first) {
        let agrees = velocity.is_some_and(|velocity| !is_a_row(velocity - first));
        let what = if agrees { What::Position } else { What::Undecided };
        // Between motor and load something may yield.
        late.push(Late { signal: Signal::Position, samples: -first, what, is_certain: false });
        return late;
    }
    let position = position.unwrap_or(0.0);
    for (signal, samples, explained) in forces {
        if samples + position > 0.0 && is_a_row(samples + position) {
            let is_certain = explained && is_law_known;
            late.push(Late { signal, samples: samples + position, what: What::Force, is_certain });
        }
    }
    if let Some(samples) = velocity.map(|velocity| velocity + position).filter(|s| is_a_row(*s)) {
        let what = if samples > 0.0 { What::Velocity } else { What::VelocityAhead };
        late.push(Late { signal: Signal::Velocity, samples: samples.abs(), what, is_certain: is_stated });
    }
    late
}

/// What the control law says, the samples by which the velocity lies behind its estimate, and whether it is known that the law computes
/// from that estimate and not from the logged velocity.
fn loop_and_velocity(machine: &Machine, smoothed: &Smoothed) -> (Says, Option<f64>, bool) {
    let velocity = velocity(machine, smoothed).filter(Shift::is_real).map(|shift| shift.samples);
    let stated = law(machine, smoothed, VelocitySource::Stated);
    if velocity.is_some() {
        // Where the law fits better with the velocity as logged, the estimate is another than stated, not late.
        let logged = law(machine, smoothed, VelocitySource::Logged);
        if logged.says == Says::InTime && logged.beats(&stated) {
            return (Says::InTime, None, false);
        }
        let is_stated = stated.says != Says::Silent && stated.beats(&logged);
        return (stated.says, velocity, is_stated);
    }
    (stated.says, velocity, false)
}

/// What the forces say of a position that would be late by so many samples: they would lie ahead of it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Witness {
    For,
    Against,
    Silent,
}

fn witness(machine: &Machine, smoothed: &Smoothed, samples: f64) -> Witness {
    let direct = matches!(machine.constants().circuit, Circuit::Direct { .. });
    let channels = [Some(Signal::Current), Some(Signal::Thrust), direct.then_some(Signal::ControlEffort)];
    let shifts = channels.into_iter().flatten().filter_map(|signal| force(machine, smoothed, signal));
    let known: Vec<f64> = shifts
        .filter(|shift| BEYOND_CHANCE * shift.standard_error < samples)
        .map(|shift| shift.samples)
        .collect();
    match known.iter().copied().fold(f64::INFINITY, f64::min) {
        ahead if ahead <= -MOST * samples => Witness::For,
        f64::INFINITY => Witness::Silent,
        _ => Witness::Against,
    }
}

/// The channel that the law finds late, if the forces agree; `logged`: the logged velocity is the stated estimate.
fn of_law(channels: &[(Signal, Shift)], logged: bool, ask: impl Fn(f64) -> Witness) -> Option<Late> {
    let find = |signal| channels.iter().find(|(s, _)| *s == signal).map(|(_, shift)| shift.samples);
    let [effort, position, reference] =
        [Signal::ControlEffort, Signal::Position, Signal::PositionReference].map(find);
    // A velocity estimate quicker than stated looks like a late position, to the law but not to the forces.
    let position = position.map(|samples| (samples, ask(samples)));
    let position = position.filter(|(_, witness)| *witness != Witness::Against);
    let late = |signal, samples: f64, what, is_certain| Some(Late { signal, samples, what, is_certain });
    match (effort, position, reference) {
        (None, Some((samples, Witness::Silent)), _) => {
            late(Signal::Position, samples, What::Input { or_velocity_estimate: !logged }, logged)
        }
        (None, Some((samples, _)), _) | (_, Some((samples, Witness::For)), _) => {
            late(Signal::Position, samples, What::Input { or_velocity_estimate: false }, true)
        }
        (Some(samples), Some(_), _) => {
            late(Signal::ControlEffort, samples, What::EffortOr(Signal::Position), logged)
        }
        (Some(samples), None, Some(_)) => {
            late(Signal::ControlEffort, samples, What::EffortOr(Signal::PositionReference), logged)
        }
        (Some(samples), None, None) => {
            late(Signal::ControlEffort, samples, What::Effort { or_velocity_estimate: !logged }, logged)
        }
        (None, None, Some(samples)) => {
            late(Signal::PositionReference, samples, What::Input { or_velocity_estimate: false }, true)
        }
        (None, None, None) => None,
    }
}

/// The velocity behind the stated estimate from the position.
fn velocity(machine: &Machine, smoothed: &Smoothed) -> Option<Shift> {
    let samples = smoothed.signal(Signal::Velocity)?;
    let position = smoothed.signal(Signal::Position)?;
    let expected = estimated(&machine.description().encoder.velocity, position, smoothed.period_s);
    let shift = behind(samples, vec![expected], smoothed, &smoothed.inner)?;
    // It is computed from the position, so that next to nothing else can be left.
    (!shift.is_real() || shift.explains() >= LARGELY).then_some(shift)
}

/// A force behind the motion that it causes.
fn force(machine: &Machine, smoothed: &Smoothed, signal: Signal) -> Option<Shift> {
    let samples = smoothed.driving(signal)?;
    let columns = smoothed.motion_columns(machine, &smoothed.moving);
    let mut all = columns.others;
    all.push(columns.acceleration);
    let basis = Basis::of(all);
    let mut shift = shift_of(&samples, &basis, smoothed, &smoothed.moving)?;
    if matches!(machine.constants().circuit, Circuit::Direct { .. }) {
        shift.samples += STAIRCASE;
    }
    Some(shift)
}

/// The load's sensor behind the axis' own.
fn load(smoothed: &Smoothed) -> Option<Late> {
    let samples = smoothed.signal(Signal::LoadPosition)?;
    let position = smoothed.signal(Signal::Position)?.to_vec();
    let shift = behind(samples, vec![position], smoothed, &smoothed.inner)?;
    let late = shift.is_real() && shift.samples > 0.0 && shift.explains() >= LARGELY;
    late.then_some(Late {
        signal: Signal::LoadPosition,
        samples: shift.samples,
        what: What::Load,
        is_certain: false,
    })
}

/// A signal behind a combination of others and a constant.
fn behind(samples: &[f64], others: Vec<Vec<f64>>, smoothed: &Smoothed, at: &[usize]) -> Option<Shift> {
    let picked = others.iter().map(|other| at.iter().map(|k| other[*k]).collect());
    let basis = Basis::of(std::iter::once(vec![1.0; at.len()]).chain(picked));
    shift_of(samples, &basis, smoothed, at)
}

fn shift_of(samples: &[f64], basis: &Basis, smoothed: &Smoothed, at: &[usize]) -> Option<Shift> {
    let later =
        |shift: isize| at.iter().map(|k| samples[k.saturating_add_signed(shift)]).collect::<Vec<f64>>();
    Shift::find(smoothed.most_shift, spread(&later(0)), |shift| basis.residual(later(shift)))
}

/// One value for a channel where its runs agree, so that they are told as one.
pub fn consensus<'a>(runs: impl Iterator<Item = &'a [Late]>) -> Vec<Vec<Late>> {
    let mut runs: Vec<Vec<Late>> = runs.map(<[Late]>::to_vec).collect();
    let all: Vec<Late> = runs.iter().flatten().cloned().collect();
    for late in runs.iter_mut().flatten() {
        let same = |other: &&Late| other.signal == late.signal && other.what == late.what;
        let mut samples: Vec<f64> = all.iter().filter(same).map(|other| other.samples).collect();
        samples.sort_by(f64::total_cmp);
        let median = samples[samples.len() / 2];
        if (late.samples - median).abs() <= AGREE_SAMPLES {
            late.samples = median;
        }
    }
    runs
}
