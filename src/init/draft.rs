//! The first machine file: every number with its mark.

use std::fmt::Write as _;

use super::item::{Item, Mark, digits, interval, toml_number};
use super::law::LawFound;
use super::motor::{Drive, drive};
use super::names::{Lack, Names};
use super::{Findings, Sheet, delay, urdf};
use crate::controller::Controller;
use crate::controller::regression::ControllerGains;
use crate::identify::least_squares::Estimate;
use crate::recording::{Recording, Signal};
use crate::sensor::VelocityEstimate;
use crate::solid::{Solid, movable_joints};
use crate::units::Motion;

/// The travel that the log shows is taken this much further on each side where none is stated.
const FURTHER: f64 = 0.25;
/// A delay within so many of its standard errors of zero is none.
const DELAY_ERRORS: f64 = 2.0;
/// Name of the URDF that is written.
pub const URDF: &str = "axis.urdf";

/// A machine as log and sheet tell it.
#[derive(Debug, Clone)]
pub struct Draft {
    /// Lines of the machine file, in its order.
    pub items: Vec<Item>,
    /// What a diagnosis cannot do without and nobody has told; with any of these nothing can be written.
    pub lacks: Vec<Lack>,
    /// What is to be said beside.
    pub notes: Vec<String>,
    /// Coulomb friction as the force balance has it: not in the machine file.
    pub coulomb: Option<Item>,
    /// Text of the URDF, where one is made.
    pub urdf: Option<String>,
}

impl Draft {
    /// Says that the sample period was stated, as the log has no time.
    pub fn state_period(&mut self) {
        for item in self.items.iter_mut().filter(|item| item.key == "sample_period_s") {
            item.mark = Mark::Assumed;
            item.words = "stated, --sample-period".to_owned();
        }
    }

    /// What is missing where a log has no time.
    pub fn period_lack() -> Lack {
        Lack {
            flag: "--sample-period",
            unit: "s",
            why: "time between two samples in s; the log has no time column".to_owned(),
        }
    }

    /// Puts log and sheet together; `solid` is the URDF of the sheet.
    pub fn of(recording: &Recording, found: &Findings, sheet: &Sheet, solid: Option<&Solid>) -> Self {
        let names = Names::of(recording.motion());
        let has = |signal: Signal| recording.runs().iter().all(|run| run.signal(signal).is_some());
        let of_urdf = solid.map(Solid::moving_inertia_along_joint);
        let drive = drive(sheet, found, of_urdf, &has, &names);
        let mut draft = Self {
            items: head(recording, sheet, solid),
            lacks: drive.lacks.clone(),
            notes: found.silent.clone(),
            coulomb: None,
            urdf: None,
        };
        let stroke = draft.solid(recording.motion(), found, sheet, solid, &drive, &names);
        draft.control(found, recording.sample_period_s(), &names);
        draft.amplifier(found, sheet, drive.delay.as_ref());
        draft.items.extend(drive.items.iter().cloned());
        draft.friction(&drive, &names);
        draft.sensors(found, &names);
        draft.notes.extend(drive.notes.iter().cloned());
        if solid.is_none()
            && let Some((mass, _, words)) = &drive.mass
        {
            let words = format!("Moving {} {}: {words}.", digits(*mass, 1e-5 * mass), names.mass_unit);
            draft.urdf = Some(urdf::one_body(recording.motion(), *mass, stroke, &words));
        }
        draft
    }

