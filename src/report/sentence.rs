//! The verdict as a sentence, with numbers and units.

use super::changes;
use super::number::{percent, plain, probability, value};
use super::remains::{
    by_calibration, largest, not_examined, only_in_training, remains, uncertain, unexplained_signals,
    worse_calibrated,
};
use super::withheld;
use super::words::{described, listed, name, phrase, times_noise, together};
use crate::diagnose::Verdict;
use crate::diagnose::verdict::{Cause, Diagnosis, Ranked, SignalGap};
use crate::recording::Signal;
use crate::units::Motion;

/// A calibration that moved the gap by this much had a part in the result.
const CALIBRATED: f64 = 0.05;
/// An explanation with this share of the best one's probability is a rival.
const RIVAL: f64 = 0.05;
/// Rivals that are named.
const RIVALS: usize = 4;

/// The verdict in a sentence, with numbers in engineering units; a second one where a gap remains behind the causes.
///
/// In a comparison, the sentence says what changed since the reference recording. Where the verdict was withheld, it says why first.
pub fn sentence(diagnosis: &Diagnosis, motion: Motion) -> String {
    if let Some(why) = &diagnosis.withheld {
        return withheld::sentence(diagnosis, why);
    }
    if let Some(text) = changes::sentence(diagnosis, motion) {
        return text;
    }
    match diagnosis.verdict {
        Verdict::NoGap => no_gap(diagnosis),
        Verdict::Cause => cause(diagnosis, motion),
        Verdict::Undecided => undecided(diagnosis),
        Verdict::Unknown if diagnosis.is_found_in_part() => cause(diagnosis, motion),
        Verdict::Unknown => unknown(diagnosis, motion),
    }
}

fn no_gap(diagnosis: &Diagnosis) -> String {
    let gap = &diagnosis.gap;
    let uncertain = uncertain(diagnosis);
    let after = if uncertain.is_some() { gap.after_predictive } else { gap.after };
    let calibrated = gap.before - after > CALIBRATED && !diagnosis.calibration.is_empty();
    let (when, rest) = if calibrated {
        (
            " once its constants are calibrated inside their tolerances",
            format!("{} → {}", plain(gap.before), times_noise(after)),
        )
    } else {
        ("", times_noise(after))
    };
    let as_fitted = uncertain.unwrap_or_default();
    format!(
        "The twin predicts the unseen runs as well as noise allows{when}: no gap (G = {rest}).{as_fitted}"
    )
}

fn cause(diagnosis: &Diagnosis, motion: Motion) -> String {
    let predicted = position(&diagnosis.gap.signals).map(|signal| prediction(signal, motion));
    let lacks = if diagnosis.causes.iter().all(is_new) { "It lacked" } else { "The machine has" };
    let what = match &diagnosis.causes[..] {
        [] => format!("The gap is {}", times_noise(diagnosis.gap.before)),
        [one] => format!("{lacks} {}: {} of the gap", described(one), percent(one.closes)),
        several => {
            let part = |cause: &Cause| format!("{} ({})", described(cause), percent(cause.closes));
            let parts: Vec<String> = several.iter().map(part).collect();
            let closed = percent(diagnosis.gap.closed);
            format!("{lacks} {}, together {closed} of the gap", parts.join(", and "))
        }
    };
    let predicted = predicted.filter(|_| !diagnosis.causes.is_empty()).unwrap_or_default();
    predicted + &what + "." + &by_calibration(diagnosis) + &remains(diagnosis, motion)
}

/// Whether the twin had nothing of a cause: it is no other value of what the machine file states.
fn is_new(cause: &Cause) -> bool {
    let has_nothing = cause.parameters.values().all(|p| p.twin == 0.0 || !p.twin.is_finite());
    has_nothing && !phrase(&cause.effect).contains("stated")
}

/// "The twin predicts position on unseen runs within 2.90 µm RMS (113 µm before). "
fn prediction(signal: &SignalGap, motion: Motion) -> String {
    let unit = Signal::from_key(&signal.signal).map_or("", |(signal, _)| signal.si_unit(motion));
    format!(
        "The twin predicts {} on unseen runs within {} RMS ({} before). ",
        name(&signal.signal),
        value(signal.rms_after, unit),
        value(signal.rms_before, unit)
    )
}

