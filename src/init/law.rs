//! Which control law the drive ran, with which gains and which velocity, from what it was told, read and commanded.

use nalgebra::{DMatrix, DVector};

use super::velocity::{along, candidates, forgets, refined};
use crate::controller::integer::IntegerGain;
use crate::controller::regression::{ControllerGains, ControllerRun, gain_regression};
use crate::controller::regressor::Unknown;
use crate::controller::{AntiWindup, Cascade, Controller, Input, Pd, Pdf};
use crate::error::Result;
use crate::identify::excitation::Outcome;
use crate::identify::least_squares::Regression;
use crate::recording::{Run, Signal};
use crate::sensor::VelocityEstimate;

/// Rows of the regressions that choose; the gains then come from all samples up to the second number.
const CHOOSING: usize = 3_000;
const MOST_SAMPLES: usize = 20_000;
/// A law must explain this share of the effort's changes: it computes from the very readings that were logged.
const LEAST_EXPLAINED: f64 = 0.9;
/// A law with more gains must leave less than this share of what the simpler one leaves.
const BETTER: f64 = 0.7;
/// The logged velocity is what the law used where it leaves less than this share of what any estimate leaves.
const LOGGED_BETTER: f64 = 0.7;
/// An integral part holds the effort before but for this share: less is no integral.
const HOLDS: f64 = 5e-3;
/// A reference may act so many samples late.
const MOST_DELAY: usize = 6;
/// Smoothings that are looked at more closely, and the steps of that.
const FEW: usize = 4;
const ROUGH_STEPS: usize = 10;
/// Steps to the last digit of a smoothing, each of which leaves 0.618 of the range.
const STEPS: usize = 36;
const REMEDY: &str = "record strokes that accelerate and reverse, at several feeds";

/// The laws that are tried, those with fewer gains first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Position P.
    P,
    /// Position P, velocity P; position PD is the same.
    Level,
    /// Pseudo-derivative feedback.
    Pdf,
    /// Position P, velocity PI.
    Pi,
}

impl Form {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::P, Self::Level, Self::Pdf, Self::Pi];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::P => "P",
            Self::Level => "P-P cascade (or PD)",
            Self::Pdf => "PDF",
            Self::Pi => "P-PI cascade",
        }
    }
}

/// A law that the log shows.
#[derive(Debug, Clone)]
pub struct FoundLaw {
    /// Its form.
    pub form: Form,
    /// With its gains; registers of a PDF law are 1, as only gain times register shows.
    pub controller: Controller,
    /// Gains with intervals, as the regression has them.
    pub gains: ControllerGains,
    /// The velocity that it computed with.
    pub velocity: VelocityEstimate,
    /// Whether that is the logged one, of which `velocity` is then the nearest estimate.
    pub is_logged: bool,
    /// Samples by which the reference acts late.
    pub reference_delay: usize,
}

/// What the search says.
#[derive(Debug, Clone)]
pub enum LawFound {
    /// A law that computes the effort.
    Law(Box<FoundLaw>),
    /// No law: why.
    None(String),
}

/// One run as a law sees it, but for the velocity.
struct Seen<'a> {
    reference: &'a [f64],
    position: &'a [f64],
    velocity: Option<&'a [f64]>,
    effort: Vec<f64>,
}

struct Search<'a> {
    runs: Vec<Seen<'a>>,
    period_s: f64,
    limit_v: Option<f64>,
    stride: usize,
}

/// Where the velocity comes from.
#[derive(Debug, Clone)]
enum Source {
    Estimate(VelocityEstimate),
    Logged,
}

/// The law of the runs.
///
/// # Model
/// For each form and each velocity estimate the effort, or its change where the form integrates, is a linear combination of
/// reference, reading, velocity and their changes; least squares choose estimate and delay of the reference. The gains then come
/// from [`gain_regression`], which computes with the law of the twin.
///
/// # Errors
/// As [`gain_regression`].
pub fn law(runs: &[Run], limit_v: Option<f64>) -> Result<LawFound> {
    let Some(search) = Search::of(runs, limit_v) else {
        return Ok(LawFound::None(
            "position reference, position and control effort are not all logged".to_owned(),
        ));
    };
    let mut best: Option<FoundLaw> = None;
    let mut tried = Vec::new();
    for form in Form::ALL {
        let Some((source, delay)) = search.choose(form) else { continue };
        let Some(found) = search.gains(form, &source, delay)? else { continue };
        tried.push(format!("{} {:.1} %", form.name(), 100.0 * found.gains.explained.max(0.0)));
        let is_better = |before: &FoundLaw| {
            let floor = 1e-9 * search.size();
            found.gains.residual_sd_v + floor < BETTER * (before.gains.residual_sd_v + floor)
        };
        if best.as_ref().is_none_or(is_better) {
            best = Some(found);
        }
    }
    Ok(match best.filter(|found| found.gains.explained >= LEAST_EXPLAINED) {
        Some(found) => LawFound::Law(Box::new(found)),
        None if tried.is_empty() => LawFound::None("the runs do not excite any law".to_owned()),
        None => LawFound::None(format!("none explains the effort: {}", tried.join(", "))),
    })
}