    /// Mass and travel: what stands in the URDF.
    fn solid(
        &mut self,
        motion: Motion,
        found: &Findings,
        sheet: &Sheet,
        solid: Option<&Solid>,
        drive: &Drive,
        names: &Names,
    ) -> Option<[f64; 2]> {
        let key = if motion == Motion::Prismatic { "mass" } else { "inertia" };
        self.items.push(match &drive.mass {
            Some((_, Some(found), words)) => Item::measured(URDF, key, names.mass_unit, found).and(words),
            Some((mass, None, words)) => {
                Item::assumed(URDF, key, names.mass_unit, toml_number(*mass), words.clone())
            }
            None => Item::missing(URDF, key, names.mass_unit, names.mass),
        });
        let [low, high] = found.range;
        let further = FURTHER * (high - low);
        let (stroke, words) = match (solid, sheet.stroke) {
            (Some(_), _) => return None,
            (None, Some(stroke)) => (stroke, "stated, --stroke".to_owned()),
            (None, None) => {
                let words = format!(
                    "the travel of the log and {:.0} % more on each side; --stroke FROM..TO",
                    100.0 * FURTHER
                );
                (
                    [low - further, high + further]
                        .map(|end| digits(end, further / 10.0).parse().unwrap_or(end)),
                    words,
                )
            }
        };
        let text = format!("{}..{}", toml_number(stroke[0]), toml_number(stroke[1]));
        self.items.push(Item::assumed(URDF, "limit", names.position_unit, text, words));
        Some(stroke)
    }

    fn control(&mut self, found: &Findings, period_s: f64, names: &Names) {
        let found = match &found.law {
            LawFound::Law(found) => found,
            LawFound::None(why) => {
                let words = format!("{why}; without it plant and drive are told apart, the loop is not");
                self.items.push(Item::missing("controller", "law", "", words));
                return;
            }
        };
        if found.reference_delay > 0 {
            let delay = delay::within_half_a_period(found.reference_delay as f64 * period_s, period_s);
            self.items.push(
                Item::measured("reference", "delay_s", "s", &delay).and("the law acts on older references"),
            );
        }
        let explained =
            digits(100.0 * found.gains.explained, 100.0 * (1.0 - found.gains.explained).max(1e-9));
        let word = match &found.controller {
            Controller::Pdf(_) => "\"pdf\"",
            Controller::Cascade(_) => "\"cascade\"",
            Controller::Pd(_) => "\"p\"",
        };
        let words = format!("{}: explains {explained} % of the effort", found.form.name());
        let law = Item {
            table: "controller",
            key: "law",
            value: Some(word.to_owned()),
            unit: "",
            mark: Mark::Measured,
            words,
        };
        self.items.push(law);
        self.gains(&found.controller, &found.gains, names);
    }

    /// The gains of a law as lines.
    fn gains(&mut self, controller: &Controller, gains: &ControllerGains, names: &Names) {
        let taken =
            |key: &'static str, value: &str, words: &str| Item::assumed("controller", key, "", value, words);
        if let Controller::Pdf(_) = controller {
            let words = "only register times gain shows: the register is taken as 1";
            self.items.push(taken("integral", "1", words));
            self.items.push(taken("proportional", "1", words));
            self.items.push(taken("velocity_units_per_si", "1.0", "the gains are in V per m/s or rad/s"));
        }
        for gain in &gains.gains {
            let key = match gain.key {
                "velocity_gain_v_s_per_m" => names.velocity_gain,
                "position_gain_v_per_m" => names.position_gain,
                key => key,
            };
            let share = gain.key == "velocity_feedforward";
            let round = [0.0, 1.0].into_iter().find(|round| share && gain.estimate.covers(*round));
            let mut item = Item::measured("controller", key, "", &gain.estimate);
            if let Some(round) = round {
                item.value = Some(format!("{round:?}"));
            }
            self.items.push(item);
        }
    }

    fn amplifier(&mut self, found: &Findings, sheet: &Sheet, delay: Option<&Estimate>) {
        self.items.push(match (sheet.voltage_limit, found.limit) {
            (Some(limit), _) => Item::assumed(
                "amplifier",
                "voltage_limit_v",
                "V",
                toml_number(limit),
                "stated, --voltage-limit",
            ),
            (None, Some(limit)) => {
                let exact = Estimate::exact(limit);
                let words = "the effort is seen to stay there".to_owned();
                Item { words, ..Item::measured("amplifier", "voltage_limit_v", "V", &exact) }
            }
            (None, None) => Item::missing(
                "amplifier",
                "voltage_limit_v",
                "V",
                "the log never reaches it; --voltage-limit V",
            ),
        });
        if let Some(delay) = delay {
            let is_some = delay.value > DELAY_ERRORS * delay.standard_error;
            let mut item = Item::measured("amplifier", "delay_s", "s", delay);
            if !is_some {
                item.value = Some("0.0".to_owned());
            }
            self.items.push(item.and("from effort to what it does"));
        }
    }

