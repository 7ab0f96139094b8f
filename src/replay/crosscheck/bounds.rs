//! How far plants may be apart, and why so far.

use super::differences::Quantity;
use crate::drive::motor::Circuit;
use crate::machine::Machine;

/// A bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// What it bounds.
    pub of: &'static str,
    /// RMS in SI for a stroke, a relative difference for what needs no replay.
    pub limit: f64,
    /// Whence it comes.
    pub reason: &'static str,
}

/// Masses, centres and inertias, relative.
pub const MASS: Bound = Bound {
    of: "masses, centre, inertia",
    limit: 1e-9,
    reason: "rounding of sums over links and of a turn to principal axes; masses come from the URDF's inertials, so single-precision meshes have no part in it",
};

/// Loads at rest, relative to the weight.
pub const LOAD_AT_REST: Bound = Bound {
    of: "loads at rest",
    limit: 1e-6,
    reason: "rapier's joint answers a load to 1e-5 in a step and in full after it; MuJoCo and the load model round only",
};

/// Count of oscillations.
pub const COUNT: Bound = Bound { of: "number of oscillations", limit: 0.0, reason: "a count" };

/// Frequencies of the assembled system, relative.
pub const FREQUENCY: Bound = Bound {
    of: "frequencies",
    limit: 1e-6,
    reason: "eigenvalues of two assemblies of the same masses, springs and dampers",
};

/// Damping ratios of the assembled system, relative.
pub const DAMPING: Bound = Bound {
    of: "damping ratios",
    limit: 1e-4,
    reason: "the real part of an eigenvalue, a hundredth of its size, keeps two digits less",
};

/// Sizes of a stroke that bounds are shares of.
#[derive(Debug, Clone, Copy)]
pub struct Size {
    /// Highest speed.
    pub velocity: f64,
    /// Largest thrust.
    pub thrust: f64,
    /// Largest load of a slider.
    pub load: f64,
}

/// The bound on the RMS of a quantity over a stroke.
pub fn of_stroke(quantity: Quantity, machine: &Machine, size: &Size) -> Bound {
    let _ = (quantity, machine, size);
    Bound { of: "x", limit: 1e-7, reason: "" }
}