impl<'a> Search<'a> {
    fn of(runs: &'a [Run], limit_v: Option<f64>) -> Option<Self> {
        let seen = runs.iter().map(|run| {
            let effort = run.signal(Signal::ControlEffort)?;
            let disturbance = run.signal(Signal::DisturbanceVoltage);
            Some(Seen {
                reference: run.signal(Signal::PositionReference)?,
                position: run.signal(Signal::Position)?,
                velocity: run.signal(Signal::Velocity),
                effort: effort
                    .iter()
                    .enumerate()
                    .map(|(k, u)| u - disturbance.map_or(0.0, |d| d[k]))
                    .collect(),
            })
        });
        let runs_seen: Vec<Seen<'a>> = seen.collect::<Option<_>>()?;
        let samples: usize = runs.iter().map(Run::len).sum();
        let period_s = runs.first()?.sample_period_s();
        Some(Self { runs: runs_seen, period_s, limit_v, stride: samples.div_ceil(CHOOSING) })
    }

    /// RMS of the effort.
    fn size(&self) -> f64 {
        let efforts = || self.runs.iter().flat_map(|run| run.effort.iter());
        (efforts().map(|u| u * u).sum::<f64>() / efforts().count().max(1) as f64).sqrt()
    }

    /// The velocity and the delay of the reference with which a form leaves least.
    fn choose(&self, form: Form) -> Option<(Source, usize)> {
        let cost = |estimate: &VelocityEstimate, delay: usize| {
            let source = Source::Estimate(estimate.clone());
            self.linear(form, &source, delay).map_or(f64::INFINITY, |(cost, _)| cost)
        };
        let plain = VelocityEstimate::SmoothedDifference { time_constant_s: 0.0 };
        let is_used = form != Form::P;
        let estimates = if is_used { candidates(self.period_s) } else { vec![plain] };
        let tried =
            estimates.iter().flat_map(|estimate| (0..=MOST_DELAY).map(move |delay| (estimate, delay)));
        let mut costs: Vec<(f64, VelocityEstimate, usize)> =
            tried.map(|(estimate, delay)| (cost(estimate, delay), estimate.clone(), delay)).collect();
        costs.sort_by(|a, b| a.0.total_cmp(&b.0));
        // A smoothing off the grid passes for a delay: the best few are looked at more closely.
        let is_smoothed =
            |(_, estimate, _): &&(f64, VelocityEstimate, usize)| estimate.time_constant_s() > 0.0;
        let few: Vec<_> = costs.iter().filter(is_smoothed).take(FEW).cloned().collect();
        costs.truncate(1);
        costs.extend(few.into_iter().map(|(_, first, delay)| {
            let near = refined(&first, ROUGH_STEPS, |estimate| cost(estimate, delay));
            (cost(&near, delay), near, delay)
        }));
        let (least, first, delay) = costs.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
        if !least.is_finite() {
            return None;
        }
        let estimate = refined(&first, STEPS, |estimate| cost(estimate, delay));
        if is_used && self.runs.iter().all(|run| run.velocity.is_some()) {
            let of = |delay: usize| Some((self.linear(form, &Source::Logged, delay)?.0, delay));
            if let Some((least, at)) = (0..=MOST_DELAY).filter_map(of).min_by(|a, b| a.0.total_cmp(&b.0))
                && least < LOGGED_BETTER.powi(2) * cost(&estimate, delay)
            {
                return Some((Source::Logged, at));
            }
        }
        Some((Source::Estimate(estimate), delay))
    }

