//! Smoothing of the velocity estimate off its stated value.

use super::law::negative;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use serde::{Deserialize, Serialize};

/// A filter in the velocity estimate that is not the stated one.
///
/// # Model
/// First-order smoothing with time constant τ, in the place of the stated one: `v ← v + T/(T+τ)·(estimate − v)`.
///
/// # Validity
/// τ ≥ 0; a filter of higher order looks like this one up to its bandwidth.
///
/// # Prior
/// τ of 0.1 to 4 sample periods, log-uniform, in the place of the stated one: what a drive offers against the ripple of a
/// differentiated encoder. Manuals of servo drives; Ellis (2012), *Control System Design Guide*, 4th ed.
///
/// # Source
/// [`VelocityEstimate`](crate::sensor::VelocityEstimate).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VelocityFilter {
    /// τ in s; not negative.
    pub time_constant_s: f64,
}

impl Law for VelocityFilter {
    const SITE: Site = Site::Sensor;
    const PHRASE: &'static str = "a velocity filter off its stated value";
    const PARAMETERS: &'static [Parameter] = &[Parameter::same("time_constant_s", "s").not_negative()];

    fn fault(&self) -> Option<String> {
        negative("time_constant_s", self.time_constant_s)
    }

    fn alter(&self, constants: &mut Constants) {
        constants.velocity.set_time_constant_s(self.time_constant_s);
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        vec![constants.velocity.time_constant_s()]
    }

    const STRETCH: Stretch = Stretch::VelocityEstimate;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "v ← v + T/(T+τ)·(estimate − v)";
    const SYMBOLS: &'static [&'static str] = &["τ"];
    const SOURCE: &'static str = "the velocity estimate that the machine file states";
    const SHOWN_BY: &'static str = "Control effort behind the velocity, or a logged velocity behind the position: starts, stops, reversals.";
    const EXAMPLE: &'static [f64] = &[2e-3];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        vec![prior.log_uniform(0.1, 4.0) * machine.constants.sample_period_s]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
