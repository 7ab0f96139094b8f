//! Resonance modes of the machine base at the point where the motors push.

use std::f64::consts::TAU;

use nalgebra::Complex;
use serde::{Deserialize, Serialize};

use crate::error::{Error, ErrorKind, Result};
use crate::units::{SMALLEST, largest};

/// One resonance of the base: natural frequency, modal mass and damping ratio.
///
/// # Model
/// M·(η̈ + 2ζω·η̇ + ω²·η) = F, ω = 2π·`frequency_hz`. The modal mass M is normalised to the motors' reaction
/// point: F acts there, and the point moves by η.
///
/// # Validity
/// Small, linear vibration. `frequency_hz` is the undamped natural frequency; 0 ≤ ζ < 1.
///
/// ```
/// use slideway::base::modes::Mode;
/// assert!(Mode::new(86.1, 1500.0, 0.02).is_ok());
/// assert_eq!(Mode::new(86.1, -1.0, 0.02).unwrap_err().key_name(), Some("mass_kg"));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(try_from = "UncheckedMode")]
pub struct Mode {
    frequency_hz: f64,
    mass_kg: f64,
    damping_ratio: f64,
}

#[derive(Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct UncheckedMode {
    frequency_hz: f64,
    mass_kg: f64,
    damping_ratio: f64,
}

/// Modal mass at most, in kg: a mode that the reaction point hardly takes part in is heavier than any machine.
const HEAVIEST_KG: f64 = 1e30;

impl TryFrom<UncheckedMode> for Mode {
    type Error = Error;

    fn try_from(mode: UncheckedMode) -> Result<Self> {
        Self::new(mode.frequency_hz, mode.mass_kg, mode.damping_ratio)
    }
}

impl Mode {
    /// From natural frequency, modal mass at the reaction point, and damping ratio.
    ///
    /// # Errors
    /// A number that is not finite; frequency or mass not > 0; a damping ratio outside 0 ≤ ζ < 1.
    pub fn new(frequency_hz: f64, mass_kg: f64, damping_ratio: f64) -> Result<Self> {
        let frequency = ("frequency_hz", frequency_hz, "Hz", largest("frequency_hz"));
        for (key, value, what, most) in [frequency, ("mass_kg", mass_kg, "kg", HEAVIEST_KG)] {
            if !(SMALLEST..=most).contains(&value) {
                let expected = format!("a finite number of {what} > 0, at most {most:e}");
                return Err(out_of_range(key, value, &expected));
            }
        }
        if !(0.0..1.0).contains(&damping_ratio) {
            return Err(out_of_range("damping_ratio", damping_ratio, "a number from 0 up to, but not, 1"));
        }
        Ok(Self { frequency_hz, mass_kg, damping_ratio })
    }

    /// Undamped natural frequency, Hz.
    pub fn frequency_hz(&self) -> f64 {
        self.frequency_hz
    }

    /// Modal mass at the motors' reaction point, kg.
    pub fn mass_kg(&self) -> f64 {
        self.mass_kg
    }

    /// Fraction ζ of critical damping.
    pub fn damping_ratio(&self) -> f64 {
        self.damping_ratio
    }

    /// ω = 2π·`frequency_hz`, rad/s.
    pub fn angular_frequency_rad_per_s(&self) -> f64 {
        TAU * self.frequency_hz
    }

    /// M·ω², N/m.
    pub fn stiffness_n_per_m(&self) -> f64 {
        self.mass_kg * self.angular_frequency_rad_per_s().powi(2)
    }

    /// η/F at `frequency_hz`, m/N.
    fn receptance(&self, frequency_hz: f64) -> Complex<f64> {
        let natural = self.angular_frequency_rad_per_s();
        let omega = TAU * frequency_hz;
        // (ω₀ − ω)(ω₀ + ω) keeps its digits next to the resonance
        let dynamic =
            Complex::new((natural - omega) * (natural + omega), 2.0 * self.damping_ratio * natural * omega);
        (dynamic * self.mass_kg).inv()
    }
}

fn out_of_range(key: &str, value: f64, expected: &str) -> Error {
    let kind = if value.is_finite() { ErrorKind::OutOfRange } else { ErrorKind::NotFinite };
    Error::new(kind)
        .key(key)
        .found(value.to_string())
        .expected(expected)
        .remedy("give each base mode its natural frequency, modal mass and damping ratio")
}

/// The modes of the base; none means a rigid base.
///
/// # Model
/// The reaction point moves by x = Σ ηᵢ, each mode driven by the same force on the base.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Modes(Vec<Mode>);

impl Modes {
    /// From single modes, in any order.
    pub fn new(modes: Vec<Mode>) -> Self {
        Self(modes)
    }

    /// The modes, in the order given.
    pub fn as_slice(&self) -> &[Mode] {
        &self.0
    }

    /// Number of modes.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether the base is rigid.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Receptance at the reaction point: displacement over force on the base, m/N, Σ 1/(Mᵢ(ωᵢ² − ω² +
    /// 2iζᵢωᵢω)).
    ///
    /// Not finite exactly at the frequency of a mode without damping.
    pub fn drive_point_response(&self, frequency_hz: f64) -> Complex<f64> {
        self.0.iter().map(|mode| mode.receptance(frequency_hz)).sum()
    }

    /// Displacement per constant force, m/N: Σ 1/(Mᵢωᵢ²).
    pub fn static_compliance_m_per_n(&self) -> f64 {
        self.0.iter().map(|mode| mode.stiffness_n_per_m().recip()).sum()
    }
}
