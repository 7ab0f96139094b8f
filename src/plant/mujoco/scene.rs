//! The scene in MuJoCo: the imported machine, and what a URDF cannot say.

use mujoco_rs::mujoco_c::{mjtDisableBit, mjtIntegrator, mjtLimited};
use mujoco_rs::prelude::{MjModel, MjSpec, MjtJoint, SpecItem};

use super::urdf::{Reading, text_for};
use super::{Imported, Integrator, VERSION};
use crate::base::Mode;
use crate::effect::Constants;
use crate::error::{Error, ErrorKind, Result};
use crate::solid::{GRAVITY_M_PER_S2, Solid};
use crate::units::Motion;

/// Name of the tendon whose length is the axis coordinate.
const COORDINATE: &str = "slideway axis coordinate";

/// Name of the joint of a base mode.
pub(super) fn mode_name(number: usize) -> String {
    format!("slideway base mode {number}")
}

/// The machine's scene and what MuJoCo read of the solid model.
///
/// # Model
/// The moving links are one body on the driven joint; the base stands still as MuJoCo's world. Each base mode is a further
/// body of its modal mass M on a joint of its own along (about) the driven one's axis, with the spring M·ω² and the damper
/// 2ζω·M. A fixed tendon over the driven joint (+1) and the modes (−1) has the axis coordinate as its length, and the
/// guide's viscous drag as its damping. Nothing collides, no joint has a limit or friction, no weight pulls at a mode itself.
pub(super) fn build(
    solid: &Solid,
    constants: &Constants,
    step_s: f64,
    integrator: Integrator,
) -> Result<(MjModel, Imported)> {
    check_version()?;
    let as_written = compiled(solid, parsed(solid, Reading::AsWritten)?)?;
    let mut spec = parsed(solid, Reading::Merged)?;
    set_options(&mut spec, step_s, integrator);
    free_joint(&mut spec, solid)?;
    for (number, mode) in constants.modes.as_slice().iter().enumerate() {
        add_mode(&mut spec, solid, number, mode)?;
    }
    add_drag(&mut spec, solid, constants.modes.len(), constants.viscous)?;
    let merged = compiled(solid, spec)?;
    let bodies = 2 + constants.modes.len() as i64;
    if merged.nbody() != bodies {
        return Err(refusal(solid, &format!("{} bodies after links were merged", merged.nbody()))
            .expected(format!("{bodies}: the world, the moving body and the base's modes")));
    }
    let imported = Imported::of(solid, &as_written, &merged)?;
    Ok((merged, imported))
}

/// Refuses a library of another version: its structures would be read wrongly.
fn check_version() -> Result<()> {
    let found = mujoco_rs::mujoco_version();
    if found == VERSION {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Inconsistent)
        .key("MuJoCo")
        .found(format!("version {found} of the library"))
        .expected(format!("version {VERSION}"))
        .remedy("run `.ci/mujoco .mujoco` and set MUJOCO_DYNAMIC_LINK_DIR to the folder it names"))
}

fn parsed(solid: &Solid, reading: Reading) -> Result<MjSpec> {
    let text = text_for(solid, reading)?;
    if text.contains('\0') {
        return Err(refusal(solid, "a NUL character"));
    }
    MjSpec::from_xml_string(&text).map_err(|e| refusal(solid, &e.to_string()))
}

fn compiled(solid: &Solid, mut spec: MjSpec) -> Result<MjModel> {
    spec.compile().map_err(|e| refusal(solid, &e.to_string()))
}

fn set_options(spec: &mut MjSpec, step_s: f64, integrator: Integrator) {
    let option = spec.option_mut();
    option.timestep = step_s;
    option.gravity = [0.0, 0.0, -GRAVITY_M_PER_S2];
    option.integrator = match integrator {
        Integrator::RungeKutta => mjtIntegrator::mjINT_RK4 as i32,
        Integrator::Euler => mjtIntegrator::mjINT_EULER as i32,
    };
    // Auto-reset would start the scene anew, in silence, where a state is not finite.
    option.disableflags = [
        mjtDisableBit::mjDSBL_CONSTRAINT,
        mjtDisableBit::mjDSBL_CONTACT,
        mjtDisableBit::mjDSBL_LIMIT,
        mjtDisableBit::mjDSBL_FRICTIONLOSS,
        mjtDisableBit::mjDSBL_ACTUATION,
        mjtDisableBit::mjDSBL_SENSOR,
        mjtDisableBit::mjDSBL_WARMSTART,
        mjtDisableBit::mjDSBL_AUTORESET,
    ]
    .into_iter()
    .fold(0, |flags, bit| flags | bit as i32);
}

