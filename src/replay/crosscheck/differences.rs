//! Differences of replayed strokes between plants.

use std::fmt;

use super::super::{Cell, PlantChoice, Traces};
use super::bounds::{self, Bound, Size};
use super::quantity::Quantity;
use super::strokes::Planned;
use crate::machine::Machine;

/// A plant and the one that is subtracted from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pair {
    /// The plant.
    pub of: PlantChoice,
    /// What is subtracted.
    pub from: PlantChoice,
}

impl fmt::Display for Pair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} − {}", short_name(self.of), short_name(self.from))
    }
}

/// A plant in a word.
pub fn short_name(plant: PlantChoice) -> &'static str {
    match plant {
        PlantChoice::Axis => "axis",
        PlantChoice::Rapier => "rapier",
        PlantChoice::Mujoco => "MuJoCo",
    }
}

/// The difference of two plants in one quantity.
#[derive(Debug, Clone)]
pub struct Difference {
    /// What is compared.
    pub quantity: Quantity,
    /// The plants.
    pub pair: Pair,
    /// The difference at every sample, in SI.
    pub series: Vec<f64>,
    /// Root of its mean square.
    pub rms: f64,
    /// Its largest size.
    pub peak: f64,
    /// The bound on its RMS.
    pub bound: Bound,
}

impl Difference {
    fn of(quantity: Quantity, pair: Pair, [a, b]: [Vec<f64>; 2], bound: Bound) -> Self {
        let series: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
        let rms = (series.iter().map(|d| d * d).sum::<f64>() / series.len().max(1) as f64).sqrt();
        Self { quantity, pair, rms, peak: largest(&series), bound, series }
    }

    /// Whether the bound is exceeded; what is not a number exceeds it.
    pub fn is_exceeded(&self) -> bool {
        self.rms.is_nan() || self.rms > self.bound.limit
    }
}

/// A stroke on all plants.
#[derive(Debug, Clone)]
pub struct Replayed {
    /// The stroke.
    pub cell: Cell,
    /// Time from rest to the feed, in s.
    pub ramp_s: f64,
    /// Time between two samples in s.
    pub period_s: f64,
    /// Differences, by quantity and then by pair.
    pub differences: Vec<Difference>,
    /// Highest speed on the reference plant.
    pub peak_velocity: f64,
    /// Largest thrust on the reference plant.
    pub peak_thrust: f64,
}

impl Replayed {
    pub(super) fn of(machine: &Machine, stroke: &Planned, plants: &[PlantChoice], traces: &[Traces]) -> Self {
        let reference = &traces[0];
        let peak_load = traces.iter().flat_map(|t| t.slider_loads.iter().flatten()).map(|load| load.abs());
        let size = Size {
            velocity: largest(&reference.velocity),
            thrust: largest(&reference.thrust),
            load: peak_load.fold(0.0, f64::max),
        };
        let mut differences = Vec::new();
        for quantity in [Quantity::Position, Quantity::Velocity, Quantity::Thrust]
            .into_iter()
            .chain((0..4).map(Quantity::Slider))
        {
            let bound = bounds::of_stroke(quantity, machine, &size);
            for pair in pairs(plants) {
                let both = [pair.of, pair.from].map(|plant| {
                    plants.iter().position(|p| *p == plant).and_then(|k| samples(quantity, &traces[k]))
                });
                if let [Some(a), Some(b)] = both {
                    differences.push(Difference::of(quantity, pair, [a, b], bound));
                }
            }
        }
        Self {
            cell: stroke.cell,
            ramp_s: stroke.ramp_s,
            period_s: machine.description().sample_period_s,
            differences,
            peak_velocity: size.velocity,
            peak_thrust: size.thrust,
        }
    }

    /// The pairs that were compared.
    pub fn pairs(&self) -> Vec<Pair> {
        let of_position = self.differences.iter().filter(|d| d.quantity == Quantity::Position);
        of_position.map(|d| d.pair).collect()
    }

    /// Largest share of a bound that any difference takes.
    pub fn share_of_bound(&self) -> f64 {
        let shares = self.differences.iter().map(|d| d.rms / d.bound.limit);
        shares.fold(0.0, |most, share| if share.is_nan() { f64::INFINITY } else { most.max(share) })
    }
}

/// Each later plant against each earlier one, the first being the reference.
fn pairs(plants: &[PlantChoice]) -> Vec<Pair> {
    let all = (0..plants.len()).flat_map(|of| (0..of).map(move |from| [of, from]));
    all.map(|[of, from]| Pair { of: plants[of], from: plants[from] }).collect()
}

fn samples(quantity: Quantity, traces: &Traces) -> Option<Vec<f64>> {
    match quantity {
        Quantity::Position => Some(traces.position.clone()),
        Quantity::Velocity => Some(traces.velocity.clone()),
        Quantity::Thrust => Some(traces.thrust.clone()),
        Quantity::Slider(k) if traces.slider_loads.len() == traces.len() => {
            Some(traces.slider_loads.iter().map(|loads| loads[k]).collect())
        }
        Quantity::Slider(_) => None,
    }
}

/// Largest size; not a number where any sample is none.
fn largest(values: &[f64]) -> f64 {
    values
        .iter()
        .fold(0.0, |most: f64, x| if x.is_nan() || most.is_nan() { f64::NAN } else { most.max(x.abs()) })
}
