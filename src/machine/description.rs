//! What a machine file says.

use super::bounds::{CORRECT, finite, positive, range, within, zero_or_more};
use super::{CrosscheckPlan, Provenance, Tolerance, TunePlan};
use crate::base::Mode;
use crate::controller::filter::MOST_FILTERS;
use crate::controller::{AntiWindup, Cascade, Controller};
use crate::drive::amplifier::Amplifier;
use crate::drive::motor::Motor;
use crate::drive::transmission::Transmission;
use crate::effect::{EffectId, Effects};
use crate::error::{Error, ErrorKind, Result, toml_text};
use crate::guide::Guide;
use crate::sensor::{CurrentSensor, Encoder, LoadSensor};
use serde::{Deserialize, Serialize};

/// Sample periods of controllers, in s: faster than any drive's current loop, slower than any position loop.
const SHORTEST_PERIOD_S: f64 = 1e-7;
const LONGEST_PERIOD_S: f64 = 1.0;
/// A force attacks within this distance of the moving body's frame, in m.
const FARTHEST_LINE_M: f64 = 100.0;

/// The content of `machine.toml`: one table per part, in the order of the signal path.
///
/// Each part is its own configuration and carries its own law; this type only gathers them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// What the machine is called in reports.
    pub name: String,
    /// The URDF file, relative to the machine file.
    pub urdf: String,
    /// The driven joint, where the URDF has more than one that moves.
    #[serde(default)]
    pub joint: Option<String>,
    /// Further joints that could move and are held at zero.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held_joints: Vec<String>,
    /// Sample period of the controller in s.
    pub sample_period_s: f64,
    /// How references come about and when the controller acts on them.
    #[serde(default)]
    pub reference: ReferenceGenerator,
    /// The control law; absent where it is not known.
    #[serde(default)]
    pub controller: Option<Controller>,
    /// The amplifier.
    #[serde(default)]
    pub amplifier: Amplifier,
    /// The motor.
    pub motor: Motor,
    /// What lies between motor and joint; absent: the motor drives the joint directly.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transmission: Option<Transmission>,
    /// The screw, where the axis is one's nut.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub screw: Option<Screw>,
    /// The guide.
    #[serde(default)]
    pub guide: Guide,
    /// The base, where its modes are known.
    #[serde(default)]
    pub base: Option<Base>,
    /// The position encoder and the velocity estimate formed from it.
    pub encoder: Encoder,
    /// A second position sensor at the load.
    #[serde(default)]
    pub load_sensor: Option<LoadSensor>,
    /// The current sensor.
    #[serde(default)]
    pub current_sensor: CurrentSensor,
    /// How far the stated constants may be off before that is a cause.
    #[serde(default)]
    pub tolerance: Tolerance,
    /// Effects that the twin already has, a table per effect.
    #[serde(default)]
    pub effect: Effects,
    /// Strokes on which the plants are held against each other; where absent, strokes of the axis' own size.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crosscheck: Option<CrosscheckPlan>,
    /// How the controller is tuned; nothing that the twin reads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tune: Option<TunePlan>,
    /// Diagnoses that wrote values into this file, the newest last; nothing that the twin reads.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub provenance: Vec<Provenance>,
}

/// A screw that moves the axis: where errors that repeat with its turns are looked for. What the motor's side of it weighs is
/// the transmission's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Screw {
    /// Travel in one turn, in m.
    pub lead_m: f64,
}

/// The machine base.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Base {
    /// Its modes at the point that receives the motor's reaction.
    pub mode: Vec<Mode>,
}

/// How the controller shapes a stroke into a position reference (trapezoidal velocity), and when it acts on one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ReferenceGenerator {
    /// Time from rest to the commanded feed, in s.
    pub acceleration_time_s: f64,
    /// Time from a reference, as it is recorded, to the controller acting on it, in s; see
    /// [`ReferenceDelay`](crate::controller::ReferenceDelay).
    pub delay_s: f64,
}

impl Default for ReferenceGenerator {
    fn default() -> Self {
        Self { acceleration_time_s: 0.02, delay_s: 0.0 }
    }
}

impl Description {
    /// Whether encoder and current sensor are stated without noise and steps.
    pub fn has_perfect_sensors(&self) -> bool {
        self.encoder.noise_m == 0.0 && self.encoder.resolution_m == 0.0 && self.current_sensor.noise_a == 0.0
    }

