//! A hypothesis: which effects the twin lacks, and the numbers that a fit may choose.

use super::estimate::{Further, is_cumulative};
use super::free::{Free, Freedom, LogNormal, is_wide};
use super::proposals::{Proposals, Together};
use crate::effect::{EffectId, Nominal, Parameter};
use crate::error::Result;
use crate::machine::Machine;
use crate::units::Motion;
use nalgebra::DVector;
use std::collections::{BTreeMap, BTreeSet};

/// A set of effects that together might explain the gap; empty: the twin as it is.
pub type EffectSet = BTreeSet<EffectId>;

/// A hypothesis on a machine.
#[derive(Debug, Clone)]
pub struct Hypothesis {
    /// Its effects.
    pub effects: EffectSet,
    /// Numbers to fit: the effects' parameters, then calibration.
    pub free: Vec<Free>,
    /// Starting values, one set or several, in the order of `free`.
    pub starts: Vec<Vec<f64>>,
    /// So many of these, the first ones, build on what a fit of another hypothesis left; the others put other values in its place.
    pub building: usize,
    /// So many of those that build, the last ones, come from fits of other subsets. They are no reason to descend from more starts.
    pub inherited: usize,
    /// Effects that some starts put elsewhere than where a fit of another hypothesis left them.
    pub elsewhere: EffectSet,
}

/// Whether an effect beside a set has something to modify, in the set or in the machine's file, or is no feature.
pub fn has_modified(machine: &Machine, effect: EffectId, beside: &EffectSet) -> bool {
    effect.has_modified(|of| beside.contains(&of) || machine.description().has(of))
}

/// A set of effects without the features that have nothing to modify.
pub fn with_modified(machine: &Machine, mut set: EffectSet) -> EffectSet {
    // A feature may modify another: each in its turn, in the catalogue's order.
    for effect in set.clone() {
        if !has_modified(machine, effect, &set) {
            set.remove(&effect);
        }
    }
    set
}

/// Starting sets of a hypothesis at most.
const MOST_STARTS: usize = 48;

impl Hypothesis {
    /// The hypothesis that these effects act on the machine, with calibration beside them; numbers that a fit of
    /// another hypothesis (`known`) has found already start where that fit left them. `None` where an effect has
    /// neither a known value nor a proposal to start from.
    pub fn new(
        machine: &Machine,
        effects: &EffectSet,
        proposals: &Proposals,
        known: &[(&Self, &[f64])],
    ) -> Option<Self> {
        let mut free = Vec::new();
        let mut starts: Vec<Vec<f64>> = vec![Vec::new()];
        let (mut places, mut together) = (BTreeMap::new(), Vec::new());
        for &effect in effects {
            let earlier = known.iter().find_map(|(other, values)| other.of_effect(effect, values));
            let (numbers, values) = match earlier {
                Some((numbers, values)) => (numbers, vec![values]),
                None => {
                    together.extend(proposals.get(effect).iter().flat_map(|proposal| &proposal.together));
                    proposed(machine, effect, proposals)?
                }
            };
            places.insert(effect, free.len());
            free.extend(numbers);
            starts = starts
                .iter()
                .flat_map(|begun| values.iter().map(move |more| [begun.as_slice(), more].concat()))
                .take(MOST_STARTS)
                .collect();
        }
        let building = starts.len();
        for calibration in calibrations(machine, effects) {
            let found = known.iter().find_map(|(other, values)| other.value(&calibration.path, values));
            let start = found.unwrap_or(calibration.neutral).clamp(calibration.range.0, calibration.range.1);
            starts.iter_mut().for_each(|set| set.push(start));
            free.push(calibration);
        }
        let first = starts[0].clone();
        let mut elsewhere = EffectSet::new();
        for set in together {
            if let Some(start) = replaced(&first, &free, &places, set) {
                starts.push(start);
                elsewhere.extend(set.own.keys());
            }
        }
        Some(Self { effects: effects.clone(), free, starts, building, inherited: 0, elsewhere })
    }

    /// Takes over the first start of the same hypothesis that builds on another fit, where it has the same numbers and is not there yet.
    pub fn inherit(&mut self, other: Self) {
        if let Some(start) = self.new_start(other) {
            self.starts.insert(self.building, start);
            self.building += 1;
            self.inherited += 1;
        }
    }

