//! The verdict and its machine-readable form, schema `slideway-diagnosis/1`.

use super::check::Finding;
use super::decide::Withheld;
use super::found::DECIDED;
use super::next_experiment::NextExperiment;
use super::noise::Source;
use super::prove::RigidBody;
use super::shape::Shape;
use super::standing::LARGELY_CLOSED;
use super::visibility::NotExamined;
use serde::Serialize;
use std::collections::BTreeMap;

/// What a diagnosis comes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The twin predicts the held-out runs as well as noise allows, calibration inside tolerance included.
    NoGap,
    /// One or several effects explain the gap.
    Cause,
    /// Several explanations do equally well on the held-out runs.
    Undecided,
    /// There is a gap that no effect of the catalogue explains.
    Unknown,
}

/// 97.5 % quantile of the normal distribution.
pub(super) const NORMAL_975: f64 = 1.959_964;

/// A fitted number with its interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// Estimate.
    pub value: f64,
    /// 95 % interval.
    pub ci95: [f64; 2],
    /// Unit.
    pub unit: String,
    /// What the twin has instead.
    pub twin: f64,
}

/// An effect that is named as a cause.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cause {
    /// Effect id.
    pub effect: String,
    /// The group that it belongs to, where several effects are numbers of one thing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Its place on the signal path.
    pub site: String,
    /// Posterior probability that it acts.
    pub probability: f64,
    /// Share of the gap that it closes.
    pub closes: f64,
    /// Effects that could stand in its place on these data.
    pub confusable_with: Vec<String>,
    /// Why these data cannot tell them apart, as a sentence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub confusable_reason: Option<String>,
    /// Its parameters.
    pub parameters: BTreeMap<String, Parameter>,
    /// Amplitudes of its waves, each of a sine and a cosine among the parameters.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub amplitudes: BTreeMap<String, Parameter>,
    /// Of a vibration from outside, its phase in each run, training runs first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<RunPhase>,
}

/// The phase φ of a vibration from outside, F = A·sin(2π·f·t + φ), in one run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunPhase {
    /// The run.
    pub run: String,
    /// φ in rad, −π to π; that which the run states, where it states one. t is the time of the session: the run begins at
    /// t = [`Run::begins_s`](crate::recording::Run::begins_s).
    pub phase_rad: f64,
}

impl Cause {
    /// What an engineer asks for: amplitudes in the place of sines and cosines.
    pub fn told(&self) -> impl Iterator<Item = (&String, &Parameter)> {
        let of_wave = |key: &str| {
            let rest = key.strip_prefix("sine").or_else(|| key.strip_prefix("cosine"));
            rest.is_some_and(|rest| self.amplitudes.contains_key(&format!("amplitude{rest}")))
        };
        self.amplitudes.iter().chain(self.parameters.iter().filter(move |(key, _)| !of_wave(key)))
    }

    /// Every number: amplitudes, then parameters.
    pub fn numbers(&self) -> impl Iterator<Item = (&String, &Parameter)> {
        self.amplitudes.iter().chain(&self.parameters)
    }
}

/// Probability that one effect of the catalogue acts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectProbability {
    /// Effect id.
    pub effect: String,
    /// Posterior probability.
    pub probability: f64,
}

/// One explanation of the ranking.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ranked {
    /// Its effects; empty: the twin as it is, calibrated.
    pub effects: Vec<String>,
    /// Posterior probability.
    pub probability: f64,
    /// Gap G on the held-out runs.
    pub held_out_gap: f64,
}

/// A stated constant moved inside its tolerance.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SignalGap {
    /// Canonical name.
    pub signal: String,
    /// RMS of recorded less predicted, twin as it is.
    pub rms_before: f64,
    /// The same with the causes added.
    pub rms_after: f64,
    /// Noise σ.
    pub noise: f64,
    /// Where the noise σ comes from.
    pub noise_source: Source,
    /// Mean absolute residual before.
    pub mae_before: f64,
    /// Mean absolute residual after.
    pub mae_after: f64,
    /// Largest absolute residual before.
    pub peak_before: f64,
    /// Largest absolute residual after.
    pub peak_after: f64,
    /// Coefficient of determination before.
    pub r2_before: f64,
    /// Coefficient of determination after.
    pub r2_after: f64,
}

/// How large the gap is and how far it shrinks.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gap {
    /// G of the twin as it is, in units of noise.
    pub before: f64,
    /// G with the causes added.
    pub after: f64,
    /// G that noise alone leaves: 1.
    pub floor: f64,
    /// 1 − (after² − 1)/(before² − 1).
    pub closed: f64,
    /// Its 95 % interval.
    pub closed_ci95: [f64; 2],
    /// The smaller of this share and that of what calibration alone leaves: what is to the causes' credit.
    pub closed_beside_calibration: f64,
    /// Whether the noise of every signal was seen in the recording: in repeats, or at standstill as at least a third of what is
    /// stated. A multiple of it is then known as such.
    pub noise_is_measured: bool,
    /// What cross-validation inside the training runs predicted.
    pub predicted_closed: f64,
    /// The same in the rigid-body scene; none without causes, and where the scene cannot be built.
    pub rigid_body: Option<RigidBody>,
    /// Signal by signal.
    pub signals: Vec<SignalGap>,
}