    /// The estimate that is nearest to the logged velocity.
    fn nearest_to_logged(&self) -> VelocityEstimate {
        let cost = |estimate: &VelocityEstimate| -> f64 {
            let of = |run: &Seen<'_>| -> f64 {
                let own = along(estimate, run.position, self.period_s);
                let logged = run.velocity.unwrap_or_default();
                let from = forgets(estimate, self.period_s);
                own.iter().zip(logged).skip(from).map(|(a, b)| (a - b).powi(2)).sum()
            };
            self.runs.iter().map(of).sum()
        };
        let all = candidates(self.period_s);
        let first = all.iter().min_by(|a, b| cost(a).total_cmp(&cost(b)));
        first.map_or(VelocityEstimate::SmoothedDifference { time_constant_s: 0.0 }, |first| {
            refined(first, STEPS, cost)
        })
    }

    /// What the law would see of a run from the first sample that counts.
    fn inputs(&self, run: &Seen<'_>, source: &Source, delay: usize) -> (usize, Vec<Input>) {
        let (velocity, from) = match (source, run.velocity) {
            (Source::Logged, Some(velocity)) => (velocity.to_vec(), 1),
            (Source::Estimate(estimate), _) => {
                (along(estimate, run.position, self.period_s), forgets(estimate, self.period_s))
            }
            (Source::Logged, None) => (vec![0.0; run.position.len()], 1),
        };
        let from = (from + delay + 1).min(run.position.len());
        let input = |k: usize| Input {
            position_reference: run.reference[k - delay],
            velocity_reference: (run.reference[k - delay] - run.reference[k - delay - 1]) / self.period_s,
            position: run.position[k],
            velocity: velocity[k],
        };
        (from, (from..run.position.len()).map(input).collect())
    }

    /// The form as a linear regression on some samples: mean square of what it leaves, coefficients.
    fn linear(&self, form: Form, source: &Source, delay: usize) -> Option<(f64, Vec<f64>)> {
        let (mut rows, mut targets): (Vec<Vec<f64>>, Vec<f64>) = (Vec::new(), Vec::new());
        for run in &self.runs {
            let (from, inputs) = self.inputs(run, source, delay);
            let effort = run.effort.get(from..)?;
            let is_clipped =
                |k: usize| self.limit_v.is_some_and(|limit| effort[k].abs() >= limit * (1.0 - 1e-6));
            for k in (1..inputs.len()).step_by(self.stride) {
                if is_clipped(k) || is_clipped(k - 1) {
                    continue;
                }
                rows.push(form.columns(inputs[k - 1], inputs[k], source));
                targets.push(if form.integrates() { effort[k] - effort[k - 1] } else { effort[k] });
            }
        }
        let columns = rows.first()?.len();
        let names = (0..columns).map(|j| j.to_string()).collect();
        let regressor = DMatrix::from_fn(rows.len(), columns, |row, column| rows[row][column]);
        let regression = Regression { names, regressor, target: DVector::from_vec(targets) };
        let solution = regression.solve(REMEDY).ok()?.identified()?;
        let left = solution.residuals.iter().map(|e| e * e).sum::<f64>() / rows.len() as f64;
        Some((left, solution.estimates.iter().map(|e| e.value).collect()))
    }

    /// The gains of a form; none where the runs do not show them, or show gains that no drive has.
    fn gains(&self, form: Form, source: &Source, delay: usize) -> Result<Option<FoundLaw>> {
        let Some((_, coefficients)) = self.linear(form, source, delay) else { return Ok(None) };
        let mut best: Option<FoundLaw> = None;
        for start in form.starts(&coefficients, self.period_s) {
            let Ok(Outcome::Identified(gains)) =
                gain_regression(&self.controller_runs(&start, source, delay), form.unknown())
            else {
                continue;
            };
            let values: Vec<f64> = gains.gains.iter().map(|gain| gain.estimate.value).collect();
            let controller = start.with_unknown_gains(form.unknown(), &values);
            let holds = gains.integrates_as_stated()
                || gains.previous_effort.is_none_or(|rho| (rho.value - 1.0).abs() < HOLDS);
            let is_sound = holds && form.is_sound(&controller) && gains.residual_sd_v.is_finite();
            if is_sound && best.as_ref().is_none_or(|before| gains.residual_sd_v < before.gains.residual_sd_v)
            {
                let (velocity, is_logged) = match source {
                    Source::Estimate(estimate) => (estimate.clone(), false),
                    Source::Logged => (self.nearest_to_logged(), true),
                };
                best =
                    Some(FoundLaw { form, controller, gains, velocity, is_logged, reference_delay: delay });
            }
        }
        Ok(best)
    }

    fn controller_runs(&self, law: &Controller, source: &Source, delay: usize) -> Vec<ControllerRun> {
        let samples: usize = self.runs.iter().map(|run| run.position.len()).sum();
        let share = (MOST_SAMPLES as f64 / samples as f64).min(1.0);
        let of = |run: &Seen<'_>| {
            let (from, mut inputs) = self.inputs(run, source, delay);
            inputs.truncate((share * inputs.len() as f64) as usize);
            let effort_v = run.effort[from..from + inputs.len()].to_vec();
            let limit_v = self.limit_v.map(|limit| limit * (1.0 - 1e-6));
            ControllerRun { law: law.clone(), period_s: self.period_s, inputs, effort_v, limit_v }
        };
        self.runs.iter().map(of).collect()
    }
}

