//! The next experiment as a command and as a sentence.

use super::stage::{payload, payload_path};
use super::{NextExperiment, Plan};
use crate::effect::EffectId;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::units::{Motion, engineering};
use std::collections::BTreeMap;

/// Differences in log-likelihood beyond this are not put into numbers.
const CERTAIN: f64 = 100.0;

/// The command that simulates a plan on the machine as stated.
pub(super) fn command(plan: &Plan, machine: &Machine, settings: &BTreeMap<String, toml::Value>) -> String {
    let file = machine.file();
    let folder = file.parent().filter(|_| file.file_name().is_some_and(|name| name == "machine.toml"));
    let mut words = vec![format!("slideway replay --machine {}", folder.unwrap_or(file).display())];
    let mut settings = settings.clone();
    if let Some(mass) = plan.added_mass {
        settings.insert(payload_path(machine), payload(machine, mass).into());
    }
    words.extend(settings.iter().map(|(key, value)| format!("--set {key}={value}")));
    let cells = plan.cells();
    let last = cells.len().saturating_sub(1);
    // With an equals sign: a stroke the other way begins with a minus.
    let option = |k: usize| if k == last && k > 0 { "--held-out" } else { "--cell" };
    words.extend(cells.iter().enumerate().map(|(k, cell)| format!("{}={cell}", option(k))));
    words.push(format!("--return --dwell {} --out next_experiment", plan.dwell_s));
    words.join(" ")
}

/// What to do and what it tells, in plain words.
pub(super) fn sentence(next: &NextExperiment) -> String {
    let plan = &next.motion;
    let is_linear = plan.motion == Motion::Prismatic;
    let [stroke_unit, feed_unit] = if is_linear { ["m", "m/min"] } else { ["rad", "rad/s"] };
    let stroke = |stroke: &f64| engineering(*stroke, stroke_unit);
    let strokes: Vec<String> = plan.strokes.iter().map(stroke).collect();
    let feed = plan.feeds.first().copied().unwrap_or_default();
    let pause = format!("{} s of standstill after each", plan.dwell_s);
    let motion =
        format!("strokes of {} there and back at {feed} {}, {pause}", strokes.join(" and "), feed_unit);
    let mass = plan.added_mass.map(|mass| {
        let amount = if is_linear { format!("mass of {mass} kg") } else { format!("inertia of {mass} kg·m²") };
        let path = if is_linear { "mass_kg" } else { "inertia_kg_m2" };
        format!("bolt a known {amount} to the moving part (and say so in the runs: set effect.payload.{path}), then ")
    });
    let (named, rivals) = match next.separates.split_first() {
        Some((named, rivals)) => {
            (explanation(named), rivals.iter().map(|r| explanation(r)).collect::<Vec<_>>())
        }
        None => (String::new(), Vec::new()),
    };
    let rivals = rivals.join(", ");
    let nats = next.predicted_separation;
    let odds = if nats > CERTAIN {
        "beyond any doubt".to_owned()
    } else {
        format!("by {nats:.0} in log-likelihood, that is {:.0e} to 1", nats.exp())
    };
    let words = |key: &String| signal_words(key, is_linear);
    // What was added tells; what is left elsewhere is how the rivals come to terms with it.
    let telling = next.signal_to_add.as_slice();
    let telling = if telling.is_empty() { &next.signals[..] } else { telling };
    let tells = telling.iter().map(words).collect::<Vec<_>>().join(" and ");
    let mut text = match &next.signal_to_add {
        None => format!("{}record {motion}", mass.unwrap_or_default()),
        Some(signal) => {
            let others: Vec<String> = next.or_signals.iter().map(|s| format!(" (or {})", words(s))).collect();
            format!(
                "no stroke, feed or payload tells {named} from {rivals} with the signals that are logged; log {} as well{}, \
                 and record {motion}",
                words(signal),
                others.concat()
            )
        }
    };
    text += &format!("; {named} and {rivals} then differ {odds}, in {tells}.");
    if !next.leaves_open.is_empty() {
        let open: Vec<String> = next.leaves_open.iter().map(|r| explanation(r)).collect();
        text += &format!(" It does not tell {named} from {}.", open.join(", "));
    }
    text
}

/// An explanation in words.
fn explanation(effects: &[String]) -> String {
    let phrase =
        |name: &String| EffectId::named(name).map_or(name.clone(), |effect| effect.phrase().to_owned());
    match effects {
        [] => "the twin as it is".to_owned(),
        some => some.iter().map(phrase).collect::<Vec<_>>().join(" with "),
    }
}

fn signal_words(key: &str, is_linear: bool) -> String {
    let motion = if is_linear { Motion::Prismatic } else { Motion::Revolute };
    match Signal::from_key(key).map(|(signal, _)| signal) {
        Some(Signal::LoadPosition) => format!("a second position sensor at the load ({key})"),
        Some(signal) => format!("the {} ({key})", signal.word(motion)),
        None => key.to_owned(),
    }
}
