//! Motions that an operator can command, from what was recorded and what the axis can do.

use crate::diagnose::experiment::Experiment;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::replay::{Motion as Reference, Stroke};
use crate::units::Motion;
use serde::{Deserialize, Serialize};

/// A motion to record: strokes there and back at feeds, a run each; the last one is to be held out.
///
/// Serialised with the units of its kind of axis in the names: `strokes_m`, `feeds_m_per_min` and `added_mass_kg`, or
/// `strokes_rad`, `feeds_rad_per_s` and `added_inertia_kg_m2`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(from = "Serialised")]
pub struct Plan {
    /// Kind of axis.
    pub motion: Motion,
    /// Strokes, a run each, in m or rad; negative: the other way first.
    pub strokes: Vec<f64>,
    /// Feeds of the strokes in m/min, or rad/s for a revolute axis, as operators state them.
    pub feeds: Vec<f64>,
    /// Standstill after each stroke in s.
    pub dwell_s: f64,
    /// Known mass in kg to bolt to the moving part, or inertia in kg·m² for a revolute axis.
    pub added_mass: Option<f64>,
}

/// Standstill before the first stroke in s.
const LEAD_S: f64 = 0.1;
/// Standstill after each stroke in s.
const DWELL_S: f64 = 0.6;
/// A standstill long enough for what creeps.
const LONG_DWELL_S: f64 = 3.0;
/// A run longer than this is not proposed, in s.
const LONGEST_S: f64 = 12.0;
/// Shares of the way to the joint's limits, and of its speed, that are used at most.
const MARGIN: f64 = 0.9;
/// Time that an operator needs for a run beside the run itself, in s.
const RUN_SETUP_S: f64 = 20.0;
/// Time that it takes to weigh a mass and to bolt it on, in s.
const MASS_SETUP_S: f64 = 900.0;
/// Added masses as shares of the moving one.
const MASSES: [f64; 2] = [0.1, 0.3];
/// The held-out stroke as a share of the other.
const JUDGE: f64 = 0.75;

impl Plan {
    fn new(motion: Motion, stroke: f64, feed: f64, dwell_s: f64) -> Self {
        let strokes = [1.0, JUDGE].map(|share| two_digits(share * stroke));
        let feed = two_digits(feed / per_second(motion));
        Self { motion, strokes: strokes.to_vec(), feeds: vec![feed; 2], dwell_s, added_mass: None }
    }

    /// The position references of its runs.
    pub fn references(&self, machine: &Machine) -> Vec<Vec<f64>> {
        let description = machine.description();
        let per_second = per_second(self.motion);
        let runs = self.strokes.iter().zip(&self.feeds);
        runs.map(|(&stroke, feed)| {
            let there = Stroke { stroke, feed: feed * per_second };
            Reference {
                strokes: vec![there, Stroke { stroke: -stroke, ..there }],
                lead_s: LEAD_S,
                dwell_s: self.dwell_s,
                ramp_s: description.reference.acceleration_time_s,
            }
            .reference(description.sample_period_s)
        })
        .collect()
    }

    /// What it costs an operator, in s.
    pub(super) fn costs_s(&self, machine: &Machine) -> f64 {
        let runs = self.strokes.len() as f64;
        let mass = if self.added_mass.is_some() { MASS_SETUP_S } else { 0.0 };
        runs * (self.lasts_s(machine) + RUN_SETUP_S) + mass
    }

    /// Duration of its longest run in s.
    fn lasts_s(&self, machine: &Machine) -> f64 {
        let per_second = per_second(self.motion);
        let ramp = machine.description().reference.acceleration_time_s;
        let runs = self.strokes.iter().zip(&self.feeds);
        let lasts = runs.map(|(&stroke, feed)| {
            2.0 * (Stroke { stroke, feed: feed * per_second }.duration_s(ramp) + self.dwell_s) + LEAD_S
        });
        lasts.fold(0.0, f64::max)
    }

    /// The cells as the command line writes them.
    pub(super) fn cells(&self) -> Vec<String> {
        self.strokes.iter().zip(&self.feeds).map(|(stroke, feed)| format!("{stroke}@{feed}")).collect()
    }
}

