//! What forged machines do otherwise than the diagnosing twin: a plant around a plant.

use super::bristle::{Fading, ForgedBristle};
use super::foreign::{Foreign, WarmingScale};
use crate::effect::{Effect, Unlike};
use crate::error::Result;
use crate::guide::{Bristle, Coast, DryFriction, GAUSSIAN, StepForce};
use crate::machine::Machine;
use crate::plant::{Drive, LoadFriction, Plant};
use crate::recording::Run;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// What a forged machine has that no law of the catalogue describes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Otherwise {
    /// Deflection δ after which dry friction slides where it has no presliding of its own, in m or rad; none: it is then by the twin's law.
    #[serde(default)]
    pub bristle_deflection: Option<f64>,
    /// Damping ratio of the bristles.
    pub bristle_damping: f64,
    /// How their damping fades.
    #[serde(default)]
    pub bristle_fading: Fading,
    /// Third and fourth harmonic of cogging and force ripple as shares of the first; the catalogue calibrates these as numbers of form.
    pub harmonics: [f64; 2],
    /// Their phases in rad.
    pub phases: [f64; 2],
    /// What no law describes at all, where the tier asks for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub foreign: Option<Foreign>,
}

impl Otherwise {
    /// Nothing but bristles under dry friction: a deflection in m or rad, and a damping ratio.
    pub const fn bristles(deflection: f64, damping: f64) -> Self {
        Self {
            bristle_deflection: Some(deflection),
            bristle_damping: damping,
            bristle_fading: Fading::HALF,
            harmonics: [0.0; 2],
            phases: [0.0; 2],
            foreign: None,
        }
    }

    /// What is logged of a run that was simulated so; see [`Foreign::logged`].
    ///
    /// # Errors
    /// A run with uneven time stamps, where something foreign acts.
    pub fn logged(&self, run: Run, machine: &Machine) -> Result<Run> {
        match &self.foreign {
            Some(foreign) => foreign.logged(run, machine),
            None => Ok(run),
        }
    }
}

/// Forces of a forged machine that its twin does not apply itself.
///
/// # Model
/// - Dry friction is [`ForgedBristle`]: its sliding level is that of the machine's dry friction at this speed and direction, the
///   load's part included. Its damping is drawn where the machine states none; it fades by a law of its own, e^λ sooner where the
///   machine states λ.
/// - Cogging and force ripple have a third and a fourth harmonic, shares of the first.
/// - What is [`Foreign`] acts as far as it acts on the plant: shocks push, and a warming scale in the loop shows its reading
///   in the place of the position.
#[derive(Debug, Clone)]
pub struct ForgedLaws {
    dry: DryFriction,
    /// Drag that the positive direction has more than the mean of both, in N·s/m or N·m·s/rad.
    drag: f64,
    bristle: Option<ForgedBristle>,
    loaded: Option<LoadFriction>,
    cogging: Option<Harmonics>,
    ripple: Option<Harmonics>,
    foreign: Option<Foreign>,
}

/// Harmonics beyond the second: amplitudes, phases and period.
#[derive(Debug, Clone, Copy)]
struct Harmonics {
    period: f64,
    amplitudes: [f64; 2],
    phases: [f64; 2],
}

impl Harmonics {
    fn new(otherwise: &Otherwise, period: f64, first: f64) -> Self {
        Self { period, amplitudes: otherwise.harmonics.map(|share| share * first), phases: otherwise.phases }
    }

    fn at(&self, position: f64) -> f64 {
        let angle = TAU * position / self.period;
        let wave = |k: usize| self.amplitudes[k] * ((k + 3) as f64 * angle + self.phases[k]).sin();
        wave(0) + wave(1)
    }
}

impl ForgedLaws {
    /// Splits a machine into the one that the twin walks and the laws around its plant.
    ///
    /// # Errors
    /// None in practice: taking an effect away leaves a valid machine.
    pub fn split(machine: &Machine, otherwise: &Otherwise) -> Result<(Machine, Self)> {
        let (effects, constants) = (machine.effects(), machine.constants());
        let dry = constants.friction;
        let mut walked = machine.clone();
        let loaded = LoadFriction::of(machine);
        let rest = loaded.as_ref().map_or(0.0, LoadFriction::usual);
        let spot = dry.local.map_or(0.0, |local| local.force.max(0.0));
        let standing = dry.at_rest_under(rest) + spot;
        let drawn =
            |stiffness: f64| 2.0 * otherwise.bristle_damping * (stiffness * constants.moving_mass).sqrt();
        let (stiffness, damping) = match dry.bristle {
            Some(Bristle { stiffness, damping, .. }) if damping > 0.0 => (stiffness, damping),
            Some(Bristle { stiffness, .. }) => (stiffness, drawn(stiffness)),
            None => match otherwise.bristle_deflection {
                Some(deflection) => (standing / deflection, drawn(standing / deflection)),
                None => (0.0, 0.0),
            },
        };
        let own = otherwise.bristle_fading;
        let fading = dry.bristle.map_or(own, |stated| Fading {
            share: own.share / stated.fading_factor,
            // What the machine's file does not say is the forged law's own.
            power: if stated.fading_exponent == GAUSSIAN { own.power } else { stated.fading_exponent },
        });
        let bristle =
            (standing > 0.0 && stiffness > 0.0).then_some(ForgedBristle { stiffness, damping, fading });
        // Without a bristle there is nothing to do otherwise.
        let is_forged = |effect: &&Effect| bristle.is_some() && effect.unlike() == Unlike::Bristles;
        for friction in effects.iter().filter(is_forged) {
            walked = walked.without_effect(friction.id())?;
        }
        let (mut cogging, mut ripple) = (None, None);
        for effect in &effects {
            match effect.unlike() {
                Unlike::ForceHarmonics { period, first } => {
                    cogging = Some(Harmonics::new(otherwise, period, first));
                }
                Unlike::RippleHarmonics { period, first } => {
                    ripple = Some(Harmonics::new(otherwise, period, first));
                }
                Unlike::Nothing | Unlike::Bristles => {}
            }
        }
        let laws = Self {
            drag: if bristle.is_some() { dry.drag(constants.viscous) } else { 0.0 },
            bristle,
            dry,
            loaded,
            cogging,
            ripple,
            foreign: otherwise.foreign.clone(),
        };
        Ok((walked, laws))
    }
}

