//! The spring–mass chain that answers at its first mass exactly as the base's modes do.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, DVector, SymmetricEigen};

use super::modes::{Mode, Modes};
use crate::error::{Error, ErrorKind, Result};

/// Relative distance of two frequencies below which they count as equal.
///
/// The coupling between the chain's masses shrinks with the distance; at 1e-6 half of the digits of the far
/// masses are lost.
const SMALLEST_SEPARATION: f64 = 1e-6;
/// Coupling between modes by the damping, relative to the largest modal damping, that rounding explains.
const MODAL_COUPLING: f64 = 1e-9;

/// Masses in a row, each held by a spring to the next, the last to ground; the drive pushes mass 1.
///
/// # Model
/// ```text
/// F → [m₁]──k₁──[m₂]──k₂── … ──[m_N]──k_N──|ground      M ẍ + C ẋ + K x = F e₁,  base displacement = x₁
/// ```
/// [`Chain::from_modes`] solves the inverse eigenvalue problem: N eigenfrequencies and N drive-point residues
/// 1/Mᵢ determine the N masses and N springs. The symmetric J = M^−½ K M^−½ is a Jacobi matrix with
/// eigenvalues ωᵢ² whose eigenvectors have first components √(wᵢ), wᵢ = (1/Mᵢ)/Σ(1/Mⱼ); Lanczos' process on
/// diag(ωᵢ²) from √w, orthogonalised in full, builds it. Then m₁ = 1/Σ(1/Mᵢ), and row by row kⱼ = aⱼmⱼ − kⱼ₋₁
/// and mⱼ₊₁ = kⱼ²/(bⱼ²mⱼ), aⱼ and bⱼ the diagonals of J.
///
/// The free choice: this is the one chain whose driven mass has no spring of its own to ground. A spring k₀
/// there, anywhere between 0 and the static stiffness of the base, would give another chain with the same
/// response; k₀ = 0 makes it unique.
///
/// Damping is modal, C = M^½ V diag(2ζᵢωᵢ) Vᵀ M^½ with V the eigenvectors of J. That couples masses that are
/// no neighbours, and no dashpots between neighbours do the same unless ζᵢ is proportional to ωᵢ
/// ([`neighbour_dashpots_n_s_per_m`](Self::neighbour_dashpots_n_s_per_m)): a polynomial in J that is again
/// tridiagonal is linear in J. So the full matrix is kept.
///
/// # Validity
/// Distinct frequencies: the eigenvalues of a Jacobi matrix are simple. The chain's inner masses are
/// equivalents, not parts of the machine; neighbouring frequencies a few per cent apart make the far ones
/// many thousand times the driven one.
///
/// ```
/// use slideway::base::{chain::Chain, modes::{Mode, Modes}};
/// let modes = Modes::new(vec![Mode::new(86.1, 1500.0, 0.02)?, Mode::new(134.19, 2200.0, 0.02)?]);
/// let chain = Chain::from_modes(&modes)?;
/// let (wanted, found) = (modes.drive_point_response(100.0), chain.drive_point_response(100.0)?);
/// assert!((found - wanted).norm() < 1e-9 * wanted.norm());
/// # Ok::<(), slideway::error::Error>(())
/// ```
///
/// # Source
/// Gladwell, Inverse Problems in Vibration, 2nd ed., chapters 3 and 4.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    masses_kg: Vec<f64>,
    springs_n_per_m: Vec<f64>,
    damping_n_s_per_m: DMatrix<f64>,
}

impl Chain {
    /// From masses, springs (the j-th between mass j and j+1, the last to ground) and dashpots beside the
    /// springs, 0 for none.
    ///
    /// # Errors
    /// No mass; lists of unequal length; a mass or spring that is not finite and > 0; a dashpot that is not
    /// finite and ≥ 0.
    pub fn new(masses_kg: Vec<f64>, springs_n_per_m: Vec<f64>, dashpots_n_s_per_m: &[f64]) -> Result<Self> {
        for (key, list) in
            [("springs_n_per_m", &springs_n_per_m[..]), ("dashpots_n_s_per_m", dashpots_n_s_per_m)]
        {
            if masses_kg.is_empty() || list.len() != masses_kg.len() {
                return Err(Error::new(ErrorKind::Inconsistent)
                    .key(key)
                    .found(format!("{} entries for {} masses", list.len(), masses_kg.len()))
                    .expected("at least one mass, and one entry a mass, the last to ground")
                    .remedy("list as many springs and dashpots as masses"));
            }
        }
        check(&masses_kg, "masses_kg", |x| x > 0.0, "finite masses > 0")?;
        check(&springs_n_per_m, "springs_n_per_m", |x| x > 0.0, "finite stiffnesses > 0")?;
        check(dashpots_n_s_per_m, "dashpots_n_s_per_m", |x| x >= 0.0, "finite dashpots >= 0")?;
        let damping_n_s_per_m = neighbour_matrix(dashpots_n_s_per_m);
        Ok(Self { masses_kg, springs_n_per_m, damping_n_s_per_m })
    }