    /// Refuses numbers outside the range that their meaning allows.
    ///
    /// # Errors
    /// The first such number, with its key path.
    pub fn check(&self) -> Result<()> {
        if !(SHORTEST_PERIOD_S..=LONGEST_PERIOD_S).contains(&self.sample_period_s) {
            let expected =
                format!("{SHORTEST_PERIOD_S} s to {LONGEST_PERIOD_S} s, as controllers are sampled");
            return Err(range("sample_period_s", self.sample_period_s, &expected));
        }
        zero_or_more("reference.acceleration_time_s", self.reference.acceleration_time_s)?;
        zero_or_more("reference.delay_s", self.reference.delay_s)?;
        self.check_controller()?;
        self.check_drive()?;
        zero_or_more("guide.viscous_n_s_per_m", self.guide.viscous_n_s_per_m)?;
        zero_or_more("encoder.resolution_m", self.encoder.resolution_m)?;
        zero_or_more("encoder.noise_m", self.encoder.noise_m)?;
        if let Some(fault) = self.encoder.velocity.fault() {
            return Err(faulty("encoder.velocity", &fault));
        }
        if let Some(sensor) = &self.load_sensor {
            zero_or_more("load_sensor.resolution_m", sensor.resolution_m)?;
            zero_or_more("load_sensor.noise_m", sensor.noise_m)?;
        }
        zero_or_more("current_sensor.noise_a", self.current_sensor.noise_a)?;
        self.tolerance.check()?;
        self.crosscheck.as_ref().map_or(Ok(()), CrosscheckPlan::check)?;
        self.tune.as_ref().map_or(Ok(()), TunePlan::check)?;
        if let Some((key, fault)) = self.effect.fault() {
            return Err(faulty(&key, &fault));
        }
        match EffectId::ALL
            .iter()
            .find(|effect| self.effect.contains(**effect) && !effect.has_modified(|of| self.has(of)))
        {
            None => Ok(()),
            Some(orphan) => {
                let modified: Vec<&str> = orphan.modifies().iter().map(|effect| effect.name()).collect();
                Err(Error::new(ErrorKind::Inconsistent)
                    .key(format!("effect.{}", orphan.name()))
                    .found("a feature without what it modifies")
                    .expected(format!("effect.{} stated too", modified.join(" or effect.")))
                    .remedy("state it, or take the feature out"))
            }
        }
    }

    /// Whether the guide has what an effect states by its own number: its drag.
    pub fn guide_has(&self, effect: EffectId) -> bool {
        effect == EffectId::ViscousFriction && self.guide.viscous_n_s_per_m > 0.0
    }

    /// Whether the file states an effect, or has it in its guide.
    pub fn has(&self, effect: EffectId) -> bool {
        self.effect.contains(effect) || self.guide_has(effect)
    }

    fn check_controller(&self) -> Result<()> {
        match &self.controller {
            None => Ok(()),
            Some(Controller::Pdf(pdf)) => {
                gain("controller.integral", f64::from(pdf.integral.value()))?;
                gain("controller.proportional", f64::from(pdf.proportional.value()))?;
                gain("controller.integral_gain_per_count", pdf.integral_gain_per_count)?;
                gain("controller.proportional_gain_per_count", pdf.proportional_gain_per_count)?;
                positive("controller.velocity_units_per_si", pdf.velocity_units_per_si)?;
                gain("controller.position_gain_per_s", pdf.position_gain_per_s)?;
                finite("controller.velocity_feedforward", pdf.velocity_feedforward)
            }
            Some(Controller::Cascade(cascade)) => {
                gain("controller.position_gain_per_s", cascade.position_gain_per_s)?;
                gain("controller.velocity_gain_v_s_per_m", cascade.velocity_gain_v_s_per_m)?;
                gain("controller.velocity_integral_per_s", cascade.velocity_integral_per_s)?;
                finite("controller.velocity_feedforward", cascade.velocity_feedforward)?;
                self.check_limit(cascade)
            }
            Some(Controller::Pd(law)) => {
                gain("controller.position_gain_v_per_m", law.position_gain_v_per_m)?;
                gain("controller.derivative_gain_v_s_per_m", law.derivative_gain_v_s_per_m)?;
                finite("controller.velocity_feedforward", law.velocity_feedforward)
            }
        }?;
        self.check_filters()
    }

