//! A voltage at zero command.

use super::law::infinite;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use serde::{Deserialize, Serialize};

/// Offset of the amplifier: the voltage that it applies at zero command.
///
/// # Model
/// `u_applied = u + u_0`; u_0 comes on top of a stated offset.
///
/// # Validity
/// Constant over a run. Where neither current nor thrust is logged, or the motor is a direct one, it is exactly a
/// constant force `−u_0·Kt/R`: no data tell the two apart.
///
/// # Prior
/// u_0 of 0.1 to 2 % of the effort's full scale, log-uniform, either sign: 10 to 200 mV of a ±10 V input before it is trimmed.
/// Data sheets of analogue servo amplifiers; Horowitz, Hill (2015), *The Art of Electronics*, 3rd ed., on offset and its drift.
///
/// # Source
/// Offset of any analogue amplifier or converter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AmplifierOffset {
    /// u_0 in V.
    pub offset_v: f64,
}

impl Law for AmplifierOffset {
    const SITE: Site = Site::Amplifier;
    const PHRASE: &'static str = "an offset of the amplifier";
    const PARAMETERS: &'static [Parameter] = &[Parameter::same("offset_v", "V")];
    // Amplifiers are trimmed; weight and cables are not.
    const RARITY: f64 = 1.5;

    fn fault(&self) -> Option<String> {
        infinite("offset_v", self.offset_v)
    }

    fn alter(&self, constants: &mut Constants) {
        constants.amplifier.offset_v += self.offset_v;
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![0.0]
    }

    const STRETCH: Stretch = Stretch::Drive;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "u_applied = u + u_0";
    const SYMBOLS: &'static [&'static str] = &["u_0"];
    const SOURCE: &'static str = "offset of any analogue amplifier or converter";
    const SHOWN_BY: &'static str = "Control effort that differs by a constant from what current or motor force take, in any motion and at standstill.";
    const EXAMPLE: &'static [f64] = &[0.1];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        vec![prior.sign() * prior.log_uniform(0.001, 0.02) * machine.voltage_v]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
