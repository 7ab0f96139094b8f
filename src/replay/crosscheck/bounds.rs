//! How far plants may be apart, and why so far.

use super::quantity::Quantity;
use crate::drive::motor::Circuit;
use crate::machine::Machine;

/// A bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// What it bounds.
    pub of: &'static str,
    /// RMS in SI for a stroke, a relative difference for what needs no replay.
    pub limit: f64,
    /// How large it is and whence it comes.
    pub reason: &'static str,
}

/// Masses, centres and inertias, relative.
pub const MASS: Bound = Bound {
    of: "masses, centre, inertia",
    limit: 1e-9,
    reason: "rounding of sums over links and of turns to principal axes; masses are the URDF's inertials, so meshes in \
             single precision have no part in them",
};

/// Loads at rest, relative to the weight.
pub const LOAD_AT_REST: Bound = Bound {
    of: "loads at rest",
    limit: 1e-9,
    reason: "rounding; rapier's joint, which answers a load to 1e-5 in one step, has had 16 steps",
};

/// Count of oscillations.
pub const COUNT: Bound = Bound { of: "number of oscillations", limit: 0.0, reason: "a count" };

/// Frequencies of the assembled system, relative.
pub const FREQUENCY: Bound = Bound {
    of: "frequencies",
    limit: 1e-6,
    reason: "eigenvalues of two assemblies of the same masses, springs and dampers; 1e-6 is what Runge–Kutta's step leaves of \
             them in a replay",
};

/// Damping ratios of the assembled system, relative.
pub const DAMPING: Bound = Bound {
    of: "damping ratios",
    limit: 1e-4,
    reason: "the real part of an eigenvalue is some hundredth of it and keeps two digits less",
};

/// Bounds on a stroke.
struct OfStroke {
    position: Bound,
    velocity: Bound,
    thrust: Bound,
    loads: Bound,
}

/// A linear plant: held forces and their rise are all that moves it.
const LINEAR: OfStroke = OfStroke {
    position: Bound {
        of: "position",
        limit: 1e-9,
        reason: "1 nm (1 nrad) RMS; without back-EMF and laws of the guide, what is left is the curvature of a force \
                 within a step, and in rapier that base and drag do not feel its rise",
    },
    velocity: Bound {
        of: "velocity",
        limit: 1e-6,
        reason: "1e-6 of the stroke's peak RMS, as far as a mass that is 1e-6 off would move it",
    },
    thrust: Bound {
        of: "thrust",
        limit: 1e-6,
        reason: "1e-6 of the stroke's peak RMS, as far as a mass that is 1e-6 off would move it",
    },
    loads: Bound {
        of: "slider loads",
        limit: 1e-6,
        reason: "1e-6 of the largest load RMS; rapier's joint answers a change of load within a step to 1e-5 of that change",
    },
};

/// A plant with back-EMF or with laws of the guide, which every plant follows in steps of its own.
const BENT: OfStroke = OfStroke {
    position: Bound {
        of: "position",
        limit: 1e-7,
        reason: "0.1 µm (0.1 µrad) RMS; back-EMF and laws of the guide are followed to second order, by axis and engines in \
                 steps of their own",
    },
    velocity: Bound {
        of: "velocity",
        limit: 1e-4,
        reason: "1e-4 of the stroke's peak RMS; back-EMF and laws of the guide are followed to second order in the step",
    },
    thrust: Bound {
        of: "thrust",
        limit: 1e-4,
        reason: "1e-4 of the stroke's peak RMS; back-EMF and laws of the guide are followed to second order in the step",
    },
    loads: Bound {
        of: "slider loads",
        limit: 1e-4,
        reason: "1e-4 of the largest load RMS; laws of the guide are followed to second order in the step",
    },
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
    let bounds = if is_linear(machine) { LINEAR } else { BENT };
    let share = |bound: Bound, of: f64| Bound { limit: bound.limit * of, ..bound };
    match quantity {
        Quantity::Position => bounds.position,
        Quantity::Velocity => share(bounds.velocity, size.velocity),
        Quantity::Thrust => share(bounds.thrust, size.thrust),
        Quantity::Slider(_) => share(bounds.loads, size.load),
    }
}

/// Whether neither back-EMF nor an effect acts.
fn is_linear(machine: &Machine) -> bool {
    let has_back_emf =
        matches!(machine.constants().circuit, Circuit::Winding { back_emf, .. } if back_emf != 0.0);
    !has_back_emf && machine.effects().is_empty()
}
