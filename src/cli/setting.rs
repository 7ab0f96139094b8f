//! `KEY=VALUE` on the command line: a machine setting by key path.

use std::fmt;
use std::str::FromStr;

use slideway::error::Error;
use slideway::machine::Machine;

/// A machine setting: key path and TOML value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Setting {
    pub(super) path: String,
    pub(super) value: toml::Value,
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let example = "write for instance controller.integral=22";
        let (path, value) = text.split_once('=').ok_or_else(|| format!("no `=` in it; {example}"))?;
        let (path, value) = (path.trim(), value.trim());
        if path.is_empty() || path.split('.').any(str::is_empty) {
            return Err(format!("`{path}` is not a key path; {example}"));
        }
        if value.is_empty() {
            return Err(format!("no value behind the `=`; {example}"));
        }
        let parsed = format!("value = {value}").parse::<toml::Table>().ok();
        match parsed.filter(|table| table.len() == 1).and_then(|mut table| table.remove("value")) {
            Some(value) => Ok(Self { path: path.to_owned(), value }),
            None => Err(format!(
                "`{value}` is not a TOML value: numbers as 22 or 1.5e-3, true or false, text in quotes ({path}='\"{value}\"')"
            )),
        }
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {}", self.path, self.value)
    }
}

/// The machine as `--set` sets it: on top of what diagnoses identified at the same key paths.
pub(super) fn set(machine: &Machine, settings: &[Setting]) -> Result<Machine, Error> {
    let on_top = |Setting { path, value }: &Setting| Setting {
        path: path.clone(),
        value: machine.on_top(path, value.clone()),
    };
    let known: Vec<Setting> = settings.iter().map(on_top).collect();
    lay_over(machine, &known, "--set")
}

/// The machine with settings laid over it; a refusal names the option and the setting at fault.
pub(super) fn lay_over(machine: &Machine, settings: &[Setting], option: &str) -> Result<Machine, Error> {
    let apply = |some: &[Setting]| {
        machine.with_settings(some.iter().map(|setting| (setting.path.as_str(), setting.value.clone())))
    };
    apply(settings).map_err(|error| {
        let text = error.statement();
        // Alone, a setting may be refused for lack of the others: the same sentence is the same fault.
        let same = |setting: &&Setting| {
            apply(std::slice::from_ref(*setting)).is_err_and(|alone| alone.statement() == text)
        };
        match settings.iter().find(same) {
            Some(setting) => error.key(format!("{option} {setting}")),
            None => error.key(option),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_values_are_toml() {
        let value = |text: &str| text.parse::<Setting>().unwrap().value;
        assert_eq!(value("controller.integral=22"), toml::Value::Integer(22));
        assert_eq!(value("a.b = 1.5e-3"), toml::Value::Float(1.5e-3));
        assert_eq!(value("a=true"), toml::Value::Boolean(true));
        assert_eq!(value("name=\"a = b\""), toml::Value::String("a = b".to_owned()));
    }

    #[test]
    fn exact_setting_that_is_none_is_refused() {
        for text in ["a", "=1", "a=", "a..b=1", "a=fast", "a=1\nb=2", "a=[1"] {
            assert!(text.parse::<Setting>().is_err(), "{text}");
        }
    }
}
