//! From the search to the verdict.

use super::amplitude::{amplitude_of_sum, amplitudes};
use super::candidate::Candidate;
use super::decide::SignalEvidence;
use super::evidence::{Closed, Score, closed};
use super::experiment::Experiment;
use super::fit::Fit;
use super::folds::Folds;
use super::found::Found;
use super::free::Freedom;
use super::harmonic;
use super::hypothesis::EffectSet;
use super::noise::Floor;
use super::parameter::{NORMAL_975, Parameter};
use super::phase::RunPhase;
use super::prior::price;
use super::rivals::{INDISTINCT, better, rivals};
use super::verdict::{
    Calibration, Cause, EffectProbability, FollowingError, Gap, OpenSignal, Ranked, SignalGap,
};
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::twin::Sensing;
use std::collections::BTreeMap;

/// The named causes, most closing first, and the effects that are harmonics of one of them.
pub fn causes(found: &Found, before: &Score, folds: &Folds) -> (Vec<Cause>, Vec<String>) {
    let chosen = &found.candidates[found.chosen];
    let total = closed(before, &chosen.score).value;
    let contributions = contributions(found, before, total);
    let mut causes: Vec<Cause> = chosen
        .effects()
        .iter()
        .map(|&effect| {
            let confusable_with = confusable(found, effect);
            Cause {
                effect: effect.name().to_string(),
                group: effect.group().map(str::to_owned),
                site: effect.site().name().to_string(),
                probability: found.probability_of(effect),
                closes: contributions.get(&effect).copied().unwrap_or(0.0),
                confusable_reason: (!confusable_with.is_empty()).then(|| alike(&confusable_with)),
                confusable_with,
                parameters: parameters(&chosen.fit, effect),
                amplitudes: amplitudes(&chosen.fit, folds, effect),
                phases: Vec::new(),
                harmonics: Vec::new(),
            }
        })
        .collect();
    causes.sort_by(|a, b| b.closes.total_cmp(&a.closes));
    let harmonics = harmonic::fold(&mut causes, &|waves| amplitude_of_sum(&chosen.fit, folds, waves));
    (causes, harmonics)
}

/// Share of the gap that each chosen effect closes: the mean of what it closes alone and what its absence
/// reopens, scaled so that the shares add up to what all close together. For the split each explanation has its numbers where training and held-out runs
/// together have them: a pitch that the training runs leave uncertain is no fault of its effect. What an explanation with another period or frequency closes counts only where
/// both explanations have another one: a wave by itself may stand for another effect. `total` is what all close as they are fitted.
fn contributions(found: &Found, before: &Score, total: f64) -> BTreeMap<EffectId, f64> {
    let chosen = &found.candidates[found.chosen];
    let of = |candidate: &Candidate| closed(before, &candidate.predictive.score).value;
    let all = of(chosen);
    let closes = |set: &EffectSet| {
        let candidate = &found.candidates[found.index(set)?];
        Some((of(candidate), candidate.fit.has_other_period(&chosen.fit)))
    };
    let raw: BTreeMap<EffectId, f64> = chosen
        .effects()
        .iter()
        .map(|&effect| {
            let rest: EffectSet = chosen.effects().iter().filter(|e| **e != effect).copied().collect();
            let alone = closes(&EffectSet::from([effect]));
            let missed = closes(&rest).map(|(without, elsewhere)| (all - without, elsewhere));
            let both: Vec<(f64, bool)> = alone.into_iter().chain(missed).collect();
            let is_like = |(_, elsewhere): &&(f64, bool)| !elsewhere || both.iter().all(|(_, e)| *e);
            let counted: Vec<f64> = both.iter().filter(is_like).map(|(share, _)| share.max(0.0)).collect();
            (effect, counted.iter().sum::<f64>() / counted.len().max(1) as f64)
        })
        .collect();
    let sum: f64 = raw.values().sum();
    raw.into_iter()
        .map(|(e, share)| (e, if sum > 0.0 { total.max(0.0) * share / sum } else { 0.0 }))
        .collect()
}

