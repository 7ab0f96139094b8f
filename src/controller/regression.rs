//! The gains that a controller ran with, from its recorded signals.

use super::regressor::{Gain, Step, Unknown};
use super::{Controller, Input};
use crate::error::{Error, ErrorKind, Result};
use crate::identify::excitation::Outcome;
use crate::identify::least_squares::{Estimate, LeastSquares, Regression};
use crate::identify::whiteness::Whiteness;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

const REMEDY: &str = "use strokes that accelerate, cruise and reverse, at several feeds; at rest or at constant speed the gains are not visible";
/// Deviation of the coefficient of u(k−1) from 1 that rounding alone explains.
const ROUNDING: f64 = 1e-9;
/// Gauss–Newton steps at most; a law that is linear in its unknown gains needs one.
const MOST_STEPS: usize = 40;
/// Relative change of the gains at which the steps end.
const CONVERGED: f64 = 1e-10;

/// What a controller saw and commanded in one run.
#[derive(Debug, Clone)]
pub struct ControllerRun {
    /// The law with the settings in force in this run.
    pub law: Controller,
    /// Sample period of the controller, s.
    pub period_s: f64,
    /// One a sample.
    pub inputs: Vec<Input>,
    /// u in V, one a sample, without a disturbance injected behind the controller.
    pub effort_v: Vec<f64>,
    /// Effort in V from which on a recorded one may be clipped: such samples are left out.
    pub limit_v: Option<f64>,
}

/// One identified gain.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IdentifiedGain {
    /// Key in the machine file, below `controller`.
    pub key: &'static str,
    /// What it multiplies.
    pub regressor: &'static str,
    /// The value stated.
    pub stated: f64,
    /// The value that the data show.
    pub estimate: Estimate,
    /// Where it is a gain per count: the stated content of the register, and the one with which the stated gain would
    /// command the same.
    pub register: Option<(i64, f64)>,
}

/// The gains that a controller ran with.
///
/// # Model
/// ```text
///   u(k) = ρ·u(k−1) + Σ gain_j·regressor_j(k) + e(k)
/// ```
/// (see [`Row`](super::regressor::Row)), linear least squares by QR. With unknown position gain and feed-forward the
/// regressors depend on the gains: Gauss–Newton from the stated ones. Intervals: Student's where e is white, else those
/// of [`Regression::with_correlated_residual`]. With an integral part ρ is an unknown too; it is 1
/// if the controller integrates as its law says. A controller without one has no such term.
///
/// # Validity
/// The recorder shows what the controller acted on, sample by sample. Noise that enters the velocity between
/// controller and recorder pulls the gains of velocity towards zero. A clipped effort is left out with its successor.
///
/// # Source
/// Liu, Lai, Yen (2009), section 3, eq. 10.
#[derive(Debug, Clone, Serialize)]
pub struct ControllerGains {
    /// In the order of [`Controller::unknown_gains`].
    pub gains: Vec<IdentifiedGain>,
    /// ρ.
    pub previous_effort: Option<Estimate>,
    /// Condition number of the column-scaled regressor.
    pub condition: f64,
    /// Standard deviation of e, V.
    pub residual_sd_v: f64,
    /// Share of the variance of u(k) − u(k−1) (of u(k) without an integral part) that the law explains.
    pub explained: f64,
    /// Samples less unknowns.
    pub degrees_of_freedom: usize,
    /// Samples left out because the effort may have been clipped.
    pub clipped: usize,
    /// Whether e is white; where it is not, the intervals take its autocorrelation into account.
    pub whiteness: Whiteness,
}

impl ControllerGains {
    /// Whether 1 lies in the interval of ρ, up to rounding; true for a law without an integral part.
    ///
    /// If not, the controller is not of this form, was saturated, or was recorded late or at another period.
    pub fn integrates_as_stated(&self) -> bool {
        self.previous_effort.is_none_or(|rho| rho.covers(1.0) || (rho.value - 1.0).abs() <= ROUNDING)
    }
}

