//! Motion of the base under a force that is held over each step.

use super::modes::{Mode, Modes};
use crate::error::{Error, ErrorKind, Result};

/// One mode over one step: η(h) = φ₁₁η + φ₁₂η̇ + γ₁F, η̇(h) = φ₂₁η + φ₂₂η̇ + γ₂F.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Propagator {
    position_by_position: f64,
    position_by_velocity: f64,
    position_by_force: f64,
    velocity_by_position: f64,
    velocity_by_velocity: f64,
    velocity_by_force: f64,
}

/// Exact motion of the base's modes from step to step, the force on the base held over each.
///
/// # Model
/// Each mode M(η̈ + 2ζω η̇ + ω²η) = F with σ = ζω, ω_d = ω√(1−ζ²), E = exp(−σh), C = cos ω_d h, S = sin(ω_d
/// h)/ω_d:
/// ```text
/// ⎡η⎤        ⎡ C + σS    S    ⎤ ⎡η⎤       ⎡ (1 − E(C + σS))/ω² ⎤ F
/// ⎢ ⎥(h) = E ⎢                ⎥ ⎢ ⎥(0) +  ⎢                    ⎥ ─
/// ⎣η̇⎦        ⎣  −ω²S   C − σS ⎦ ⎣η̇⎦       ⎣         E·S        ⎦ M
/// ```
/// State: η₁, η̇₁, η₂, η̇₂, … in m and m/s. Displacement of the base Σ ηᵢ, positive along the joint's
/// positive axis; the force is that on the base, the negative of the force on the table.
///
/// # Validity
/// Exact for a force held constant over the step, whatever its length.
///
/// ```
/// use slideway::base::{modes::{Mode, Modes}, motion::BaseMotion};
/// let modes = Modes::new(vec![Mode::new(86.1, 1500.0, 0.02)?]);
/// let motion = BaseMotion::new(&modes, 0.25e-3)?;
/// let mut state = vec![0.0; motion.state_len()];
/// for _ in 0..40_000 { motion.advance(&mut state, 200.0); }
/// let settled = 200.0 * modes.static_compliance_m_per_n();
/// assert!((motion.displacement(&state) / settled - 1.0).abs() < 1e-9);
/// # Ok::<(), slideway::error::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct BaseMotion {
    propagators: Vec<Propagator>,
    displacement_per_force: f64,
    velocity_per_force: f64,
}

impl BaseMotion {
    /// For steps of `dt_s`.
    ///
    /// # Errors
    /// A step that is not finite and > 0.
    pub fn new(modes: &Modes, dt_s: f64) -> Result<Self> {
        if !(dt_s.is_finite() && dt_s > 0.0) {
            return Err(Error::new(ErrorKind::OutOfRange)
                .key("dt_s")
                .found(dt_s.to_string())
                .expected("a finite number of seconds > 0")
                .remedy("step the base by the plant's step"));
        }
        let propagators: Vec<_> = modes.as_slice().iter().map(|mode| Propagator::new(mode, dt_s)).collect();
        let displacement_per_force = propagators.iter().map(|p| p.position_by_force).sum();
        let velocity_per_force = propagators.iter().map(|p| p.velocity_by_force).sum();
        Ok(Self { propagators, displacement_per_force, velocity_per_force })
    }

    /// Length of the state slice: two numbers a mode.
    pub fn state_len(&self) -> usize {
        2 * self.propagators.len()
    }

    /// Advances the state by one step under the force on the base, N.
    pub fn advance(&self, state: &mut [f64], force_n: f64) {
        debug_assert_eq!(state.len(), self.state_len());
        for (p, mode) in self.propagators.iter().zip(state.chunks_exact_mut(2)) {
            let (position, velocity) = (mode[0], mode[1]);
            mode[0] = p.position_by_position * position
                + p.position_by_velocity * velocity
                + p.position_by_force * force_n;
            mode[1] = p.velocity_by_position * position
                + p.velocity_by_velocity * velocity
                + p.velocity_by_force * force_n;
        }
    }

    /// Velocity of the base one step on if no force acted, m/s; add force ×
    /// [`velocity_per_force`](Self::velocity_per_force) for the velocity under a force that is still to be
    /// found.
    pub fn free_velocity(&self, state: &[f64]) -> f64 {
        let modes = self.propagators.iter().zip(state.chunks_exact(2));
        modes.map(|(p, mode)| p.velocity_by_position * mode[0] + p.velocity_by_velocity * mode[1]).sum()
    }

    /// Displacement of the base one step on if no force acted, m.
    pub fn free_displacement(&self, state: &[f64]) -> f64 {
        let modes = self.propagators.iter().zip(state.chunks_exact(2));
        modes.map(|(p, mode)| p.position_by_position * mode[0] + p.position_by_velocity * mode[1]).sum()
    }

    /// Displacement one step on per force held over it, m/N.
    pub fn displacement_per_force(&self) -> f64 {
        self.displacement_per_force
    }

    /// Velocity one step on per force held over it, m/(s·N).
    pub fn velocity_per_force(&self) -> f64 {
        self.velocity_per_force
    }

    /// Displacement of the base, m.
    pub fn displacement(&self, state: &[f64]) -> f64 {
        state.iter().step_by(2).sum()
    }

    /// Velocity of the base, m/s.
    pub fn velocity(&self, state: &[f64]) -> f64 {
        state.iter().skip(1).step_by(2).sum()
    }
}

impl Propagator {
    fn new(mode: &Mode, h: f64) -> Self {
        let (omega, zeta, mass) = (mode.angular_frequency_rad_per_s(), mode.damping_ratio(), mode.mass_kg());
        let sigma = zeta * omega;
        let damped = omega * ((1.0 - zeta) * (1.0 + zeta)).sqrt();
        let decay = (-sigma * h).exp();
        let (c, s) = ((damped * h).cos(), (damped * h).sin() / damped);
        // 1 − E(C + σS) without taking two numbers near 1 apart
        let half = (0.5 * damped * h).sin();
        let risen = 2.0 * decay * half * half - (-sigma * h).exp_m1() - decay * sigma * s;
        Self {
            position_by_position: decay * (c + sigma * s),
            position_by_velocity: decay * s,
            position_by_force: risen / (mass * omega * omega),
            velocity_by_position: -decay * omega * omega * s,
            velocity_by_velocity: decay * (c - sigma * s),
            velocity_by_force: decay * s / mass,
        }
    }
}
