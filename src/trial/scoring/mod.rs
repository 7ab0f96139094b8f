//! Scoring: the seal opened against committed verdicts, and what they were worth.
//!
//! # Principles
//! A gap is RMS in standard deviations of the noise: what a hidden effect makes beside everything else that is hidden, beyond
//! what constants inside their tolerances make up for.
//!
//! - **What must be named.** A hidden effect must be named where its gap is 3 σ or more. From 1 to 3 σ it may be named. Below
//!   1 σ, the floor, the case counts as null for this effect: to name it is not wrong and is not asked for. This holds for what
//!   the tier planned and for what comes along with it: friction behind a feature of friction, the bristles of friction,
//!   nuisances.
//! - **What names it.** Its own name; the name of an equal, which nobody could tell from it on these runs; or a cause that is
//!   reported in a group of which it, or an equal, is a member. One cause names one hidden effect.
//! - **Extra names.** A cause that stands for no hidden effect of any size is an extra name: a wrong one. With a probability
//!   of 0.9 or more in a verdict `cause` it is a confident wrong name. That is the worst kind: each is listed.
//! - **Named first.** No extra name stands before a planned effect. What is hidden beside it may.
//! - **Null cases.** A case is null where nothing hidden makes 1 σ, in whichever tier. A false alarm is an extra name, or any
//!   verdict but `no_gap` without a name; both are counted, and a case counts once.
//! - **Outside the catalogue.** Right is `unknown` or `undecided`; below the floor `no_gap` is right as well, and neither is a
//!   false alarm. A confident name is wrong.
//! - **Changes.** Right is the changed effect named first and nothing extra. What is hidden before and after alike may be
//!   named or not.
//! - **What nobody could know.** Cases whose planned effect has equals are counted apart, and named first is given with and
//!   without them.
//! - **Parameters.** Those of a named cause are compared with those of the hidden effect of its name. Of a law with several pitches
//!   the pitch tells which is which, not the order in which they are numbered.
//! - **Size of a case**: the smallest gap of its planned effects. Every rate counts only cases that it can be asked of.

pub mod bars;
pub mod confusion;
pub mod interval;
pub mod judge;
pub mod naming;
mod parameters;
pub mod reliability;
pub mod size;
mod statement;
mod story;
pub mod summary;

use super::folder::{Skipped, Trial};
use super::seal::CommittedVerdicts;
use super::tier::Tier;
use super::truth::Truth;
use crate::error::{Error, ErrorKind, Result};
use bars::{Bar, bars};
use confusion::Confusion;
use judge::Judged;
use reliability::Reliability;
use serde::Serialize;
use summary::{ByBand, ByEffect, ByTier, Nulls};

/// Schema of the score.
pub const SCHEMA: &str = "slideway-score/2";
/// Cases that are listed as the worst.
const WORST: usize = 10;

/// A confident wrong name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConfidentWrong {
    /// Case, from 1.
    pub case: usize,
    /// Its tier.
    pub tier: Tier,
    /// The name.
    pub effect: String,
    /// Its stated probability.
    pub probability: f64,
    /// What was hidden and what was said.
    pub story: String,
}

/// The score of a trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scores {
    /// `slideway-score/2`.
    pub schema: &'static str,
    /// Seed.
    pub seed: u64,
    /// `development` or `judging`.
    pub purpose: &'static str,
    /// Machine on trial.
    pub machine: String,
    /// Engine that forged it.
    pub engine: String,
    /// SHA-256 of the truth.
    pub truth_sha256: String,
    /// Effects that were not forged, and why.
    pub skipped: Vec<Skipped>,
    /// The bars.
    pub bars: Vec<Bar>,
    /// Tier by tier.
    pub tiers: Vec<ByTier>,
    /// Tier by tier and size by size.
    pub bands: Vec<ByBand>,
    /// The single tier by planned effect.
    pub effects: Vec<ByEffect>,
    /// The null cases, tier by tier; the last is of all tiers.
    pub nulls: Vec<Nulls>,
    /// Whether stated probabilities are kept.
    pub reliability: Reliability,
    /// Every confident wrong name.
    pub confident_wrong: Vec<ConfidentWrong>,
    /// Which effect was named for which.
    pub confusion: Confusion,
    /// Every case, in its order.
    pub cases: Vec<Judged>,
    /// Version of this program.
    pub version: &'static str,
}

/// Opens a trial's seal against its committed verdicts and scores them.
///
/// # Errors
/// A case without a committed verdict, verdicts or a truth that were changed, or a seal that was opened against other
/// verdicts.
pub fn score(trial: &Trial) -> Result<Scores> {
    let committed = CommittedVerdicts::read(trial)?;
    let truth: Truth = trial.truth().open(&committed)?;
    let cases = judged(trial, &truth, &committed)?;
    Ok(Scores {
        schema: SCHEMA,
        seed: trial.seed.number(),
        purpose: trial.seed.kind(),
        machine: truth.machine,
        engine: truth.engine.name().to_owned(),
        truth_sha256: trial.announcement.truth_sha256.clone(),
        skipped: trial.announcement.skipped.clone(),
        bars: bars(&cases),
        tiers: summary::tiers(&cases),
        bands: summary::bands(&cases),
        effects: summary::effects(&cases),
        nulls: summary::nulls(&cases),
        reliability: Reliability::of(&cases),
        confident_wrong: confident_wrong(&cases),
        confusion: Confusion::of(&cases),
        cases,
        version: env!("CARGO_PKG_VERSION"),
    })
}

fn judged(trial: &Trial, truth: &Truth, committed: &CommittedVerdicts) -> Result<Vec<Judged>> {
    let one = |case: &super::truth::TrueCase| {
        let verdict = committed.verdicts().iter().find(|committed| committed.case == case.case);
        let verdict = verdict.ok_or_else(|| {
            Error::new(ErrorKind::Missing)
                .file(trial.verdicts())
                .key(case.case.to_string())
                .found("a truth with more cases than the trial")
                .expected("a verdict on every case")
                .remedy("forge the trial again")
        })?;
        Ok(Judged::new(case, verdict))
    };
    truth.cases.iter().map(one).collect()
}

/// Every confident wrong name, surest first.
pub fn confident_wrong(cases: &[Judged]) -> Vec<ConfidentWrong> {
    let of = |case: &Judged| -> Vec<ConfidentWrong> {
        let one = |name: &judge::Named| ConfidentWrong {
            case: case.case,
            tier: case.tier,
            effect: name.effect.clone(),
            probability: name.probability,
            story: case.story.clone(),
        };
        case.confident_wrong().map(one).collect()
    };
    let mut all: Vec<ConfidentWrong> = cases.iter().flat_map(of).collect();
    all.sort_by(|a, b| b.probability.total_cmp(&a.probability).then(a.case.cmp(&b.case)));
    all
}

impl Scores {
    /// The worst of the cases that came out wrong, worst first; without those of a confident wrong name, which are listed by
    /// themselves.
    pub fn worst(&self) -> Vec<&Judged> {
        let is_listed = |case: &&Judged| case.confident_wrong().next().is_none() && !case.is_right();
        let mut worst: Vec<&Judged> = self.cases.iter().filter(is_listed).collect();
        worst.sort_by(|a, b| b.badness().total_cmp(&a.badness()).then(a.case.cmp(&b.case)));
        worst.truncate(WORST);
        worst
    }
}