fn position(signals: &[SignalGap]) -> Option<&SignalGap> {
    let is = |wanted| move |gap: &&SignalGap| Signal::from_key(&gap.signal).is_some_and(|(s, _)| s == wanted);
    signals.iter().find(is(Signal::Position)).or(signals.first())
}

/// The named explanation and those that do without one of its effects, most probable first.
fn rivals(diagnosis: &Diagnosis) -> Vec<&Ranked> {
    let named: Vec<&str> = diagnosis.causes.iter().map(|cause| cause.effect.as_str()).collect();
    let holds = |ranked: &Ranked| named.iter().all(|effect| ranked.effects.iter().any(|e| e == effect));
    let is_named = |ranked: &Ranked| holds(ranked) && ranked.effects.len() == named.len();
    let own = diagnosis.ranking.iter().find(|ranked| is_named(ranked)).or(diagnosis.ranking.first());
    let least = RIVAL * own.map_or(0.0, |ranked| ranked.probability);
    let is_rival = |ranked: &&Ranked| is_named(ranked) || (!holds(ranked) && ranked.probability >= least);
    let rivals: Vec<&Ranked> = diagnosis.ranking.iter().filter(is_rival).collect();
    // Without causes, or a ranking that names them, the first of the ranking are the rivals.
    if rivals.len() > 1 { rivals } else { diagnosis.ranking.iter().collect() }
}

fn undecided(diagnosis: &Diagnosis) -> String {
    let rivals = rivals(diagnosis);
    let some = &rivals[..rivals.len().min(RIVALS)];
    // What all of them hold is said once.
    let shared: Vec<String> = match some {
        [first, rest @ ..] if !rest.is_empty() => {
            let in_all = |effect: &&String| rest.iter().all(|ranked| ranked.effects.contains(*effect));
            first.effects.iter().filter(in_all).cloned().collect()
        }
        _ => Vec::new(),
    };
    let beside = |ranked: &Ranked| -> String {
        let own = ranked.effects.iter().filter(|effect| !shared.contains(effect));
        let own: Vec<String> = own.cloned().collect();
        if own.is_empty() && !shared.is_empty() { "nothing".to_owned() } else { together(&own) }
    };
    let parts: Vec<String> = some
        .iter()
        .map(|ranked| format!("{} ({})", beside(ranked), probability(ranked.probability)))
        .collect();
    let more = match rivals.len() - some.len() {
        0 => String::new(),
        more => format!(" and {more} less probable"),
    };
    let left = some.iter().map(|ranked| ranked.held_out_gap).filter(|gap| gap.is_finite());
    let (least, most) = left.fold((f64::MAX, 0.0), |(a, b): (f64, f64), gap| (a.min(gap), b.max(gap)));
    let shrink = if most == 0.0 {
        String::new()
    } else if plain(least) == plain(most) {
        format!(" Each leaves {}.", times_noise(most))
    } else {
        format!(" They leave {} to {}.", plain(least), times_noise(most))
    };
    let (gap, parts) = (times_noise(diagnosis.gap.before), parts.join(", "));
    if shared.is_empty() {
        return format!(
            "There is a gap of {gap}, but these data cannot tell apart what causes it: {parts}{more}.{shrink}"
        );
    }
    let phrases: Vec<String> = shared.iter().map(|effect| phrase(effect)).collect();
    let have = if phrases.len() == 1 { "has" } else { "have" };
    format!(
        "There is a gap of {gap}. {} {have} a part in every explanation, but these data cannot tell apart what acts \
         beside: {parts}{more}.{shrink}",
        capitalised(&listed(&phrases))
    )
}

fn unknown(diagnosis: &Diagnosis, motion: Motion) -> String {
    let gap = &diagnosis.gap;
    if let Some(text) = only_in_training(diagnosis) {
        return text;
    }
    let mut text =
        format!("A gap of {} remains that no effect of the catalogue explains", times_noise(gap.after));
    let effects: Vec<String> = diagnosis.causes.iter().map(|cause| cause.effect.clone()).collect();
    if !effects.is_empty() {
        text += &format!(
            " ({} closes {} of {})",
            together(&effects),
            percent(gap.closed),
            times_noise(gap.before)
        );
    }
    let open = text + &largest(diagnosis, motion) + "." + &worse_calibrated(diagnosis);
    open + &unexplained_signals(diagnosis) + &not_examined(diagnosis)
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
