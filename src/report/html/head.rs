//! The verdict in a sentence, and the numbers to remember.

use super::unbroken::unbroken;
use super::withheld::above;
use crate::diagnose::{Diagnosis, Verdict};
use crate::report::drive::on_the_drive;
use crate::report::figure::escape;
use crate::report::number::{percent, plain, probability};
use crate::report::sentence;
use crate::report::withheld::rest;
use crate::report::words::phrase;
use crate::units::Motion;

/// A sentence of more letters is set smaller.
const LONG: usize = 190;

/// The verdict in a word.
pub(super) fn word(diagnosis: &Diagnosis) -> &'static str {
    match diagnosis.verdict {
        Verdict::NoGap => "no gap",
        Verdict::Cause => "cause found",
        Verdict::Unknown if diagnosis.withheld.is_some() => "no verdict",
        Verdict::Unknown if diagnosis.is_found_in_part() => "cause found in part",
        Verdict::Undecided => "undecided",
        Verdict::Unknown => "unknown cause",
    }
}

fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoGap => "good",
        Verdict::Cause => "found",
        Verdict::Undecided | Verdict::Unknown => "open",
    }
}

/// The head of a page about a diagnosis.
pub(super) fn head(diagnosis: &Diagnosis, motion: Motion) -> String {
    let note = diagnosis.data.note.as_ref();
    let note =
        note.map_or_else(String::new, |note| format!("<p class=\"note\">Data: {}</p>\n", escape(note)));
    let words = match &diagnosis.withheld {
        Some(_) => rest(diagnosis),
        None => sentence(diagnosis, motion),
    };
    let beside = on_the_drive(diagnosis, motion);
    let beside = match beside.is_empty() {
        true => beside,
        false => format!("<p class=\"drive\">{}</p>\n", escape(&unbroken(&beside))),
    };
    let facts: String = facts(diagnosis)
        .iter()
        .map(|(value, what)| {
            format!(
                "<li><strong>{}</strong><span>{}</span></li>",
                escape(&unbroken(value)),
                escape(&unbroken(what))
            )
        })
        .collect();
    format!(
        "<header>\n<p class=\"machine\">{}<span class=\"badge {}\">{}</span></p>\n{}<h1{}>{}</h1>\n{beside}{note}\
         <ul class=\"facts\">{facts}</ul>\n</header>\n",
        escape(&diagnosis.data.machine),
        class(diagnosis.verdict),
        escape(word(diagnosis)),
        above(diagnosis),
        if words.chars().count() > LONG { " class=\"long\"" } else { "" },
        escape(&unbroken(&words)),
    )
}

/// The head of a page that is no diagnosis.
pub(super) fn plain_head(machine: &str, kind: &str, sentence: &str, note: Option<&str>) -> String {
    let note =
        note.map_or_else(String::new, |note| format!("<p class=\"note\">Data: {}</p>\n", escape(note)));
    format!(
        "<header>\n<p class=\"machine\">{}<span class=\"badge plain\">{}</span></p>\n<h1>{}</h1>\n{note}</header>\n",
        escape(machine),
        escape(kind),
        escape(sentence),
    )
}

fn facts(diagnosis: &Diagnosis) -> Vec<(String, String)> {
    let gap = &diagnosis.gap;
    let mut list = vec![(
        format!("{} → {}", plain(gap.before), plain(gap.after)),
        "gap before and after, in multiples of noise on unseen runs; 1 is what noise alone leaves".to_owned(),
    )];
    if diagnosis.verdict == Verdict::NoGap {
        return list;
    }
    let [from, to] = gap.closed_ci95.map(percent);
    let interval = if from == to { from } else { format!("{from} to {to}") };
    list.push((percent(gap.closed), format!("of the gap closed on unseen runs, 95 % interval {interval}")));
    list.push((percent(gap.predicted_closed), "predicted from the training runs alone".to_owned()));
    for cause in diagnosis.causes.iter().take(3) {
        let what = format!("probability of {}", phrase(&cause.effect));
        list.push((probability(cause.probability), what));
    }
    list.push((percent(diagnosis.unexplained), "of the gap stays unexplained".to_owned()));
    list
}
