//! The verdict and its machine-readable form, schema `slideway-diagnosis/1`.

pub use super::cause::{Cause, Harmonic};
use super::check::Finding;
pub use super::decide::{Limits, Verdict};
pub use super::grounds::{Veto, Withheld};
pub use super::parameter::Parameter;
pub use super::phase::RunPhase;
pub use super::place::{Band, Share, Where};

use super::decide::above_noise;
use super::identifiability::Identifiability;
use super::json;
use super::next_experiment::NextExperiment;
use super::noise::Source;
use super::prove::RigidBody;
use super::residual_whiteness::ResidualWhiteness;
use super::shape::Shape;
use super::thresholds::{ADEQUATE_GAP, LARGELY};
pub use super::training_gap::{Stretch, TrainingGap};
use super::untested::Untested;
use super::visibility::NotExamined;
use crate::recording::{Cut, Samples};
use serde::{Deserialize, Serialize};

/// Probability that one effect of the catalogue acts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectProbability {
    /// Effect id.
    pub effect: String,
    /// Posterior probability.
    pub probability: f64,
}

/// One explanation of the ranking.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ranked {
    /// Its effects; empty: the twin as it is, calibrated.
    pub effects: Vec<String>,
    /// Posterior probability.
    #[serde(deserialize_with = "json::number")]
    pub probability: f64,
    /// Gap G on the held-out runs.
    #[serde(deserialize_with = "json::number")]
    pub held_out_gap: f64,
}

/// A stated constant moved inside its tolerance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Key path.
    pub path: String,
    /// Estimate and interval.
    #[serde(flatten)]
    pub parameter: Parameter,
    /// Whether it went to the edge of its tolerance.
    pub at_tolerance: bool,
}

/// One signal on the held-out runs, before and after, in SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SignalGap {
    /// Canonical name.
    pub signal: String,
    /// RMS of recorded less predicted, twin as it is.
    #[serde(deserialize_with = "json::number")]
    pub rms_before: f64,
    /// The same with the causes added.
    #[serde(deserialize_with = "json::number")]
    pub rms_after: f64,
    /// Noise σ.
    #[serde(deserialize_with = "json::number")]
    pub noise: f64,
    /// Where the noise σ comes from.
    pub noise_source: Source,
    /// Mean absolute residual before.
    #[serde(deserialize_with = "json::number")]
    pub mae_before: f64,
    /// Mean absolute residual after.
    #[serde(deserialize_with = "json::number")]
    pub mae_after: f64,
    /// Largest absolute residual before.
    #[serde(deserialize_with = "json::number")]
    pub peak_before: f64,
    /// Largest absolute residual after.
    #[serde(deserialize_with = "json::number")]
    pub peak_after: f64,
    /// Coefficient of determination before.
    #[serde(deserialize_with = "json::number")]
    pub r2_before: f64,
    /// Coefficient of determination after.
    #[serde(deserialize_with = "json::number")]
    pub r2_after: f64,
}

/// A number of a cause where training and held-out runs together have it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Updated {
    /// Key path.
    pub path: String,
    /// Value of the fit, which has the training runs alone.
    #[serde(deserialize_with = "json::number")]
    pub fitted: f64,
    /// Value with the held-out runs.
    #[serde(deserialize_with = "json::number")]
    pub updated: f64,
    /// By how many standard errors of the fit it moves.
    #[serde(deserialize_with = "json::number")]
    pub standard_errors: f64,
    /// Unit.
    pub unit: String,
}

