//! Fits to the end that go most of their way in long steps of the plant.

use super::care::Care;
use super::descent::{Arrived, InitialGuess, descend};
use super::objective::Objective;
use crate::error::Result;

/// Descends from a start as [`descend`] does. A fit to the end goes first in the longest steps of the plant that change its residuals little
/// ([`Objective::lengthened`]), and from where that ends in the fine ones.
///
/// # Model
/// `r_long(θ) + d`, with `d = r_fine(θ₀) − r_long(θ₀)` from the start θ₀, is what the fit in long steps minimises (defect correction): only what the
/// error of the steps *changes* on the way is left to the fine ones. Where the fit ends is told by those alone; the long steps change how soon.
///
/// # Errors
/// A setting of a run that the machine does not have.
///
/// # Source
/// D. Echeverría, P. W. Hemker (2005), *Space mapping and defect correction*, Comput. Methods Appl. Math. 5:107.
pub(super) fn descend_from(
    objective: &Objective,
    start: InitialGuess,
    care: Care,
    iterations: usize,
) -> Result<Arrived> {
    let start = match care {
        Care::Rough(_) => start,
        Care::Thorough => descended_in_long_steps(objective, start, iterations)?,
    };
    descend(objective, start, care, iterations)
}

/// Where the fit in long steps ends; the start where there are none.
fn descended_in_long_steps(
    objective: &Objective,
    start: InitialGuess,
    iterations: usize,
) -> Result<InitialGuess> {
    let fine = &start.residuals;
    let Some((long, residuals)) = objective.lengthened(&start.values, fine)? else { return Ok(start) };
    let defect = fine - &residuals;
    let corrected = Objective { defect: Some(&defect), ..long };
    let begun = InitialGuess { values: start.values, residuals: residuals + &defect };
    let values = descend(&corrected, begun, Care::Thorough, iterations)?.values;
    InitialGuess::at(objective, values)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::diagnose::experiment::Experiment;
    use crate::diagnose::free::Free;
    use crate::diagnose::free::tests::number;
    use crate::diagnose::hypothesis::Hypothesis;
    use crate::diagnose::hypothesis::tests::hypothesis;
    use crate::diagnose::noise::Floor;
    use crate::effect::EffectId;
    use crate::machine::Machine;
    use crate::machine::shipped;
    use crate::plant::axis::LONGEST_STEP_S;
    use crate::replay::recording::recorded;
    use crate::replay::{PlantChoice, Traces, simulate};
    use crate::twin::Sensing;
    use crate::units::Motion;

    /// A machine whose control period is several steps of the plant long.
    pub(in crate::diagnose) fn slow() -> Machine {
        let is_slow = |machine: &Machine| {
            let description = machine.description();
            let is_long = description.sample_period_s > 3.0 * LONGEST_STEP_S;
            is_long && description.controller.is_some() && machine.motion() == Motion::Prismatic
        };
        shipped().find(is_slow).unwrap()
    }

    /// Friction and the bristles' stiffness.
    pub(in crate::diagnose) fn bristles() -> Hypothesis {
        let of = |effect, name, scale: f64| Free {
            range: (0.1 * scale, 100.0 * scale),
            scale,
            ..number(effect, name)
        };
        let coulomb = of(EffectId::CoulombFriction, "force_n", 10.0);
        hypothesis(vec![coulomb, of(EffectId::Presliding, "stiffness_n_per_m", 1e6)])
    }

    /// A reference from rest to and fro, twice, and how the machine follows it.
    pub(in crate::diagnose) fn to_and_fro(real: &Machine) -> (Vec<f64>, Traces) {
        let period_s = real.description().sample_period_s;
        let wave = |t: f64| if t < 0.2 { 0.0 } else { 1e-3 * (1.0 - (5.0 * (t - 0.2)).cos()) };
        let reference: Vec<f64> = (0..1500).map(|k| wave(f64::from(k) * period_s)).collect();
        let traces = simulate(real, PlantChoice::Axis, Sensing::Perfect, &reference, |_| ()).unwrap();
        (reference, traces)
    }

    /// The long steps alone end beside the bristles' stiffness and the friction that made a run; the fine ones after them end there.
    #[test]
    fn exact_a_fit_to_the_end_ends_where_the_fine_steps_do() {
        let hypothesis = bristles();
        // Of a sensor that is a hundred times finer the error of the long steps shows.
        let noise_m = slow().description().encoder.noise_m;
        let stated = slow().with_settings([("encoder.noise_m", toml::Value::Float(0.01 * noise_m))]).unwrap();
        let truth = [60.0, 4e7];
        let real = hypothesis.machine(&stated, &truth).unwrap();
        let (reference, traces) = to_and_fro(&real);
        let runs =
            [Experiment::new(&recorded("run", &stated, &reference, traces).unwrap(), &stated).unwrap()];
        let floor = Floor::estimate(&stated, &[&runs[0]]).unwrap();
        let objective = Objective::new(&stated, &hypothesis, &runs, &floor);
        let off = |values: &[f64]| (values[0] / truth[0] - 1.0).abs().max((values[1] / truth[1] - 1.0).abs());
        let start = InitialGuess::at(&objective, vec![58.0, 1e7]).unwrap();
        let long = descended_in_long_steps(&objective, start.clone(), 60).unwrap().values;
        let fine = descend_from(&objective, start, Care::Thorough, 60).unwrap().values;
        assert!(off(&long) > 10.0 * off(&fine) && off(&fine) < 1e-4, "{long:?} {fine:?}");
    }
}
