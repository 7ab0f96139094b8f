//! The machine description: the parts gathered from one folder, with every number at a key path.
//!
//! A machine is a folder with `machine.toml`, the URDF and meshes it names, and a README that gives the
//! source of every number. A new machine is a new folder; nothing in this crate knows one by name.

mod bounds;
mod carried;
mod criterion;
mod description;
mod file_tables;
mod file_text;
mod key_path;
mod plans;
pub mod provenance;
mod schema;
#[cfg(test)]
mod shipped;
mod stated;
mod tolerance;
mod turned;
mod write;

pub use criterion::Criterion;
pub use description::{Base, Description, ReferenceGenerator, Screw};
pub use file_tables::{FileKey, FileTable, file_tables};
pub use plans::{CrosscheckPlan, TunePlan, Vary};
pub use provenance::Provenance;
pub use schema::schema;
#[cfg(test)]
pub(crate) use shipped::shipped;
pub use tolerance::Tolerance;
pub use turned::turned;

use crate::base::Modes;
use crate::confine;
use crate::drive::motor::{Circuit, Motor};
use crate::drive::transmission::Transmission;
use crate::effect::{Constants, Effect, EffectId};
use crate::error::{Error, ErrorKind, Result, toml_text};
use crate::guide::DryFriction;
use crate::sensor::{End, LogScale};
use crate::solid::{Solid, Weight};
use crate::units::Motion;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Bytes of a machine file at most.
const MOST_BYTES: u64 = 16 << 20;
/// Keys that say which solid model is read.
const FIXED: [&str; 3] = ["urdf", "joint", "held_joints"];
/// Bearing sliders A–D.
const SLIDERS: usize = 4;

/// A machine: its description, its solid model and the settings laid over the file.
///
/// # Design
/// A parameter is a TOML key path (`controller.integral`, `effect.coulomb_friction.force_n`). Setting one
/// changes the parsed TOML tree and reads the description anew, so a candidate of a fit passes the same
/// validation as a file, and one name serves as struct field, TOML key, fit parameter and report row.
#[derive(Debug, Clone)]
pub struct Machine {
    file: PathBuf,
    table: Arc<toml::Table>,
    description: Arc<Description>,
    solid: Arc<Solid>,
    /// Laws beside those of the description; see [`with_probe`](Self::with_probe).
    probes: Vec<Effect>,
}

impl Machine {
    /// Reads a machine folder, or a machine file of any name in it.
    ///
    /// # Errors
    /// File missing, TOML syntax, unknown or missing key (with line), a value out of range (with key), or
    /// anything wrong with the URDF and its meshes.
    pub fn read(path: &Path) -> Result<Self> {
        let file = if path.is_dir() { path.join("machine.toml") } else { path.to_path_buf() };
        let text = confine::read_text(&file, MOST_BYTES)
            .map_err(|e| e.remedy("give a machine folder (with machine.toml) or a machine file"))?;
        let table: toml::Table = toml::from_str(&text).map_err(|e| toml_text::refusal(&file, &text, &e))?;
        let description: Description = toml::from_str(&text).map_err(|e| {
            // Of what is missing all is told at once; of what is wrong the line.
            let is_lack = e.message().starts_with("missing field");
            let lacking = stated::check_complete(&table).err().filter(|_| is_lack);
            lacking.map_or_else(|| toml_text::refusal(&file, &text, &e), |lacking| lacking.file(&file))
        })?;
        description.check().map_err(|e| e.file(&file))?;
        let folder = file.parent().unwrap_or(Path::new("."));
        let urdf = folder.join(&description.urdf);
        confine::check(&urdf, &[folder]).map_err(|e| e.file(&file).key("urdf"))?;
        let joint = description.joint.as_deref();
        let solid = Solid::import_of_machine(&urdf, joint, &description.held_joints, folder)?;
        stated::check_motion(&table, solid.joint.motion).map_err(|e| e.file(&file))?;
        let machine = Self {
            file,
            table: Arc::new(table),
            description: Arc::new(description),
            solid: Arc::new(solid),
            probes: Vec::new(),
        };
        machine.check_against_solid()?;
        let plan = machine.description.crosscheck.as_ref();
        plan.map_or(Ok(()), |plan| machine.check_cells("crosscheck", &plan.cells))?;
        machine.check_tune()?;
        Ok(machine)
    }

