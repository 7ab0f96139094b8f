//! A run cut to pieces at standstills, and which of them are held out or used.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::coverage::{BINS, Counts, Coverage, MOTION_BINS, ways};
use super::kinematics::Kinematics;
use super::profile::Profile;
use super::run::Run;
use super::signal::Signal;

/// Share of a single run that is held out.
const HELD_OUT: f64 = 1.0 / 3.0;
/// A piece has at least so many samples.
pub(super) const LEAST_PIECE: usize = 50;
/// What a change between training and held out costs, in squares of shares: each cut leaves a start to be read.
const CHANGE_COST: f64 = 0.02;
/// A bin counts for the choice where it has at least this share of the moving samples.
const LEAST_BIN: f64 = 0.01;
/// Pieces among which roles are chosen, at most; shorter ones are joined.
const MOST_PIECES: usize = 200;
/// Standstills in which the axis still creeps are left out where one in so many, and more than one, are without.
const CALM_SHARE: usize = 4;
/// A cut in motion may lie this share of the run before or after the place wanted.
const MOTION_PLAY: f64 = 0.08;
/// A replay of a piece begins so much earlier, in s. What no signal tells of the state at a cut (how base and drive train swing) has died out
/// by then: a mode of 20 Hz with a damping ratio of 0.05 to 4 %.
const LEAD_S: f64 = 0.5;
/// Half width in s of the parabola from which the state at a cut is read.
const ENTRY_S: f64 = 4e-3;
/// Parts that a budget is spent in: no stretch that is chosen alone is longer than one.
const PORTIONS: usize = 12;
/// What goes on where a chosen stretch ends is preferred so much: it needs no start of its own.
const GOES_ON: f64 = 1.5;

/// How a single run was cut.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cut {
    /// Name of the run.
    pub run: String,
    /// Where it was cut, in s as its file counts.
    pub at_s: Vec<f64>,
    /// From when to when it is held out, in s as its file counts.
    pub held_out_s: Vec<[f64; 2]>,
    /// Whether the axis was moving there: it never stands.
    pub in_motion: bool,
    /// Directions, forward and backward, that only one side has.
    pub one_sided: Vec<String>,
}

/// Samples of a recording and how many of them are worked on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Samples {
    /// Worked on.
    pub used: usize,
    /// Recorded.
    pub recorded: usize,
    /// Worked on at most.
    pub most: usize,
    /// Stretches that the used ones lie in.
    pub stretches: usize,
}

/// A stretch of a run.
#[derive(Debug, Clone)]
struct Stretch {
    run: usize,
    samples: Range<usize>,
    /// Whether a replay may begin there.
    begins: bool,
    counts: Counts,
}

/// Sides of a single run: training, held out, how it was cut; none where it is too short or does not move.
pub(super) fn halves(run: &Run) -> Option<(Vec<Run>, Vec<Run>, Cut)> {
    let runs = std::slice::from_ref(run);
    let profile = Profile::of(run);
    if run.len() < 3 * LEAST_PIECE || profile.fastest() == 0.0 {
        return None;
    }
    let coverage = Coverage::of(runs, std::slice::from_ref(&profile));
    let mut ends = middles(run, &profile);
    let in_motion = ends.is_empty();
    if in_motion {
        ends = vec![moving_cut(run, &profile)];
    }
    let pieces = joined(&ends, run.len(), run.len() / MOST_PIECES);
    let counts: Vec<Counts> = pieces.iter().map(|piece| coverage.count(run, &profile, piece)).collect();
    let held_out = match pieces.len() {
        0 | 1 => return None,
        // The model of what it did so far says what it does next.
        2 if in_motion => vec![false, true],
        _ => roles(&pieces, &counts),
    };
    let sides = merged(&pieces, &held_out);
    let time_s = |sample: usize| run.file_time_s(sample);
    let cut = Cut {
        run: run.name().to_owned(),
        at_s: sides.iter().skip(1).map(|(samples, _)| time_s(samples.start)).collect(),
        held_out_s: sides
            .iter()
            .filter(|(_, held)| *held)
            .map(|(samples, _)| [time_s(samples.start), time_s(samples.end)])
            .collect(),
        in_motion,
        one_sided: one_sided(&counts, &held_out).into_iter().map(str::to_owned).collect(),
    };
    let side = |wanted: bool| -> Vec<Run> {
        let of = sides.iter().filter(|(_, held)| *held == wanted);
        of.map(|(samples, _)| piece(run, samples.clone())).collect()
    };
    Some((side(false), side(true), cut))
}

/// The middles of the standstills between which the axis moves; where there are enough of them, of those without creep.
fn middles(run: &Run, profile: &Profile) -> Vec<usize> {
    let inside = |still: &Range<usize>| still.start > 0 && still.end + profile.block < run.len();
    let all: Vec<Range<usize>> = profile.standstills(run).into_iter().filter(inside).collect();
    let calm: Vec<Range<usize>> = all.iter().filter(|still| profile.is_calm(still)).cloned().collect();
    let enough = CALM_SHARE * calm.len() >= all.len() && calm.len() > 1;
    let chosen = if enough { calm } else { all };
    chosen.iter().map(|still| still.start.midpoint(still.end)).collect()
}

