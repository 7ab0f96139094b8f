//! One verdict against its truth.

use super::naming::{Naming, Standing};
use super::parameters::{Compared, compared};
use super::size::{Band, Demand, FLOOR};
use super::statement::{Statement, statements};
use super::story::story;
use crate::diagnose::Verdict;
use crate::trial::seal::Committed;
use crate::trial::tier::Tier;
use crate::trial::truth::{HiddenEffect, TrueCase};
use crate::trial::verdict::{REFUSED, Said};
use serde::Serialize;

/// Probability from which on a wrong name is a confident one.
pub const CONFIDENT: f64 = 0.9;

/// One hidden effect, what is asked for it, and how it is named.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sought {
    /// Its name.
    pub effect: &'static str,
    /// Whether the tier asked for it; else it comes along.
    pub planned: bool,
    /// Gap that it makes, in standard deviations of the noise.
    pub gap: f64,
    /// What is asked for it.
    pub demand: Demand,
    /// Effects that nobody could tell from it on these runs.
    pub equals: Vec<&'static str>,
    /// How it is named; none where it is not.
    pub named_as: Option<Standing>,
}

/// One named cause.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Named {
    /// Its name.
    pub effect: String,
    /// Its stated probability.
    pub probability: f64,
    /// What it stands for.
    pub standing: Standing,
}

/// How a case came out in which nothing hidden shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Alarm {
    /// No gap, or what is named is hidden.
    Quiet,
    /// A false name.
    FalseName,
    /// Nothing named, and yet another verdict than that there is no gap.
    OtherVerdict,
}

/// How one case was judged. The rules are those of [`super`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judged {
    /// Case, from 1.
    pub case: usize,
    /// Its tier.
    pub tier: Tier,
    /// The hidden effects: what must be named first, of these what is planned, of these the largest gap.
    pub hidden: Vec<Sought>,
    /// Size of the case in standard deviations of the noise: the smallest planned gap. In the tier outside, where what is
    /// hidden may have no law, what everything hidden makes together. None where nothing is planned.
    pub size: Option<f64>,
    /// Band of its size.
    pub band: Option<Band>,
    /// Signals that were not logged.
    pub missing: Vec<String>,
    /// What the verdict came to.
    pub verdict: &'static str,
    /// The causes named, most closing first.
    pub named: Vec<Named>,
    /// Every planned effect of 1 σ or more is named, and no extra name stands before one; none where there is none such, and
    /// in the tier outside.
    pub top_1: Option<bool>,
    /// The same with at most one extra name before them; an effect that is only probable has its place behind the causes.
    pub top_2: Option<bool>,
    /// Every planned effect of 1 σ or more is named; none as above.
    pub planned_named: Option<bool>,
    /// Every hidden effect of 3 σ or more is named, planned or not; none as above.
    pub all_named: Option<bool>,
    /// Number of extra names.
    pub extra: usize,
    /// Mean probability on the planned effects of 1 σ or more; none as above.
    pub probability: Option<f64>,
    /// Whether the largest share of the gap is put at the site of a hidden effect of 1 σ or more; none where there is none.
    pub site: Option<bool>,
    /// The answer is `unknown` or `undecided`.
    pub flagged: bool,
    /// Whether there was a false alarm; none where something hidden shows.
    pub alarm: Option<Alarm>,
    /// Gap of the twin as it is, in units of noise.
    pub gap_before: f64,
    /// Share of the gap that was closed; none without causes.
    pub closed: Option<f64>,
    /// Share that was predicted; none without causes.
    pub predicted: Option<f64>,
    /// Largest error of a planned effect's parameters, as a share of its largest of the same unit; none where no planned effect
    /// is named by its own name.
    pub parameter_error: Option<f64>,
    /// Share of the 95 % intervals of hidden effects that hold the truth; none where none is named by its own name.
    pub covered: Option<f64>,
    /// Probabilities that were stated, and whether they were of what is hidden.
    pub statements: Vec<Statement>,
    /// Computing time on one core, in s.
    pub seconds: f64,
    /// What was hidden and what was said, in words.
    pub story: String,
}

