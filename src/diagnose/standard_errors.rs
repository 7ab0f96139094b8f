//! The standard errors that a report tells: those of the chosen explanation, with all that leaves its numbers uncertain.

use super::evidence::Score;
use super::experiment::{HeldOut, Training};
use super::floors::Floors;
use super::folds::Folds;
use super::found::Found;
use super::other_minima;
use super::uncertainty::Uncertainty;
use crate::error::Result;
use crate::machine::Machine;

/// Widens the standard errors of the chosen fit; see [`Uncertainty::of`], [`Uncertainty::beside_modal_masses`], which `is_comparison` leaves out (one base, before and
/// after), and [`other_minima::covariance`]. Returns the fits without each training run.
///
/// # Errors
/// Whatever a replay refuses.
fn widen(
    found: &mut Found,
    machine: &Machine,
    (training, held_out): (&Training, &HeldOut),
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
    Ok(folds)
}

/// Takes the explanation that is told in the end, with its widened standard errors ([`widen`]): the calibrated twin where by these there is nothing to name beside it
/// ([`Found::has_nothing_to_name`]), and else the chosen one. Returns the fits without each training run.
///
/// # Errors
/// Whatever a replay refuses.
pub(super) fn tell(
    found: &mut Found,
    machine: &Machine,
    (training, held_out, before): (&Training, &HeldOut, &Score),
    floors: &Floors,
    is_comparison: bool,
) -> Result<Folds> {
    let runs = (training, held_out);
    let folds = widen(found, machine, runs, floors, is_comparison)?;
    if !found.has_nothing_to_name() {
        return Ok(folds);
    }
    found.settle(before);
    widen(found, machine, runs, floors, is_comparison)
}
