//! Does the control effort fit reference and position through the control law, as logged or with one of them late?

use super::projection::{Basis, spread};
use super::shift::Shift;
use super::smoothed::{Smoothed, differences};
use crate::controller::{Controller, Filters};
use crate::diagnose::scalar_product::dot;
use crate::diagnose::thresholds::{LARGELY, MOST};
use crate::machine::Machine;
use crate::recording::Signal;
use crate::sensor::{VelocityEstimate, VelocityMemory};

/// Unexplained share of the effort up to which the law is taken for the one that ran: a controller computes from
/// the very readings that were logged, so no physics comes between, only rounding and unequal gains.
///
/// Its root, the share of the amplitude, is the small rest of what is explained largely.
pub(super) const FITS: f64 = (1.0 - LARGELY) * (1.0 - LARGELY);
/// An unexplained share below this is rounding: nothing is left that a shift could explain.
const EXACT: f64 = 1e-8;

/// Whether one share of the power is clearly less than another: less than half in amplitude.
pub(super) fn is_clearly_less(one: f64, other: f64) -> bool {
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
    if !late.is_empty() {
        // A feed-forward that the law does not state acts ahead of its reference, as a late channel of it makes the law seem to act.
        let fed_forward = relation.left_with(relation.acceleration()).unwrap_or(f64::INFINITY);
        late.retain(|(_, shift)| is_clearly_less(shift.after, fed_forward));
    }
    let least = late.iter().map(|(_, shift)| shift.after).fold(f64::INFINITY, f64::min);
    late.retain(|(_, shift)| !is_clearly_less(least.max(EXACT), shift.after));
    match late.is_empty() {
        false => Law { says: Says::Late(late), left: least },
        true if left <= FITS => Law { says: Says::InTime, left },
        true => Law { says: Says::Silent, left },
    }
}

/// A reference that acts later on the law than logged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Late {
    /// That of velocity alone.
    VelocityReference,
    /// Those of position and velocity.
    References,
}

/// The velocity from which the law is taken to compute.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VelocitySource {
    /// The estimate that the machine states, from the logged position.
    Stated,
    /// The logged velocity.
    Logged,
}

pub(super) struct Relation<'a> {
    controller: &'a Controller,
    estimate: &'a VelocityEstimate,
    effort: Vec<f64>,
    reference: &'a [f64],
    /// Velocity reference.
    rate: &'a [f64],
    position: &'a [f64],
    /// Set where the law computes from the logged velocity.
    velocity: Option<&'a [f64]>,
    disturbance: Option<&'a [f64]>,
    direction: &'a [f64],
    at: Vec<usize>,
    period_s: f64,
}

impl<'a> Relation<'a> {
    pub(super) fn of(machine: &'a Machine, smoothed: &'a Smoothed, velocity: VelocitySource) -> Option<Self> {
        let description = machine.description();
        let effort = smoothed.signal(Signal::ControlEffort)?;
        let [reference, rate] = smoothed.acted_on.each_ref().map(Vec::as_slice);
        if reference.is_empty() {
            return None;
        }
        let velocity = match velocity {
            VelocitySource::Stated => None,
            VelocitySource::Logged => Some(smoothed.signal(Signal::Velocity)?),
        };
        Some(Self {
            controller: description.controller.as_ref()?,
            estimate: &description.encoder.velocity,
            effort: effort.to_vec(),
            reference,
            rate,
            position: smoothed.signal(Signal::Position)?,
            velocity,
            disturbance: smoothed.signal(Signal::DisturbanceVoltage),
            direction: &smoothed.direction,
            at: smoothed.inner.clone(),
            period_s: smoothed.period_s,
        })
    }

    /// A signal at the samples compared, `shift` samples later.
    fn at(&self, signal: &[f64], shift: isize) -> Vec<f64> {
        self.at.iter().map(|k| signal[k.saturating_add_signed(shift)]).collect()
    }

    /// Share of the effort that the law leaves; none where that is rounding.
    pub(super) fn left(&self) -> Option<f64> {
        let residual = self.residual(Signal::ControlEffort, 0);
        let left = dot(&residual, &residual) / spread(&self.compared_effort());
        (left > EXACT).then_some(left)
    }