impl Diagnosis {
    /// Whether the verdict is `unknown` though the causes named are certain and close most of what calibration leaves: part of
    /// the cause is found, and what is left is more than noise and has no name.
    pub fn is_found_in_part(&self) -> bool {
        self.verdict == Verdict::Unknown
            && self.withheld.is_none()
            && !self.causes.is_empty()
            && self.causes.iter().all(|cause| cause.probability >= DECIDED)
            && self.gap.closed_beside_calibration >= LARGELY_CLOSED
    }
}

/// A share of the gap by name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Share {
    /// Site, segment or phase.
    #[serde(skip)]
    pub name: String,
    /// Share, 0 to 1.
    pub share: f64,
}

/// A share of the gap between two values.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Band {
    /// From.
    pub from: f64,
    /// To.
    pub to: f64,
    /// Share, 0 to 1.
    pub share: f64,
}

/// Where the gap lies.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Where {
    /// By place on the signal path.
    pub site: Vec<Share>,
    /// By stretch of the signal path between two logged signals, with its residual as a force.
    pub segment: Vec<Share>,
    /// By phase of the motion.
    pub phase: Vec<Share>,
    /// By frequency.
    pub frequency_hz: Vec<Band>,
    /// By position, m or rad.
    pub position: Vec<Band>,
    /// By speed, m/s or rad/s.
    pub speed: Vec<Band>,
}

impl Serialize for Where {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeStruct;
        let named = |key: &'static str, shares: &[Share]| -> Vec<BTreeMap<&'static str, serde_json::Value>> {
            shares
                .iter()
                .map(|s| BTreeMap::from([(key, s.name.clone().into()), ("share", s.share.into())]))
                .collect()
        };
        let mut map = serializer.serialize_struct("Where", 6)?;
        map.serialize_field("site", &named("site", &self.site))?;
        map.serialize_field("segment", &named("segment", &self.segment))?;
        map.serialize_field("phase", &named("phase", &self.phase))?;
        map.serialize_field("frequency_hz", &self.frequency_hz)?;
        map.serialize_field("position", &self.position)?;
        map.serialize_field("speed", &self.speed)?;
        map.end()
    }
}

/// What the diagnosis stands on.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
}

/// What a comparison stands on: the diagnosis of the reference recording, whose twin is the baseline.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reference {
    /// What the reference came to, against the machine file: `unknown` where no pass of its diagnosis explains it.
    pub verdict: Verdict,
    /// What the machine had when the reference was recorded; `twin` is what the machine file has.
    pub causes: Vec<Cause>,
    /// G of the machine file's twin on the reference's held-out runs.
    pub gap_before: f64,
    /// G of the baseline on them.
    pub gap_after: f64,
    /// The reference recording.
    pub data: Data,
}

/// The whole diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Diagnosis {
    /// `slideway-diagnosis/1`.
    pub schema: &'static str,
    /// What it comes to.
    pub verdict: Verdict,
    /// Why the verdict is `unknown` whatever the evidence says; none where the evidence gave it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub withheld: Option<Withheld>,
    /// The effects named, most closing first.
    pub causes: Vec<Cause>,
    /// Probability of every effect of the catalogue, most probable first.
    pub effects: Vec<EffectProbability>,
    /// Explanations, most probable first.
    pub ranking: Vec<Ranked>,
    /// Explanations that predict better still, by less than is worth naming beside this gap: what a diagnosis
    /// with the causes in the twin would look at next.
    pub refinements: Vec<Ranked>,
    /// Stated constants moved inside their tolerance.
    pub calibration: Vec<Calibration>,
    /// How large, how far.
    pub gap: Gap,
    /// Where.
    #[serde(rename = "where")]
    pub place: Where,
    /// Share of the gap that stays open.
    pub unexplained: f64,
    /// What the gap that stays open looks like, where it is more than noise.
    pub left: Option<Shape>,
    /// The experiment that would settle what these data leave open; none where nothing is open, or nothing settles it.
    pub next_experiment: Option<NextExperiment>,
    /// Effects that the recorded signals cannot show.
    pub not_examined: Vec<NotExamined>,
    /// Effects that act in a stretch of the signal path which, replayed alone, shows no gap.
    pub ruled_out: Vec<NotExamined>,
    /// What was noticed in the data.
    pub checks: Vec<Finding>,
    /// What it stands on.
    pub data: Data,
    /// In a comparison, the recording before: causes are then what changed since, and `twin` is the value before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
    /// Version of this program.
    pub version: &'static str,
}
