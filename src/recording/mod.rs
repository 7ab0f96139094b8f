//! What is recorded, real or simulated alike: runs of signals in SI, read from tables through a `recording.toml` that says
//! which column is which.
//!
//! Tables are text in many layouts, Parquet, TwinCAT Scope exports, traces of SINUMERIK and TIA Portal, MCAP with ROS 2 joint states, MAT and HDF5. A few lost samples are
//! filled in and reported ([`Run::remarks`]); channels with clocks of their own are read at the instants of the slowest one.
//!
//! ```toml
//! sample_period_s = 250e-6               # optional where the files have a time column
//! motion = "prismatic"                   # optional where a signal name tells it
//! machine = "../../models/slide"         # optional
//! note = "measured after the overhaul"   # optional; shown wherever results are
//! data_folder = "../data"                # optional; the environment variable SLIDEWAY_DATA overrides it
//!
//! [[run]]
//! file = "stroke020_feed08.csv"
//! name = "slow stroke"                   # optional; otherwise the file name without its ending
//! role = "held_out"                      # or "training"; optional
//! set = { "controller.integral" = 22 }   # machine settings in force in this run, by key path
//! extra_columns = ["slider_a_n"]         # columns kept beside the signals, as they stand in the file
//! from_s = 0.5                           # only the samples with from_s ≤ time < to_s; both optional
//! to_s = 8.0
//! stroke_m = 0.02                        # further keys are metadata
//!
//! [columns]                              # only where a name or a unit differs; a [[run]] may have its own
//! position_m = { column = "pos_meas", unit = "mm" }
//! current_a = "motor current"
//! control_effort_v = { column = "dac", unit = 3.05e-4, scale = -1, offset = 0.01 }
//! ```
//! A run's `set` says what is known of the machine in this run alone: gains, or a weight bolted on as
//! `{ "effect.payload.mass_kg" = 5.0 }`. Where a diagnosis fits the same number of an effect, the run's difference to
//! the machine file comes on top of the fitted value.
//!
//! A reading becomes SI as `reading · unit · scale + offset`; a unit may be a number, in SI units per count.
//!
//! Rows are counted as an editor does: the header of a CSV file is row 1 (comment lines above it are not
//! counted); a Parquet file has no header, so its first row is row 1.

mod array_file;
mod cdr;
mod columns;
mod coverage;
mod csv_table;
mod decode;
mod dialect;
mod document;
mod file_columns;
mod halscope;
mod kinematics;
mod likely;
mod loaded_table;
mod log;
mod lost;
mod manifest;
mod mcap_records;
mod mcap_table;
mod meaning;
mod outline;
mod parquet_pages;
mod parquet_table;
mod pieces;
mod plausibility;
mod profile;
mod range;
mod read;
mod resolve;
mod run;
mod schema;
mod scope_table;
mod series;
mod session;
mod shared;
mod signal;
mod split;
mod table;
mod tia_samples;
mod tia_trace;
mod timing;
mod trace_xml;
mod write;

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

pub use columns::Conversion;
pub use dialect::Dialect;
pub use kinematics::Kinematics;
pub use log::{LogContext, MappedColumn};
pub use pieces::{Cut, Samples};
pub use plausibility::{Finding, plausibility};
pub use run::{FEEDFORWARD_KEY, Role, Run};
pub use schema::schema;
pub use session::{BEGIN_KEY, one_after_another};
pub use signal::{Signal, TIME_KEY};
pub use split::{HeldOutRuns, Split, SplitRule, TrainingRuns};
pub use table::TableLayout;
pub use timing::{PeriodSource, Timing};
pub use write::{Existing, Format};

use crate::error::{Error, ErrorKind, Result};
use crate::units::Motion;

/// Runs may differ in their period by this fraction: the clocks of one drive at different temperatures.
const PERIOD_AGREEMENT: f64 = 1e-3;

/// Runs of one machine, with names of their own, one motion and one sample period.
#[derive(Debug, Clone)]
pub struct Recording {
    /// The TOML file it was read from; empty for a recording made in memory.
    pub path: PathBuf,
    /// Where the data come from, in words; shown wherever results are.
    pub note: Option<String>,
    /// The folder of the machine description, where the recording names one.
    pub machine: Option<PathBuf>,
    /// What was converted from what, for reports; columns with canonical name and unit are not listed.
    pub units_read: Vec<Conversion>,
    motion: Motion,
    sample_period_s: f64,
    runs: Vec<Run>,
    manifest_sha256: String,
}

