//! The catalogue of effects: what a law says of itself is what it does, and the program tells all of it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::slideway as run;
use serde::Deserialize;
use slideway::effect::{CONTROLLER_GAIN, Door, EffectId, Effects, Parameter, Stretch, Usual};
use slideway::machine::Machine;
use slideway::recording::Signal;
use slideway::report::example;
use slideway::units::{Motion, engineering};
use std::path::Path;

const BAD_INPUT: Option<i32> = Some(2);

fn shown(arguments: &[&str]) -> String {
    let output = run(arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// A text without what its layout adds: spaces, line ends, marks of code and of comments.
fn bare(text: &str) -> String {
    text.replace("///", "").chars().filter(|c| !c.is_whitespace() && *c != '`').collect()
}

/// The table of a machine file that states effects.
#[derive(Deserialize)]
struct File {
    effect: Effects,
}

/// The effects that a table states, or what is wrong with them.
fn effects(table: &str) -> Result<Effects, String> {
    let file: File = toml::from_str(table).map_err(|error| error.to_string())?;
    file.effect.fault().map_or(Ok(file.effect), |(key, fault)| Err(format!("{key}: {fault}")))
}

/// The effect alone, with these values, by the keys of an axis.
fn stated(effect: EffectId, motion: Motion, values: &[f64]) -> Result<Effects, String> {
    let row = |(parameter, value): (&Parameter, &f64)| format!("{} = {value:?}\n", parameter.key(motion));
    let rows: String = effect.parameters().iter().zip(values).map(row).collect();
    effects(&format!("[effect.{}]\n{rows}", effect.name()))
}

#[test]
fn exact_every_effect_is_listed() {
    let list = shown(&["effects"]);
    for effect in EffectId::ALL {
        assert!(list.contains(effect.name()) && list.contains(effect.phrase()), "{}", effect.name());
    }
}

#[test]
fn exact_every_effect_tells_what_its_law_states() {
    for &effect in EffectId::ALL {
        let sheet = shown(&["effects", effect.name()]);
        let told = bare(&sheet);
        let mut parts = vec![effect.phrase(), effect.site().name(), effect.source(), effect.shown_by()];
        parts.extend(effect.equation().lines());
        parts.extend(effect.symbols());
        parts.extend(effect.group());
        parts.extend(effect.modifies().iter().map(|other| other.name()));
        parts.extend(effect.likenesses().iter().flat_map(|likeness| [likeness.other.name(), likeness.place]));
        for parameter in effect.parameters() {
            parts.extend([parameter.name, parameter.revolute_name, parameter.unit, parameter.revolute_unit]);
        }
        for part in parts {
            assert!(told.contains(&bare(part)), "`{part}` is not in:\n{sheet}");
        }
        let usual = effect.parameters().iter().filter_map(|parameter| parameter.usual);
        let prior = |usual: Usual| match usual {
            Usual::Factor(factor) => format!("within a factor {factor:.2}"),
            Usual::Range { prismatic, .. } => format!("between {}", engineering(prismatic.0, "m")),
        };
        for prior in usual.map(prior) {
            assert!(told.contains(&bare(&prior)), "`{prior}` is not in:\n{sheet}");
        }
        let table: Vec<&str> = sheet.lines().skip_while(|line| !line.contains("in a machine file")).collect();
        assert_eq!(bare(&table[1..].concat()), bare(&example(effect)), "{}", effect.name());
    }
}

#[test]
fn exact_group_shows_each_of_its_effects() {
    let sheets = shown(&["effects", CONTROLLER_GAIN]);
    for effect in EffectId::ALL.iter().filter(|effect| effect.group() == Some(CONTROLLER_GAIN)) {
        assert!(sheets.contains(&format!("[effect.{}]", effect.name())), "{}", effect.name());
    }
}

#[test]
fn exact_wrong_name_is_refused_with_the_one_that_was_meant() {
    let output = run(&["effects", "colomb_friction"]);
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), BAD_INPUT, "{told}");
    assert!(told.contains("a similar value exists: 'coulomb_friction'"), "{told}");
    assert!(output.stdout.is_empty());
}

#[test]
fn exact_every_example_is_accepted_in_a_machine_file() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    let machines = ["grinder", "servo", "xl330"].map(|name| Machine::read(&models.join(name)).unwrap());
    for &effect in EffectId::ALL {
        let has_it = |machine: &&Machine| !effect.has_nothing_to_change(&machine.stated_constants());
        let machine = machines.iter().find(has_it).unwrap();
        let table: toml::Table = example(effect).parse().unwrap();
        let stated = table["effect"].as_table().unwrap();
        let settings: Vec<(String, toml::Value)> = stated
            .iter()
            .flat_map(|(id, keys)| {
                let keys = keys.as_table().unwrap().clone();
                keys.into_iter().map(move |(key, value)| (format!("effect.{id}.{key}"), value))
            })
            .collect();
        let settings = settings.iter().map(|(path, value)| (path.as_str(), value.clone()));
        let real = machine.with_settings(settings).unwrap_or_else(|error| panic!("{error}"));
        assert!(real.description().effect.contains(effect), "{}", effect.name());
        if let Err(fault) = self::stated(effect, Motion::Revolute, effect.example()) {
            panic!("{fault}");
        }
    }
}

