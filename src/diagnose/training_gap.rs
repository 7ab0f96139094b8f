//! What a twin leaves of the training runs, and where in them most.

use super::evidence::{BLOCKS, residuals};
use super::experiment::{Experiment, Training};
use super::json;
use super::noise::Floor;
use crate::error::Result;
use crate::machine::Machine;
use crate::twin::Sensing;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// What a twin leaves of the runs that its numbers were fitted to.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TrainingGap {
    /// G on all training runs.
    #[serde(deserialize_with = "json::number")]
    pub gap: f64,
    /// Whether that is more than may stay open, and the held-out runs leave no more than that: something happens in these runs only. The verdict is
    /// `unknown` then.
    pub is_only_here: bool,
    /// The stretch, a fortieth of them, whose G is largest.
    pub worst: Option<Stretch>,
    /// Where it is so, what would explain these runs as well: sets of the fewest effects beside the causes, as far as the search has met any, the one that leaves
    /// least first. The held-out runs cannot judge them.
    #[serde(default)]
    pub explained_by: Vec<Vec<String>>,
}

/// A stretch of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stretch {
    /// The run.
    pub run: String,
    /// Where it begins, s on the clock of the run's file.
    pub from_s: f64,
    /// Where it ends, s.
    pub to_s: f64,
    /// G on it.
    #[serde(deserialize_with = "json::number")]
    pub gap: f64,
}

impl TrainingGap {
    /// That of a machine; whether only these runs are not explained is the decision's to say.
    ///
    /// # Errors
    /// A setting of a run that the machine does not have.
    pub fn of(machine: &Machine, training: &Training, floor: &Floor) -> Result<Self> {
        let runs = training.runs();
        let total: usize = runs.iter().map(Experiment::samples).sum();
        let length = total.div_ceil(BLOCKS).max(1);
        let parts = |experiment: &Experiment| parts(machine, experiment, floor, length);
        let parts: Vec<(Stretch, f64)> =
            runs.par_iter().map(parts).collect::<Result<Vec<_>>>()?.into_iter().flatten().collect();
        let squares: f64 = parts.iter().map(|(_, squares)| squares).sum();
        let worst = parts.into_iter().map(|(stretch, _)| stretch).max_by(|a, b| a.gap.total_cmp(&b.gap));
        Ok(Self {
            gap: (squares / total.max(1) as f64).sqrt(),
            is_only_here: false,
            worst,
            explained_by: Vec::new(),
        })
    }
}

/// The parts of a run, of so many samples each, and what they leave: the sum of squared normalised residuals, every signal weighing the same.
fn parts(
    machine: &Machine,
    experiment: &Experiment,
    floor: &Floor,
    length: usize,
) -> Result<Vec<(Stretch, f64)>> {
    let predicted = experiment.predict(machine, Sensing::Perfect)?;
    let signals = experiment.signals().len();
    let residuals = residuals(experiment, &predicted, floor);
    let run = experiment.run();
    let part = |from: usize| {
        let to = (from + length).min(experiment.samples());
        let all = residuals.iter().take(signals).flat_map(|residual| &residual[from..to]);
        let squares = all.map(|x| x * x).sum::<f64>() / signals.max(1) as f64;
        let gap = (squares / (to - from) as f64).sqrt();
        let stretch = Stretch {
            run: run.name().to_owned(),
            from_s: run.file_time_s(from),
            to_s: run.file_time_s(to - 1),
            gap,
        };
        (stretch, squares)
    };
    Ok((0..experiment.samples()).step_by(length).map(part).collect())
}
