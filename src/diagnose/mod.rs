//! Diagnosis: where the twin and the recording disagree, which effect causes it, how far it shrinks.
//!
//! The procedure is its own definition: check → floor → hypothesise and fit (training runs only) → compare (held-out
//! runs only) → prove → decide → locate. A fatal finding of the checks ends it before anything is fitted.

mod amplitude;
mod attribute;
mod autocorrelation;
mod beginnings;
mod borne_out;
mod bounded;
pub mod candidate;
pub mod care;
pub mod cause;
pub mod check;
pub mod compare;
mod conclude;
mod continuation;
pub mod cut;
mod dead_reference;
pub mod decide;
mod descent;
mod discrepancy;
mod drive_force;
mod earlier_search;
pub mod estimate;
pub mod evidence;
pub mod experiment;
mod fine_pitch;
pub mod fit;
mod floors;
mod folds;
pub mod found;
mod free;
pub mod grounds;
mod half_pitch;
pub mod harmonic;
pub mod hypothesis;
pub mod identifiability;
mod improve;
mod integration_error;
mod joint;
mod json;
mod line_search;
mod linearised;
mod locate;
mod logged_input;
mod long_steps;
mod measured;
mod merged_waves;
mod modal_masses;
mod mode_search;
pub mod motion;
mod nested;
pub mod next_experiment;
pub mod noise;
mod nonparametric;
pub mod objective;
mod ordinates;
mod other_minima;
mod outcome;
mod own_gap;
mod pair_search;
pub mod parameter;
pub mod phase;
mod pitch_search;
pub mod place;
pub mod play;
mod posterior;
mod predictive;
mod predictive_weights;
mod prior;
pub mod proposals;
pub mod prove;
pub mod reached;
pub mod residual_whiteness;
mod rivals;
mod run_setting;
mod sandwich;
mod scalar_product;
mod score_test;
mod segments;
pub mod selection;
mod sensor_bias;
mod settle;
pub mod shape;
mod short_travel;
mod significance;
pub mod smooth;
mod standard_errors;
pub mod thresholds;
pub mod training_gap;
mod uncertainty;
pub mod untested;
mod updated;
pub mod verdict;
pub mod visibility;
mod wald;
mod wave_basis;
mod wave_descent;
mod wave_sets;
mod wave_starts;
mod waves;
mod widen;

pub use compare::compare;
pub use improve::improved;
pub use verdict::{Diagnosis, Verdict};

use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::{HeldOutRuns, Recording, Run, Signal, Split, SplitRule, TrainingRuns};
use candidate::Candidate;
use cut::contradiction::StatedStretches;
use decide::Limits;
use evidence::Score;
use experiment::{Experiment, HeldOut, Training};
use fit::Fit;
use floors::Floors;
use found::Found;
use next_experiment::NextExperiment;
use noise::Floor;
use reached::Reached;
use selection::Search;
use std::collections::BTreeMap;
use training_gap::TrainingGap;
use visibility::View;

/// What a diagnosis may name, and who is told how it goes on.
pub struct Options<'a> {
    /// Effects that may be named.
    pub catalogue: &'a [EffectId],
    /// Told how far the fitting is.
    pub progress: &'a (dyn Fn(Progress) + Sync),
    /// Samples that are worked on, at most about: of more, the stretches of most motion ([`Recording::split_within`]).
    pub most_samples: usize,
    /// What the verdict is decided by.
    pub limits: Limits,
}

/// How far a diagnosis is. What is fitted next depends on what was found: the total grows round by round.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress<'a> {
    /// So many more hypotheses are to be fitted.
    Asked(usize),
    /// One of them has been, with these effects.
    Fitted(&'a str),
}

/// Beyond so many samples further ones of the same motion tell little: parameters are known to σ/√N of a gap that is many σ.
pub const MOST_SAMPLES: usize = 40_000;

impl Default for Options<'_> {
    fn default() -> Self {
        Self {
            catalogue: EffectId::ALL,
            progress: &|_| (),
            most_samples: MOST_SAMPLES,
            limits: Limits::default(),
        }
    }
}

/// Diagnoses a recording against a machine's twin.
///
/// # Errors
/// A recording that cannot be split into training and held-out runs, signals that a replay needs and the
/// recording lacks, or settings that the machine does not have.
pub fn diagnose(machine: &Machine, recording: &Recording, options: &Options) -> Result<Diagnosis> {
    diagnose_after(machine, recording, options, Before::default())
}

/// What is known of the machine before a recording was made.
#[derive(Clone, Default)]
struct Before {
    /// What its twin leaves of each signal anyway, RMS in SI.
    left: BTreeMap<Signal, f64>,
    /// In a comparison, the diagnosis of the reference.
    reference: Option<verdict::Reference>,
    /// Whether the recording is the reference of a comparison.
    is_reference: bool,
}

