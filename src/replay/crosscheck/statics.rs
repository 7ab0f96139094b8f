//! What needs no replay: masses, loads at rest, oscillations of the assembled system.

use super::super::PlantChoice;
use super::bounds::{self, Bound};
use crate::error::Result;
use crate::guide::StepForce;
use crate::machine::Machine;
use crate::plant::axis::Axis;
use crate::plant::mujoco::{self, MujocoRig};
use crate::plant::rapier::{Rig, STEP_S, Scene};
use crate::plant::{Drive, LoadModel, Plant, Resonance};
use crate::solid::{GRAVITY_M_PER_S2, MassProperties};
use crate::units::Motion;
use nalgebra::{Point3, Vector3};

/// Steps at rest until a scene's joint carries the weight.
const STEPS_AT_REST: usize = 16;

/// One quantity from every engine that knows it.
#[derive(Debug, Clone)]
pub struct Static {
    /// What it is.
    pub quantity: String,
    /// Its SI unit; 1 for a ratio.
    pub unit: &'static str,
    /// From solid model and axis, from rapier, from MuJoCo.
    pub values: [Option<f64>; 3],
    /// What differences are divided by.
    pub scale: f64,
    /// The bound on the relative difference.
    pub bound: Bound,
}

impl Static {
    /// Largest difference between two engines, relative; none where only one knows it.
    pub fn difference(&self) -> Option<f64> {
        let known: Vec<f64> = self.values.into_iter().flatten().collect();
        let (first, others) = known.split_first()?;
        let range = others.iter().fold([*first; 2], |[low, high], x| match x.is_nan() {
            true => [f64::NAN; 2],
            false => [low.min(*x), high.max(*x)],
        });
        (!others.is_empty()).then(|| (range[1] - range[0]) / self.scale)
    }

    /// Whether the bound is exceeded; what is not a number exceeds it.
    pub fn is_exceeded(&self) -> bool {
        self.difference().is_some_and(|difference| difference.is_nan() || difference > self.bound.limit)
    }
}

/// All rows; `subjects` holds the machine of each plant.
pub(super) fn of(subjects: &[(PlantChoice, Machine)]) -> Result<Vec<Static>> {
    let machine = |plant| subjects.iter().find(|(of, _)| *of == plant).map(|(_, machine)| machine);
    let Some(ours) = machine(PlantChoice::Axis) else { return Ok(Vec::new()) };
    let rapier = machine(PlantChoice::Rapier).unwrap_or(ours);
    let mut mujoco = match machine(PlantChoice::Mujoco) {
        Some(machine) if mujoco::IS_BUILT_IN => Some(MujocoRig::new(machine)?),
        _ => None,
    };
    let mut rows = masses(ours, pushed_inertia(rapier)?, mujoco.as_ref());
    rows.extend(loads(ours, &mut Rig::new(rapier)?, mujoco.as_mut()));
    let theirs = mujoco.as_ref().map(MujocoRig::resonances);
    rows.extend(oscillations(&Axis::of(&ours.constants()).resonances(), theirs.as_deref()));
    Ok(rows)
}