    /// The same with a further term.
    pub(super) fn left_with(&self, term: Option<Vec<f64>>) -> Option<f64> {
        let effort = self.compared_effort();
        let residual = Basis::of(self.own_columns().into_iter().chain([term?])).residual(effort.clone());
        Some(dot(&residual, &residual) / spread(&effort))
    }

    /// The effort at the samples compared.
    pub(super) fn compared_effort(&self) -> Vec<f64> {
        self.at(&self.effort, 0)
    }

    /// The terms of the law at the samples compared.
    pub(super) fn own_columns(&self) -> Vec<Vec<f64>> {
        self.own_columns_of([self.reference, self.rate])
    }

    fn own_columns_of(&self, references: [&[f64]; 2]) -> Vec<Vec<f64>> {
        let estimate = || estimated(self.estimate, self.position, self.period_s);
        let velocity = self.velocity.map_or_else(estimate, <[f64]>::to_vec);
        let mut columns = self.columns(references, self.position, &velocity);
        columns.extend(self.disturbance.map(<[f64]>::to_vec));
        columns.iter().map(|column| self.at(column, 0)).collect()
    }

    /// Which of these terms is the reference's velocity: a constant and the position error stand before it (see [`Self::columns`]).
    pub(super) fn rate_column(&self) -> Option<usize> {
        (!matches!(self.controller, Controller::Pdf(_))).then_some(2)
    }

    /// The reference's acceleration, as the law's filters pass it, at the samples compared.
    pub(super) fn acceleration(&self) -> Option<Vec<f64>> {
        self.filtered_column(differences(self.reference, self.period_s).1)
    }

    /// The position's acceleration, likewise.
    pub(super) fn measured_acceleration(&self) -> Option<Vec<f64>> {
        self.filtered_column(differences(self.position, self.period_s).1)
    }

    /// The sign of the reference's velocity, likewise; none where it is not known sample by sample.
    pub(super) fn direction(&self) -> Option<Vec<f64>> {
        let is_known = self.direction.len() == self.reference.len();
        is_known.then(|| self.filtered_column(self.direction.to_vec())).flatten()
    }

    fn filtered_column(&self, column: Vec<f64>) -> Option<Vec<f64>> {
        let filters = Filters::new(self.controller.filters(), self.period_s);
        filtered(vec![column], &filters).first().map(|column| self.at(column, 0))
    }

    /// What the law leaves of the effort when a reference acts `samples` later on it than logged.
    pub(super) fn residual_late(&self, what: Late, samples: isize) -> Vec<f64> {
        let reference = match what {
            Late::VelocityReference => self.reference.to_vec(),
            Late::References => shifted(self.reference, -samples),
        };
        let rate = shifted(self.rate, -samples);
        let basis = Basis::of(self.own_columns_of([&reference, &rate]));
        basis.residual(self.compared_effort())
    }

    /// What the law leaves of the effort when one channel is taken `shift` samples later.
    fn residual(&self, moved: Signal, shift: isize) -> Vec<f64> {
        let of = |signal| if signal == moved { shift } else { 0 };
        let [reference, rate] =
            [self.reference, self.rate].map(|signal| shifted(signal, of(Signal::PositionReference)));
        let position = shifted(self.position, of(Signal::Position));
        let velocity = match self.velocity {
            // Position and velocity come from one sensor.
            Some(velocity) => shifted(velocity, of(Signal::Position)),
            None => estimated(self.estimate, &position, self.period_s),
        };
        let mut columns = self.columns([&reference, &rate], &position, &velocity);
        columns.extend(self.disturbance.map(<[f64]>::to_vec));
        let basis = Basis::of(columns.iter().map(|column| self.at(column, 0)));
        basis.residual(self.at(&self.effort, of(Signal::ControlEffort)))
    }

    fn columns(&self, [reference, rate]: [&[f64]; 2], position: &[f64], velocity: &[f64]) -> Vec<Vec<f64>> {
        let count = reference.len();
        let error: Vec<f64> = reference.iter().zip(position).map(|(r, x)| r - x).collect();
        let proportional = match self.controller {
            Controller::Pdf(_) => vec![velocity.to_vec()],
            Controller::Cascade(_) | Controller::Pd(_) => {
                vec![error.clone(), rate.to_vec(), velocity.to_vec()]
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
