//! Engines that simulate forged machines.

use super::laws::{Forged, ForgedLaws, Otherwise};
use crate::error::Result;
use crate::machine::Machine;
use crate::plant::axis::{Axis, longest_step};
use crate::plant::mujoco::{self, Integrator, MujocoRig};
use crate::plant::rapier::Rig;
use crate::replay::{Commands, Traces};
use crate::twin::Sensing;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Longest step of a forging plant in s: an eighth of the step on which the diagnosis replays.
pub const STEP_S: f64 = 31.25e-6;
/// Longest step while the sizes of hidden effects are measured, in s.
pub const SKETCH_STEP_S: f64 = 62.5e-6;
/// The axis has stood at the first reference for so long before a run begins, in s.
const STOOD_S: f64 = 1.0;

/// The engine that simulates forged machines, around which lie the [`ForgedLaws`].
///
/// A further engine is a variant here, its plant in [`Engine::simulate`] and its word in [`Engine::name`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Engine {
    /// The rigid-body scene built from URDF and meshes, at an eighth of the diagnosing plant's step.
    #[default]
    Rapier,
    /// The reduced axis at the same step: some ten times faster, and nearer to what the diagnosis replays on.
    Axis,
    /// MuJoCo by Runge and Kutta at the same step: shares no solver with the diagnosis. Needs the feature `mujoco`.
    Mujoco,
}

impl Engine {
    /// Every engine.
    pub const ALL: [Self; 3] = [Self::Rapier, Self::Axis, Self::Mujoco];

    /// The word on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rapier => "rapier",
            Self::Axis => "axis",
            Self::Mujoco => "mujoco",
        }
    }

    /// Lets a forged machine follow a sampled position reference from standstill, at a time of the session in s, in steps of at most
    /// `step_s`.
    ///
    /// # Errors
    /// What the plant refuses.
    pub fn simulate(
        self,
        machine: &Machine,
        otherwise: &Otherwise,
        sensing: Sensing,
        reference: &[f64],
        begins_s: f64,
        step_s: f64,
    ) -> Result<Traces> {
        let commands = Commands::follow(machine, reference)?.from_first().beginning(begins_s);
        self.stepped(machine, otherwise, sensing, (&commands, STOOD_S), step_s, |_| ())
    }

    /// Lets a machine that is otherwise so be told commands, after so long a standstill in closed loop; `each` is told
    /// after every sample how many are done. The step is [`STEP_S`] at most.
    ///
    /// # Errors
    /// What the plant refuses.
    pub fn told(
        self,
        machine: &Machine,
        otherwise: &Otherwise,
        sensing: Sensing,
        commands: &Commands,
        stood_s: f64,
        each: impl FnMut(usize),
    ) -> Result<Traces> {
        self.stepped(machine, otherwise, sensing, (commands, stood_s), STEP_S, each)
    }

    fn stepped(
        self,
        machine: &Machine,
        otherwise: &Otherwise,
        sensing: Sensing,
        (commands, stood_s): (&Commands, f64),
        longest_s: f64,
        each: impl FnMut(usize),
    ) -> Result<Traces> {
        let step_s = step(machine, longest_s);
        let (walked, laws) = ForgedLaws::split(machine, otherwise)?;
        let clock_s = commands.begins_s() - commands.stood_s(stood_s);
        match self {
            Self::Rapier => {
                let plant = Forged::new(Rig::with_step(&walked, step_s)?, laws, clock_s);
                commands.walk(&walked, plant, sensing, stood_s, each)
            }
            Self::Axis => {
                let plant = Forged::new(Axis::new(&walked.constants(), step_s), laws, clock_s);
                commands.walk(&walked, plant, sensing, stood_s, each)
            }
            Self::Mujoco => {
                let plant = MujocoRig::with_step(&walked, step_s, Integrator::RungeKutta)?;
                commands.walk(&walked, Forged::new(plant, laws, clock_s), sensing, stood_s, each)
            }
        }
    }
}

/// The same with perfect sensors on the reduced axis at a coarser step: fast, for measuring sizes; the run begins at a time of the session in s.
///
/// # Errors
/// A machine without a controller, or a reference beyond its joint's limits.
pub fn sketch(machine: &Machine, otherwise: &Otherwise, reference: &[f64], begins_s: f64) -> Result<Traces> {
    let (walked, laws) = ForgedLaws::split(machine, otherwise)?;
    let plant =
        Forged::new(Axis::new(&walked.constants(), step(machine, SKETCH_STEP_S)), laws, begins_s - STOOD_S);
    let commands = Commands::follow(machine, reference)?.from_first().beginning(begins_s);
    commands.walk(&walked, plant, Sensing::Perfect, STOOD_S, |_| ())
}

/// The longest step of a machine that is at most `longest_s`.
fn step(machine: &Machine, longest_s: f64) -> f64 {
    longest_step(machine.description().sample_period_s, longest_s)
}

impl fmt::Display for Engine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Engine {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let names = Self::ALL.map(Self::name).join(", ");
        let engine = Self::ALL.into_iter().find(|e| e.name() == text);
        if engine == Some(Self::Mujoco) && !mujoco::IS_BUILT_IN {
            return Err("this program was built without MuJoCo; build it with `--features mujoco`".to_owned());
        }
        engine.ok_or_else(|| format!("expected one of {names}"))
    }
}
