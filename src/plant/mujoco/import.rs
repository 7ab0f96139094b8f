//! What MuJoCo's importer makes of the solid model.

use mujoco_rs::prelude::{MjModel, MjtObjBase};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::Imported;
use super::scene::missing;
use crate::error::Result;
use crate::solid::{MassProperties, Solid};

impl Imported {
    /// Reads them off the model of every link and that of the merged ones.
    pub(super) fn of(solid: &Solid, as_written: &MjModel, merged: &MjModel) -> Result<Self> {
        Ok(Self {
            total_mass_kg: as_written.totalmass(),
            moving: mass_properties(merged, body(solid, merged)?),
            meshes: usize::try_from(as_written.nmesh()).unwrap_or_default(),
        })
    }
}

/// MuJoCo's number of the moving body.
pub(super) fn body(solid: &Solid, model: &MjModel) -> Result<usize> {
    let name = &solid.moving.link;
    model.name_to_id(MjtObjBase::mjOBJ_BODY, name).ok_or_else(|| missing(solid, name))
}

/// Mass properties of a body in its frame.
pub(super) fn mass_properties(model: &MjModel, body: usize) -> MassProperties {
    let [w, i, j, k] = model.body_iquat()[body];
    let principal = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k)).to_rotation_matrix();
    let moments = Matrix3::from_diagonal(&Vector3::from(model.body_inertia()[body]));
    MassProperties {
        mass_kg: model.body_mass()[body],
        centre_m: Vector3::from(model.body_ipos()[body]),
        inertia_kg_m2: principal.matrix() * moments * principal.matrix().transpose(),
    }
}