    fn check_filters(&self) -> Result<()> {
        let filters = self.controller.as_ref().map_or(&[][..], Controller::filters);
        if filters.len() > MOST_FILTERS {
            return Err(Error::new(ErrorKind::OutOfRange)
                .key("controller.filter")
                .found(format!("{} filters", filters.len()))
                .expected(format!("at most {MOST_FILTERS}"))
                .remedy("leave out those that act outside the band of the axis"));
        }
        let faults = filters.iter().filter_map(|filter| filter.fault(self.sample_period_s));
        match faults.into_iter().next() {
            None => Ok(()),
            Some((key, fault)) => Err(Error::new(ErrorKind::OutOfRange)
                .key(format!("controller.filter.{key}"))
                .found(fault)
                .remedy("correct the filter")),
        }
    }

    fn check_limit(&self, cascade: &Cascade) -> Result<()> {
        if let Some(limit) = cascade.effort_limit_v {
            positive("controller.effort_limit_v", limit)?;
        } else if cascade.anti_windup != AntiWindup::None {
            return Err(Error::new(ErrorKind::Missing)
                .key("controller.effort_limit_v")
                .found("an anti_windup without a limit that would ask for it")
                .expected("the limit of the effort inside the controller, in V")
                .remedy("state effort_limit_v, or leave anti_windup out"));
        }
        match cascade.anti_windup {
            AntiWindup::BackCalculation { tracking_time_s }
                if !(tracking_time_s.is_finite() && tracking_time_s >= self.sample_period_s) =>
            {
                let expected = format!("at least the sample period, {} s", self.sample_period_s);
                Err(range("controller.anti_windup.tracking_time_s", tracking_time_s, &expected))
            }
            _ => Ok(()),
        }
    }

    fn check_drive(&self) -> Result<()> {
        if let Some(limit) = self.amplifier.voltage_limit_v {
            positive("amplifier.voltage_limit_v", limit)?;
        }
        zero_or_more("amplifier.delay_s", self.amplifier.delay_s)?;
        zero_or_more("amplifier.dead_zone_v", self.amplifier.dead_zone_v)?;
        finite("amplifier.offset_v", self.amplifier.offset_v)?;
        for (place, point) in self.motor.lines_of_action_m().iter().enumerate() {
            let key = format!("motor.lines_of_action_m.{place}");
            point.iter().try_for_each(|x| within(&key, *x, f64::NEG_INFINITY, FARTHEST_LINE_M))?;
        }
        if let Some(pitch) = self.motor.magnet_pitch() {
            positive("motor.magnet_pitch_m", pitch)?;
        }
        if let Some(screw) = &self.screw {
            positive("screw.lead_m", screw.lead_m)?;
        }
        if let Some(supply) = self.amplifier.supply_v {
            positive("amplifier.supply_v", supply)?;
        }
        if let Some(transmission) = &self.transmission {
            positive("transmission.ratio", transmission.ratio)?;
            zero_or_more("transmission.rotor_inertia_kg_m2", transmission.rotor_inertia_kg_m2)?;
        }
        match &self.motor {
            Motor::Winding(winding) => {
                positive("motor.resistance_ohm", winding.resistance_ohm)?;
                positive("motor.inductance_h", winding.inductance_h)?;
                positive("motor.force_constant_n_per_a", winding.force_constant_n_per_a)?;
                zero_or_more("motor.back_emf_v_s_per_m", winding.back_emf_v_s_per_m)
            }
            Motor::CurrentLoop(current_loop) => {
                positive("motor.command_a_per_v", current_loop.command_a_per_v)?;
                positive("motor.time_constant_s", current_loop.time_constant_s)?;
                if let Some(limit) = current_loop.current_limit_a {
                    positive("motor.current_limit_a", limit)?;
                }
                positive("motor.force_constant_n_per_a", current_loop.force_constant_n_per_a)
            }
            Motor::Direct(direct) => positive("motor.force_n_per_v", direct.force_n_per_v),
        }
    }
}

/// What a check says in one sentence, shared out: the key of the number at fault, what it is, what it should be.
fn faulty(table: &str, fault: &str) -> Error {
    let is_name = |name: &&str| !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || c == '_');
    let name = fault.split_once(" = ").map(|(name, _)| name).filter(is_name);
    let key = name.map_or_else(|| table.to_owned(), |name| format!("{table}.{name}"));
    toml_text::explained(Error::new(ErrorKind::OutOfRange).key(key), fault).remedy(CORRECT)
}

/// Refuses a gain with which the loop would drive the axis away from its reference.
fn gain(key: &str, value: f64) -> Result<()> {
    let negative = |error: Error| {
        match value < 0.0 {
        true => error.remedy(
            "a negative gain feeds back with the wrong sign, and the loop is unstable: write the gain without its sign",
        ),
        false => error,
    }
    };
    zero_or_more(key, value).map_err(negative)
}
