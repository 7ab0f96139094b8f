//! Does the control effort fit reference and position through the control law, as logged or with one of them late?

use super::projection::{Basis, dot, spread};
use super::shift::Shift;
use super::smoothed::Smoothed;
use crate::controller::{Controller, Filters};
use crate::diagnose::thresholds::{LARGELY, MOST};
use crate::machine::Machine;
use crate::recording::Signal;
use crate::sensor::{VelocityEstimate, VelocityMemory};

/// Unexplained share of the effort up to which the law is taken for the one that ran: a controller computes from
/// the very readings that were logged, so no physics comes between, only rounding and unequal gains.
///
/// Its root, the share of the amplitude, is the small rest of what is explained largely.
const FITS: f64 = (1.0 - LARGELY) * (1.0 - LARGELY);
/// An unexplained share below this is rounding: nothing is left that a shift could explain.
const EXACT: f64 = 1e-8;

/// Whether one share of the power is clearly less than another: less than half in amplitude.
fn is_clearly_less(one: f64, other: f64) -> bool {
    one < MOST * MOST * other
}

/// What the control law says of the channels that it connects.
#[derive(Debug, Clone, PartialEq)]
pub enum Says {
    /// Reference, position and effort fit as they are.
    InTime,
    /// They fit when one of these channels is moved; more than one where they cannot be told apart.
    Late(Vec<(Signal, Shift)>),
    /// Nothing: a signal is missing, or the law did not run like that.
    Silent,
}

/// The control law held against the logged channels.
#[derive(Debug, Clone, PartialEq)]
pub struct Law {
    /// What it says.
    pub says: Says,
    /// Share of the effort that stays unexplained then.
    pub left: f64,
}

impl Law {
    const SILENT: Self = Self { says: Says::Silent, left: f64::INFINITY };

    /// Whether this law fits clearly better than another that is not exact itself.
    pub fn beats(&self, other: &Self) -> bool {
        other.left > EXACT && is_clearly_less(self.left, other.left)
    }
}

/// Asks the control law.
///
/// # Model
/// Both laws are linear in their inputs: the effort is a combination of position error, reference velocity, velocity
/// estimate and the integrals of these. The gains are left free, so that wrong ones are no delay.
/// `velocity` tells from which velocity the law computes: the estimate as stated, or the logged one.
pub fn law(machine: &Machine, smoothed: &Smoothed, velocity: VelocitySource) -> Law {
    let Some(relation) = Relation::of(machine, smoothed, velocity) else { return Law::SILENT };
    let variance = spread(&relation.at(&relation.effort, 0));
    let find = |signal| {
        Some((signal, Shift::find(smoothed.most_shift, variance, |shift| relation.residual(signal, shift))?))
    };
    // A channel can only be late: early ones are all the others late. What a law computes from aligned readings is exact, so that the true shift
    // leaves next to nothing.
    let explains = |(_, shift): &(Signal, Shift)| {
        shift.samples > 0.0 && shift.is_real() && shift.explains() > LARGELY && shift.after < FITS
    };
    let now = relation.residual(Signal::ControlEffort, 0);
    let left = dot(&now, &now) / variance;
    let mut late: Vec<(Signal, Shift)> = Vec::new();
    if left > EXACT {
        let channels = [Signal::ControlEffort, Signal::Position, Signal::PositionReference];
        late = channels.into_iter().filter_map(find).filter(explains).collect();
    }
    let least = late.iter().map(|(_, shift)| shift.after).fold(f64::INFINITY, f64::min);
    late.retain(|(_, shift)| !is_clearly_less(least.max(EXACT), shift.after));
    match late.is_empty() {
        false => Law { says: Says::Late(late), left: least },
        true if left <= FITS => Law { says: Says::InTime, left },
        true => Law { says: Says::Silent, left },
    }
}

/// The velocity from which the law is taken to compute.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VelocitySource {
    /// The estimate that the machine states, from the logged position.
    Stated,
    /// The logged velocity.
    Logged,
}

struct Relation<'a> {
    controller: &'a Controller,
    estimate: &'a VelocityEstimate,
    effort: Vec<f64>,
    reference: &'a [f64],
    position: &'a [f64],
    /// Set where the law computes from the logged velocity.
    velocity: Option<&'a [f64]>,
    disturbance: Option<&'a [f64]>,
    at: Vec<usize>,
    period_s: f64,
}