/// Why explanations with other effects cannot be told apart by how they predict.
fn alike(others: &[String]) -> String {
    format!(
        "Fitted in its place, {} predicts the held-out runs as well: the log-likelihoods differ by less than {INDISTINCT:.0}, which chance can do.",
        others.join(" or ")
    )
}

/// Effects of explanations that predict the held-out runs as well: worse by no more than [`INDISTINCT`], and better by no more
/// than what they cost more.
fn confusable(found: &Found, effect: EffectId) -> Vec<String> {
    let chosen = found.candidates[found.chosen].effects();
    let is_as_good = |candidate: &Candidate, probability: f64| {
        let price = |effects: &EffectSet| price(effects, &found.stated);
        let dearer = (price(candidate.effects()) - price(chosen)).max(0.0);
        better(found, candidate, probability).is_some_and(|b| b > -INDISTINCT && b < dearer + INDISTINCT)
    };
    let mut names: Vec<String> = rivals(found)
        .filter(|(candidate, _)| !candidate.effects().contains(&effect))
        .filter(|(candidate, p)| is_as_good(candidate, *p))
        .flat_map(|(candidate, _)| candidate.effects().difference(chosen).copied())
        .map(|e| e.name().to_string())
        .collect();
    names.sort();
    names.dedup();
    names
}

/// The phase of the machine's vibration in each run, as the run states it or as it suits the run best; none where the machine
/// has no vibration.
///
/// # Errors
/// A setting of a run that the machine does not have.
pub fn phases<'a>(
    machine: &Machine,
    runs: impl IntoIterator<Item = &'a Experiment>,
) -> Result<Vec<RunPhase>> {
    let mut phases = Vec::new();
    for experiment in runs {
        let set = experiment.machine(machine)?;
        let Some(law) = &set.description().effect.external_vibration else { continue };
        let (sine, cosine) = law.phase_rad.sin_cos();
        let run = experiment.run().name().to_owned();
        phases.push(RunPhase { run, phase_rad: sine.atan2(cosine) });
    }
    Ok(phases)
}

fn parameters(fit: &Fit, effect: EffectId) -> BTreeMap<String, Parameter> {
    fit.hypothesis
        .free
        .iter()
        .enumerate()
        .filter(|(_, free)| free.effect == effect && free.freedom == Freedom::Cause)
        .map(|(k, free)| (free.name.to_string(), parameter(fit, k)))
        .collect()
}

/// A number with its interval, which ends where the law ends; that of one that does nothing on these runs is all of its range.
fn parameter(fit: &Fit, k: usize) -> Parameter {
    let (value, half) = (fit.values[k], NORMAL_975 * fit.standard_errors[k]);
    let free = &fit.hypothesis.free[k];
    let is_idle = half == 0.0 && !free.held;
    let own = free.effect.numbers().find(|p| [p.name, p.revolute_name].contains(&free.name));
    let (least, most) = own.map_or((f64::NEG_INFINITY, f64::INFINITY), |own| own.limits);
    let ci95 = match is_idle {
        true => [free.range.0, free.range.1],
        false => [(value - half).max(least), (value + half).min(most)],
    };
    Parameter { value, ci95, unit: free.unit.to_string(), twin: free.neutral }
}

/// Constants that the chosen fit moved inside their tolerance.
pub fn calibration(fit: &Fit) -> Vec<Calibration> {
    let free = fit.hypothesis.free.iter().enumerate();
    free.filter(|(_, free)| free.freedom == Freedom::Calibration)
        .map(|(k, free)| {
            let edge = 1e-3 * (free.range.1 - free.range.0);
            let value = fit.values[k];
            Calibration {
                path: free.path.clone(),
                parameter: parameter(fit, k),
                at_tolerance: value - free.range.0 < edge || free.range.1 - value < edge,
            }
        })
        .collect()
}

/// Probability of every effect looked at, most probable first; `harmonics` of others are none by themselves.
pub fn effects(found: &Found, catalogue: &[EffectId], harmonics: &[String]) -> Vec<EffectProbability> {
    let own = catalogue.iter().filter(|e| harmonics.iter().all(|harmonic| *harmonic != e.name()));
    let mut list: Vec<EffectProbability> = own
        .map(|&e| EffectProbability { effect: e.name().to_string(), probability: found.probability_of(e) })
        .collect();
    list.sort_by(|a, b| b.probability.total_cmp(&a.probability).then(a.effect.cmp(&b.effect)));
    list
}

