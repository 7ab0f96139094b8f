//! Strokes of a machine as tests record them: the machine as it is told, the machine as it is.

use slideway::machine::Machine;
use slideway::recording::{Recording, Role, Run};
use slideway::replay::recording::recorded;
use slideway::replay::{Commands, Motion, PlantChoice, Stroke, run_seed};
use slideway::twin::Sensing;

/// Stroke in m, feed in m/min, role of the run; rad and rad/min on an axis that turns.
pub type Cell = (f64, f64, Role);

/// How strokes are recorded.
pub struct Strokes<'a> {
    /// The machine that the recording tells of.
    pub stated: &'a Machine,
    /// The machine that moves.
    pub real: &'a Machine,
    /// What it moves on.
    pub plant: PlantChoice,
    /// Shares of each stroke, one after the other; none: it stands still for 2000 samples.
    pub legs: &'a [f64],
    /// Standstill after each leg, in s.
    pub dwell_s: f64,
    /// Seed of the noise.
    pub seed: u64,
}

/// There and back.
const BOTH_WAYS: [f64; 2] = [1.0, -1.0];

impl<'a> Strokes<'a> {
    /// There and back on the reduced axis.
    pub fn both_ways(stated: &'a Machine, real: &'a Machine, seed: u64) -> Self {
        Self { stated, real, plant: PlantChoice::Axis, legs: &BOTH_WAYS, dwell_s: 0.3, seed }
    }

    /// One run of each cell.
    pub fn recording(&self, cells: &[Cell]) -> Recording {
        self.recording_from(&cells.iter().map(|cell| (0.0, *cell)).collect::<Vec<_>>())
    }

    /// One run of each cell, from a position of its own.
    pub fn recording_from(&self, cells: &[(f64, Cell)]) -> Recording {
        let mut begins_s = 0.0;
        let run = |(from, cell): &(f64, Cell)| {
            let run = self.run(*from, *cell, begins_s);
            begins_s += run.duration_s() + run.sample_period_s();
            run
        };
        Recording::new(cells.iter().map(run).collect()).unwrap()
    }

    fn run(&self, from: f64, (stroke, feed, role): Cell, begins_s: f64) -> Run {
        let whole = Stroke::metres_at_metres_per_minute(stroke, feed).unwrap();
        let strokes =
            self.legs.iter().map(|share| Stroke { stroke: share * whole.stroke, ..whole }).collect();
        let motion = Motion { strokes, lead_s: 0.1, dwell_s: self.dwell_s, ramp_s: 0.02 };
        let mut reference = motion.reference(self.real.description().sample_period_s);
        if self.legs.is_empty() {
            reference.resize(2000, 0.0);
        }
        reference.iter_mut().for_each(|position| *position += from);
        let name = format!("stroke{:.0}_feed{feed:.0}", whole.stroke * 1e3);
        let sensing = Sensing::AsStated { seed: run_seed(self.seed, &name) };
        let commands = Commands::follow(self.real, &reference).unwrap().beginning(begins_s);
        let traces = commands.simulate(self.real, self.plant, sensing, |_| ()).unwrap();
        let mut run = recorded(&name, self.stated, &reference, traces).unwrap();
        run.role = Some(role);
        run
    }
}