impl Serialize for Plan {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeMap;
        let [strokes, feeds, mass] = match self.motion {
            Motion::Prismatic => ["strokes_m", "feeds_m_per_min", "added_mass_kg"],
            Motion::Revolute => ["strokes_rad", "feeds_rad_per_s", "added_inertia_kg_m2"],
        };
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry(strokes, &self.strokes)?;
        map.serialize_entry(feeds, &self.feeds)?;
        map.serialize_entry("there_and_back", &true)?;
        map.serialize_entry("dwell_s", &self.dwell_s)?;
        if let Some(added) = self.added_mass {
            map.serialize_entry(mass, &added)?;
        }
        map.end()
    }
}

/// The form of a plan in a verdict.
#[derive(Deserialize)]
struct Serialised {
    strokes_m: Option<Vec<f64>>,
    #[serde(default, alias = "strokes_rad")]
    strokes: Vec<f64>,
    #[serde(alias = "feeds_m_per_min", alias = "feeds_rad_per_s")]
    feeds: Vec<f64>,
    dwell_s: f64,
    #[serde(default, alias = "added_mass_kg", alias = "added_inertia_kg_m2")]
    added_mass: Option<f64>,
}

impl From<Serialised> for Plan {
    fn from(plan: Serialised) -> Self {
        let Serialised { strokes_m, strokes, feeds, dwell_s, added_mass } = plan;
        let motion = if strokes_m.is_some() { Motion::Prismatic } else { Motion::Revolute };
        Self { motion, strokes: strokes_m.unwrap_or(strokes), feeds, dwell_s, added_mass }
    }
}

/// The unit of a feed in m/s or rad/s.
fn per_second(motion: Motion) -> f64 {
    if motion == Motion::Prismatic { 1.0 / 60.0 } else { 1.0 }
}

/// What the recorded runs did, and what the joint allows.
struct Extent {
    stroke: f64,
    speed: f64,
    reach: [f64; 2],
    fastest: f64,
}

impl Extent {
    fn of(machine: &Machine, recorded: &[Experiment]) -> Option<Self> {
        let joint = &machine.solid().joint;
        let (mut strokes, mut speeds) = (Vec::new(), Vec::new());
        for experiment in recorded {
            let Some(reference) = experiment.run().signal(Signal::PositionReference) else { continue };
            let start = reference.first().copied().unwrap_or(0.0);
            let period = experiment.run().sample_period_s();
            strokes.push(reference.iter().map(|x| (x - start).abs()).fold(0.0, f64::max));
            speeds.push(reference.windows(2).map(|w| (w[1] - w[0]).abs() / period).fold(0.0, f64::max));
        }
        let middle = |list: &mut Vec<f64>| {
            list.retain(|x| *x > 0.0);
            list.sort_by(f64::total_cmp);
            list.get(list.len() / 2).copied()
        };
        let farthest = strokes.iter().copied().fold(0.0, f64::max);
        let fastest = speeds.iter().copied().fold(0.0, f64::max);
        let (stroke, speed) = (middle(&mut strokes)?, middle(&mut speeds)?);
        // Where the joint has no limits, the recorded motion is what is known to be safe; a little more is tried.
        let limit = |stated: f64, seen: f64| if stated.is_finite() { MARGIN * stated } else { 3.0 * seen };
        Some(Self {
            stroke,
            speed,
            reach: [limit(joint.upper, farthest).max(0.0), limit(-joint.lower, farthest).max(0.0)],
            fastest: limit(joint.velocity, fastest).min(3.0 * fastest),
        })
    }
}

/// The motions to choose from: what was recorded again, the other way, shorter, longer, creeping, fast, with a long
/// standstill, and with known masses.
pub(super) fn candidates(machine: &Machine, recorded: &[Experiment]) -> Vec<Plan> {
    let Some(extent) = Extent::of(machine, recorded) else { return Vec::new() };
    let motion = machine.motion();
    let far = |way: usize| extent.reach[way] * if way == 0 { 1.0 } else { -1.0 };
    let strokes = [
        extent.stroke,
        -extent.stroke,
        0.1 * extent.stroke,
        0.3 * extent.stroke,
        (3.0 * extent.stroke).min(far(0)),
        -(3.0 * extent.stroke).min(-far(1)),
    ];
    let feeds = [0.02, 0.1, 0.4, 1.0, 2.0].map(|share| (share * extent.speed).min(extent.fastest));
    let mut plans: Vec<Plan> = strokes
        .iter()
        .flat_map(|&stroke| feeds.iter().map(move |&feed| Plan::new(motion, stroke, feed, DWELL_S)))
        .collect();
    plans.push(Plan::new(motion, extent.stroke, extent.speed, LONG_DWELL_S));
    for share in MASSES {
        let mass = two_digits(share * machine.constants().moving_mass);
        for feed in [0.4, 1.0].map(|share| share * extent.speed) {
            let plan = Plan::new(motion, extent.stroke, feed, DWELL_S);
            plans.push(Plan { added_mass: Some(mass), ..plan });
        }
    }
    let within = |stroke: f64| stroke != 0.0 && (-extent.reach[1]..=extent.reach[0]).contains(&stroke);
    let mut allowed: Vec<Plan> = Vec::new();
    for plan in plans {
        let known = allowed.contains(&plan);
        let fits =
            plan.strokes.iter().all(|stroke| within(*stroke)) && plan.feeds.iter().all(|feed| *feed > 0.0);
        if fits && !known && plan.lasts_s(machine) <= LONGEST_S {
            allowed.push(plan);
        }
    }
    allowed
}

