//! The proof on another plant: the gap before and after, once more in the rigid-body scene.

use super::evidence::{Closed, MOST, Score, closed};
use super::experiment::Experiment;
use super::json;
use super::noise::Floor;
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
    /// The held-out runs that were replayed: in their order, as many as time allows.
    pub runs: Vec<String>,
}

impl RigidBody {
    /// Whether it surely closes less than most of the gap: the upper end of the interval lies below one half.
    pub fn has_failed(&self) -> bool {
        self.closed_ci95[1] < MOST
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
    let jobs: Vec<(&Machine, &Experiment)> =
        [stated, improved].into_iter().flat_map(|machine| chosen.iter().map(move |e| (machine, e))).collect();
    let replayed: Result<Vec<Traces>> = jobs.par_iter().map(|(machine, e)| replay(machine, e)).collect();
    let mut replayed = replayed.ok()?;
    let after = replayed.split_off(chosen.len());
    let [before, after] =
        [(&replayed, floors[0]), (&after, floors[1])].map(|(t, floor)| Score::of_traces(&chosen, t, floor));
    if before.is_adequate() {
        return None;
    }
    let Closed { value, ci95 } = closed(&before, &after);
    Some(RigidBody {
        before: before.gap(),
        after: after.gap(),
        closed: value,
        closed_ci95: [ci95.0, ci95.1],
        runs: chosen.iter().map(|e| e.run().name().to_owned()).collect(),
    })
}

fn replay(machine: &Machine, experiment: &Experiment) -> Result<Traces> {
    let machine = experiment.machine(machine)?;
    Ok(experiment.recorded().replay(&machine, Rig::new(&machine)?, Sensing::Perfect))
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