    /// Takes over such a start with other values of these effects, as one that replaces what was found.
    pub fn replace(&mut self, other: Self, effects: &EffectSet) {
        if let Some(start) = self.new_start(other) {
            self.starts.push(start);
            self.elsewhere.extend(effects.intersection(&self.effects));
        }
    }

    fn new_start(&self, other: Self) -> Option<Vec<f64>> {
        let first = other.starts.into_iter().next();
        first.filter(|start| start.len() == self.free.len() && !self.starts.contains(start))
    }

    /// Negative logarithm of the numbers' prior beside its largest value: half the sum of the squares of their deviations in standard deviations.
    pub fn strain(&self, values: &[f64]) -> f64 {
        0.5 * self.free.iter().zip(values).map(|(free, value)| free.deviation(*value).powi(2)).sum::<f64>()
    }

    /// Normal matrix (its diagonal) and gradient of [`strain`](Self::strain), in steps of the numbers' scales.
    pub fn prior(&self, values: &[f64]) -> (DVector<f64>, DVector<f64>) {
        let deviation = |k: usize| self.free[k].deviation(values[k]);
        let per_scale = |k: usize| self.free[k].deviation_per_scale(values[k]);
        let count = self.free.len();
        let normal = DVector::from_fn(count, |k, _| per_scale(k) * per_scale(k));
        (normal, DVector::from_fn(count, |k, _| per_scale(k) * deviation(k)))
    }

    /// How many numbers its effects have.
    pub fn numbers(&self) -> usize {
        self.free.iter().filter(|free| free.freedom == Freedom::Cause).count()
    }

    /// The numbers of one effect as a fit left them.
    fn of_effect(&self, effect: EffectId, values: &[f64]) -> Option<(Vec<Free>, Vec<f64>)> {
        let own = |(free, _): &(&Free, &f64)| free.effect == effect && free.freedom == Freedom::Cause;
        let (numbers, found): (Vec<Free>, Vec<f64>) =
            self.free.iter().zip(values).filter(own).map(|(free, value)| (free.clone(), *value)).unzip();
        (!numbers.is_empty()).then_some((numbers, found))
    }

    /// Place of a number of a cause among [`free`](Self::free), by the names of its effect and of itself.
    pub(super) fn place(&self, effect: &str, name: &str) -> Option<usize> {
        let is_it =
            |free: &Free| free.freedom == Freedom::Cause && free.effect.name() == effect && free.name == name;
        self.free.iter().position(is_it)
    }

    pub(super) fn value(&self, path: &str, values: &[f64]) -> Option<f64> {
        self.free.iter().position(|free| free.path == path).map(|k| values[k])
    }

    /// The machine with the values in force.
    ///
    /// # Errors
    /// A value that the machine's description refuses.
    pub fn machine(&self, machine: &Machine, values: &[f64]) -> Result<Machine> {
        machine.with_settings(
            self.free
                .iter()
                .zip(values)
                .map(|(free, &value)| (free.path.as_str(), toml::Value::Float(value))),
        )
    }
}

/// A start with other values of some effects, whose numbers begin at these places, and of what is beside them; none where one of the effects is
/// not in the hypothesis.
fn replaced(
    start: &[f64],
    free: &[Free],
    places: &BTreeMap<EffectId, usize>,
    set: &Together,
) -> Option<Vec<f64>> {
    let mut start = start.to_vec();
    for (effect, own) in &set.own {
        let from = *places.get(effect)?;
        start.get_mut(from..from + own.len())?.copy_from_slice(own);
    }
    for (value, free) in start.iter_mut().zip(free) {
        if let Some(other) = set.beside.get(&free.path) {
            *value = *other;
        }
    }
    Some(start)
}

/// Key path of an effect's parameter.
pub fn path(effect: EffectId, parameter: &str) -> String {
    format!("effect.{}.{parameter}", effect.name())
}

/// A machine with an effect whose parameters have these values, those that are not given as they were.
///
/// # Errors
/// A value that the machine's description refuses.
pub fn with_effect(machine: &Machine, effect: EffectId, values: &[f64]) -> Result<Machine> {
    let paths: Vec<String> = paths(effect, machine.motion()).collect();
    let values = values.iter().copied().map(toml::Value::Float);
    machine.with_settings(paths.iter().map(String::as_str).zip(values))
}