/// The allowed values that `slideway effects` tells are those that a machine file may hold.
#[test]
fn exact_allowed_values_are_those_that_the_law_accepts() {
    for &effect in EffectId::ALL {
        for (k, parameter) in effect.parameters().iter().enumerate() {
            let accepts = |value: f64| {
                let mut values = effect.example().to_vec();
                values[k] = value;
                stated(effect, Motion::Prismatic, &values).is_ok()
            };
            let told = format!("{}.{}: {}", effect.name(), parameter.name, parameter.allowed());
            let (least, most) = parameter.limits;
            for (limit, outwards) in [(least, -1.0), (most, 1.0)] {
                if limit.is_finite() {
                    assert_eq!(accepts(limit), !parameter.open, "{told}, at {limit}");
                    assert!(!accepts(limit + 1e-3 * outwards), "{told}, beyond {limit}");
                } else {
                    let far = 0.9 * slideway::units::largest(parameter.name);
                    assert!(accepts(far * outwards), "{told}, at {far}");
                }
            }
            assert!(accepts(effect.example()[k]), "{told}, as in the example");
            assert!(!accepts(f64::NAN), "{told}, no number");
        }
    }
}

/// Documentation of an effect's law.
fn documented(effect: EffectId) -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/effect");
    let own = folder.join(format!("{}.rs", effect.name()));
    let file = if own.is_file() { own } else { folder.join(format!("{}.rs", effect.group().unwrap())) };
    let text = std::fs::read_to_string(file).unwrap();
    text.lines().filter_map(|line| Some(line.trim_start().strip_prefix("///")?.to_owned())).collect()
}

#[test]
fn exact_equations_stand_in_the_documentation_of_their_laws() {
    for &effect in EffectId::ALL {
        let documentation = bare(&documented(effect).concat());
        // The documentation has "with φ = …" behind the mark of code.
        for part in effect.equation().lines().flat_map(|case| case.split(" with ")) {
            assert!(documentation.contains(&bare(part)), "{}: {part}", effect.name());
        }
    }
}

/// The documentation of a parameter's field begins with its symbol, which stands in the equation.
#[test]
fn exact_symbols_are_those_of_the_documentation() {
    for &effect in EffectId::ALL {
        let documentation = documented(effect);
        for symbol in effect.symbols() {
            let begins = |line: &String| {
                let rest = line.trim_start().strip_prefix(symbol);
                rest.is_some_and(|rest| rest.starts_with([' ', ',', '.', ';']))
            };
            assert!(documentation.iter().any(begins), "{}: no field begins with {symbol}", effect.name());
            let in_equation = symbol.trim_end_matches("/2π");
            assert!(effect.equation().contains(in_equation), "{}: no {symbol} in it", effect.name());
        }
    }
}

#[test]
fn exact_likenesses_are_read_from_both_sides() {
    for &effect in EffectId::ALL {
        let others: Vec<EffectId> = effect.likenesses().iter().map(|likeness| likeness.other).collect();
        for &other in &others {
            assert_ne!(other, effect);
            assert_eq!(others.iter().filter(|o| **o == other).count(), 1, "{} twice", other.name());
            let back = other.likenesses().iter().any(|likeness| likeness.other == effect);
            assert!(back, "{} and {}", effect.name(), other.name());
        }
    }
}

/// A law acts through the doors that it lists, and through no other.
#[test]
fn exact_doors_are_those_that_change_something() {
    for &effect in EffectId::ALL {
        let law = &stated(effect, Motion::Prismatic, effect.example()).unwrap().acting()[0];
        let places = (1..40).map(|k| (0.0013 * f64::from(k), 0.01 * f64::from(k) - 0.2));
        for (position, velocity) in places {
            // A new door is a line in the list and an arm here.
            let acts = |door: Door| match door {
                Door::Push => law.push(position, velocity) != 0.0,
                Door::Shake => law.shake(position) != 0.0,
                Door::MotorForce => law.motor_change(position, 100.0) != 0.0,
                Door::Transmission => law.stops([position; 2]) != [position; 2],
                Door::Reading => law.read(position) != position,
            };
            for door in [Door::Push, Door::Shake, Door::MotorForce, Door::Transmission, Door::Reading] {
                assert_eq!(acts(door), law.acts_through(door), "{}, {door:?} at {position}", effect.name());
            }
        }
    }
}

#[test]
fn exact_controller_gains_act_in_the_control_law() {
    for effect in EffectId::ALL {
        let is_gain = effect.group() == Some(CONTROLLER_GAIN);
        assert_eq!(effect.stretch() == Stretch::Controller, is_gain, "{}", effect.name());
    }
}

#[test]
fn exact_equals_hold_only_where_their_words_say() {
    let machine = Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap();
    let constants = machine.constants();
    let equal = |effect: EffectId, logged: &[Signal]| -> Vec<&str> {
        let all = effect.likenesses();
        all.iter().filter(|l| l.is_equal(&constants, logged)).map(|l| l.other.name()).collect()
    };
    assert_eq!(equal(EffectId::AmplifierOffset, &[Signal::Position]), ["constant_force"]);
    assert!(equal(EffectId::AmplifierOffset, &[Signal::Position, Signal::Current]).is_empty());
    assert_eq!(equal(EffectId::EncoderScale, &[Signal::Position]), ["force_constant"]);
    assert!(equal(EffectId::EncoderScale, &[Signal::Position, Signal::LoadPosition]).is_empty());
}
