//! Cross-check: the same strokes on every plant, and what needs no replay, with bounds on the differences.
//!
//! The plants share the twin's signal path and the laws of guide and motor. What they do not share is what is checked: import,
//! masses, integration of mass, drag and base, and what the guide carries.

pub mod bounds;
mod differences;
mod quantity;
mod statics;
mod strokes;

pub use bounds::Bound;
pub use differences::{Difference, Pair, Replayed, short_name};
pub use quantity::Quantity;
pub use statics::Static;
pub use strokes::{Planned, cells_of, ramp_s};

use super::{Cell, PlantChoice};
use crate::error::Result;
use crate::machine::Machine;
use crate::plant::mujoco;
use crate::plant::rapier::STEP_S;
use rayon::prelude::*;

/// What is to be held against each other.
#[derive(Debug, Clone)]
pub struct Crosscheck {
    /// Each plant with the machine that it is made of, the reference first.
    subjects: Vec<(PlantChoice, Machine)>,
    strokes: Vec<Planned>,
}

/// What came out.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// What needs no replay.
    pub statics: Vec<Static>,
    /// The strokes in their order.
    pub strokes: Vec<Replayed>,
    /// The plants, the reference first.
    pub plants: Vec<PlantChoice>,
    /// Whether the controller closed the loop; else the force that the stroke needs was applied.
    pub is_closed_loop: bool,
    /// What was taken off or added for the engines' steps.
    pub offsets: Offsets,
}

/// Known offsets of the engines' steps, the largest of all strokes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offsets {
    /// Step of the engines in s.
    pub step_s: f64,
    /// `h·v/2` at the highest speed, in m or rad.
    pub lead: f64,
    /// `F·h²/12·(1/m + Σ 1/M)` at the largest thrust F, in m or rad: what the rises of the force sum up to.
    pub rise: f64,
}

impl Crosscheck {
    /// The machine on every plant that this build has, on these strokes.
    ///
    /// # Errors
    /// A cell beyond the travel.
    pub fn of(machine: &Machine, cells: &[Cell]) -> Result<Self> {
        let mut plants = vec![PlantChoice::Axis, PlantChoice::Rapier];
        if mujoco::IS_BUILT_IN {
            plants.push(PlantChoice::Mujoco);
        }
        let strokes = cells.iter().map(|cell| Planned::of(machine, *cell)).collect::<Result<_>>()?;
        Ok(Self { subjects: plants.into_iter().map(|plant| (plant, machine.clone())).collect(), strokes })
    }

    /// The same with one plant made of another machine: what its difference would be seen as.
    #[must_use]
    pub fn with(mut self, plant: PlantChoice, machine: &Machine) -> Self {
        for subject in self.subjects.iter_mut().filter(|(of, _)| *of == plant) {
            subject.1 = machine.clone();
        }
        self
    }

    /// Samples of all replays together.
    pub fn samples(&self) -> usize {
        self.subjects.len() * self.strokes.iter().map(|stroke| stroke.reference.len()).sum::<usize>()
    }

    /// Replays and compares; `each` is told how many more samples are done.
    ///
    /// # Errors
    /// What a plant refuses.
    pub fn run(&self, each: impl Fn(usize) + Sync) -> Result<Outcome> {
        let statics = statics::of(&self.subjects)?;
        let count = self.subjects.len();
        let traces = (0..count * self.strokes.len())
            .into_par_iter()
            .map(|k| {
                let (plant, machine) = &self.subjects[k % count];
                let stroke = &self.strokes[k / count];
                let traces = stroke.replay(machine, *plant);
                each(stroke.reference.len());
                traces
            })
            .collect::<Result<Vec<_>>>()?;
        let plants: Vec<PlantChoice> = self.subjects.iter().map(|(plant, _)| *plant).collect();
        let strokes: Vec<Replayed> = self
            .strokes
            .iter()
            .zip(traces.chunks(count))
            .map(|(stroke, traces)| Replayed::of(self.machine(), stroke, &plants, traces))
            .collect();
        Ok(Outcome {
            statics,
            offsets: self.offsets(&strokes),
            strokes,
            plants,
            is_closed_loop: self.machine().description().controller.is_some(),
        })
    }

    /// The machine of the reference plant.
    fn machine(&self) -> &Machine {
        &self.subjects[0].1
    }

    fn offsets(&self, strokes: &[Replayed]) -> Offsets {
        let constants = self.machine().constants();
        let period_s = constants.sample_period_s;
        let step_s = period_s / (period_s / STEP_S - 1e-9).ceil();
        let most = |of: fn(&Replayed) -> f64| strokes.iter().map(of).fold(0.0, f64::max);
        let mobility = constants.modes.as_slice().iter().map(|mode| 1.0 / mode.mass_kg()).sum::<f64>();
        Offsets {
            step_s,
            lead: 0.5 * step_s * most(|stroke| stroke.peak_velocity),
            rise: step_s * step_s / 12.0
                * (1.0 / constants.moving_mass + mobility)
                * most(|stroke| stroke.peak_thrust),
        }
    }
}

impl Outcome {
    /// Whether every difference keeps its bound.
    pub fn is_within(&self) -> bool {
        self.exceeded().is_empty()
    }

    /// What exceeds its bound, in words: each quantity and pair once, with its strokes.
    pub fn exceeded(&self) -> Vec<String> {
        let statics = self.statics.iter().filter(|row| row.is_exceeded()).map(|row| row.quantity.clone());
        let mut wrong: Vec<(String, Vec<String>)> = Vec::new();
        for stroke in &self.strokes {
            for difference in stroke.differences.iter().filter(|difference| difference.is_exceeded()) {
                let what = format!("{} of {}", difference.quantity, difference.pair);
                match wrong.iter_mut().find(|(known, _)| *known == what) {
                    Some((_, cells)) => cells.push(stroke.cell.to_string()),
                    None => wrong.push((what, vec![stroke.cell.to_string()])),
                }
            }
        }
        statics.chain(wrong.iter().map(|(what, cells)| format!("{what} on {}", cells.join(", ")))).collect()
    }

    /// The stroke that comes nearest to a bound, or is farthest beyond it.
    pub fn worst(&self) -> Option<&Replayed> {
        self.strokes.iter().max_by(|a, b| a.share_of_bound().total_cmp(&b.share_of_bound()))
    }

    /// Every bound that was applied, each once.
    pub fn bounds(&self) -> Vec<Bound> {
        let dynamic = self.strokes.iter().flat_map(|stroke| stroke.differences.iter().map(|d| d.bound));
        let mut all: Vec<Bound> = Vec::new();
        for bound in dynamic.chain(self.statics.iter().map(|row| row.bound)) {
            if !all.iter().any(|known| known.of == bound.of) {
                all.push(bound);
            }
        }
        all
    }
}