/// Every explanation looked at, most probable first.
pub fn ranking(found: &Found) -> Vec<Ranked> {
    let pairs = found.candidates.iter().zip(&found.posterior);
    let mut list: Vec<Ranked> =
        pairs.map(|(candidate, &probability)| ranked(candidate, probability)).collect();
    list.sort_by(|a, b| {
        b.probability.total_cmp(&a.probability).then(a.held_out_gap.total_cmp(&b.held_out_gap))
    });
    list
}

/// Better explanations whose gain is too small to name beside this gap, best first.
pub fn refinements(found: &Found, before: &Score) -> Vec<Ranked> {
    let is_detail = |k: &usize| !found.is_settled && found.is_refinement(*k, before);
    let indices = (0..found.candidates.len()).filter(is_detail);
    let mut list: Vec<Ranked> = indices.map(|k| ranked(&found.candidates[k], found.posterior[k])).collect();
    list.sort_by(|a, b| {
        a.held_out_gap.total_cmp(&b.held_out_gap).then(a.effects.len().cmp(&b.effects.len()))
    });
    list.truncate(3);
    list
}

fn ranked(candidate: &Candidate, probability: f64) -> Ranked {
    Ranked {
        effects: candidate.effects().iter().map(|e| e.name().to_string()).collect(),
        probability,
        held_out_gap: candidate.score.gap(),
    }
}

/// The gap of the chosen explanation, with the signals for which alone it is not explained.
pub fn with_open_signals(gap: Gap, found: &Found, before: &Score, machine: &Machine) -> Gap {
    let evidence = found.evidence(found.chosen, before, gap.noise_is_measured);
    let open = |of: SignalEvidence| OpenSignal {
        signal: of.signal.key(machine.motion()).to_string(),
        open: 1.0 - of.closed,
    };
    let unexplained_signals = evidence.deciding_signals(&found.limits).into_iter().map(open).collect();
    Gap { unexplained_signals, ..gap }
}

/// By how much the machine is off its reference in these runs.
pub fn following_error(runs: &[Experiment]) -> Option<FollowingError> {
    let pairs = runs.iter().filter_map(|experiment| {
        let run = experiment.run();
        run.signal(Signal::PositionReference).zip(run.signal(Signal::Position))
    });
    let samples =
        pairs.flat_map(|(reference, position)| reference.iter().copied().zip(position.iter().copied()));
    FollowingError::of(samples)
}

/// Gap before and after, signal by signal.
///
/// # Errors
/// Whatever a replay refuses.
pub fn gap(
    machines: [&Machine; 2],
    scores: [&Score; 2],
    (closed_beside_calibration, predicted_closed): (f64, f64),
    held_out: &[Experiment],
    floor: &Floor,
) -> Result<Gap> {
    let Closed { value, ci95 } = closed(scores[0], scores[1]);
    let before = statistics(machines[0], held_out)?;
    let after = statistics(machines[1], held_out)?;
    let signals = before
        .into_iter()
        .map(|(signal, b)| {
            let a = after.get(&signal).copied().unwrap_or_default();
            SignalGap {
                signal: signal.key(machines[0].motion()).to_string(),
                rms_before: b.rms,
                rms_after: a.rms,
                noise: floor.root_mean_square(signal, held_out),
                noise_source: floor.source(signal),
                mae_before: b.mae,
                mae_after: a.mae,
                peak_before: b.peak,
                peak_after: a.peak,
                r2_before: b.r2,
                r2_after: a.r2,
            }
        })
        .collect();
    Ok(Gap {
        before: scores[0].gap(),
        after: scores[1].gap(),
        floor: 1.0,
        closed: value,
        closed_ci95: [ci95.0, ci95.1],
        closed_beside_calibration,
        noise_is_measured: floor.is_measured(),
        predicted_closed,
        signals,
        ..Gap::default()
    })
}

#[derive(Debug, Clone, Copy, Default)]
struct Statistics {
    rms: f64,
    mae: f64,
    peak: f64,
    r2: f64,
}

