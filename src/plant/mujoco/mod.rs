//! The plant in MuJoCo: the same URDF and meshes, read by another importer and moved by another engine.
//!
//! The point of this plant is that it shares no solver with the others: MuJoCo reads the solid model itself, integrates mass,
//! drag and base modes together, and works out what the guide carries. It is built with the feature `mujoco`; without that,
//! [`MujocoRig`] is known and refuses to be made.

#[cfg(not(feature = "mujoco"))]
mod absent;
#[cfg(feature = "mujoco")]
mod attack;
#[cfg(feature = "mujoco")]
mod engine;
#[cfg(feature = "mujoco")]
mod import;
#[cfg(feature = "mujoco")]
mod linear;
#[cfg(feature = "mujoco")]
mod rig;
#[cfg(feature = "mujoco")]
mod scene;
#[cfg(feature = "mujoco")]
mod state;
#[cfg(feature = "mujoco")]
mod urdf;

#[cfg(not(feature = "mujoco"))]
pub use absent::MujocoRig;
#[cfg(feature = "mujoco")]
pub use rig::MujocoRig;

pub use super::Resonance;
use crate::solid::MassProperties;

/// Whether this build has MuJoCo in it.
pub const IS_BUILT_IN: bool = cfg!(feature = "mujoco");

/// Version of MuJoCo that the binding is made for; any other has other structures in memory.
pub const VERSION: &str = "3.17.0";

/// Longest step of [`MujocoRig::new`] in s, the one of the rigid-body scene.
pub const LONGEST_STEP_S: f64 = 62.5e-6;

/// How MuJoCo integrates over a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Integrator {
    /// Explicit Runge–Kutta of fourth order, forces held over the step: the reference.
    #[default]
    RungeKutta,
    /// Semi-implicit Euler with joint damping implicit: MuJoCo's own default, a third of the work.
    Euler,
}

/// Mass properties as MuJoCo's importer reads them, to hold against those of [`Solid`](crate::solid::Solid).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Imported {
    /// Mass of all links, in kg.
    pub total_mass_kg: f64,
    /// All links that the joint moves, in the moving body's frame: mass, centre, inertia about the centre.
    pub moving: MassProperties,
    /// Meshes read from files; links that name the same file with the same scale share one.
    pub meshes: usize,
}
