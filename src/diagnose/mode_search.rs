//! Frequencies of a mode that is not listed, from what the replays of a fit leave.

use super::care::Sensitivities;
use super::estimate::resonance::LOWEST_HZ;
use super::fit::Fit;
use super::hypothesis::with_effect;
use super::objective::Objective;
use super::score_test::ScoreTest;
use crate::effect::EffectId;
use crate::effect::flexible_mode::{DAMPING_RATIOS, HIGHEST_HZ, HIGHEST_OF_RATE};
use crate::error::Result;
use crate::machine::Machine;
use nalgebra::DVector;

/// Damping ratio of the modes that are tried over all frequencies: the largest that modes have, so that each covers its neighbourhood. Of the ringing of a mode
/// with the least one, such a mode explains 4·ζ₁·ζ₂/(ζ₁ + ζ₂)² = 28 %.
const DAMPING: f64 = DAMPING_RATIOS.1;
/// So many of the frequencies that explain most are tried again with the geometric mean of the damping ratios, and then with the least: a choice of cost.
const REFINED: usize = 6;
/// So many steps of the lesser damping to both sides of each: they reach half a step of the larger damping, where its next frequency takes over.
const BESIDE: i32 = 2;
/// Modal mass while a response is taken, in moving masses: a hundred times the largest of the prior, so that the response is of first order.
const MASSES: f64 = 1e4;

/// Where the fit of a mode may begin: frequency in Hz, modal mass in kg or kg·m², damping ratio; at most so many, the one that explains most first.
/// `mass` is the moving mass or inertia.
///
/// # Model
/// The replay's normalised residuals change with a mode of frequency f and modal mass M by R(f)/M, seen through the twin's own loop. With g and b of the
/// [score test](ScoreTest) of R:
/// ```text
///   1/M = b/g,   gain = b²/g, where b > 0
/// ```
/// Unlike the reaction of an oscillator in the missing force it takes no derivative of the position, which smoothing bounds to about 120 Hz, and weighs
/// every sample by what it tells.
///
/// # Validity
/// To first order in 1/M. A lightly damped mode is found where its frequency is among the [`REFINED`] that explain most with the largest damping.
///
/// # Errors
/// Whatever a replay refuses.
pub fn modes(
    objective: &Objective,
    fit: &Fit,
    sensitivities: &Sensitivities,
    mass: f64,
    most: usize,
) -> Result<Vec<Vec<f64>>> {
    let fitted = fit.machine(objective.machine)?;
    let frequencies = frequencies(objective.machine.description().sample_period_s);
    if frequencies.is_empty() {
        return Ok(Vec::new());
    }
    let heavy = MASSES * mass;
    let residuals = objective.residuals(&fit.values)?;
    let explained = |tried: Vec<Mode>| -> Result<Vec<Option<Explained>>> {
        let with = |m: &Mode| with_effect(&fitted, EffectId::FlexibleMode, &[m.frequency, heavy, m.damping]);
        let machines: Result<Vec<Machine>> = tried.iter().map(with).collect();
        let changed = objective.residuals_at(&machines?)?;
        let responses: Vec<DVector<f64>> =
            changed.into_iter().map(|changed| (changed - &residuals) * heavy).collect();
        let columns = &sensitivities.columns;
        let tests = ScoreTest::each(objective, &fit.values, &residuals, columns, &responses);
        let score = |(mode, [g, b]): (Mode, [f64; 2])| {
            (b > 0.0 && g > 0.0).then_some(Explained { mode, gain: b * b / g, mass: g / b })
        };
        Ok(tried.into_iter().zip(tests).map(score).collect())
    };
    let broad = frequencies.into_iter().map(|frequency| Mode { frequency, damping: DAMPING });
    let mut best = peaks(&explained(broad.collect())?);
    best.truncate(REFINED);
    if best.is_empty() {
        return Ok(Vec::new());
    }
    for damping in [(DAMPING_RATIOS.0 * DAMPING_RATIOS.1).sqrt(), DAMPING_RATIOS.0] {
        let narrow = best.iter().flat_map(|one| one.mode.narrowed(damping));
        let found = explained(narrow.collect())?;
        for (one, found) in best.iter_mut().zip(found.chunks(2 * BESIDE as usize + 1)) {
            let better = found.iter().flatten().filter(|other| other.gain > one.gain);
            if let Some(better) = better.max_by(|a, b| a.gain.total_cmp(&b.gain)) {
                *one = *better;
            }
        }
    }
    best.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let starts = best.into_iter().take(most);
    Ok(starts.map(|one| vec![one.mode.frequency, one.mass, one.mode.damping]).collect())
}

/// A mode that is tried.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Mode {
    /// In Hz.
    frequency: f64,
    /// Damping ratio.
    damping: f64,
}

impl Mode {
    /// Modes of this damping at its frequency and beside it, a mode's width at half its power apart.
    fn narrowed(self, damping: f64) -> impl Iterator<Item = Self> {
        let at = move |k: i32| Self { frequency: self.frequency * step(damping).powi(k), damping };
        (-BESIDE..=BESIDE).map(at)
    }
}

