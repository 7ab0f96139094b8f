//! The force that a channel tells, fitted by the motion: its sign and its size show in the mass.

use super::projection::{Basis, Coefficient, spread};
use super::smoothed::Smoothed;
use crate::diagnose::scalar_product::dot;
use crate::drive::motor::{Circuit, CircuitStep};
use crate::machine::Machine;
use crate::recording::Signal;

/// Channels that tell the motor's force.
pub const FORCE: [Signal; 3] = [Signal::ControlEffort, Signal::Current, Signal::Thrust];

/// A channel's force explained by the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertia {
    /// The mass that the channel's force and the motion imply, in kg or kg·m².
    pub mass: Coefficient,
    /// Share of the force that mass, friction, spring and weight of any size explain.
    pub explained: f64,
}

impl Inertia {
    /// Of one channel; none where it was not logged or the motion says nothing.
    ///
    /// # Model
    /// `F = m·a + c±·v + F_c·sgn v + k·x + F_0` by least squares over the moving samples, all six free.
    pub fn of(machine: &Machine, smoothed: &Smoothed, signal: Signal) -> Option<Self> {
        let force = force(machine, smoothed, signal)?;
        let y: Vec<f64> = smoothed.moving.iter().map(|k| force[*k]).collect();
        let columns = smoothed.motion_columns(machine, &smoothed.moving);
        let others = Basis::of(columns.others);
        let mass = Coefficient::of(&columns.acceleration, &others, &y)?;
        let all: Vec<f64> = y.iter().zip(&columns.acceleration).map(|(y, a)| y - mass.value * a).collect();
        let rest = others.residual(all);
        let variance = spread(&y);
        (variance > 0.0).then(|| Self { mass, explained: 1.0 - dot(&rest, &rest) / variance })
    }
}

/// The motor's force in N or N·m as one channel tells it, with the constants as stated.
fn force(machine: &Machine, smoothed: &Smoothed, signal: Signal) -> Option<Vec<f64>> {
    let samples = smoothed.driving(signal)?;
    let circuit = machine.constants().circuit;
    match (signal, &circuit) {
        (Signal::Current, Circuit::Winding { force_constant, .. }) => {
            Some(samples.iter().map(|i| i * force_constant).collect())
        }
        (Signal::Current, Circuit::Direct { .. }) => None,
        (Signal::ControlEffort, Circuit::Direct { force_per_volt }) => {
            Some(samples.iter().map(|u| u * force_per_volt).collect())
        }
        (Signal::ControlEffort, Circuit::Winding { resistance_ohm, .. }) => {
            let step = CircuitStep::new(&circuit, smoothed.period_s);
            let mut current = samples.first().map_or(0.0, |u| u / resistance_ohm);
            // Back-EMF goes with velocity, which the fit leaves free.
            let mean = |u: &f64| step.advance(&mut current, *u, 0.0) * step.effort_constant();
            Some(samples.iter().map(mean).collect())
        }
        _ => Some(samples),
    }
}
