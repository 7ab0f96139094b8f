//! Which runs train and which are held out, as a diagnosis shares them out.

use super::TrialRun;
use crate::error::Result;
use crate::recording::{Recording, Run, SplitRule};

/// The runs of a session in groups, from what was logged of each: training and held-out ones. A single run is a group by
/// itself: both sides are stretches of it.
///
/// # Errors
/// As [`Recording::new`] and [`Recording::split`].
pub fn shared_out<'a>(runs: &'a [TrialRun], logged: Vec<Run>) -> Result<Vec<Vec<&'a TrialRun>>> {
    if runs.len() < 2 {
        return Ok(vec![runs.iter().collect()]);
    }
    let (training, held_out) = Recording::new(logged)?.split(SplitRule::default())?;
    let of = |side: &[Run]| -> Vec<&'a TrialRun> {
        runs.iter().filter(|run| side.iter().any(|one| one.name() == run.name)).collect()
    };
    Ok(vec![of(training.runs()), of(held_out.runs())])
}
