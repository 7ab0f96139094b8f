//! Where in its play the drive train stands at the beginning of one run: before it, anything may have moved.

use super::hypothesis::path;
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::{Run, Signal};
use crate::replay::Traces;
use std::ops::Range;

/// Key of β, see [`Backlash`](crate::effect::Backlash).
pub(super) const KEY: &str = "initial_share";
/// Distances between values of β from whose replays its best value follows, round by round: the whole play, then many times what that is off by.
const REACHES: [f64; 2] = [1.0, 0.15];
/// Places between the ends at which the polynomial is looked at first (it has two minima at most), and halvings of the bracket then: to rounding.
const PLACES: usize = 40;
const HALVINGS: usize = 40;
/// Of a run one part in so many is replayed first, then longer parts by the other factor until β is forgotten: a choice of cost.
const FIRST_PART: usize = 16;
const LONGER: usize = 4;
/// The play was crossed where the motor has moved so many times its width: after one width one way a load that does not coast stands at that end, the rest is room for one that does.
const CROSSED: f64 = 4.0;
/// β is forgotten where the rest of the run would add less than this share to the curvature of the sum of squares over β: the best β is a mean by curvature of what both
/// parts tell, and moves by that share of how far they are apart.
const FORGOTTEN: f64 = 1e-3;
/// A sum of squares that changes by less than this share of itself says nothing of β: rounding.
const ROUNDING: f64 = 1e-12;

/// Whether the machine has a play whose beginning a run may have to tell.
pub fn has_play(machine: &Machine) -> bool {
    machine.description().effect.backlash.as_ref().is_some_and(|law| law.width_m > 0.0)
}

/// The machines with the β that suits the run best, where they have a play and the run does not state its β.
///
/// # Model
/// A replay is piecewise smooth in β. Near one value it depends on it as `y(β₀ + δ) = y₀ + a·δ + b·δ²`, which follows from replays at three values;
/// β is where the sum of squares, a polynomial of the fourth degree, is least within the play, each signal weighed by what the replay in the middle of
/// the three leaves of it. The values are the ends and the middle of the play first, then three near what came out. A run that does not depend on β leaves
/// it in the middle. Once the play was crossed and what differs has died out, the rest of the run tells nothing of β: it is not replayed. `replay` gives replays of so
/// many samples of several machines with perfect sensors, at the phases of vibrations that they state.
///
/// # Errors
/// None in practice: any β between −1 and 1 is one.
pub fn suited(
    run: &Run,
    signals: &[Signal],
    mut machines: Vec<Machine>,
    replay: impl Fn(&[Machine], usize) -> Vec<Traces>,
) -> Result<Vec<Machine>> {
    let open: Vec<usize> = (0..machines.len()).filter(|&k| has_play(&machines[k])).collect();
    if open.is_empty() || is_stated(run) {
        return Ok(machines);
    }
    let mut shares = vec![0.0_f64; open.len()];
    for reach in REACHES {
        let places = |share: f64| {
            let middle = share.clamp(reach - 1.0, 1.0 - reach);
            [middle - reach, middle, middle + reach]
        };
        let probes = open.iter().zip(&shares).flat_map(|(&m, share)| places(*share).map(|share| (m, share)));
        let probes: Vec<Machine> = probes.map(|(m, share)| at(&machines[m], share)).collect::<Result<_>>()?;
        let replayed = until_forgotten(signals, &probes, run.len(), &replay);
        for (share, traces) in shares.iter_mut().zip(replayed.chunks_exact(3)) {
            let [_, middle, _] = places(*share);
            let within = [(-1.0 - middle) / reach, (1.0 - middle) / reach];
            if let Some(step) = best(run, signals, traces, within.map(|end| end.clamp(-2.0, 2.0))) {
                *share = (middle + reach * step).clamp(-1.0, 1.0);
            }
        }
    }
    for (&m, share) in open.iter().zip(shares) {
        machines[m] = at(&machines[m], share)?;
    }
    Ok(machines)
}

/// Replays of three machines for each play, up to where β is forgotten in all of them.
fn until_forgotten(
    signals: &[Signal],
    probes: &[Machine],
    whole: usize,
    replay: &impl Fn(&[Machine], usize) -> Vec<Traces>,
) -> Vec<Traces> {
    let mut samples = whole.div_ceil(FIRST_PART);
    loop {
        let replayed = replay(probes, samples);
        let mut plays = probes.chunks_exact(3).zip(replayed.chunks_exact(3));
        let is_forgotten = |(machines, traces): (&[Machine], &[Traces])| {
            is_crossed(&machines[1], &traces[1]) && is_told(signals, traces, whole)
        };
        // Some replays are of the whole run in any case.
        let is_whole = replayed.iter().all(|traces| traces.position.len() >= whole);
        if is_whole || samples >= whole || plays.all(is_forgotten) {
            return replayed;
        }
        samples = (LONGER * samples).min(whole);
    }
}

