//! What acts over one step of a twin.

use super::laws::Here;
use crate::guide::{Coast, StepForce};

/// What acts over one step beside the motor's own force, whose mean is here too, and dry friction.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Acting {
    /// Forces of position, velocity and time.
    pub push: StepForce,
    /// What laws that change the motor's force add to it.
    pub change: StepForce,
    /// Mean of the motor's force.
    pub motor: f64,
    pub weight: StepForce,
}

/// A step of which weight and dry friction are still to be found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Begun {
    pub acting: Acting,
    /// The step under all else.
    pub coast: Coast,
    pub here: Here,
    /// Levels of friction in proportion to a load.
    pub loaded: [f64; 2],
}

impl Begun {
    /// What acts over the step beside dry friction, under this weight.
    #[inline(always)]
    pub fn under(&self, weight: StepForce) -> Acting {
        Acting { weight, ..self.acting }
    }
}
