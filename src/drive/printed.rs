//! The sampled linear motor and the control law as a paper prints them, and with their signs put right.
//!
//! Only to regenerate printed transfer functions. A replay does not use these: it propagates the winding
//! exactly.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::controller::Pdf;
use crate::error::{Error, ErrorKind, Result};
use crate::identify::transfer::TransferFunction;

/// Which form of the sampled motor is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Variant {
    /// As eq. (7) is printed, with the resistance subtracted: its pole lies outside the unit circle.
    AsPrinted,
    /// With the resistance added, as backward Euler of the winding equation gives it.
    #[default]
    Corrected,
}

/// The linear motor from voltage (V) to force (N), sampled at T.
///
/// # Model
/// Winding `L·di/dt + R·i = u`, force `F = Kt·i`, no back-EMF. Backward Euler, `s = (1 − z⁻¹)/T`:
/// ```text
/// corrected   L(z) = Kt·T·z / ((L + R·T)·z − L)      pole L/(L + R·T) < 1
/// as printed  L(z) = Kt·T·z / ((L − R·T)·z − L)      pole L/(L − R·T), > 1 while R·T < L
/// ```
///
/// # Validity
/// R·T much smaller than L: the first-order pole of [`zero_order_hold_pole`] is the exact one.
///
/// # Source
/// Liu, Lai, Yen, grinding-machine controller identification, eq. (7) (the sign of R·T is a misprint there).
///
/// # Errors
/// A parameter that is not finite and > 0; as printed, also R·T = L, where the printed form has no value.
pub fn motor(
    variant: Variant,
    resistance_ohm: f64,
    inductance_h: f64,
    force_constant_n_per_a: f64,
    sample_period_s: f64,
) -> Result<TransferFunction> {
    positive("resistance_ohm", resistance_ohm)?;
    positive("inductance_h", inductance_h)?;
    positive("force_constant_n_per_a", force_constant_n_per_a)?;
    positive("sample_period_s", sample_period_s)?;
    let lead = match variant {
        Variant::AsPrinted => inductance_h - resistance_ohm * sample_period_s,
        Variant::Corrected => inductance_h + resistance_ohm * sample_period_s,
    };
    if lead == 0.0 {
        return Err(Error::new(ErrorKind::Undetermined)
            .key("sample_period_s")
            .found(format!("{sample_period_s} s, for which the resistance times it equals the inductance"))
            .expected("a sample period other than inductance / resistance")
            .remedy("use the corrected form, or a shorter sample period"));
    }
    let gain = force_constant_n_per_a * sample_period_s / lead;
    TransferFunction::new(vec![gain], vec![1.0, -inductance_h / lead], sample_period_s)
}

/// The plant P*(z) = W(z)·L(z) of eq. (11): motor in series with the worktable's identified W(z).
///
/// The product is formed at W's sample period. The paper multiplies W(z) with a motor sampled at the
/// controller's period as if both had been sampled alike; state W at that period to regenerate the printed
/// numbers.
///
/// # Errors
/// As [`motor`].
pub fn plant(
    variant: Variant,
    worktable: &TransferFunction,
    resistance_ohm: f64,
    inductance_h: f64,
    force_constant_n_per_a: f64,
) -> Result<TransferFunction> {
    let period = worktable.sample_period_s();
    worktable.multiply(&motor(variant, resistance_ohm, inductance_h, force_constant_n_per_a, period)?)
}

/// The exact pole of the winding whose voltage is held over each sample: exp(−R·T/L).
///
/// # Errors
/// A parameter that is not finite and > 0.
pub fn zero_order_hold_pole(resistance_ohm: f64, inductance_h: f64, sample_period_s: f64) -> Result<f64> {
    positive("resistance_ohm", resistance_ohm)?;
    positive("inductance_h", inductance_h)?;
    positive("sample_period_s", sample_period_s)?;
    Ok((-resistance_ohm * sample_period_s / inductance_h).exp())
}

fn positive(key: &str, value: f64) -> Result<()> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    let kind = if value.is_finite() { ErrorKind::OutOfRange } else { ErrorKind::NotFinite };
    Err(Error::new(kind)
        .key(key)
        .found(value.to_string())
        .expected("a finite number > 0")
        .remedy("take it from the motor's data sheet"))
}

/// The control effort of a pseudo-derivative-feedback law with its gains per count k1, k2 left open, eq. (8).
///
/// # Model
/// ```text
/// as printed  u(k) = n_i·T·k1·e(k) + u1(k−1) + n_p·k2·y(k)       feeds the velocity y back positively
/// corrected   u(k) = n_i·T·k1·e(k) + u1(k−1) − n_p·k2·y(k)
/// ```
///
/// # Source
/// Liu, Lai, Yen, eq. (8).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlEffort {
    /// n_i·T, what multiplies k1·e(k).
    pub integral: f64,
    /// ± n_p, what multiplies k2·y(k).
    pub proportional: f64,
}

impl ControlEffort {
    /// Of a law sampled at `period_s`.
    pub fn of(variant: Variant, law: &Pdf, period_s: f64) -> Self {
        let register = f64::from(law.proportional.value());
        let proportional = match variant {
            Variant::AsPrinted => register,
            Variant::Corrected => -register,
        };
        Self { integral: f64::from(law.integral.value()) * period_s, proportional }
    }

    /// Whether the velocity is fed back against its own direction, for positive k2.
    pub fn feeds_back_negatively(&self) -> bool {
        self.proportional < 0.0
    }
}

impl fmt::Display for ControlEffort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.proportional < 0.0 { '-' } else { '+' };
        write!(f, "{:.2e} k1 e(k) + u1(k-1) {sign} {} k2 y(k)", self.integral, self.proportional.abs())
    }
}

/// A transfer function with its coefficients rounded to so many decimals, as a paper prints it and computes on with it.
///
/// # Errors
/// Coefficients that round to a function that is none.
pub fn rounded(function: &TransferFunction, decimals: i32) -> Result<TransferFunction> {
    let scale = 10f64.powi(decimals);
    let round = |coefficients: &[f64]| coefficients.iter().map(|c| (c * scale).round() / scale).collect();
    TransferFunction::new(
        round(function.numerator()),
        round(function.denominator()),
        function.sample_period_s(),
    )
}