    fn friction(&mut self, drive: &Drive, names: &Names) {
        let Some(friction) = &drive.friction else {
            self.items.push(Item::missing(
                "guide",
                names.viscous_key,
                names.viscous_unit,
                "no force balance",
            ));
            return;
        };
        let viscous = &friction.viscous;
        self.items.push(match viscous.ci95[0] > 0.0 {
            true => Item::measured("guide", names.viscous_key, names.viscous_unit, viscous),
            false => {
                let words = format!("none shows ({})", interval(viscous, names.viscous_unit));
                Item::assumed("guide", names.viscous_key, names.viscous_unit, "0.0", words)
            }
        });
        let coulomb =
            Item::measured("effect.coulomb_friction", names.force_key, names.force_unit, &friction.coulomb);
        self.notes.push(format!(
            "dry friction of {} {} ({}) is not put into the machine: the diagnosis is to find and prove it",
            digits(friction.coulomb.value, friction.coulomb.standard_error),
            names.force_unit,
            interval(&friction.coulomb, names.force_unit)
        ));
        let constant = &friction.constant;
        if !constant.covers(0.0) && constant.value.abs() > 0.1 * friction.coulomb.value.abs() {
            self.notes.push(format!(
                "{} {} ({}) are spent alike in both directions: weight of an axis that is not level, a cable, or friction that \
                 differs by direction",
                digits(constant.value, constant.standard_error),
                names.force_unit,
                interval(constant, names.force_unit)
            ));
        }
        self.coulomb = Some(coulomb);
    }

    fn sensors(&mut self, found: &Findings, names: &Names) {
        let of_step = found.step.map_or(0.0, |step| step * step / 12.0);
        let noise = (found.reading_noise.powi(2) - of_step).max(0.0).sqrt();
        self.items.push(match found.step {
            Some(step) => Item {
                words: "least step of the positions, which lie on a grid".to_owned(),
                ..Item::measured("encoder", names.resolution, names.position_unit, &Estimate::exact(step))
            },
            None => Item::assumed(
                "encoder",
                names.resolution,
                names.position_unit,
                "0.0",
                "the positions lie on no grid",
            ),
        });
        let item = |table, key, unit, noise: f64| Item {
            words: "fourth differences, which smooth motion leaves out".to_owned(),
            value: Some(digits(noise, noise / 10.0)),
            ..Item::measured(table, key, unit, &Estimate::exact(noise))
        };
        self.items.push(item("encoder", names.noise, names.position_unit, noise));
        self.items.push(match &found.law {
            LawFound::Law(found) => {
                let words = match (found.is_logged, found.form == super::Form::P) {
                    (_, true) => "the law does not use it".to_owned(),
                    (true, _) => "nearest to the logged velocity, which the law uses".to_owned(),
                    (false, _) => "the law computes with it".to_owned(),
                };
                let mark = if found.form == super::Form::P { Mark::Assumed } else { Mark::Measured };
                let value = Some(inline(&found.velocity));
                Item { table: "encoder", key: "velocity", value, unit: "", mark, words }
            }
            LawFound::None(_) => {
                let plain = VelocityEstimate::SmoothedDifference { time_constant_s: 0.0 };
                Item::assumed("encoder", "velocity", "", inline(&plain), "a plain difference")
            }
        });
        if let Some(noise) = found.current_noise {
            self.items.push(item("current_sensor", "noise_a", "A", noise));
        }
    }

