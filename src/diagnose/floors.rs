//! The noise floors of explanations: one that they share, and that of those whose effects make noise of their own.

use super::evidence::Score;
use super::experiment::{Experiment, HeldOut, Training};
use super::fit::Fit;
use super::hypothesis::{EffectSet, Hypothesis};
use super::motion;
use super::noise::Floor;
use super::proposals::Proposals;
use super::thresholds::STATED_NOISE;
use super::training_gap::TrainingGap;
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use std::collections::BTreeMap;

/// The noise floors of explanations.
pub struct Floors {
    /// The floor of every twin whose effects make no noise.
    pub common: Floor,
    /// An effect that makes noise, and the floor of twins that have it; none where the recording does not bear it out.
    own: Option<(EffectId, Floor)>,
}

impl Floors {
    /// Estimates the floors of twins that are like `machine` but for effects that make noise; `left` is what they leave of each
    /// signal anyway, RMS in SI.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub fn estimate(
        machine: &Machine,
        training: &Training,
        held_out: &HeldOut,
        left: &BTreeMap<Signal, f64>,
    ) -> Result<Self> {
        let all: Vec<&Experiment> = training.runs().iter().chain(held_out.runs()).collect();
        let floor = |machine: &Machine| Floor::estimate(machine, &all).map(|floor| floor.beside(left));
        let noisy = noisy(machine, training)?;
        let own = noisy.map(|(effect, twin)| floor(&twin).map(|floor| (effect, floor))).transpose()?;
        Ok(Self { common: floor(machine)?, own })
    }

    /// Those of another twin of the same machine, where they are others.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub fn others(
        &self,
        machine: &Machine,
        (training, held_out): (&Training, &HeldOut),
        left: &BTreeMap<Signal, f64>,
    ) -> Result<Option<Self>> {
        let others = Self::estimate(machine, training, held_out, left)?;
        let is_like = |runs: &[Experiment]| others.common.is_like(&self.common, runs);
        let are_like = is_like(training.runs()) && is_like(held_out.runs());
        Ok((!are_like).then_some(others))
    }

    /// The floor of a twin with these effects, where it has one of its own.
    pub fn own(&self, effects: &EffectSet) -> Option<&Floor> {
        self.own.as_ref().filter(|(effect, _)| effects.contains(effect)).map(|(_, floor)| floor)
    }

    /// Scores the twin of a fit; tells whether by a floor of its own.
    ///
    /// A twin that makes noise differs by that much from a machine that makes none as well: whether the machine makes it shows in
    /// what the twin without it leaves, of every signal as of any other noise that is stated.
    ///
    /// # Errors
    /// A setting of a run that the machine does not have.
    pub fn score(&self, machine: &Machine, fit: &Fit, runs: &HeldOut) -> Result<(Score, bool)> {
        let twin = fit.machine(machine)?;
        if let Some(own) = self.own(&fit.hypothesis.effects) {
            let quiet = Score::of(&without_noise(machine, fit)?, runs, own)?;
            if STATED_NOISE * quiet.quietest() >= 1.0 {
                return Ok((Score::with_own_floor(&twin, runs, [own, &self.common])?, true));
            }
        }
        Ok((Score::of(&twin, runs, &self.common)?, false))
    }

    /// The gap that a fit leaves of the training runs; by the floor of its effects, where it is scored by that.
    ///
    /// # Errors
    /// A setting of a run that the machine does not have.
    pub fn training_gap(
        &self,
        machine: &Machine,
        fit: &Fit,
        runs: &Training,
        has_own_floor: bool,
    ) -> Result<f64> {
        let own = self.own(&fit.hypothesis.effects).filter(|_| has_own_floor);
        let Some(own) = own else { return Ok(fit.mean_square.sqrt()) };
        Ok(TrainingGap::of(&fit.machine(machine)?, runs, own)?.gap)
    }
}

/// The machine with an effect that makes noise, as the training runs show it; none where they show none.
fn noisy(machine: &Machine, training: &Training) -> Result<Option<(EffectId, Machine)>> {
    let constants = machine.constants();
    let Some(&effect) = EffectId::ALL.iter().find(|e| e.makes_noise() && e.applies(&constants)) else {
        return Ok(None);
    };
    let proposals = Proposals::of(&motion::screen(training.runs(), machine)?, [effect]);
    let hypothesis = Hypothesis::new(machine, &EffectSet::from([effect]), &proposals, &[]);
    let twin = hypothesis.and_then(|h| h.starts.first().map(|start| h.machine(machine, start)));
    Ok(twin.transpose()?.map(|twin| (effect, twin)))
}

/// The machine with what a fit found but for effects that make noise.
///
/// # Errors
/// A value that the machine's description refuses.
pub fn without_noise(machine: &Machine, fit: &Fit) -> Result<Machine> {
    let pairs = fit.hypothesis.free.iter().zip(&fit.values);
    let quiet = pairs.filter(|(free, _)| !free.effect.makes_noise());
    machine.with_settings(quiet.map(|(free, &value)| (free.path.as_str(), value.into())))
}
