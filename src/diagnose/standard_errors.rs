//! The standard errors that a report tells: those of the chosen explanation, with all that leaves its numbers uncertain.

use super::evidence::Score;
use super::experiment::{HeldOut, Training};
use super::floors::Floors;
use super::folds::Folds;
use super::found::Found;
use super::other_minima;
use super::significance::none_is_significant;
use super::uncertainty::Uncertainty;
use crate::error::Result;
use crate::machine::Machine;

/// Widens the standard errors of the chosen fit; see [`Uncertainty::of`], [`Uncertainty::beside_modal_masses`], which `is_comparison` leaves out (one base, before and
/// after), and [`other_minima::covariance`]. Returns the fits without each training run. Where by these none of its effects is significant and calibration alone leaves noise, the
/// calibrated twin takes its place: there is nothing to name.
///
/// # Errors
/// Whatever a replay refuses.
pub(super) fn widen(
    found: &mut Found,
    machine: &Machine,
    (training, held_out, before): (&Training, &HeldOut, &Score),
    floors: &Floors,
    is_comparison: bool,
) -> Result<Folds> {
    let floor = &floors.common;
    let chosen = found.chosen;
    let known = found.uncertainties.remove(&chosen);
    let known =
        known.map_or_else(|| Uncertainty::of(machine, &found.candidates[chosen].fit, training, floor), Ok)?;
    let Uncertainty { fit: wide, folds } = match is_comparison {
        true => known,
        false => known.beside_modal_masses(machine, training, floor)?,
    };
    let fit = &mut found.candidates[chosen].fit;
    (fit.standard_errors, fit.covariance) = (wide.standard_errors, wide.covariance);
    let added = other_minima::covariance(found, machine, (training, held_out), floor)?;
    added.iter().for_each(|covariance| found.candidates[chosen].fit.widen(covariance));
    if none_is_significant(&found.candidates[chosen].fit) && found.predicts_to_noise(0) {
        found.settle(before);
        return widen(found, machine, (training, held_out, before), floors, is_comparison);
    }
    Ok(folds)
}
