//! What a machine file must state, and by which names on its kind of axis.

use crate::effect::{EffectId, Effects};
use crate::error::{Error, ErrorKind, Result};
use crate::units::Motion;

/// What every machine file has, and what it is.
const COMPLETE: [(&str, &str); 5] = [
    ("name", "name = \"…\", what the machine is called"),
    ("urdf", "urdf = \"…\", the file of its solid model"),
    ("sample_period_s", "sample_period_s = …, of the controller"),
    ("motor", "[motor] with kind = \"winding\", \"current_loop\" or \"direct\""),
    (
        "encoder",
        "[encoder] with velocity = { kind = \"smoothed_difference\", time_constant_s = 0.0 } or as it is",
    ),
];
/// What the kinds of motor state, on a sliding axis.
const MOTORS: [(&str, &[&str]); 3] = [
    ("winding", &["resistance_ohm", "inductance_h", "force_constant_n_per_a"]),
    ("current_loop", &["time_constant_s", "force_constant_n_per_a"]),
    ("direct", &["force_n_per_v"]),
];
/// Keys of the same meaning on a sliding and on a turning axis, by table; effects tell their own.
const PAIRS: [(&str, &str, &str); 14] = [
    ("controller", "position_gain_v_per_m", "position_gain_v_per_rad"),
    ("controller", "derivative_gain_v_s_per_m", "derivative_gain_v_s_per_rad"),
    ("controller", "velocity_gain_v_s_per_m", "velocity_gain_v_s_per_rad"),
    ("motor", "force_constant_n_per_a", "torque_constant_nm_per_a"),
    ("motor", "back_emf_v_s_per_m", "back_emf_v_s_per_rad"),
    ("motor", "magnet_pitch_m", "magnet_pitch_rad"),
    ("motor", "force_n_per_v", "torque_nm_per_v"),
    ("guide", "viscous_n_s_per_m", "viscous_nm_s_per_rad"),
    ("encoder", "resolution_m", "resolution_rad"),
    ("encoder", "noise_m", "noise_rad"),
    ("load_sensor", "resolution_m", "resolution_rad"),
    ("load_sensor", "noise_m", "noise_rad"),
    ("tune", "friction_n", "friction_nm"),
    ("feedforward", "viscous_n_s_per_m", "viscous_nm_s_per_rad"),
];

/// Refuses a file that lacks what every machine states; names all of it at once.
pub(super) fn check_complete(table: &toml::Table) -> Result<()> {
    let lacking: Vec<&(&str, &str)> = COMPLETE.iter().filter(|(key, _)| !table.contains_key(*key)).collect();
    if !lacking.is_empty() {
        let keys: Vec<&str> = lacking.iter().map(|(key, _)| *key).collect();
        let what: Vec<&str> = lacking.iter().map(|(_, what)| *what).collect();
        return Err(Error::new(ErrorKind::Missing)
            .found(format!("a machine file without {}", keys.join(", ")))
            .expected(what.join("; "))
            .remedy("add what is missing; the machines in `models` show complete files"));
    }
    check_motor(table)?;
    let Some(effects) = table.get("effect").and_then(toml::Value::as_table) else { return Ok(()) };
    effects.iter().try_for_each(|(name, stated)| check_effect(name, stated))
}

fn check_motor(table: &toml::Table) -> Result<()> {
    let Some(motor) = table.get("motor").and_then(toml::Value::as_table) else { return Ok(()) };
    let kind = motor.get("kind").and_then(toml::Value::as_str);
    let Some((kind, needed)) = MOTORS.iter().find(|(name, _)| Some(*name) == kind) else { return Ok(()) };
    let other =
        |key: &str| PAIRS.iter().find(|(_, sliding, _)| *sliding == key).map(|(_, _, turning)| *turning);
    let is_there =
        |key: &str| motor.contains_key(key) || other(key).is_some_and(|key| motor.contains_key(key));
    let lacking: Vec<String> = needed
        .iter()
        .filter(|key| !is_there(key))
        .map(|key| other(key).map_or_else(|| (*key).to_owned(), |other| format!("{key} (or {other})")))
        .collect();
    lacks("motor", &lacking, &format!("they belong to a motor of kind {kind}"))
}

fn check_effect(name: &str, stated: &toml::Value) -> Result<()> {
    let effect = EffectId::named(name);
    let (Some(effect), Some(stated)) = (effect, stated.as_table()) else { return Ok(()) };
    let alone: toml::Table = [(name.to_owned(), stated.clone().into())].into_iter().collect();
    let read = alone.try_into::<Effects>();
    if !read.is_err_and(|error| error.message().starts_with("missing field")) {
        return Ok(());
    }
    let is_there = |name: &str, other: &str| stated.contains_key(name) || stated.contains_key(other);
    let lacking: Vec<String> = effect
        .parameters()
        .iter()
        .filter(|parameter| !is_there(parameter.name, parameter.revolute_name))
        .map(|parameter| match parameter.name == parameter.revolute_name {
            true => parameter.name.to_owned(),
            false => format!("{} (or {})", parameter.name, parameter.revolute_name),
        })
        .collect();
    lacks(&format!("effect.{name}"), &lacking, &format!("`slideway effects {name}` shows a complete table"))
}

fn lacks(table: &str, lacking: &[String], remedy: &str) -> Result<()> {
    if lacking.is_empty() {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Missing)
        .key(table)
        .found(format!("[{table}] without {}", lacking.join(", ")))
        .expected("all of its numbers")
        .remedy(remedy.to_owned()))
}

/// Refuses keys of a turning axis on a sliding one, and the other way round.
///
/// Motor and encoder behind a transmission turn whatever the axis does.
pub(super) fn check_motion(table: &toml::Table, motion: Motion) -> Result<()> {
    let geared = table.contains_key("transmission");
    let is_behind = |name: &str| geared && (name == "motor" || name == "encoder");
    for (name, sliding, turning) in PAIRS.into_iter().filter(|(name, ..)| !is_behind(name)) {
        let Some(part) = table.get(name).and_then(toml::Value::as_table) else { continue };
        fits(name, part, [sliding, turning], motion)?;
    }
    let Some(effects) = table.get("effect").and_then(toml::Value::as_table) else { return Ok(()) };
    for effect in EffectId::ALL.iter() {
        let Some(stated) = effects.get(effect.name()).and_then(toml::Value::as_table) else { continue };
        let name = format!("effect.{}", effect.name());
        for parameter in effect.parameters().iter() {
            fits(&name, stated, [parameter.name, parameter.revolute_name], motion)?;
        }
    }
    Ok(())
}

fn fits(name: &str, part: &toml::Table, [sliding, turning]: [&str; 2], motion: Motion) -> Result<()> {
    let (own, other) = match motion {
        Motion::Prismatic => (sliding, turning),
        Motion::Revolute => (turning, sliding),
    };
    if own == other || !part.contains_key(other) {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Inconsistent)
        .key(format!("{name}.{other}"))
        .found(format!("a key of the other kind of axis: the driven joint is {motion}"))
        .expected(format!("`{own}`"))
        .remedy("convert the number and rename the key, or correct the type of the joint in the URDF"))
}
