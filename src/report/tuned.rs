//! A tuning as a report.

use super::figure::{Figure, Map, Panel};
use super::number::{plain, value};
use super::sheet::{Section, Sheet};
use crate::machine::Machine;
use crate::tune::{Criterion, Departure, Given, Kind, Knob, Map as Grid, Outcome, Setting, Tuning};
use crate::units::Motion;

/// Rows of the map's table: the best settings.
const BEST: usize = 10;

/// A tuning: what is chosen, beside the setting as stated and those that were to be beaten; the map; what gives first.
pub fn tuned(machine: &Machine, tuning: &Tuning, outcome: &Outcome) -> Sheet {
    let report = Report { machine, tuning, outcome, motion: machine.motion() };
    Sheet {
        subject: machine.description().name.clone(),
        kind: "tuning",
        sentence: report.sentence(),
        note: Some(
            "simulated: reduced axis in closed loop, perfect sensors; the machine as its file states it"
                .to_owned(),
        ),
        motion: machine.motion(),
        sections: vec![report.settings(), report.strokes(), report.map(), report.robustness()],
    }
}

/// Every setting of the map as CSV: its numbers, the criteria (worst of all strokes, in the units of their keys), the mean
/// settling time, whether the loop is stable and all limits are kept.
pub fn tuning_map(machine: &Machine, tuning: &Tuning, outcome: &Outcome) -> String {
    let motion = machine.motion();
    let keys = tuning.knobs.iter().map(|knob| knob.key.clone());
    let criteria = Criterion::ALL.into_iter().map(|criterion| criterion.key(motion).to_owned());
    let more = ["mean_settling_time_s", "is_stable", "keeps_limits"].map(str::to_owned);
    let head: Vec<String> = keys.chain(criteria).chain(more).collect();
    let row = |setting: &Setting| {
        let criteria = Criterion::ALL.into_iter().zip(setting.worst());
        let criteria = criteria.map(|(criterion, value)| (value / criterion.per_key()).to_string());
        let numbers = setting.values.iter().map(f64::to_string).chain(criteria);
        let mean = setting.mean(Criterion::SettlingTime).to_string();
        let keeps = setting.excess(&tuning.limits) == 0.0;
        numbers.chain([mean, setting.is_stable.to_string(), keeps.to_string()]).collect::<Vec<_>>().join(",")
    };
    let rows = outcome.map.settings.iter().map(row);
    [head.join(",")].into_iter().chain(rows).map(|line| line + "\n").collect()
}

struct Report<'a> {
    machine: &'a Machine,
    tuning: &'a Tuning,
    outcome: &'a Outcome,
    motion: Motion,
}

const HEADS: [&str; 11] = [
    "",
    "overshoot",
    "over feed",
    "reverse",
    "settling",
    "following",
    "thrust",
    "effort V",
    "gain dB",
    "phase °",
    "modulus",
];
/// What the heads stand for.
const COUNTED: &str = "overshoot: of position, % of the stroke; over feed: of velocity, % of the feed; reverse: velocity against \
    the stroke, % of the feed; settling: into 2 % of the stroke after the reference has stopped, ms; following: largest following \
    error; thrust, effort: largest; gain, phase, modulus: margins of the linear loop.";

