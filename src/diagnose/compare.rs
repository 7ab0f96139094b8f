//! Two recordings of one machine, before and after: what changed between them.

use super::decide::above_noise;
use super::verdict::{Cause, Diagnosis, Parameter, Reference, Verdict};
use super::{Before, Options, diagnose_after};
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::{Recording, Signal};

/// The reference is diagnosed again with what was found in the twin, at most so often: the largest effects hide the
/// smaller ones.
const PASSES: usize = 3;

/// Diagnoses `recording` against the twin of the machine as it was when `reference` was recorded.
///
/// # Model
/// The machine's twin is given everything that a diagnosis of the reference finds, causes and calibration, until nothing
/// more is named or no more than a small gap ([`Limits::small_gap`](super::Limits)) is left; that twin is the baseline.
/// The recording is then diagnosed against it: its causes are what *changed*, and the `twin` value of each parameter is the value before. An effect that the baseline has already is
/// free inside `tolerance.effect` as calibration and may be named as a cause beyond it, like any other constant.
///
/// What the baseline leaves of the reference's own held-out runs is no change either: it is taken into the noise of
/// each signal, so that the gap of an unchanged machine is 1. It is no bound from below: an explanation of the recording that leaves less
/// is judged by what it leaves. Where more than a tenth of the reference's gap has no explanation, a change may hide in it, or look like
/// another one. The comparison is then `unknown` and says so; so is one that shows a gap where the explanation of the reference is not identified and leaves more than a small gap.
///
/// # Validity
/// Both recordings are of one machine; settings that differ between them (`set` of their runs) are known, not found.
/// What neither the reference nor the recording tells of the machine stays as its file states it.
///
/// # Errors
/// What [`diagnose`](super::diagnose) refuses, of either recording.
pub fn compare(
    machine: &Machine,
    reference: &Recording,
    recording: &Recording,
    options: &Options,
) -> Result<Diagnosis> {
    Baseline::of(machine, reference, options)?.change(recording, options)
}

/// The machine as it was when the reference was recorded: what recordings are compared with.
pub struct Baseline {
    machine: Machine,
    /// What its twin leaves of the reference's held-out runs, and the diagnosis of the reference.
    known: Before,
}

impl Baseline {
    /// Diagnoses the reference until nothing more is named, and takes all of it into the twin. Of a reference that no explanation explains that is the most probable
    /// one, whether its effects are certain or not: what changed is told from what the baseline predicts.
    ///
    /// # Errors
    /// What [`diagnose`](super::diagnose) refuses of the reference, with its path.
    pub fn of(machine: &Machine, reference: &Recording, options: &Options) -> Result<Self> {
        Self::found(machine, reference, options).map_err(|error| {
            match reference.path.as_os_str().is_empty() {
                true => error,
                false => error.file(&reference.path),
            }
        })
    }

    /// What has changed when `recording` was made.
    ///
    /// # Errors
    /// What [`diagnose`](super::diagnose) refuses of the recording.
    pub fn change(&self, recording: &Recording, options: &Options) -> Result<Diagnosis> {
        diagnose_after(&self.machine, recording, options, self.known.clone())
    }