/// The fastest place near the last third: friction slides and nothing accelerates there, so that the state is known best.
fn moving_cut(run: &Run, profile: &Profile) -> usize {
    let count = run.len() as f64;
    let [from, to] = [1.0 - HELD_OUT - MOTION_PLAY, 1.0 - HELD_OUT + MOTION_PLAY]
        .map(|share| (share * count) as usize / profile.block);
    let speed = |b: &usize| profile.velocity.get(*b).map_or(0.0, |v| v.abs());
    let fastest = (from..to.max(from + 1)).max_by(|a, b| speed(a).total_cmp(&speed(b)));
    (fastest.unwrap_or(from) * profile.block + profile.block / 2).clamp(LEAST_PIECE, run.len() - LEAST_PIECE)
}

/// Pieces between the ends, of at least so many samples.
fn joined(ends: &[usize], count: usize, least: usize) -> Vec<Range<usize>> {
    let least = least.max(LEAST_PIECE);
    let mut pieces: Vec<Range<usize>> = Vec::new();
    let mut from = 0;
    for end in ends.iter().copied().chain([count]) {
        if end - from >= least {
            pieces.push(from..end);
            from = end;
        }
    }
    match pieces.last_mut() {
        Some(last) => last.end = count,
        None => pieces.push(0..count),
    }
    pieces
}

/// Which pieces are held out: about a third of each kind of motion, in few stretches.
fn roles(pieces: &[Range<usize>], counts: &[Counts]) -> Vec<bool> {
    let total = sum(counts);
    let moving: f64 = ways(&total).iter().sum();
    let samples: usize = pieces.iter().map(Range::len).sum();
    let cost = |held: &[bool]| {
        let chosen = || held.iter().enumerate().filter(|(_, held)| **held).map(|(k, _)| k);
        let changes = held.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let length = chosen().map(|k| pieces[k].len()).sum::<usize>() as f64 / samples as f64;
        let share = |bin: usize| chosen().map(|k| counts[k][bin]).sum::<f64>() / total[bin];
        let bins = (0..MOTION_BINS).filter(|bin| total[*bin] > LEAST_BIN * moving);
        let unlike: f64 = bins.map(|bin| (share(bin) - HELD_OUT).powi(2)).sum();
        unlike + (length - HELD_OUT).powi(2) + CHANGE_COST * changes as f64
    };
    let count = pieces.len();
    let stretch = |from: usize, to: usize| (0..count).map(|k| k >= from && k < to).collect::<Vec<bool>>();
    // The last stretch of a given length first: of equal ones what comes later is held out.
    let starts = (1..count).map(|from| stretch(from, count));
    let inner = (0..count.min(40)).flat_map(|k| {
        let from = k * count / count.min(40);
        (1..=count / 2).step_by((count / 40).max(1)).map(move |length| (from, (from + length).min(count)))
    });
    let inner = inner.filter(|(from, to)| to - from < count).map(|(from, to)| stretch(from, to));
    let best = starts.chain(inner).map(|held| (cost(&held), held)).min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((mut least, mut held)) = best else { return vec![false; count] };
    for _ in 0..2 * count {
        let flipped = (0..count).filter_map(|k| {
            let mut other = held.clone();
            other[k] = !other[k];
            let is_two_sided = other.contains(&true) && other.contains(&false);
            is_two_sided.then(|| (cost(&other), other))
        });
        match flipped.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((less, other)) if less < least => (least, held) = (less, other),
            _ => break,
        }
    }
    held
}

fn sum(counts: &[Counts]) -> Counts {
    let mut total = [0.0; BINS];
    counts.iter().for_each(|one| total.iter_mut().zip(one).for_each(|(total, one)| *total += one));
    total
}

/// Neighbouring pieces of one role as one.
fn merged(pieces: &[Range<usize>], held_out: &[bool]) -> Vec<(Range<usize>, bool)> {
    let mut sides: Vec<(Range<usize>, bool)> = Vec::new();
    for (piece, held) in pieces.iter().zip(held_out) {
        match sides.last_mut().filter(|(last, role)| role == held && last.end == piece.start) {
            Some((last, _)) => last.end = piece.end,
            None => sides.push((piece.clone(), *held)),
        }
    }
    sides
}

/// Directions of which one side has none.
fn one_sided(counts: &[Counts], held_out: &[bool]) -> Vec<&'static str> {
    let side = |wanted: bool| -> [f64; 2] {
        let of = counts.iter().zip(held_out).filter(|(_, held)| **held == wanted);
        ways(&sum(&of.map(|(counts, _)| *counts).collect::<Vec<_>>()))
    };
    let (training, held_out) = (side(false), side(true));
    let words = ["forward", "backward"].into_iter().enumerate();
    words.filter(|(way, _)| (training[*way] > 0.0) != (held_out[*way] > 0.0)).map(|(_, word)| word).collect()
}

