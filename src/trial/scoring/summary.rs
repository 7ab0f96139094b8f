//! What many cases came to: by tier, by size, by effect.

use super::interval::{Level, Rate};
use super::judge::{Alarm, Judged};
use super::size::Band;
use crate::effect::EffectId;
use crate::trial::tier::Tier;
use serde::Serialize;

/// Predicted and achieved share of the gap agree within this.
const PREDICTION_MARGIN: f64 = 0.1;

/// What a number of cases came to. A rate counts those cases that it can be asked of: nothing need be named that does not show.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tally {
    /// Number of cases.
    pub cases: usize,
    /// Came out as they should.
    pub right: Rate,
    /// Every planned effect named first; see [`Judged::top_1`].
    pub top_1: Rate,
    /// The same without the cases of which nobody could know: a planned effect has equals.
    pub top_1_without_equals: Rate,
    /// The cases of which nobody could know: every planned effect named by its own name or an equal's.
    pub with_equals: Rate,
    /// The planned effects with at most one extra name before them.
    pub top_2: Rate,
    /// Every planned effect named.
    pub planned_named: Rate,
    /// Every hidden effect of 3 σ or more named.
    pub all_named: Rate,
    /// No extra name.
    pub nothing_extra: Rate,
    /// Cases with a confident wrong name.
    pub confident_wrong: Rate,
    /// `unknown` or `undecided`.
    pub flagged: Rate,
    /// The largest share of the gap put at the right site.
    pub site: Rate,
    /// Mean probability on the planned effects.
    pub probability: Level,
    /// Median share of the gap closed.
    pub closed: Level,
    /// Predicted within ±0.1 of the achieved share.
    pub predicted_within: Rate,
    /// Median of the largest relative parameter error.
    pub parameter_error: Level,
    /// Mean share of 95 % intervals that hold the truth.
    pub covered: Level,
    /// Median computing time of a case on one core, in s.
    pub seconds: Level,
}

impl Tally {
    /// Counts cases.
    pub fn of(cases: &[&Judged]) -> Self {
        let all = |holds: &dyn Fn(&Judged) -> bool| Rate::count(cases.iter().map(|case| holds(case)));
        let known = |holds: &dyn Fn(&Judged) -> Option<bool>| {
            Rate::count(cases.iter().filter_map(|case| holds(case)))
        };
        let numbers = |number: &dyn Fn(&Judged) -> Option<f64>| -> Vec<f64> {
            cases.iter().filter_map(|case| number(case)).collect()
        };
        Self {
            cases: cases.len(),
            right: all(&Judged::is_right),
            top_1: known(&|c| c.top_1),
            top_1_without_equals: known(&|c| c.top_1.filter(|_| !c.has_equals())),
            with_equals: known(&|c| c.has_equals().then(|| c.named_itself_or_equal())),
            top_2: known(&|c| c.top_2),
            planned_named: known(&|c| c.planned_named),
            all_named: known(&|c| c.all_named),
            nothing_extra: all(&|c| c.extra == 0),
            confident_wrong: all(&|c| c.confident_wrong().next().is_some()),
            flagged: all(&|c| c.flagged),
            site: known(&|c| c.site),
            probability: Level::mean(&numbers(&|c| c.probability)),
            closed: Level::median(&numbers(&|c| c.closed)),
            predicted_within: known(&is_predicted),
            parameter_error: Level::median(&numbers(&|c| c.parameter_error)),
            covered: Level::mean(&numbers(&|c| c.covered)),
            seconds: Level::median(&numbers(&|c| Some(c.seconds))),
        }
    }
}

fn is_predicted(case: &Judged) -> Option<bool> {
    let (closed, predicted) = case.closed.zip(case.predicted)?;
    Some((closed - predicted).abs() <= PREDICTION_MARGIN)
}

/// The cases of one tier.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ByTier {
    /// The tier.
    pub tier: Tier,
    /// What they came to.
    #[serde(flatten)]
    pub tally: Tally,
}

/// The cases of one tier and one band of sizes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ByBand {
    /// The tier.
    pub tier: Tier,
    /// The band of the smallest planned gap.
    pub band: Band,
    /// What they came to.
    #[serde(flatten)]
    pub tally: Tally,
}

/// The single cases of one effect.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ByEffect {
    /// The planned effect.
    pub effect: &'static str,
    /// What they came to.
    #[serde(flatten)]
    pub tally: Tally,
}

/// The null cases: nothing hidden makes 1 σ.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Nulls {
    /// The tier; none: of all tiers.
    pub tier: Option<Tier>,
    /// False alarms of either kind.
    pub false_alarms: Rate,
    /// A false name.
    pub false_names: Rate,
    /// Nothing named, and yet another verdict than that there is no gap.
    pub other_verdicts: Rate,
}

/// Summaries of the tiers that there are cases of.
pub fn tiers(cases: &[Judged]) -> Vec<ByTier> {
    let own =
        |tier| chosen(cases, |case| case.tier == tier).map(|own| ByTier { tier, tally: Tally::of(&own) });
    Tier::ALL.into_iter().filter_map(own).collect()
}

/// Summaries of the bands that there are cases of, tier by tier.
pub fn bands(cases: &[Judged]) -> Vec<ByBand> {
    let own = |tier: Tier, band: Band| {
        let own = chosen(cases, |case| case.tier == tier && case.band == Some(band))?;
        Some(ByBand { tier, band, tally: Tally::of(&own) })
    };
    let of = |tier| Band::ALL.into_iter().filter_map(move |band| own(tier, band));
    Tier::ALL.into_iter().flat_map(of).collect()
}

/// Summaries of the single cases, by planned effect, in signal-path order.
pub fn effects(cases: &[Judged]) -> Vec<ByEffect> {
    let is_planned = |case: &Judged, name: &str| case.hidden.iter().any(|h| h.planned && h.effect == name);
    let own = |id: &EffectId| {
        let own = chosen(cases, |case| case.tier == Tier::Single && is_planned(case, id.name()))?;
        Some(ByEffect { effect: id.name(), tally: Tally::of(&own) })
    };
    EffectId::ALL.iter().filter_map(own).collect()
}

/// False alarms, tier by tier and of all tiers together, which is the last.
pub fn nulls(cases: &[Judged]) -> Vec<Nulls> {
    let of = |tier: Option<Tier>| {
        let is_own = |case: &Judged| case.alarm.is_some() && tier.is_none_or(|tier| case.tier == tier);
        let own = chosen(cases, is_own)?;
        let rate = |is: &dyn Fn(Alarm) -> bool| Rate::count(own.iter().filter_map(|case| case.alarm).map(is));
        Some(Nulls {
            tier,
            false_alarms: rate(&|alarm| alarm != Alarm::Quiet),
            false_names: rate(&|alarm| alarm == Alarm::FalseName),
            other_verdicts: rate(&|alarm| alarm == Alarm::OtherVerdict),
        })
    };
    Tier::ALL.into_iter().map(Some).chain([None]).filter_map(of).collect()
}

/// The cases of a kind; none where there are none.
fn chosen(cases: &[Judged], is_own: impl Fn(&Judged) -> bool) -> Option<Vec<&Judged>> {
    let own: Vec<&Judged> = cases.iter().filter(|case| is_own(case)).collect();
    (!own.is_empty()).then_some(own)
}