/// A plant with the laws of a forged machine around it.
pub struct Forged<P> {
    inner: P,
    laws: ForgedLaws,
    deflection: f64,
    forces: [f64; 2],
    /// The step that was looked at.
    ahead: Option<Coast>,
    /// Time of the session in s.
    clock_s: f64,
}

impl<P: Plant> Forged<P> {
    /// The plant with these laws, the bristles undeflected, at a time of the session in s.
    pub fn new(inner: P, laws: ForgedLaws, clock_s: f64) -> Self {
        Self { inner, laws, deflection: 0.0, forces: [0.0; 2], ahead: None, clock_s }
    }

    /// The plant inside, which knows where the moving part is and not what a sensor shows.
    pub fn inner(&self) -> &P {
        &self.inner
    }

    /// The scale in the loop, where it warms.
    fn scale(&self) -> Option<&WarmingScale> {
        self.laws.foreign.as_ref().and_then(Foreign::in_loop)
    }

    /// Shocks over the coming step.
    fn shock(&self) -> StepForce {
        let step_s = self.inner.step_s();
        self.laws.foreign.as_ref().map_or(StepForce::ZERO, |foreign| foreign.push(self.clock_s, step_s))
    }

    /// Drag by which a direction differs from the mean of both.
    fn drag(&self, velocity: f64) -> f64 {
        -self.laws.drag * velocity.abs()
    }

    /// Friction over the step that ends so without it.
    fn friction(&mut self, coast: Coast) -> f64 {
        let Some(bristle) = self.laws.bristle else { return 0.0 };
        let position = self.inner.position();
        let [ahead, back] =
            self.laws.loaded.as_ref().map_or([0.0; 2], |friction| {
                friction.levels(self.inner.slider_loads(), self.forces, position)
            });
        let dry = self.laws.dry;
        let level = |velocity: f64| {
            let (direction, loaded) = if velocity < 0.0 { (-1.0, back) } else { (1.0, ahead) };
            dry.level_at(dry.level_under(loaded, direction, velocity.abs()), position, self.clock_s)
        };
        let (force, deflection) = bristle.step(self.deflection, coast, self.inner.step_s(), level);
        self.deflection = deflection;
        force
    }
}

impl<P: Plant> Plant for Forged<P> {
    fn step_s(&self) -> f64 {
        self.inner.step_s()
    }

    fn position(&self) -> f64 {
        let position = self.inner.position();
        self.scale().map_or(position, |scale| scale.reading(position, self.clock_s))
    }

    fn velocity(&self) -> f64 {
        self.inner.velocity()
    }

    fn current(&self) -> f64 {
        self.inner.current()
    }

    fn set_current(&mut self, current_a: f64) {
        self.inner.set_current(current_a);
    }

    fn coast(&mut self, drive: Drive) -> Coast {
        let ahead = self.inner.coast(drive);
        self.ahead = Some(ahead);
        ahead
    }

    fn advance(&mut self, motor: StepForce, guide: StepForce) {
        let Some(ahead) = self.ahead.take() else { return };
        let (begin, end) = (self.inner.position(), self.inner.position() + ahead.free_travel);
        let over = |harmonics: Option<Harmonics>, [first, last]: [f64; 2]| {
            harmonics.map_or(StepForce::ZERO, |h| StepForce::between(first * h.at(begin), last * h.at(end)))
        };
        let motor = motor + over(self.laws.ripple, ahead.motor_force);
        let guide = guide + over(self.laws.cogging, [1.0; 2]) + self.shock();
        let coast = ahead.under(motor + guide);
        let drag = StepForce::between(self.drag(coast.velocity), self.drag(coast.free_velocity));
        let guide = guide + drag + StepForce::held(self.friction(coast.under(drag)));
        self.inner.advance(motor, guide);
        let [first, last] = ahead.motor_force;
        self.forces = [0.5 * (first + last) + motor.mean, guide.mean];
        self.clock_s += self.inner.step_s();
    }

    fn place(&mut self, position: f64, velocity: f64) {
        let place = self.scale().map_or(position, |scale| scale.place(position, self.clock_s));
        self.inner.place(place, velocity);
        (self.deflection, self.forces) = (0.0, [0.0; 2]);
    }

    fn snapshot(&self) -> Vec<f64> {
        [vec![self.deflection, self.forces[0], self.forces[1]], self.inner.snapshot()].concat()
    }

    fn restore(&mut self, snapshot: &[f64]) {
        let (own, inner) = snapshot.split_at(3);
        (self.deflection, self.forces) = (own[0], [own[1], own[2]]);
        self.inner.restore(inner);
    }

    fn includes_other_forces(&self) -> bool {
        self.inner.includes_other_forces()
    }

    fn carries_weight(&self) -> bool {
        self.inner.carries_weight()
    }

    fn slider_loads(&mut self) -> Option<[f64; 4]> {
        self.inner.slider_loads()
    }
}
