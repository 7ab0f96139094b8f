//! What stands for the plant in MuJoCo where this build has none.

use super::{Imported, Integrator, Resonance};
use crate::effect::Constants;
use crate::error::{Error, ErrorKind, Result};
use crate::guide::{Coast, StepForce};
use crate::machine::Machine;
use crate::plant::rapier::Reaction;
use crate::plant::{Drive, Plant};

/// The plant in MuJoCo, which this build does not have: there is no value of this type.
#[derive(Debug, Clone, Copy)]
pub enum MujocoRig {}

impl MujocoRig {
    /// Refuses.
    ///
    /// # Errors
    /// Always, with how to build with MuJoCo.
    pub fn new(_: &Machine) -> Result<Self> {
        Err(refusal())
    }

    /// Refuses.
    ///
    /// # Errors
    /// Always, with how to build with MuJoCo.
    pub fn with_step(_: &Machine, _: f64, _: Integrator) -> Result<Self> {
        Err(refusal())
    }

    /// Refuses.
    ///
    /// # Errors
    /// Always, with how to build with MuJoCo.
    pub fn with_constants(_: &Machine, _: &Constants, _: f64, _: Integrator) -> Result<Self> {
        Err(refusal())
    }

    /// How the steps are integrated.
    pub fn integrator(&self) -> Integrator {
        match *self {}
    }

    /// What MuJoCo's importer made of URDF and meshes.
    pub fn imported(&self) -> &Imported {
        match *self {}
    }

    /// What an effort along the joint accelerates by MuJoCo's mass matrix.
    pub fn moving_inertia(&self) -> f64 {
        match *self {}
    }

    /// Frequencies and damping ratios of moving part, drag and base together.
    pub fn resonances(&self) -> Vec<Resonance> {
        match *self {}
    }

    /// Displacement of the base at the reaction point, in m or rad.
    pub fn base_displacement(&self) -> f64 {
        match *self {}
    }

    /// What the base exerts on the moving body through the joint.
    pub fn reaction(&mut self) -> Reaction {
        match *self {}
    }
}

fn refusal() -> Error {
    Error::new(ErrorKind::Missing)
        .key("mujoco")
        .found("a program that was built without MuJoCo")
        .expected("one built with the feature `mujoco`")
        .remedy("run `.ci/mujoco .mujoco`, set MUJOCO_DYNAMIC_LINK_DIR as it says, and build with `--features mujoco`")
}

impl Plant for MujocoRig {
    fn carries_weight(&self) -> bool {
        match *self {}
    }

    fn step_s(&self) -> f64 {
        match *self {}
    }

    fn position(&self) -> f64 {
        match *self {}
    }

    fn velocity(&self) -> f64 {
        match *self {}
    }

    fn current(&self) -> f64 {
        match *self {}
    }

    fn set_current(&mut self, _: f64) {
        match *self {}
    }

    fn coast(&mut self, _: Drive) -> Coast {
        match *self {}
    }

    fn advance(&mut self, _: StepForce, _: StepForce) {
        match *self {}
    }

    fn place(&mut self, _: f64, _: f64) {
        match *self {}
    }

    fn snapshot(&self) -> Vec<f64> {
        match *self {}
    }

    fn restore(&mut self, _: &[f64]) {
        match *self {}
    }
}
