//! One case drawn: runs, nominal errors, effects and what each of them makes.

use super::bristle::Fading;
use super::convergence::{Converged, converged};
use super::engine::Engine;
use super::equals::struck;
use super::foreign::{Foreign, ForeignKind};
use super::gauge::Gauge;
use super::hide::{hidden, stated_friction};
use super::information::{Calibration, Equals};
use super::laws::Otherwise;
use super::nominal::{Care, NominalErrors};
use super::nuisance::nuisances;
use super::plan::Planned;
use super::real::{Acting, Known, Real, by_key, in_order};
use super::runs::{self, TrialRun};
use super::scale::machinery;
use super::scoring::size::FLOOR;
use super::seed::Seed;
use super::tier::Tier;
use super::truth::{HiddenEffect, TrueCase};
use crate::effect::{EffectId, Machinery, Prior};
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Draws before a case is given up. A machine that does not work makes no recording: it runs against its stops, or swings by itself.
const MOST_DRAWS: usize = 24;
/// Probability that a changed machine had something hidden before already, that this is struck from the catalogue, and that a case outside
/// the catalogue hides an effect and nothing foreign.
const UNEXPLAINED: f64 = 0.5;
/// What a draw comes to.
pub enum Outcome {
    /// A case; its number is still open.
    Drawn(Box<TrueCase>),
    /// An effect with which no machine works, and why.
    Skipped(EffectId, String),
}

/// What cases are drawn for.
#[derive(Debug, Clone, Copy)]
pub struct Cases<'a> {
    /// Seed of the trial.
    pub seed: Seed,
    /// The machine on trial.
    pub machine: &'a Machine,
    /// The engine that forges it.
    pub engine: Engine,
    /// The signals that it logs.
    pub logged: &'a [Signal],
}

/// What is drawn before anything is measured.
struct Drawn<'a> {
    runs: &'a [TrialRun],
    otherwise: &'a Otherwise,
    foreign: Option<Foreign>,
    real: &'a Real<'a>,
    /// The same without what was hidden before already.
    plain: &'a Real<'a>,
    scale: &'a Machinery,
}

/// What a draw makes.
struct Measured {
    effects: Vec<HiddenEffect>,
    /// What the effects of before make.
    before: f64,
    otherwise: Otherwise,
    gap: f64,
    converged: Converged,
}