/// A number that can be typed: two significant digits.
fn two_digits(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::shipped;
    use crate::recording::Run;
    use std::collections::BTreeMap;

    fn machines() -> Vec<Machine> {
        shipped().filter(|machine| machine.description().controller.is_some()).collect()
    }

    /// A short motion as it may have been recorded on any machine.
    fn recorded(machine: &Machine) -> Vec<Experiment> {
        let stroke = Stroke { stroke: 0.02, feed: 0.1 };
        let motion = Reference { strokes: vec![stroke], lead_s: 0.1, dwell_s: 0.1, ramp_s: 0.02 };
        let reference = motion.reference(machine.description().sample_period_s);
        let signals = [Signal::PositionReference, Signal::Position].map(|s| (s, reference.clone()));
        let period_s = machine.description().sample_period_s;
        let run = Run::new("run", machine.motion(), period_s, BTreeMap::from(signals)).unwrap();
        vec![Experiment::new(&run, machine).unwrap()]
    }

    #[test]
    fn exact_motions_stay_within_the_joint() {
        let machines = machines();
        assert!(machines.len() >= 2);
        for machine in machines {
            let plans = candidates(&machine, &recorded(&machine));
            assert!(plans.len() > 10, "{}", plans.len());
            assert!(plans.iter().any(|plan| plan.added_mass.is_some()));
            let joint = &machine.solid().joint;
            for plan in plans {
                assert!(plan.lasts_s(&machine) <= LONGEST_S, "{plan:?}");
                for reference in plan.references(&machine) {
                    let inside = reference.iter().all(|x| (joint.lower..=joint.upper).contains(x));
                    assert!(inside && reference.last().unwrap().abs() < 1e-9, "{plan:?}");
                }
            }
        }
    }

    #[test]
    fn exact_names_carry_the_units_of_the_axis() {
        let keys = |motion| {
            let plan = Plan { added_mass: Some(2.0), ..Plan::new(motion, 0.02, 0.1, 0.5) };
            let json = serde_json::to_value(plan).unwrap();
            json.as_object().unwrap().keys().cloned().collect::<Vec<_>>()
        };
        let fixed = ["dwell_s", "there_and_back"];
        for (motion, own) in [
            (Motion::Prismatic, ["added_mass_kg", "feeds_m_per_min", "strokes_m"]),
            (Motion::Revolute, ["added_inertia_kg_m2", "feeds_rad_per_s", "strokes_rad"]),
        ] {
            let keys = keys(motion);
            assert!(
                keys.len() == 5 && own.iter().chain(&fixed).all(|key| keys.iter().any(|k| k == key)),
                "{keys:?}"
            );
        }
        assert_eq!(Plan::new(Motion::Prismatic, 0.02, 8.0 / 60.0, 0.5).cells(), ["0.02@8", "0.015@8"]);
    }

    #[test]
    fn exact_standstill_alone_gives_nothing_to_go_by() {
        for machine in machines() {
            let still = vec![0.0; 200];
            let signals = [Signal::PositionReference, Signal::Position].map(|s| (s, still.clone()));
            let period_s = machine.description().sample_period_s;
            let run = Run::new("run", machine.motion(), period_s, BTreeMap::from(signals)).unwrap();
            assert!(candidates(&machine, &[Experiment::new(&run, &machine).unwrap()]).is_empty());
        }
    }
}
