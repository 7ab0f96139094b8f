//! The motor's winding, from its stated values.

use super::{Estimate, Screen};
use crate::drive::motor::Circuit;
use crate::effect::{BackEmf, Law, WindingInductance, WindingResistance};

impl Estimate for WindingResistance {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        vec![screen.constants.as_ref().map_or(vec![1.0], Self::neutral)]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let stated = screen.constants.as_ref().map_or(1.0, |c| Self::neutral(c)[0]);
        vec![(0.2 * stated, 5.0 * stated)]
    }
}

impl Estimate for WindingInductance {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        vec![screen.constants.as_ref().map_or(vec![1.0], Self::neutral)]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let stated = screen.constants.as_ref().map_or(1.0, |c| Self::neutral(c)[0]);
        vec![(0.1 * stated, 10.0 * stated)]
    }
}

impl Estimate for BackEmf {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let Some(constants) = &screen.constants else { return vec![vec![1.0]] };
        let stated = Self::neutral(constants);
        let Circuit::Winding { force_constant, .. } = constants.circuit else { return vec![stated] };
        // At zero, where none is stated, a fit stands on the edge of what is possible and may not find away from it.
        let more =
            [1e-3, 1e-2, 1e-1].map(|share| stated.iter().map(|ke| ke + share * force_constant).collect());
        std::iter::once(stated).chain(more).collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let most = match screen.constants.as_ref().map(|c| c.circuit) {
            Some(Circuit::Winding { force_constant, .. }) => 3.0 * force_constant,
            _ => 1.0,
        };
        vec![(0.0, most)]
    }
}