/// Some samples of a run under a name that says which, with those before as their lead.
fn piece(run: &Run, samples: Range<usize>) -> Run {
    if samples == (0..run.len()) {
        return run.clone();
    }
    let begun = |samples: Range<usize>| {
        let entry = entry(run, samples.start).filter(|_| samples.start > 0);
        run.part(samples, entry)
    };
    let lead = (LEAD_S / run.sample_period_s()).round() as usize;
    let before = samples.start.saturating_sub(lead)..samples.start;
    let is_led = before.len() >= LEAST_PIECE;
    let piece = begun(samples);
    if is_led { piece.led_by(begun(before)) } else { piece }
}

/// Position, velocity and acceleration at a sample, from a parabola through the positions on both sides; a velocity or an acceleration
/// that their scatter explains is none.
fn entry(run: &Run, sample: usize) -> Option<[f64; 3]> {
    let position = run.signal(Signal::Position)?;
    let wanted = ((ENTRY_S / run.sample_period_s()).round() as usize).max(3);
    let half = wanted.min(sample).min(run.len() - 1 - sample);
    let window = sample - half..sample + half + 1;
    let times_s = window.clone().map(|row| run.time_s(row) - run.time_s(sample));
    let fit = Kinematics::fit(times_s, &position[window.clone()])?;
    let (velocity, acceleration) = (fit.significant_velocity(), fit.significant_acceleration());
    Some([fit.state[0], velocity.unwrap_or(0.0), acceleration.unwrap_or(0.0)])
}

/// Stretches of the runs that hold most of their motion within so many samples; all of them where they fit.
///
/// # Model
/// The runs are cut at standstills, and what is longer than a portion of the budget further on: such a stretch is used only
/// after the one before it, so that every replay begins where the axis stood or the run began. The stretch that adds most to
/// Σ √(samples of a kind of motion) a sample is taken first, and so on: rare motion counts before more of the same.
pub(super) fn most_telling(runs: Vec<Run>, budget: usize) -> Vec<Run> {
    if runs.iter().map(Run::len).sum::<usize>() <= budget {
        return runs;
    }
    let profiles: Vec<Profile> = runs.iter().map(Profile::of).collect();
    let coverage = Coverage::of(&runs, &profiles);
    let portion = (budget / PORTIONS).max(LEAST_PIECE);
    let stretches: Vec<Stretch> = runs
        .iter()
        .zip(&profiles)
        .enumerate()
        .flat_map(|(k, (run, profile))| stretches(k, run, profile, &coverage, portion))
        .collect();
    let chosen = choose(&stretches, budget);
    let mut used: Vec<Run> = Vec::new();
    for (k, run) in runs.iter().enumerate() {
        let own = || stretches.iter().zip(&chosen).filter(|(stretch, _)| stretch.run == k);
        let pieces: Vec<Range<usize>> = own().map(|(stretch, _)| stretch.samples.clone()).collect();
        let is_used: Vec<bool> = own().map(|(_, chosen)| *chosen).collect();
        let kept = merged(&pieces, &is_used).into_iter().filter(|(_, used)| *used);
        used.extend(kept.map(|(samples, _)| piece(run, samples)));
    }
    used
}

/// The stretches of a run, in the order of time.
fn stretches(
    index: usize,
    run: &Run,
    profile: &Profile,
    coverage: &Coverage,
    portion: usize,
) -> Vec<Stretch> {
    let pieces = joined(&middles(run, profile), run.len(), portion / 2);
    let portions = pieces.into_iter().flat_map(|piece| {
        let parts = piece.len().div_ceil(portion).max(1);
        let at = move |part: usize| piece.start + part * piece.len() / parts;
        (0..parts).map(move |part| (at(part)..at(part + 1), part == 0)).collect::<Vec<_>>()
    });
    portions
        .map(|(samples, begins)| {
            let counts = coverage.count(run, profile, &samples);
            Stretch { run: index, samples, begins, counts }
        })
        .collect()
}

/// Which stretches are used.
fn choose(stretches: &[Stretch], budget: usize) -> Vec<bool> {
    let mut chosen = vec![false; stretches.len()];
    let (mut held, mut left) = ([0.0; BINS], budget);
    loop {
        let follows =
            |k: usize| k > 0 && chosen[k - 1] && stretches[k - 1].samples.end == stretches[k].samples.start;
        let open = |k: &usize| {
            !chosen[*k] && stretches[*k].samples.len() <= left && (stretches[*k].begins || follows(*k))
        };
        let gain = |k: usize| {
            let added =
                held.iter().zip(&stretches[k].counts).map(|(held, more)| (held + more).sqrt() - held.sqrt());
            let worth = added.sum::<f64>() / stretches[k].samples.len() as f64;
            if follows(k) { GOES_ON * worth } else { worth }
        };
        // Of equal ones the first.
        let open = (0..stretches.len()).filter(open).map(|k| (gain(k), k));
        let Some((_, best)) = open.reduce(|a, b| if b.0 > a.0 { b } else { a }) else { return chosen };
        chosen[best] = true;
        left -= stretches[best].samples.len();
        held.iter_mut().zip(&stretches[best].counts).for_each(|(held, more)| *held += more);
    }
}
