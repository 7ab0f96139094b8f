//! What the named causes leave open, and where that is largest.

use super::number::{percent, value};
use super::place::{banded, named, top};
use super::stretches::seconds;
use super::words::{listed, name, phrase, times_noise, together};
use crate::diagnose::Verdict;
use crate::diagnose::decide::above_noise;
use crate::diagnose::thresholds::{LARGELY, MOST};
use crate::diagnose::verdict::{Diagnosis, Gap, OpenSignal, Stretch, Updated};
use crate::units::Motion;

/// From this gap on, what remains behind the named causes is worth a sentence.
const REMAINS: f64 = 1.5;
/// Probability from which an explanation is told as one of several that explain the rest.
const AMONG_EQUALS: f64 = 0.1;
/// Standard errors beyond which a number of the held-out runs contradicts that of the training runs: 6·10⁻⁵ by chance.
const FARTHEST: f64 = 4.0;

/// What the causes leave open, as a sentence more.
pub(super) fn remains(diagnosis: &Diagnosis, motion: Motion) -> String {
    let left = times_noise(diagnosis.gap.after);
    if let Some(text) = uncertain(diagnosis) {
        return text;
    }
    if let Some(text) = only_in_training(diagnosis) {
        return format!(" {text}");
    }
    match diagnosis.verdict {
        Verdict::Unknown => {
            format!(
                " A gap of {left} remains that no effect of the catalogue explains{}.{}{}",
                largest(diagnosis, motion),
                worse_calibrated(diagnosis),
                not_examined(diagnosis)
            )
        }
        _ if diagnosis.gap.after <= REMAINS => String::new(),
        _ => equals_beside(diagnosis).unwrap_or_else(|| format!(" A gap of {left} remains unexplained.")),
    }
}

/// That calibration overfits the training runs: the twin as it is predicts the held-out runs better, where nothing is named.
pub(super) fn worse_calibrated(diagnosis: &Diagnosis) -> String {
    let Gap { before, after, .. } = diagnosis.gap;
    let is_worse = diagnosis.causes.is_empty() && before < LARGELY * after;
    if !is_worse {
        return String::new();
    }
    format!(
        " The twin as it is leaves {}: calibration inside its tolerances overfits the training runs.",
        times_noise(before)
    )
}

/// What would explain the rest, where several effects do that alike beside the causes: none of them is certain, and the rest is small enough to name none.
fn equals_beside(diagnosis: &Diagnosis) -> Option<String> {
    let is_cause = |effect: &String| diagnosis.causes.iter().any(|cause| cause.effect == *effect);
    let beside = diagnosis.ranking.iter().filter_map(|ranked| {
        let more: Vec<String> = ranked.effects.iter().filter(|effect| !is_cause(effect)).cloned().collect();
        let has_all = ranked.effects.len() == diagnosis.causes.len() + more.len();
        let explains = ranked.held_out_gap <= REMAINS && ranked.probability >= AMONG_EQUALS;
        let is_one = has_all && !more.is_empty() && explains;
        is_one.then(|| (together(&more), ranked.held_out_gap))
    });
    let beside: Vec<(String, f64)> = beside.collect();
    let left = beside.iter().map(|(_, left)| *left).fold(0.0, f64::max);
    if beside.len() < 2 {
        return None;
    }
    let names: Vec<String> = beside.iter().map(|(name, _)| name.clone()).collect();
    Some(format!(
        " A gap of {} remains. It would be explained by {} (to {}); these runs do not tell which.",
        times_noise(diagnosis.gap.after),
        names.join(" or by "),
        times_noise(left)
    ))
}

/// Effects that the machine could have and that were not looked at: that no effect explains the gap is not said of them.
pub(super) fn not_examined(diagnosis: &Diagnosis) -> String {
    let open = diagnosis.not_examined.iter().filter(|not| not.could_act());
    let phrases: Vec<String> = open.map(|not| phrase(&not.effect)).collect();
    if phrases.is_empty() { String::new() } else { format!(" Not examined: {}.", listed(&phrases)) }
}

/// What calibration alone leaves, where it closes most of the gap: what the causes close with it is not all to their credit.
pub(super) fn by_calibration(diagnosis: &Diagnosis) -> String {
    let calibrated = diagnosis.ranking.iter().find(|ranked| ranked.effects.is_empty());
    let alone = calibrated.map(|ranked| ranked.held_out_gap).filter(|_| !diagnosis.calibration.is_empty());
    let open = |gap: &f64| above_noise(*gap) / above_noise(diagnosis.gap.before);
    alone.filter(|gap| open(gap) <= 1.0 - LARGELY).map_or_else(String::new, |gap| {
        format!(" Calibration inside its tolerances alone leaves {}.", times_noise(gap))
    })
}