/// Friction, damping and limits belong to the laws that the twin applies, not to the URDF.
fn free_joint(spec: &mut MjSpec, solid: &Solid) -> Result<()> {
    let name = &solid.joint.name;
    let joint = spec.joint_mut(name).ok_or_else(|| missing(solid, name))?;
    joint.set_limited(mjtLimited::mjLIMITED_FALSE);
    joint.set_actfrclimited(mjtLimited::mjLIMITED_FALSE);
    joint.set_frictionloss(0.0);
    joint.damping_mut().fill(0.0);
    joint.stiffness_mut().fill(0.0);
    joint.set_armature(0.0);
    Ok(())
}

fn add_mode(spec: &mut MjSpec, solid: &Solid, number: usize, mode: &Mode) -> Result<()> {
    let axis = solid.joint.origin.rotation * solid.joint.axis.into_inner();
    let (mass, omega) = (mode.mass_kg(), mode.angular_frequency_rad_per_s());
    let body = spec.world_body_mut().add_body();
    body.set_mass(mass);
    // About a revolute axis the modal mass is an inertia; along a prismatic one the body does not turn.
    *body.inertia_mut() = [mass; 3];
    body.set_explicitinertial(true);
    let (motion, is_level) = match solid.joint.motion {
        Motion::Prismatic => (MjtJoint::mjJNT_SLIDE, axis.z == 0.0),
        Motion::Revolute => (MjtJoint::mjJNT_HINGE, true),
    };
    // Where gravity has no part along the axis, its compensation would only cost time.
    if !is_level {
        body.set_gravcomp(1.0);
    }
    let joint = body.add_joint();
    joint.set_name(&mode_name(number)).map_err(|e| refusal(solid, &e.to_string()))?;
    joint.set_type(motion);
    *joint.axis_mut() = axis.into();
    joint.stiffness_mut()[0] = mode.stiffness_n_per_m();
    joint.damping_mut()[0] = 2.0 * mode.damping_ratio() * omega * mass;
    Ok(())
}

fn add_drag(spec: &mut MjSpec, solid: &Solid, modes: usize, viscous: f64) -> Result<()> {
    let tendon = spec.add_tendon();
    tendon.set_name(COORDINATE).map_err(|e| refusal(solid, &e.to_string()))?;
    tendon.damping_mut()[0] = viscous;
    tendon.wrap_joint(&solid.joint.name, 1.0);
    for number in 0..modes {
        tendon.wrap_joint(&mode_name(number), -1.0);
    }
    Ok(())
}

/// An element of the URDF that MuJoCo does not have.
pub(super) fn missing(solid: &Solid, name: &str) -> Error {
    refusal(solid, "no element of that name")
        .key(name)
        .expected("every link and joint of the URDF in MuJoCo's model")
}

/// What MuJoCo refuses, with the mesh or the link that its message names.
pub(super) fn refusal(solid: &Solid, message: &str) -> Error {
    let between = |before: &str, after: char| {
        let (_, rest) = message.split_once(before)?;
        rest.split_once(after).map(|(inside, _)| inside.to_owned())
    };
    let lines: Vec<&str> = message.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    let mut error = Error::new(ErrorKind::Inconsistent);
    if let Some(file) = between("file '", '\'') {
        error = error.file(file);
    }
    if let Some(element) = between("lement name '", '\'').or_else(|| between("lement '", '\'')) {
        error = error.key(element);
    }
    error
        .file(&solid.path)
        .found(format!("by MuJoCo: {}", lines.join("; ")))
        .expected("a URDF and meshes that MuJoCo's importer takes")
        .remedy("correct what it names; meshes as OBJ or binary STL, inertias of bodies that can exist")
}
