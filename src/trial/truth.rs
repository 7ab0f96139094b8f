//! The truth of a trial: what was hidden in each case.

use super::engine::Engine;
use super::laws::Otherwise;
use super::nominal::NominalErrors;
use super::real::Known;
use super::runs::TrialRun;
use super::tier::Tier;
use crate::effect::{EffectId, Site};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Schema of the truth file.
pub const SCHEMA: &str = "slideway-truth/2";

/// What was hidden in all cases.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// `slideway-truth/2`.
    pub schema: String,
    /// Seed of the trial.
    pub seed: u64,
    /// What makes the hash more than a hash of guesses.
    pub nonce: String,
    /// Name of the machine.
    pub machine: String,
    /// Engine that the recordings were simulated on.
    pub engine: Engine,
    /// The cases, in their order.
    pub cases: Vec<TrueCase>,
}

/// What was hidden in one case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrueCase {
    /// Its number, from 1.
    pub case: usize,
    /// Its tier.
    pub tier: Tier,
    /// Every effect by which the machine differs from the twin that is diagnosed; in the tier of changes, from the machine before.
    pub effects: Vec<HiddenEffect>,
    /// What the twin that is diagnosed states beyond the machine's file, as it really is: friction of the guide.
    pub stated: Vec<Known>,
    /// The settings by which it states that, within its tolerance.
    pub twin: BTreeMap<String, f64>,
    /// In the tier of changes, the effects that machine and twin differ by before and after alike; none elsewhere.
    pub before: Vec<HiddenEffect>,
    /// By how much the nominal parameters were off.
    pub nominal: NominalErrors,
    /// What the forged machine had that no law of the catalogue describes.
    pub otherwise: Otherwise,
    /// The runs.
    pub runs: Vec<TrialRun>,
    /// Effects struck from the catalogue.
    pub struck: Vec<EffectId>,
    /// Canonical names of the signals that were not logged.
    pub missing: Vec<String>,
    /// What everything hidden makes together beyond calibration, in standard deviations of the noise; see [`HiddenEffect::gap`].
    pub gap: f64,
    /// Longest step of the plant that simulated it in s.
    pub step_s: f64,
    /// Error of the simulation itself against half its step, RMS, in standard deviations of the noise over √N; see
    /// [`converged`](super::convergence::converged).
    pub integration_error: f64,
}

/// One hidden effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HiddenEffect {
    /// Which one.
    pub effect: EffectId,
    /// Its parameters, by their key; a payload comes on top of what the nominal mass is off by.
    pub parameters: BTreeMap<String, f64>,
    /// Whether the tier asked for it. Else it comes with another one, as friction and its bristles do, or is a nuisance.
    pub planned: bool,
    /// What it makes beside everything else that is hidden, beyond what constants inside their tolerances make up for: RMS over
    /// signals and samples in standard deviations of the noise, of training or held-out runs, whichever show less.
    pub gap: f64,
    /// Effects that do the same on these runs, as far as their noise can tell; see [`Equals`](super::information::Equals).
    pub equals: Vec<EffectId>,
}

impl HiddenEffect {
    /// Whether a name is the effect's or an equal's.
    pub fn is_called(&self, name: &str) -> bool {
        self.effect.name() == name || self.equals.iter().any(|equal| equal.name() == name)
    }

    /// Whether a site is the effect's or an equal's.
    pub fn is_at(&self, site: &str) -> bool {
        let sites = super::equals::sites(self.effect, &self.equals);
        sites.iter().any(|s: &Site| s.name() == site)
    }
}
