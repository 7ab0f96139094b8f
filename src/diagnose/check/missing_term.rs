//! A feed-forward or a lag of the reference that the control law does not state: the effort tells it, computed from reference and position.

use super::law::{FITS, Late, Relation, VelocitySource, is_clearly_less};
use super::projection::{Basis, Coefficient, spread};
use super::shift::Shift;
use super::smoothed::Smoothed;
use super::{Check, Finding};
use crate::diagnose::scalar_product::dot;
use crate::diagnose::thresholds::{BEYOND_CHANCE, LARGELY};
use crate::machine::Machine;
use crate::recording::Signal;
use crate::units::{Motion, engineering};

/// A velocity reference that acts earlier or later than the law computes it by no more than so many samples is told otherwise than by a backward difference:
/// a central one acts half a sample earlier. The bound is half way from there to a whole sample.
const CONVENTION: f64 = 0.75;

/// A term of the reference that the law does not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Term {
    /// Its acceleration.
    Acceleration,
    /// The sign of its velocity.
    Direction,
}

/// What the effort holds beyond the control law.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Holds {
    /// So much per unit of the reference's acceleration, in V·s²/m or V·s²/rad, and in the direction of its velocity, in V.
    Terms([Option<f64>; 2]),
    /// A reference that acts so much later than logged, in s; none where either may be late.
    Late(Option<Late>, f64),
}

/// What the effort holds, and the share of its power that stays unexplained.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Missing {
    holds: Holds,
    left: f64,
}

/// What closes nine tenths of the power that the law leaves of the effort; none where the law leaves rounding, or nothing does.
///
/// # Model
/// As in [`law`](super::law::law), the gains are left free. A feed-forward of acceleration or friction is a term more, whose coefficient is five standard
/// errors from zero; an acceleration has a positive one. A lag of the velocity reference alone, or of both references, is found as the shift that leaves
/// least. Of those that close as much the one that leaves least is told, of two terms only where one is not enough.
///
/// # Validity
/// Gains that stay the same over the run; effort and reference in time with each other. Where the axis follows closely, the free gains take a share of an acceleration:
/// its size is too small then, by an eighth on a screw axis.
pub fn missing(machine: &Machine, smoothed: &Smoothed) -> Option<Missing> {
    let relation = Relation::of(machine, smoothed, VelocitySource::Stated)?;
    let before = relation.left()?;
    // Another velocity estimate than stated is an effect of the catalogue: it acts by the acceleration of the position.
    let estimate = relation.left_with(relation.measured_acceleration())?;
    let closes = |missing: &Missing| {
        missing.left < FITS
            && missing.left <= (1.0 - LARGELY) * before
            && is_clearly_less(missing.left, estimate)
    };
    let of = |terms: &[Term]| with_terms(&relation, terms, smoothed.period_s).filter(closes);
    let late = |what: Late| late(&relation, what, smoothed).filter(closes);
    let late = either(late(Late::VelocityReference), late(Late::References));
    let one = [of(&[Term::Acceleration]), of(&[Term::Direction]), late];
    let least = one.into_iter().flatten().min_by(|a, b| a.left.total_cmp(&b.left));
    least.or_else(|| of(&[Term::Acceleration, Term::Direction]))
}

/// The one that leaves clearly less; where neither does, either may be late, by as much as the better one says.
fn either(one: Option<Missing>, other: Option<Missing>) -> Option<Missing> {
    let (Some(first), Some(second)) = (one, other) else { return one.or(other) };
    let (better, worse) = if first.left <= second.left { (first, second) } else { (second, first) };
    match better.holds {
        Holds::Late(_, lag) if !is_clearly_less(better.left, worse.left) => {
            Some(Missing { holds: Holds::Late(None, lag), ..better })
        }
        _ => Some(better),
    }
}

fn late(relation: &Relation, what: Late, smoothed: &Smoothed) -> Option<Missing> {
    let variance = spread(&relation.compared_effort());
    let shift = Shift::find(smoothed.most_shift, variance, |samples| relation.residual_late(what, samples))?;
    let is_late = shift.samples > CONVENTION && shift.samples >= BEYOND_CHANCE * shift.standard_error;
    let lag = shift.samples * smoothed.period_s;
    is_late.then_some(Missing { holds: Holds::Late(Some(what), lag), left: shift.after })
}

