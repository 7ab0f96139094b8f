//! The controller's own samples under a log that was read at other times.

use super::Traces;
use crate::recording::Run;
use crate::twin::{Command, Sensing};

/// A log read at uneven times, polled over a bus say, beside the controller that sampled by itself.
///
/// # Model
/// The controller runs at its period T from the first time stamp on. What a row commands holds from its time stamp to the next
/// one; a row reads the state between the controller's samples k and k + 1 at its time stamp t:
/// ```text
///   x(t) = x[k] + (t/T − k)·(x[k+1] − x[k])        k = ⌊t/T⌋
/// ```
/// Effort is that of sample k: it holds until the next. With noise and rounding of sensors asked for, the nearest sample is read.
///
/// # Validity
/// Motion close to a straight line within one T; commands and readings of a row at one time.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    commands: Vec<Command>,
    /// Sample before each row, and the share of a period that has passed since.
    rows: Vec<(usize, f64)>,
}

/// Time stamps are rounded: this share of a period is none.
const ROUNDING: f64 = 1e-6;

impl Grid {
    /// The controller's samples under a run with time stamps of its own; none for an evenly sampled run.
    pub fn of(run: &Run, commands: &[Command], period_s: f64) -> Option<Self> {
        let instants_s = run.instants_s()?;
        let rows: Vec<(usize, f64)> = instants_s
            .iter()
            .map(|t| {
                let place = t / period_s + ROUNDING;
                (place as usize, (place.fract() - ROUNDING).max(0.0))
            })
            .collect();
        let samples = rows.last().map_or(0, |(last, _)| last + 2);
        let mut row = 0;
        let on_grid = (0..samples).map(|k| {
            let now_s = (k as f64 + ROUNDING) * period_s;
            while instants_s.get(row + 1).is_some_and(|next| *next <= now_s) {
                row += 1;
            }
            commands[row]
        });
        Some(Self { commands: on_grid.collect(), rows })
    }

    /// The commands, one a period of the controller.
    pub fn commands(&self) -> &[Command] {
        &self.commands
    }

    /// What a log at the rows' time stamps holds of the controller's samples.
    pub fn read(&self, traces: &Traces, sensing: Sensing) -> Traces {
        let is_perfect = sensing == Sensing::Perfect;
        let between = |samples: &[f64]| -> Vec<f64> {
            let at = |&(k, share): &(usize, f64)| {
                let share = if is_perfect { share } else { share.round() };
                let (now, next) = (samples[k], samples[(k + 1).min(samples.len() - 1)]);
                now + share * (next - now)
            };
            self.rows.iter().map(at).collect()
        };
        let held = |samples: &[f64]| self.rows.iter().map(|&(k, _)| samples[k]).collect();
        let loads = |&(k, _): &(usize, f64)| traces.slider_loads.get(k).copied();
        Traces {
            position: between(&traces.position),
            velocity: between(&traces.velocity),
            effort_v: held(&traces.effort_v),
            current: between(&traces.current),
            thrust: between(&traces.thrust),
            load_position: between(&traces.load_position),
            slider_loads: self.rows.iter().filter_map(loads).collect(),
        }
    }
}
