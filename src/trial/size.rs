//! Effects of any size: one number from barely there to large, everything else drawn.

use super::nominal;
use super::scale::Scale;
use crate::drive::motor::Circuit;
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::{Machine, Tolerance};
use crate::recording::Signal;
use rand::RngExt;
use rand::rngs::StdRng;
use std::f64::consts::TAU;

/// An effect with a size that is still open.
///
/// # Model
/// `values(s)` are the effect's parameters at size s, which runs over `range`. Constants that may be calibrated inside
/// their tolerance begin at half as much again as is [`Absorbed`]: nearer, a deviation is no cause. A feature of friction comes with
/// the friction that it modifies and is measured by itself: its size is what it does beyond [`Family::reduced`].
pub struct Family {
    /// The effect.
    pub effect: EffectId,
    /// Least and largest size.
    pub range: (f64, f64),
    /// The effects that it modifies.
    pub base: Vec<(EffectId, Vec<f64>)>,
    /// What is there at size zero beside them.
    pub reduced: Vec<(EffectId, Vec<f64>)>,
    values: Box<dyn Fn(f64) -> Vec<f64> + Send + Sync>,
}

/// Deviations of constants with a tolerance begin at so many times what is absorbed.
const BEYOND: f64 = 1.5;
/// Coulomb part of laws that hold Coulomb friction as a special case, as shares of the largest motor force.
const COULOMB_PART: (f64, f64) = (0.02, 0.08);
/// Periods along the axis as shares of the largest stroke: several fit into it.
const PERIODS: (f64, f64) = (0.08, 0.25);

impl Family {
    /// Draws everything but the size.
    pub fn draw(effect: EffectId, scale: &Scale, absorbed: &Absorbed, random: &mut StdRng) -> Self {
        let drawn = Drawn::of(scale, random);
        let (range, values) = match effect.site() {
            crate::effect::Site::Controller | crate::effect::Site::Amplifier => drive(effect, scale, drawn),
            crate::effect::Site::Motor => motor(effect, scale, absorbed, drawn),
            crate::effect::Site::Guide => guide(effect, scale, absorbed, drawn),
            crate::effect::Site::Structure => structure(effect, scale, absorbed, drawn),
            crate::effect::Site::Sensor => sensor(effect, scale, absorbed, drawn),
        };
        let mut base = Vec::new();
        if effect.modifies().contains(&EffectId::CoulombFriction) {
            base.push((EffectId::CoulombFriction, vec![drawn.coulomb]));
        }
        if effect.modifies().contains(&EffectId::ViscousFriction) && scale.constants.viscous == 0.0 {
            base.push((EffectId::ViscousFriction, vec![drawn.viscous]));
        }
        let reduced = match effect {
            // In proportion to Coulomb friction it is a constant force.
            EffectId::AsymmetricFriction => vec![(effect, vec![drawn.lean, 0.0])],
            _ => Vec::new(),
        };
        Self { effect, range, base, reduced, values }
    }

    /// The family on the friction that is there already, where that is what it modifies.
    #[must_use]
    pub fn beside(mut self, others: &[(EffectId, Vec<f64>)]) -> Self {
        for (effect, values) in &mut self.base {
            if let Some((_, there)) = others.iter().find(|(other, _)| other == effect) {
                values.clone_from(there);
            }
        }
        self
    }

    /// The parameters at a size, in the law's order.
    pub fn values(&self, size: f64) -> Vec<f64> {
        (self.values)(size)
    }
}

/// How far a constant may be off, as a fraction, before no combination of constants inside their tolerances stands for it.
///
/// # Model
/// Closed loop, mass, drag and force constant act as ratios to one another: a force constant off by 4 % is a mass off by
/// 3 % and a force constant off by 1 %, with the drag following. The voltage-to-force chain adds the resistance where no
/// current is logged that would tell it apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Absorbed {
    mass: f64,
    viscous: f64,
    force_constant: f64,
    resistance: f64,
    inductance: f64,
}

impl Absorbed {
    /// What the tolerances absorb on the logged signals.
    pub fn of(tolerance: &Tolerance, logged: &[Signal]) -> Self {
        let ratio = tolerance.mass.min(tolerance.viscous);
        let unseen = if logged.contains(&Signal::Current) { 0.0 } else { tolerance.resistance };
        Self {
            mass: tolerance.mass + tolerance.force_constant + unseen,
            viscous: tolerance.viscous + tolerance.mass + tolerance.force_constant + unseen,
            force_constant: tolerance.force_constant + ratio + unseen,
            resistance: tolerance.resistance
                + if unseen > 0.0 { tolerance.force_constant + ratio } else { 0.0 },
            inductance: tolerance.inductance + unseen,
        }
    }
}

type Values = Box<dyn Fn(f64) -> Vec<f64> + Send + Sync>;

/// What is drawn whatever the effect.
#[derive(Debug, Clone, Copy)]
struct Drawn {
    sign: f64,
    period: f64,
    phase: [f64; 2],
    second: f64,
    coulomb: f64,
    lean: f64,
    viscous: f64,
    share: [f64; 3],
}