fn with_terms(relation: &Relation, terms: &[Term], period_s: f64) -> Option<Missing> {
    let column = |term: &Term| match term {
        Term::Acceleration => relation.acceleration(),
        Term::Direction => relation.direction(),
    };
    let extra: Vec<Vec<f64>> = terms.iter().map(column).collect::<Option<_>>()?;
    let (own, effort) = (relation.own_columns(), relation.compared_effort());
    let coefficient = |of: &[f64]| {
        let others = own.iter().chain(&extra).filter(|column| column.as_slice() != of).cloned();
        Coefficient::of(of, &Basis::of(others), &effort)
    };
    let mut found = [None; 2];
    for (term, column) in terms.iter().zip(&extra) {
        let value = coefficient(column).filter(|found| found.significance() >= BEYOND_CHANCE)?.value;
        found[usize::from(*term == Term::Direction)] = Some(value);
    }
    let rate = relation.rate_column().and_then(|k| coefficient(&own[k]));
    let per_velocity =
        rate.filter(|rate| rate.significance() >= BEYOND_CHANCE).map_or(0.0, |rate| rate.value);
    let is_lead = |value: f64| value > CONVENTION * period_s * per_velocity.max(0.0);
    if found[0].is_some_and(|acceleration| !is_lead(acceleration)) {
        return None;
    }
    let rest = Basis::of(own.iter().chain(&extra).cloned()).residual(effort.clone());
    Some(Missing { holds: Holds::Terms(found), left: dot(&rest, &rest) / spread(&effort) })
}

impl Missing {
    fn is_like(&self, other: &Self) -> bool {
        match (self.holds, other.holds) {
            (Holds::Late(..), Holds::Late(..)) => true,
            (Holds::Terms(one), Holds::Terms(another)) => {
                let signs = |terms: [Option<f64>; 2]| terms.map(|term| term.map(|value| value > 0.0));
                signs(one) == signs(another)
            }
            _ => false,
        }
    }

    fn sentence(&self, motion: Motion) -> String {
        let unit = Signal::Position.si_unit(motion);
        let (what, remedy) = match self.holds {
            Holds::Late(what, lag) => {
                let by = engineering(lag, "s");
                match what {
                    None => (
                        format!("a velocity feed-forward, or a reference, that acts {by} later than logged"),
                        "log both references as the controller has them, or state [reference] delay_s",
                    ),
                    Some(Late::VelocityReference) => (
                        format!("a velocity feed-forward that acts {by} later than the logged reference"),
                        "log the velocity reference as the controller has it",
                    ),
                    Some(Late::References) => (
                        format!(
                            "a reference that acts {by} later than logged: the drive delays or smooths it"
                        ),
                        "log the reference as the controller has it, or state [reference] delay_s",
                    ),
                }
            }
            Holds::Terms([acceleration, direction]) => {
                let volts = |value: f64| engineering(value, "V");
                let acceleration = acceleration.map(|value| {
                    format!(
                        "a feed-forward of {} per {unit}/s² of the reference's acceleration",
                        volts(value)
                    )
                });
                let direction = direction.map(|value| {
                    format!("a feed-forward of {} in the direction of the commanded motion", volts(value))
                });
                let both: Vec<String> = acceleration.into_iter().chain(direction).collect();
                (both.join(" and "), "log what is fed forward as disturbance_v, which the effort holds too")
            }
        };
        format!(
            "The control law does not give the logged effort from the logged reference and position. It would with {what}. No effect of the catalogue \
             is that: {remedy}."
        )
    }
}

/// One finding for the recording, where most of its runs hold the same: the numbers of the run that leaves least.
pub fn finding(runs: &[Option<Missing>], motion: Motion) -> Option<Finding> {
    let all: Vec<&Missing> = runs.iter().flatten().collect();
    let best = all.iter().min_by(|a, b| a.left.total_cmp(&b.left))?;
    let alike = all.iter().filter(|missing| missing.is_like(best)).count();
    (2 * alike > runs.len()).then(|| Finding::warning("", Check::ControlLaw, best.sentence(motion)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn missing(holds: Holds, left: f64) -> Option<Missing> {
        Some(Missing { holds, left })
    }

    #[test]
    fn exact_what_is_held_is_told_in_its_unit() {
        let text = |holds| missing(holds, 0.0).unwrap().sentence(Motion::Prismatic);
        assert!(
            text(Holds::Terms([Some(4.0), None])).contains("4.00 V per m/s² of the reference's acceleration")
        );
        assert!(text(Holds::Terms([None, Some(1.0)])).contains("1.00 V in the direction of"));
        let late = Holds::Late(Some(Late::References), 875e-6);
        assert!(text(late).contains("a reference that acts 875 µs later than logged"));
    }

    #[test]
    fn exact_most_runs_must_hold_the_same() {
        let forward = missing(Holds::Terms([Some(4.0), None]), 1e-4);
        let late = missing(Holds::Late(Some(Late::VelocityReference), 1e-3), 1e-5);
        let found =
            |runs: &[Option<Missing>]| finding(runs, Motion::Prismatic).map(|finding| finding.message);
        assert!(found(&[forward, forward, None]).unwrap().contains("4.00 V"));
        assert_eq!(found(&[forward, None]), None);
        assert_eq!(found(&[forward, forward, late]), None);
        assert_eq!(found(&[]), None);
    }
}