    /// The machine with values set at key paths; numbers and other TOML values alike.
    ///
    /// # Errors
    /// Unknown key path or a value that the description refuses.
    pub fn with_settings<'a>(
        &self,
        settings: impl IntoIterator<Item = (&'a str, toml::Value)>,
    ) -> Result<Self> {
        let mut table = (*self.table).clone();
        for (path, value) in settings {
            self.check_settable(path)?;
            key_path::set(&mut table, path, value).map_err(|e| e.file(&self.file))?;
        }
        self.with_table(table)
    }

    /// Refuses what is read once, with the file: setting it afterwards would change nothing.
    fn check_settable(&self, path: &str) -> Result<()> {
        if !FIXED.contains(&path.split('.').next().unwrap_or(path)) {
            return Ok(());
        }
        Err(Error::new(ErrorKind::Inconsistent)
            .file(&self.file)
            .key(path)
            .found("a setting of the solid model, which is read with the machine file")
            .expected("a key path of another part")
            .remedy("write a machine file with the other solid model, and name that"))
    }

    /// The machine without an effect that its file may state, and without the features that then modify nothing.
    ///
    /// # Errors
    /// None in practice: taking an effect away leaves a valid description.
    pub fn without_effect(&self, id: EffectId) -> Result<Self> {
        let mut table = (*self.table).clone();
        if let Some(toml::Value::Table(effects)) = table.get_mut("effect") {
            effects.remove(id.name());
            for effect in EffectId::ALL {
                let is_left =
                    |of: EffectId| effects.contains_key(of.name()) || self.description.guide_has(of);
                if !effect.has_modified(is_left) {
                    effects.remove(effect.name());
                }
            }
        }
        self.with_table(table)
    }

    /// The machine with a law more, which may be of a kind that it has already: a small one, of which replays tell the response. It acts in
    /// replays only: neither description nor TOML tree has it.
    #[must_use]
    pub fn with_probe(mut self, probe: Effect) -> Self {
        self.probes.push(probe);
        self
    }

    /// Whether replays of both are the same: one solid model, the same TOML tree, and no probes.
    pub(crate) fn replays_like(&self, other: &Self) -> bool {
        let has_probes = !self.probes.is_empty() || !other.probes.is_empty();
        !has_probes && Arc::ptr_eq(&self.solid, &other.solid) && self.table == other.table
    }

    fn with_table(&self, table: toml::Table) -> Result<Self> {
        let description: Description = table.clone().try_into().map_err(|e: toml::de::Error| {
            toml_text::explained(Error::new(ErrorKind::UnknownKey).file(&self.file), e.message())
                .remedy("write the key path as in machine.toml, for instance controller.integral=22")
        })?;
        description.check().map_err(|e| e.file(&self.file))?;
        let machine = Self {
            file: self.file.clone(),
            table: Arc::new(table),
            description: Arc::new(description),
            solid: Arc::clone(&self.solid),
            probes: self.probes.clone(),
        };
        machine.check_against_solid()?;
        Ok(machine)
    }

    /// Refuses an effect that the machine has nothing for: stated, it would be ignored. Of a closed current loop these are the resistance,
    /// the inductance and the back-EMF of the winding inside it.
    fn check_effects_act(&self) -> Result<()> {
        let stated = self.stated_constants();
        let Some(effect) = self.effects().into_iter().find(|e| e.id().has_nothing_to_change(&stated)) else {
            return Ok(());
        };
        Err(Error::new(ErrorKind::Inconsistent)
            .file(&self.file)
            .key(format!("effect.{}", effect.id().name()))
            .found("an effect of something that this machine does not have")
            .expected(format!(
                "a machine with it; `slideway effects {}` says what it acts on",
                effect.id().name()
            ))
            .remedy("take the effect out, or state what it acts on"))
    }

    fn check_against_solid(&self) -> Result<()> {
        let constants = self.constants();
        if constants.moving_mass.is_nan() || constants.moving_mass <= 0.0 {
            return Err(Error::new(ErrorKind::OutOfRange)
                .file(&self.file)
                .key("effect.payload")
                .found(format!("a moving mass of {}", constants.moving_mass))
                .expected("more than zero after the payload is added")
                .remedy("a negative payload must be smaller than the solid model's mass"));
        }
        self.check_lever()?;
        self.check_effects_act()?;
        if constants.rotor_inertia > 0.0 && !constants.modes.as_slice().is_empty() {
            return Err(Error::new(ErrorKind::Inconsistent)
                .file(&self.file)
                .key("transmission.rotor_inertia_kg_m2")
                .found("a rotor inertia beside modes of the base")
                .expected("one of the two: no plant has a rotor that turns while its base moves")
                .remedy("leave out [base], or add the rotor's inertia at the joint as effect.payload"));
        }
        let sliders = &self.description.guide.sliders;
        for (place, slider) in sliders.iter().enumerate() {
            if sliders[..place].contains(slider) {
                return Err(Error::new(ErrorKind::Inconsistent)
                    .file(&self.file)
                    .key("guide.sliders")
                    .found(format!("the slider `{slider}` twice"))
                    .expected("each slider once: A to D")
                    .remedy("name the other slider"));
            }
            self.solid.link(slider).map_err(|e| e.key(slider.clone()).file(&self.file))?;
        }
        Ok(())
    }

