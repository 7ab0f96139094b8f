//! The settings of a run on top of what a fit moves.

use super::hypothesis::{path, stated_numbers};
use super::{phase, play};
use crate::effect::{EffectId, Parameter};
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Run;

/// Settings of a run: those of the machine's own keys, and by how much the effects' numbers differ in this run.
///
/// # Model
/// A setting says what is known of one run: `"effect.payload.mass_kg" = 5` is a weight bolted on for it. A fit says what
/// is not known of all runs. Where both speak of one number of an effect, the run's difference to the machine as
/// stated comes on top of the fitted value: `fitted + (set − stated)`, which is the set value as long as nothing is
/// fitted; values that an earlier diagnosis wrote into the machine count as fitted. So a known payload does not undo the calibration of the mass, nor of a cause found beside it.
///
/// # Validity
/// Numbers of effects that have a value where the effect is absent (the stated one, or the one that leaves the twin as
/// it is). All other settings, and numbers without such a value, hold as they stand.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RunSettings {
    plain: Vec<(String, toml::Value)>,
    shifts: Vec<Shift>,
}

/// Numbers of effects that belong to one run and not to the machine.
const OF_ONE_RUN: [(EffectId, &str); 2] =
    [(EffectId::Backlash, play::KEY), (EffectId::ExternalVibration, phase::KEY)];

/// What a run sets of a number that a fit may move.
#[derive(Debug, Clone, PartialEq)]
struct Shift {
    effect: EffectId,
    index: usize,
    path: String,
    set: f64,
    stated: f64,
}

impl RunSettings {
    /// Sorts the settings of a run, against the machine as stated.
    pub(super) fn of(run: &Run, stated: &Machine) -> Self {
        let mut sorted = Self { plain: Vec::new(), shifts: Vec::new() };
        for (key, value) in &run.settings {
            match shift(stated, key, value) {
                Some(shift) => sorted.shifts.push(shift),
                None => sorted.plain.push((key.clone(), value.clone())),
            }
        }
        sorted
    }

    /// The machine, stated or fitted, as it was set in the run.
    ///
    /// # Errors
    /// A setting that the machine does not have, or a number that its description refuses.
    pub(super) fn machine(&self, machine: &Machine) -> Result<Machine> {
        if self.plain.is_empty() && self.shifts.is_empty() {
            return Ok(machine.clone());
        }
        // How one run begins says nothing of a machine that has no play, nor a phase of one that nothing shakes.
        let effects = &machine.description().effect;
        let means = |key: &str| {
            let of_run = OF_ONE_RUN.iter().find(|(effect, number)| path(*effect, number) == key);
            of_run.is_none_or(|(effect, _)| effects.contains(*effect))
        };
        let plain = self.plain.iter().filter(|(key, _)| means(key));
        let plain = plain.map(|(key, value)| (key.as_str(), value.clone()));
        let shifted = self.shifts.iter().map(|s| (s.path.as_str(), toml::Value::Float(s.value(machine))));
        // Together: some keys of an effect say nothing without the others.
        machine.with_settings(plain.chain(shifted))
    }
}

impl Shift {
    fn value(&self, machine: &Machine) -> f64 {
        let fitted = stated_numbers(machine, self.effect)[self.index];
        // The set value to the last bit where nothing was fitted.
        if fitted == self.stated { self.set } else { fitted + (self.set - self.stated) }
    }
}

/// The setting as a difference, where it is of a number of an effect that has a value in the machine as stated.
fn shift(machine: &Machine, key: &str, value: &toml::Value) -> Option<Shift> {
    let set = value.as_float().or_else(|| value.as_integer().map(|n| n as f64))?;
    let (name, number) = key.strip_prefix("effect.")?.split_once('.')?;
    let effect = EffectId::ALL.iter().copied().find(|effect| effect.name() == name)?;
    let (index, parameter) =
        effect.numbers().enumerate().find(|(_, p)| [p.name, p.revolute_name].contains(&number))?;
    // One name for one number: the one that fits use.
    let path = path(effect, parameter.key(machine.motion()));
    let stated = match machine.stated_before(&path) {
        // What an earlier diagnosis identified is no more undone by a known setting than what this one fits.
        Some(before) => before.unwrap_or_else(|| usual(effect, parameter)),
        None => stated_numbers(machine, effect)[index],
    };
    stated.is_finite().then_some(Shift { effect, index, path, set, stated })
}

