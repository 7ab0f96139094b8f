//! The motor of the draft: of the sheet and the log together.

use super::item::{Item, digits, interval, toml_number};
use super::names::{Lack, Names};
use super::{Balance, Findings, Sheet};
use crate::identify::least_squares::Estimate;
use crate::recording::Signal;

/// Relative difference of stated and measured numbers beyond their interval that is worth a word.
const WORTH_TELLING: f64 = 0.03;

/// What moves the axis, and how much of it there is to move.
pub struct Drive {
    /// Its lines.
    pub items: Vec<Item>,
    /// Moving mass or inertia, where it is known, and where from.
    pub mass: Option<(f64, Option<Estimate>, String)>,
    /// The balance in N or N·m.
    pub friction: Option<Balance>,
    /// What is missing.
    pub lacks: Vec<Lack>,
    /// What is to be said.
    pub notes: Vec<String>,
    /// Delay of the amplifier, s.
    pub delay: Option<Estimate>,
}

/// A kind of motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Winding,
    CurrentLoop,
    Direct,
}

/// The drive of an axis; `mass` is that of a URDF.
pub fn drive(
    sheet: &Sheet,
    found: &Findings,
    mass: Option<f64>,
    has: &dyn Fn(Signal) -> bool,
    names: &Names,
) -> Drive {
    let is_stated = sheet.resistance.is_some() && sheet.inductance.is_some();
    let kind = match (has(Signal::Current), has(Signal::ControlEffort)) {
        (true, false) => Kind::CurrentLoop,
        (true, true) => Kind::Winding,
        (false, _) if is_stated && sheet.force_constant.is_some() => Kind::Winding,
        (false, _) => Kind::Direct,
    };
    let mut drive = Drive {
        items: Vec::new(),
        mass: None,
        friction: None,
        lacks: Vec::new(),
        notes: Vec::new(),
        delay: None,
    };
    let channel = if has(Signal::Current) { Signal::Current } else { Signal::ControlEffort };
    let constant = drive.constant(kind, channel, sheet, found, mass, names);
    drive.lines(kind, constant.as_ref(), found, names);
    drive.circuit(kind, sheet, found, names);
    drive.delay = match kind {
        Kind::Winding => found.winding.map(|winding| winding.delay),
        Kind::Direct => found.balance(Signal::ControlEffort).map(|balance| balance.delay),
        Kind::CurrentLoop => None,
    };
    drive
}

/// Force per unit of the channel, and how it is known.
struct Constant {
    value: f64,
    found: Option<Estimate>,
    words: String,
}

impl Drive {
    /// The force constant and the mass: one of them, or the ratio alone.
    fn constant(
        &mut self,
        kind: Kind,
        channel: Signal,
        sheet: &Sheet,
        found: &Findings,
        of_urdf: Option<f64>,
        names: &Names,
    ) -> Option<Constant> {
        let stated = if kind == Kind::Direct { sheet.force_per_volt } else { sheet.force_constant };
        let flag = if kind == Kind::Direct { names.force_per_volt } else { names.force_constant };
        let logged = found.thrust_per.filter(|(over, _)| *over == channel).map(|(_, estimate)| estimate);
        let from_log = || {
            let words = "the logged thrust over it: the number that the drive reckons with".to_owned();
            logged.map(|found| Constant { value: found.value, found: Some(found), words })
        };
        let mass = of_urdf.map(|mass| (mass, "the URDF")).or(sheet.mass.map(|mass| (mass, names.mass)));
        // What a volt does to a winding at rest.
        let over = match (kind, channel) {
            (Kind::Winding, Signal::ControlEffort) => 1.0 / sheet.resistance.unwrap_or(1.0),
            _ => 1.0,
        };
        let balance = found.balance(channel).map(|balance| balance.times(over));
        let from_mass = || {
            let (mass, inertia) = (mass?.0, balance?.inertia);
            let share = inertia.standard_error / inertia.value;
            let (value, standard_error) = (mass / inertia.value, mass / inertia.value * share);
            let ends = [inertia.ci95[1], inertia.ci95[0]].map(|end| mass / end);
            let words = format!(
                "mass of {} over what the log spends on acceleration",
                format_args!("{mass} {}", names.mass_unit)
            );
            let is_told = inertia.ci95[0] > 0.0;
            is_told.then_some(Constant {
                value,
                found: Some(Estimate { value, standard_error, ci95: ends }),
                words,
            })
        };
        let by_flag = stated.map(|value| Constant { value, found: None, words: format!("stated, {flag}") });
        let constant = by_flag.or_else(from_log).or_else(from_mass);
        self.mass = mass.map(|(mass, from)| (mass, None, format!("stated, {from}")));
        self.friction = match (&constant, balance) {
            (Some(constant), Some(balance)) => Some(balance.times(constant.value)),
            _ => found.balance(Signal::Thrust).copied(),
        };
        if let (None, Some(friction)) = (&self.mass, &self.friction)
            && friction.inertia.ci95[0] > 0.0
        {
            let words = match &constant {
                Some(constant) if constant.found.is_none() => format!("with {flag} as stated"),
                _ => "from the force balance".to_owned(),
            };
            self.mass = Some((friction.inertia.value, Some(friction.inertia), words));
        }
        self.compare(mass.map(|(mass, _)| mass), stated, logged, names);
        self.lacking(constant.is_some(), balance.as_ref(), kind, names);
        constant
    }