/// Diagnoses a recording of a machine of which something is known before.
fn diagnose_after(
    machine: &Machine,
    recording: &Recording,
    options: &Options,
    known: Before,
) -> Result<Diagnosis> {
    let split = recording.split_within(SplitRule::default(), options.most_samples)?;
    let mut ready = Ready::new(machine, &split.training, &split.held_out, known)?;
    let view = View::of(machine, ready.training.runs(), options.catalogue);
    // What is fitted to a column that is not what it is taken for says nothing.
    let is_fit_to_judge = grounds::fatal(&ready.checks).next().is_none();
    let catalogue = if is_fit_to_judge { &view.catalogue[..] } else { &[] };
    let options = &Options { catalogue, ..*options };
    let found = match ready.search(options, None)? {
        Reached::End(found) => found,
        Reached::OtherFloors(found) => ready.search_again(options, found)?,
    };
    let mut found = ready.search_again(options, found)?;
    if found.is_quiet(&ready.before) {
        // The held-out runs show no gap, or calibration leaves none that a cause explains overwhelmingly better.
        found.settle(&ready.before);
    }
    let diagnosis = ready.conclude(found, recording, &split, options)?;
    Ok(Diagnosis { not_examined: view.not_examined, ..diagnosis })
}

/// Runs made ready, with what is known before the search.
struct Ready<'a> {
    machine: &'a Machine,
    training: Training,
    held_out: HeldOut,
    floors: Floors,
    before: Score,
    /// Stretches of the signal path that show no gap of their own.
    clean: Vec<cut::Cut>,
    stretches: StatedStretches,
    known: Before,
    /// What was noticed in the data.
    checks: Vec<check::Finding>,
}

impl<'a> Ready<'a> {
    fn new(
        machine: &'a Machine,
        training: &TrainingRuns,
        held_out: &HeldOutRuns,
        known: Before,
    ) -> Result<Self> {
        let ready = |run: &Run| Experiment::new(run, machine);
        let (training, held_out) = (training.prepare(ready)?, held_out.prepare(ready)?);
        dead_reference::refuse(&training.runs().iter().chain(held_out.runs()).collect::<Vec<_>>())?;
        let checks = check::check(machine, training.runs(), held_out.runs());
        let floors = Floors::estimate(machine, &training, &held_out, &known.left)?;
        let before = Score::of(machine, &held_out, &floors.common)?;
        let stated = cut::stated(machine, training.runs())?;
        let (clean, stretches) = (cut::clean(&stated)?, StatedStretches::of(machine, &stated)?);
        Ok(Self { machine, training, held_out, floors, before, clean, stretches, known, checks })
    }

    /// The noise floors of the twin that has the causes of a fit, where they are others: noise takes another way through it (stick-slip above all).
    fn other_floors(&self, fit: &Fit) -> Result<Option<Floors>> {
        let twin = floors::without_noise(self.machine, fit)?;
        self.floors.others(&twin, (&self.training, &self.held_out), &self.known.left)
    }

    /// The noise floor of a candidate.
    fn floor_of(&self, candidate: &Candidate) -> &Floor {
        let own = self.floors.own(candidate.effects()).filter(|_| candidate.has_own_floor);
        own.unwrap_or(&self.floors.common)
    }

    /// Judges again by the noise floors of the explanation that a search chose, where they are others.
    fn search_again(&mut self, options: &Options, earlier: Found) -> Result<Found> {
        let chosen = &earlier.candidates[earlier.chosen];
        let other = if chosen.effects().is_empty() { None } else { self.other_floors(&chosen.fit)? };
        let Some(floors) = other else { return Ok(earlier) };
        self.floors = floors;
        self.before = Score::of(self.machine, &self.held_out, &self.floors.common)?;
        self.search(options, Some(&earlier)).map(Reached::found)
    }

    /// A search; one without an earlier one may end where its floors do not hold.
    fn search(&self, options: &Options, earlier: Option<&Found>) -> Result<Reached> {
        let constants = self.machine.constants();
        let applies = |effect: &EffectId| effect.applies(&constants);
        let catalogue: Vec<EffectId> = options.catalogue.iter().copied().filter(applies).collect();
        let catalogue = cut::left(&catalogue, &self.clean, self.training.runs());
        let has_other_floors = |fit: &Fit| self.other_floors(fit).map(|floors| floors.is_some());
        let search = Search {
            machine: self.machine,
            training: &self.training,
            held_out: &self.held_out,
            floors: &self.floors,
            catalogue: &catalogue,
            stretches: &self.stretches,
            earlier,
            limits: &options.limits,
            for_prediction: self.known.is_reference,
            progress: options.progress,
            has_other_floors: earlier.is_none().then_some(&has_other_floors),
        };
        search.run(&self.before)
    }