    fn found(machine: &Machine, reference: &Recording, options: &Options) -> Result<Self> {
        let diagnose = |machine: &Machine| {
            diagnose_after(machine, reference, options, Before { is_reference: true, ..Before::default() })
        };
        let mut last = diagnose(machine)?;
        let mut baseline = last.improved(machine)?;
        let mut known = Reference {
            verdict: last.verdict,
            withheld: last.withheld.as_ref().map(|withheld| withheld.by),
            causes: last.causes.clone(),
            gap_before: last.gap.before,
            gap_after: last.gap.after,
            data: last.data.clone(),
        };
        // A pass whose explanation is refused leaves what its own twin leaves: the baseline.
        let mut is_refused = false;
        for _ in 1..PASSES {
            // A small gap need not be named: it counts as noise of the comparison.
            let is_small = last.gap.after <= options.limits.small_gap;
            if last.causes.is_empty() || last.refinements.is_empty() || is_small {
                break;
            }
            last = diagnose(&baseline)?;
            is_refused = last.withheld.is_some();
            if is_refused {
                break;
            }
            baseline = last.improved(&baseline)?;
            known.learn(&last);
        }
        let signals = last.gap.signals.iter();
        let left = signals.filter_map(|gap| {
            let left = if is_refused { gap.rms_before } else { gap.rms_after };
            Some((Signal::from_key(&gap.signal)?.0, left))
        });
        let left = left.collect();
        Ok(Self { machine: baseline, known: Before { left, reference: Some(known), is_reference: false } })
    }
}

impl Reference {
    /// Takes over what a further pass has found: the causes it names, with the twin's value of the first pass, and the
    /// calibration of those named before. A reference that the first pass does not explain is explained where a later one does.
    fn learn(&mut self, pass: &Diagnosis) {
        self.gap_after = pass.gap.after;
        if self.verdict == Verdict::Unknown && pass.verdict != Verdict::Unknown {
            let is_gap = pass.verdict == Verdict::NoGap && !self.causes.is_empty();
            self.verdict = if is_gap { Verdict::Cause } else { pass.verdict };
            self.withheld = None;
        }
        for calibration in &pass.calibration {
            let named = self.causes.iter_mut().flat_map(|cause| {
                let effect = cause.effect.clone();
                cause.parameters.iter_mut().map(move |(key, p)| (format!("effect.{effect}.{key}"), p))
            });
            let same = named.filter(|(path, _)| *path == calibration.path);
            same.for_each(|(_, parameter)| renew(parameter, &calibration.parameter));
            let of_effect =
                |cause: &&mut Cause| calibration.path.starts_with(&format!("effect.{}.", cause.effect));
            // Its parts have moved since; they stand by themselves then.
            self.causes.iter_mut().filter(of_effect).for_each(|cause| {
                cause.amplitudes.clear();
                cause.phases.clear();
            });
        }
        let share = above_noise(pass.gap.before) / above_noise(self.gap_before).max(f64::MIN_POSITIVE);
        for cause in &pass.causes {
            let closes = cause.closes * share.min(1.0);
            match self.causes.iter_mut().find(|known| known.effect == cause.effect) {
                None => self.causes.push(Cause { closes, ..cause.clone() }),
                Some(known) => {
                    known.closes += closes;
                    known.amplitudes.clone_from(&cause.amplitudes);
                    known.phases.clone_from(&cause.phases);
                    known.harmonics.extend(cause.harmonics.iter().cloned());
                    for (key, parameter) in &cause.parameters {
                        match known.parameters.get_mut(key) {
                            Some(own) => renew(own, parameter),
                            None => drop(known.parameters.insert(key.clone(), parameter.clone())),
                        }
                    }
                }
            }
        }
    }
}

/// A later estimate in the place of an earlier one; what the machine file has stays.
fn renew(parameter: &mut Parameter, later: &Parameter) {
    *parameter = Parameter { twin: parameter.twin, ..later.clone() };
}

impl Diagnosis {
    /// The machine with the causes and the calibration of its diagnosis; where nothing is named, calibration alone.
    ///
    /// # Errors
    /// A value that the machine's description refuses.
    pub fn improved(&self, machine: &Machine) -> Result<Machine> {
        let causes = self.causes.iter().flat_map(Cause::settings);
        let causes = causes.map(|(path, parameter)| (path, parameter.value));
        let calibration = self.calibration.iter().map(|c| (c.path.clone(), c.parameter.value));
        let settings: Vec<(String, f64)> = causes.chain(calibration).collect();
        machine.with_settings(settings.iter().map(|(path, value)| (path.as_str(), (*value).into())))
    }
}
