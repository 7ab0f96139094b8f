//! Which case hides what: tiers filled up evenly with effects, then shuffled.

use super::seed::Seed;
use super::tier::Tier;
use crate::effect::EffectId;
use crate::recording::Signal;
use rand::RngExt;
use rand::rngs::StdRng;
use std::collections::BTreeSet;

/// One case before anything of it is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// Its tier.
    pub tier: Tier,
    /// The effects to hide, in no order.
    pub effects: Vec<EffectId>,
    /// What to hide instead where these cannot be forged together; none where every effect has its turn.
    pub spare: Vec<Vec<EffectId>>,
    /// Signals not to log.
    pub missing: Vec<Signal>,
    /// What its random numbers are called: its tier and place in it, so that one tier does not depend on others.
    pub purpose: String,
}

/// The signals that the tier of missing signals leaves out, one at a time.
pub const MISSING: [Signal; 3] = [Signal::Current, Signal::ControlEffort, Signal::Velocity];

/// Other pairs or triples tried where one cannot be forged.
const SPARE: usize = 3;

/// Plans tiers of so many cases each (their own number where none is given), from effects that can be forged, on a
/// machine that logs these signals; `equal` tells effects that no data tell apart.
pub fn plan(
    seed: Seed,
    tiers: &[Tier],
    cases: Option<usize>,
    effects: &[EffectId],
    logged: &[Signal],
    equal: &dyn Fn(EffectId, EffectId) -> bool,
) -> Vec<Planned> {
    let missing: Vec<Signal> = MISSING.into_iter().filter(|signal| logged.contains(signal)).collect();
    let mut all = Vec::new();
    for &tier in tiers {
        let mut random = seed.random(&format!("plan {tier}"));
        let sets = sets(tier, effects, equal, &mut random);
        let count = cases.unwrap_or_else(|| tier.cases(effects.len()));
        for k in 0..count {
            let Some(set) = sets.get(k % sets.len().max(1)) else { break };
            let left_out = match tier {
                Tier::Missing => missing.get(k % missing.len().max(1)).copied(),
                _ => None,
            };
            all.push(Planned {
                tier,
                effects: set.clone(),
                spare: spare(&sets, k, count),
                missing: left_out.into_iter().collect(),
                purpose: format!("{tier} {k}"),
            });
        }
    }
    shuffle(&mut all, &mut seed.random("order"));
    all
}

/// Pairs or triples that no case of so many begins with, a few for each.
fn spare(sets: &[Vec<EffectId>], case: usize, count: usize) -> Vec<Vec<EffectId>> {
    let places = (1..=SPARE).map(|k| case + k * count);
    places.filter_map(|k| sets.get(k)).filter(|set| set.len() > 1).cloned().collect()
}

/// The sets of effects that a tier goes through.
fn sets(
    tier: Tier,
    effects: &[EffectId],
    equal: &dyn Fn(EffectId, EffectId) -> bool,
    random: &mut StdRng,
) -> Vec<Vec<EffectId>> {
    let mut sets: Vec<Vec<EffectId>> = match tier.effects() {
        0 => vec![Vec::new()],
        1 => effects.iter().map(|effect| vec![*effect]).collect(),
        2 => pairs(effects, equal),
        _ => triples(effects, equal),
    };
    shuffle(&mut sets, random);
    sets
}

/// Every two effects of which neither is the other, or modifies it.
fn pairs(effects: &[EffectId], equal: &dyn Fn(EffectId, EffectId) -> bool) -> Vec<Vec<EffectId>> {
    // A feature comes with the friction that it modifies anyway.
    let part = |a: EffectId, b: EffectId| a.modifies().contains(&b) || b.modifies().contains(&a);
    let beside = |a: EffectId, b: EffectId| a < b && !part(a, b) && !equal(a, b);
    effects
        .iter()
        .flat_map(|&a| effects.iter().filter(move |&&b| beside(a, b)).map(move |&b| vec![a, b]))
        .collect()
}

/// Every three effects of which each two are a pair.
fn triples(effects: &[EffectId], equal: &dyn Fn(EffectId, EffectId) -> bool) -> Vec<Vec<EffectId>> {
    let pairs = pairs(effects, equal);
    let is_pair: BTreeSet<&[EffectId]> = pairs.iter().map(Vec::as_slice).collect();
    let thirds = |pair: &Vec<EffectId>| {
        let (a, b) = (pair[0], pair[1]);
        let fits = |c: &&EffectId| is_pair.contains(&[a, **c][..]) && is_pair.contains(&[b, **c][..]);
        effects.iter().filter(fits).map(|&c| vec![a, b, c]).collect::<Vec<_>>()
    };
    pairs.iter().flat_map(thirds).collect()
}

fn shuffle<T>(list: &mut [T], random: &mut StdRng) {
    for k in (1..list.len()).rev() {
        list.swap(k, random.random_range(0..=k));
    }
}
