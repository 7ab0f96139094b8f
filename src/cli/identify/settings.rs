//! The machine as it was set in the runs of a recording that are looked at together.

use nalgebra::Complex;
use slideway::error::{Error, ErrorKind};
use slideway::identify::loop_response::Part;
use slideway::machine::Machine;
use slideway::recording::Run;
use slideway::replay::compared::{as_set, check};
use slideway::twin::{LinearLoop, LinearPlant};

/// Frequencies at which two responses are held against each other, in shares of half the sampling rate.
const COMPARED_AT: [f64; 3] = [1e-3, 0.03, 0.7];

/// The machine as the runs were set, where all of them have the same response of that part; none where no machine is named.
pub(super) fn same_settings(
    runs: &[Run],
    machine: Option<&Machine>,
    part: Part,
) -> Result<Option<Machine>, Error> {
    let Some(first) = runs.first() else { return Ok(machine.cloned()) };
    let Some(machine) = machine else {
        let is_loop = matches!(part, Part::OpenLoop | Part::ClosedLoop);
        let law = |run: &Run| -> Vec<(String, toml::Value)> {
            let of_law = run.settings.iter().filter(|(path, _)| path.starts_with("controller."));
            of_law.map(|(path, value)| (path.clone(), value.clone())).collect()
        };
        return match runs.iter().find(|run| is_loop && law(run) != law(first)) {
            Some(other) => Err(mixed(first, other, part)),
            None => Ok(None),
        };
    };
    let mut set = Vec::with_capacity(runs.len());
    for run in runs {
        check(run, machine)?;
        set.push(as_set(run, machine)?);
    }
    let response = |machine: &Machine| -> [Complex<f64>; 3] {
        let (plant, looped) = (LinearPlant::of(machine), LinearLoop::of(machine).ok());
        COMPARED_AT.map(|share| {
            let frequency = share * plant.nyquist_hz();
            match (part, &looped) {
                (Part::OpenLoop, Some(looped)) => looped.open_loop(frequency),
                (Part::ClosedLoop, Some(looped)) => looped.closed_loop(frequency),
                _ => plant.plant(frequency),
            }
        })
    };
    let of_first = set.first().map(response);
    if let Some(k) = set.iter().position(|machine| Some(response(machine)) != of_first) {
        return Err(mixed(first, &runs[k], part));
    }
    Ok(set.into_iter().next())
}

fn mixed(one: &Run, other: &Run, part: Part) -> Error {
    Error::new(ErrorKind::Inconsistent)
        .key(format!("{}.set", other.name()))
        .found(format!("a machine set otherwise than in the run {}", one.name()))
        .expected(format!("the same {} in all runs that are averaged", part.word()))
        .remedy("name one run with --run")
}
