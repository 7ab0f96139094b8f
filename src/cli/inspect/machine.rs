//! What is in a machine.

use std::io::Write;

use slideway::base::{Chain, Modes};
use slideway::machine::Machine;
use slideway::plant::Plant as _;
use slideway::plant::rapier::Rig;
use slideway::solid::{Link, Shape, Side};
use slideway::units::{Motion, engineering};

use crate::cli::Failure;
use crate::cli::stability::stability;
use crate::cli::table::Table;

/// Parts of the description in hardware order; modes are shown by themselves.
const PARTS: [&str; 8] =
    ["reference", "controller", "amplifier", "motor", "guide", "encoder", "current_sensor", "tolerance"];

/// Shows a machine.
pub(super) fn show(machine: &Machine, out: &mut dyn Write) -> Result<(), Failure> {
    let description = machine.description();
    let solid = machine.solid();
    writeln!(out, "machine    {}", description.name)?;
    writeln!(out, "file       {}", machine.file().display())?;
    writeln!(out, "period     {}", engineering(description.sample_period_s, "s"))?;
    write!(out, "{}", stability(machine))?;
    let joint = &solid.joint;
    writeln!(
        out,
        "joint      {}, {}, from {} to {}",
        joint.name,
        joint.motion,
        length_or_angle(joint.lower, joint.motion),
        length_or_angle(joint.upper, joint.motion)
    )?;
    parts(machine, out)?;
    links(machine, out)?;
    base(machine, out)?;
    effects(machine, out)?;
    sliders(machine, out)
}

fn length_or_angle(value: f64, motion: Motion) -> String {
    let unit = match motion {
        Motion::Prismatic => "m",
        Motion::Revolute => "rad",
    };
    if value.is_finite() { engineering(value, unit) } else { "no limit".to_owned() }
}

/// Every part with its keys, defaults included.
fn parts(machine: &Machine, out: &mut dyn Write) -> Result<(), Failure> {
    writeln!(out, "\nparts in the order of the signal path, defaults included")?;
    let table = toml::Table::try_from(machine.description()).unwrap_or_else(|_| machine.table().clone());
    for part in PARTS {
        match table.get(part) {
            Some(toml::Value::Table(keys)) if !keys.is_empty() => {
                let list: Vec<String> = keys.iter().map(|(key, value)| format!("{key} = {value}")).collect();
                writeln!(out, "  {part:<15}{}", list.join(", "))?;
            }
            _ => writeln!(out, "  {part:<15}not stated")?,
        }
    }
    Ok(())
}

fn links(machine: &Machine, out: &mut dyn Write) -> Result<(), Failure> {
    let solid = machine.solid();
    writeln!(out, "\nsolid model  {}", solid.path.display())?;
    let mut table =
        Table::new(["link", "moves", "mass", "shape", "triangles", "volume", "mass over volume"]).left(2);
    for (side, link) in solid.links() {
        let moves = if side == Side::Moving { "yes" } else { "no" };
        let [shape, triangles, volume, density] = geometry(link);
        let mass = engineering(link.mass.mass_kg, "kg");
        table.row([link.name.clone(), moves.to_owned(), mass, shape, triangles, volume, density]);
    }
    table.write(out)?;
    writeln!(out, "  every mesh is closed, faces outwards and is of a machine part's size")?;
    let constants = machine.constants();
    let unit = if machine.motion() == Motion::Prismatic { "kg" } else { "kg·m²" };
    writeln!(out, "  base {}", engineering(solid.base.mass.mass_kg, "kg"))?;
    writeln!(out, "  moving {}", engineering(solid.moving.mass.mass_kg, "kg"))?;
    writeln!(
        out,
        "  along the joint {:.4} {unit}, with effects {:.4} {unit}",
        solid.moving_inertia_along_joint(),
        constants.moving_mass
    )?;
    writeln!(out, "  weight along the joint {}", weight(machine))?;
    Ok(())
}

/// Weight along the joint in words.
fn weight(machine: &Machine) -> String {
    let Some(weight) = machine.weight() else { return "none".to_owned() };
    match weight.hanging_rad() {
        None => format!("{:.4} N at every position", weight.effort(0.0)),
        Some(hanging) => format!("up to {:.4} N·m, hangs at {hanging:.4} rad", weight.largest()),
    }
}

