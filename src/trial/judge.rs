//! One verdict against its truth.

use super::seal::Committed;
use super::tier::Tier;
use super::truth::{HiddenEffect, TrueCase};
use super::verdict::{Came, Cause, Said};
use crate::effect::EffectId;
use serde::Serialize;
use std::collections::BTreeMap;

/// How one case was judged.
///
/// # Model
/// - The effects in order are the named causes, most closing first, then the rest by probability. A hidden effect is
///   *at a place* when the effect there has its name or reports it as one that could stand in its place
///   (`confusable_with`; in an undecided verdict also any explanation at least a twentieth as probable as the first). Top-1
///   needs a named cause; no place counts where the verdict is that there is no gap.
/// - The probability on the truth is that of the effect and of its exact equals on the logged signals together, and, where
///   the truth is reported as confusable, that of the cause named.
/// - The site is right where the largest share of the gap is put at the site of a hidden effect or of its equal.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judged {
    /// Case, from 1.
    pub case: usize,
    /// Its tier.
    pub tier: Tier,
    /// The hidden effects, largest gap first; behind them the friction that one of them modifies.
    pub hidden: Vec<&'static str>,
    /// Gap that the first of them makes.
    pub gap: f64,
    /// Signals that were not logged.
    pub missing: Vec<String>,
    /// What the verdict came to.
    pub verdict: &'static str,
    /// The causes named.
    pub named: Vec<String>,
    /// Every hidden effect is at the first places, as many as are hidden; null: no gap was reported.
    pub top_1: bool,
    /// The same with one more place.
    pub top_2: bool,
    /// Every hidden effect is named by its own name, and nothing else.
    pub exact: bool,
    /// Every hidden effect is among the causes.
    pub all_named: bool,
    /// Causes named that stand for no hidden effect.
    pub extra: usize,
    /// Mean probability on the hidden effects; none where nothing is hidden.
    pub probability: Option<f64>,
    /// Whether the largest share is put at the right site; none where nothing is hidden.
    pub site: Option<bool>,
    /// The answer is `unknown` or `undecided`.
    pub flagged: bool,
    /// Gap that the twin as it is left.
    pub gap_before: f64,
    /// Share of the gap that was closed; none without causes.
    pub closed: Option<f64>,
    /// Share that was predicted; none without causes.
    pub predicted: Option<f64>,
    /// Largest error of a hidden effect's parameters, as a share of the largest of the same unit; none where it was
    /// not named by its own name.
    pub parameter_error: Option<f64>,
    /// Share of these parameters whose 95 % interval holds the truth.
    pub covered: Option<f64>,
    /// Computing time on one core, in s.
    pub seconds: f64,
    /// What was hidden and what was said, in words.
    pub story: String,
}

/// Explanations of an undecided verdict that count as one group, as shares of the first.
const GROUP: f64 = 0.05;

