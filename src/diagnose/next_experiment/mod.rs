//! The next experiment: which motion, or which signal, would settle what these data leave open.
//!
//! The rivals are simulated in motions that an operator can command; what each could take up by another choice of its
//! own numbers is projected out. What is left is the expected difference in log-likelihood, and the best motion for
//! its time is proposed. Where no motion sets the rivals apart, signals that were not logged are added in turn.

mod plan;
mod separation;
mod stage;
mod words;

pub use plan::Plan;

use super::experiment::{COMPARED, Experiment};
use super::fit::Fit;
use super::found::Found;
use super::hypothesis::EffectSet;
use super::json;
use super::noise::Floor;
use super::rivals;
use crate::drive::motor::Motor;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use rayon::prelude::*;
use separation::{Pair, Seen, Separation, distance, on_all, refitted};
use serde::{Deserialize, Serialize};
use stage::{Draft, Measure, Stage, largest_effort_v};
use std::collections::BTreeMap;

/// What to record next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NextExperiment {
    /// The motion.
    pub motion: Plan,
    /// The command that simulates it; its numbers are those to give the machine.
    pub command: String,
    /// Explanations that it sets apart, the chosen one first, as lists of effects.
    pub separates: Vec<Vec<String>>,
    /// Explanations that stay as good as the chosen one.
    pub leaves_open: Vec<Vec<String>>,
    /// Expected difference in log-likelihood between the chosen explanation and the nearest of those, in nats.
    #[serde(deserialize_with = "json::number")]
    pub predicted_separation: f64,
    /// Signals that tell, most telling first.
    pub signals: Vec<String>,
    /// A signal that has to be logged as well: no motion tells the explanations apart without it.
    pub signal_to_add: Option<String>,
    /// Signals that would do in its place.
    pub or_signals: Vec<String>,
    /// All this in words.
    pub sentence: String,
}

/// A question that a diagnosis leaves open.
pub(super) struct Question<'a> {
    /// The twin as it is.
    pub(super) machine: &'a Machine,
    /// Runs that were fitted.
    pub(super) training: &'a [Experiment],
    /// Runs that judged.
    pub(super) held_out: &'a [Experiment],
    /// Noise floor.
    pub(super) floor: &'a Floor,
    /// What the search found.
    pub(super) found: &'a Found,
    /// Explanations that may have to be set apart from the chosen one.
    pub(super) rivals: Vec<rivals::Rival<'a>>,
}

/// An answer to it.
#[derive(Debug, Default)]
pub(super) struct Proposal {
    /// What to record next.
    pub(super) next: Option<NextExperiment>,
    /// Explanations that the runs recorded so far cannot set apart from the chosen one, whichever were true.
    pub(super) equivalent: Vec<Equivalent>,
}

/// An explanation that the runs recorded so far cannot set apart from the chosen one.
#[derive(Debug)]
pub(super) struct Equivalent {
    /// Its effects.
    pub(super) effects: EffectSet,
    /// Log-likelihood by which the two differ on all recorded runs, each fitted to what the other predicts.
    nats: f64,
    /// Share of what the chosen one changes in the signals that this one changes alike, 0 to 1.
    alike: f64,
}

impl Equivalent {
    /// Why it cannot be told apart, as a sentence.
    pub(super) fn reason(&self, strange: &[String]) -> String {
        format!(
            "On these runs their sensitivities are collinear: {}, refitted, makes {} of the same change in the logged signals, and what differs is worth {:.1} in log-likelihood.",
            strange.join(" with "),
            percent(self.alike),
            self.nats
        )
    }
}

/// A share as percent, no finer than it means something.
fn percent(share: f64) -> String {
    if share > 0.9999 { "more than 99.99 %".to_owned() } else { format!("{:.2} %", 100.0 * share) }
}

/// A difference of so many nats settles a question: e¹⁰ to 1, beyond any prior of the catalogue.
const SETTLES: f64 = 10.0;
/// More than this is not worth paying for, in nats.
const ENOUGH: f64 = 40.0;
/// Rivals looked at.
const MOST_RIVALS: usize = 4;
/// Signals that a replay predicts, in the order of what it takes to log one: what the drive knows, then sensors.
const TO_ADD: [Signal; 6] = [
    Signal::Position,
    Signal::Velocity,
    Signal::ControlEffort,
    Signal::Current,
    Signal::Thrust,
    Signal::LoadPosition,
];
/// Signals that carry less than this share of the difference are not named.
const LEAST_SHARE: f64 = 0.1;

/// The experiment that settles the question best for its time; none where nothing that can be simulated does.
///
/// # Errors
/// Whatever a replay of the recorded runs refuses.
pub(super) fn propose(question: &Question) -> Result<Proposal> {
    let Some((desk, equivalent)) = Desk::new(question)? else { return Ok(Proposal::default()) };
    Ok(Proposal { next: desk.next(), equivalent })
}

