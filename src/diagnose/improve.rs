//! From a diagnosis to the improved machine.

use super::verdict::{Diagnosis, Parameter, Verdict};
use crate::error::Result;
use crate::machine::provenance::{Identified, Reason};
use crate::machine::{Machine, Provenance};

/// The machine with the named causes and the calibrated constants in force, and where these values come from.
///
/// None where there is nothing to put into the machine: no cause was named, several explanations do equally well, or the verdict
/// was withheld.
///
/// # Errors
/// A value that the machine's description refuses: the diagnosis is of another machine.
pub fn improved(diagnosis: &Diagnosis, machine: &Machine) -> Result<Option<(Machine, Provenance)>> {
    let is_open = diagnosis.verdict == Verdict::Undecided || diagnosis.withheld.is_some();
    if diagnosis.causes.is_empty() || is_open {
        return Ok(None);
    }
    let causes = diagnosis.causes.iter().flat_map(super::verdict::Cause::settings);
    let causes = causes.map(|(path, parameter)| identified(path, parameter, Reason::Cause));
    let calibrated = diagnosis.calibration.iter();
    let calibrated = calibrated.map(|c| identified(c.path.clone(), &c.parameter, Reason::Calibration));
    let value: Vec<Identified> = causes.chain(calibrated).collect();
    let settings = value.iter().map(|v| (v.path.as_str(), toml::Value::Float(v.value)));
    let better = machine.with_settings(settings)?;
    let (gap, data) = (&diagnosis.gap, &diagnosis.data);
    let provenance = Provenance {
        recording_sha256: data.sha256.clone(),
        training: data.training.clone(),
        held_out: data.held_out.clone(),
        gap_before: gap.before,
        gap_after: gap.after,
        closed: gap.closed,
        closed_ci95: gap.closed_ci95,
        version: diagnosis.version.clone(),
        value,
    };
    Ok(Some((better, provenance)))
}

fn identified(path: String, parameter: &Parameter, reason: Reason) -> Identified {
    let Parameter { value, ci95, unit, twin } = parameter.clone();
    Identified { path, value, ci95, unit, before: twin.is_finite().then_some(twin), reason }
}