impl Judged {
    /// Judges a committed verdict.
    pub fn new(truth: &TrueCase, committed: &Committed) -> Self {
        let said = &committed.said;
        let mut hidden: Vec<&HiddenEffect> = truth.effects.iter().collect();
        let is_modified =
            |h: &HiddenEffect| truth.effects.iter().any(|other| other.effect.modifies().contains(&h.effect));
        hidden.sort_by(|a, b| is_modified(a).cmp(&is_modified(b)).then(b.gap.total_cmp(&a.gap)));
        let count = hidden.len();
        let has_causes = !said.causes.is_empty();
        let is_null = truth.tier == Tier::Null;
        let ranks = ranks(said);
        let no_gap = said.verdict == Came::NoGap;
        let within = |places: usize| {
            !no_gap && hidden.iter().all(|h| ranks.iter().take(places).any(|rank| rank.is_for(h, said)))
        };
        let stands = |cause: &Cause| {
            truth.effects.iter().any(|h| Rank::of(cause).is_for(h, said) || h.is_called(&cause.effect))
                || is_bristle(truth, &cause.effect)
        };
        let extra = said.causes.iter().filter(|cause| !stands(cause)).count();
        let names: Vec<&str> = said.causes.iter().map(|cause| cause.effect.as_str()).collect();
        let own = names.iter().filter(|name| !is_bristle(truth, name)).count();
        let exact = own == count && hidden.iter().all(|h| names.contains(&h.effect.name()));
        let errors =
            hidden.iter().filter_map(|h| errors(h, said)).reduce(|a, b| (a.0.max(b.0), a.1 + b.1, a.2 + b.2));
        Self {
            case: truth.case,
            tier: truth.tier,
            hidden: hidden.iter().map(|h| h.effect.name()).collect(),
            gap: hidden.first().map_or(truth.gap, |h| h.gap),
            missing: truth.missing.clone(),
            verdict: said.verdict.name(),
            named: names.iter().map(|name| (*name).to_owned()).collect(),
            top_1: if is_null { no_gap } else { has_causes && within(count) },
            top_2: if is_null { no_gap } else { within(count + 1) },
            exact,
            all_named: has_causes && within(said.causes.len()),
            extra,
            probability: mean(hidden.iter().map(|h| probability(h, said))),
            site: (!is_null).then(|| site(&hidden, said)),
            flagged: matches!(said.verdict, Came::Unknown | Came::Undecided),
            gap_before: said.gap.before,
            closed: has_causes.then_some(said.gap.closed),
            predicted: has_causes.then_some(said.gap.predicted_closed),
            parameter_error: errors.map(|(error, ..)| error),
            covered: errors.map(|(_, covered, of)| covered / of),
            seconds: committed.seconds,
            story: story(&hidden, truth, said),
        }
    }

    /// Whether the case came out as it should.
    pub fn is_right(&self) -> bool {
        match self.tier {
            Tier::Outside => self.flagged,
            Tier::Pair | Tier::Triple => self.all_named,
            _ => self.top_1,
        }
    }

    /// How bad a case is, from 0: wrong ones first, surer ones worse.
    pub fn badness(&self) -> f64 {
        let doubt = match self.tier {
            Tier::Null | Tier::Outside => 0.5,
            _ => 1.0 - self.probability.unwrap_or(0.0),
        };
        f64::from(u8::from(!self.is_right())) * 2.0 + doubt + 0.1 * self.extra as f64
    }
}

/// Whether a name is that of the bristles that every forged machine with dry friction has, hidden by themselves or not.
fn is_bristle(truth: &TrueCase, name: &str) -> bool {
    let presliding = EffectId::Presliding;
    let has_friction = truth.effects.iter().any(|h| presliding.modifies().contains(&h.effect));
    name == presliding.name() && has_friction && truth.effects.iter().all(|h| h.effect != presliding)
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), v| (sum + v, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// An effect at its place: a named cause, or one that is only probable.
struct Rank<'a> {
    effect: &'a str,
    group: &'a [String],
    is_cause: bool,
}

impl<'a> Rank<'a> {
    fn of(cause: &'a Cause) -> Self {
        Self { effect: &cause.effect, group: &cause.confusable_with, is_cause: true }
    }

    /// Whether the place is a hidden effect's.
    fn is_for(&self, hidden: &HiddenEffect, said: &Said) -> bool {
        let name = hidden.effect.name();
        let undecided = || {
            let first = said.ranking.first().map_or(0.0, |explanation| explanation.probability);
            let near = |e: &super::verdict::Explanation| {
                e.probability >= GROUP * first
                    && e.effects.iter().any(|effect| effect == name)
                    && !e.effects.iter().any(|effect| effect == self.effect)
            };
            self.is_cause && said.verdict == Came::Undecided && said.ranking.iter().any(near)
        };
        self.effect == name || self.group.iter().any(|other| other == name) || undecided()
    }
}

/// The effects in order: causes, then the others by probability.
fn ranks(said: &Said) -> Vec<Rank<'_>> {
    let rest = said.effects.iter().filter(|e| !said.causes.iter().any(|cause| cause.covers(&e.effect)));
    let rest = rest.map(|e| Rank { effect: &e.effect, group: &[], is_cause: false });
    said.causes.iter().map(Rank::of).chain(rest).collect()
}