/// What a number is where nothing is stated: the usual one of its law's form, or zero.
fn usual(effect: EffectId, parameter: &Parameter) -> f64 {
    let form = effect.form().iter().find(|form| form.parameter.name == parameter.name);
    form.map_or(0.0, |form| form.usual)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::shipped;
    use crate::recording::Signal;
    use crate::units::Motion;
    use std::collections::BTreeMap;

    const PAYLOAD: &str = "effect.payload.mass_kg";

    fn machine() -> Machine {
        shipped().find(|machine| machine.motion() == Motion::Prismatic).unwrap()
    }

    fn run(settings: &[(&str, toml::Value)]) -> Run {
        let signals = BTreeMap::from([(Signal::Position, vec![0.0; 3])]);
        let mut run = Run::new("run", Motion::Prismatic, 1e-3, signals).unwrap();
        run.settings = settings.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect();
        run
    }

    #[test]
    fn exact_known_payload_comes_on_top_of_the_fitted_one() {
        let stated = machine();
        let settings = RunSettings::of(&run(&[(PAYLOAD, toml::Value::Integer(5))]), &stated);
        let set = |fitted: &Machine| settings.machine(fitted).unwrap().number(PAYLOAD);
        assert_eq!(set(&stated), Some(5.0));
        let fitted = stated.with_settings([(PAYLOAD, toml::Value::Float(0.75))]).unwrap();
        assert_eq!(set(&fitted), Some(5.75));
        // A payload that the file states already is replaced by the setting, and the fit's change kept.
        let carrying = stated.with_settings([(PAYLOAD, toml::Value::Float(2.0))]).unwrap();
        let settings = RunSettings::of(&run(&[(PAYLOAD, toml::Value::Float(5.0))]), &carrying);
        let fitted = stated.with_settings([(PAYLOAD, toml::Value::Float(2.25))]).unwrap();
        assert_eq!(settings.machine(&carrying).unwrap().number(PAYLOAD), Some(5.0));
        assert_eq!(settings.machine(&fitted).unwrap().number(PAYLOAD), Some(5.25));
    }

    #[test]
    fn exact_identified_values_are_kept_below_a_known_setting() {
        let file = "[[provenance]]\nrecording_sha256 = \"0\"\ntraining = []\nheld_out = []\ngap_before = 2.0\n\
                    gap_after = 1.0\nclosed = 1.0\nclosed_ci95 = [1.0, 1.0]\nversion = \"0\"\n\
                    [[provenance.value]]\npath = \"effect.payload.mass_kg\"\nvalue = 0.25\n\
                    ci95 = [0.2, 0.3]\nunit = \"kg\"\nbefore = 0.0\nreason = \"calibration\"\n";
        let mut entry: toml::Table = toml::from_str(file).unwrap();
        let provenance = entry.remove("provenance").unwrap();
        let settings = [(PAYLOAD, toml::Value::Float(0.25)), ("provenance", provenance)];
        let improved = machine().with_settings(settings).unwrap();
        let set = RunSettings::of(&run(&[(PAYLOAD, toml::Value::Float(5.0))]), &improved);
        assert_eq!(set.machine(&improved).unwrap().number(PAYLOAD), Some(5.25));
        // A replay of such a run simulates the same.
        assert_eq!(improved.on_top(PAYLOAD, toml::Value::Float(5.0)), toml::Value::Float(5.25));
        assert_eq!(machine().on_top(PAYLOAD, toml::Value::Float(5.0)), toml::Value::Float(5.0));
    }

    #[test]
    fn exact_other_settings_hold_as_they_stand() {
        let stated = machine();
        let key = "amplifier.offset_v";
        let settings = RunSettings::of(&run(&[(key, toml::Value::Float(0.5))]), &stated);
        assert_eq!(settings.machine(&stated).unwrap().number(key), Some(0.5));
        let none = RunSettings::of(&run(&[]), &stated).machine(&stated).unwrap();
        assert_eq!(none.table(), stated.table());
    }

    #[test]
    fn exact_setting_that_the_machine_does_not_have_is_refused() {
        let stated = machine();
        for key in ["controller.nonsense", "effect.nonsense.mass_kg", "effect.payload.nonsense"] {
            let settings = RunSettings::of(&run(&[(key, toml::Value::Float(1.0))]), &stated);
            assert!(settings.machine(&stated).is_err(), "{key}");
        }
    }
}
