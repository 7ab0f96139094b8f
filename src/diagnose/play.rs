//! Where in its play the drive train stands at the beginning of one run: before it, anything may have moved.

use super::hypothesis::path;
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::{Run, Signal};
use crate::replay::Traces;

/// Key of β, see [`Backlash`](crate::effect::Backlash).
const KEY: &str = "begin_share";
/// Values of β from which a replay's dependence on it follows.
const PROBES: [f64; 3] = [-1.0, 0.0, 1.0];
/// Places between the ends at which the polynomial is looked at first, and halvings of the bracket then.
const PLACES: usize = 40;
const HALVINGS: usize = 40;

/// Whether the machine has a play whose beginning a run may have to tell.
pub fn has_play(machine: &Machine) -> bool {
    machine.description().effect.backlash.as_ref().is_some_and(|law| law.width_m > 0.0)
}

/// The machines with the β that suits the run best, where they have a play and the run does not state its β.
///
/// # Model
/// To second order a replay depends on β as `y(β) = y₀ + a·β + b·β²`, which follows from replays at β of −1, 0 and 1. β is where the sum of squares,
/// a polynomial of the fourth degree, is least between −1 and 1, each signal weighed by what the replay from the middle leaves of it. `replay` gives
/// replays of several machines with perfect sensors.
///
/// # Errors
/// None in practice: any β between −1 and 1 is one.
pub fn suited(
    run: &Run,
    signals: &[Signal],
    mut machines: Vec<Machine>,
    replay: impl Fn(&[Machine]) -> Vec<Traces>,
) -> Result<Vec<Machine>> {
    let open: Vec<usize> = (0..machines.len()).filter(|&k| has_play(&machines[k])).collect();
    if open.is_empty() || is_stated(run) {
        return Ok(machines);
    }
    let probes: Result<Vec<Machine>> = open
        .iter()
        .flat_map(|&m| PROBES.map(|share| (m, share)))
        .map(|(m, share)| at(&machines[m], share))
        .collect();
    let replayed = replay(&probes?);
    for (&m, traces) in open.iter().zip(replayed.chunks_exact(PROBES.len())) {
        machines[m] = at(&machines[m], best(run, signals, traces))?;
    }
    Ok(machines)
}

/// A machine as set in a run, with the β of another one advanced by so much, as far as it goes; unchanged where the run states its β.
///
/// # Errors
/// None in practice: any β between −1 and 1 is one.
pub fn advanced(run: &Run, of: &Machine, machine: Machine, advance: f64) -> Result<Machine> {
    match of.description().effect.backlash.as_ref().filter(|_| has_play(&machine) && !is_stated(run)) {
        Some(law) => at(&machine, (law.begin_share + advance).min(1.0)),
        None => Ok(machine),
    }
}

fn is_stated(run: &Run) -> bool {
    run.settings.contains_key(&path(EffectId::Backlash, KEY))
}

fn at(machine: &Machine, share: f64) -> Result<Machine> {
    machine.with_settings([(path(EffectId::Backlash, KEY).as_str(), toml::Value::Float(share))])
}

/// The β at which the replays come nearest to the run.
fn best(run: &Run, signals: &[Signal], traces: &[Traces]) -> f64 {
    let mut sum = [0.0; 5];
    for &signal in signals {
        let probed: Option<Vec<&[f64]>> = traces.iter().map(|traces| traces.signal(signal)).collect();
        let Some((measured, probed)) = run.signal(signal).zip(probed) else { continue };
        let polynomial = squares(measured, [probed[0], probed[1], probed[2]]);
        if polynomial[0] > 0.0 && polynomial.iter().all(|c| c.is_finite()) {
            sum.iter_mut().zip(polynomial).for_each(|(sum, c)| *sum += c / polynomial[0]);
        }
    }
    least(&sum)
}

/// Coefficients of `Σ(m − y₀ − a·β − b·β²)²` by powers of β, the lowest first.
fn squares(measured: &[f64], [behind, middle, ahead]: [&[f64]; 3]) -> [f64; 5] {
    let mut sum = [0.0; 5];
    for (((measured, behind), middle), ahead) in measured.iter().zip(behind).zip(middle).zip(ahead) {
        let (r, a, b) = (measured - middle, 0.5 * (ahead - behind), 0.5 * (ahead + behind) - middle);
        let terms = [r * r, -2.0 * r * a, a * a - 2.0 * r * b, 2.0 * a * b, b * b];
        sum.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
    }
    sum
}

/// Where a polynomial is least between −1 and 1.
fn least(polynomial: &[f64; 5]) -> f64 {
    let value = |x: f64| polynomial.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let place = |k: usize| 2.0 * k as f64 / PLACES as f64 - 1.0;
    let start = (0..=PLACES).map(place).min_by(|a, b| value(*a).total_cmp(&value(*b))).unwrap_or(0.0);
    let slope = |x: f64| (1..5).rev().fold(0.0, |sum, k| sum * x + k as f64 * polynomial[k]);
    let reach = 2.0 / PLACES as f64;
    let (mut low, mut high) = ((start - reach).max(-1.0), (start + reach).min(1.0));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if slope(middle) > 0.0 { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A course that depends on β to second order, and noise-free samples of it at one β.
    #[test]
    fn exact_the_beginning_is_found_where_a_run_tells_it() {
        let y = |share: f64, k: usize| {
            let t = k as f64 * 0.1;
            t.sin() + share * (-t).exp() + 0.3 * share * share * t.cos()
        };
        let course = |share: f64| (0..50).map(|k| y(share, k)).collect::<Vec<f64>>();
        let [behind, middle, ahead] = PROBES.map(course);
        for share in [-0.93, -0.2, 0.0, 0.41] {
            let polynomial = squares(&course(share), [&behind, &middle, &ahead]);
            assert!((least(&polynomial) - share).abs() < 1e-6, "{share}: {}", least(&polynomial));
        }
        // Beyond the ends of the play it stands at one.
        assert!((least(&[4.0, -4.0, 1.0, 0.0, 0.0]) - 1.0).abs() < 1e-9);
    }
}
