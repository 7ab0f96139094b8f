//! A published table of controller gains, replayed: are the gains found again from what a logger would have written?

use super::controller_run::controller_run;
use super::recording::recorded;
use super::{Cell, Motion, PlantChoice, planned_reference, run_seed, simulate};
use crate::controller::regression::{ControllerGains, gain_regression};
use crate::controller::regressor::Unknown;
use crate::error::{Error, ErrorKind, Result, toml_text};
use crate::identify::excitation::Outcome;
use crate::machine::Machine;
use crate::recording::{Run, Signal};
use crate::twin::Sensing;
use rayon::prelude::*;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Standstill before and after a stroke, in s.
const LEAD_S: f64 = 0.1;
const DWELL_S: f64 = 0.4;

/// A table of gains as a file: which strokes, with which gains each, and how they were logged.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GainTable {
    /// The machine file or folder, relative to this file.
    machine: PathBuf,
    /// Strokes that only verify: no gain may be identified on them.
    #[serde(default)]
    verification: Vec<String>,
    /// Resolution of logged signals by their canonical names, in SI.
    #[serde(default)]
    logger: BTreeMap<String, f64>,
    /// The strokes to identify on.
    cell: Vec<TableCell>,
    /// The file it was read from.
    #[serde(skip)]
    file: PathBuf,
}

/// A stroke of the table and the gains published for it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct TableCell {
    /// `STROKE@FEED`.
    stroke: String,
    /// Gains by their keys below `controller`.
    gains: BTreeMap<String, f64>,
}

/// What was found again on one stroke.
#[derive(Debug, Clone)]
pub struct Recovered {
    /// The stroke, as the table writes it.
    pub stroke: String,
    /// The gains that the stroke was replayed with, in the order of `found`.
    pub published: Vec<f64>,
    /// What the regression gives.
    pub found: ControllerGains,
}

impl Recovered {
    /// Relative errors of the gains.
    pub fn errors(&self) -> Vec<f64> {
        self.found.gains.iter().zip(&self.published).map(|(g, p)| g.estimate.value / p - 1.0).collect()
    }
}

/// Means over the strokes of one gain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mean {
    /// Of the published values.
    pub published: f64,
    /// Of the recovered values.
    pub found: f64,
}

impl GainTable {
    /// Reads a table.
    ///
    /// # Errors
    /// A file that cannot be read or is not such a table, a stroke that is none, no stroke, or one that also verifies.
    pub fn read(file: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(file).map_err(|e| {
            Error::io(file, &e).remedy("name a file with [[cell]] tables of strokes and gains")
        })?;
        let mut table: Self = toml::from_str(&text).map_err(|e| toml_text::refusal(file, &text, &e))?;
        table.file = file.to_path_buf();
        table.check().map_err(|e| e.file(file))?;
        Ok(table)
    }

    fn check(&self) -> Result<()> {
        if self.cell.is_empty() {
            return Err(Error::new(ErrorKind::Missing)
                .key("cell")
                .found("no stroke")
                .expected("at least one [[cell]]")
                .remedy("add a [[cell]] with `stroke` and `gains`"));
        }
        let verifying: Vec<Cell> =
            self.verification.iter().map(|text| text.parse()).collect::<Result<_>>()?;
        for cell in &self.cell {
            let stroke: Cell = cell.stroke.parse()?;
            if verifying.contains(&stroke) {
                return Err(Error::new(ErrorKind::Inconsistent)
                    .key("cell.stroke")
                    .found(format!("`{}`, which stands under `verification` too", cell.stroke))
                    .expected("strokes for identification that verify nothing")
                    .remedy("take it out of one of the lists"));
            }
        }
        for (key, step) in &self.logger {
            if Signal::from_key(key).is_none() || !(step.is_finite() && *step >= 0.0) {
                return Err(Error::new(ErrorKind::OutOfRange)
                    .key(format!("logger.{key}"))
                    .found(step.to_string())
                    .expected("the name of a signal with a resolution of zero or more, in SI")
                    .remedy("write for instance control_effort_v = 3e-4"));
            }
        }
        Ok(())
    }

