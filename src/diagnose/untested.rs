//! What the recorded motion could not test, in numbers, and which motion would.

use super::experiment::Experiment;
use crate::effect::EffectId;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::units::{Motion, engineering};
use serde::{Deserialize, Serialize};

/// Effects that may act beyond what the runs did, without a trace in them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Untested {
    /// Effect ids.
    pub effects: Vec<String>,
    /// Beyond what: "pitch above", "speed below", "speed above".
    pub beyond: String,
    /// The number, in SI.
    pub limit: f64,
    /// Its unit.
    pub unit: String,
    /// The motion that would test it, as a sentence.
    pub motion: String,
}

// These numbers word a suggestion; no verdict depends on them.
/// Share of the joint's range and speed that a motion is told to use: away from the end stops.
const USED: f64 = 0.9;
/// A motion that goes less than this many times further tests nothing new.
const FURTHER: f64 = 1.1;
/// Where a joint has no end, a motion is told to go this many times as far: three of the pitches that just did not fit.
const FARTHER: f64 = 3.0;
/// A speed is held where it changes from sample to sample by no more than this share of the largest: rounding of the log.
const HELD: f64 = 1e-6;
/// A slower motion is told to be this share of the slowest: a decade, as friction curves are recorded.
const SLOWER: f64 = 0.1;

/// What these runs of a machine could not test of a catalogue.
///
/// # Model
/// What repeats along the axis shows from one pitch within the travel on; beyond it is a spring or a constant force. Friction that
/// depends on speed shows between the slowest speed that was held and the fastest. A run without a held speed goes through all speeds up to
/// its largest.
pub fn untested(machine: &Machine, runs: &[&Experiment], catalogue: &[EffectId]) -> Vec<Untested> {
    let extent = Extent::of(runs);
    let names = |is_meant: &dyn Fn(EffectId) -> bool| -> Vec<String> {
        catalogue.iter().filter(|effect| is_meant(**effect)).map(|effect| effect.name().to_owned()).collect()
    };
    let repeats = |effect: EffectId| effect.parameters().iter().any(|p| p.name == "period_m");
    let at_low_speed = |effect| effect == EffectId::StribeckFriction;
    let with_speed = |effect| {
        matches!(
            effect,
            EffectId::ViscousFriction | EffectId::AsymmetricFriction | EffectId::VoltageSaturation
        )
    };
    let list = [
        extent.pitch(machine, names(&repeats)),
        extent.slow(machine, names(&at_low_speed)),
        extent.fast(machine, names(&with_speed)),
    ];
    list.into_iter().flatten().filter(|untested| !untested.effects.is_empty()).collect()
}

/// Travel of all runs together, in m or rad.
pub(super) fn travel(runs: &[&Experiment]) -> f64 {
    Extent::of(runs).travel
}

/// What the runs did.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Extent {
    travel: f64,
    /// The slowest speed that was held.
    slowest: Option<f64>,
    fastest: f64,
}

impl Extent {
    fn of(runs: &[&Experiment]) -> Self {
        let positions = || runs.iter().filter_map(|run| run.run().signal(Signal::Position)).flatten();
        let (low, high) =
            positions().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
        let speeds: Vec<Vec<f64>> = runs
            .iter()
            .map(|run| run.recorded().commands().iter().map(|c| c.velocity_reference.abs()).collect())
            .collect();
        Self::along(if high > low { high - low } else { 0.0 }, &speeds)
    }

    fn along(travel: f64, speeds: &[Vec<f64>]) -> Self {
        let fastest = speeds.iter().flatten().copied().fold(0.0, f64::max);
        let held = |pair: &[f64]| pair[1] > 0.0 && (pair[1] - pair[0]).abs() <= HELD * fastest;
        let slowest_of = |run: &Vec<f64>| {
            run.windows(2).filter(|pair| held(pair)).map(|pair| pair[1]).min_by(f64::total_cmp)
        };
        let moving = speeds.iter().filter(|run| run.iter().any(|v| *v > 0.0));
        // Where one run goes through all speeds, none is left out below.
        let slowest: Option<Vec<f64>> = moving.map(slowest_of).collect();
        Self { travel, slowest: slowest.and_then(|all| all.into_iter().min_by(f64::total_cmp)), fastest }
    }

    fn pitch(&self, machine: &Machine, effects: Vec<String>) -> Option<Untested> {
        let joint = &machine.solid().joint;
        let motion = machine.motion();
        let unit = Signal::Position.si_unit(motion);
        let reach = USED * (joint.upper - joint.lower);
        let wanted = if reach.is_finite() { reach } else { FARTHER * self.travel };
        let is_whole_turn = motion == Motion::Revolute && self.travel >= std::f64::consts::TAU;
        (self.travel > 0.0 && !is_whole_turn && wanted > FURTHER * self.travel).then(|| Untested {
            effects,
            beyond: "pitch above".to_owned(),
            limit: self.travel,
            unit: unit.to_owned(),
            motion: format!("Record strokes of {}.", engineering(wanted, unit)),
        })
    }

    fn slow(&self, machine: &Machine, effects: Vec<String>) -> Option<Untested> {
        let unit = Signal::Velocity.si_unit(machine.motion());
        self.slowest.map(|slowest| Untested {
            effects,
            beyond: "speed below".to_owned(),
            limit: slowest,
            unit: unit.to_owned(),
            motion: format!("Record a slow stroke at {}.", engineering(SLOWER * slowest, unit)),
        })
    }

    fn fast(&self, machine: &Machine, effects: Vec<String>) -> Option<Untested> {
        let unit = Signal::Velocity.si_unit(machine.motion());
        let wanted = USED * machine.solid().joint.velocity;
        let is_faster = wanted.is_finite() && self.fastest > 0.0 && wanted > FURTHER * self.fastest;
        is_faster.then(|| Untested {
            effects,
            beyond: "speed above".to_owned(),
            limit: self.fastest,
            unit: unit.to_owned(),
            motion: format!("Record a stroke at {}.", engineering(wanted, unit)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_slowest_and_fastest_held_speed() {
        let trapezoid =
            |v: f64| [vec![0.0; 3], vec![0.5 * v], vec![v; 5], vec![0.5 * v], vec![0.0; 3]].concat();
        let extent = Extent::along(0.02, &[trapezoid(0.1), trapezoid(0.02)]);
        assert_eq!(extent, Extent { travel: 0.02, slowest: Some(0.02), fastest: 0.1 });
        // A sine holds no speed: it goes through all of them.
        let sine: Vec<f64> = (1..40).map(|k| (0.1 * f64::from(k)).sin().abs()).collect();
        assert_eq!(Extent::along(0.02, &[trapezoid(0.1), sine]).slowest, None);
        assert_eq!(Extent::along(0.0, &[vec![0.0; 9]]), Extent { travel: 0.0, slowest: None, fastest: 0.0 });
    }
}