/// Ratio of a frequency to the one before: 1 + 2ζ, a mode's width at half its power.
fn step(damping: f64) -> f64 {
    1.0 + 2.0 * damping
}

/// What a mode explains.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Explained {
    mode: Mode,
    /// By how much it lowers the weighted sum of squares.
    gain: f64,
    /// Its modal mass.
    mass: f64,
}

/// Frequencies in Hz that are tried.
fn frequencies(period_s: f64) -> Vec<f64> {
    let (lowest, highest) = (LOWEST_HZ, HIGHEST_HZ.min(HIGHEST_OF_RATE / period_s));
    let up = std::iter::successors(Some(lowest), |f| Some(f * step(DAMPING)));
    up.take_while(|f| *f < highest).collect()
}

/// Modes that explain more than their neighbours; the one that explains most first.
fn peaks(scores: &[Option<Explained>]) -> Vec<Explained> {
    let gain = |k: usize| scores.get(k).copied().flatten().map_or(0.0, |score| score.gain);
    let is_peak = |&k: &usize| gain(k) > gain(k + 1) && (k == 0 || gain(k) >= gain(k - 1));
    let mut peaks: Vec<Explained> = (0..scores.len()).filter(is_peak).filter_map(|k| scores[k]).collect();
    peaks.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    peaks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::experiment::Experiment;
    use crate::diagnose::hypothesis::tests::hypothesis;
    use crate::diagnose::long_steps::tests::{slow, to_and_fro};
    use crate::diagnose::noise::Floor;
    use crate::plant::axis::LONGEST_STEP_S;
    use crate::replay::recording::recorded;
    use nalgebra::DMatrix;
    use std::collections::BTreeSet;

    /// On slow motion a mode of little damping mostly yields as a spring does, and so does every mode above it with the mass for that; what rings tells
    /// which one it is.
    #[test]
    fn exact_a_mode_of_little_damping_is_told_from_its_compliance() {
        let machine = slow();
        let mass = machine.constants().moving_mass;
        let truth = [21.0, 50.0 * mass, 0.006];
        let real = with_effect(&machine, EffectId::FlexibleMode, &truth).unwrap();
        let (reference, traces) = to_and_fro(&real);
        let run = Experiment::new(&recorded("run", &machine, &reference, traces).unwrap(), &machine).unwrap();
        let floor = Floor::estimate(&machine, &[&run]).unwrap();
        let (runs, hypothesis) = ([run], hypothesis(Vec::new()));
        let objective = Objective::new(&machine, &hypothesis, &runs, &floor);
        let rows = objective.residuals(&[]).unwrap().len();
        let columns = DMatrix::zeros(rows, 0);
        let sensitivities =
            Sensitivities { free: Vec::new(), columns, stride: 1, longest_step_s: LONGEST_STEP_S };
        let fit = Fit {
            hypothesis: hypothesis.clone(),
            values: Vec::new(),
            size: 0.0,
            mean_square: 0.0,
            standard_errors: Vec::new(),
            covariance: DMatrix::zeros(0, 0),
            shown: BTreeSet::new(),
        };
        let starts = modes(&objective, &fit, &sensitivities, mass, 3).unwrap();
        let [frequency, found, damping] = starts[0][..] else { panic!("{starts:?}") };
        assert!((frequency / truth[0] - 1.0).abs() < 0.02, "{starts:?}");
        assert!((found / truth[1] - 1.0).abs() < 0.3 && damping < 0.02, "{starts:?}");
    }

    /// Peaks are higher than both neighbours, at the ends than the one; what would need a negative mass is none.
    #[test]
    fn exact_peaks_are_told_by_what_they_explain() {
        let gains = [3.0, 1.0, 5.0, 5.0, 2.0, 0.0, 4.0];
        let mode = Mode { frequency: 40.0, damping: DAMPING };
        let score = |gain: f64| (gain > 0.0).then_some(Explained { mode, gain, mass: 10.0 * gain });
        let scores: Vec<Option<Explained>> = gains.map(score).to_vec();
        assert_eq!(peaks(&scores).iter().map(|peak| peak.gain).collect::<Vec<f64>>(), [5.0, 4.0, 3.0]);
        assert_eq!(peaks(&[None; 3]), []);
    }

    /// From the lowest frequency to a fifth of the sample rate, each within a mode's width of the one before.
    #[test]
    fn exact_frequencies_cover_all_that_is_sampled() {
        let frequencies = frequencies(1e-3);
        let last = frequencies[frequencies.len() - 1];
        assert!(frequencies[0] == 2.0 && last < 200.0 && last * step(DAMPING) >= 200.0);
        assert!(super::frequencies(0.1).is_empty());
        assert!(frequencies.windows(2).all(|pair| (pair[1] / pair[0] - 1.12).abs() < 1e-12));
    }
}