    /// The chain whose drive-point receptance at mass 1 is that of the modes.
    ///
    /// # Errors
    /// No mode; two equal frequencies; modes so unequal that a mass or spring of the chain is lost to
    /// rounding.
    pub fn from_modes(modes: &Modes) -> Result<Self> {
        let modes = sorted_distinct(modes)?;
        // eigenvalues relative to the largest, so that nothing under- or overflows
        let largest = modes[modes.len() - 1].angular_frequency_rad_per_s();
        let spectrum: Vec<f64> =
            modes.iter().map(|m| (m.angular_frequency_rad_per_s() / largest).powi(2)).collect();
        let residue: f64 = modes.iter().map(|mode| mode.mass_kg().recip()).sum();
        let weights: Vec<f64> = modes.iter().map(|mode| mode.mass_kg().recip() / residue).collect();
        let jacobi = Jacobi::from_spectrum(&spectrum, &weights);
        let (masses_kg, springs_n_per_m) = jacobi.masses_and_springs(residue.recip(), largest * largest)?;
        let modal: Vec<f64> =
            modes.iter().map(|m| 2.0 * m.damping_ratio() * m.angular_frequency_rad_per_s()).collect();
        // the Lanczos vectors are the rows of V up to the sign by which J's couplings become negative
        let v = DMatrix::from_fn(modes.len(), modes.len(), |mass, mode| {
            let sign = if mass % 2 == 0 { 1.0 } else { -1.0 };
            sign * masses_kg[mass].sqrt() * jacobi.vectors[(mode, mass)]
        });
        let damping_n_s_per_m = &v * DMatrix::from_diagonal(&DVector::from_vec(modal)) * v.transpose();
        Ok(Self { masses_kg, springs_n_per_m, damping_n_s_per_m })
    }

    /// The modes of the chain at its driven mass, lowest frequency first.
    ///
    /// # Errors
    /// Damping that couples the modes (then no modes with damping ratios describe the chain) or is critical
    /// and beyond.
    pub fn to_modes(&self) -> Result<Modes> {
        let stiffness = self.mass_normalised(&self.stiffness_matrix_n_per_m());
        let eigen = SymmetricEigen::new(stiffness.clone());
        let damping = eigen.eigenvectors.transpose()
            * self.mass_normalised(&self.damping_n_s_per_m)
            * &eigen.eigenvectors;
        let bound = MODAL_COUPLING * damping.diagonal().amax();
        let coupled = (0..self.len()).any(|i| (0..i).any(|j| damping[(i, j)].abs() > bound));
        if coupled {
            return Err(Error::new(ErrorKind::Undetermined)
                .key("dashpots_n_s_per_m")
                .found("damping that couples the chain's modes")
                .expected("modal damping, such as dashpots in one proportion to the springs")
                .remedy("make the dashpots proportional to the springs, or keep the chain as it is"));
        }
        let mut modes = Vec::with_capacity(self.len());
        for (i, eigenvalue) in eigen.eigenvalues.iter().enumerate() {
            let omega = eigenvalue.max(0.0).sqrt();
            let component =
                first_component(&stiffness, *eigenvalue, &eigen.eigenvectors.column(i).into_owned());
            let mass_kg = self.masses_kg[0] / component.powi(2);
            // C is positive semidefinite; rounding may leave an undamped mode just below zero
            let modal_damping = damping[(i, i)].max(0.0);
            modes.push(Mode::new(omega / TAU, mass_kg, modal_damping / (2.0 * omega))?);
        }
        modes.sort_by(|a, b| a.frequency_hz().total_cmp(&b.frequency_hz()));
        Ok(Modes::new(modes))
    }