/// Key paths of an effect's parameters on this kind of axis.
pub fn paths(effect: EffectId, motion: Motion) -> impl Iterator<Item = String> {
    effect.parameters().iter().map(move |parameter| path(effect, parameter.key(motion)))
}

/// Keys and units of an effect's parameters on this kind of axis.
fn parameters(effect: EffectId, motion: Motion) -> impl Iterator<Item = (&'static str, &'static str)> {
    effect.parameters().iter().map(move |p| (p.key(motion), p.unit(motion)))
}

/// Parameter values that leave the twin as its file states it.
pub(super) fn stated_values(machine: &Machine, effect: EffectId) -> Vec<f64> {
    let neutral = effect.neutral(&machine.constants());
    effect
        .parameters()
        .iter()
        .zip(neutral)
        .map(|(p, neutral)| {
            let stated = [p.name, p.revolute_name].into_iter().find_map(|n| machine.number(&path(effect, n)));
            stated.unwrap_or(neutral)
        })
        .collect()
}

/// The same, then those of the numbers that are fitted where a recording tells them, then those of form.
pub(super) fn stated_numbers(machine: &Machine, effect: EffectId) -> Vec<f64> {
    let further = effect.further().iter().map(|parameter| (parameter, 0.0));
    let form = effect.form().iter().map(|form| (&form.parameter, form.usual));
    let number = |(parameter, usual): (&Parameter, f64)| {
        machine.number(&path(effect, parameter.key(machine.motion()))).unwrap_or(usual)
    };
    stated_values(machine, effect).into_iter().chain(further.chain(form).map(number)).collect()
}

/// An effect's numbers and their starting values as screening proposes them.
fn proposed(
    machine: &Machine,
    effect: EffectId,
    proposals: &Proposals,
) -> Option<(Vec<Free>, Vec<Vec<f64>>)> {
    let proposal = proposals.get(effect)?;
    let neutral = stated_numbers(machine, effect);
    let mut values = proposal.starts.clone();
    if machine.description().effect.contains(effect) {
        // Screening sees what is missing; where the twin has some of these already, that comes on top.
        if is_cumulative(effect) {
            values.iter_mut().for_each(|start| start[0] += neutral[0]);
        }
        // What the twin has may have changed in size only.
        values.insert(0, neutral[..effect.parameters().len()].to_vec());
    }
    let first = values.first()?.clone();
    let motion = machine.motion();
    let number = |parameter: &Parameter, neutral: f64, start: f64, range: (f64, f64)| {
        let name = parameter.key(motion);
        let (path, unit, freedom) = (path(effect, name), parameter.unit(motion), Freedom::Cause);
        let (scale, held) = (scale(start, range), parameter.held);
        let usual = parameter.usual.filter(|_| range.0 > 0.0);
        let prior = usual.and_then(|usual| usual.range(motion, neutral)).map(LogNormal::between);
        Free { effect, name, unit, path, freedom, neutral, range, scale, held, prior }
    };
    let parameters = effect.parameters().iter().enumerate();
    let mut numbers: Vec<Free> =
        parameters.map(|(k, p)| number(p, neutral[k], first[k], proposal.ranges[k])).collect();
    let stated = &neutral[numbers.len()..];
    for ((parameter, &stated), further) in effect.further().iter().zip(stated).zip(&proposal.further) {
        let Some(Further { start, range }) = *further else { continue };
        numbers.push(number(parameter, stated, start, (range.0 + stated, range.1 + stated)));
        // The first start of what the twin has is as it stands.
        let stands = machine.description().effect.contains(effect);
        for (k, values) in values.iter_mut().enumerate() {
            values.push(if stands && k == 0 { stated } else { stated + start });
        }
    }
    Some((numbers, values))
}

fn scale(start: f64, range: (f64, f64)) -> f64 {
    let coarse = if is_wide(range) { 0.0 } else { 0.02 * (range.1 - range.0) };
    start.abs().max(coarse).max(f64::MIN_POSITIVE)
}