impl Recording {
    /// A recording made in memory, by a replay say.
    ///
    /// # Errors
    /// No runs, a run name twice, runs of different motion or sample period (beyond 0.1 %; within it the
    /// period of the first run in alphabetical order holds for all), a session that no clock tells. Runs with uneven time
    /// stamps have each their own.
    ///
    /// # Model
    /// A run begins within the session at its `begins_s`, where all runs state one; else where its own time stamps place it, if
    /// the runs have their places on one clock; else when the run before it in the list has ended.
    pub fn new(mut runs: Vec<Run>) -> Result<Self> {
        let even_first = |run: &&Run| (run.instants_s().is_some(), run.name().to_owned());
        let Some(first) = runs.iter().min_by_key(even_first) else {
            return Err(Error::new(ErrorKind::TooLittleData)
                .key("run")
                .found("a recording without runs")
                .expected("at least one run")
                .remedy("add a run"));
        };
        let (motion, period, name) = (first.motion(), first.sample_period_s(), first.name().to_owned());
        let mut names = std::collections::BTreeSet::new();
        for run in &mut runs {
            if !names.insert(run.name().to_owned()) {
                return Err(inconsistent(run, "its name a second time", "run names that differ")
                    .remedy("rename one of the runs"));
            }
            if run.motion() != motion {
                let expected = format!("a {motion} one, as in `{name}`");
                return Err(inconsistent(run, &format!("a {} axis", run.motion()), &expected)
                    .remedy("make a recording for each axis"));
            }
            if run.instants_s().is_some() {
                continue;
            }
            if (run.sample_period_s() / period - 1.0).abs() > PERIOD_AGREEMENT {
                let found = format!("a sample period of {} s", run.sample_period_s());
                return Err(inconsistent(run, &found, &format!("{period} s, as in `{name}`"))
                    .remedy("resample, or make a recording for each sample period"));
            }
            run.set_sample_period_s(period);
        }
        session::place(&mut runs)?;
        Ok(Self {
            path: PathBuf::new(),
            note: None,
            machine: None,
            units_read: Vec::new(),
            motion,
            sample_period_s: period,
            runs,
            manifest_sha256: String::new(),
        })
    }

    /// Reads a folder that holds `recording.toml`, or such a TOML file of any name.
    ///
    /// # Errors
    /// Everything that is wrong with the file, its runs, their columns or their units is refused with file,
    /// row, key and remedy; see the module for the format.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        read::recording(path.as_ref(), read::Content::Measured)
    }

    /// The same where runs need not hold anything measured: a position reference, say, that an axis is to be told.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn read_commands(path: impl AsRef<Path>) -> Result<Self> {
        read::recording(path.as_ref(), read::Content::Commands)
    }

    /// Whether the axis slides or turns.
    pub fn motion(&self) -> Motion {
        self.motion
    }

    /// Time between two samples, in every run.
    pub fn sample_period_s(&self) -> f64 {
        self.sample_period_s
    }

    /// The runs, in the order of the file; at least one.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// The run of a name.
    pub fn run(&self, name: &str) -> Option<&Run> {
        self.runs.iter().find(|run| run.name() == name)
    }

    /// SHA-256 over the TOML file and all run files, whatever the order of the runs.
    pub fn sha256(&self) -> String {
        let mut runs: Vec<_> = self.runs.iter().map(|run| (run.name(), run.sha256())).collect();
        runs.sort_unstable();
        let mut hash = Sha256::new();
        hash.update(&self.manifest_sha256);
        for (name, sha256) in runs {
            hash.update(name);
            hash.update([0]);
            hash.update(sha256);
        }
        run::hex(hash)
    }
}

fn inconsistent(run: &Run, found: &str, expected: &str) -> Error {
    let error =
        Error::new(ErrorKind::Inconsistent).key(run.name()).found(found).expected(expected.to_owned());
    if run.file.as_os_str().is_empty() { error } else { error.file(&run.file) }
}
