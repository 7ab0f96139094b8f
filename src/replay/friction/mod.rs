//! What is hard to measure on a machine, estimated from a recording: the dry friction of its guide and the acceleration time
//! of its reference generator.

mod coarse;
mod held;
mod interval;
mod profile;
mod subject;

use super::compared::Agreement;
use crate::error::{Error, ErrorKind, Result};
use crate::identify::excitation::Outcome;
use crate::identify::least_squares::Estimate;
use crate::identify::nonlinear::{Solution, Unknown, solve};
use crate::machine::Machine;
use crate::plant::LoadModel;
use crate::recording::{Run, Signal};
use crate::twin::Sensing;
use coarse::{Coarse, largest_force};
pub use held::{Held, held};
use interval::{Spread, spread};
use nalgebra::DVector;
use profile::{Profile, Strokes};
use rayon::prelude::*;
use subject::{Subject, range};

/// Fits with noise taken anew from the twin as fitted before.
const PASSES: usize = 3;
/// Step of a derivative by acceleration time or start, in sample periods.
const TIME_STEP: f64 = 0.2;
/// Step of a derivative by friction, as a share of the largest force; by the reference before the first stroke, of the
/// stroke.
const FORCE_STEP: f64 = 1e-3;
const BASE_STEP: f64 = 1e-6;
/// What to do where the data do not tell the numbers apart.
const REMEDY: &str = "record strokes at several feeds, or leave viscous drag as stated";

/// Numbers of one replay.
#[derive(Debug, Clone, PartialEq)]
struct Numbers {
    ramp_s: f64,
    coulomb: f64,
    viscous: Option<f64>,
    starts: Vec<f64>,
    base: f64,
    /// By how much the start is off what the first samples show: position, and commanded voltage.
    start_off: [f64; 2],
}

/// What one run tells by itself.
#[derive(Debug, Clone, PartialEq)]
pub struct RunFriction {
    /// Its name.
    pub name: String,
    /// When its strokes begin, in s from its first sample; empty where the twin follows the logged reference.
    pub starts_s: Vec<f64>,
    /// Acceleration time read off the logged reference, in s.
    pub reference_acceleration_time_s: Option<f64>,
    /// How far position and force of the fitted twin are off.
    pub agreement: Vec<Agreement>,
}

/// Dry friction and acceleration time, from a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Friction {
    /// Coulomb friction F_c in N, or N·m for a revolute axis.
    pub coulomb: Estimate,
    /// Viscous coefficient in N·s/m or N·m·s/rad, where it was asked for.
    pub viscous: Option<Estimate>,
    /// Acceleration time of the reference in s, from the measured signals; none where no run states stroke and feed.
    pub acceleration_time_s: Option<Estimate>,
    /// Force N that presses the moving part on its guide, in N: the sum of the slider loads at rest, where the machine has
    /// sliders.
    pub normal_force_n: Option<f64>,
    /// μ = F_c/N.
    pub coefficient: Option<Estimate>,
    /// The runs.
    pub runs: Vec<RunFriction>,
    /// Condition number of the column-scaled Jacobian.
    pub condition: f64,
    /// Residuals that were fitted.
    pub samples: usize,
    /// Independent residuals that would tell the Coulomb friction as well.
    pub effective_samples: f64,
    /// Root mean square of the residuals over what the stated sensor noise makes of them: 1 where the twin fits; none where no
    /// noise is stated.
    pub misfit: Option<f64>,
}

/// Residuals beyond so many times the stated noise: the twin does not fit.
const MISFIT: f64 = 3.0;

impl Friction {
    /// Whether what is left is far more than the stated noise: the numbers then lean on a twin that is wrong elsewhere, and
    /// their intervals do not hold that.
    pub fn is_misfit(&self) -> bool {
        self.misfit.is_some_and(|misfit| misfit > MISFIT)
    }

    /// Runs whose logged reference has another acceleration time than was found, beyond the interval and half a sample period.
    pub fn other_ramps(&self, sample_period_s: f64) -> Vec<&RunFriction> {
        let Some(Estimate { ci95: [from, to], .. }) = self.acceleration_time_s else { return Vec::new() };
        let half = 0.5 * sample_period_s;
        let is_other = |run: &&RunFriction| {
            run.reference_acceleration_time_s.is_some_and(|read| read < from - half || read > to + half)
        };
        self.runs.iter().filter(is_other).collect()
    }
}