/// Whether the motor has moved so far that it took the load with it, wherever in the play that stood.
fn is_crossed(machine: &Machine, traces: &Traces) -> bool {
    let width = machine.description().effect.backlash.as_ref().map_or(0.0, |law| law.width_m);
    let (low, high) =
        traces.position.iter().fold((f64::MAX, f64::MIN), |(low, high), &at| (low.min(at), high.max(at)));
    high - low >= CROSSED * width
}

/// Whether the rest of a run of so many samples tells next to nothing of β, where replays from different values go on to differ as they do in their last quarter.
fn is_told(signals: &[Signal], traces: &[Traces], whole: usize) -> bool {
    let is_told = |&signal: &Signal| {
        let Some(probed) = traces.iter().map(|of| of.signal(signal)).collect::<Option<Vec<&[f64]>>>() else {
            return true;
        };
        let last = last_quarter(probed[1].len());
        let power = |from: usize| -> f64 {
            let others = [probed[0], probed[2]].into_iter();
            let pairs = others.flat_map(|other| other[from..].iter().zip(&probed[1][from..]));
            pairs.map(|(a, b)| (a - b).powi(2)).sum()
        };
        let rest = (whole - last.start) as f64 / last.len() as f64;
        !last.is_empty() && rest * power(last.start) <= FORGOTTEN * power(0)
    };
    signals.iter().all(is_told)
}

/// The last quarter of so many samples.
pub(super) fn last_quarter(samples: usize) -> Range<usize> {
    samples - samples / 4..samples
}

/// A machine as set in a run, with the β of another one advanced by so much, unless that stands at an end of its play, where it does not follow
/// what else changes; unchanged where the run states its β.
///
/// # Errors
/// None in practice: any β between −1 and 1 is one.
pub fn advanced(run: &Run, of: &Machine, machine: Machine, advance: f64) -> Result<Machine> {
    match of.description().effect.backlash.as_ref().filter(|_| has_play(&machine) && !is_stated(run)) {
        Some(law) if law.initial_share.abs() < 1.0 => at(&machine, (law.initial_share + advance).min(1.0)),
        Some(law) => at(&machine, law.initial_share),
        None => Ok(machine),
    }
}

/// The machine at the middle of its play.
///
/// # Errors
/// None in practice.
pub fn from_middle(machine: Machine) -> Result<Machine> {
    if has_play(&machine) { at(&machine, 0.0) } else { Ok(machine) }
}

fn is_stated(run: &Run) -> bool {
    run.settings.contains_key(&path(EffectId::Backlash, KEY))
}

fn at(machine: &Machine, share: f64) -> Result<Machine> {
    machine.with_settings([(path(EffectId::Backlash, KEY).as_str(), toml::Value::Float(share))])
}

/// Where between two ends the replays come nearest to the run, in distances of the three from the middle one; none where they do not tell.
fn best(run: &Run, signals: &[Signal], traces: &[Traces], ends: [f64; 2]) -> Option<f64> {
    let mut sum = [0.0; 5];
    for &signal in signals {
        let probed: Option<Vec<&[f64]>> = traces.iter().map(|traces| traces.signal(signal)).collect();
        let Some((measured, probed)) = run.signal(signal).zip(probed) else { continue };
        let polynomial = squares(measured, [probed[0], probed[1], probed[2]]);
        let varies = polynomial[1..].iter().any(|c| *c != 0.0);
        if polynomial[0] == 0.0 && varies {
            return Some(0.0); // a signal that the middle one meets to the last bit
        }
        if varies && polynomial.iter().all(|c| c.is_finite()) {
            sum.iter_mut().zip(polynomial).for_each(|(sum, c)| *sum += c / polynomial[0]);
        }
    }
    least(&sum, ends)
}

/// Coefficients of `Σ(m − y₀ − a·δ − b·δ²)²` by powers of δ, the lowest first.
fn squares(measured: &[f64], [behind, middle, ahead]: [&[f64]; 3]) -> [f64; 5] {
    let mut sum = [0.0; 5];
    for (((measured, behind), middle), ahead) in measured.iter().zip(behind).zip(middle).zip(ahead) {
        let (r, a, b) = (measured - middle, 0.5 * (ahead - behind), 0.5 * (ahead + behind) - middle);
        let terms = [r * r, -2.0 * r * a, a * a - 2.0 * r * b, 2.0 * a * b, b * b];
        sum.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
    }
    sum
}