/// How large the gap is and how far it shrinks.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Gap {
    /// G of the twin as it is, in units of noise.
    #[serde(default, deserialize_with = "json::number")]
    pub before: f64,
    /// G with the causes added.
    #[serde(default, deserialize_with = "json::number")]
    pub after: f64,
    /// G that noise alone leaves: 1.
    #[serde(default, deserialize_with = "json::number")]
    pub floor: f64,
    /// G with the causes added and their numbers where training and held-out runs together have them (posterior predictive): by this the verdict is
    /// decided. Where it is far less than `after`, the training runs leave numbers uncertain.
    #[serde(default, deserialize_with = "json::number")]
    pub after_predictive: f64,
    /// Numbers of the causes that the held-out runs move by a standard error or more.
    #[serde(default)]
    pub updated: Vec<Updated>,
    /// 1 − (after² − 1)/(before² − 1).
    #[serde(default, deserialize_with = "json::number")]
    pub closed: f64,
    /// Its 95 % interval.
    #[serde(default, deserialize_with = "json::interval")]
    pub closed_ci95: [f64; 2],
    /// The smaller of 1 − (`after_predictive`² − 1)/(`before`² − 1) and the same with what calibration alone leaves in the place of `before`: what is to
    /// the causes' credit.
    #[serde(default, deserialize_with = "json::number")]
    pub closed_beside_calibration: f64,
    /// Whether the noise of every signal was seen in the recording: in repeats, or at standstill as at least a third of what is
    /// stated. A multiple of it is then known as such.
    #[serde(default)]
    pub noise_is_measured: bool,
    /// What cross-validation inside the training runs predicted.
    #[serde(default, deserialize_with = "json::number")]
    pub predicted_closed: f64,
    /// The same in the rigid-body scene; none without causes, and where the scene cannot be built.
    #[serde(default)]
    pub rigid_body: Option<RigidBody>,
    /// What the explanation leaves of the training runs.
    #[serde(default)]
    pub training: TrainingGap,
    /// Signal by signal.
    #[serde(default)]
    pub signals: Vec<SignalGap>,
    /// Signals that the causes do not explain, though all together leave little; without causes, signals that leave more than noise, though all together leave no
    /// more. For these the verdict is `unknown`.
    #[serde(default)]
    pub unexplained_signals: Vec<OpenSignal>,
}

/// A signal that is not explained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OpenSignal {
    /// Its key, with unit.
    pub signal: String,
    /// Share of the power of its gap that stays open, of the twin as it is or calibrated, whichever leaves less in all; more than 1 where it grew.
    #[serde(deserialize_with = "json::number")]
    pub open: f64,
}

/// Position reference less measured position, in m or rad.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FollowingError {
    /// Root mean square.
    pub rms: f64,
    /// Largest magnitude.
    pub peak: f64,
}

impl FollowingError {
    /// Over all samples of some pairs of reference and position; none without one.
    pub fn of(pairs: impl IntoIterator<Item = (f64, f64)>) -> Option<Self> {
        let (mut count, mut squares, mut peak) = (0_usize, 0.0, 0.0_f64);
        for error in pairs.into_iter().map(|(reference, position)| reference - position) {
            count += 1;
            squares += error * error;
            peak = peak.max(error.abs());
        }
        (count > 0).then(|| Self { rms: (squares / count as f64).sqrt(), peak })
    }
}

impl Diagnosis {
    /// Whether the verdict is `unknown` though the causes named are certain, close most of what calibration leaves and leave no signal unexplained: part of
    /// the cause is found, and what is left is more than noise and has no name.
    pub fn is_found_in_part(&self) -> bool {
        self.verdict == Verdict::Unknown
            && self.withheld.is_none()
            && !self.causes.is_empty()
            && self.causes.iter().all(|cause| cause.probability >= self.limits.probability)
            && self.gap.closed_beside_calibration >= LARGELY
            && self.gap.unexplained_signals.is_empty()
    }
}

/// What the diagnosis stands on.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Data {
    /// Name of the machine.
    pub machine: String,
    /// Training runs.
    pub training: Vec<String>,
    /// Held-out runs.
    pub held_out: Vec<String>,
    /// SHA-256 of the recording.
    pub sha256: String,
    /// Where the recording comes from, in its own words.
    pub note: Option<String>,
    /// How a single run was cut into training and held-out stretches; none where there were several runs.
    pub cut: Option<Cut>,
    /// How many samples were worked on.
    pub samples: Samples,
}

/// What a comparison stands on: the diagnosis of the reference recording, whose twin is the baseline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// What the reference came to, against the machine file: `unknown` where no pass of its diagnosis explains it.
    pub verdict: Verdict,
    /// What forbade its verdict, where something did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub withheld: Option<Veto>,
    /// What the machine had when the reference was recorded; `twin` is what the machine file has.
    pub causes: Vec<Cause>,
    /// G of the machine file's twin on the reference's held-out runs.
    #[serde(deserialize_with = "json::number")]
    pub gap_before: f64,
    /// G of the baseline on them.
    #[serde(deserialize_with = "json::number")]
    pub gap_after: f64,
    /// The reference recording.
    pub data: Data,
}