fn masses(ours: &Machine, pushed: f64, mujoco: Option<&MujocoRig>) -> Vec<Static> {
    let (solid, is_sliding) = (ours.solid(), ours.motion() == Motion::Prismatic);
    let moving = &solid.moving.mass;
    let imported = mujoco.map(MujocoRig::imported);
    let inertia = ours.constants().moving_mass;
    let row = |quantity: &str, unit, values, scale| Static {
        quantity: quantity.to_owned(),
        unit,
        values,
        scale,
        bound: bounds::MASS,
    };
    let along = if is_sliding { ("moving mass", "kg") } else { ("inertia about the joint", "kg·m²") };
    let total = solid.total_mass_kg();
    let mut rows = vec![
        row("total mass", "kg", [Some(total), None, imported.map(|i| i.total_mass_kg)], total),
        row(along.0, along.1, [Some(inertia), Some(pushed), mujoco.map(MujocoRig::moving_inertia)], inertia),
    ];
    let trace = moving.inertia_kg_m2.trace();
    // A centre of mass has no size of its own.
    let gyration = (0.5 * trace / moving.mass_kg).sqrt();
    let both =
        |of: &dyn Fn(&MassProperties) -> f64| [Some(of(moving)), None, imported.map(|i| of(&i.moving))];
    for (k, axis) in ["x", "y", "z"].iter().enumerate() {
        let values = both(&|mass| mass.centre_m[k]);
        rows.push(row(&format!("centre of mass, {axis}"), "m", values, gyration));
    }
    for (i, j, name) in [(0, 0, "xx"), (1, 1, "yy"), (2, 2, "zz"), (0, 1, "xy"), (0, 2, "xz"), (1, 2, "yz")] {
        let values = both(&|mass| mass.inertia_kg_m2[(i, j)]);
        rows.push(row(&format!("inertia {name}"), "kg·m²", values, trace));
    }
    rows
}

/// What rapier accelerates by a unit effort along the joint: effort × step / change of velocity.
fn pushed_inertia(machine: &Machine) -> Result<f64> {
    let solid = &*machine.loaded_solid();
    let payload = machine.constants().moving_mass - solid.moving_inertia_along_joint();
    let mut scene = Scene::new(solid, STEP_S, Vector3::zeros())?.with_payload(payload)?;
    scene.apply(1.0, Point3::from(solid.moving.mass.centre_m));
    scene.step();
    Ok(STEP_S / scene.velocity())
}

/// Loads of the sliders while nothing drives the axis.
fn loads(ours: &Machine, rapier: &mut Rig, mujoco: Option<&mut MujocoRig>) -> Vec<Static> {
    let Some(model) = LoadModel::of(ours) else { return Vec::new() };
    let (at_rest, rapier) = (model.loads([0.0; 2]), rest(rapier));
    let mujoco = mujoco.and_then(rest);
    let weight = ours.constants().moving_mass * GRAVITY_M_PER_S2;
    let row = |k: usize| Static {
        quantity: format!("load at rest, slider {}", ["A", "B", "C", "D"][k]),
        unit: "N",
        values: [Some(at_rest[k]), rapier.map(|loads| loads[k]), mujoco.map(|loads| loads[k])],
        scale: weight,
        bound: bounds::LOAD_AT_REST,
    };
    (0..4).map(row).collect()
}

fn rest(plant: &mut impl Plant) -> Option<[f64; 4]> {
    plant.place(0.0, 0.0);
    for _ in 0..STEPS_AT_REST {
        plant.coast(Drive::Force(0.0));
        plant.advance(StepForce::ZERO, StepForce::ZERO);
    }
    let loads = plant.slider_loads();
    plant.place(0.0, 0.0);
    loads
}

/// Oscillations of table and base together, by frequency.
fn oscillations(ours: &[Resonance], theirs: Option<&[Resonance]>) -> Vec<Static> {
    let count = ours.len().max(theirs.map_or(0, <[Resonance]>::len));
    let mut rows = Vec::new();
    if count > 0 {
        rows.push(Static {
            quantity: "number of oscillations".to_owned(),
            unit: "1",
            values: [Some(ours.len() as f64), None, theirs.map(|list| list.len() as f64)],
            scale: 1.0,
            bound: bounds::COUNT,
        });
    }
    for k in 0..count {
        let (a, b) = (ours.get(k), theirs.and_then(|list| list.get(k)));
        let mut push = |quantity: String, unit, of: fn(&Resonance) -> f64, bound| {
            let values = [a.map(of), None, b.map(of)];
            let scale = a.or(b).map_or(1.0, of);
            rows.push(Static { quantity, unit, values, scale, bound });
        };
        push(format!("frequency {}", k + 1), "Hz", |r| r.frequency_hz, bounds::FREQUENCY);
        push(format!("damping ratio {}", k + 1), "1", |r| r.damping_ratio, bounds::DAMPING);
    }
    rows
}