/// Where a polynomial is least between two ends; none where it does not vary.
fn least(polynomial: &[f64; 5], [from, to]: [f64; 2]) -> Option<f64> {
    let value = |x: f64| polynomial.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let place = |k: usize| from + (to - from) * k as f64 / PLACES as f64;
    let (mut best, mut most) = (from, f64::MIN);
    for x in (0..=PLACES).map(place) {
        best = if value(x) < value(best) { x } else { best };
        most = most.max(value(x));
    }
    if most - value(best) <= ROUNDING * polynomial[0].abs() {
        return None;
    }
    let slope = |x: f64| (1..5).rev().fold(0.0, |sum, k| sum * x + k as f64 * polynomial[k]);
    let reach = (to - from) / PLACES as f64;
    let (mut low, mut high) = ((best - reach).max(from), (best + reach).min(to));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if slope(middle) > 0.0 { high = middle } else { low = middle }
    }
    // At an end exactly, where it falls to there.
    let is_end = |end: f64, is_outward: bool| best == end && is_outward;
    if is_end(from, slope(from) >= 0.0) || is_end(to, slope(to) <= 0.0) {
        Some(best)
    } else {
        Some(0.5 * (low + high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::long_steps::tests::slow;

    const WHOLE: [f64; 2] = [-1.0, 1.0];

    /// A course that depends on β to second order, and noise-free samples of it at one β.
    #[test]
    fn exact_the_beginning_is_found_where_a_run_tells_it() {
        let y = |share: f64, k: usize| {
            let t = k as f64 * 0.1;
            t.sin() + share * (-t).exp() + 0.3 * share * share * t.cos()
        };
        let course = |share: f64| (0..50).map(|k| y(share, k)).collect::<Vec<f64>>();
        let [behind, middle, ahead] = [-1.0, 0.0, 1.0].map(course);
        for share in [-0.93, -0.2, 0.0, 0.41] {
            let polynomial = squares(&course(share), [&behind, &middle, &ahead]);
            let found = least(&polynomial, WHOLE).unwrap();
            assert!((found - share).abs() < 1e-6, "{share}: {found}");
        }
    }

    /// Beyond the ends of the play it stands at one of them exactly; where nothing depends on it nothing is told.
    #[test]
    fn exact_ends_are_ends_and_what_does_not_vary_tells_nothing() {
        let parabola = |at: f64| [at * at, -2.0 * at, 1.0, 0.0, 0.0];
        assert_eq!([1.7, -2.0].map(|at| least(&parabola(at), WHOLE)), [Some(1.0), Some(-1.0)]);
        assert!((least(&parabola(0.3), [-0.5, 2.0]).unwrap() - 0.3).abs() < 1e-9);
        assert_eq!([[0.0; 5], [3.0, 0.0, 0.0, 0.0, 0.0]].map(|p| least(&p, WHOLE)), [None, None]);
    }

    /// Replays are of more samples until the play was crossed and they have come together; of the whole run where they do not.
    #[test]
    fn exact_the_rest_of_a_run_is_not_replayed_once_its_beginning_is_forgotten() {
        let width_m = 1e-3;
        let key = path(EffectId::Backlash, "width_m");
        let machine = slow().with_settings([(key.as_str(), toml::Value::Float(width_m))]).unwrap();
        let probes: Vec<Machine> = [-1.0, 0.0, 1.0].map(|share| at(&machine, share).unwrap()).into();
        let replayed = |speed: f64, decay: f64| {
            let mut asked = Vec::new();
            let counted = std::cell::RefCell::new(&mut asked);
            let replay = |machines: &[Machine], samples: usize| {
                counted.borrow_mut().push(samples);
                let share = |m: &Machine| m.description().effect.backlash.as_ref().unwrap().initial_share;
                let at = |m: &Machine, k: usize| speed * k as f64 + share(m) * (-decay * k as f64).exp();
                let of = |m: &Machine| Traces {
                    position: (0..samples).map(|k| at(m, k)).collect(),
                    ..Traces::with_capacity(samples)
                };
                machines.iter().map(of).collect()
            };
            until_forgotten(&[Signal::Position], &probes, 1600, &replay);
            asked
        };
        assert_eq!([replayed(1e-3, 0.2), replayed(1e-3, 0.03)], [vec![100], vec![100, 400]]);
        // Not crossed for a while; and what differs stays.
        assert_eq!([replayed(9e-6, 0.2), replayed(1e-3, 0.0)], [[100, 400, 1600]; 2].map(Vec::from));
    }
}
