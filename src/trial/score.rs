//! Scoring: the seal opened against committed verdicts, and what they were worth.

use super::bars::{BEST_PUBLIC_PROBABILITY, Bar, bars};
use super::confusion::Confusion;
use super::folder::{Skipped, Trial};
use super::interval::{Level, Rate};
use super::judge::Judged;
use super::seal::CommittedVerdicts;
use super::tier::Tier;
use super::truth::Truth;
use crate::error::{Error, ErrorKind, Result};
use serde::Serialize;

/// Cases that are listed as the worst.
const WORST: usize = 10;
/// Predicted and achieved share of the gap agree within this.
const PREDICTION_MARGIN: f64 = 0.1;
/// Edges of the size classes, in gaps.
const SIZES: [f64; 4] = [10.0, 30.0, 100.0, 300.0];

/// What the cases of one tier came to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// The tier.
    pub tier: Tier,
    /// Number of cases.
    pub cases: usize,
    /// Every hidden effect at the first places, reported groups counted.
    pub top_1: Rate,
    /// The same with one place more.
    pub top_2: Rate,
    /// Named by its own name and nothing else.
    pub exact: Rate,
    /// Every hidden effect among the causes.
    pub all_named: Rate,
    /// A cause named that stands for nothing hidden.
    pub extra: Rate,
    /// Any verdict but `no_gap`; for the null tier.
    pub false_alarms: Rate,
    /// A cause named although nothing is hidden; for the null tier.
    pub false_causes: Rate,
    /// `unknown` or `undecided`.
    pub flagged: Rate,
    /// The largest share put at the right site.
    pub site: Rate,
    /// Mean probability on the hidden effects.
    pub probability: Level,
    /// Median share of the gap closed.
    pub closed: Level,
    /// Predicted within ±0.1 of achieved.
    pub predicted_within: Rate,
    /// Median of the largest parameter error.
    pub parameter_error: Level,
    /// Mean share of 95 % intervals that hold the truth.
    pub covered: Level,
    /// Median computing time of a case on one core, in s.
    pub seconds: Level,
}

/// What the cases of one size came to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BySize {
    /// Least gap.
    pub from: f64,
    /// Largest gap; none: no limit.
    pub to: Option<f64>,
    /// Number of cases.
    pub cases: usize,
    /// Top-1.
    pub top_1: Rate,
    /// Top-2.
    pub top_2: Rate,
    /// Mean probability on the hidden effect.
    pub probability: Level,
    /// Median share of the gap closed.
    pub closed: Level,
}

/// The score of a trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scores {
    /// `slideway-score/1`.
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
    /// Tier by tier.
    pub tiers: Vec<Summary>,
    /// The single tier by size.
    pub sizes: Vec<BySize>,
    /// The bars.
    pub bars: Vec<Bar>,
    /// Which effect was named for which.
    pub confusion: Confusion,
    /// Best published mean probability on the true cause of an unseen cycle.
    pub best_public_probability: f64,
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
    let mut cases = Vec::new();
    for case in &truth.cases {
        let verdict = committed.verdicts().iter().find(|committed| committed.case == case.case);
        let verdict = verdict.ok_or_else(|| {
            Error::new(ErrorKind::Missing)
                .file(trial.verdicts())
                .key(case.case.to_string())
                .found("a truth with more cases than the trial")
                .expected("a verdict on every case")
                .remedy("forge the trial again")
        })?;
        cases.push(Judged::new(case, verdict));
    }
    let tiers = summaries(&cases);
    Ok(Scores {
        schema: "slideway-score/1",
        seed: trial.seed.number(),
        purpose: trial.seed.kind(),
        machine: truth.machine,
        engine: truth.engine.name().to_owned(),
        truth_sha256: trial.announcement.truth_sha256.clone(),
        skipped: trial.announcement.skipped.clone(),
        sizes: sizes(&cases),
        bars: bars(&tiers),
        confusion: Confusion::of(&cases),
        best_public_probability: BEST_PUBLIC_PROBABILITY,
        tiers,
        cases,
        version: env!("CARGO_PKG_VERSION"),
    })
}

impl Scores {
    /// The worst cases, worst first.
    pub fn worst(&self) -> Vec<&Judged> {
        let mut worst: Vec<&Judged> = self.cases.iter().collect();
        worst.sort_by(|a, b| b.badness().total_cmp(&a.badness()).then(a.case.cmp(&b.case)));
        worst.truncate(WORST);
        worst
    }
}

/// Summaries of the tiers that there are cases of.
pub fn summaries(cases: &[Judged]) -> Vec<Summary> {
    let own = |tier: Tier| cases.iter().filter(|case| case.tier == tier).collect::<Vec<_>>();
    Tier::ALL
        .into_iter()
        .map(|tier| (tier, own(tier)))
        .filter(|(_, own)| !own.is_empty())
        .map(summary)
        .collect()
}

fn summary((tier, cases): (Tier, Vec<&Judged>)) -> Summary {
    let rate = |holds: &dyn Fn(&Judged) -> bool| Rate::count(cases.iter().map(|case| holds(case)));
    let some = |number: &dyn Fn(&Judged) -> Option<f64>| -> Vec<f64> {
        cases.iter().filter_map(|case| number(case)).collect()
    };
    let within = |case: &&Judged| {
        case.closed
            .zip(case.predicted)
            .map(|(closed, predicted)| (closed - predicted).abs() <= PREDICTION_MARGIN)
    };
    Summary {
        tier,
        cases: cases.len(),
        top_1: rate(&|c| c.top_1),
        top_2: rate(&|c| c.top_2),
        exact: rate(&|c| c.exact),
        all_named: rate(&|c| c.all_named),
        extra: rate(&|c| c.extra > 0),
        false_alarms: rate(&|c| c.hidden.is_empty() && !c.top_1),
        false_causes: rate(&|c| c.hidden.is_empty() && !c.named.is_empty()),
        flagged: rate(&|c| c.flagged),
        site: Rate::count(cases.iter().filter_map(|case| case.site)),
        probability: Level::mean(&some(&|c| c.probability)),
        closed: Level::median(&some(&|c| c.closed)),
        predicted_within: Rate::count(cases.iter().filter_map(within)),
        parameter_error: Level::median(&some(&|c| c.parameter_error)),
        covered: Level::mean(&some(&|c| c.covered)),
        seconds: Level::median(&some(&|c| Some(c.seconds))),
    }
}

/// The single tier by the gap that the hidden effect makes.
fn sizes(cases: &[Judged]) -> Vec<BySize> {
    let edges: Vec<f64> = std::iter::once(0.0).chain(SIZES).collect();
    let class = |(k, &from): (usize, &f64)| {
        let to = edges.get(k + 1).copied();
        let own: Vec<&Judged> = cases
            .iter()
            .filter(|c| c.tier == Tier::Single && c.gap >= from && to.is_none_or(|to| c.gap < to))
            .collect();
        let some = |number: &dyn Fn(&Judged) -> Option<f64>| -> Vec<f64> {
            own.iter().filter_map(|case| number(case)).collect()
        };
        BySize {
            from,
            to,
            cases: own.len(),
            top_1: Rate::count(own.iter().map(|c| c.top_1)),
            top_2: Rate::count(own.iter().map(|c| c.top_2)),
            probability: Level::mean(&some(&|c| c.probability)),
            closed: Level::median(&some(&|c| c.closed)),
        }
    };
    edges.iter().enumerate().map(class).filter(|class| class.cases > 0).collect()
}
