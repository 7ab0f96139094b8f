//! A whole run simulated along a position reference, and the seed of its noise.

use super::{Commands, PlantChoice, Traces};
use crate::error::Result;
use crate::machine::Machine;
use crate::twin::Sensing;
use sha2::{Digest, Sha256};

/// Lets the machine follow a sampled position reference from standstill, its loop closed.
///
/// Before the first sample it has stood at the first reference for 2 s. `each` is told after every sample how many are done.
///
/// # Errors
/// A machine without a controller, a reference beyond the joint's limits, or what the scene refuses.
pub fn simulate(
    machine: &Machine,
    plant: PlantChoice,
    sensing: Sensing,
    reference: &[f64],
    each: impl FnMut(usize),
) -> Result<Traces> {
    Commands::follow(machine, reference)?.simulate(machine, plant, sensing, each)
}

/// The seed of one run's noise: runs differ in it, but it depends on nothing but the run's name and `seed`.
pub fn run_seed(seed: u64, run: &str) -> u64 {
    let mut hash = Sha256::new();
    hash.update(seed.to_le_bytes());
    hash.update(run);
    let digest = hash.finalize();
    digest.iter().take(8).fold(0, |number, byte| number << 8 | u64::from(*byte))
}