impl Reference {
    /// Whether an explanation fits it, or closes its gap for the most part, identified or not: what is left then is noise of the comparison. So is what
    /// noise leaves of its held-out runs, whatever happened in its training runs.
    /// None does where its data are faulty, or in the rigid-body scene it fails.
    pub fn is_explained(&self) -> bool {
        let may_be = matches!(self.withheld, None | Some(Veto::Unidentified | Veto::Stretch));
        let leaves_little = self.gap_after <= ADEQUATE_GAP || self.open_share() <= 1.0 - LARGELY;
        self.verdict != Verdict::Unknown || may_be && leaves_little
    }

    /// Whether its explanation is identified by its own runs and each effect of it probable, or leaves no more than a small gap of it. An error of a baseline
    /// that is not identified cannot be told from a change.
    pub fn is_identified(&self, limits: &Limits) -> bool {
        let is_stated = !matches!(self.withheld, Some(Veto::Unidentified | Veto::Stretch));
        let is_probable = self.causes.iter().all(|cause| cause.probability >= limits.probability);
        self.verdict != Verdict::Unknown || self.gap_after <= limits.small_gap || is_stated && is_probable
    }

    /// Share of its gap's power above noise that the baseline leaves open.
    pub fn open_share(&self) -> f64 {
        above_noise(self.gap_after) / above_noise(self.gap_before).max(f64::MIN_POSITIVE)
    }
}

/// Name and version of the form.
pub const SCHEMA: &str = "slideway-diagnosis/1";

/// The whole diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// `slideway-diagnosis/1`.
    pub schema: String,
    /// What it comes to.
    pub verdict: Verdict,
    /// The limits that it was decided by.
    #[serde(default)]
    pub limits: Limits,
    /// Why the verdict is `unknown` whatever the evidence says; none where the evidence gave it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub withheld: Option<Withheld>,
    /// The effects named, most closing first.
    #[serde(default)]
    pub causes: Vec<Cause>,
    /// Probability of every effect of the catalogue, most probable first.
    #[serde(default)]
    pub effects: Vec<EffectProbability>,
    /// Explanations, most probable first.
    #[serde(default)]
    pub ranking: Vec<Ranked>,
    /// Explanations that predict better still, by less than is worth naming beside this gap: what a diagnosis
    /// with the causes in the twin would look at next.
    #[serde(default)]
    pub refinements: Vec<Ranked>,
    /// Stated constants moved inside their tolerance.
    #[serde(default)]
    pub calibration: Vec<Calibration>,
    /// How well the data determine each parameter of the explanation, and which they determine only together.
    #[serde(default, skip_serializing_if = "Identifiability::is_empty")]
    pub identifiability: Identifiability,
    /// Whether the residual of each signal is white.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub residual_whiteness: Vec<ResidualWhiteness>,
    /// How large, how far.
    #[serde(default)]
    pub gap: Gap,
    /// Following error of the machine on the held-out runs; none where the reference was not logged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub following_error: Option<FollowingError>,
    /// Where.
    #[serde(default, rename = "where")]
    pub place: Where,
    /// Share of the gap that stays open.
    #[serde(default)]
    pub unexplained: f64,
    /// What the gap that stays open looks like, where it is more than noise.
    #[serde(default)]
    pub left: Option<Shape>,
    /// The experiment that would settle what these data leave open; none where nothing is open, or nothing settles it.
    #[serde(default)]
    pub next_experiment: Option<NextExperiment>,
    /// Where the verdict is `unknown`: what the recorded motion could not test.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub untested: Vec<Untested>,
    /// Effects that the recorded signals cannot show.
    #[serde(default)]
    pub not_examined: Vec<NotExamined>,
    /// Effects that act in a stretch of the signal path which, replayed alone, shows no gap.
    #[serde(default)]
    pub ruled_out: Vec<NotExamined>,
    /// What was noticed in the data.
    #[serde(default)]
    pub checks: Vec<Finding>,
    /// What it stands on.
    #[serde(default)]
    pub data: Data,
    /// In a comparison, the recording before: causes are then what changed since, and `twin` is the value before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
    /// Version of this program.
    #[serde(default)]
    pub version: String,
}
