//! The linear part of the axis, continuous and discretised exactly.

use crate::drive::motor::Circuit;
use crate::effect::Constants;
use crate::plant::Resonance;
use nalgebra::{DMatrix, DVector};

/// Continuous linear dynamics `ż = A·z + b_u·u + b_f·f` of axis, winding and base.
///
/// # Model
/// With q the position of the moving part relative to the base point that receives the reaction, i the current of
/// the winding, η_j the base modes and f the force of the guide (friction, position forces):
/// ```text
///   L·di/dt = u − R·i − Ke·q̇
///   F   = Kt·i + f − c·q̇
///   M_j·(η̈_j + 2ζ_j·ω_j·η̇_j + ω_j²·η_j) = −F
///   q̈   = F/m − Σ η̈_j
/// ```
/// A direct motor has no state: its force is K·u. States in the order q̇, i, η_1, η̇_1/ω_1, η_2, …, q; the rates of the
/// modes are divided by ω_j so that the matrix is balanced.
#[derive(Debug, Clone)]
pub(super) struct Dynamics {
    pub layout: Layout,
    matrix: DMatrix<f64>,
    by_voltage: DVector<f64>,
    by_force: DVector<f64>,
}

/// Where the states stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    pub has_winding: bool,
    pub modes: usize,
}

impl Layout {
    /// Place of the current.
    pub const CURRENT: usize = 1;

    /// Number of states, position included.
    pub fn states(self) -> usize {
        2 + usize::from(self.has_winding) + 2 * self.modes
    }

    /// Place of the position: the last.
    pub fn position(self) -> usize {
        self.states() - 1
    }

    /// Place of the first mode.
    pub fn first_mode(self) -> usize {
        1 + usize::from(self.has_winding)
    }
}

/// One step: `z⁺ = Φ·z + Γ_u·u + Γ_f·mean + Γ_r·rise`.
#[derive(Debug, Clone)]
pub(super) struct Discrete {
    pub transition: DMatrix<f64>,
    pub by_voltage: DVector<f64>,
    pub by_mean: DVector<f64>,
    pub by_rise: DVector<f64>,
}

impl Dynamics {
    /// The dynamics of these constants.
    pub fn of(constants: &Constants) -> Self {
        let modes = constants.modes.as_slice();
        let has_winding = matches!(constants.circuit, Circuit::Winding { .. });
        let layout = Layout { has_winding, modes: modes.len() };
        let (size, velocity, position) = (layout.states(), 0, layout.position());
        let mut matrix = DMatrix::zeros(size, size);
        let mut by_force = DVector::zeros(size);
        let mut mobility = 1.0 / constants.moving_mass;
        for (j, mode) in modes.iter().enumerate() {
            let place = layout.first_mode() + 2 * j;
            let rate = place + 1;
            let omega = mode.angular_frequency_rad_per_s();
            let damping = 2.0 * mode.damping_ratio() * omega;
            matrix[(place, rate)] = omega;
            matrix[(rate, place)] = -omega;
            matrix[(rate, rate)] = -damping;
            by_force[rate] = -1.0 / (mode.mass_kg() * omega);
            // q̈ contains −η̈_j.
            matrix[(velocity, place)] = omega * omega;
            matrix[(velocity, rate)] = damping * omega;
            mobility += 1.0 / mode.mass_kg();
        }
        by_force[velocity] = mobility;
        // Drag acts where the guide's force acts.
        let drag = &by_force * -constants.viscous;
        let mut by_velocity = matrix.column_mut(velocity);
        by_velocity += &drag;
        matrix[(position, velocity)] = 1.0;
        let by_voltage = match constants.circuit {
            Circuit::Direct { force_per_volt } => &by_force * force_per_volt,
            Circuit::Winding { resistance_ohm, inductance_h, force_constant, back_emf } => {
                let current = Layout::CURRENT;
                let mut by_current = matrix.column_mut(current);
                by_current += &by_force * force_constant;
                matrix[(current, current)] = -resistance_ohm / inductance_h;
                matrix[(current, velocity)] = -back_emf / inductance_h;
                let mut by_voltage = DVector::zeros(size);
                by_voltage[current] = 1.0 / inductance_h;
                by_voltage
            }
        };
        Self { layout, matrix, by_voltage, by_force }
    }

    /// The same without the motor: no voltage, no current acts.
    pub fn without_motor(&self) -> Self {
        let mut forced = self.clone();
        forced.by_voltage.fill(0.0);
        if self.layout.has_winding {
            forced.matrix.column_mut(Layout::CURRENT).fill(0.0);
            forced.matrix.row_mut(Layout::CURRENT).fill(0.0);
        }
        forced
    }

    /// The oscillations of moving part, drag and base, by frequency; motions that do not oscillate are none.
    ///
    /// # Model
    /// Eigenvalues of the continuous matrix without the winding and without the position, which acts back on nothing.
    pub fn resonances(&self) -> Vec<Resonance> {
        let mut matrix = self.matrix.clone().remove_column(self.layout.position());
        matrix = matrix.remove_row(self.layout.position());
        if self.layout.has_winding {
            matrix = matrix.remove_column(Layout::CURRENT).remove_row(Layout::CURRENT);
        }
        Resonance::of(&matrix, 1e-9 * matrix.amax())
    }

    /// One step of `step_s`, with voltage held and force as mean and rise.
    ///
    /// # Model
    /// Matrix exponential of the dynamics with u, f and the slope of f as further states (Van Loan).
    ///
    /// # Source
    /// Åström, Wittenmark (1997), *Computer-Controlled Systems*, sections 2.3 and 8.3; Van Loan (1978), *Computing
    /// integrals involving the matrix exponential*.
    pub fn over(&self, step_s: f64) -> Discrete {
        let size = self.matrix.nrows();
        let (voltage, force, slope) = (size, size + 1, size + 2);
        let mut augmented = DMatrix::zeros(size + 3, size + 3);
        augmented.view_mut((0, 0), (size, size)).copy_from(&(&self.matrix * step_s));
        augmented.view_mut((0, voltage), (size, 1)).copy_from(&(&self.by_voltage * step_s));
        augmented.view_mut((0, force), (size, 1)).copy_from(&(&self.by_force * step_s));
        // In units of the step: f(s) = f(0) + rise·s.
        augmented[(force, slope)] = 1.0;
        let exact = augmented.exp();
        let column = |k: usize| exact.view((0, k), (size, 1)).column(0).into_owned();
        let by_mean = column(force);
        // mean + rise·(s − ½)
        let by_rise = column(slope) - &by_mean * 0.5;
        Discrete {
            transition: exact.view((0, 0), (size, size)).into_owned(),
            by_voltage: column(voltage),
            by_mean,
            by_rise,
        }
    }

    /// Change of the state at the end of a step per volt more until the share `switch` of it.
    ///
    /// # Model
    /// The response to a voltage over the whole step less that to one from the switch on.
    pub fn by_earlier_voltage(&self, step_s: f64, switch: f64) -> DVector<f64> {
        self.over(step_s).by_voltage - self.over((1.0 - switch) * step_s).by_voltage
    }
}