/// Identifies the unknown gains of a law from runs of it; registers and other settings may differ from run to run.
///
/// # Errors
/// No run; signals of unequal length; numbers that are not finite; a gain that a register of 0 switches off; fewer than
/// five usable samples a gain; gains that run away.
pub fn gain_regression(runs: &[ControllerRun], unknown: Unknown) -> Result<Outcome<ControllerGains>> {
    let Some(first) = runs.first() else {
        return Err(Error::new(ErrorKind::TooLittleData)
            .found("no run")
            .expected("at least one run with reference, position and control effort")
            .remedy("log these signals"));
    };
    runs.iter().try_for_each(check)?;
    let stated = first.law.unknown_gains(unknown);
    acts(runs, unknown)?;
    let mut values: Vec<f64> = stated.iter().map(|gain| gain.stated).collect();
    for _ in 0..MOST_STEPS {
        let rows = rows(runs, unknown, &values);
        let regression = rows.regression(&stated, &values);
        let solution = match regression.solve(REMEDY)? {
            Outcome::Identified(solution) => solution,
            Outcome::NotExcited(why) => return Ok(Outcome::NotExcited(why)),
        };
        let next: Vec<f64> = solution.estimates.iter().take(values.len()).map(|e| e.value).collect();
        let moved = values.iter().zip(&next).any(|(a, b)| (a - b).abs() > CONVERGED * a.abs().max(b.abs()));
        values = next;
        if !moved {
            let told = told(runs, unknown, &stated);
            return rows.result(&told, &regression, &solution).map(Outcome::Identified);
        }
    }
    Err(Error::new(ErrorKind::Undetermined)
        .key("controller")
        .found(format!("gains that do not converge from the stated ones in {MOST_STEPS} steps"))
        .expected("a law near the stated one")
        .remedy(
            "check which law the controller runs, and that reference, position and effort are of one sample",
        ))
}

/// The gains as stated; a register only where it is the same in all runs.
fn told(runs: &[ControllerRun], unknown: Unknown, stated: &[Gain]) -> Vec<Gain> {
    let same = |(j, gain): (usize, &Gain)| {
        let is_same = runs.iter().all(|run| run.law.unknown_gains(unknown)[j].register == gain.register);
        Gain { register: gain.register.filter(|_| is_same), ..*gain }
    };
    stated.iter().enumerate().map(same).collect()
}

fn check(run: &ControllerRun) -> Result<()> {
    let (inputs, efforts) = (run.inputs.len(), run.effort_v.len());
    if inputs != efforts {
        return Err(Error::new(ErrorKind::Inconsistent)
            .key("control_effort_v")
            .found(format!("{efforts} samples beside {inputs} of the controller's inputs"))
            .expected("signals of one length")
            .remedy("cut all signals to the same samples"));
    }
    let finite = |input: &Input| {
        [input.position_reference, input.velocity_reference, input.position, input.velocity]
            .iter()
            .all(|x| x.is_finite())
    };
    match run.inputs.iter().zip(&run.effort_v).position(|(input, u)| !(finite(input) && u.is_finite())) {
        None => Ok(()),
        Some(k) => Err(Error::new(ErrorKind::NotFinite)
            .found(format!("a sample that is not a number (sample {k}, counted from 0)"))
            .expected("finite numbers")
            .remedy("cut the run there or repair the recording")),
    }
}

/// Refuses a gain that a register of 0 switches off in all runs.
fn acts(runs: &[ControllerRun], unknown: Unknown) -> Result<()> {
    let off: Vec<Vec<bool>> = runs
        .iter()
        .map(|run| run.law.unknown_gains(unknown).iter().map(|gain| gain.register == Some(0)).collect())
        .collect();
    let names = runs[0].law.unknown_gains(unknown);
    match (0..names.len()).find(|&j| off.iter().all(|run| run.get(j) == Some(&true))) {
        None => Ok(()),
        Some(j) => Err(Error::new(ErrorKind::OutOfRange)
            .key(format!("controller.{}", names[j].key))
            .found("a register of 0 in every run")
            .expected("a register other than 0")
            .remedy("identify on runs in which this path of the controller was switched on")),
    }
}