/// Which signals the causes named do not explain; without causes, which alone leave more than noise.
pub(super) fn unexplained_signals(diagnosis: &Diagnosis) -> String {
    let left = |of: &OpenSignal| {
        let gap = diagnosis.gap.signals.iter().find(|gap| gap.signal == of.signal && gap.noise > 0.0)?;
        Some(gap.rms_after / gap.noise)
    };
    let of = |of: &OpenSignal| match of.open {
        _ if diagnosis.causes.is_empty() => left(of).map_or_else(String::new, |left| {
            format!(" The {} alone leaves {}.", name(&of.signal), times_noise(left))
        }),
        open if open < 1.0 => format!(" Of the {}'s gap {} stays.", name(&of.signal), percent(open)),
        _ => format!(" The {} is predicted no better.", name(&of.signal)),
    };
    diagnosis.gap.unexplained_signals.iter().map(of).collect()
}

/// That the training runs alone are not explained, and where in them most is left; none where it is not so.
pub(super) fn only_in_training(diagnosis: &Diagnosis) -> Option<String> {
    let Gap { before, after, after_predictive, training, .. } = &diagnosis.gap;
    // Numbers that were fitted to what the held-out runs do not have may predict these badly.
    let decisive = if *after_predictive > 0.0 { after_predictive.min(*after) } else { *after };
    let held_out = if diagnosis.causes.is_empty() { decisive.min(*before) } else { decisive };
    let place = |worst: &Stretch| {
        let [from, to] = [worst.from_s, worst.to_s].map(seconds);
        format!(", largest in `{}` from {from} to {to} s ({})", worst.run, times_noise(worst.gap))
    };
    training.is_only_here.then(|| {
        let mut text = format!(
            "A gap of {} remains in the training runs{}. The held-out runs do not show it ({}).",
            times_noise(training.gap),
            training.worst.as_ref().map(place).unwrap_or_default(),
            times_noise(held_out)
        );
        if !training.explained_by.is_empty() {
            text += &format!(
                " It would be explained by {}, which no held-out run can judge.",
                training.explained_by.iter().map(|set| together(set)).collect::<Vec<_>>().join(" or ")
            );
        }
        text
    })
}

/// That the training runs leave the numbers uncertain, where those with the held-out runs close most of what the fit leaves and are near those of the fit.
pub(super) fn uncertain(diagnosis: &Diagnosis) -> Option<String> {
    let Gap { after, after_predictive: within, updated, .. } = &diagnosis.gap;
    let is_of_numbers = diagnosis.verdict != Verdict::Unknown
        && *after > REMAINS
        && *within > 0.0
        && within.powi(2) - 1.0 < (1.0 - MOST) * (after.powi(2) - 1.0)
        && updated.iter().all(|number| number.standard_errors <= FARTHEST);
    is_of_numbers.then(|| {
        let number = updated.iter().find_map(moved).unwrap_or_default();
        format!(
            " As fitted, {} remains: the training runs leave numbers uncertain that the held-out runs tell. With both kinds of run{number} {} remains. \
             Record another run like the held-out ones, and train on all of these.",
            times_noise(*after),
            times_noise(*within),
        )
    })
}

/// ", the period of force ripple is 44.2 mm, not 38.0 mm, and"; none of a sine or cosine, which tells an engineer nothing by itself, and of one that is
/// written alike.
fn moved(number: &Updated) -> Option<String> {
    let (effect, key) = number.path.strip_prefix("effect.")?.split_once('.')?;
    let [is, was] = [number.updated, number.fitted].map(|v| value(v, &number.unit));
    let tells = !key.contains("sine") && is != was;
    tells.then(|| format!(", the {} of {} is {is}, not {was}, and", name(key), phrase(effect)))
}

/// "; it is largest in phase “reverse” (41 %)": where what is left lies; empty where nothing is known of that.
pub(super) fn largest(diagnosis: &Diagnosis, motion: Motion) -> String {
    let place = diagnosis.left.as_ref().map_or(&diagnosis.place, |left| &left.place);
    let position = if motion == Motion::Prismatic { "m" } else { "rad" };
    let largest = [
        ("in phase “", top(named(&place.phase)), "”"),
        ("at ", top(banded(&place.frequency_hz, "Hz")), ""),
        ("at positions ", top(banded(&place.position, position)), ""),
    ];
    let parts: Vec<String> = largest
        .into_iter()
        .filter_map(|(before, entries, after)| {
            entries.first().map(|(label, share)| format!("{before}{label}{after} ({})", percent(*share)))
        })
        .collect();
    if parts.is_empty() { String::new() } else { format!("; it is largest {}", listed(&parts)) }
}
