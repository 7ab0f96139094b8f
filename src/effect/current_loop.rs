//! Bandwidth of the current loop off its stated value.

use super::law::not_positive;
use super::prior::{Machinery, Prior};
use super::{Constants, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch, Unlike};
use crate::drive::motor::Circuit;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A current loop slower or faster than stated, or one where the twin has none.
///
/// # Model
/// ```text
///   τ·di/dt = k·u − i, τ = 1/(2π·f_c)
/// ```
/// Of a stated
/// [`CurrentLoop`](crate::drive::current_loop::CurrentLoop) the time constant changes; of a stated
/// [`Direct`](crate::drive::motor::Direct) effort, which follows at once, τ is new.
///
/// # Validity
/// Torque-controlled drives; the lag of a voltage-fed winding is its inductance. A lag much shorter than the sample period is
/// a delay of τ.
///
/// # Prior
/// f_c of 50 to 2000 Hz, log-uniform: a large motor on a slow bridge to a small one switched at 16 kHz. Leonhard, *Control of
/// Electrical Drives*, 3rd ed. (2001); data sheets of servo drives.
///
/// # Source
/// Leonhard, *Control of Electrical Drives*, 3rd ed. (2001): the closed current loop as a first-order lag.
///
/// ```
/// use slideway::drive::motor::Circuit;
/// use slideway::effect::CurrentLoop;
/// let slow = CurrentLoop { bandwidth_hz: 1.0 / std::f64::consts::TAU };
/// let Circuit::Winding { resistance_ohm, inductance_h, force_constant, .. } =
///     slow.slowed(Circuit::Direct { force_per_volt: 40.0 })
/// else {
///     panic!("a lag has a state");
/// };
/// assert!((inductance_h / resistance_ohm - 1.0).abs() < 1e-12);
/// assert_eq!(force_constant / resistance_ohm, 40.0);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurrentLoop {
    /// f_c in Hz; more than zero.
    pub bandwidth_hz: f64,
}

impl CurrentLoop {
    /// The circuit with this lag.
    pub fn slowed(&self, circuit: Circuit) -> Circuit {
        let tau_s = 1.0 / (TAU * self.bandwidth_hz);
        match circuit {
            Circuit::Winding { resistance_ohm, force_constant, back_emf, .. } => Circuit::Winding {
                resistance_ohm,
                inductance_h: tau_s * resistance_ohm,
                force_constant,
                back_emf,
            },
            Circuit::Direct { force_per_volt } => Circuit::Winding {
                resistance_ohm: 1.0,
                inductance_h: tau_s,
                force_constant: force_per_volt,
                back_emf: 0.0,
            },
        }
    }
}

impl Law for CurrentLoop {
    const SITE: Site = Site::Amplifier;
    const PHRASE: &'static str = "a current loop slower or faster than stated";
    const PARAMETERS: &'static [Parameter] = &[Parameter::same("bandwidth_hz", "Hz").positive()];

    fn fault(&self) -> Option<String> {
        not_positive("bandwidth_hz", self.bandwidth_hz)
    }

    fn alter(&self, constants: &mut Constants) {
        constants.circuit = self.slowed(constants.circuit);
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        match constants.circuit {
            Circuit::Winding { resistance_ohm, inductance_h, .. } => {
                vec![resistance_ohm / (TAU * inductance_h)]
            }
            Circuit::Direct { .. } => vec![f64::INFINITY],
        }
    }

    const STRETCH: Stretch = Stretch::Drive;

    fn lacks(constants: &Constants) -> Option<Lack> {
        constants.has_voltage_fed_winding.then_some(Lack::NothingToChange)
    }

    const EQUATION: &'static str = "τ·di/dt = k·u − i, τ = 1/(2π·f_c)";
    const SYMBOLS: &'static [&'static str] = &["f_c"];
    const SOURCE: &'static str = "Leonhard, Control of Electrical Drives, 3rd ed. (2001): the closed current loop as a first-order lag";
    const SHOWN_BY: &'static str =
        "Current or force that lags its command: fast changes of the effort, current logged.";
    const EXAMPLE: &'static [f64] = &[200.0];
    const CONFUSABLE: &'static [Likeness] =
        &[Likeness::similar(EffectId::LoopDelay, "where nothing moves as fast as the loop")];

    fn draw(_machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        vec![prior.log_uniform(50.0, 2000.0)]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
