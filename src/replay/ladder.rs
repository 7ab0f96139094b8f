//! A feed-forward put together term by term: what each leaves to the feedback, by the twin and as measured.

use super::compared::{as_set, check};
use super::feedforward::Direction;
use super::{Feedforward, Recorded};
use crate::effect::Constants;
use crate::error::{Error, ErrorKind, Result};
use crate::machine::Machine;
use crate::plant::Load;
use crate::plant::axis::Axis;
use crate::recording::{Run, Signal};
use crate::twin::Sensing;
use rayon::prelude::*;

/// The terms of a feed-forward, in the order in which they are added.
pub const TERMS: [&str; 4] = ["inertia", "viscous", "Coulomb", "weight"];

/// Samples count where the reference is faster than this share of its top speed in the run: near standstill dry friction is
/// anything, and what is fed forward for it switches.
pub const MOVING: f64 = 0.05;

/// What a feed-forward with some of the terms leaves to the feedback, as root mean square of the effort in V.
#[derive(Debug, Clone, PartialEq)]
pub struct Rung {
    /// Which of the [`TERMS`] are fed forward.
    pub terms: [bool; 4],
    /// Predicted along all runs, with the machine's own numbers.
    pub predicted_v: f64,
    /// What runs with this feed-forward measured.
    pub measured: Option<Measured>,
}

/// Feedback that was measured beside a stated feed-forward.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// The runs' names.
    pub runs: Vec<String>,
    /// Root mean square of the logged effort in V.
    pub effort_v: f64,
    /// The same of the twin with the numbers that the runs state.
    pub as_stated_v: f64,
}

/// The ladder of a feed-forward.
///
/// # Model
/// Of a machine with inertia J (or mass), steady friction R(v) and weight W(q):
/// ```text
///   F = J·a_ref + c·v_ref + F_c·sgn(v) − W(q_ref)
///   (F_c, c) = argmin Σ (½(R(v_k) + R(−v_k)) − F_c − c·|v_k|)²     over the moving samples of all references
/// ```
/// Every rung has one term more; its effort is that of the twin's closed loop on the reduced axis, with perfect sensors,
/// along the recorded references. Root mean squares are over the samples of all runs at which the reference moves
/// ([`MOVING`]).
///
/// # Validity
/// What is fed forward is exact where friction is Coulomb and viscous. Other laws (Stribeck, bristles, loads) are taken at
/// their mean over both directions, along the speeds of the recording; friction in proportion to what a transmission
/// transmits is not fed forward.
///
/// # Source
/// Siciliano, Sciavicco, Villani, Oriolo, *Robotics*, sections 8.3 and 8.5.1.
#[derive(Debug, Clone, PartialEq)]
pub struct Ladder {
    /// All terms with the machine's own numbers.
    pub own: Feedforward,
    /// Whether the machine has weight along its joint.
    pub has_weight: bool,
    /// None, + inertia, + viscous, + Coulomb, + weight where there is any; then what else runs state.
    pub rungs: Vec<Rung>,
    /// Root mean square of logged less predicted effort in V, of the runs with the fewest terms fed forward: what the twin
    /// leaves unexplained; none where no run has a logged effort.
    pub unexplained_v: Option<f64>,
}

/// A run ready to be replayed.
struct Subject<'a> {
    run: &'a Run,
    machine: Machine,
    recorded: Recorded,
    stated: Feedforward,
    /// Samples that count.
    moving: Vec<usize>,
}

/// Sum of squares and their number.
#[derive(Debug, Clone, Copy, Default)]
struct Squares(f64, usize);

impl Squares {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        values.fold(Self::default(), |sum, value| Self(sum.0 + value * value, sum.1 + 1))
    }

    fn root_mean(all: impl IntoIterator<Item = Self>) -> f64 {
        let Self(sum, count) = all.into_iter().fold(Self::default(), |a, b| Self(a.0 + b.0, a.1 + b.1));
        (sum / count.max(1) as f64).sqrt()
    }
}

