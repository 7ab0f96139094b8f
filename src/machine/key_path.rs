//! Values at TOML key paths.

use crate::error::{Error, ErrorKind, Result};

/// Sets the value at `path` (keys joined by dots, array places as numbers); tables on the way are made.
pub(super) fn set(table: &mut toml::Table, path: &str, value: toml::Value) -> Result<()> {
    let mut keys = path.split('.').peekable();
    let mut current = Place::Table(table);
    while let Some(key) = keys.next() {
        let last = keys.peek().is_none();
        let slot = match current {
            Place::Table(table) => {
                if last {
                    let value = like(table.get(key), value);
                    table.insert(key.to_string(), value);
                    return Ok(());
                }
                table.entry(key.to_string()).or_insert_with(|| toml::Value::Table(toml::Table::new()))
            }
            Place::Array(array) => {
                let slot = key.parse::<usize>().ok().and_then(|index| array.get_mut(index));
                let slot = slot.ok_or_else(|| no_such_key(path, key))?;
                if last {
                    *slot = like(Some(slot), value);
                    return Ok(());
                }
                slot
            }
        };
        current = match slot {
            toml::Value::Table(table) => Place::Table(table),
            toml::Value::Array(array) => Place::Array(array),
            _ => return Err(no_such_key(path, key)),
        };
    }
    Ok(())
}

enum Place<'a> {
    Table(&'a mut toml::Table),
    Array(&'a mut Vec<toml::Value>),
}

/// Fits set real numbers; where the file holds an integer (a register) the nearest one is meant.
fn like(present: Option<&toml::Value>, value: toml::Value) -> toml::Value {
    match (present, &value) {
        (Some(toml::Value::Integer(_)), toml::Value::Float(x)) if x.fract() == 0.0 => {
            toml::Value::Integer(*x as i64)
        }
        _ => value,
    }
}

fn no_such_key(path: &str, key: &str) -> Error {
    Error::new(ErrorKind::UnknownKey)
        .key(path)
        .found(format!("`{key}`, which holds neither a table nor a list with that place"))
        .expected("a key path of the machine file")
        .remedy("write it as in machine.toml, for instance controller.integral")
}

/// The value at `path`, if there is one.
pub(super) fn value<'a>(table: &'a toml::Table, path: &str) -> Option<&'a toml::Value> {
    let mut keys = path.split('.');
    let first = table.get(keys.next()?)?;
    keys.try_fold(first, |value, key| match value {
        toml::Value::Table(table) => table.get(key),
        toml::Value::Array(array) => array.get(key.parse::<usize>().ok()?),
        _ => None,
    })
}

/// The number at `path`, if there is one.
pub(super) fn number(table: &toml::Table, path: &str) -> Option<f64> {
    match value(table, path)? {
        toml::Value::Float(x) => Some(*x),
        toml::Value::Integer(n) => Some(*n as f64),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_value_set_at_a_path_is_read_back() {
        let mut table: toml::Table = toml::from_str("[a]\nb = 1\n[[c.mode]]\nx = 2.0\n").unwrap();
        set(&mut table, "a.b", toml::Value::Float(7.0)).unwrap();
        set(&mut table, "c.mode.0.x", toml::Value::Float(2.5)).unwrap();
        set(&mut table, "effect.new.force_n", toml::Value::Float(3.0)).unwrap();
        assert_eq!(table["a"]["b"], toml::Value::Integer(7));
        assert_eq!(number(&table, "c.mode.0.x"), Some(2.5));
        assert_eq!(number(&table, "effect.new.force_n"), Some(3.0));
    }

    #[test]
    fn exact_path_through_a_number_is_refused() {
        let mut table: toml::Table = toml::from_str("a = 1\n").unwrap();
        let error = set(&mut table, "a.b", toml::Value::Float(1.0)).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::UnknownKey);
    }
}
