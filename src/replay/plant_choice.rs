//! Which plant a simulation runs on.

use std::fmt;

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