impl<'a> Subject<'a> {
    fn of(run: &'a Run, machine: &Machine) -> Result<Self> {
        check(run, machine)?;
        let machine = as_set(run, machine)?;
        let recorded = Recorded::of(run, &machine)?;
        let speed = |k: usize| recorded.commands()[k].velocity_reference.abs();
        let top = (0..run.len()).map(speed).fold(0.0, f64::max);
        if top == 0.0 {
            let error = Error::new(ErrorKind::TooLittleData)
                .key(format!("{}.{}", run.name(), Signal::PositionReference.key(run.motion())))
                .found("a reference that does not move")
                .expected("a move, along which inertia and friction need an effort")
                .remedy("take the run out, or name the runs with --run");
            return Err(if run.file.as_os_str().is_empty() { error } else { error.file(&run.file) });
        }
        let moving = (0..run.len()).filter(|k| speed(*k) > MOVING * top).collect();
        Ok(Self { run, stated: Feedforward::of(run)?, machine, recorded, moving })
    }

    fn replay(&self, forward: &Feedforward) -> Vec<f64> {
        let axis = Axis::of(&self.machine.constants());
        forward.replay(&self.recorded, &self.machine, axis, Sensing::Perfect).traces.effort_v
    }

    fn squares(&self, effort_v: &[f64]) -> Squares {
        Squares::of(self.moving.iter().map(|k| effort_v[*k]))
    }

    fn speeds(&self) -> impl Iterator<Item = f64> + '_ {
        self.moving.iter().map(|k| self.recorded.commands()[*k].velocity_reference.abs())
    }

    fn logged(&self) -> Option<&[f64]> {
        self.run.signal(Signal::ControlEffort)
    }
}

impl Ladder {
    /// The ladder of a machine along the references of runs.
    ///
    /// # Errors
    /// No run; a machine without a control law; a run without position or position reference, or whose reference does not
    /// move; another sample period or kind of motion than the machine's; a stated feed-forward that cannot be told.
    pub fn of(runs: &[&Run], machine: &Machine) -> Result<Self> {
        if machine.description().controller.is_none() {
            return Err(machine
                .lacks_controller()
                .expected("the table [controller]: what the feedback commands is asked for")
                .remedy("state the control law that the drive runs"));
        }
        let subjects = runs.iter().map(|run| Subject::of(run, machine)).collect::<Result<Vec<_>>>()?;
        if subjects.is_empty() {
            return Err(Error::new(ErrorKind::TooLittleData)
                .key("run")
                .found("no run")
                .expected("at least one"));
        }
        let own = own(machine, &subjects);
        let has_weight = machine.weight().is_some();
        let count = if has_weight { TERMS.len() } else { TERMS.len() - 1 };
        let mut sets: Vec<[bool; 4]> = (0..=count).map(|n| std::array::from_fn(|k| k < n)).collect();
        let mut others: Vec<[bool; 4]> = subjects.iter().map(|subject| terms(&subject.stated)).collect();
        others.sort_unstable();
        others.dedup();
        others.retain(|set| !sets.contains(set));
        sets.extend(others);
        let rungs = sets.into_par_iter().map(|terms| Rung {
            terms,
            predicted_v: predicted(&some(&own, terms), &subjects),
            measured: Measured::of(terms, &subjects),
        });
        Ok(Self { rungs: rungs.collect(), own, has_weight, unexplained_v: unexplained(&subjects) })
    }
}

impl Measured {
    fn of(set: [bool; 4], subjects: &[Subject]) -> Option<Self> {
        let of_set: Vec<_> = subjects
            .iter()
            .filter(|subject| terms(&subject.stated) == set)
            .filter_map(|subject| Some((subject, subject.logged()?)))
            .collect();
        (!of_set.is_empty()).then(|| Self {
            runs: of_set.iter().map(|(subject, _)| subject.run.name().to_owned()).collect(),
            effort_v: Squares::root_mean(of_set.iter().map(|(subject, logged)| subject.squares(logged))),
            as_stated_v: Squares::root_mean(
                of_set.iter().map(|(subject, _)| subject.squares(&subject.replay(&subject.stated))),
            ),
        })
    }
}