/// Estimates Coulomb friction, acceleration time and, where asked for, the viscous coefficient.
///
/// # Model
/// The twin on the reduced axis follows, in closed loop with perfect sensors and under each run's settings, the reference
/// that its generator would make: strokes of trapezoidal velocity with acceleration time T_a. Wanted are T_a, F_c in
/// `F = −F_c·sgn(v)`, c in `F = −c·v`, and, where the reference was not logged, the start of each stroke and the reference
/// before it; and of each run by how much position and effort at its start are off the means over its first standstill, which
/// the loop's noise moves slowly:
/// ```text
///   θ = argmin Σ_runs Σ_k ((x − x̂(θ))/σ_x)² + ((F − F̂(θ))/σ_F)²
/// ```
/// with x the position and F thrust, else current, else effort; σ(t) from the stated sensor noise carried through the
/// loop. μ = F_c/N.
/// Positive force acts along positive position.
///
/// # Validity
/// Intervals are of noise and of the reduction to one axis. Mass, motor constants and gains are as the machine states them:
/// errors of theirs go into the numbers, not into the intervals; [`held`] says how far. Friction is Coulomb's. μ takes N as the weight on the sliders: a preloaded guide presses harder, and its true
/// coefficient is smaller.
///
/// # Source
/// Nonlinear output-error identification: Ljung, *System Identification*, 2nd ed., sections 7.2 and 9.
///
/// # Errors
/// A machine without controller; a run that neither states stroke and feed nor logs its reference, that stands still or
/// moves at one speed only, that does not make the stroke it states, or lacks position or every measure of force; numbers
/// that the recording does not tell apart.
pub fn identify(runs: &[&Run], machine: &Machine, with_viscous: bool) -> Result<Friction> {
    let mut subjects: Vec<Subject> =
        runs.iter().map(|run| Subject::of(run, machine)).collect::<Result<_>>()?;
    let mut problem = Problem::of(&subjects, machine, with_viscous)?;
    let mut solution = problem.fit(&subjects)?;
    let mut draws = Vec::new();
    for _ in 1..PASSES {
        let all = problem.numbers(&solution.values, &subjects);
        draws = subjects.par_iter().zip(&all).map(|(s, n)| s.noise(n)).collect::<Result<Vec<_>>>()?;
        for ((subject, numbers), draws) in subjects.iter_mut().zip(&all).zip(&draws) {
            subject.weigh(numbers, draws)?;
        }
        problem.start_at(&solution.values);
        solution = problem.fit(&subjects)?;
    }
    let all = problem.numbers(&solution.values, &subjects);
    let scene = subjects.par_iter().zip(&all).map(|(subject, numbers)| subject.change_on_scene(numbers));
    let spread = spread(&solution, &subjects, &draws, scene.collect::<Result<Vec<_>>>()?.concat())?;
    problem.conclude(&solution, &spread, &subjects, machine)
}

/// An error about a run.
fn refused(run: &Run, kind: ErrorKind, key: &str) -> Error {
    let error = Error::new(kind).key(format!("{}.{key}", run.name()));
    if run.file.as_os_str().is_empty() { error } else { error.file(&run.file) }
}

/// What the start of a run is off: its position, and its effort where that was logged.
fn start_off(subject: &Subject) -> Vec<Unknown> {
    let all = (f64::NEG_INFINITY, f64::INFINITY);
    let of = |word: &str, step: f64| Unknown {
        name: format!("{word} of {}", subject.run.name()),
        start: 0.0,
        range: all,
        step,
    };
    let mut list = vec![of("position at the start", BASE_STEP * range(subject.recorded(0)))];
    if subject.has_start_effort() {
        let effort = subject.run.signal(Signal::ControlEffort).unwrap_or_default();
        list.push(of("effort at the start", FORCE_STEP * range(effort).max(f64::MIN_POSITIVE)));
    }
    list
}

/// The unknown numbers and where they stand among the values.
struct Problem {
    unknowns: Vec<Unknown>,
    has_ramp: bool,
    has_viscous: bool,
}

impl Problem {
    fn of(subjects: &[Subject], machine: &Machine, with_viscous: bool) -> Result<Self> {
        let period_s = machine.description().sample_period_s;
        let constants = machine.constants();
        let strokes = subjects.iter().filter_map(|s| match &s.profile {
            Profile::Strokes(strokes) => Some(strokes),
            Profile::Logged(_) => None,
        });
        let strokes: Vec<&Strokes> = strokes.collect();
        let force = largest_force(subjects, &constants);
        let coarse = Coarse::of(subjects, machine, force)?;
        let unknown = |name: &str, start, range, step| Unknown { name: name.to_owned(), start, range, step };
        let mut unknowns = Vec::new();
        if !strokes.is_empty() {
            let slowest = strokes.iter().flat_map(|s| &s.strokes).map(|s| s.stroke.abs() / s.feed);
            let longest = 10.0 * slowest.fold(0.0, f64::max);
            let step = TIME_STEP * period_s;
            unknowns.push(unknown("acceleration time", coarse.ramp_s, (0.5 * period_s, longest), step));
        }
        let step = FORCE_STEP * force;
        unknowns.push(unknown("Coulomb friction", coarse.coulomb, (0.0, f64::INFINITY), step));
        if with_viscous {
            let fastest = strokes.iter().flat_map(|s| &s.strokes).map(|s| s.feed).fold(0.0, f64::max);
            let step = FORCE_STEP * force / if fastest > 0.0 { fastest } else { 1.0 };
            unknowns.push(unknown("viscous drag", constants.viscous, (0.0, f64::INFINITY), step));
        }
        for (subject, starts) in subjects.iter().zip(&coarse.starts) {
            unknowns.extend(start_off(subject));
            let Some(strokes) = subject.unknown() else { continue };
            let name = subject.run.name();
            let end = subject.run.duration_s();
            for start in starts {
                unknowns.push(unknown(
                    &format!("start of {name}"),
                    *start,
                    (-end, end),
                    TIME_STEP * period_s,
                ));
            }
            let step = BASE_STEP * strokes.strokes.iter().map(|s| s.stroke.abs()).fold(0.0, f64::max);
            let all = (f64::NEG_INFINITY, f64::INFINITY);
            unknowns.push(unknown(&format!("reference before {name}"), strokes.base, all, step));
        }
        Ok(Self { unknowns, has_ramp: !strokes.is_empty(), has_viscous: with_viscous })
    }

