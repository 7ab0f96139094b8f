//! The guide: what the moving part slides or turns on, and how it sticks and slips.

mod bristle;
mod friction;
mod level;
mod step;
mod step_equation;
pub mod stick_slip;

pub use bristle::{Bristle, Sliding};
pub use friction::{DryFriction, Local, Stribeck};
pub use level::Level;
pub(crate) use step::travel_until;
pub use step::{Coast, GAUSS, Response, StepForce};
pub use step_equation::{GAUSSIAN, StepEquation, StepEquations};

use serde::{Deserialize, Serialize};

/// The guide as the machine file states it.
///
/// # Model
/// `F = −c·v`. Dry friction is an effect of the catalogue, stated under `[effect]`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Guide {
    /// Viscous coefficient c in N·s/m, or N·m·s/rad for a revolute axis.
    #[serde(default, alias = "viscous_nm_s_per_rad")]
    pub viscous_n_s_per_m: f64,
    /// Links of the four bearing sliders A–D, whose loads the rigid-body scene reports.
    #[serde(default)]
    pub sliders: Vec<String>,
}
