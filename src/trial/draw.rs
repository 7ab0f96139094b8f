//! One case drawn: runs, nominal errors, effects and their sizes.

use super::calibrate::{Gauge, Sized};
use super::equals::{equals, struck};
use super::laws::Otherwise;
use super::nominal::{Care, NominalErrors};
use super::plan::Planned;
use super::scale::scale;
use super::seed::Seed;
use super::size::{Family, absorbed};
use super::strokes;
use super::tier::Tier;
use super::truth::{HiddenEffect, TrueCase};
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use rand::RngExt;
use rand::rngs::StdRng;
use std::f64::consts::TAU;

/// Gaps between which sizes are drawn, evenly on a logarithmic scale: just above the floor to plain to see.
pub const GAPS: (f64, f64) = (3.0, 300.0);
/// In a pair, the smaller effect makes at least so large a gap, …
const LEAST_OF_PAIR: f64 = 6.0;
/// … and the larger one at most so many times the smaller one's.
const MOST_RATIO: f64 = 8.0;
/// Draws before a case is given up: some modes of a base hardly show, whatever is done to them.
const MOST_DRAWS: usize = 24;

/// What a draw comes to.
pub enum Outcome {
    /// A case; its number is still open.
    Drawn(Box<TrueCase>),
    /// An effect that cannot show on this machine, and why.
    Skipped(EffectId, String),
}

/// Draws a planned case.
///
/// # Errors
/// Whatever a replay of the machine as it is refuses.
pub fn case(seed: Seed, machine: &Machine, logged: &[Signal], planned: &Planned) -> Result<Outcome> {
    let logged: Vec<Signal> = logged.iter().copied().filter(|s| !planned.missing.contains(s)).collect();
    let mut reason = None;
    for effects in std::iter::once(&planned.effects).chain(&planned.spare) {
        let planned = &Planned { effects: effects.clone(), ..planned.clone() };
        for draw in 0..MOST_DRAWS {
            let mut random = seed.random(&format!("{} {draw}", planned.purpose));
            match attempt(machine, &logged, planned, &mut random, draw + 1 == MOST_DRAWS)? {
                Outcome::Skipped(effect, why) => reason = reason.or(Some((effect, why))),
                drawn @ Outcome::Drawn(_) => return Ok(drawn),
            }
        }
    }
    let nothing = || (EffectId::PositionGain, "no draw came to anything".to_owned());
    let (effect, why) = reason.unwrap_or_else(nothing);
    Ok(Outcome::Skipped(effect, why))
}

fn otherwise(machine: &Machine, stroke: f64, random: &mut StdRng) -> Otherwise {
    let step = machine.constants().encoder_step;
    let step = if step > 0.0 { step } else { 1e-6 * stroke };
    Otherwise {
        bristle_deflection: step * random.random_range(0.2..0.6),
        bristle_damping: random.random_range(0.5..1.0),
        harmonics: [random.random_range(0.02..0.06), random.random_range(0.01..0.03)],
        phases: [random.random_range(0.0..TAU), random.random_range(0.0..TAU)],
        foreign: None,
    }
}