impl Judged {
    /// Judges a committed verdict.
    pub fn new(truth: &TrueCase, committed: &Committed) -> Self {
        let said = &committed.said;
        let hidden = sorted(&truth.effects);
        let naming = Naming::of(&hidden, &truth.before, said);
        let places = Places { truth, hidden: &hidden, naming: &naming, said };
        let named = named(&naming);
        let extra = named.iter().filter(|name| name.standing == Standing::Extra).count();
        let size = size(truth);
        let has_causes = !said.causes().is_empty();
        let compared = compared(&hidden, said);
        let errors = |planned_only: bool| {
            let asked = hidden.iter().zip(&compared).filter(|(h, _)| h.planned || !planned_only);
            asked.filter_map(|(_, compared)| *compared).reduce(Compared::with)
        };
        Self {
            case: truth.case,
            tier: truth.tier,
            hidden: hidden.iter().enumerate().map(|(k, h)| sought(h, naming.named_as(k))).collect(),
            size,
            band: size.map(Band::of),
            missing: truth.missing.clone(),
            verdict: said.name(),
            top_1: places.planned(|k| places.is_within(k, 0) && naming.named_as(k).is_some()),
            top_2: places.planned(|k| places.is_within(k, 1)),
            planned_named: places.planned(|k| naming.named_as(k).is_some()),
            all_named: places.every(|h| Demand::of(h.gap) == Demand::Must, |k| naming.named_as(k).is_some()),
            extra,
            probability: places.probability(),
            site: site(truth, said),
            flagged: is_flagged(said),
            alarm: shows_nothing(truth).then(|| alarm(truth.tier, extra, said)),
            named,
            gap_before: said.gap()[0],
            closed: has_causes.then_some(said.closed()[0]),
            predicted: has_causes.then_some(said.closed()[1]),
            parameter_error: errors(true).map(|compared| compared.error),
            covered: errors(false).map(|compared| compared.covered as f64 / compared.of as f64),
            statements: statements(&hidden, &truth.before, said),
            seconds: committed.seconds,
            story: story(&hidden, truth, said),
        }
    }

    /// Whether the case came out as it should.
    pub fn is_right(&self) -> bool {
        let is_clean = self.extra == 0 && self.verdict != REFUSED;
        if self.tier == Tier::Outside {
            return self.flagged || (is_clean && self.size.is_some_and(|size| size < FLOOR));
        }
        if let Some(alarm) = self.alarm {
            return alarm == Alarm::Quiet;
        }
        let mut asked = self.hidden.iter().filter(|h| h.planned && h.demand == Demand::Must).peekable();
        if asked.peek().is_none() {
            return is_clean;
        }
        match self.tier {
            Tier::Change => self.top_1 == Some(true) && is_clean,
            Tier::Pair | Tier::Triple => asked.all(|h| h.named_as.is_some()),
            _ => self.top_1 == Some(true),
        }
    }

    /// Extra names with a probability of 0.9 or more in a verdict `cause`: the worst that a verdict can be.
    pub fn confident_wrong(&self) -> impl Iterator<Item = &Named> {
        let is_cause = self.verdict == Verdict::Cause.name();
        let is_wrong = |name: &&Named| name.standing == Standing::Extra && name.probability >= CONFIDENT;
        self.named.iter().filter(is_wrong).filter(move |_| is_cause)
    }

    /// Whether nobody could tell a planned effect of 1 σ or more from another one.
    pub fn has_equals(&self) -> bool {
        let mut shown = self.hidden.iter().filter(|h| h.planned && h.demand != Demand::NeedNot);
        self.planned_named.is_some() && shown.any(|h| !h.equals.is_empty())
    }

    /// Whether every planned effect of 1 σ or more is named by its own name or an equal's, not by a group.
    pub fn named_itself_or_equal(&self) -> bool {
        let shown = self.hidden.iter().filter(|h| h.planned && h.demand != Demand::NeedNot);
        shown.into_iter().all(|h| matches!(h.named_as, Some(Standing::Itself | Standing::Equal)))
    }

    /// How bad a wrong case is, from 0: the less probable the truth and the more extra names, the worse.
    pub fn badness(&self) -> f64 {
        self.probability.map_or(0.5, |probability| 1.0 - probability) + 0.1 * self.extra as f64
    }
}

/// Hidden effects in the order in which names are given to them.
fn sorted(effects: &[HiddenEffect]) -> Vec<&HiddenEffect> {
    let mut hidden: Vec<&HiddenEffect> = effects.iter().collect();
    let key = |h: &HiddenEffect| (Demand::of(h.gap), !h.planned);
    hidden.sort_by(|a, b| key(a).cmp(&key(b)).then(b.gap.total_cmp(&a.gap)));
    hidden
}

fn sought(hidden: &HiddenEffect, named_as: Option<Standing>) -> Sought {
    Sought {
        effect: hidden.effect.name(),
        planned: hidden.planned,
        gap: hidden.gap,
        demand: Demand::of(hidden.gap),
        equals: hidden.equals.iter().map(|equal| equal.name()).collect(),
        named_as,
    }
}