    /// What stated numbers and the log say of one another.
    fn compare(&mut self, mass: Option<f64>, stated: Option<f64>, logged: Option<Estimate>, names: &Names) {
        let differs = |stated: f64, found: &Estimate| {
            !found.covers(stated) && (found.value / stated - 1.0).abs() > WORTH_TELLING
        };
        if let (Some(mass), Some(friction)) = (mass, &self.friction)
            && differs(mass, &friction.inertia)
        {
            self.notes.push(format!(
                "the log spends its force on {} {} ({}), where {mass} {} is stated: force constant, mass or a base that gives way",
                digits(friction.inertia.value, friction.inertia.standard_error),
                names.mass_unit,
                interval(&friction.inertia, names.mass_unit),
                names.mass_unit
            ));
        }
        if let (Some(stated), Some(logged)) = (stated, logged)
            && differs(stated, &logged)
        {
            self.notes.push(format!(
                "the logged thrust is {} times its channel, where {stated} is stated",
                digits(logged.value, logged.standard_error)
            ));
        }
    }

    /// Of mass and force constant one has to be stated.
    fn lacking(&mut self, has_constant: bool, balance: Option<&Balance>, kind: Kind, names: &Names) {
        let (flag, unit) = match kind {
            Kind::Direct => (names.force_per_volt, names.force_per_volt_unit),
            _ => (names.force_constant, names.force_constant_unit),
        };
        let (has_mass, ratio) = (self.mass.is_some(), balance.map(|balance| balance.inertia));
        match (has_constant, has_mass, ratio) {
            (true, true, _) => {}
            (false, false, Some(ratio)) => {
                let unit_of = if kind == Kind::Direct { "V" } else { "A" };
                let why = format!(
                    "a log of {unit_of} and motion tells only their ratio, {} {unit_of} per {} ({}); this or {} {}",
                    digits(ratio.value, ratio.standard_error),
                    names.acceleration_unit,
                    interval(&ratio, "").trim_end(),
                    names.mass,
                    names.mass_unit
                );
                self.lacks.push(Lack { flag, unit, why });
            }
            (constant, mass, _) => {
                if !constant {
                    let why = "force for what the controller commands; the log does not tell it".to_owned();
                    self.lacks.push(Lack { flag, unit, why });
                }
                if !mass {
                    let why = "moving mass; the log does not tell it".to_owned();
                    self.lacks.push(Lack { flag: names.mass, unit: names.mass_unit, why });
                }
            }
        }
    }

    fn lines(&mut self, kind: Kind, constant: Option<&Constant>, found: &Findings, names: &Names) {
        let word = match kind {
            Kind::Winding => "\"winding\"",
            Kind::CurrentLoop => "\"current_loop\"",
            Kind::Direct => "\"direct\"",
        };
        let why = match kind {
            Kind::Winding if found.winding.is_none_or(|w| w.back_emf.ci95[0] <= 0.0) => {
                "a current loop of first order would look the same: no back-EMF shows"
            }
            Kind::Winding => "a back-EMF shows",
            Kind::CurrentLoop => "a current without a control effort",
            Kind::Direct => "no current is logged: force follows the effort at once",
        };
        self.items.push(Item::assumed("motor", "kind", "", word, why));
        let (key, unit) = match kind {
            Kind::Direct => (names.force_per_volt_key, names.force_per_volt_unit),
            _ => (names.force_constant_key, names.force_constant_unit),
        };
        let flag = if kind == Kind::Direct { names.force_per_volt } else { names.force_constant };
        self.items.push(match constant {
            Some(Constant { found: Some(found), words, .. }) => {
                Item::measured("motor", key, unit, found).and(words)
            }
            Some(Constant { value, words, .. }) => {
                Item::assumed("motor", key, unit, toml_number(*value), words.clone())
            }
            None => Item::missing("motor", key, unit, flag),
        });
        if kind == Kind::CurrentLoop {
            self.items.push(Item::assumed(
                "motor",
                "command_a_per_v",
                "A/V",
                "1.0",
                "the command is not logged",
            ));
            let words = "the current loop's own lag is not logged";
            self.items.push(Item::assumed("motor", "time_constant_s", "s", "1e-3", words));
        }
    }

    /// Resistance, inductance and back-EMF of a winding.
    fn circuit(&mut self, kind: Kind, sheet: &Sheet, found: &Findings, names: &Names) {
        if kind != Kind::Winding {
            return;
        }
        if let Some(winding) = found.winding.filter(|winding| winding.back_emf.ci95[0] > 0.0) {
            self.items.push(Item::measured(
                "motor",
                names.back_emf_key,
                names.back_emf_unit,
                &winding.back_emf,
            ));
        }
        let parts = [
            ("resistance_ohm", "Ω", "--resistance", sheet.resistance, found.winding.map(|w| w.resistance)),
            ("inductance_h", "H", "--inductance", sheet.inductance, found.winding.map(|w| w.inductance)),
        ];
        for (key, unit, flag, stated, found) in parts {
            let item = match (stated, found) {
                (Some(stated), found) => {
                    if let Some(found) = found.filter(|found| !found.covers(stated)) {
                        let log = digits(found.value, found.standard_error);
                        self.notes.push(format!(
                            "{key}: the log shows {log} {unit} ({}), {stated} is stated",
                            interval(&found, unit)
                        ));
                    }
                    Item::assumed("motor", key, unit, toml_number(stated), format!("stated, {flag}"))
                }
                (None, Some(found)) => {
                    Item::measured("motor", key, unit, &found).and("from effort and current")
                }
                (None, None) => {
                    let why = "effort and current do not show it".to_owned();
                    self.lacks.push(Lack { flag, unit, why });
                    Item::missing("motor", key, unit, flag)
                }
            };
            self.items.push(item);
        }
    }
}