    fn conclude(
        &self,
        mut found: Found,
        recording: &Recording,
        split: &Split,
        options: &Options,
    ) -> Result<Diagnosis> {
        let runs = (&self.training, &self.held_out, &self.before);
        let is_comparison = self.known.reference.is_some();
        let folds = standard_errors::tell(&mut found, self.machine, runs, &self.floors, is_comparison)?;
        let floor = self.floor_of(&found.candidates[found.chosen]);
        let floors = [&self.floors.common, floor];
        let predicted = folds.predicted_closed(self.machine, &self.training, floors)?;
        let found = &found;
        let chosen = &found.candidates[found.chosen];
        let improved = chosen.fit.machine(self.machine)?;
        let (mut causes, harmonics) = conclude::causes(found, &self.before, &folds);
        let prove = || prove::rigid_body([self.machine, &improved], self.held_out.runs(), floors);
        let rigid_body = if causes.is_empty() { None } else { prove() };
        let (verdict, withheld) = self.decide(found, floor, &options.limits, rigid_body.as_ref());
        let next_experiment = match withheld {
            Some(_) => None,
            None => self.next_experiment(found, verdict, &mut causes)?,
        };
        self.set_phases(&mut causes, &improved)?;
        let runs: Vec<&Experiment> = self.training.runs().iter().chain(self.held_out.runs()).collect();
        short_travel::qualify(&mut causes, self.machine, &runs, options.catalogue);
        let training = self.training_gap(found, &improved, floor, &options.limits)?;
        let gap = self.gap(found, &improved, predicted, floor)?;
        let gap = verdict::Gap { rigid_body, training, ..gap };
        let unexplained = if verdict == Verdict::NoGap { 0.0 } else { (1.0 - gap.closed).clamp(0.0, 1.0) };
        let mut place = locate::locate([self.machine, &improved], self.held_out.runs(), &self.floors.common)?;
        attribute::attribute(&mut place, &causes, unexplained);
        Ok(Diagnosis {
            schema: verdict::SCHEMA.to_owned(),
            verdict,
            limits: options.limits,
            withheld,
            effects: conclude::effects(found, options.catalogue, &harmonics),
            ranking: conclude::ranking(found),
            refinements: conclude::refinements(found, &self.before),
            calibration: conclude::calibration(&chosen.fit),
            identifiability: identifiability::Identifiability::of(&chosen.fit),
            residual_whiteness: residual_whiteness::residual_whiteness(
                &improved,
                self.held_out.runs(),
                floor,
            )?,
            left: self.left(verdict, &gap, &improved, floor)?,
            gap,
            following_error: conclude::following_error(self.held_out.runs()),
            place,
            unexplained,
            next_experiment,
            causes,
            untested: if verdict == Verdict::Unknown { self.untested(options) } else { Vec::new() },
            not_examined: Vec::new(),
            ruled_out: cut::ruled_out(options.catalogue, &self.clean, self.training.runs()),
            checks: self.findings(chosen),
            data: self.data(recording, split),
            reference: self.known.reference.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        })
    }

    /// What the chosen explanation, `improved`, leaves of the held-out runs; `predicted` is the closed share that cross-validation predicts.
    fn gap(&self, found: &Found, improved: &Machine, predicted: f64, floor: &Floor) -> Result<verdict::Gap> {
        let chosen = &found.candidates[found.chosen];
        let shares = (found.share(found.chosen, &self.before), predicted);
        let (machines, scores) = ([self.machine, improved], [&self.before, &chosen.score]);
        let gap = conclude::gap(machines, scores, shares, self.held_out.runs(), floor)?;
        let gap = updated::with_predictive(gap, chosen);
        Ok(conclude::with_open_signals(gap, found, &self.before, self.machine))
    }

    /// What the chosen explanation, `improved`, leaves of the training runs.
    fn training_gap(
        &self,
        found: &Found,
        improved: &Machine,
        floor: &Floor,
        limits: &Limits,
    ) -> Result<TrainingGap> {
        let is_measured = floor.is_measured();
        let evidence = found.evidence(found.chosen, &self.before, is_measured);
        let is_only_here = evidence.explains_held_out(limits) && !evidence.explains_training(limits);
        let sets = match is_only_here {
            true => found.missing_in_training(&self.before, is_measured),
            false => Vec::new(),
        };
        let explained_by = sets.iter().map(|set| set.iter().map(|e| e.name().to_owned()).collect()).collect();
        let gap = TrainingGap::of(improved, &self.training, floor)?;
        Ok(TrainingGap { is_only_here, explained_by, ..gap })
    }