fn predicted(forward: &Feedforward, subjects: &[Subject]) -> f64 {
    Squares::root_mean(subjects.iter().map(|subject| subject.squares(&subject.replay(forward))))
}

/// What the twin leaves of the logged effort of the runs with the fewest terms.
fn unexplained(subjects: &[Subject]) -> Option<f64> {
    let count = |subject: &Subject| terms(&subject.stated).iter().filter(|term| **term).count();
    let logged = || subjects.iter().filter_map(|subject| Some((subject, subject.logged()?)));
    let fewest = logged().map(|(subject, _)| count(subject)).min()?;
    let left = logged().filter(|(subject, _)| count(subject) == fewest).map(|(subject, logged)| {
        let replayed = subject.replay(&subject.stated);
        let left: Vec<f64> = logged.iter().zip(&replayed).map(|(a, b)| a - b).collect();
        subject.squares(&left)
    });
    Some(Squares::root_mean(left))
}

/// Which terms a feed-forward has.
fn terms(forward: &Feedforward) -> [bool; 4] {
    [forward.mass_kg != 0.0, forward.viscous_n_s_per_m != 0.0, forward.coulomb_n != 0.0, forward.weight]
}

/// Some of the terms.
fn some(own: &Feedforward, [inertia, viscous, coulomb, weight]: [bool; 4]) -> Feedforward {
    Feedforward {
        mass_kg: if inertia { own.mass_kg } else { 0.0 },
        viscous_n_s_per_m: if viscous { own.viscous_n_s_per_m } else { 0.0 },
        coulomb_n: if coulomb { own.coulomb_n } else { 0.0 },
        direction: own.direction,
        weight: weight && own.weight,
    }
}

/// All terms with the machine's numbers; the direction of the Coulomb part as runs state it.
fn own(machine: &Machine, subjects: &[Subject]) -> Feedforward {
    let [coulomb_n, viscous_n_s_per_m] = friction(machine, subjects.iter().flat_map(Subject::speeds));
    let is_measured = |s: &Subject| s.stated.coulomb_n != 0.0 && s.stated.direction == Direction::Measured;
    Feedforward {
        mass_kg: machine.constants().moving_mass,
        viscous_n_s_per_m,
        coulomb_n,
        direction: if subjects.iter().any(is_measured) { Direction::Measured } else { Direction::Reference },
        weight: machine.weight().is_some(),
    }
}

/// Coulomb and viscous part of the machine's steady friction over speeds, by least squares.
fn friction(machine: &Machine, speeds: impl Iterator<Item = f64>) -> [f64; 2] {
    let Constants { friction, viscous, .. } = machine.constants();
    let loads = match Load::of(machine) {
        Some(sliders @ Load::Sliders(_)) => sliders.usual(),
        // It follows the effort, which no speed tells.
        Some(Load::Transmitted(_)) | None => 0.0,
    };
    // The drag of the linear dynamics is set apart: what is left of a plain friction is then exactly its level.
    let rest = |speed: f64| {
        let loaded = loads * friction.load_coefficient;
        0.5 * (friction.level_under(loaded, 1.0, speed) + friction.level_under(loaded, -1.0, speed))
    };
    let points: Vec<[f64; 2]> = speeds.map(|speed| [speed, rest(speed)]).collect();
    let mean = |k: usize| points.iter().map(|point| point[k]).sum::<f64>() / points.len().max(1) as f64;
    let [middle, level] = [mean(0), mean(1)];
    let (mut spread, mut cross) = (0.0, 0.0);
    for [speed, rest] in &points {
        spread += (speed - middle).powi(2);
        cross += (speed - middle) * (rest - level);
    }
    let slope =
        if spread > 0.0 && points.iter().any(|p| p[1] != points[0][1]) { cross / spread } else { 0.0 };
    // An empty sum is −0.
    [level - slope * middle + 0.0, viscous + slope]
}
