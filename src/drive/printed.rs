//! The sampled linear motor in the form the grinding-machine paper prints it, and with its sign put right.
//!
//! Only to regenerate printed transfer functions. A replay does not use these: it propagates the winding
//! exactly.

use serde::{Deserialize, Serialize};

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
