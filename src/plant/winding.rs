//! The motor beside a plant that takes forces.

use super::Drive;
use crate::drive::motor::{Circuit, CircuitStep, StepCurrent};
use crate::guide::StepForce;

/// The motor of a plant whose engine takes forces: its current, and its force over each step.
///
/// # Model
/// Over a step the voltage is held (or switches once) and the axis has the velocity that its last two values extrapolate
/// to for the middle of the step. The current follows exactly; the engine gets its force as mean and rise.
///
/// # Validity
/// Exact without back-EMF; with it, second order in the step.
#[derive(Debug, Clone)]
pub struct WindingState {
    circuit: Circuit,
    step_s: f64,
    whole: CircuitStep,
    /// A step in which the voltage switches at this share of it.
    split: (f64, [CircuitStep; 2]),
    current_a: f64,
    /// Current at the end of the step that was looked at.
    next_a: f64,
    velocity: f64,
    earlier_velocity: f64,
}

impl WindingState {
    /// The motor for steps of `step_s`, without current.
    pub fn new(circuit: &Circuit, step_s: f64) -> Self {
        let half = CircuitStep::new(circuit, 0.5 * step_s);
        Self {
            circuit: *circuit,
            step_s,
            whole: CircuitStep::new(circuit, step_s),
            split: (0.5, [half; 2]),
            current_a: 0.0,
            next_a: 0.0,
            velocity: 0.0,
            earlier_velocity: 0.0,
        }
    }

    /// Current in A; zero for a motor without a winding.
    pub fn current(&self) -> f64 {
        self.current_a
    }

    /// Sets the current in A.
    pub fn set_current(&mut self, current_a: f64) {
        if self.whole.has_current() {
            (self.current_a, self.next_a) = (current_a, current_a);
        }
    }

    /// Starts without current at a velocity.
    pub fn place(&mut self, velocity: f64) {
        (self.current_a, self.next_a) = (0.0, 0.0);
        (self.velocity, self.earlier_velocity) = (velocity, velocity);
    }

    /// The motor's force over the coming step, and at its beginning and end; the axis begins the step with `velocity`.
    pub fn look_ahead(&mut self, drive: Drive, velocity: f64) -> (StepForce, [f64; 2]) {
        self.velocity = velocity;
        self.next_a = self.current_a;
        let (earlier_v, now_v, switch) = match drive {
            Drive::Force(force) => return (StepForce::held(force), [force; 2]),
            Drive::Voltage { earlier_v, now_v, switch } => (earlier_v, now_v, switch),
        };
        let middle = velocity + 0.5 * (velocity - self.earlier_velocity);
        let constant = self.whole.effort_constant();
        let mut current = self.current_a;
        let over = if switch <= 0.0 {
            self.whole.over(&mut current, now_v, middle)
        } else if switch >= 1.0 {
            self.whole.over(&mut current, earlier_v, middle)
        } else {
            let [first, second] = self.split_at(switch);
            let before = first.over(&mut current, earlier_v, middle);
            before.then(second.over(&mut current, now_v, middle), switch)
        };
        self.next_a = current;
        // A force that rises by D at zero mean has the first moment D/12.
        let force = StepForce { mean: constant * over.mean, rise: 12.0 * constant * over.moment };
        let ends = if self.whole.has_current() { [self.current_a, current] } else { [over.mean; 2] };
        (force, ends.map(|current| constant * current))
    }

    /// Makes the step that was looked at.
    pub fn advance(&mut self) {
        if self.whole.has_current() {
            self.current_a = self.next_a;
        }
        self.earlier_velocity = self.velocity;
    }

    /// Current and the velocity one step ago.
    pub fn snapshot(&self) -> [f64; 2] {
        [self.current_a, self.earlier_velocity]
    }

    /// Goes back to a snapshot.
    pub fn restore(&mut self, [current_a, earlier_velocity]: [f64; 2]) {
        (self.current_a, self.next_a, self.earlier_velocity) = (current_a, current_a, earlier_velocity);
    }

    fn split_at(&mut self, switch: f64) -> [CircuitStep; 2] {
        if self.split.0 != switch {
            let piece = |share: f64| CircuitStep::new(&self.circuit, share * self.step_s);
            self.split = (switch, [piece(switch), piece(1.0 - switch)]);
        }
        self.split.1
    }
}

/// Joins the currents of two pieces of a step.
trait Then {
    /// `self` over the share `switch` of the step, then `next` over the rest.
    fn then(self, next: StepCurrent, switch: f64) -> StepCurrent;
}

impl Then for StepCurrent {
    fn then(self, next: StepCurrent, switch: f64) -> StepCurrent {
        let rest = 1.0 - switch;
        StepCurrent {
            mean: switch * self.mean + rest * next.mean,
            moment: switch * (self.mean * (0.5 * switch - 0.5) + switch * self.moment)
                + rest * (next.mean * 0.5 * switch + rest * next.moment),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CIRCUIT: Circuit =
        Circuit::Winding { resistance_ohm: 1.3, inductance_h: 8e-3, force_constant: 83.1, back_emf: 0.0 };

    /// A step that is cut where the voltage does not change is the whole step: force, rise and current.
    #[test]
    fn exact_a_cut_without_a_switch_changes_nothing() {
        let (mut whole, mut cut) = (WindingState::new(&CIRCUIT, 250e-6), WindingState::new(&CIRCUIT, 250e-6));
        for state in [&mut whole, &mut cut] {
            state.set_current(0.7);
        }
        let (a, ends_a) = whole.look_ahead(Drive::voltage(3.0), 0.1);
        let switched = Drive::Voltage { earlier_v: 3.0, now_v: 3.0, switch: 0.3 };
        let (b, ends_b) = cut.look_ahead(switched, 0.1);
        assert!((a.mean - b.mean).abs() < 1e-12 && (a.rise - b.rise).abs() < 1e-8, "{a:?} {b:?}");
        assert!((ends_a[1] - ends_b[1]).abs() < 1e-12);
    }
}