impl Report<'_> {
    fn name(&self, values: &[f64]) -> String {
        values.iter().map(|value| number(*value)).collect::<Vec<_>>().join("/")
    }

    fn keys(&self) -> String {
        self.tuning.knobs.iter().map(|knob| knob.key.as_str()).collect::<Vec<_>>().join(", ")
    }

    fn sentence(&self) -> String {
        let Outcome { chosen, own, evaluated, .. } = self.outcome;
        let strokes = self.tuning.cells.len();
        let kept = if chosen.excess(&self.tuning.limits) == 0.0 {
            "keeps all limits".to_owned()
        } else {
            format!("comes nearest to the limits and still misses {}", self.missed(chosen))
        };
        let as_stated = if chosen.values == own.values { "; it is the one stated" } else { "" };
        let set: Vec<String> = self
            .tuning
            .knobs
            .iter()
            .zip(&chosen.values)
            .map(|(knob, value)| format!("{} = {}", knob.key, number(*value)))
            .collect();
        let mut sentence = format!(
            "{} {kept} on {strokes} strokes{as_stated}. {evaluated} settings were replayed.",
            set.join(", ")
        );
        if chosen.strokes.iter().any(|stroke| stroke[Criterion::SettlingTime as usize].is_infinite()) {
            sentence += &format!(
                " Some stroke does not settle within the dwell of {} s; --dwell gives more time.",
                number(self.tuning.dwell_s)
            );
        }
        let knobs = self.tuning.knobs.iter().zip(&chosen.values);
        let edge = knobs.filter(|(knob, value)| **value == knob.from || **value == knob.to);
        let edge: Vec<&str> = edge.map(|(knob, _)| knob.key.as_str()).collect();
        if !edge.is_empty() {
            sentence += &format!(
                " It stands at the edge of the range of {}: look further with --vary.",
                edge.join(", ")
            );
        }
        sentence
    }

    /// What a setting misses, in words.
    fn missed(&self, setting: &Setting) -> String {
        let mut words: Vec<&str> = if setting.is_stable { Vec::new() } else { vec!["stability"] };
        words.extend(self.tuning.limits.exceeded(&setting.worst()).into_iter().map(Criterion::name));
        words.join(", ")
    }

    /// Worst figures over all strokes.
    fn settings(&self) -> Section {
        let Outcome { own, marks, chosen, beats, .. } = self.outcome;
        let mut rows = vec![self.row(format!("stated {}", self.name(&own.values)), own)];
        rows.extend(marks.iter().map(|mark| self.row(format!("marked {}", self.name(&mark.values)), mark)));
        rows.push(self.row(format!("chosen {}", self.name(&chosen.values)), chosen));
        rows.push(self.limits());
        let mut section = Section::new("Settings, worst of all strokes").table(&HEADS, rows);
        section = section.remark(format!("Settings in the order of {}. {COUNTED}", self.keys()));
        for (mark, beats) in marks.iter().zip(beats) {
            let says =
                if *beats { "On every stroke at least as good as" } else { "Not on every stroke as good as" };
            section = section.words(format!(
                "{says} {} (within the limits; settling time and following error no larger).",
                self.name(&mark.values)
            ));
        }
        section
    }

    fn row(&self, name: String, setting: &Setting) -> Vec<String> {
        let worst = setting.worst();
        let stable = if setting.is_stable { "" } else { " UNSTABLE" };
        let cells = Criterion::ALL.iter().zip(worst).map(|(criterion, x)| {
            // How far an axis has run away says nothing.
            if !setting.is_stable {
                return "–".to_owned();
            }
            let text = self.cell(*criterion, x);
            // What exceeds its limit is marked.
            if self.tuning.limits.excess(*criterion, x) > 0.0 { format!("{text} !") } else { text }
        });
        [name + stable].into_iter().chain(cells).collect()
    }

    fn limits(&self) -> Vec<String> {
        let cell = |criterion: Criterion| {
            let sign = if criterion.is_margin() { "≥" } else { "≤" };
            let bound = self.tuning.limits.bound(criterion);
            bound.map_or(String::new(), |bound| format!("{sign} {}", self.cell(criterion, bound)))
        };
        ["limit (! if not)".to_owned()].into_iter().chain(Criterion::ALL.map(cell)).collect()
    }

    fn cell(&self, criterion: Criterion, x: f64) -> String {
        let (length, force) = match self.motion {
            Motion::Prismatic => ("m", "N"),
            Motion::Revolute => ("rad", "N·m"),
        };
        match criterion {
            _ if x.is_nan() => "–".to_owned(),
            Criterion::SettlingTime if x.is_infinite() => "never".to_owned(),
            _ if x.is_infinite() => "∞".to_owned(),
            Criterion::PositionOvershoot | Criterion::VelocityOvershoot | Criterion::ReverseVelocity => {
                format!("{:.2}", 100.0 * x)
            }
            Criterion::SettlingTime => format!("{:.0}", 1e3 * x),
            Criterion::FollowingError => value(x, length),
            Criterion::PeakThrust => value(x, force),
            Criterion::PeakEffort | Criterion::ModulusMargin => format!("{x:.2}"),
            Criterion::GainMargin | Criterion::PhaseMargin => format!("{x:.1}"),
        }
    }

    /// Stroke by stroke: as stated, marked, chosen.
    fn strokes(&self) -> Section {
        let Outcome { own, marks, chosen, .. } = self.outcome;
        let settings = || [own].into_iter().chain(marks).chain([chosen]);
        let mut heads = vec!["stroke".to_owned()];
        heads.extend(settings().map(|setting| self.name(&setting.values)));
        let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
        let of = |criterion: Criterion| {
            let rows = self.tuning.cells.iter().enumerate().map(|(k, cell)| {
                let cells = settings().map(|s| self.cell(criterion, s.strokes[k][criterion as usize]));
                [cell.to_string()].into_iter().chain(cells).collect()
            });
            rows.collect::<Vec<Vec<String>>>()
        };
        Section::new("Stroke by stroke")
            .words("Position overshoot, % of the stroke:")
            .table(&heads, of(Criterion::PositionOvershoot))
            .words("Settling time into 2 % of the stroke, ms:")
            .table(&heads, of(Criterion::SettlingTime))
    }

    /// The map as a figure, for two knobs, and the best of its settings.
    fn map(&self) -> Section {
        let limits = &self.tuning.limits;
        let objective = self.tuning.objective.criterion();
        let map = &self.outcome.map;
        let inside = map.settings.iter().filter(|setting| setting.excess(limits) == 0.0);
        let mut best: Vec<&Setting> = inside.collect();
        best.sort_by(|a, b| a.mean(objective).total_cmp(&b.mean(objective)));
        let counts: Vec<String> = map.values.iter().map(|values| values.len().to_string()).collect();
        let mut section = Section::new("Map").words(format!(
            "{} settings; {} keep all limits.{}",
            counts.join(" × "),
            if best.is_empty() { "none".to_owned() } else { best.len().to_string() },
            if best.is_empty() { String::new() } else { format!(" The best by mean {}:", objective.name()) }
        ));
        let wider = |(knob, step): (&Knob, f64)| {
            format!("{} in the place of {} for {}", number(step), number(knob.step), knob.key)
        };
        let widened: Vec<String> = map.widened(&self.tuning.knobs).into_iter().map(wider).collect();
        if !widened.is_empty() {
            let most = Grid::MOST;
            let text =
                format!("Steps of the map, which holds at most {most} settings: {}.", widened.join(", "));
            section = section.words(text);
        }
        let mut heads = HEADS;
        heads[0] = "setting";
        let rows =
            best.iter().take(BEST).map(|setting| self.row(self.name(&setting.values), setting)).collect();
        if !best.is_empty() {
            section = section.table(&heads, rows);
        }
        match &map.values[..] {
            [rows, columns] => section.figure(self.figure(rows, columns)),
            _ => section,
        }
    }

    fn figure(&self, rows: &[f64], columns: &[f64]) -> Figure {
        let Outcome { own, marks, chosen, map, .. } = self.outcome;
        let objective = self.tuning.objective.criterion();
        let (scale, per_si) = match objective {
            Criterion::SettlingTime => ("mean settling time in ms", 1e3),
            Criterion::FollowingError => ("mean following error in µm (µrad)", 1e6),
            _ => ("mean peak thrust in N (N·m)", 1.0),
        };
        let place = |setting: &Setting| [setting.values[1], setting.values[0]];
        let mut named = vec![(place(own), format!("stated {}", self.name(&own.values)))];
        named.extend(marks.iter().map(|mark| (place(mark), self.name(&mark.values))));
        named.push((place(chosen), format!("chosen {}", self.name(&chosen.values))));
        named.dedup_by(|a, b| a.0 == b.0);
        let panel = Panel::Map(Map {
            title: format!("{} over {} strokes", objective.name(), self.tuning.cells.len()),
            x: (self.tuning.knobs[1].key.clone(), columns.to_vec()),
            y: (self.tuning.knobs[0].key.clone(), rows.to_vec()),
            values: map.settings.iter().map(|setting| per_si * setting.mean(objective)).collect(),
            is_inside: map
                .settings
                .iter()
                .map(|setting| setting.excess(&self.tuning.limits) == 0.0)
                .collect(),
            scale: scale.to_owned(),
            marks: named,
        });
        let caption = format!(
            "Settings of {} on {} strokes: shaded where all limits are kept, the darker the larger; grey where not.",
            self.machine.description().name,
            self.tuning.cells.len()
        );
        Figure::new("tuning", caption, vec![panel])
    }

    /// The re-check and what gives first.
    fn robustness(&self) -> Section {
        let Outcome { chosen, robustness, .. } = self.outcome;
        let rows = robustness.rows.iter();
        let rows =
            rows.map(|(departure, settings)| self.row(self.departure(*departure), &settings[0])).collect();
        let mut section =
            Section::new(format!("The chosen setting {} on other machines", self.name(&chosen.values)))
                .table(&HEADS, rows);
        for kind in Kind::ALL {
            if robustness.rows.iter().any(|(departure, _)| departure.kind() == kind) {
                section = section.words(format!("{}: {}", kind.name(), self.given(kind)));
            }
        }
        if self.outcome.marks.is_empty() {
            return section;
        }
        let mut heads = vec!["beyond the limits".to_owned(), format!("chosen {}", self.name(&chosen.values))];
        heads.extend(self.outcome.marks.iter().map(|mark| format!("marked {}", self.name(&mark.values))));
        let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
        let beside = |(departure, settings): &(Departure, Vec<Setting>)| {
            let missed = settings.iter().map(|setting| self.missed(setting));
            let missed = missed.map(|words| if words.is_empty() { "–".to_owned() } else { words });
            [self.departure(*departure)].into_iter().chain(missed).collect()
        };
        section.table_with(&heads, robustness.rows.iter().map(beside).collect(), heads.len())
    }

    /// What gives first for departures of one kind, in words.
    fn given(&self, kind: Kind) -> String {
        let Outcome { chosen, robustness, .. } = self.outcome;
        let already = self.missed(chosen);
        let given = robustness.gives_first(&self.tuning.limits, chosen, kind);
        let kept = if already.is_empty() { "all limits are kept" } else { "no further limit is exceeded" };
        let first = |given: &Given| {
            let mut words: Vec<&str> = if given.is_stable { Vec::new() } else { vec!["stability"] };
            words.extend(given.criteria.iter().map(|criterion| criterion.name()));
            format!("{} at {}", words.join(", "), self.departure(given.departure))
        };
        let said = if given.is_empty() {
            kept.to_owned()
        } else {
            format!("what gives first is {}", given.iter().map(first).collect::<Vec<_>>().join("; "))
        };
        if already.is_empty() { said + "." } else { format!("{said} (missed as stated: {already}).") }
    }

    fn departure(&self, departure: Departure) -> String {
        let percent = |share: f64| format!("{:+.0} %", 100.0 * share);
        let (mass, force) = match self.motion {
            Motion::Prismatic => ("mass", "N"),
            Motion::Revolute => ("inertia", "N·m"),
        };
        match departure {
            Departure::Mass(share) => format!("{mass} {}", percent(share)),
            Departure::Friction(level) => format!("friction {}", value(level, force)),
            Departure::BaseFrequencies(share) => format!("base {}", percent(share)),
        }
    }
}

/// A register as such, a real number to three digits.
fn number(value: f64) -> String {
    if value.fract() == 0.0 { format!("{value:.0}") } else { plain(value) }
}
