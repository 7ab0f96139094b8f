//! Scale of a logged current or effort off its stated value.

use super::law::not_positive;
use super::prior::{Machinery, Prior};
use super::{Constants, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch, Unlike};
use crate::recording::Signal;
use crate::sensor::LogScale;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// A logged current or control effort whose unit is not the stated one: per cent taken for ampere, peak for RMS, a gain of the
/// analogue output.
///
/// # Model
/// ```text
///   current as logged = f_i·i        effort as logged = f_u·u
/// ```
/// The machine itself does what it does: only the log is wrong.
///
/// # Validity
/// Signals that were logged; the factor of one that was not stays 1. Where a current drives the replay, its factor f_i is
/// exactly a force constant off by 1/f_i: only a logged force or effort tells them apart.
///
/// # Prior
/// Two times in three the current is wrong, else the effort; the other one's factor is 1. Of the current: √2 or 1/√2 (peak and
/// RMS), 2 or 1/2 (a range, a factor of two between amplitude and span), or with probability one fifth a gain within ±10 %,
/// uniform. Of the effort: 2, 1/2, or with probability one third such a gain. Manuals of servo drives and of current probes,
/// which scale by range, RMS and peak.
///
/// # Source
/// Unit conversion; RMS and peak of a phase current differ by √2.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SensorScale {
    /// f_i, more than zero.
    #[serde(default = "one")]
    pub current: f64,
    /// f_u, more than zero.
    #[serde(default = "one")]
    pub effort: f64,
}

fn one() -> f64 {
    1.0
}

impl Law for SensorScale {
    const SITE: Site = Site::Sensor;
    const PHRASE: &'static str = "a logged signal in the wrong scale";
    const PARAMETERS: &'static [Parameter] =
        &[Parameter::same("current", "1").positive(), Parameter::same("effort", "1").positive()];

    fn fault(&self) -> Option<String> {
        not_positive("current", self.current).or_else(|| not_positive("effort", self.effort))
    }

    fn alter(&self, constants: &mut Constants) {
        constants.log_scale = LogScale { current: self.current, effort: self.effort };
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        vec![constants.log_scale.current, constants.log_scale.effort]
    }

    const STRETCH: Stretch = Stretch::Log;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "current as logged = f_i·i        effort as logged = f_u·u";
    const SYMBOLS: &'static [&'static str] = &["f_i", "f_u"];
    const SOURCE: &'static str = "unit conversion; RMS and peak of a phase current differ by √2";
    const SHOWN_BY: &'static str =
        "Current and effort that do not belong together, while the motion does what it should: log both.";
    const EXAMPLE: &'static [f64] = &[0.5, 1.0];
    const CONFUSABLE: &'static [Likeness] = &[Likeness::equal(
        EffectId::ForceConstant,
        "where a logged current drives the replay",
        |constants, logged| {
            let unseen = [Signal::ControlEffort, Signal::Thrust].iter().all(|s| !logged.contains(s));
            constants.controller.is_none() && logged.contains(&Signal::Current) && unseen
        },
    )];

    fn draw(_machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        if prior.chance(2.0 / 3.0) {
            let gain = prior.uniform(0.9, 1.1);
            vec![prior.one_of(&[SQRT_2, FRAC_1_SQRT_2, 2.0, 0.5, gain]), 1.0]
        } else {
            let gain = prior.uniform(0.9, 1.1);
            vec![1.0, prior.one_of(&[2.0, 0.5, gain])]
        }
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
