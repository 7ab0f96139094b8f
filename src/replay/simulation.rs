//! A whole run simulated: which plant, which sensors, within the travel of the axis.

use std::fmt;

use super::{Commands, Traces};
use crate::error::{Error, ErrorKind, Result};
use crate::machine::Machine;
use crate::twin::Sensing;
use crate::units::Motion;
use sha2::{Digest, Sha256};

/// The plant that a simulation runs on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PlantChoice {
    /// The rigid-body scene built from URDF and meshes; knows the slider loads.
    #[default]
    Rapier,
    /// The reduced-order axis derived from the solid model.
    Axis,
    /// The same URDF and meshes in MuJoCo; knows the slider loads. Needs the feature `mujoco`.
    Mujoco,
}

impl fmt::Display for PlantChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Rapier => "rigid-body scene (rapier)",
            Self::Axis => "reduced axis",
            Self::Mujoco => "scene in MuJoCo",
        })
    }
}

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

/// Samples of a run at most: more than a day at 1 kHz.
const MOST_SAMPLES: f64 = 1e8;

/// The sampled position reference of a motion that the machine can make.
///
/// # Errors
/// A motion beyond the joint's limits, or one that would take more than 10⁸ samples; found before anything is sampled.
pub fn planned_reference(machine: &Machine, motion: &super::Motion) -> Result<Vec<f64>> {
    let reached: Vec<f64> = motion
        .strokes
        .iter()
        .scan(0.0, |from, stroke| {
            *from += stroke.stroke;
            Some(*from)
        })
        .collect();
    check_travel(machine, &reached)?;
    check_samples(machine, motion, 1)?;
    Ok(motion.reference(machine.description().sample_period_s))
}

/// Refuses so many runs of a motion that would take more than 10⁸ samples together.
///
/// # Errors
/// As said.
pub fn check_samples(machine: &Machine, motion: &super::Motion, runs: usize) -> Result<()> {
    let period_s = machine.description().sample_period_s;
    let of_stroke = |stroke: &super::Stroke| stroke.duration_s(motion.ramp_s) + motion.dwell_s;
    let duration_s = motion.lead_s + motion.strokes.iter().map(of_stroke).sum::<f64>();
    let samples = duration_s / period_s * runs as f64;
    if samples <= MOST_SAMPLES {
        return Ok(());
    }
    let each = if runs > 1 { format!("{runs} motions") } else { "a motion".to_owned() };
    Err(Error::new(ErrorKind::OutOfRange)
        .key("cell")
        .found(format!("{each} of {duration_s:.3e} s, {samples:.1e} samples"))
        .expected(format!("at most {MOST_SAMPLES:.0e} samples"))
        .remedy("ask for a higher feed, a shorter standstill, or fewer runs"))
}

/// Refuses a reference beyond the joint's limits.
pub(super) fn check_travel(machine: &Machine, reference: &[f64]) -> Result<()> {
    let joint = &machine.solid().joint;
    match reference.iter().find(|position| !(joint.lower..=joint.upper).contains(*position)) {
        None => Ok(()),
        Some(_) => {
            let far = reference.iter().copied().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
            let unit = match joint.motion {
                Motion::Prismatic => "m",
                Motion::Revolute => "rad",
            };
            Err(Error::new(ErrorKind::OutOfRange)
                .file(&machine.solid().path)
                .key(joint.name.clone())
                .found(format!("a motion to {far} {unit}"))
                .expected(format!("positions from {} to {} {unit}", joint.lower, joint.upper))
                .remedy("shorten the stroke; it starts at position 0"))
        }
    }
}

/// The seed of one run's noise: runs differ in it, but it depends on nothing but the run's name and `seed`.
pub fn run_seed(seed: u64, run: &str) -> u64 {
    let mut hash = Sha256::new();
    hash.update(seed.to_le_bytes());
    hash.update(run);
    let digest = hash.finalize();
    digest.iter().take(8).fold(0, |number, byte| number << 8 | u64::from(*byte))
}