impl Drawn {
    fn of(scale: &Scale, random: &mut StdRng) -> Self {
        let stated = scale.constants.viscous;
        Self {
            sign: if random.random_range(0.0..1.0) < 0.5 { -1.0 } else { 1.0 },
            period: scale.stroke.abs() * random.random_range(PERIODS.0..PERIODS.1),
            phase: [random.random_range(0.0..TAU), random.random_range(0.0..TAU)],
            second: random.random_range(0.0..0.4),
            coulomb: scale.force * random.random_range(COULOMB_PART.0..COULOMB_PART.1),
            lean: random.random_range(-0.3..0.3),
            viscous: if stated > 0.0 { stated } else { 0.1 * scale.force / scale.speed },
            share: [0, 1, 2].map(|_| random.random_range(0.0..1.0)),
        }
    }

    /// Two harmonics of amplitude s: period, then sine and cosine of each.
    fn wave(self) -> impl Fn(f64) -> Vec<f64> + Send + Sync {
        move |s| {
            let [first, second] = self.phase.map(f64::sin_cos);
            let t = s * self.second;
            vec![self.period, s * first.1, s * first.0, t * second.1, t * second.0]
        }
    }
}

fn one(value: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Values {
    Box::new(move |s| vec![value(s)])
}

/// A number between two, on a logarithmic scale.
fn between(from: f64, to: f64, share: f64) -> f64 {
    from * (to / from).powf(share)
}

fn drive(effect: EffectId, scale: &Scale, drawn: Drawn) -> ((f64, f64), Values) {
    let (volt, period) = (scale.voltage_v, scale.constants.sample_period_s);
    match effect {
        EffectId::PositionGain | EffectId::VelocityGain | EffectId::IntegralGain => {
            ((1e-4, 0.5), one(move |s| 1.0 + drawn.sign * s))
        }
        EffectId::VelocityFeedforward => {
            let stated = effect.neutral(&scale.constants).first().copied().unwrap_or(0.0);
            // Towards the middle of none and all, so that it stays between them.
            let sign = if stated < 0.5 { 1.0 } else { -1.0 };
            ((1e-4, 0.5), one(move |s| stated + sign * s))
        }
        EffectId::LoopDelay => ((5e-3, 4.0), one(move |s| s * period)),
        EffectId::VoltageSaturation => ((1e-3, 0.75), one(move |s| volt * (1.0 - s))),
        EffectId::DeadZone => ((1e-6, 0.1), one(move |s| s * volt)),
        _ => ((1e-6, 0.3), one(move |s| drawn.sign * s * volt)),
    }
}

fn motor(effect: EffectId, scale: &Scale, absorbed: &Absorbed, drawn: Drawn) -> ((f64, f64), Values) {
    let neutral = effect.neutral(&scale.constants).first().copied().unwrap_or(0.0);
    let off = move |s: f64| neutral * (1.0 + drawn.sign * s);
    let beyond = |absorbed: f64, most: f64| ((BEYOND * absorbed).max(1e-4), most);
    let force = scale.force;
    match effect {
        EffectId::WindingResistance => (beyond(absorbed.resistance, 0.4), one(off)),
        EffectId::WindingInductance => (beyond(absorbed.inductance, 0.6), one(off)),
        EffectId::ForceConstant => (beyond(absorbed.force_constant, 0.25), one(off)),
        EffectId::BackEmf => {
            let whole = scale.voltage_v / scale.speed;
            // Against drag, a winding's resistance takes a voltage in proportion to speed as well.
            let like_it = match scale.constants.circuit {
                Circuit::Winding { resistance_ohm, force_constant, .. } => {
                    resistance_ohm * scale.constants.viscous / force_constant
                }
                Circuit::Direct { .. } => 0.0,
            };
            let least = BEYOND * absorbed.resistance * like_it / whole;
            ((least.max(1e-5), 1.5), one(move |s| neutral + s * whole))
        }
        EffectId::ForceRipple => ((1e-6, 0.2), Box::new(drawn.wave())),
        _ => ((1e-7, 0.2), Box::new(move |s| drawn.wave()(s * force).into_iter().collect())),
    }
}

fn guide(effect: EffectId, scale: &Scale, absorbed: &Absorbed, drawn: Drawn) -> ((f64, f64), Values) {
    let (force, stated, stroke) = (scale.force, scale.constants.viscous, scale.stroke);
    let weight = 9.81 * (scale.constants.moving_mass - scale.constants.rotor_inertia);
    let (coulomb, viscous, sign, lean) = (drawn.coulomb, drawn.viscous, drawn.sign, drawn.lean);
    match effect {
        EffectId::ViscousFriction if stated > 0.0 => {
            (((BEYOND * absorbed.viscous).max(1e-4), 0.9), one(move |s| stated * (1.0 + sign * s)))
        }
        EffectId::ViscousFriction => ((1e-5, 3.0), one(move |s| s * viscous)),
        EffectId::CoulombFriction => ((1e-6, 0.2), one(move |s| s * force)),
        EffectId::LoadDependentFriction if scale.constants.has_slider_loads => {
            ((1e-6, 0.2), one(move |s| s * force / weight))
        }
        EffectId::LoadDependentFriction => ((1e-4, 0.4), one(move |s| s)),
        EffectId::AsymmetricFriction => ((1e-4, 0.8), Box::new(move |s| vec![lean, sign * s])),
        EffectId::StribeckFriction => {
            let slow = scale.speed * between(0.02, 0.1, drawn.share[0]);
            ((1e-3, 2.0), Box::new(move |s| vec![1.0 + s, slow]))
        }
        EffectId::Presliding => {
            let (travel, mass) = (stroke.abs(), scale.constants.moving_mass);
            let ratio = between(0.05, 0.5, drawn.share[0]);
            let values = move |s: f64| {
                let stiffness = coulomb / (s * travel);
                vec![stiffness, 2.0 * ratio * (stiffness * mass).sqrt()]
            };
            ((1e-7, 5e-3), Box::new(values))
        }
        EffectId::CableSpring => {
            let centre = stroke * drawn.share[0];
            ((1e-6, 0.5), Box::new(move |s| vec![s * force / stroke.abs(), centre]))
        }
        _ => ((1e-6, 0.3), one(move |s| sign * s * force)),
    }
}

fn structure(effect: EffectId, scale: &Scale, absorbed: &Absorbed, drawn: Drawn) -> ((f64, f64), Values) {
    let (mass, travel, sign) = (scale.constants.moving_mass, scale.stroke.abs(), drawn.sign);
    let modes = scale.constants.modes.as_slice();
    match effect {
        EffectId::Payload => ((BEYOND * absorbed.mass, 0.5), one(move |s| sign * s * mass)),
        EffectId::BaseModeShift => {
            let mode = 1.0 + (drawn.share[0] * modes.len() as f64).floor();
            ((0.005, 0.75), Box::new(move |s| vec![mode, 1.0 + sign * s, 1.0]))
        }
        EffectId::FlexibleMode => {
            let lowest = modes.iter().map(|m| m.frequency_hz()).fold(f64::INFINITY, f64::min);
            let nyquist = 0.5 / scale.constants.sample_period_s;
            let most = (0.85 * lowest).min(0.15 * nyquist);
            let frequency = between(0.25 * most, most, drawn.share[0]);
            let damping = between(0.015, 0.06, drawn.share[1]);
            ((1e-4, 0.5), Box::new(move |s| vec![frequency, mass / s, damping]))
        }
        EffectId::Backlash => ((1e-7, 5e-3), one(move |s| s * travel)),
        _ => {
            let both_flanks = 0.0;
            let values = move |s: f64| [&drawn.wave()(s * travel)[..3], &[both_flanks]].concat();
            ((1e-8, 1e-3), Box::new(values))
        }
    }
}

fn sensor(effect: EffectId, scale: &Scale, absorbed: &Absorbed, drawn: Drawn) -> ((f64, f64), Values) {
    let (travel, sign) = (scale.stroke.abs(), drawn.sign);
    let (step, period) = (scale.constants.encoder_step, scale.constants.sample_period_s);
    match effect {
        EffectId::EncoderScale => {
            (((BEYOND * absorbed.force_constant).max(1e-4), 0.2), one(move |s| 1.0 + sign * s))
        }
        EffectId::EncoderPeriodicError => {
            ((1e-8, 1e-3), Box::new(move |s| drawn.wave()(s * travel)[..3].to_vec()))
        }
        EffectId::EncoderResolution => {
            let step = if step > 0.0 { step } else { 1e-6 * travel };
            ((3.0, 1e3), one(move |s| s * step))
        }
        _ => {
            let own = effect.neutral(&scale.constants).first().copied().unwrap_or(0.0);
            ((1e-3, 30.0), one(move |s| own + s * period))
        }
    }
}

/// A machine with effects in it, each by its parameters in the law's order.
///
/// # Errors
/// Parameters that the description refuses, or effects that cannot stand beside each other.
pub fn with_effects(machine: &Machine, effects: &[(EffectId, Vec<f64>)]) -> Result<Machine> {
    let mut settings: Vec<(String, toml::Value)> = Vec::new();
    for (effect, values) in effects {
        for (parameter, &value) in effect.parameters().iter().zip(values) {
            let path = format!("effect.{}.{}", effect.name(), parameter.key(machine.motion()));
            // A payload comes on top of what the mass is off by.
            let (path, value) = match effect {
                EffectId::Payload => nominal::payload(machine, value),
                _ => (path, value),
            };
            settings.push((path, toml::Value::Float(value)));
        }
    }
    machine.with_settings(settings.iter().map(|(path, value)| (path.as_str(), value.clone())))
}
