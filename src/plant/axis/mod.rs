//! The reduced-order axis: moving mass, viscous guide and base modes, discretised exactly.

use super::Plant;
use crate::effect::Constants;
use crate::guide::stick_slip::Coast;
use nalgebra::DMatrix;

/// The axis reduced to what moves along the joint.
///
/// # Model
/// With q the position of the moving part relative to the base point that receives the reaction, and η_j
/// the base modes:
/// ```text
///   F   = F_motor + F_guide − c·q̇
///   M_j·(η̈_j + 2ζ_j·ω_j·η̇_j + ω_j²·η_j) = −F
///   q̈   = F/m − Σ η̈_j
/// ```
/// Forces are held over a step (zero-order hold), for which the matrix exponential is exact: no numerical
/// damping and no frequency error at any step length.
///
/// # Validity
/// The moving part is rigid; modes of the base move along the joint only.
///
/// # Source
/// Discretisation: Åström, Wittenmark, *Computer-Controlled Systems*, eq. 2.4.
#[derive(Debug, Clone)]
pub struct Axis {
    step_s: f64,
    /// Rows in blocks of four; `columns` blocks of four numbers for each row block.
    transition: Vec<[f64; 4]>,
    input: Vec<[f64; 4]>,
    columns: usize,
    /// q̇, η_1, η̇_1, η_2, …, then q last, then padding.
    state: Vec<f64>,
    ahead: Vec<[f64; 4]>,
    position_place: usize,
}

/// Longest step of the axis plant in s: reversals and pushes are resolved to second order inside it.
pub const LONGEST_STEP_S: f64 = 250e-6;

impl Axis {
    /// The axis with the longest step that divides the sample period and is at most [`LONGEST_STEP_S`].
    pub fn of(constants: &Constants) -> Self {
        let period = constants.sample_period_s;
        Self::new(constants, period / (period / LONGEST_STEP_S - 1e-9).ceil().max(1.0))
    }

    /// The axis with these constants, advancing by `step_s` each time.
    pub fn new(constants: &Constants, step_s: f64) -> Self {
        let dynamics = continuous(constants);
        let size = dynamics.nrows() - 1;
        let discrete = (dynamics * step_s).exp();
        let blocks = size.div_ceil(4);
        let entry = |row: usize, column: usize| if row < size { discrete[(row, column)] } else { 0.0 };
        // q (the last state) does not act back on the others: its column is the identity.
        let columns = size - 1;
        let mut transition = Vec::with_capacity(blocks * columns);
        for block in 0..blocks {
            for column in 0..columns {
                transition.push(std::array::from_fn(|r| entry(4 * block + r, column)));
            }
        }
        let input = (0..blocks).map(|block| std::array::from_fn(|r| entry(4 * block + r, size))).collect();
        Self {
            step_s,
            transition,
            input,
            columns,
            state: vec![0.0; 4 * blocks],
            ahead: vec![[0.0; 4]; blocks],
            position_place: size - 1,
        }
    }

    /// Displacement of the base at the reaction point in m, positive along the joint's positive direction.
    pub fn base_displacement(&self) -> f64 {
        (1..self.position_place).step_by(2).map(|k| self.state[k]).sum()
    }
}

/// Continuous dynamics `[A B; 0 0]` of the states q̇, η_1, η̇_1, …, q with the force as last column.
fn continuous(constants: &Constants) -> DMatrix<f64> {
    let modes = constants.modes.as_slice();
    let size = 2 + 2 * modes.len();
    let (velocity, position, force) = (0, size - 1, size);
    let mut matrix = DMatrix::zeros(size + 1, size + 1);
    let drag = constants.viscous;
    let mut mobility = 1.0 / constants.moving_mass;
    for (j, mode) in modes.iter().enumerate() {
        let (place, rate) = (1 + 2 * j, 2 + 2 * j);
        let omega = mode.angular_frequency_rad_per_s();
        let stiffness = omega * omega;
        let damping = 2.0 * mode.damping_ratio() * omega;
        matrix[(place, rate)] = 1.0;
        matrix[(rate, place)] = -stiffness;
        matrix[(rate, rate)] = -damping;
        matrix[(rate, velocity)] = drag / mode.mass_kg();
        matrix[(rate, force)] = -1.0 / mode.mass_kg();
        // q̈ contains −η̈_j.
        matrix[(velocity, place)] = stiffness;
        matrix[(velocity, rate)] = damping;
        mobility += 1.0 / mode.mass_kg();
    }
    matrix[(velocity, velocity)] = -drag * mobility;
    matrix[(velocity, force)] = mobility;
    matrix[(position, velocity)] = 1.0;
    matrix
}

impl Plant for Axis {
    fn step_s(&self) -> f64 {
        self.step_s
    }

    fn position(&self) -> f64 {
        self.state[self.position_place]
    }

    fn velocity(&self) -> f64 {
        self.state[0]
    }

    #[inline]
    fn coast(&mut self, force: f64) -> Coast {
        for (ahead, rows) in self.ahead.iter_mut().zip(self.transition.chunks_exact(self.columns)) {
            let mut sum = [0.0; 4];
            for (row, &value) in rows.iter().zip(&self.state) {
                for lane in 0..4 {
                    sum[lane] += row[lane] * value;
                }
            }
            *ahead = sum;
        }
        self.ahead[self.position_place / 4][self.position_place % 4] += self.state[self.position_place];
        let mobility = self.input[0][0];
        Coast { velocity: self.state[0], free_velocity: self.ahead[0][0] + mobility * force, mobility }
    }

    #[inline]
    fn advance(&mut self, motor_force: f64, guide_force: f64) {
        let force = motor_force + guide_force;
        for ((state, ahead), input) in self.state.chunks_exact_mut(4).zip(&self.ahead).zip(&self.input) {
            for lane in 0..4 {
                state[lane] = ahead[lane] + input[lane] * force;
            }
        }
    }

    fn place(&mut self, position: f64, velocity: f64) {
        self.state.fill(0.0);
        self.state[0] = velocity;
        self.state[self.position_place] = position;
    }

    fn relocate(&mut self, position: f64, velocity: f64) {
        self.state[0] = velocity;
        self.state[self.position_place] = position;
    }

    fn snapshot(&self) -> Vec<f64> {
        self.state.clone()
    }

    fn restore(&mut self, snapshot: &[f64]) {
        self.state.copy_from_slice(snapshot);
    }
}