/// The regression at the present gains.
struct Rows {
    regressors: Vec<Vec<f64>>,
    previous: Vec<f64>,
    target: Vec<f64>,
    increments: Vec<f64>,
    lengths: Vec<usize>,
    has_integral: bool,
    clipped: usize,
}

fn rows(runs: &[ControllerRun], unknown: Unknown, values: &[f64]) -> Rows {
    let mut rows = Rows {
        regressors: Vec::new(),
        previous: Vec::new(),
        target: Vec::new(),
        increments: Vec::new(),
        lengths: Vec::new(),
        has_integral: runs[0].law.integrates(),
        clipped: 0,
    };
    for run in runs {
        let law = run.law.with_unknown_gains(unknown, values);
        let is_clipped = |k: usize| run.limit_v.is_some_and(|limit| run.effort_v[k].abs() >= limit);
        let before = rows.target.len();
        for k in 1..run.inputs.len() {
            if is_clipped(k) || (rows.has_integral && is_clipped(k - 1)) {
                rows.clipped += 1;
                continue;
            }
            let step = Step { before: run.inputs[k - 1], now: run.inputs[k], period_s: run.period_s };
            let row = law.regress(unknown, step);
            rows.regressors.push(row.regressors);
            rows.previous.push(run.effort_v[k - 1]);
            rows.target.push(run.effort_v[k]);
            rows.increments.push(row.increment);
        }
        rows.lengths.push(rows.target.len() - before);
    }
    rows
}

impl Rows {
    /// target = u(k), less what the increment is beyond its own linearisation.
    fn regression(&self, gains: &[Gain], values: &[f64]) -> Regression {
        let columns = gains.len() + usize::from(self.has_integral);
        let mut regressor = DMatrix::zeros(self.target.len(), columns);
        let mut target = DVector::zeros(self.target.len());
        for (k, row) in self.regressors.iter().enumerate() {
            let linear: f64 = row.iter().zip(values).map(|(x, gain)| x * gain).sum();
            for (j, x) in row.iter().enumerate() {
                regressor[(k, j)] = *x;
            }
            if self.has_integral {
                regressor[(k, gains.len())] = self.previous[k];
            }
            target[k] = self.target[k] - self.increments[k] + linear;
        }
        let mut names: Vec<String> = gains.iter().map(|gain| gain.regressor.to_owned()).collect();
        if self.has_integral {
            names.push("u(k-1)".to_owned());
        }
        Regression { names, regressor, target }
    }

    fn result(
        &self,
        gains: &[Gain],
        regression: &Regression,
        solution: &LeastSquares,
    ) -> Result<ControllerGains> {
        let whiteness = self.whiteness(&solution.residuals);
        let robust = regression.with_correlated_residual(solution, &self.lengths)?;
        let solution = if whiteness.is_white() || solution.residual_sd == 0.0 { solution } else { &robust };
        let identified = gains.iter().zip(&solution.estimates).map(|(gain, &estimate)| IdentifiedGain {
            key: gain.key,
            regressor: gain.regressor,
            stated: gain.stated,
            estimate,
            register: gain.register.map(|n| (n, n as f64 * estimate.value / gain.stated)),
        });
        let whole = |k: usize| if self.has_integral { self.previous[k] } else { 0.0 };
        let changes = self.target.iter().enumerate().map(|(k, u)| u - whole(k));
        let power: f64 = changes.map(|change| change * change).sum();
        let left: f64 = solution.residuals.iter().map(|e| e * e).sum();
        Ok(ControllerGains {
            gains: identified.collect(),
            previous_effort: self.has_integral.then(|| solution.estimates[gains.len()]),
            condition: solution.condition,
            residual_sd_v: solution.residual_sd,
            explained: if power > 0.0 { 1.0 - left / power } else { 0.0 },
            degrees_of_freedom: solution.degrees_of_freedom,
            clipped: self.clipped,
            whiteness,
        })
    }

    fn whiteness(&self, residuals: &[f64]) -> Whiteness {
        let mut rest = residuals;
        let cut = |&length: &usize| {
            let (run, behind) = rest.split_at(length);
            rest = behind;
            run
        };
        let by_run: Vec<&[f64]> = self.lengths.iter().map(cut).collect();
        Whiteness::of(&by_run)
    }
}