/// Shape, triangles, volume in litres and the density that mass and volume make.
fn geometry(link: &Link) -> [String; 4] {
    let dash = || "-".to_owned();
    if link.geometry.is_empty() {
        return ["none".to_owned(), dash(), dash(), dash()];
    }
    let mut words: Vec<&str> = Vec::new();
    let mut triangles = 0;
    for geometry in &link.geometry {
        words.push(match &geometry.shape {
            Shape::Mesh { mesh, .. } => {
                triangles += mesh.triangles.len();
                "mesh"
            }
            Shape::Box { .. } => "box",
            Shape::Cylinder { .. } => "cylinder",
            Shape::Sphere { .. } => "sphere",
        });
    }
    // Of density 1 kg/m³, mass is volume.
    let volume = link.mass_from_geometry(1.0).mass_kg;
    [
        words.join(" + "),
        if triangles > 0 { triangles.to_string() } else { dash() },
        format!("{:.3} l", 1000.0 * volume),
        format!("{:.0} kg/m³", link.mass.mass_kg / volume),
    ]
}

fn base(machine: &Machine, out: &mut dyn Write) -> Result<(), Failure> {
    let Some(base) = &machine.description().base else {
        writeln!(out, "\nbase  rigid: no modes stated")?;
        return Ok(());
    };
    writeln!(out, "\nbase modes at the motor's reaction point")?;
    let mut table = Table::new(["mode", "frequency", "modal mass", "damping ratio", "stiffness"]);
    for (place, mode) in base.mode.iter().enumerate() {
        table.row([
            (place + 1).to_string(),
            format!("{} Hz", mode.frequency_hz()),
            format!("{} kg", mode.mass_kg()),
            mode.damping_ratio().to_string(),
            stiffness(mode.stiffness_n_per_m()),
        ]);
    }
    table.write(out)?;
    let modes = Modes::new(base.mode.clone());
    match Chain::from_modes(&modes) {
        Ok(chain) => {
            writeln!(out, "equivalent chain, driven at mass 1")?;
            let mut table = Table::new(["mass", "kg", "spring to the next (the last: to ground)"]);
            let springs = chain.springs_n_per_m();
            for (place, (mass, spring)) in chain.masses_kg().iter().zip(springs).enumerate() {
                table.row([(place + 1).to_string(), format!("{mass:.2}"), stiffness(*spring)]);
            }
            table.write(out)?;
        }
        Err(error) => writeln!(out, "no equivalent chain: {}", error.statement())?,
    }
    Ok(())
}

fn stiffness(n_per_m: f64) -> String {
    format!("{:.3} N/µm", n_per_m / 1e6)
}

fn effects(machine: &Machine, out: &mut dyn Write) -> Result<(), Failure> {
    writeln!(out, "\neffects that the twin has")?;
    let acting = machine.effects();
    if acting.is_empty() {
        writeln!(out, "  none")?;
    }
    for effect in acting {
        let id = effect.id();
        let values: Vec<String> = id
            .parameters()
            .iter()
            .filter_map(|parameter| {
                let keys = [parameter.name, parameter.revolute_name];
                let value = keys.iter().find_map(|k| machine.number(&format!("effect.{}.{k}", id.name())))?;
                Some(format!("{} = {value}", parameter.name))
            })
            .collect();
        writeln!(out, "  {} ({}): {}", id.name(), id.site().name(), values.join(", "))?;
    }
    Ok(())
}

fn sliders(machine: &Machine, out: &mut dyn Write) -> Result<(), Failure> {
    let names = &machine.description().guide.sliders;
    let Some(loads) = Rig::new(machine)?.slider_loads() else { return Ok(()) };
    writeln!(out, "\nloads on the sliders at rest")?;
    let mut table = Table::new(["slider", "vertical load N"]);
    for (name, load) in names.iter().zip(loads) {
        table.row([name.clone(), format!("{load:.2}")]);
    }
    table.row(["together".to_owned(), format!("{:.2}", loads.iter().sum::<f64>())]);
    table.write(out)?;
    Ok(())
}
