//! A hypothesis: which effects the twin lacks, and the numbers that a fit may choose.

use crate::effect::{EffectId, Screen};
use crate::error::Result;
use crate::machine::Machine;
use crate::units::Motion;
use std::collections::BTreeSet;

/// A set of effects that together might explain the gap; empty: the twin as it is.
pub type EffectSet = BTreeSet<EffectId>;

/// Why a number is free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Freedom {
    /// It belongs to an effect of the hypothesis.
    Cause,
    /// It is a stated constant, free inside its tolerance beside every hypothesis.
    Calibration,
}

/// One number that a fit may choose.
#[derive(Debug, Clone, PartialEq)]
pub struct Free {
    /// Effect through which it acts.
    pub effect: EffectId,
    /// Parameter key for this kind of axis.
    pub name: &'static str,
    /// Unit for this kind of axis.
    pub unit: &'static str,
    /// TOML key path.
    pub path: String,
    /// Why it is free.
    pub freedom: Freedom,
    /// Value that leaves the twin as stated.
    pub neutral: f64,
    /// Range of the fit.
    pub range: (f64, f64),
    /// Step by which it is varied and compared: about what a fit should resolve coarsely.
    pub scale: f64,
}

/// A hypothesis on a machine.
#[derive(Debug, Clone)]
pub struct Hypothesis {
    /// Its effects.
    pub effects: EffectSet,
    /// Numbers to fit: the effects' parameters, then calibration.
    pub free: Vec<Free>,
    /// Starting values, one set or several, in the order of `free`.
    pub starts: Vec<Vec<f64>>,
}

impl Hypothesis {
    /// The hypothesis that these effects act on the machine, with calibration beside them.
    pub fn new(machine: &Machine, effects: &EffectSet, screen: &Screen) -> Self {
        let motion = machine.motion();
        let mut free = Vec::new();
        let mut starts: Vec<Vec<f64>> = vec![Vec::new()];
        for &effect in effects {
            let ranges = effect.range(screen);
            let neutral = stated_values(machine, effect);
            let mut values = effect.start(screen);
            // Screening sees what is missing; where the twin has some of these already, that comes on top.
            if effect.is_cumulative() && machine.description().effect.contains(effect) {
                values.iter_mut().for_each(|start| start[0] += neutral[0]);
            }
            free.extend(parameters(effect, motion).enumerate().map(|(k, (name, unit))| {
                let range = ranges[k];
                Free {
                    effect,
                    name,
                    unit,
                    path: path(effect, name),
                    freedom: Freedom::Cause,
                    neutral: neutral[k],
                    range,
                    scale: scale(values[0][k], range),
                }
            }));
            // Several starts of one effect branch the list; those of the first effect that has them suffice.
            let branches = if starts.len() == 1 { values.as_slice() } else { &values[..1] };
            starts = starts
                .iter()
                .flat_map(|begun| branches.iter().map(move |more| [begun.as_slice(), more].concat()))
                .collect();
        }
        for calibration in calibrations(machine, effects) {
            starts.iter_mut().for_each(|start| start.push(calibration.neutral));
            free.push(calibration);
        }
        Self { effects: effects.clone(), free, starts }
    }

    /// Starts numbers that a fit of another hypothesis has found already where that fit left them.
    pub fn start_from(&mut self, other: &Self, values: &[f64]) {
        for (found, value) in other.free.iter().zip(values) {
            if let Some(place) = self.free.iter().position(|free| free.path == found.path) {
                self.starts.iter_mut().for_each(|start| start[place] = *value);
            }
        }
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

/// Key path of an effect's parameter.
pub fn path(effect: EffectId, parameter: &str) -> String {
    format!("effect.{}.{parameter}", effect.name())
}

/// Keys and units of an effect's parameters on this kind of axis.
fn parameters(effect: EffectId, motion: Motion) -> impl Iterator<Item = (&'static str, &'static str)> {
    effect.parameters().iter().map(move |p| (p.key(motion), p.unit(motion)))
}

/// Parameter values that leave the twin as its file states it.
fn stated_values(machine: &Machine, effect: EffectId) -> Vec<f64> {
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

fn scale(start: f64, range: (f64, f64)) -> f64 {
    start.abs().max(0.02 * (range.1 - range.0)).max(f64::MIN_POSITIVE)
}

/// The stated constants that are free inside their tolerance: mass, viscous coefficient, and the parameters
/// of effects that the twin already has; not those of the hypothesis, nor those it takes over.
fn calibrations(machine: &Machine, effects: &EffectSet) -> Vec<Free> {
    let tolerance = &machine.description().tolerance;
    let stated = machine.stated_constants();
    let taken: BTreeSet<EffectId> = effects.iter().flat_map(|e| e.supersedes()).copied().collect();
    let free_to_move = |effect| !effects.contains(&effect) && !taken.contains(&effect);
    let mut list = Vec::new();
    let mut push = |effect: EffectId, index: usize, neutral: f64, half: f64| {
        let parameter = parameters(effect, machine.motion()).nth(index);
        if let Some((name, unit)) = parameter.filter(|_| half > 0.0 && free_to_move(effect)) {
            let range = (neutral - half, neutral + half);
            let path = path(effect, name);
            let freedom = Freedom::Calibration;
            list.push(Free { effect, name, unit, path, freedom, neutral, range, scale: half });
        }
    };
    let present = &machine.description().effect;
    for &effect in EffectId::ALL {
        let values = stated_values(machine, effect);
        match effect {
            EffectId::Payload => push(effect, 0, values[0], tolerance.mass * stated.moving_mass),
            EffectId::ViscousFriction if !present.contains(effect) => {
                push(effect, 0, values[0], tolerance.viscous * stated.viscous);
            }
            _ if present.contains(effect) => {
                for (index, value) in values.iter().enumerate() {
                    push(effect, index, *value, tolerance.effect * value.abs());
                }
            }
            _ => {}
        }
    }
    list
}