    /// Receptance at mass 1: its displacement over the force on it, m/N.
    ///
    /// # Errors
    /// Exactly at the frequency of a mode without damping, where the response is infinite.
    pub fn drive_point_response(&self, frequency_hz: f64) -> Result<Complex<f64>> {
        let omega = TAU * frequency_hz;
        let stiffness = self.mass_normalised(&self.stiffness_matrix_n_per_m());
        let damping = self.mass_normalised(&self.damping_n_s_per_m);
        let mut dynamic = stiffness.zip_map(&damping, |k, c| Complex::new(k, omega * c));
        for i in 0..self.len() {
            dynamic[(i, i)] -= omega * omega;
        }
        let mut unit = DVector::from_element(self.len(), Complex::new(0.0, 0.0));
        unit[0] = Complex::new(1.0, 0.0);
        let solution = dynamic.lu().solve(&unit).ok_or_else(|| {
            Error::new(ErrorKind::Undetermined)
                .key("frequency_hz")
                .found(format!("{frequency_hz} Hz, the frequency of a mode without damping"))
                .expected("a frequency at which the response is finite")
                .remedy("give the mode some damping or ask beside it")
        })?;
        Ok(solution[0] / self.masses_kg[0])
    }

    /// Displacement of mass 1 per constant force, m/N: the springs in series.
    pub fn static_compliance_m_per_n(&self) -> f64 {
        self.springs_n_per_m.iter().map(|k| k.recip()).sum()
    }

    /// Number of masses.
    pub fn len(&self) -> usize {
        self.masses_kg.len()
    }

    /// Never true: a chain has at least one mass.
    pub fn is_empty(&self) -> bool {
        self.masses_kg.is_empty()
    }

    /// m₁ (driven) … m_N, kg.
    pub fn masses_kg(&self) -> &[f64] {
        &self.masses_kg
    }

    /// k₁ (between masses 1 and 2) … k_N (to ground), N/m.
    pub fn springs_n_per_m(&self) -> &[f64] {
        &self.springs_n_per_m
    }

    /// K, N/m.
    pub fn stiffness_matrix_n_per_m(&self) -> DMatrix<f64> {
        neighbour_matrix(&self.springs_n_per_m)
    }

    /// C, N·s/m; in general full.
    pub fn damping_matrix_n_s_per_m(&self) -> &DMatrix<f64> {
        &self.damping_n_s_per_m
    }

    /// Dashpots beside the springs that do what C does, N·s/m; none if C cannot be built from them.
    pub fn neighbour_dashpots_n_s_per_m(&self) -> Option<Vec<f64>> {
        // the diagonal of a neighbour matrix is c_j + c_{j−1}
        let mut dashpot = 0.0;
        let dashpots: Vec<f64> = (0..self.len())
            .map(|j| {
                dashpot = self.damping_n_s_per_m[(j, j)] - dashpot;
                dashpot
            })
            .collect();
        let scaled_difference =
            self.mass_normalised(&(neighbour_matrix(&dashpots) - &self.damping_n_s_per_m)).amax();
        let bound = MODAL_COUPLING * self.mass_normalised(&self.damping_n_s_per_m).amax();
        (scaled_difference <= bound && dashpots.iter().all(|c| *c >= 0.0)).then_some(dashpots)
    }

    fn mass_normalised(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(self.len(), self.len(), |i, j| {
            matrix[(i, j)] / (self.masses_kg[i].sqrt() * self.masses_kg[j].sqrt())
        })
    }
}

/// First component of a unit eigenvector of a tridiagonal matrix, to relative accuracy even where the mode
/// hardly moves mass 1.
///
/// The eigenvector is accurate where it is large; from there the rows of (J − λ)v = 0, eliminated from the
/// top, lead to mass 1.
fn first_component(jacobi: &DMatrix<f64>, eigenvalue: f64, vector: &DVector<f64>) -> f64 {
    let largest = vector.icamax();
    let mut component = vector[largest];
    let mut pivot = jacobi[(0, 0)] - eigenvalue;
    for j in 0..largest {
        let coupling = jacobi[(j, j + 1)];
        component *= -coupling / pivot;
        pivot = jacobi[(j + 1, j + 1)] - eigenvalue - coupling * coupling / pivot;
    }
    if component.is_finite() { component } else { vector[0] }
}

