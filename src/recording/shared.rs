//! Held-out samples that are training samples too: a copy, a cut or an overlap of two logs.

use std::collections::HashMap;

use super::run::Run;
use super::signal::Signal;
use crate::error::{Error, ErrorKind, Result};

/// Samples of a piece that is looked for.
const PIECE: usize = 64;
/// Samples in common, elsewhere in the run, that chance does not make.
const FEWEST_ELSEWHERE: usize = 500;
/// Share of the shorter run in common at the same place, beyond what two simulated strokes begin with.
const SHARE_IN_PLACE: f64 = 0.5;
const FACTOR: u64 = 0x9E37_79B9_7F4A_7C15;

/// Refuses a held-out run that has samples in common with a training run, in all signals that both have.
///
/// # Validity
/// Standstills say nothing, and simulated runs without noise begin alike: in place, half of the shorter run must agree.
pub(super) fn check(run: &Run, training: &[Run]) -> Result<()> {
    for other in training {
        // Two time ranges of one file are told apart by their times.
        if run.sha256() == other.sha256() && !run.sha256().is_empty() {
            continue;
        }
        if let Some((count, [at, place])) = in_common(run, other) {
            return Err(Error::new(ErrorKind::Inconsistent)
                .key(run.name())
                .found(format!(
                    "{count} held-out samples, from sample {} on, that are those of the training run `{}` from sample {} on",
                    at + 1,
                    other.name(),
                    place + 1
                ))
                .expected("held-out runs that were not trained on")
                .remedy("cut the overlap from one of the two runs, or drop one"));
        }
    }
    Ok(())
}

/// The first piece in common that says something: its samples, and where it begins in both.
fn in_common(run: &Run, other: &Run) -> Option<(usize, [usize; 2])> {
    let (a, b) = marks(run, other)?;
    let moving = run.signal(Signal::Position).or_else(|| run.signals().values().next().map(Vec::as_slice))?;
    let mut pieces: HashMap<u64, usize> = HashMap::new();
    for start in (0..(a.len() + 1).saturating_sub(PIECE)).step_by(PIECE) {
        let is_moving = moving[start..start + PIECE].iter().any(|x| *x != moving[start]);
        if is_moving {
            pieces.entry(hash(&a[start..start + PIECE])).or_insert(start);
        }
    }
    let last = FACTOR.wrapping_pow(PIECE as u32);
    let mut rolling = 0_u64;
    let mut seen_to = 0;
    for end in 0..b.len() {
        rolling = rolling.wrapping_mul(FACTOR).wrapping_add(b[end]);
        if end >= PIECE {
            rolling = rolling.wrapping_sub(last.wrapping_mul(b[end - PIECE]));
        }
        if end + 1 < PIECE.max(seen_to) {
            continue;
        }
        let Some(&start) = pieces.get(&rolling) else { continue };
        let place = end + 1 - PIECE;
        let before = a[..start].iter().rev().zip(b[..place].iter().rev()).take_while(|(a, b)| a == b).count();
        let behind = a[start..].iter().zip(&b[place..]).take_while(|(a, b)| a == b).count();
        let (count, begin) = (before + behind, [start - before, place - before]);
        seen_to = place + behind;
        let shorter = a.len().min(b.len()) as f64;
        let enough = if begin[0] == begin[1] {
            SHARE_IN_PLACE * shorter
        } else {
            (FEWEST_ELSEWHERE as f64).min(SHARE_IN_PLACE * shorter)
        };
        let piece = &moving[begin[0]..begin[0] + count];
        let moved = piece.windows(2).filter(|pair| pair[0] != pair[1]).count();
        if count as f64 >= enough && moved >= PIECE / 2 {
            return Some((count, begin));
        }
    }
    None
}

/// One number a sample from all signals that both runs have; none where they have no measured one in common.
fn marks(run: &Run, other: &Run) -> Option<(Vec<u64>, Vec<u64>)> {
    let common: Vec<Signal> =
        run.signals().keys().copied().filter(|signal| other.signal(*signal).is_some()).collect();
    if !common.iter().any(|signal| signal.is_measured()) {
        return None;
    }
    let of = |run: &Run| -> Vec<u64> {
        let mut marks = vec![0_u64; run.len()];
        for signal in &common {
            for (mark, sample) in marks.iter_mut().zip(run.signal(*signal).unwrap_or_default()) {
                *mark = (mark.rotate_left(23) ^ (sample + 0.0).to_bits()).wrapping_mul(FACTOR);
            }
        }
        marks
    };
    Some((of(run), of(other)))
}

fn hash(marks: &[u64]) -> u64 {
    marks.iter().fold(0, |hash: u64, mark| hash.wrapping_mul(FACTOR).wrapping_add(*mark))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Motion;
    use std::collections::BTreeMap;

    fn noise(seed: u64, samples: usize) -> Vec<f64> {
        (0..samples as u64).map(|k| ((k + seed * 7919).wrapping_mul(FACTOR) >> 40) as f64 * 1e-9).collect()
    }

    fn run(name: &str, samples: Vec<f64>) -> Run {
        Run::new(name, Motion::Prismatic, 1e-3, BTreeMap::from([(Signal::Position, samples)])).unwrap()
    }

    #[test]
    fn exact_copies_cuts_and_overlaps_are_found() {
        let log = noise(1, 4000);
        let training = [run("t", log.clone())];
        let joined = |a: &[f64], b: &[f64]| [a, b].concat();
        for (held_out, begins) in [
            (log[..3000].to_vec(), "from sample 1 on"),
            (log[1500..].to_vec(), "from sample 1501 on"),
            (joined(&noise(2, 2000), &log[1000..1700]), "from sample 1001 on"),
        ] {
            let error = check(&run("h", held_out), &training).unwrap_err();
            assert!(error.to_string().contains(begins), "{error}");
        }
        assert!(check(&run("h", noise(3, 4000)), &training).is_ok());
    }

    #[test]
    fn exact_standstills_and_like_beginnings_are_no_copies() {
        let still = [vec![0.0; 3000], noise(4, 1000)].concat();
        let other = [vec![0.0; 3000], noise(5, 1000)].concat();
        assert!(check(&run("h", still), &[run("t", other)]).is_ok());
        let (long, short) = (noise(6, 4000), [&noise(6, 900)[..], &noise(7, 2000)].concat());
        assert!(check(&run("h", short), &[run("t", long)]).is_ok());
    }
}
