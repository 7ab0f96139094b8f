//! The proof on another plant: the gap before and after, once more in the rigid-body scene.

use super::evidence::{Closed, Score, closed};
use super::experiment::Experiment;
use super::json;
use super::noise::Floor;
use super::thresholds::MOST;
use crate::error::Result;
use crate::machine::Machine;
use crate::plant::rapier::Rig;
use crate::replay::Traces;
use crate::twin::Sensing;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Simulated time of the runs that are replayed in the scene at most, in s: some 90 ms of computing a second for
/// the two machines together.
const LONGEST_S: f64 = 20.0;

/// The gap in the rigid-body scene, on held-out runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RigidBody {
    /// G of the twin as it is, in units of noise.
    #[serde(deserialize_with = "json::number")]
    pub before: f64,
    /// G with the causes added.
    #[serde(deserialize_with = "json::number")]
    pub after: f64,
    /// 1 − (after² − 1)/(before² − 1).
    #[serde(deserialize_with = "json::number")]
    pub closed: f64,
    /// Its 95 % interval.
    #[serde(deserialize_with = "json::interval")]
    pub closed_ci95: [f64; 2],
    /// The share that the reduced axis closes on the same runs.
    #[serde(deserialize_with = "json::number")]
    pub closed_on_axis: f64,
    /// The held-out runs that were replayed: in their order, as many as time allows.
    pub runs: Vec<String>,
}

impl RigidBody {
    /// Whether most of what the reduced axis closes surely stays open here: the upper end of the interval lies below half of its share.
    ///
    /// How much the explanation leaves on both plants is not for this proof to judge: only what rests on the reduction would not repeat.
    pub fn has_failed(&self) -> bool {
        self.closed_ci95[1] < MOST * self.closed_on_axis
    }
}

/// Replays held-out runs in the rigid-body scene with the machine as stated and as improved; none where the scene
/// cannot be built from the machine, no run is short enough, or the twin as it is leaves no gap on these runs.
///
/// # Model
/// The score is the one of the reduced axis: same runs, same noise floors (before, after), only the plant differs. What the
/// reduced axis leaves out (the body's attitude, loads of the sliders) is in the scene, so a shrink that rests on the
/// reduction would not repeat here.
pub fn rigid_body(
    [stated, improved]: [&Machine; 2],
    held_out: &[Experiment],
    floors: [&Floor; 2],
) -> Option<RigidBody> {
    if held_out.iter().any(|e| e.input().is_some()) {
        return None; // replayed in windows: the scene has no loop to close
    }
    let chosen = within(held_out, LONGEST_S);
    if chosen.is_empty() {
        return None;
    }
    let scores = |replay: Replay| scores([stated, improved], &chosen, floors, replay);
    let [before, after] = scores(in_scene).ok()?;
    if before.is_adequate() {
        return None;
    }
    let [stated_on_axis, improved_on_axis] = scores(on_axis).ok()?;
    let Closed { value, ci95 } = closed(&before, &after);
    Some(RigidBody {
        before: before.gap(),
        after: after.gap(),
        closed: value,
        closed_ci95: [ci95.0, ci95.1],
        closed_on_axis: closed(&stated_on_axis, &improved_on_axis).value,
        runs: chosen.iter().map(|e| e.run().name().to_owned()).collect(),
    })
}

/// A replay of a machine on a plant, with perfect sensors.
type Replay = fn(&Machine, &Experiment) -> Result<Traces>;

fn in_scene(machine: &Machine, experiment: &Experiment) -> Result<Traces> {
    let machine = experiment.machine(machine)?;
    Ok(experiment.recorded().replay(&machine, Rig::new(&machine)?, Sensing::Perfect))
}

fn on_axis(machine: &Machine, experiment: &Experiment) -> Result<Traces> {
    experiment.predict(machine, Sensing::Perfect)
}

/// Scores of the machines, each by its own floor.
fn scores(
    machines: [&Machine; 2],
    runs: &[Experiment],
    floors: [&Floor; 2],
    replay: Replay,
) -> Result<[Score; 2]> {
    let jobs: Vec<(&Machine, &Experiment)> =
        machines.into_iter().flat_map(|machine| runs.iter().map(move |run| (machine, run))).collect();
    let replayed: Result<Vec<Traces>> = jobs.par_iter().map(|(machine, run)| replay(machine, run)).collect();
    let replayed = replayed?;
    let (before, after) = replayed.split_at(runs.len());
    Ok([Score::of_traces(runs, before, floors[0]), Score::of_traces(runs, after, floors[1])])
}

/// The runs, in their order, that fit into so much simulated time.
fn within(runs: &[Experiment], mut left_s: f64) -> Vec<Experiment> {
    let mut chosen = Vec::new();
    for run in runs {
        let lasts_s = run.run().duration_s();
        if lasts_s <= left_s {
            left_s -= lasts_s;
            chosen.push(run.clone());
        }
    }
    chosen
}