    /// The machine that the table is about.
    ///
    /// # Errors
    /// As [`Machine::read`].
    pub fn machine(&self) -> Result<Machine> {
        Machine::read(&self.file.parent().unwrap_or(Path::new(".")).join(&self.machine))
    }

    /// Replays every stroke with its gains in closed loop, sensors with noise and rounding as the machine states them,
    /// and identifies the gains from what a logger of the stated resolution keeps. The law starts from the machine's
    /// own gains and is never told those of the table.
    ///
    /// # Errors
    /// A gain that the law does not have, and what simulation or regression refuse.
    pub fn recover(&self, machine: &Machine, plant: PlantChoice, seed: u64) -> Result<Vec<Recovered>> {
        self.cell.par_iter().map(|cell| self.recover_cell(machine, plant, seed, cell)).collect()
    }

    fn recover_cell(
        &self,
        machine: &Machine,
        plant: PlantChoice,
        seed: u64,
        cell: &TableCell,
    ) -> Result<Recovered> {
        let paths: Vec<(String, toml::Value)> =
            cell.gains.iter().map(|(key, value)| (format!("controller.{key}"), (*value).into())).collect();
        let settings = paths.iter().map(|(path, value)| (path.as_str(), value.clone()));
        let published = machine.with_settings(settings).map_err(|e| e.file(&self.file))?;
        let stroke: Cell = cell.stroke.parse()?;
        let motion = Motion {
            strokes: vec![stroke.stroke(machine.motion())?],
            lead_s: LEAD_S,
            dwell_s: DWELL_S,
            ramp_s: machine.description().reference.acceleration_time_s,
        };
        let reference = planned_reference(machine, &motion)?;
        let name = stroke.name(machine.motion());
        let sensing = Sensing::AsStated { seed: run_seed(seed, &name) };
        let traces = simulate(&published, plant, sensing, &reference, |_| ())?;
        let logged = self.logged(recorded(&name, &published, &reference, traces)?)?;
        let run = controller_run(machine, &logged)?;
        match gain_regression(std::slice::from_ref(&run), Unknown::VelocityLoop)? {
            Outcome::NotExcited(why) => Err(Error::new(ErrorKind::Undetermined)
                .file(&self.file)
                .key(cell.stroke.clone())
                .found(why.to_string())
                .expected("a stroke that excites every gain")),
            Outcome::Identified(found) => {
                let published = self.published(cell, &found)?;
                Ok(Recovered { stroke: cell.stroke.clone(), published, found })
            }
        }
    }

    fn published(&self, cell: &TableCell, found: &ControllerGains) -> Result<Vec<f64>> {
        let value = |gain: &crate::controller::regression::IdentifiedGain| {
            cell.gains.get(gain.key).copied().ok_or_else(|| {
                Error::new(ErrorKind::Missing)
                    .file(&self.file)
                    .key(format!("{}: {}", cell.stroke, gain.key))
                    .found("a stroke without this gain")
                    .expected("every gain that is identified")
                    .remedy("add it to the stroke's `gains`")
            })
        };
        found.gains.iter().map(value).collect()
    }

    /// The run in the logger's resolution.
    fn logged(&self, run: Run) -> Result<Run> {
        let rounded = |(signal, samples): (&Signal, &Vec<f64>)| {
            let step = self.logger.get(signal.key(run.motion())).copied().unwrap_or(0.0);
            let samples = samples.iter().map(|x| if step > 0.0 { (x / step).round() * step } else { *x });
            (*signal, samples.collect())
        };
        Run::new(run.name(), run.motion(), run.sample_period_s(), run.signals().iter().map(rounded).collect())
    }

    /// Means of each gain over the strokes.
    pub fn means(recovered: &[Recovered]) -> Vec<Mean> {
        let count = recovered.len() as f64;
        let gains = recovered.first().map_or(0, |first| first.published.len());
        (0..gains)
            .map(|j| Mean {
                published: recovered.iter().map(|r| r.published[j]).sum::<f64>() / count,
                found: recovered.iter().map(|r| r.found.gains[j].estimate.value).sum::<f64>() / count,
            })
            .collect()
    }
}
