//! The ladder of a feed-forward as a report.

use super::number::{NONE, value};
use super::sheet::{Section, Sheet};
use crate::machine::Machine;
use crate::recording::Recording;
use crate::replay::Feedforward;
use crate::replay::feedforward::Direction;
use crate::replay::ladder::{Ladder, MOVING, Rung, TERMS};
use crate::units::Motion;

/// What each term of a feed-forward leaves to the feedback, predicted and measured.
pub fn ladder(found: &Ladder, machine: &Machine, recording: &Recording, runs: usize) -> Sheet {
    let effort = Effort::of(machine);
    let heads =
        ["fed forward", "own number", "predicted", "and unexplained", "as stated", "measured", "runs"];
    let rows = found.rungs.iter().map(|rung| row(rung, found, machine.motion(), &effort)).collect();
    let mut section = Section::new("Feedback, RMS").table_with(&heads, rows, 2).remark(format!(
        "predicted: the twin with the machine's own numbers along the references of all runs; as stated: with the numbers that the \
         runs state, along theirs; measured: their logged effort. {} Samples count where the reference is faster than {:.0} % of its \
         top speed in the run.",
        unexplained(found, &effort),
        100.0 * MOVING
    ));
    if found.own.direction == Direction::Measured {
        section = section.remark("The Coulomb part goes by the measured velocity, as runs state it.");
    }
    let name = &machine.description().name;
    let mut sentence = format!("What a feed-forward leaves to the feedback of {name}, term by term.");
    if found.own.viscous_n_s_per_m == 0.0 && found.own.coulomb_n == 0.0 {
        sentence += " The machine file has no friction, so nothing is predicted of its terms: diagnose first, and name the machine \
                     that --write-machine writes.";
    }
    Sheet {
        subject: recording.path.display().to_string(),
        kind: "feed-forward ladder",
        sentence: format!("{sentence} {runs} of {} runs.", recording.runs().len()),
        note: recording.note.clone(),
        motion: machine.motion(),
        sections: vec![section],
    }
}

/// How an effort is shown: as force or torque where it is one in the steady state, else in V.
struct Effort {
    per_volt: f64,
    unit: &'static str,
}

impl Effort {
    fn of(machine: &Machine) -> Self {
        let constants = machine.constants();
        if constants.has_voltage_fed_winding {
            return Self { per_volt: 1.0, unit: "V" };
        }
        let unit = if machine.motion() == Motion::Prismatic { "N" } else { "N·m" };
        Self { per_volt: constants.force_per_volt(), unit }
    }

    fn text(&self, effort_v: f64) -> String {
        value(self.per_volt * effort_v, self.unit)
    }
}

fn unexplained(found: &Ladder, effort: &Effort) -> String {
    found.unexplained_v.map_or_else(
        || "No effort was logged, so nothing is known of what the twin leaves unexplained.".to_owned(),
        |left| {
            format!("Unexplained: {} of the runs with the fewest terms, added as squares.", effort.text(left))
        },
    )
}

fn row(rung: &Rung, found: &Ladder, motion: Motion, effort: &Effort) -> Vec<String> {
    let none = || NONE.to_owned();
    let measured = rung.measured.as_ref();
    let with = found.unexplained_v.map(|left| effort.text(rung.predicted_v.hypot(left)));
    vec![
        title(rung.terms),
        number(&found.own, rung.terms, motion),
        effort.text(rung.predicted_v),
        with.unwrap_or_else(none),
        measured.map_or_else(none, |m| effort.text(m.as_stated_v)),
        measured.map_or_else(none, |m| effort.text(m.effort_v)),
        measured.map_or_else(none, |m| m.runs.len().to_string()),
    ]
}

/// A rung by the term that it adds; what is no rung by all of its terms.
fn title(terms: [bool; 4]) -> String {
    let fed: Vec<&str> =
        TERMS.into_iter().zip(terms).filter_map(|(name, is_fed)| is_fed.then_some(name)).collect();
    let is_rung = terms.windows(2).all(|pair| pair[0] || !pair[1]);
    match fed.last() {
        None => "none".to_owned(),
        Some(last) if is_rung => format!("+ {last}"),
        Some(_) => fed.join(" and "),
    }
}

/// The machine's number of the term that a rung adds.
fn number(own: &Feedforward, terms: [bool; 4], motion: Motion) -> String {
    let is_rung = terms.windows(2).all(|pair| pair[0] || !pair[1]);
    let units = match motion {
        Motion::Prismatic => ["kg", "N·s/m", "N"],
        Motion::Revolute => ["kg·m²", "N·m·s/rad", "N·m"],
    };
    let values = [own.mass_kg, own.viscous_n_s_per_m, own.coulomb_n];
    match terms.iter().filter(|term| **term).count() {
        count @ 1..=3 if is_rung => value(values[count - 1], units[count - 1]),
        _ => String::new(),
    }
}