impl Cases<'_> {
    /// Draws a planned case. Nothing is drawn again because it does not show.
    ///
    /// # Errors
    /// Whatever a replay of the machine as it is refuses.
    pub fn draw(&self, planned: &Planned) -> Result<Outcome> {
        let logged: Vec<Signal> =
            self.logged.iter().copied().filter(|s| !planned.missing.contains(s)).collect();
        let own = Cases { logged: &logged, ..*self };
        for effects in std::iter::once(&planned.effects).chain(&planned.spare) {
            let planned = &Planned { effects: effects.clone(), ..planned.clone() };
            for draw in 0..MOST_DRAWS {
                let mut random = self.seed.random(&format!("{} {draw}", planned.purpose));
                if let Some(case) = own.attempt(planned, &mut random)? {
                    return Ok(Outcome::Drawn(Box::new(case)));
                }
            }
        }
        let effect = planned.effects.last().copied().unwrap_or(EffectId::PositionGain);
        Ok(Outcome::Skipped(effect, format!("in {MOST_DRAWS} draws the axis did not work with it")))
    }

    /// One draw; none where the axis does not work.
    fn attempt(&self, planned: &Planned, random: &mut StdRng) -> Result<Option<TrueCase>> {
        let machine = self.machine;
        let runs = runs::draw(machine, random)?.runs;
        let care = if planned.tier == Tier::Poor { Care::Poor } else { Care::Careful };
        let nominal = NominalErrors::draw(machine, care, random);
        let otherwise = otherwise(random);
        let scale = machinery(machine, &Real::new(machine, nominal.clone(), Vec::new())?, &runs)?;
        let foreign = foreign(planned.tier, machine, &scale, &runs, random);
        // What is foreign is outside by itself.
        let asked = if foreign.is_some() { Vec::new() } else { planned.effects.clone() };
        let prior = &mut Prior::new(random);
        let stated = stated_friction(machine, &scale, &asked, prior);
        let before = match planned.tier {
            Tier::Change => {
                self.before(&Real::new(machine, nominal.clone(), stated.clone())?, &scale, planned, prior)?
            }
            _ => Vec::new(),
        };
        let real = Real::new(machine, nominal.clone(), [&stated[..], &before].concat())?;
        let scale = machinery(machine, &real, &runs)?;
        // Values that the machine's description refuses make no machine.
        let Ok(acting) = hidden(&real, &scale, &asked, prior) else { return Ok(None) };
        let plain = Real::new(machine, nominal.clone(), stated.clone())?;
        let drawn =
            Drawn { runs: &runs, otherwise: &otherwise, foreign, real: &real, plain: &plain, scale: &scale };
        let Some(measured) = self.measured(&drawn, acting, prior)? else { return Ok(None) };
        let known = |list: &[Acting]| list.iter().map(|acting| Known::new(acting, machine)).collect();
        Ok(Some(TrueCase {
            case: 0,
            tier: planned.tier,
            struck: self.struck(planned, &measured.effects, &before, prior),
            effects: measured.effects,
            twin: twin(machine, &stated, &asked, care, prior),
            stated: known(&stated),
            before: before.iter().map(|acting| told(acting, machine, measured.before, Vec::new())).collect(),
            nominal,
            otherwise: measured.otherwise,
            missing: planned.missing.iter().map(|s| s.key(machine.motion()).to_owned()).collect(),
            gap: measured.gap,
            step_s: measured.converged.step_s,
            integration_error: measured.converged.error,
            runs,
        }))
    }

    /// Adds nuisances to what is drawn, and measures all of it; none where the axis does not work.
    fn measured(
        &self,
        drawn: &Drawn,
        mut acting: Vec<Acting>,
        prior: &mut Prior,
    ) -> Result<Option<Measured>> {
        let Drawn { runs, otherwise, real, plain, scale, .. } = *drawn;
        let quiet = real.with(&[])?;
        let gauge = |hidden: &[Acting], otherwise: &Otherwise| {
            let whole = real.with(hidden).ok()?;
            Some((Gauge::new([&whole, &quiet], otherwise, runs, self.logged).ok()?, whole))
        };
        let Some((sketched, _)) = gauge(&acting, otherwise) else { return Ok(None) };
        acting.extend(nuisances(&sketched, real, scale, &acting, prior));
        let Some((own, whole)) = gauge(&acting, otherwise) else { return Ok(None) };
        let Some(together) = own.change(&quiet) else { return Ok(None) };
        let calibration = Calibration::new(&own, real, &acting);
        let Some(effects) = effects(&own, real, &acting, &calibration, scale, prior)? else {
            return Ok(None);
        };
        let otherwise = Otherwise { foreign: drawn.foreign.clone(), ..otherwise.clone() };
        let Some(unexplained) = own.change(&plain.with(&acting)?) else { return Ok(None) };
        let before = own.size(&calibration.beyond(&unexplained));
        let mut gap = own.size(&calibration.beyond(&together));
        if drawn.foreign.is_some() {
            let Some((disturbed, whole)) = gauge(&acting, &otherwise) else { return Ok(None) };
            let Some(change) = disturbed.change(&whole) else { return Ok(None) };
            gap = disturbed.size(&change);
        }
        let converged = converged(self.engine, &whole, &otherwise, &runs[own.longest()], self.logged, &own);
        Ok(converged.ok().map(|converged| Measured { effects, before, otherwise, gap, converged }))
    }

    /// What a machine had hidden before it changed: nothing, or an effect that has nothing to do with the change.
    fn before(
        &self,
        real: &Real,
        scale: &Machinery,
        planned: &Planned,
        prior: &mut Prior,
    ) -> Result<Vec<Acting>> {
        let is_apart = |effect: &EffectId| {
            let touches =
                |a: EffectId, b: EffectId| a == b || a.modifies().contains(&b) || b.modifies().contains(&a);
            let is_friction =
                |e: EffectId| EffectId::Presliding.modifies().contains(&e) || e == EffectId::Presliding;
            let struck = struck(*effect, self.machine, self.logged);
            effect.applies(real.constants())
                && !self.machine.description().effect.contains(*effect)
                && !is_friction(*effect)
                && planned.effects.iter().all(|&own| !touches(own, *effect) && !struck.contains(&own))
        };
        let others: Vec<EffectId> = EffectId::ALL.iter().copied().filter(is_apart).collect();
        if others.is_empty() || !prior.chance(UNEXPLAINED) {
            return Ok(Vec::new());
        }
        let effect = others[prior.integer(0, others.len() as u32 - 1) as usize];
        let acting = hidden(real, scale, &[effect], prior)?;
        Ok(acting.into_iter().map(|acting| Acting { planned: false, ..acting }).collect())
    }

    /// The effects struck from the catalogue: in the tier outside, those by which the hidden one could be explained; in that of changes,
    /// in half of the cases those by which the machine before could be.
    fn struck(
        &self,
        planned: &Planned,
        effects: &[HiddenEffect],
        before: &[Acting],
        prior: &mut Prior,
    ) -> Vec<EffectId> {
        let own: Vec<EffectId> = match planned.tier {
            Tier::Outside => {
                effects.iter().filter(|hidden| hidden.planned).map(|hidden| hidden.effect).collect()
            }
            Tier::Change if prior.chance(UNEXPLAINED) => before.iter().map(|acting| acting.effect).collect(),
            _ => Vec::new(),
        };
        let listed = own.iter().flat_map(|effect| struck(*effect, self.machine, self.logged));
        let equal = effects
            .iter()
            .filter(|hidden| own.contains(&hidden.effect))
            .flat_map(|hidden| hidden.equals.clone());
        let all: std::collections::BTreeSet<EffectId> = listed.chain(equal).collect();
        all.into_iter().collect()
    }
}