fn probability(hidden: &HiddenEffect, said: &Said) -> f64 {
    let name = hidden.effect.name();
    let mut group: Vec<&str> = vec![name];
    group.extend(hidden.equals.iter().map(|equal| equal.name()));
    let reported = said.causes.iter().filter(|cause| cause.covers(name)).map(|cause| cause.effect.as_str());
    for effect in reported {
        if !group.contains(&effect) {
            group.push(effect);
        }
    }
    group.into_iter().map(|effect| said.probability(effect)).sum::<f64>().min(1.0)
}

fn site(hidden: &[&HiddenEffect], said: &Said) -> bool {
    let largest = said.place.site.iter().max_by(|a, b| a.share.total_cmp(&b.share));
    largest.is_some_and(|largest| hidden.iter().any(|h| h.is_at(&largest.site)))
}

/// Largest relative error of an effect's parameters, how many intervals hold the truth, of how many; none where the effect
/// is not among the causes.
fn errors(hidden: &HiddenEffect, said: &Said) -> Option<(f64, f64, f64)> {
    let cause = said.causes.iter().find(|cause| cause.effect == hidden.effect.name())?;
    let unit = |key: &str| {
        let parameter = hidden.effect.parameters().iter().find(|p| p.name == key || p.revolute_name == key);
        parameter.map_or("", |p| p.unit)
    };
    let mut largest: BTreeMap<&str, f64> = BTreeMap::new();
    for (key, value) in &hidden.parameters {
        let most = largest.entry(unit(key)).or_default();
        *most = most.max(value.abs());
    }
    let (mut worst, mut covered, mut of) = (0.0_f64, 0.0, 0.0);
    for (key, truth) in &hidden.parameters {
        let Some(number) = cause.parameters.get(key) else { continue };
        let scale = largest.get(unit(key)).copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
        worst = worst.max((number.value - truth).abs() / scale);
        let [from, to] = number.ci95;
        // A number that only starts set, a resolution above all, has no width: it is right to the last digits or not.
        let rounding = 1e-9 * truth.abs();
        let holds =
            from.is_none_or(|from| from - rounding <= *truth) && to.is_none_or(|to| *truth <= to + rounding);
        covered += f64::from(u8::from(holds));
        of += 1.0;
    }
    (of > 0.0).then_some((worst, covered, of))
}

/// Four digits, with an exponent where that is shorter.
fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-2..1e4).contains(&size) { format!("{value:.4}") } else { format!("{value:.3e}") }
}

fn story(hidden: &[&HiddenEffect], truth: &TrueCase, said: &Said) -> String {
    let of = |h: &&HiddenEffect| {
        let numbers: Vec<String> =
            h.parameters.iter().map(|(key, value)| format!("{key} {}", short(*value))).collect();
        format!("{} (gap {:.1}: {})", h.effect.name(), h.gap, numbers.join(", "))
    };
    let what = match hidden {
        [] => "nothing".to_owned(),
        all => all.iter().map(of).collect::<Vec<_>>().join(" and "),
    };
    let missing = match &truth.missing[..] {
        [] => String::new(),
        missing => format!(", without {}", missing.join(", ")),
    };
    let named = |cause: &Cause| match &cause.confusable_with[..] {
        [] => format!("{} {:.2}", cause.effect, cause.probability),
        others => format!("{} {:.2} or {}", cause.effect, cause.probability, others.join(", ")),
    };
    let causes: Vec<String> = said.causes.iter().map(named).collect();
    let causes = if causes.is_empty() { "no cause".to_owned() } else { causes.join(" + ") };
    let likely: Vec<String> =
        said.effects.iter().take(3).map(|e| format!("{} {:.2}", e.effect, e.probability)).collect();
    format!(
        "hidden {what}{missing}; said {}: {causes}; G {:.1} → {:.2}; most probable: {}",
        said.verdict.name(),
        said.gap.before,
        said.gap.after,
        likely.join(", ")
    )
}