/// Matrix of elements between neighbours, the last to ground.
fn neighbour_matrix(elements: &[f64]) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(elements.len(), elements.len());
    for (j, element) in elements.iter().enumerate() {
        matrix[(j, j)] += element;
        if j + 1 < elements.len() {
            matrix[(j + 1, j + 1)] += element;
            matrix[(j, j + 1)] -= element;
            matrix[(j + 1, j)] -= element;
        }
    }
    matrix
}

fn check(list: &[f64], key: &str, allowed: fn(f64) -> bool, expected: &str) -> Result<()> {
    match list.iter().position(|x| !(x.is_finite() && allowed(*x))) {
        None => Ok(()),
        Some(j) => Err(Error::new(ErrorKind::OutOfRange)
            .key(key)
            .found(format!("{} in place {}", list[j], j + 1))
            .expected(expected)
            .remedy("a chain is made of positive masses and springs")),
    }
}

fn sorted_distinct(modes: &Modes) -> Result<Vec<Mode>> {
    let mut modes = modes.as_slice().to_vec();
    if modes.is_empty() {
        return Err(Error::new(ErrorKind::Missing)
            .key("modes")
            .found("no mode")
            .expected("at least one")
            .remedy("a rigid base needs no chain"));
    }
    modes.sort_by(|a, b| a.frequency_hz().total_cmp(&b.frequency_hz()));
    for pair in modes.windows(2) {
        let (low, high) = (pair[0].frequency_hz(), pair[1].frequency_hz());
        if high - low <= SMALLEST_SEPARATION * high {
            return Err(Error::new(ErrorKind::Inconsistent)
                .key("frequency_hz")
                .found(format!("two modes at {low} and {high} Hz"))
                .expected("distinct frequencies: a chain has no repeated one")
                .remedy("merge the two into one mode of mass 1/(1/M1 + 1/M2)"));
        }
    }
    Ok(modes)
}

/// A symmetric tridiagonal matrix with its Lanczos vectors (one column a row of the matrix).
struct Jacobi {
    diagonal: Vec<f64>,
    coupling: Vec<f64>,
    vectors: DMatrix<f64>,
}

impl Jacobi {
    /// From eigenvalues and the squared first components of the eigenvectors.
    fn from_spectrum(spectrum: &[f64], weights: &[f64]) -> Self {
        let size = spectrum.len();
        let spectrum = DVector::from_column_slice(spectrum);
        let mut vectors = DMatrix::zeros(size, size);
        let mut vector = DVector::from_iterator(size, weights.iter().map(|w| w.sqrt())).normalize();
        let (mut diagonal, mut coupling) = (Vec::with_capacity(size), Vec::with_capacity(size - 1));
        for j in 0..size {
            vectors.set_column(j, &vector);
            let mut next = spectrum.component_mul(&vector);
            diagonal.push(vector.dot(&next));
            // twice is enough to be orthogonal to rounding
            for _ in 0..2 {
                let known = vectors.columns(0, j + 1);
                let along = known.tr_mul(&next);
                next -= known * along;
            }
            if j + 1 < size {
                let length = next.norm();
                coupling.push(length);
                vector = next / length;
            }
        }
        Self { diagonal, coupling, vectors }
    }

    /// Masses and springs, the first mass given, the matrix being in units of `scale` (rad²/s²).
    fn masses_and_springs(&self, first_mass_kg: f64, scale: f64) -> Result<(Vec<f64>, Vec<f64>)> {
        let size = self.diagonal.len();
        let (mut masses, mut springs) = (Vec::with_capacity(size), Vec::with_capacity(size));
        let (mut mass, mut spring) = (first_mass_kg, 0.0);
        for j in 0..size {
            masses.push(mass);
            spring = self.diagonal[j] * mass - spring;
            springs.push(spring * scale);
            if let Some(coupling) = self.coupling.get(j) {
                mass = (spring / coupling).powi(2) / mass;
            }
        }
        let lost = |list: &[f64]| list.iter().any(|x| !(x.is_finite() && *x > 0.0));
        if lost(&masses) || lost(&springs) {
            return Err(Error::new(ErrorKind::Undetermined)
                .key("modes")
                .found("modes whose chain has a mass or spring too small for double precision")
                .expected("modes of comparable mass with separated frequencies")
                .remedy("merge or drop modes that hardly move, or use the modes themselves"));
        }
        Ok((masses, springs))
    }
}
