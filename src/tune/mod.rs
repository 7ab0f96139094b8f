//! Tuning: named numbers of a controller swept and optimised over strokes, and the choice checked where the machine is off.
//!
//! - [`Knob`]: a number that may be turned, and how far.
//! - [`Criterion`], [`Limits`]: what is asked of a setting.
//! - [`Tuning::run`]: the map of settings, the best of them, and what gives first when the machine differs.

mod criteria;
mod knob;
mod measure;
mod robust;
mod search;

pub use crate::machine::Criterion;
pub use criteria::{Limits, Values, WrittenLimit};
pub use knob::{Knob, Written};
pub use measure::{Bench, Setting};
pub use robust::{Departure, Given, Kind, Robustness};
pub use search::{Map, Objective};

use crate::error::{Error, ErrorKind, Result};
use crate::machine::Machine;
use crate::replay::Cell;

/// What is tuned, over which strokes, to what end.
#[derive(Debug, Clone)]
pub struct Tuning {
    /// The numbers that are turned; one or more.
    pub knobs: Vec<Knob>,
    /// The strokes.
    pub cells: Vec<Cell>,
    /// Standstill after each stroke, s.
    pub dwell_s: f64,
    /// What every stroke must keep.
    pub limits: Limits,
    /// What is made small among settings that keep the limits.
    pub objective: Objective,
    /// Settings to be beaten, one number a knob each.
    pub marks: Vec<Vec<f64>>,
    /// Largest Coulomb friction of the re-check, N or N·m.
    pub friction: f64,
}

/// What came out.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The setting as the machine states it.
    pub own: Setting,
    /// The marked settings.
    pub marks: Vec<Setting>,
    /// The best setting.
    pub chosen: Setting,
    /// Whether the best setting is, stroke by stroke, at least as good as each marked one.
    pub beats: Vec<bool>,
    /// Every setting of the map.
    pub map: Map,
    /// Settings looked at in all.
    pub evaluated: usize,
    /// The chosen setting, then the marked ones, re-checked.
    pub robustness: Robustness,
}

impl Tuning {
    /// Sweeps, optimises, re-checks. `each` is told after every setting how many more are done.
    ///
    /// # Method
    /// Every setting of a grid of at most 3600 is replayed in closed loop on the reduced axis with perfect sensors. The
    /// order of settings is: stable, margins short of their bounds by least; strokes beyond their limits by least; at least
    /// as good as every mark that keeps the limits, on every stroke; least objective; least following error. From the best
    /// of the grid a compass search goes on in steps halved down to one count of an integer and a thousandth of the range
    /// of a real number. Of settings that keep the limits within a tenth of the least objective, the one is chosen that
    /// exceeds the limits least on machines whose mass, friction and base frequencies are off.
    ///
    /// # Errors
    /// A machine without a controller, a knob that is none, a mark of another length, a stroke beyond the travel.
    pub fn run(&self, machine: &Machine, each: impl Fn(usize) + Sync) -> Result<Outcome> {
        self.check(machine)?;
        let bench = Bench::new(machine, &self.knobs, &self.cells, self.dwell_s)?;
        let own: Vec<f64> = self.knobs.iter().map(|knob| knob.stated(machine)).collect::<Result<_>>()?;
        let mut rivals = vec![own];
        rivals.extend(self.marks.iter().cloned());
        let mut rivals = bench.measure(&rivals, &each)?.into_iter();
        let own = rivals.next().ok_or_else(|| no_setting(machine))?;
        let marks: Vec<Setting> = rivals.collect();
        let search = search::Search { tuning: self, bench: &bench, marks: &marks };
        let (map, best, mut evaluated) = search.run(&each)?;
        // Of settings nearly as good, the one that keeps most where the machine is off.
        let mut candidates = search.nearly_as_good(&map, best);
        evaluated += candidates.len() * robust::DEPARTURES;
        let mut looked_at: Vec<Vec<f64>> = candidates.iter().map(|setting| setting.values.clone()).collect();
        looked_at.extend(marks.iter().map(|mark| mark.values.clone()));
        let checked = Robustness::of(machine, self, &looked_at, &each)?;
        let excess = |k: &usize| checked.excess(*k, &self.limits);
        let sturdiest = (0..candidates.len()).min_by(|a, b| excess(a).total_cmp(&excess(b))).unwrap_or(0);
        let chosen = candidates.swap_remove(sturdiest);
        let robustness = checked.only(sturdiest, looked_at.len() - marks.len()..looked_at.len());
        let beats = marks
            .iter()
            .map(|mark| chosen.is_at_least_as_good_as(mark, &self.limits, bench.period_s()))
            .collect();
        Ok(Outcome { own, marks, chosen, beats, map, evaluated, robustness })
    }

