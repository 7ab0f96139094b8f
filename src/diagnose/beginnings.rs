//! How lately replayed machines begin a run: with which phase of a vibration, and where in a play.

use super::play::has_play;
use crate::error::Result;
use crate::machine::Machine;
use crate::replay::recorded::shakes;
use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

/// Whether each run of a machine has a beginning of its own: a phase of a vibration, or a place in a play.
pub fn has_own_beginnings(machine: &Machine) -> bool {
    shakes(machine) || has_play(machine)
}

/// So many machines are remembered, a choice of cost. A fit asks twice in a row for the same one, for its residuals and for their derivatives, and a few fits run side by side.
const REMEMBERED: usize = 16;

/// A machine, the longest step of its replays in s, and the machine with the beginning that suits the run.
type Beginning = (Machine, f64, Machine);

/// Machines with the beginnings that suit one run, the latest last.
///
/// To find one costs three replays of the run for a vibration and six for a play; it is the same each time.
#[derive(Debug, Default)]
pub struct Beginnings(Mutex<VecDeque<Beginning>>);

/// Of another run nothing is remembered.
impl Clone for Beginnings {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl Beginnings {
    /// The machines with the beginnings that suit the run: those that are remembered, and those of the others by `suited`.
    ///
    /// # Errors
    /// Those of `suited`.
    pub fn of(
        &self,
        machines: Vec<Machine>,
        longest_step_s: f64,
        suited: impl FnOnce(Vec<Machine>) -> Result<Vec<Machine>>,
    ) -> Result<Vec<Machine>> {
        let known: Vec<Option<Machine>> = machines.iter().map(|m| self.known(m, longest_step_s)).collect();
        let is_new =
            |(machine, known): (&Machine, &Option<Machine>)| known.is_none().then(|| machine.clone());
        let new: Vec<Machine> = machines.iter().zip(&known).filter_map(is_new).collect();
        let found = if new.is_empty() { Vec::new() } else { suited(new.clone())? };
        new.into_iter()
            .zip(&found)
            .for_each(|(new, found)| self.remember((new, longest_step_s, found.clone())));
        let mut found = found.into_iter();
        let both = machines.into_iter().zip(known);
        Ok(both.map(|(own, known)| known.or_else(|| found.next()).unwrap_or(own)).collect())
    }

    fn known(&self, machine: &Machine, longest_step_s: f64) -> Option<Machine> {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_it = |(of, step_s, _): &&Beginning| *step_s == longest_step_s && of.replays_like(machine);
        all.iter().rev().find(is_it).map(|(.., begun)| begun.clone())
    }

    fn remember(&self, beginning: Beginning) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if all.len() == REMEMBERED {
            all.pop_front();
        }
        all.push_back(beginning);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::long_steps::tests::slow;

    /// What was asked for is asked for once, in its place among others, and anew for other steps, after many others and of another run.
    #[test]
    fn exact_a_beginning_is_found_once() {
        let (beginnings, stated) = (Beginnings::default(), slow());
        let with = |viscous: &f64| {
            stated.with_settings([("guide.viscous_n_s_per_m", toml::Value::Float(*viscous))]).unwrap()
        };
        let asked = |values: &[f64], step_s: f64| {
            let mut asked = 0;
            let marked = |machines: Vec<Machine>| {
                asked = machines.len();
                Ok(machines)
            };
            let machines: Vec<Machine> = values.iter().map(with).collect();
            let of = beginnings.of(machines.clone(), step_s, marked).unwrap();
            assert!(of.iter().zip(&machines).all(|(a, b)| a.replays_like(b)));
            asked
        };
        assert_eq!([asked(&[1.0, 2.0], 1e-3), asked(&[3.0, 1.0, 2.0], 1e-3), asked(&[1.0], 2e-3)], [2, 1, 1]);
        let many: Vec<f64> = (10..10 + REMEMBERED).map(|k| k as f64).collect();
        assert_eq!([asked(&many, 1e-3), asked(&[1.0], 1e-3)], [REMEMBERED, 1]);
        let mut asked_anew = false;
        let of_another = beginnings.clone().of(vec![with(&1.0)], 1e-3, |machines| {
            asked_anew = true;
            Ok(machines)
        });
        assert!(of_another.is_ok() && asked_anew);
    }
}
