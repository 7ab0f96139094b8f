//! The assembled scene as a linear system, from MuJoCo's own masses and forces.

use nalgebra::{DMatrix, DVector};

use super::Resonance;
use super::engine::Engine;
use super::state::{RiseResponse, State};

/// Mass, damping and stiffness matrix about the scene's zero.
///
/// # Model
/// `M·q̈ + D·q̇ + K·q = g·F`, with g = 1 on the driven joint and −1 on every mode. M is MuJoCo's; columns of D and K are the
/// forces that its springs and dampers exert at a unit of one speed or coordinate.
#[derive(Debug, Clone)]
pub(super) struct Linear {
    mass: DMatrix<f64>,
    damping: DMatrix<f64>,
    stiffness: DMatrix<f64>,
    effort: DVector<f64>,
}

impl Linear {
    pub fn of(engine: &mut Engine) -> Self {
        let zero = engine.zero();
        let size = zero.q.len();
        let mass = DMatrix::from_row_slice(size, size, &engine.mass_matrix(&zero));
        let still = engine.passive_forces(&zero);
        let mut column = |state: State| {
            let forces = engine.passive_forces(&state);
            DVector::from_iterator(size, still.iter().zip(&forces).map(|(still, moved)| still - moved))
        };
        let unit = |dof: usize| {
            let mut unit = vec![0.0; size];
            unit[dof] = 1.0;
            unit
        };
        let stiffness: Vec<_> = (0..size).map(|k| column(State { q: unit(k), v: zero.v.clone() })).collect();
        let damping: Vec<_> = (0..size).map(|k| column(State { q: zero.q.clone(), v: unit(k) })).collect();
        Self {
            mass,
            damping: DMatrix::from_columns(&damping),
            stiffness: DMatrix::from_columns(&stiffness),
            effort: DVector::from_fn(size, |dof, _| engine.sign(dof)),
        }
    }

    /// Mass (or inertia) of one degree of freedom.
    pub fn inertia(&self, dof: usize) -> f64 {
        self.mass[(dof, dof)]
    }

    /// The oscillations, by frequency; motions that do not oscillate are none.
    ///
    /// # Model
    /// Eigenvalues of `[[0, ω₀·1], [−M⁻¹K/ω₀, −M⁻¹D]]` for the states ω₀·q and q̇; ω₀ balances the matrix.
    pub fn resonances(&self) -> Vec<Resonance> {
        let Some(inverse) = self.mass.clone().try_inverse() else { return Vec::new() };
        let size = self.mass.nrows();
        let (by_coordinate, by_speed) = (&inverse * &self.stiffness, &inverse * &self.damping);
        let scale = by_coordinate.amax().sqrt();
        if scale == 0.0 {
            return Vec::new();
        }
        let mut system = DMatrix::zeros(2 * size, 2 * size);
        system.view_mut((0, size), (size, size)).fill_diagonal(scale);
        system.view_mut((size, 0), (size, size)).copy_from(&(by_coordinate / -scale));
        system.view_mut((size, size), (size, size)).copy_from(&-by_speed);
        Resonance::of(&system, 1e-9 * scale)
    }

    /// What the engine, which holds a force over a step, leaves out of one that rises within it.
    ///
    /// # Model
    /// A force `rise·(t/h − ½)` with the force vector b = M⁻¹g moves the state at the end of the step by
    /// `−h²/12·A·b·rise` (first moment of the force; A the system's matrix, the next term is smaller by ω·h/2): the
    /// coordinates by `−h²/12·M⁻¹g`, the speeds by `+h²/12·M⁻¹·D·M⁻¹g`. It belongs into the state itself: base modes and
    /// drag answer to it.
    ///
    /// # Source
    /// Euler and Maclaurin's correction of the trapezoidal rule.
    pub fn rise_response(&self, step_s: f64) -> RiseResponse {
        let Some(inverse) = self.mass.clone().try_inverse() else {
            let none = vec![0.0; self.effort.len()];
            return RiseResponse { q: none.clone(), v: none };
        };
        let moment = step_s * step_s / 12.0;
        let accelerations = &inverse * &self.effort;
        let slowed = &inverse * (&self.damping * &accelerations);
        RiseResponse {
            q: accelerations.iter().map(|a| -moment * a).collect(),
            v: slowed.iter().map(|a| moment * a).collect(),
        }
    }
}
