//! What real machines have: draws of a law's parameters from what catalogues, standards and papers say of them.

use super::Constants;
use crate::units::Motion;
use rand::RngExt;
use rand::rngs::StdRng;
use std::f64::consts::TAU;

/// Magnet and slot pitches of linear motors in m.
///
/// Catalogues of iron-core and ironless linear motors; Boldea (2013), *Linear Electric Machines, Drives, and MAGLEVs Handbook*.
pub(super) const PITCHES_M: (f64, f64) = (0.010, 0.060);
/// Poles, slots and their least common multiple in a turn of rotary motors: 84 is that of 12 slots and 14 poles.
///
/// Zhu, Howe (2000), *Influence of design parameters on cogging torque in permanent magnet machines*.
pub(super) const A_TURN: (f64, f64) = (2.0, 84.0);
/// Radii in m at which bearings roll, seals rub and discs are graduated.
///
/// Dimension tables of rolling-bearing and rotary-encoder catalogues.
const RADII_M: (f64, f64) = (0.010, 0.050);
/// Resistance or inductance between two lines of a star-connected winding, beside that of a phase.
///
/// Any text on three-phase machines.
pub(super) const LINES_TO_PHASE: f64 = 2.0;
/// Voltage between two lines of a star-connected winding beside that of a phase, √3, and with it a constant that is stated for the one or the other.
///
/// Any text on three-phase machines.
pub(super) const LINE_VOLTAGE_TO_PHASE: f64 = 1.732_050_807_568_877_2;
/// Second harmonic of a pitch as a share of the first.
const SECOND: (f64, f64) = (0.0, 0.4);
/// Friction that a feature modifies where none is stated, as a share of the rated force: the middle of
/// [`CoulombFriction`](super::CoulombFriction)'s prior.
const FRICTION: f64 = 0.02;

/// What priors are scaled by: the machine alone, whatever its runs show.
///
/// Force means torque on a revolute axis. Every number but [`travel`](Self::travel) and [`coulomb`](Self::coulomb) is more than
/// zero, and [`travel`](Self::travel) is not zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Machinery {
    /// Constants of the machine as it really is before the hidden effect, friction that it states included.
    pub constants: Constants,
    /// How the axis moves.
    pub motion: Motion,
    /// Rated force of the motor at the joint in N, or N·m.
    pub rated_force: f64,
    /// Full scale of the effort in V: its limit where one is stated, else the largest that ordinary motion takes.
    pub voltage_v: f64,
    /// Largest feed in m/s, or rad/s.
    pub speed: f64,
    /// Travel that runs cover from where they begin in m, or rad; signed.
    pub travel: f64,
    /// Coulomb friction that a feature of friction would modify in N, or N·m; 0: none.
    pub coulomb: f64,
}

impl Machinery {
    /// One turn of the motor's shaft as the joint moves by it in rad; 2π without a transmission. For revolute axes.
    pub fn turn(&self) -> f64 {
        let stated = self.constants.stated_pitches.last().copied();
        stated.filter(|_| self.constants.has_transmission).unwrap_or(TAU)
    }

    /// Coulomb friction in N, or N·m, on which a feature of friction stands: that of the machine, or 2 % of the rated force
    /// where it has none.
    pub fn friction(&self) -> f64 {
        if self.coulomb > 0.0 { self.coulomb } else { FRICTION * self.rated_force }
    }
}

/// A source of random numbers, with the distributions that priors are made of.
#[derive(Debug)]
pub struct Prior<'a> {
    random: &'a mut StdRng,
}

impl<'a> Prior<'a> {
    /// Draws from a generator.
    pub fn new(random: &'a mut StdRng) -> Self {
        Self { random }
    }

    /// A number between two, whose logarithm is equally likely everywhere between theirs; both more than zero.
    pub fn log_uniform(&mut self, from: f64, to: f64) -> f64 {
        from * (to / from).powf(self.share())
    }

    /// A number between two, equally likely everywhere.
    pub fn uniform(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.share()
    }

    /// +1 or −1, equally likely.
    pub fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// An angle of a whole turn in rad.
    pub fn angle(&mut self) -> f64 {
        self.uniform(0.0, TAU)
    }

    /// One of several numbers, equally likely; not a number where there are none.
    pub fn one_of(&mut self, numbers: &[f64]) -> f64 {
        let k = self.random.random_range(0..numbers.len().max(1));
        numbers.get(k).copied().unwrap_or(f64::NAN)
    }

    /// A whole number between two, both included, equally likely.
    pub fn integer(&mut self, from: u32, to: u32) -> f64 {
        f64::from(self.random.random_range(from..=to.max(from)))
    }

    /// A whole number between two, both included, whose logarithm is about equally likely everywhere.
    pub fn count(&mut self, from: f64, to: f64) -> f64 {
        self.log_uniform(from, to).round()
    }

    /// Whether something of this probability happens.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.share() < probability
    }

    fn share(&mut self) -> f64 {
        self.random.random_range(0.0..1.0)
    }

    /// A length of a surface in m as the joint moves by it: itself on a prismatic axis; on a revolute one in rad, divided by a
    /// radius of 10 to 50 mm, which is that of its bearing, seal or disc. Velocities in m/s alike.
    pub fn at_surface(&mut self, length: f64, machine: &Machinery) -> f64 {
        match machine.motion {
            Motion::Prismatic => length,
            Motion::Revolute => length / self.uniform(RADII_M.0, RADII_M.1),
        }
    }

    /// A pitch at which a motor repeats: 10 to 60 mm, or 2π/n with n from 2 to 84 in a turn of the motor; m or rad.
    pub fn motor_pitch(&mut self, machine: &Machinery) -> f64 {
        match machine.motion {
            Motion::Prismatic => self.uniform(PITCHES_M.0, PITCHES_M.1),
            Motion::Revolute => machine.turn() / self.count(A_TURN.0, A_TURN.1),
        }
    }

    /// With probability one half one of the pitches that the machine file states, where it states any; m or rad.
    pub fn stated_pitch(&mut self, machine: &Machinery) -> Option<f64> {
        let stated = &machine.constants.stated_pitches;
        let is_one = !stated.is_empty() && self.chance(0.5);
        is_one.then(|| self.one_of(stated))
    }

    /// Two harmonics of a pitch: pitch, then sine and cosine of each. The second has 0 to 40 % of the first one's amplitude, and a
    /// phase of its own.
    pub fn wave(&mut self, pitch: f64, amplitude: f64) -> Vec<f64> {
        let (sine, cosine) = self.angle().sin_cos();
        let (sine_2, cosine_2) = self.angle().sin_cos();
        let second = amplitude * self.uniform(SECOND.0, SECOND.1);
        vec![pitch, amplitude * sine, amplitude * cosine, second * sine_2, second * cosine_2]
    }

    /// One harmonic of a pitch: pitch, sine, cosine.
    pub fn periodic(&mut self, pitch: f64, amplitude: f64) -> Vec<f64> {
        let (sine, cosine) = self.angle().sin_cos();
        vec![pitch, amplitude * sine, amplitude * cosine]
    }
}
