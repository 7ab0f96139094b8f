//! What `[tune]` asks of a machine, checked when the file is read: numbers that its controller has, values that they can have.

use super::{Criterion, Machine, TunePlan, Vary, key_path};
use crate::error::{Error, ErrorKind, Result};
use crate::units::Motion;

/// What a register holds.
const REGISTER: std::ops::RangeInclusive<f64> = -32_768.0..=32_767.0;

/// A value as the machine file holds it.
pub fn turned(value: f64, is_integer: bool) -> toml::Value {
    if is_integer { toml::Value::Integer(value.round() as i64) } else { toml::Value::Float(value) }
}

impl Machine {
    /// Whether the file holds an integer at a key path.
    pub fn is_integer(&self, key: &str) -> bool {
        key_path::value(&self.table, key).is_some_and(toml::Value::is_integer)
    }

    /// Refuses a value that a number of the controller cannot have: a fraction of an integer, what a register cannot hold, what
    /// the description refuses.
    ///
    /// # Errors
    /// As said.
    pub fn check_turned(&self, key: &str, value: f64) -> Result<()> {
        let is_integer = self.is_integer(key);
        let fits = !is_integer || (value.fract() == 0.0 && REGISTER.contains(&value));
        if !(value.is_finite() && fits) {
            let what = if is_integer { "a whole number of 16 bits" } else { "a finite number" };
            return Err(Error::new(ErrorKind::OutOfRange)
                .file(&self.file)
                .key(key)
                .found(value.to_string())
                .expected(what)
                .remedy("give a value that the controller can be set to"));
        }
        self.with_settings([(key, turned(value, is_integer))]).map(drop)
    }

    /// Checks `[tune]` against the axis and its controller.
    pub(super) fn check_tune(&self) -> Result<()> {
        let Some(plan) = &self.description.tune else { return Ok(()) };
        // Without a control law, in a variant of a machine that has one, nothing is tuned.
        if self.description.controller.is_none() {
            return Ok(());
        }
        let moved = |error: Error, key: &str| error.moved_to(&self.file, format!("tune.{key}"));
        self.check_cells("tune", &plan.cells)?;
        for (key, bound) in &plan.limits {
            Criterion::bounded(self.motion(), key, *bound)
                .map_err(|error| moved(error, &format!("limits.{key}")))?;
        }
        for (place, vary) in plan.vary.iter().enumerate() {
            let is_twice = plan.vary[..place].iter().any(|other| other.key == vary.key);
            self.check_vary(vary, is_twice)
                .map_err(|(error, key)| moved(error, &format!("vary.{place}.{key}")))?;
        }
        self.check_marks(plan)
    }

    /// Refuses strokes of a plan beyond the travel; that they are strokes was checked with the description.
    pub(super) fn check_cells(&self, table: &str, cells: &[String]) -> Result<()> {
        let joint = &self.solid.joint;
        let is_beyond = |cell: &String| {
            let stroke = cell.split_once('@').and_then(|(stroke, _)| stroke.trim().parse::<f64>().ok());
            stroke.is_some_and(|stroke| !(joint.lower..=joint.upper).contains(&stroke))
        };
        let Some((place, cell)) = cells.iter().enumerate().find(|(_, cell)| is_beyond(cell)) else {
            return Ok(());
        };
        let unit = if joint.motion == Motion::Prismatic { "m" } else { "rad" };
        Err(Error::new(ErrorKind::OutOfRange)
            .file(&self.file)
            .key(format!("{table}.cells.{place}"))
            .found(format!("`{cell}`"))
            .expected(format!(
                "a stroke from {} to {} {unit}, the travel of the joint",
                joint.lower, joint.upper
            ))
            .remedy("shorten the stroke; it starts at position 0"))
    }

    /// With the key below the entry at which it is refused.
    fn check_vary(&self, vary: &Vary, is_twice: bool) -> std::result::Result<(), (Error, &'static str)> {
        let Vary { key, from, to, step } = vary;
        let refuse = |found: String, expected: String| {
            Error::new(ErrorKind::OutOfRange).found(found).expected(expected).remedy(
                "write for instance key = \"controller.integral\", from = 6, to = 65; each number of the controller once",
            )
        };
        if is_twice {
            return Err((refuse(format!("`{key}` a second time"), "each number once".to_owned()), "key"));
        }
        if !key.starts_with("controller.") || self.number(key).is_none() {
            let found = format!("`{key}`, which is no number of the controller");
            return Err((refuse(found, format!("one of {}", self.controller_numbers().join(", "))), "key"));
        }
        for (end, name) in [(from, "from"), (to, "to")] {
            self.check_turned(key, *end).map_err(|error| (error, name))?;
        }
        match step {
            Some(step) if self.is_integer(key) && step.fract() != 0.0 => {
                Err((refuse(step.to_string(), format!("a whole number, as `{key}` is")), "step"))
            }
            _ => Ok(()),
        }
    }

    /// Key paths of the controller's numbers.
    fn controller_numbers(&self) -> Vec<String> {
        let law = self.table.get("controller").and_then(toml::Value::as_table);
        let numbers = law.into_iter().flatten().filter(|(_, value)| value.is_integer() || value.is_float());
        numbers.map(|(key, _)| format!("controller.{key}")).collect()
    }

    fn check_marks(&self, plan: &TunePlan) -> Result<()> {
        for (place, mark) in plan.marks.iter().enumerate() {
            let key = format!("tune.marks.{place}");
            if mark.len() != plan.vary.len() {
                return Err(Error::new(ErrorKind::OutOfRange)
                    .file(&self.file)
                    .key(key)
                    .found(format!("{} numbers", mark.len()))
                    .expected(format!("{}, one for each [[tune.vary]]", plan.vary.len()))
                    .remedy("write them in the order of the entries, as in marks = [[22, 220]]"));
            }
            for (vary, value) in plan.vary.iter().zip(mark) {
                self.check_turned(&vary.key, *value)
                    .map_err(|error| error.moved_to(&self.file, key.clone()))?;
            }
        }
        Ok(())
    }
}