    fn start_at(&mut self, values: &[f64]) {
        self.unknowns.iter_mut().zip(values).for_each(|(unknown, value)| unknown.start = *value);
    }

    fn coulomb(&self) -> usize {
        usize::from(self.has_ramp)
    }

    /// The numbers of each run.
    fn numbers(&self, values: &[f64], subjects: &[Subject]) -> Vec<Numbers> {
        let coulomb = self.coulomb();
        let mut next = coulomb + 1 + usize::from(self.has_viscous);
        let of = |subject: &Subject| {
            let mut numbers = Numbers {
                ramp_s: values[0],
                coulomb: values[coulomb],
                viscous: self.has_viscous.then(|| values[coulomb + 1]),
                starts: Vec::new(),
                base: 0.0,
                start_off: [values[next], 0.0],
            };
            next += 1;
            if subject.has_start_effort() {
                numbers.start_off[1] = values[next];
                next += 1;
            }
            if let Some(strokes) = subject.unknown() {
                let count = strokes.strokes.len();
                numbers.starts = values[next..next + count].to_vec();
                numbers.base = values[next + count];
                next += count + 1;
            } else if let Profile::Strokes(strokes) = &subject.profile {
                numbers.starts.clone_from(&strokes.start_s);
                numbers.base = strokes.base;
            }
            numbers
        };
        subjects.iter().map(of).collect()
    }

    fn fit(&self, subjects: &[Subject]) -> Result<Solution> {
        let residuals = |values: &[f64]| {
            let numbers = self.numbers(values, subjects);
            let each = subjects.par_iter().zip(&numbers).map(|(subject, numbers)| subject.residuals(numbers));
            Ok(DVector::from_vec(each.collect::<Result<Vec<_>>>()?.concat()))
        };
        match solve(&self.unknowns, REMEDY, residuals)? {
            Outcome::Identified(solution) => Ok(solution),
            Outcome::NotExcited(refusal) => Err(Error::new(ErrorKind::Undetermined)
                .found(refusal.to_string())
                .expected("a recording that tells the numbers apart")
                .remedy(REMEDY)),
        }
    }

    fn conclude(
        &self,
        solution: &Solution,
        spread: &Spread,
        subjects: &[Subject],
        machine: &Machine,
    ) -> Result<Friction> {
        let estimate = |k: usize| {
            let (value, standard_error) = (solution.values[k], spread.standard_errors[k]);
            let half = spread.quantile * standard_error;
            let from = (value - half).max(self.unknowns[k].range.0);
            Estimate { value, standard_error, ci95: [from, value + half] }
        };
        let coulomb = estimate(self.coulomb());
        let normal_force_n = LoadModel::of(machine).map(|model| model.loads([0.0; 2]).iter().sum::<f64>());
        let all = self.numbers(&solution.values, subjects);
        let runs = subjects.iter().zip(&all).map(|(subject, numbers)| {
            let twin = subject.replay(numbers, Sensing::Perfect)?;
            let of = |k: usize| {
                let predicted = twin.signal(subject.signals[k]).unwrap_or_default();
                Agreement::between(subject.signals[k], subject.recorded(k), predicted)
            };
            Ok(RunFriction {
                name: subject.run.name().to_owned(),
                starts_s: numbers.starts.clone(),
                reference_acceleration_time_s: match &subject.profile {
                    Profile::Strokes(strokes) => strokes.read_s,
                    Profile::Logged(_) => None,
                },
                agreement: vec![of(0), of(1)],
            })
        });
        Ok(Friction {
            coulomb,
            viscous: self.has_viscous.then(|| estimate(self.coulomb() + 1)),
            acceleration_time_s: self.has_ramp.then(|| estimate(0)),
            normal_force_n,
            coefficient: normal_force_n.map(|force| Estimate {
                value: coulomb.value / force,
                standard_error: coulomb.standard_error / force,
                ci95: coulomb.ci95.map(|end| end / force),
            }),
            runs: runs.collect::<Result<_>>()?,
            condition: solution.condition,
            samples: solution.residuals.len(),
            effective_samples: spread.effective_samples[self.coulomb()],
            misfit: spread.misfit,
        })
    }
}