/// The stated constants that are free inside their tolerance: mass, viscous coefficient, force constant, winding
/// resistance and inductance, the encoder's zero, and the parameters of effects that the twin already has; not those of the
/// hypothesis.
fn calibrations(machine: &Machine, effects: &EffectSet) -> Vec<Free> {
    let tolerance = &machine.description().tolerance;
    let stated = machine.stated_constants();
    let free_to_move = |effect: EffectId| !effects.contains(&effect);
    let mut list = Vec::new();
    let mut push = |effect: EffectId, index: usize, neutral: f64, half: f64| {
        let parameter = parameters(effect, machine.motion()).nth(index);
        let moves = half > 0.0 && free_to_move(effect) && effect.applies(&stated);
        if let Some((name, unit)) = parameter.filter(|_| moves) {
            let (low, high) = effect.parameters()[index].limits;
            let range = ((neutral - half).max(low), (neutral + half).min(high));
            let path = path(effect, name);
            let freedom = Freedom::Calibration;
            list.push(Free {
                effect,
                name,
                unit,
                path,
                freedom,
                neutral,
                range,
                scale: half,
                held: false,
                prior: None,
            });
        }
    };
    let present = &machine.description().effect;
    for &effect in EffectId::ALL {
        let values = stated_values(machine, effect);
        let is_stated = present.contains(effect);
        // Drag that is stated as an effect has an effect's tolerance.
        match effect.nominal().filter(|nominal| !(is_stated && *nominal == Nominal::Viscous)) {
            Some(Nominal::MovingMass) => push(effect, 0, values[0], tolerance.mass * stated.moving_mass),
            Some(Nominal::Viscous) => push(effect, 0, values[0], tolerance.viscous * stated.viscous),
            Some(Nominal::ForceConstant) => push(effect, 0, values[0], tolerance.force_constant * values[0]),
            Some(Nominal::Resistance) => push(effect, 0, values[0], tolerance.resistance * values[0]),
            Some(Nominal::Inductance) => push(effect, 0, values[0], tolerance.inductance * values[0]),
            Some(Nominal::EncoderZero) => push(effect, 0, values[0], tolerance.zero_rad),
            None if is_stated => {
                for (index, value) in values.iter().enumerate() {
                    if !effect.parameters()[index].held {
                        push(effect, index, *value, tolerance.effect * value.abs());
                    }
                }
            }
            None => {}
        }
    }
    list.extend(forms(machine, effects));
    list
}

/// The numbers of form of what the twin has, as stated or by the hypothesis.
fn forms(machine: &Machine, effects: &EffectSet) -> impl Iterator<Item = Free> {
    let has = |effect: &EffectId| effects.contains(effect) || machine.description().effect.contains(*effect);
    let there: Vec<EffectId> = EffectId::ALL.iter().copied().filter(has).collect();
    there.into_iter().flat_map(|effect| effect.form().iter().map(move |form| (effect, form))).map(
        |(effect, form)| {
            let (name, unit) = (form.parameter.key(machine.motion()), form.parameter.unit(machine.motion()));
            let (path, scale) = (path(effect, name), form.tolerance);
            let neutral = machine.number(&path).unwrap_or(form.usual);
            let (low, high) = form.parameter.limits;
            let (freedom, range) =
                (Freedom::Calibration, ((neutral - scale).max(low), (neutral + scale).min(high)));
            Free { effect, name, unit, path, freedom, neutral, range, scale, held: false, prior: None }
        },
    )
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::diagnose::free::tests::number;

    /// A hypothesis with these numbers.
    pub(in crate::diagnose) fn hypothesis(free: Vec<Free>) -> Hypothesis {
        let effects = free.iter().map(|free| free.effect).collect();
        Hypothesis { effects, free, starts: vec![], building: 0, inherited: 0, elsewhere: EffectSet::new() }
    }

    /// A start from another minimum is descended from beside those that build on what is found, and the sensitivities there are not taken over
    /// for the effects that both have.
    #[test]
    fn exact_another_minimum_is_a_start_of_its_own() {
        let numbers = || vec![number(EffectId::Cogging, "period_m"), number(EffectId::Payload, "mass_kg")];
        let begun = |period: f64| {
            let mut begun = hypothesis(numbers());
            (begun.starts, begun.building) = (vec![vec![period, 0.0]], 1);
            begun
        };
        let mut own = begun(0.06);
        own.replace(begun(0.036), &EffectSet::from([EffectId::Cogging, EffectId::AsymmetricFriction]));
        assert_eq!((own.starts, own.building), (vec![vec![0.06, 0.0], vec![0.036, 0.0]], 1));
        assert_eq!(own.elsewhere, EffectSet::from([EffectId::Cogging]));
    }
}