impl Form {
    fn integrates(self) -> bool {
        matches!(self, Self::Pdf | Self::Pi)
    }

    fn unknown(self) -> Unknown {
        if self == Self::P { Unknown::VelocityLoop } else { Unknown::BothLoops }
    }

    /// What its gains multiply, at two samples that follow one another.
    fn columns(self, before: Input, now: Input, source: &Source) -> Vec<f64> {
        let error = now.position_reference - now.position;
        let [reference, velocity] = [now.velocity_reference, now.velocity];
        let change = velocity - before.velocity;
        match self {
            Self::P => vec![error],
            Self::Level => vec![error, reference, -velocity],
            Self::Pdf => vec![error, reference, -velocity, -change],
            Self::Pi => {
                let share = reference - before.velocity_reference;
                let mut columns = vec![error, reference, -velocity, -change, share];
                // What the position loop sees move; a smoothed difference has it in velocity and change already.
                if matches!(source, Source::Estimate(VelocityEstimate::Taps { .. })) {
                    columns.push(before.position - now.position);
                }
                columns
            }
        }
    }

    /// Laws with the gains that the linear regression says.
    fn starts(self, coefficients: &[f64], period_s: f64) -> Vec<Controller> {
        let cascade = |position: f64, velocity: f64, integral: f64, share: f64| {
            Controller::Cascade(Cascade {
                position_gain_per_s: position,
                velocity_gain_v_s_per_m: velocity,
                velocity_integral_per_s: integral,
                velocity_feedforward: share,
                effort_limit_v: None,
                anti_windup: AntiWindup::None,
                filter: Vec::new(),
            })
        };
        match (self, coefficients) {
            (Self::P, [gain]) => vec![Controller::Pd(Pd {
                position_gain_v_per_m: *gain,
                derivative_gain_v_s_per_m: 0.0,
                velocity_feedforward: 0.0,
                filter: Vec::new(),
            })],
            (Self::Level, [error, reference, velocity]) => {
                vec![cascade(error / velocity, *velocity, 0.0, reference / velocity)]
            }
            (Self::Pdf, [error, reference, velocity, change]) => vec![Controller::Pdf(Pdf {
                integral: IntegerGain::saturating(1),
                proportional: IntegerGain::saturating(1),
                integral_gain_per_count: velocity / period_s,
                proportional_gain_per_count: *change,
                velocity_units_per_si: 1.0,
                position_gain_per_s: error / velocity,
                velocity_feedforward: reference / velocity,
                filter: Vec::new(),
            })],
            (Self::Pi, [_, _, velocity, change, share, moved]) => {
                vec![cascade(moved / change, *change, velocity / (change * period_s), share / change)]
            }
            (Self::Pi, [error, _, velocity, change, share]) => {
                // Kp + Ki and Kp·Ki show; which is which does not, so both are tried.
                let (sum, product) = (velocity / (change * period_s), error / (change * period_s));
                let half = 0.5 * sum;
                let root = (half * half - product).max(0.0).sqrt();
                let pair = [(half + root, half - root), (half - root, half + root)];
                pair.map(|(position, integral)| cascade(position, *change, integral, share / change)).to_vec()
            }
            _ => Vec::new(),
        }
    }

    /// Whether the gains are those of a loop that feeds back.
    fn is_sound(self, law: &Controller) -> bool {
        match law {
            Controller::Pdf(law) => {
                law.integral_gain_per_count > 0.0
                    && law.proportional_gain_per_count > 0.0
                    && law.position_gain_per_s >= 0.0
            }
            Controller::Cascade(law) => {
                law.velocity_gain_v_s_per_m > 0.0
                    && law.position_gain_per_s >= 0.0
                    && (self == Self::Level || law.velocity_integral_per_s > 0.0)
            }
            Controller::Pd(law) => law.position_gain_v_per_m > 0.0,
        }
    }
}