/// What each hidden effect makes beside the others, and what nobody could tell from it; none where the axis does not work without one.
fn effects(
    gauge: &Gauge,
    real: &Real,
    acting: &[Acting],
    calibration: &Calibration,
    scale: &Machinery,
    prior: &mut Prior,
) -> Result<Option<Vec<HiddenEffect>>> {
    let equals = Equals::new(gauge, real, acting, calibration, scale, prior);
    let mut effects = Vec::new();
    for own in acting {
        let others: Vec<Acting> = acting.iter().filter(|other| other.effect != own.effect).cloned().collect();
        let without = real.with(&others)?;
        let Some(change) = gauge.change(&without) else { return Ok(None) };
        let gap = gauge.size(&calibration.beyond(&change));
        let equals = if gap >= FLOOR { equals.of(own, &change) } else { Vec::new() };
        effects.push(told(own, &without, gap, equals));
    }
    Ok(Some(effects))
}

/// An effect as the truth file has it.
fn told(acting: &Acting, machine: &Machine, gap: f64, equals: Vec<EffectId>) -> HiddenEffect {
    HiddenEffect {
        effect: acting.effect,
        parameters: by_key(acting, machine),
        planned: acting.planned,
        gap,
        equals,
    }
}

/// What is foreign to every law, in half of the cases outside the catalogue: of a kind that can show on the machine.
fn foreign(
    tier: Tier,
    machine: &Machine,
    scale: &Machinery,
    runs: &[TrialRun],
    random: &mut StdRng,
) -> Option<Foreign> {
    if tier != Tier::Outside || random.random_range(0.0..1.0) < UNEXPLAINED {
        return None;
    }
    let kinds: Vec<ForeignKind> = Foreign::ALL_KINDS.into_iter().filter(|kind| kind.shows(machine)).collect();
    let kind = kinds[random.random_range(0..kinds.len())];
    let end = |run: &TrialRun| run.begins_s + run.length_s(machine);
    let session_s = runs.iter().map(end).fold(0.0, f64::max);
    Some(Foreign::draw(kind, machine, scale.rated_force, session_s, random))
}

/// What a forged machine does otherwise, its bristles aside, which are an effect of their own.
fn otherwise(random: &mut StdRng) -> Otherwise {
    let bristle_damping = random.random_range(0.5..1.0);
    Otherwise {
        bristle_deflection: None,
        bristle_damping,
        bristle_fading: fading(bristle_damping),
        harmonics: [random.random_range(0.02..0.06), random.random_range(0.01..0.03)],
        phases: [random.random_range(0.0..TAU), random.random_range(0.0..TAU)],
        foreign: None,
    }
}

/// How the damping of bristles fades: drawn by a generator of its own, so that all else is drawn from the seed as it was.
///
/// # Prior
/// It fades where it would make a quarter to the whole of the sliding level, log-uniform: more would brake harder than the level after
/// each reversal. The power is 1 to 3, uniform, around the 2 of Olsson (1996). Engineering estimates: nobody publishes either.
fn fading(damping: f64) -> Fading {
    let mut random = StdRng::seed_from_u64(damping.to_bits());
    let share = 0.25 * 4.0_f64.powf(random.random_range(0.0..1.0));
    Fading { share, power: random.random_range(1.0..3.0) }
}

/// The settings by which the twin of a case knows more than the machine's file: friction, off by a share of its tolerance unless another
/// value is what is hidden.
fn twin(
    machine: &Machine,
    stated: &[Acting],
    planned: &[EffectId],
    care: Care,
    prior: &mut Prior,
) -> BTreeMap<String, f64> {
    let tolerance = machine.description().tolerance.effect;
    let mut settings = BTreeMap::new();
    for acting in stated {
        for (key, value) in by_key(acting, machine) {
            let off = if planned.contains(&acting.effect) {
                0.0
            } else {
                care.off(tolerance, prior.uniform(-1.0, 1.0))
            };
            settings.insert(format!("effect.{}.{key}", acting.effect.name()), value * (1.0 + off));
        }
    }
    settings
}

impl TrueCase {
    /// The machine as it really is in this case.
    ///
    /// # Errors
    /// A truth that does not belong to the machine.
    pub fn machine(&self, machine: &Machine) -> Result<Machine> {
        let acting: Vec<Acting> = self.effects.iter().map(|hidden| acting(hidden, machine)).collect();
        self.real(machine)?.with(&acting)
    }

    /// The machine as it was before a change.
    ///
    /// # Errors
    /// A truth that does not belong to the machine.
    pub fn machine_before(&self, machine: &Machine) -> Result<Machine> {
        self.real(machine)?.with(&[])
    }

    fn real<'a>(&self, machine: &'a Machine) -> Result<Real<'a>> {
        let stated = self.stated.iter().map(|known| known.acting(machine));
        let before = self.before.iter().map(|hidden| acting(hidden, machine));
        Real::new(machine, self.nominal.clone(), stated.chain(before).collect())
    }
}

/// A hidden effect as it acts on a machine.
fn acting(hidden: &HiddenEffect, machine: &Machine) -> Acting {
    Acting {
        effect: hidden.effect,
        values: in_order(hidden.effect, &hidden.parameters, machine),
        planned: hidden.planned,
    }
}
