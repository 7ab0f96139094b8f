//! Where fits of what repeats along the axis or in time begin, and those of a mode, from what the replays of a fit leave.

use super::care::{Care, Sensitivities};
use super::estimate::{Screen, reading, vibration};
use super::fine_pitch::periods;
use super::fit::Fit;
use super::line_search::vibrations;
use super::mode_search::modes;
use super::pitch_search::{About, Family, PitchSearch, Travel};
use super::proposals::{Proposals, members};
use super::selection::Search;
use super::waves::{self, WaveLaw};
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;

/// Laws of a force over place that repeats.
const COGGING: [EffectId; 3] = [EffectId::Cogging, EffectId::SecondCogging, EffectId::ThirdCogging];
/// Laws of a share of the motor's force that repeats.
const RIPPLE: [EffectId; 2] = [EffectId::ForceRipple, EffectId::SecondForceRipple];
/// The law of what an encoder reads wrong.
const ENCODER: [EffectId; 1] = [EffectId::EncoderPeriodicError];
/// The law of what a screw moves wrong.
const SCREW: [EffectId; 1] = [EffectId::ScrewError];
/// Starts of a fine period.
const FINE_PERIODS: usize = 3;
/// A period of so many standard deviations of the position's noise: the noise of the place then takes a quarter off its amplitude, `1 − exp(−½(2π/8)²)`.
const CLEAR_OF_NOISE: f64 = 8.0;
/// Half of the shortest lead in the prior of [`ScrewError`](crate::effect::ScrewError), in m; the periods of its prior on a revolute axis are longer than
/// this many rad.
const LEAST_LEAD: f64 = 1e-3;
/// Starts of a mode.
const MODES: usize = 3;
/// The largest share of a ripple that a fit begins with: no fit begins where the motor pulls backwards.
const LARGEST_SHARE: f64 = 0.5;

/// What repeats along the axis.
fn families(screen: &Screen) -> [Family; 4] {
    let family = |laws, wave: WaveLaw, largest, harmonics| Family { laws, wave, largest, harmonics };
    let reading = reading::largest(screen);
    [
        family(&COGGING, waves::force, screen.largest_force, 2),
        family(&RIPPLE, waves::ripple, LARGEST_SHARE, 2),
        family(&ENCODER, waves::reading, reading, 1),
        family(&SCREW, waves::lead, reading, 1),
    ]
}

/// The places that the runs pass.
fn travel(screen: &Screen) -> Travel {
    let (low, high) = screen.ends();
    Travel { low, high, longest: screen.period_range().1 }
}

impl Search<'_> {
    /// Adds starts of the next law of each family, by itself and together with those that the fit has.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub(super) fn add_waves(
        &self,
        proposals: &mut Proposals,
        fit: &Fit,
        sensitivities: &Sensitivities,
        screen: &Screen,
    ) -> Result<()> {
        let objective = self.objective(&fit.hypothesis).for_care(Care::Rough(sensitivities));
        let effects = &fit.hypothesis.effects;
        let stated = &self.machine.description().effect;
        for family in families(screen) {
            let next = family.laws.iter().find(|law| !effects.contains(law) && !stated.contains(**law));
            let Some(&next) = next.filter(|law| self.catalogue.contains(law)) else { continue };
            let members = members(next);
            let is_found = members.len() > 1 && members.iter().all(|of| *of == next || effects.contains(of));
            let about = if is_found { About::Nonparametric } else { About::Fit };
            let search = PitchSearch::of(&objective, fit, sensitivities, family, travel(screen), about)?;
            let Some(search) = search else { continue };
            let together = if is_found { search.sets(&members) } else { Vec::new() };
            let mut pitches = search.pitches();
            // What a law has besides a wave (the flank of a screw) starts from none.
            pitches.iter_mut().for_each(|start| start.resize(next.parameters().len(), 0.0));
            proposals.add(next, pitches, together);
        }
        Ok(())
    }

    /// Starts of a reading's error with a period that is short against the travel, of each effect that makes one: the signal period of a scale, a lead.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub(super) fn fine_periods(
        &self,
        proposals: &Proposals,
        machine: &Machine,
        screen: &Screen,
    ) -> Result<Vec<(EffectId, Vec<Vec<f64>>)>> {
        let is_open = |effect: &EffectId| {
            !machine.description().effect.contains(*effect) && proposals.get(*effect).is_some()
        };
        let open: Vec<EffectId> = ENCODER.into_iter().chain(SCREW).filter(is_open).collect();
        if open.is_empty() {
            return Ok(Vec::new());
        }
        let noise = self.floors.common.sigma(Signal::Position);
        let (shortest, longest) = screen.period_range();
        let shortest = shortest.max(CLEAR_OF_NOISE * noise).max(screen.shortest_read());
        let found = periods(machine, self.training.runs(), shortest, screen.reading_step, FINE_PERIODS)?;
        let of_effect = |effect: EffectId| {
            // Behind one sensor a screw and an encoder are equals, where a screw may have such a lead.
            let least = if SCREW.contains(&effect) { LEAST_LEAD } else { 0.0 };
            let starts = found.iter().filter(|start| (least..=longest).contains(&start[0]));
            let mut starts: Vec<Vec<f64>> = starts.map(|start| start.to_vec()).collect();
            // What a law has besides a wave (the flank of a screw) starts from none.
            starts.iter_mut().for_each(|start| start.resize(effect.parameters().len(), 0.0));
            (effect, starts)
        };
        Ok(open.into_iter().map(of_effect).collect())
    }

    /// Adds starts of a vibration where the machine states none.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub(super) fn add_vibrations(&self, proposals: &mut Proposals, fit: &Fit, screen: &Screen) -> Result<()> {
        let is_stated = self.machine.description().effect.contains(EffectId::ExternalVibration);
        if is_stated || proposals.get(EffectId::ExternalVibration).is_none() {
            return Ok(());
        }
        let objective = self.objective(&fit.hypothesis);
        let starts = vibrations(&objective, &fit.values, screen.largest_force, vibration::STARTS)?;
        proposals.add(EffectId::ExternalVibration, starts, Vec::new());
        Ok(())
    }

    /// Adds starts of a mode where the machine's file states no further one.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub(super) fn add_modes(
        &self,
        proposals: &mut Proposals,
        fit: &Fit,
        sensitivities: &Sensitivities,
        screen: &Screen,
    ) -> Result<()> {
        let is_stated = self.machine.description().effect.contains(EffectId::FlexibleMode);
        if is_stated || proposals.get(EffectId::FlexibleMode).is_none() {
            return Ok(());
        }
        let objective = self.objective(&fit.hypothesis).for_care(Care::Rough(sensitivities));
        let starts = modes(&objective, fit, sensitivities, screen.moving_mass(), MODES)?;
        proposals.add(EffectId::FlexibleMode, starts, Vec::new());
        Ok(())
    }
}