    /// Largest thrust of the strokes under the setting as stated, N or N·m.
    ///
    /// # Errors
    /// As [`Tuning::run`].
    pub fn peak_thrust(&self, machine: &Machine) -> Result<f64> {
        self.check(machine)?;
        let bench = Bench::new(machine, &self.knobs, &self.cells, self.dwell_s)?;
        let own = self.knobs.iter().map(|knob| knob.stated(machine)).collect::<Result<_>>()?;
        let measured = bench.measure(&[own], &|_| ())?;
        Ok(measured.iter().map(|setting| setting.worst()[Criterion::PeakThrust as usize]).fold(0.0, f64::max))
    }

    /// Settings of the map and the re-check: what there is to be done at least.
    pub fn least_settings(&self) -> usize {
        let map: usize = search::grid(&self.knobs).iter().map(Vec::len).product();
        map + 1 + self.marks.len() + robust::DEPARTURES
    }

    fn check(&self, machine: &Machine) -> Result<()> {
        let refuse = |key: &str, found: String, expected: &str, remedy: &str| {
            Err(Error::new(ErrorKind::OutOfRange)
                .file(machine.file())
                .key(key)
                .found(found)
                .expected(expected)
                .remedy(remedy))
        };
        if machine.description().controller.is_none() {
            return Err(no_setting(machine));
        }
        if self.knobs.is_empty() || self.cells.is_empty() {
            let found = format!("{} numbers to vary and {} strokes", self.knobs.len(), self.cells.len());
            return refuse(
                "tune",
                found,
                "at least one of each",
                "give --vary KEY=FROM..TO and --cell STROKE@FEED",
            );
        }
        if let Some(mark) = self.marks.iter().find(|mark| mark.len() != self.knobs.len()) {
            let found = format!("{} numbers", mark.len());
            let expected = format!("{}, one for each varied key", self.knobs.len());
            let remedy = "write them in the order of --vary, as in --mark 22,220";
            return refuse("--mark", found, &expected, remedy).map_err(|error| error.typed("--mark"));
        }
        for mark in &self.marks {
            self.knobs.iter().zip(mark).try_for_each(|(knob, value)| knob.check_value(machine, *value))?;
        }
        let twice = |k: &usize| self.knobs[..*k].iter().any(|knob| knob.key == self.knobs[*k].key);
        if let Some(twice) = (0..self.knobs.len()).find(twice) {
            let key = self.knobs[twice].key.clone();
            return refuse(&key, "the key twice".to_owned(), "each number once", "leave one of both out");
        }
        if !(self.friction.is_finite() && self.friction >= 0.0) {
            return refuse(
                "--friction",
                self.friction.to_string(),
                "zero or more",
                "give the friction to withstand",
            );
        }
        self.knobs.iter().try_for_each(|knob| knob.check(machine))
    }
}

fn no_setting(machine: &Machine) -> Error {
    machine
        .lacks_controller()
        .found("a machine without a control law, which has nothing to tune")
        .remedy("state the law that the drive runs; `slideway identify gains` finds its gains from a log")
}