fn attempt(
    machine: &Machine,
    logged: &[Signal],
    planned: &Planned,
    random: &mut StdRng,
    is_last: bool,
) -> Result<Outcome> {
    let runs = strokes::draw(machine, random)?;
    let care = if planned.tier == Tier::Poor { Care::Poor } else { Care::Careful };
    let nominal = NominalErrors::draw(machine, care, random);
    let real = nominal.apply(machine)?;
    let stroke = runs.iter().map(|run| run.stroke.abs()).fold(0.0, f64::max);
    let otherwise = otherwise(machine, stroke, random);
    let scale = scale(&real, &runs, &otherwise)?;
    let gauge = Gauge::new(&real, &otherwise, &runs, logged)?;
    let absorbed = absorbed(&machine.description().tolerance, logged);
    let (mut bases, mut sized): (Vec<Sized>, Vec<Sized>) = (Vec::new(), Vec::new());
    for &effect in &planned.effects {
        let window = match sized.first() {
            None if planned.effects.len() == 1 => GAPS,
            None => (LEAST_OF_PAIR, GAPS.1),
            Some(first) => (LEAST_OF_PAIR.max(first.gap / MOST_RATIO), GAPS.1.min(first.gap * MOST_RATIO)),
        };
        let family = Family::draw(effect, &scale, &absorbed, random).beside(&hidden_so_far(&bases, &sized));
        for (effect, values) in family.base.clone() {
            if !planned.effects.contains(&effect) && !bases.iter().any(|base| base.effect == effect) {
                let there = hidden_so_far(&bases, &[]);
                let gap = gauge.gap(&[&there[..], &[(effect, values.clone())]].concat(), &there);
                bases.push(Sized { effect, values, gap });
            }
        }
        match gauge.sized(&family, window, random.random_range(0.0..1.0)) {
            Ok(one) => sized.push(one),
            Err(most) => {
                let why = format!(
                    "the largest size tried makes a gap of {most:.1} on these strokes, {:.0} is the least asked for",
                    window.0
                );
                return Ok(Outcome::Skipped(effect, why));
            }
        }
    }
    let gaps = || sized.iter().map(|one| one.gap);
    let lopsided = gaps().fold(0.0, f64::max) > 1.5 * MOST_RATIO * gaps().fold(f64::INFINITY, f64::min);
    let together = hidden_so_far(&bases, &sized);
    let gap = gauge.gap(&together, &[]);
    if let (Some(last), true) = (planned.effects.last(), !gap.is_finite() || (lopsided && !is_last)) {
        let why =
            if lopsided { "it cannot be as small as the other" } else { "the axis does not work with both" };
        return Ok(Outcome::Skipped(*last, why.to_owned()));
    }
    let struck = match (planned.tier, planned.effects.first()) {
        (Tier::Outside, Some(effect)) => struck(*effect, machine, logged),
        _ => Vec::new(),
    };
    Ok(Outcome::Drawn(Box::new(TrueCase {
        case: 0,
        tier: planned.tier,
        effects: bases
            .iter()
            .map(|one| hidden(one, &real, logged, false))
            .chain(sized.iter().map(|one| hidden(one, &real, logged, true)))
            .collect(),
        stated: Vec::new(),
        before: Vec::new(),
        nominal,
        otherwise,
        runs,
        struck,
        missing: planned.missing.iter().map(|s| s.key(machine.motion()).to_owned()).collect(),
        gap,
        integration_error: 0.0,
    })))
}

/// The friction that features modify, and the effects planned, as far as they have a size.
fn hidden_so_far(bases: &[Sized], sized: &[Sized]) -> Vec<(EffectId, Vec<f64>)> {
    bases.iter().chain(sized).map(|one| (one.effect, one.values.clone())).collect()
}

fn hidden(sized: &Sized, real: &Machine, logged: &[Signal], planned: bool) -> HiddenEffect {
    let keys = sized.effect.parameters().iter().map(|p| p.key(real.motion()).to_owned());
    HiddenEffect {
        effect: sized.effect,
        parameters: keys.zip(sized.values.iter().copied()).collect(),
        planned,
        gap: sized.gap,
        equals: equals(sized.effect, real, logged),
    }
}

impl TrueCase {
    /// The machine as it really is in this case.
    ///
    /// # Errors
    /// A truth that does not belong to the machine.
    pub fn machine(&self, machine: &Machine) -> Result<Machine> {
        let real = self.nominal.apply(machine)?;
        let values = |hidden: &HiddenEffect| -> Vec<f64> {
            let keys = hidden.effect.parameters().iter().map(|p| p.key(real.motion()));
            keys.map(|key| hidden.parameters.get(key).copied().unwrap_or(f64::NAN)).collect()
        };
        let effects: Vec<_> = self.effects.iter().map(|hidden| (hidden.effect, values(hidden))).collect();
        super::size::with_effects(&real, &effects)
    }
}