fn statistics(machine: &Machine, experiments: &[Experiment]) -> Result<BTreeMap<Signal, Statistics>> {
    let mut pairs: BTreeMap<Signal, Vec<(f64, f64)>> = BTreeMap::new();
    for experiment in experiments {
        let predicted = experiment.predict(machine, Sensing::Perfect)?;
        for &signal in experiment.signals() {
            let measured = experiment.run().signal(signal);
            let Some((measured, predicted)) = measured.zip(predicted.signal(signal)) else { continue };
            let both = measured.iter().copied().zip(predicted.iter().copied());
            pairs.entry(signal).or_default().extend(both);
        }
    }
    Ok(pairs.into_iter().map(|(signal, pairs)| (signal, Statistics::of(&pairs))).collect())
}

impl Statistics {
    fn of(pairs: &[(f64, f64)]) -> Self {
        let count = pairs.len() as f64;
        let mean = pairs.iter().map(|(m, _)| m).sum::<f64>() / count;
        let squares: f64 = pairs.iter().map(|(m, p)| (m - p).powi(2)).sum();
        let spread: f64 = pairs.iter().map(|(m, _)| (m - mean).powi(2)).sum();
        Self {
            rms: (squares / count).sqrt(),
            mae: pairs.iter().map(|(m, p)| (m - p).abs()).sum::<f64>() / count,
            peak: pairs.iter().fold(0.0, |peak, (m, p)| peak.max((m - p).abs())),
            r2: if spread > 0.0 { 1.0 - squares / spread } else { 0.0 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::found::tests::{COULOMB, candidate, found};

    /// Friction takes 100² to 5², and a wave of 20 µm beside it to noise. Alone a wave closes 80 %, at a period of 30 mm: that is not the one which was found.
    #[test]
    fn exact_a_wave_of_another_period_says_nothing_of_what_the_found_one_closes() {
        let wave = EffectId::EncoderPeriodicError;
        let of_period = |effects: &[EffectId], period: f64, left: f64| {
            let mut candidate = candidate(effects, 1.0, left);
            let free = &mut candidate.fit.hypothesis.free;
            if let Some(k) = free.iter().position(|free| free.effect == wave) {
                (free[k].name, candidate.fit.values[k]) = ("period_m", period);
            }
            candidate
        };
        let share = |alone: f64| {
            let all = vec![
                candidate(&[], 0.0, 1e4),
                candidate(&[COULOMB], 1.0, 25.0),
                of_period(&[wave], alone, 2000.0),
                of_period(&[COULOMB, wave], 2.0, 1.0),
            ];
            contributions(&found(all, 3), &Score::even(1e4), 1.0)[&wave]
        };
        let closes = |left: f64| 1.0 - (left - 1.0) / (1e4 - 1.0);
        let missed = 1.0 - closes(25.0);
        assert!((share(3.0) - missed / (missed + closes(25.0))).abs() < 1e-9, "{}", share(3.0));
        let (of_wave, of_friction) = (closes(2000.0) + missed, closes(25.0) + 1.0 - closes(2000.0));
        assert!((share(2.0) - of_wave / (of_wave + of_friction)).abs() < 1e-9, "{}", share(2.0));
    }

    /// Friction of 0.5 N with a standard error of as much is not negative, and a share is between 0 and 1.
    #[test]
    fn exact_an_interval_ends_where_the_law_ends() {
        let interval = |effect: EffectId, name: &'static str, value: f64, error: f64| {
            let mut fit = candidate(&[effect], value, 1.0).fit;
            fit.hypothesis.free[0].name = name;
            fit.standard_errors = vec![error];
            parameter(&fit, 0).ci95
        };
        assert_eq!(interval(COULOMB, "force_n", 0.5, 0.5)[0], 0.0);
        assert_eq!(interval(EffectId::Backlash, "carried_share", 0.5, 0.9), [0.0, 1.0]);
        let inside = interval(COULOMB, "force_n", 2.0, 0.5);
        assert!(
            (inside[0] - (2.0 - 0.5 * NORMAL_975)).abs() < 1e-12
                && (inside[1] - (2.0 + 0.5 * NORMAL_975)).abs() < 1e-12
        );
    }
}