    /// The shape of what stays open of the held-out runs, or of the training runs where they alone are not explained; none where noise is all that is
    /// left.
    fn left(
        &self,
        verdict: Verdict,
        gap: &verdict::Gap,
        improved: &Machine,
        floor: &Floor,
    ) -> Result<Option<shape::Shape>> {
        let leaves_noise = gap.after <= thresholds::ADEQUATE_GAP && gap.unexplained_signals.is_empty();
        if verdict == Verdict::NoGap || leaves_noise && !gap.training.is_only_here {
            return Ok(None);
        }
        let (runs, name) = match gap.training.is_only_here {
            true => (self.training.runs(), "training"),
            false => (self.held_out.runs(), "held-out"),
        };
        shape::shape(improved, runs, name, floor).map(Some)
    }

    /// Sets the phases of a vibration among the causes, of all runs.
    fn set_phases(&self, causes: &mut [verdict::Cause], improved: &Machine) -> Result<()> {
        let vibrates = |cause: &&mut verdict::Cause| cause.effect == EffectId::ExternalVibration.name();
        if let Some(cause) = causes.iter_mut().find(vibrates) {
            cause.phases =
                conclude::phases(improved, self.training.runs().iter().chain(self.held_out.runs()))?;
        }
        Ok(())
    }

    /// The verdict, and why it is withheld if it is.
    fn decide(
        &self,
        found: &Found,
        floor: &Floor,
        limits: &Limits,
        rigid_body: Option<&prove::RigidBody>,
    ) -> (Verdict, Option<grounds::Withheld>) {
        let reference = self.known.reference.as_ref().map(|before| grounds::Before {
            is_explained: before.is_explained(),
            is_identified: before.is_identified(limits),
            gap_after: before.gap_after,
        });
        let unidentified = found.unidentified(self.machine);
        let unidentified = unidentified.as_ref();
        let grounds = grounds::Grounds { checks: &self.checks, reference, unidentified, rigid_body };
        decide::decide(&found.evidence(found.chosen, &self.before, floor.is_measured()), limits, &grounds)
    }

    /// What the recorded motion could not test of the effects that the machine can have.
    fn untested(&self, options: &Options) -> Vec<untested::Untested> {
        let constants = self.machine.constants();
        let applies = |effect: &EffectId| effect.applies(&constants);
        let catalogue: Vec<EffectId> = options.catalogue.iter().copied().filter(applies).collect();
        let runs: Vec<&Experiment> = self.training.runs().iter().chain(self.held_out.runs()).collect();
        untested::untested(self.machine, &runs, &catalogue)
    }

    /// What was diagnosed.
    fn data(&self, recording: &Recording, split: &Split) -> verdict::Data {
        let names = |runs: &[Experiment]| runs.iter().map(|e| e.run().name().to_string()).collect();
        verdict::Data {
            machine: self.machine.description().name.clone(),
            training: names(self.training.runs()),
            held_out: names(self.held_out.runs()),
            sha256: recording.sha256(),
            note: recording.note.clone(),
            cut: split.cut.clone(),
            samples: split.samples,
        }
    }

    /// What is to be known of the data.
    fn findings(&self, chosen: &Candidate) -> Vec<check::Finding> {
        let mut findings = self.checks.clone();
        findings.extend(visibility::findings(self.training.runs()));
        findings.extend(visibility::findings(self.held_out.runs()));
        findings.extend(chosen.has_own_floor.then(check::coarse_readings));
        findings
    }

    /// What to record next, where an explanation is left that does as well as the chosen one; explanations that could
    /// not but do as well are added to what the causes can be confused with.
    fn next_experiment(
        &self,
        found: &Found,
        verdict: Verdict,
        causes: &mut [verdict::Cause],
    ) -> Result<Option<NextExperiment>> {
        if causes.is_empty() && verdict != Verdict::Undecided {
            return Ok(None);
        }
        let proposal = next_experiment::propose(&next_experiment::Question {
            machine: self.machine,
            training: self.training.runs(),
            held_out: self.held_out.runs(),
            floor: self.floor_of(&found.candidates[found.chosen]),
            found,
            rivals: rivals::open_rivals(found, verdict == Verdict::Undecided),
        })?;
        for equal in &proposal.equivalent {
            let strange = equal.effects.difference(found.candidates[found.chosen].effects());
            let strange: Vec<String> = strange.map(|effect| effect.name().to_owned()).collect();
            if strange.is_empty() {
                continue;
            }
            for cause in causes.iter_mut().filter(|c| !equal.effects.iter().any(|e| e.name() == c.effect)) {
                cause.confusable_reason = Some(equal.reason(&strange));
                cause.confusable_with.extend(strange.iter().cloned());
                cause.confusable_with.sort();
                cause.confusable_with.dedup();
            }
        }
        Ok(proposal.next)
    }
}