    /// The description as read, with the settings laid over it.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The solid model.
    pub fn solid(&self) -> &Solid {
        &self.solid
    }

    /// The file it was read from.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// The TOML tree, settings included.
    pub fn table(&self) -> &toml::Table {
        &self.table
    }

    /// What to say where a control law is needed and none is stated; what for and what else to do is the caller's to add.
    pub fn lacks_controller(&self) -> Error {
        Error::new(ErrorKind::Missing)
            .file(&self.file)
            .key("controller")
            .found("a machine without a control law")
            .expected("the table [controller]")
    }

    /// Prismatic or revolute.
    pub fn motion(&self) -> Motion {
        self.solid.joint.motion
    }

    /// Effects that act, in signal-path order; probes last.
    pub fn effects(&self) -> Vec<Effect> {
        let mut acting = self.description.effect.acting();
        acting.extend(self.probes.iter().cloned());
        acting
    }

    /// The value at a key path, where it is stated and is a number.
    pub fn number(&self, path: &str) -> Option<f64> {
        key_path::number(&self.table, path)
    }

    /// The constants of the twin as stated, before any effect.
    pub fn stated_constants(&self) -> Constants {
        let d = &*self.description;
        let rotor_inertia = d.transmission.as_ref().map_or(0.0, Transmission::inertia_at_joint);
        Constants {
            controller: d.controller.clone(),
            amplifier: match &d.motor {
                Motor::CurrentLoop(current_loop) => current_loop.limited(d.amplifier.clone()),
                Motor::Winding(_) | Motor::Direct(_) => d.amplifier.clone(),
            }
            .within_duty(),
            circuit: match &d.transmission {
                Some(transmission) => transmission.at_joint(Circuit::from(&d.motor)),
                None => Circuit::from(&d.motor),
            },
            stated_pitches: [
                d.motor.magnet_pitch(),
                d.screw.as_ref().map(|screw| screw.lead_m),
                d.transmission.as_ref().map(Transmission::turn),
            ]
            .into_iter()
            .flatten()
            .collect(),
            has_voltage_fed_winding: matches!(d.motor, Motor::Winding(_)),
            moving_mass: self.solid.moving_inertia_along_joint() + rotor_inertia,
            rotor_inertia,
            has_transmission: d.transmission.is_some(),
            has_turning_weight: self.motion() == Motion::Revolute
                && Weight::of(
                    &self.solid.joint,
                    &self.moving_body(),
                    self.solid.moving_inertia_along_joint(),
                )
                .is_some(),
            viscous: d.guide.viscous_n_s_per_m,
            friction: DryFriction::default(),
            has_slider_loads: d.guide.sliders.len() == SLIDERS && self.motion() == Motion::Prismatic,
            modes: d.base.as_ref().map_or_else(Modes::default, |b| Modes::new(b.mode.clone())),
            sees_load: d.load_sensor.is_some() || d.encoder.end == End::Load,
            sees_both_ends: d.load_sensor.is_some() && d.encoder.end == End::Motor,
            reading_step: 0.0,
            encoder_step: d.encoder.resolution_m,
            log_scale: LogScale::default(),
            velocity: d.encoder.velocity.clone(),
            sample_period_s: d.sample_period_s,
        }
    }

    /// Weight along the joint with the effects at work; none for a level guide or a part balanced about its axis.
    pub fn weight(&self) -> Option<Weight> {
        let constants = self.constants();
        let weighing = constants.moving_mass - constants.rotor_inertia;
        Weight::of(&self.solid.joint, &self.moving_body(), weighing)
    }

    /// The constants of the twin with its effects at work.
    pub fn constants(&self) -> Constants {
        let mut constants = self.stated_constants();
        for effect in self.effects() {
            effect.alter(&mut constants);
        }
        constants
    }
}