/// The rivals, ready to be tried.
struct Desk<'a> {
    question: &'a Question<'a>,
    logged: Vec<Signal>,
    settings: BTreeMap<String, toml::Value>,
    chosen: &'a Fit,
    rivals: Vec<Rival>,
    deflation: Box<dyn Fn(Signal) -> f64 + Sync + 'a>,
}

/// An explanation beside the chosen one.
struct Rival {
    fit: Fit,
    weight: f64,
    /// The chosen one and this one on the recorded runs.
    pair: Pair,
}

/// A motion tried on the rivals.
struct Trial {
    plan: Plan,
    extra: Option<Signal>,
    separations: Vec<Separation>,
    /// Weight of the rivals that are settled.
    settled: f64,
    /// Nats for an hour.
    worth: f64,
}

impl<'a> Desk<'a> {
    /// The desk, and those explanations on it that the recorded runs cannot set apart from the chosen one; none where
    /// nothing is open.
    fn new(question: &'a Question<'a>) -> Result<Option<(Self, Vec<Equivalent>)>> {
        let Question { machine, training, held_out, floor, found, .. } = question;
        let has = |signal: &Signal| training.iter().all(|e| e.signals().contains(signal));
        let logged: Vec<Signal> = COMPARED.into_iter().filter(has).collect();
        if logged.is_empty() || question.rivals.is_empty() {
            return Ok(None);
        }
        let deflation = found.reference().deflations();
        let largest_effort_v = largest_effort_v(training);
        let measure = Measure { floor, deflation: &deflation, logged: &logged, largest_effort_v };
        let stages: Vec<Stage> =
            training.iter().chain(*held_out).map(|e| Stage::recorded(e, &measure)).collect();
        let chosen = &found.candidates[found.chosen].fit;
        let truth = on_all(chosen, &stages, machine)?;
        let change = distance(&truth, &on_all(&found.candidates[0].fit, &stages, machine)?);
        let (mut rivals, mut equivalent) = (Vec::new(), Vec::new());
        for open in question.rivals.iter().take(MOST_RIVALS) {
            let (fit, seen) = refitted(&open.candidate.fit, &truth, &stages, machine)?;
            let pair = Pair::new([chosen, &fit], [&truth, &seen]);
            let nats = pair.known();
            let is_equivalent = nats < rivals::INDISTINCT;
            if is_equivalent {
                let alike = (1.0 - nats / change.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                equivalent.push(Equivalent { effects: open.candidate.effects().clone(), nats, alike });
            }
            if open.is_open || is_equivalent {
                rivals.push(Rival { fit, weight: open.weight, pair });
            }
        }
        if rivals.is_empty() {
            return Ok(None);
        }
        let settings = shared_settings(training);
        let deflation = Box::new(deflation);
        Ok(Some((Self { question, logged, settings, chosen, rivals, deflation }, equivalent)))
    }

    /// What to record next: a motion, or a motion with a signal more.
    fn next(&self) -> Option<NextExperiment> {
        let plans = plan::candidates(self.question.machine, self.question.training);
        if let Some(best) = self.best(&plans, None).filter(|trial| trial.settled > 0.0) {
            return Some(self.write(&best, &[]));
        }
        let plain: Vec<Plan> = plans.into_iter().filter(|plan| plan.added_mass.is_none()).collect();
        let missing = TO_ADD.into_iter().filter(|signal| !self.logged.contains(signal));
        let trials: Vec<Trial> = missing.filter_map(|signal| self.best(&plain, Some(signal))).collect();
        let most = trials.iter().map(|trial| trial.settled).fold(0.0, f64::max);
        let mut telling = trials.into_iter().filter(|trial| trial.settled >= most && most > 0.0);
        let first = telling.next()?;
        let others: Vec<Signal> = telling.filter_map(|trial| trial.extra).collect();
        Some(self.write(&first, &others))
    }

    /// The plan that settles most, and among those the one worth most for its time; the first of equals.
    ///
    /// Plans are tried from the quickest on, one a core at a time. Once one settles all rivals, those that could not be worth more for their time are not
    /// tried: what is beyond [`ENOUGH`] is worth nothing.
    fn best(&self, plans: &[Plan], extra: Option<Signal>) -> Option<Trial> {
        let base = self.base(extra)?;
        let all: f64 = self.rivals.iter().map(|rival| rival.weight).sum();
        let mut open: Vec<(usize, &Plan, f64)> =
            plans.iter().enumerate().map(|(k, plan)| (k, plan, plan.costs_s(&base))).collect();
        open.sort_by(|a, b| a.2.total_cmp(&b.2));
        let mut best: Option<(usize, Trial)> = None;
        for some in open.chunks(rayon::current_num_threads()) {
            let may_win = |cost_s: f64| {
                let settles = best.as_ref().filter(|(_, best)| best.settled >= all);
                settles.is_none_or(|(_, best)| ENOUGH * all / cost_s >= best.worth)
            };
            let trials: Vec<(usize, Trial)> = some
                .par_iter()
                .filter(|(.., cost_s)| may_win(*cost_s))
                .filter_map(|(k, plan, _)| Some((*k, self.attempt(plan, &base, extra)?)))
                .collect();
            best = best.into_iter().chain(trials).reduce(|best, next| {
                let rank = |(k, trial): &(usize, Trial)| (trial.settled, trial.worth, std::cmp::Reverse(*k));
                if rank(&next) > rank(&best) { next } else { best }
            });
        }
        best.map(|(_, trial)| trial)
    }

    /// The machine with a second position sensor where one is to be tried; none where it has it or cannot be told
    /// what the signal is.
    fn base(&self, extra: Option<Signal>) -> Option<Machine> {
        let machine = self.question.machine;
        match extra {
            Some(Signal::LoadPosition) if machine.description().load_sensor.is_none() => {
                let encoder = &machine.description().encoder;
                let (step, noise) = ("load_sensor.resolution_m", "load_sensor.noise_m");
                machine
                    .with_settings([(step, encoder.resolution_m.into()), (noise, encoder.noise_m.into())])
                    .ok()
            }
            Some(Signal::Current) if matches!(machine.description().motor, Motor::Direct(_)) => None,
            _ => Some(machine.clone()),
        }
    }

    /// Tries a plan; none where the axis cannot do it.
    fn attempt(&self, plan: &Plan, base: &Machine, extra: Option<Signal>) -> Option<Trial> {
        let deflation = |signal: Signal| (self.deflation)(signal);
        let Question { floor, training, .. } = self.question;
        let largest_effort_v = largest_effort_v(training);
        let measure = Measure { floor, deflation: &deflation, logged: &self.logged, largest_effort_v };
        let draft = Draft::of(plan, base, self.chosen, &self.settings, &measure).ok()??;
        // Explanations that are exactly equal in most motions are common: a noise floor and sensitivities for each of them are not needed.
        let mut rivals = self.rivals.iter().map(|rival| draft.may_tell(base, &rival.fit, &measure));
        if extra.is_none() && rivals.all(|tells| matches!(tells, Ok(false))) {
            return None;
        }
        let stage = Stage::planned(draft, extra, &measure).ok()?;
        let own = Seen::of(self.chosen, &stage, base).ok()?;
        let separations: Option<Vec<Separation>> = self
            .rivals
            .iter()
            .map(|rival| {
                let seen = Seen::of(&rival.fit, &stage, base).ok()?;
                rival.pair.further(&stage, [&own, &seen])
            })
            .collect();
        let separations = separations?;
        let pairs = || self.rivals.iter().zip(&separations);
        let settled = pairs().filter(|(_, s)| s.nats >= SETTLES).map(|(rival, _)| rival.weight).sum();
        let gain: f64 = pairs().map(|(rival, s)| rival.weight * s.nats.min(ENOUGH)).sum();
        let worth = gain / plan.costs_s(base);
        Some(Trial { plan: plan.clone(), extra, separations, settled, worth })
    }

    fn write(&self, trial: &Trial, or_signals: &[Signal]) -> NextExperiment {
        let motion = self.question.machine.motion();
        let key = |signal: &Signal| signal.key(motion).to_owned();
        let effects = |fit: &Fit| -> Vec<String> {
            fit.hypothesis.effects.iter().map(|e| e.name().to_owned()).collect()
        };
        let pairs = || self.rivals.iter().zip(&trial.separations);
        let (apart, open): (Vec<_>, Vec<_>) = pairs().partition(|(_, s)| s.nats >= SETTLES);
        let nearest = apart.iter().map(|(_, s)| *s).min_by(|a, b| a.nats.total_cmp(&b.nats));
        let mut told: Vec<(Signal, f64)> = nearest.map_or_else(Vec::new, |s| s.signals.clone());
        told.retain(|(signal, share)| *share >= LEAST_SHARE || trial.extra == Some(*signal));
        told.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut next = NextExperiment {
            motion: trial.plan.clone(),
            command: words::command(&trial.plan, self.question.machine, &self.settings),
            separates: [effects(self.chosen)]
                .into_iter()
                .chain(apart.iter().map(|(rival, _)| effects(&rival.fit)))
                .collect(),
            leaves_open: open.iter().map(|(rival, _)| effects(&rival.fit)).collect(),
            predicted_separation: nearest.map_or(0.0, |s| s.nats),
            signals: told.iter().map(|(signal, _)| key(signal)).collect(),
            signal_to_add: trial.extra.as_ref().map(key),
            or_signals: or_signals.iter().map(key).collect(),
            sentence: String::new(),
        };
        next.sentence = words::sentence(&next);
        next
    }
}

/// Settings that all runs share: the next run will have them too.
fn shared_settings(runs: &[Experiment]) -> BTreeMap<String, toml::Value> {
    let Some((first, rest)) = runs.split_first() else { return BTreeMap::new() };
    let shared = |(key, value): &(&String, &toml::Value)| {
        rest.iter().all(|e| e.run().settings.get(*key) == Some(*value))
    };
    first.run().settings.iter().filter(shared).map(|(key, value)| (key.clone(), value.clone())).collect()
}