    /// The machine file.
    pub fn text(&self) -> String {
        let mut text = String::from(HEAD);
        let mut table = "";
        for item in self.items.iter().filter(|item| item.table != URDF) {
            if item.table != table {
                table = item.table;
                // A table of which nothing is known is not begun.
                let is_empty = self.items.iter().all(|other| other.table != table || other.value.is_none());
                let _ = if is_empty && table != "amplifier" {
                    write!(text, "\n# [{table}]\n")
                } else {
                    write!(text, "\n[{table}]\n")
                };
            }
            let unit = if item.unit.is_empty() { String::new() } else { format!(", in {}", item.unit) };
            let (mark, words) = (item.mark.word(), &item.words);
            let _ = match &item.value {
                Some(value) if words.is_empty() => writeln!(text, "{} = {value}  # {mark}", item.key),
                Some(value) => writeln!(text, "{} = {value}  # {mark}: {words}", item.key),
                None => writeln!(text, "# {} =  # {mark}{unit}: {words}", item.key),
            };
        }
        for item in self.items.iter().filter(|item| item.table == URDF) {
            let value = item.value.as_deref().unwrap_or("?");
            let line = format!(
                "# {URDF}: {} {value} {}  # {}: {}\n",
                item.key,
                item.unit,
                item.mark.word(),
                item.words
            );
            text.insert_str(HEAD.len(), &line);
        }
        if let Some(coulomb) = &self.coulomb {
            let _ = write!(
                text,
                "\n# Left to the diagnosis to find and prove; to take it as known, uncomment:\n# [{}]\n# {} = {}  # {}: {}\n",
                coulomb.table,
                coulomb.key,
                coulomb.value.as_deref().unwrap_or_default(),
                coulomb.mark.word(),
                coulomb.words
            );
        }
        text
    }
}

const HEAD: &str = "#:schema ./machine.schema.json\n\
    # Written by `slideway init`. Each number is\n\
    #   measured  found in the log, with its 95 % interval where it has one,\n\
    #   assumed   stated by a flag, or by the rule that its comment names,\n\
    #   missing   neither: a comment; write it in when you know it.\n\
    # `slideway kinds` lists what else a machine file can state.\n";

/// What stands at the head of the file.
fn head(recording: &Recording, sheet: &Sheet, solid: Option<&Solid>) -> Vec<Item> {
    let quoted = |text: &str| toml::Value::from(text).to_string();
    let name = sheet.name.clone().unwrap_or_else(|| "axis".to_owned());
    let words = if sheet.name.is_some() { "--name" } else { "--name NAME" };
    let mut items = vec![Item::assumed("", "name", "", quoted(&name), words)];
    let file = solid.and_then(|solid| solid.path.file_name()).map(|name| name.to_string_lossy().into_owned());
    let words = if solid.is_some() { "--urdf" } else { "one body on one joint" };
    items.push(Item::assumed("", "urdf", "", quoted(file.as_deref().unwrap_or(URDF)), words));
    if let Some(solid) = solid {
        items.push(Item::assumed("", "joint", "", quoted(&solid.joint.name), "driven, --joint"));
        let held: Vec<String> = movable_joints(&solid.path)
            .unwrap_or_default()
            .into_iter()
            .map(|joint| joint.name)
            .filter(|name| *name != solid.joint.name)
            .collect();
        if !held.is_empty() {
            items.push(Item::assumed("", "held_joints", "", toml::Value::from(held), "held at zero"));
        }
    }
    let period = recording.sample_period_s();
    let words = "that of the log".to_owned();
    items.push(Item { words, ..Item::measured("", "sample_period_s", "s", &Estimate::exact(period)) });
    items
}

/// A velocity estimate as TOML.
fn inline(estimate: &VelocityEstimate) -> String {
    match estimate {
        VelocityEstimate::SmoothedDifference { time_constant_s } => {
            let time = digits(*time_constant_s, 1e-4 * time_constant_s);
            format!("{{ kind = \"smoothed_difference\", time_constant_s = {time} }}")
        }
        VelocityEstimate::Taps { taps, .. } => format!("{{ kind = \"taps\", taps = {taps:?} }}"),
    }
}