fn named(naming: &Naming) -> Vec<Named> {
    let one = |(cause, standing): (&crate::diagnose::verdict::Cause, Standing)| Named {
        effect: cause.effect.clone(),
        probability: cause.probability,
        standing,
    };
    naming.causes().map(one).collect()
}

fn size(truth: &TrueCase) -> Option<f64> {
    let planned = truth.effects.iter().filter(|h| h.planned).map(|h| h.gap).reduce(f64::min);
    planned.or((truth.tier == Tier::Outside).then_some(truth.gap))
}

/// Whether nothing that is hidden makes 1 σ.
fn shows_nothing(truth: &TrueCase) -> bool {
    let outside = size(truth).filter(|_| truth.tier == Tier::Outside);
    let gaps = truth.effects.iter().chain(&truth.before).map(|h| h.gap).chain(outside);
    gaps.into_iter().all(|gap| gap < FLOOR)
}

fn is_flagged(said: &Said) -> bool {
    matches!(said.verdict(), Some(Verdict::Unknown | Verdict::Undecided))
}

/// What came of a case in which nothing shows. In the tier outside, `unknown` and `undecided` are right names.
fn alarm(tier: Tier, extra: usize, said: &Said) -> Alarm {
    if tier == Tier::Outside && is_flagged(said) {
        Alarm::Quiet
    } else if extra > 0 {
        Alarm::FalseName
    } else if said.verdict() != Some(Verdict::NoGap) && said.causes().is_empty() {
        Alarm::OtherVerdict
    } else {
        Alarm::Quiet
    }
}

/// The hidden effects of a case at their places.
struct Places<'a> {
    truth: &'a TrueCase,
    hidden: &'a [&'a HiddenEffect],
    naming: &'a Naming<'a>,
    said: &'a Said,
}

impl Places<'_> {
    /// Whether something holds for every effect that is asked for; none where none is.
    fn every(&self, is_asked: impl Fn(&HiddenEffect) -> bool, holds: impl Fn(usize) -> bool) -> Option<bool> {
        let mut asked = self.hidden.iter().enumerate().filter(|(_, h)| is_asked(h)).peekable();
        let is_any = self.truth.tier != Tier::Outside && asked.peek().is_some();
        is_any.then(|| asked.all(|(k, _)| holds(k)))
    }

    /// Whether something holds for every planned effect that shows; none where none does.
    fn planned(&self, holds: impl Fn(usize) -> bool) -> Option<bool> {
        self.every(is_planned_to_show, holds)
    }

    /// Whether at most so many extra names stand before a hidden effect.
    fn is_within(&self, hidden: usize, extra: usize) -> bool {
        let is_answer = self.said.verdict() != Some(Verdict::NoGap);
        is_answer && self.naming.wrong_before(hidden).is_some_and(|wrong| wrong <= extra)
    }

    fn probability(&self) -> Option<f64> {
        let shown: Vec<f64> = self
            .hidden
            .iter()
            .filter(|h| self.truth.tier != Tier::Outside && is_planned_to_show(h))
            .map(|h| probability(h, self.said))
            .collect();
        (!shown.is_empty()).then(|| shown.iter().sum::<f64>() / shown.len() as f64)
    }
}

fn is_planned_to_show(hidden: &HiddenEffect) -> bool {
    hidden.planned && hidden.gap >= FLOOR
}

/// Probability on an effect: its own, its equals', and that of the causes which report one of them as confusable.
fn probability(hidden: &HiddenEffect, said: &Said) -> f64 {
    let reports = |name: &str| {
        let mut causes = said.causes().iter().filter(|cause| cause.effect == name);
        causes.any(|cause| cause.confusable_with.iter().any(|other| hidden.is_called(other)))
    };
    let group = said.effects().iter().filter(|e| hidden.is_called(&e.effect) || reports(&e.effect));
    group.fold(0.0, |sum: f64, e| sum + e.probability).min(1.0)
}

/// Whether the largest share of the gap is put where something hidden lies.
fn site(truth: &TrueCase, said: &Said) -> Option<bool> {
    truth.effects.iter().find(|h| h.gap >= FLOOR)?;
    let largest = said.sites().iter().max_by(|a, b| a.share.total_cmp(&b.share));
    let mut shown = truth.effects.iter().chain(&truth.before).filter(|h| h.gap >= FLOOR);
    Some(largest.is_some_and(|largest| shown.any(|h| h.is_at(&largest.name))))
}
