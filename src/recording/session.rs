//! When the runs of a recording were made: their places on the session's clock.

use super::run::Run;
use crate::error::{Error, ErrorKind, Result};

/// Key of a run that states when it begins within the session, in s.
pub const BEGIN_KEY: &str = "begins_s";

/// Gives each run its place on the session's clock, in s.
///
/// # Errors
/// A `begins_s` that is no finite number, or that some runs state and others do not.
pub(super) fn place(runs: &mut [Run]) -> Result<()> {
    let stated: Vec<Option<f64>> = runs.iter().map(stated).collect::<Result<_>>()?;
    if let Some(lacking) =
        stated.iter().position(Option::is_none).filter(|_| stated.iter().any(Option::is_some))
    {
        return Err(refuse(
            &runs[lacking],
            ErrorKind::Missing,
            "no begins_s, which other runs state".to_owned(),
        ));
    }
    if stated.iter().all(Option::is_some) {
        runs.iter_mut().zip(stated).for_each(|(run, begins)| run.begins_s = begins.unwrap_or(0.0));
        return Ok(());
    }
    if share_a_clock(runs) {
        let first = runs.iter().map(|run| run.start_s).fold(f64::INFINITY, f64::min);
        runs.iter_mut().for_each(|run| run.begins_s = run.start_s - first);
        return Ok(());
    }
    let lengths_s: Vec<f64> = runs.iter().map(|run| run.duration_s() + run.sample_period_s()).collect();
    runs.iter_mut().zip(one_after_another(lengths_s)).for_each(|(run, begins_s)| run.begins_s = begins_s);
    Ok(())
}

/// When each of several runs begins that follow one another from time 0, from their lengths in s.
pub fn one_after_another(lengths_s: impl IntoIterator<Item = f64>) -> impl Iterator<Item = f64> {
    lengths_s.into_iter().scan(0.0, |now_s, length_s| Some(std::mem::replace(now_s, *now_s + length_s)))
}

/// Whether the time stamps of the runs lie side by side on one clock.
fn share_a_clock(runs: &[Run]) -> bool {
    let mut spans: Vec<[f64; 2]> =
        runs.iter().map(|run| [run.start_s, run.start_s + run.duration_s()]).collect();
    spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
    spans.windows(2).all(|pair| pair[0][1] < pair[1][0])
}

fn stated(run: &Run) -> Result<Option<f64>> {
    let Some(value) = run.metadata.get(BEGIN_KEY) else { return Ok(None) };
    let number = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    match number.filter(|begins| begins.is_finite()) {
        Some(begins) => Ok(Some(begins)),
        None => Err(refuse(run, ErrorKind::Syntax, value.to_string())),
    }
}

fn refuse(run: &Run, kind: ErrorKind, found: String) -> Error {
    let error = Error::new(kind)
        .key(format!("{}.{BEGIN_KEY}", run.name()))
        .found(found)
        .expected("seconds from the beginning of the session to that of the run, for all runs or for none")
        .remedy("state begins_s in every [[run]], or in none: runs then follow one another as listed");
    if run.file.as_os_str().is_empty() { error } else { error.file(&run.file) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Signal;
    use crate::units::Motion;
    use std::collections::BTreeMap;

    fn run(name: &str, samples: usize) -> Run {
        let signals = BTreeMap::from([(Signal::Position, vec![0.0; samples])]);
        Run::new(name, Motion::Prismatic, 0.5, signals).unwrap()
    }

    fn begins(runs: &mut [Run]) -> Vec<f64> {
        place(runs).unwrap();
        runs.iter().map(|run| run.begins_s).collect()
    }

    #[test]
    fn exact_runs_follow_one_another_where_no_clock_tells() {
        assert_eq!(begins(&mut [run("b", 4), run("a", 2), run("c", 9)]), [0.0, 2.0, 3.0]);
    }

    #[test]
    fn exact_time_stamps_on_one_clock_place_the_runs() {
        let mut runs = [run("a", 4), run("b", 4)];
        (runs[0].start_s, runs[1].start_s) = (60.0, 10.0);
        assert_eq!(begins(&mut runs), [50.0, 0.0]);
        // Two that overlap are not on one clock.
        (runs[0].start_s, runs[1].start_s) = (60.0, 61.0);
        assert_eq!(begins(&mut runs), [0.0, 2.0]);
    }

    #[test]
    fn exact_stated_begins_hold_for_all_runs_or_none() {
        let mut runs = [run("a", 4), run("b", 4)];
        runs[0].metadata.insert(BEGIN_KEY.to_owned(), 7.into());
        assert!(place(&mut runs).is_err());
        runs[1].metadata.insert(BEGIN_KEY.to_owned(), 1800.5.into());
        assert_eq!(begins(&mut runs), [7.0, 1800.5]);
        runs[1].metadata.insert(BEGIN_KEY.to_owned(), "late".into());
        assert!(place(&mut runs).is_err());
    }
}