impl<'a> Relation<'a> {
    fn of(machine: &'a Machine, smoothed: &'a Smoothed, velocity: VelocitySource) -> Option<Self> {
        let description = machine.description();
        let effort = smoothed.signal(Signal::ControlEffort)?;
        let velocity = match velocity {
            VelocitySource::Stated => None,
            VelocitySource::Logged => Some(smoothed.signal(Signal::Velocity)?),
        };
        Some(Self {
            controller: description.controller.as_ref()?,
            estimate: &description.encoder.velocity,
            effort: effort.to_vec(),
            reference: smoothed.signal(Signal::PositionReference)?,
            position: smoothed.signal(Signal::Position)?,
            velocity,
            disturbance: smoothed.signal(Signal::DisturbanceVoltage),
            at: smoothed.inner.clone(),
            period_s: smoothed.period_s,
        })
    }

    /// A signal at the samples compared, `shift` samples later.
    fn at(&self, signal: &[f64], shift: isize) -> Vec<f64> {
        self.at.iter().map(|k| signal[k.saturating_add_signed(shift)]).collect()
    }

    /// What the law leaves of the effort when one channel is taken `shift` samples later.
    fn residual(&self, moved: Signal, shift: isize) -> Vec<f64> {
        let of = |signal| if signal == moved { shift } else { 0 };
        let reference = shifted(self.reference, of(Signal::PositionReference));
        let position = shifted(self.position, of(Signal::Position));
        let velocity = match self.velocity {
            // Position and velocity come from one sensor.
            Some(velocity) => shifted(velocity, of(Signal::Position)),
            None => estimated(self.estimate, &position, self.period_s),
        };
        let mut columns = self.columns(&reference, &position, &velocity);
        columns.extend(self.disturbance.map(<[f64]>::to_vec));
        let basis = Basis::of(columns.iter().map(|column| self.at(column, 0)));
        basis.residual(self.at(&self.effort, of(Signal::ControlEffort)))
    }

    fn columns(&self, reference: &[f64], position: &[f64], velocity: &[f64]) -> Vec<Vec<f64>> {
        let count = reference.len();
        let error: Vec<f64> = reference.iter().zip(position).map(|(r, x)| r - x).collect();
        let rate =
            (0..count).map(|k| if k == 0 { 0.0 } else { (reference[k] - reference[k - 1]) / self.period_s });
        let proportional = match self.controller {
            Controller::Pdf(_) => vec![velocity.to_vec()],
            Controller::Cascade(_) | Controller::Pd(_) => {
                vec![error.clone(), rate.collect(), velocity.to_vec()]
            }
        };
        let mut columns = vec![vec![1.0; count]];
        columns.extend(proportional);
        if self.controller.integrates() {
            let sum = |signal: &[f64]| {
                let mut sum = 0.0;
                let add = |x: &f64| {
                    sum += x * self.period_s;
                    sum
                };
                signal.iter().map(add).collect::<Vec<f64>>()
            };
            columns.extend([reference.to_vec(), sum(velocity), sum(&error)]);
        }
        filtered(columns, &Filters::new(self.controller.filters(), self.period_s))
    }
}

/// What the filters behind the law make of the terms that it adds up.
fn filtered(mut columns: Vec<Vec<f64>>, filters: &Filters) -> Vec<Vec<f64>> {
    for column in columns.iter_mut().filter(|_| !filters.is_empty()) {
        let mut memory = filters.steady(column.first().copied().unwrap_or(0.0));
        column.iter_mut().for_each(|sample| *sample = filters.pass(&mut memory, *sample));
    }
    columns
}

/// The signal as it is `shift` samples later, held at the ends.
fn shifted(signal: &[f64], shift: isize) -> Vec<f64> {
    let last = signal.len().saturating_sub(1);
    (0..signal.len()).map(|k| signal[k.saturating_add_signed(shift).min(last)]).collect()
}

/// The controller's velocity estimate along positions.
pub fn estimated(estimate: &VelocityEstimate, position: &[f64], period_s: f64) -> Vec<f64> {
    let first = position.first().copied().unwrap_or_default();
    let speed = position.get(1).map_or(0.0, |second| (second - first) / period_s);
    let mut memory = VelocityMemory::moving(first, speed, period_s);
    position.iter().map(|x| estimate.update(&mut memory, *x, period_s)).collect()
}
