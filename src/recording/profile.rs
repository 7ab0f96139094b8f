//! The motion of a run in short blocks: where it stands, where it moves how.

use std::ops::Range;

use super::run::Run;
use super::signal::Signal;

/// Length of a block in s: means over it tell a standstill under noise and vibration.
const BLOCK_S: f64 = 0.01;
/// A block has at least so many samples, …
const LEAST_BLOCK: usize = 4;
/// … and a standstill lasts at least so long once the axis has settled, in s: half of it remains before the motion after a cut.
const LEAST_STANDSTILL_S: f64 = 0.1;
/// A reference stands while it keeps to this share of its range: rounding of the log.
const REFERENCE_STILL: f64 = 1e-6;
/// An axis slower than this share of its largest speed does not move.
pub(super) const SLOW: f64 = 0.01;
/// An axis has settled where it keeps within so many standard deviations of where it ends up, …
const SETTLED_DEVIATIONS: f64 = 4.0;
/// … or within this share of its travel.
const SETTLED_SHARE: f64 = 1e-4;
/// Means of the halves of a standstill that differ by more standard errors, and by more than this share of the travel, tell creep.
const CALM_DEVIATIONS: f64 = 4.0;
const CALM_SHARE: f64 = 1e-5;
/// Without a reference a speed is read over so many blocks.
const SPEED_BLOCKS: usize = 4;

/// Means over the blocks of a run.
#[derive(Debug, Clone)]
pub(super) struct Profile {
    /// Samples in a block.
    pub(super) block: usize,
    /// Length of a block in s.
    pub(super) block_s: f64,
    pub(super) position: Vec<f64>,
    pub(super) velocity: Vec<f64>,
    pub(super) acceleration: Vec<f64>,
}

impl Profile {
    /// The motion of a run, from the first of these that was logged: position, second position, their references.
    pub(super) fn of(run: &Run) -> Self {
        let period_s = run.sample_period_s();
        let block = ((BLOCK_S / period_s).round() as usize).max(LEAST_BLOCK);
        let block_s = block as f64 * period_s;
        let logged = [Signal::Position, Signal::LoadPosition, Signal::PositionReference];
        let samples = logged.into_iter().find_map(|signal| run.signal(signal));
        let mean = |samples: &[f64]| samples.iter().sum::<f64>() / samples.len() as f64;
        let position: Vec<f64> = samples.unwrap_or_default().chunks_exact(block).map(mean).collect();
        let velocity = slope(&position, block_s);
        let acceleration = slope(&velocity, block_s);
        Self { block, block_s, position, velocity, acceleration }
    }

    /// Largest speed.
    pub(super) fn fastest(&self) -> f64 {
        self.velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()))
    }

    /// Stretches of samples over which the axis of the run stands.
    ///
    /// # Model
    /// The reference keeps its value and the axis has settled: it stays about where it ends up and drifts at less than 1 % of
    /// its largest speed. A vibration about the place is no motion. Without a reference the speed over 40 ms decides.
    pub(super) fn standstills(&self, run: &Run) -> Vec<Range<usize>> {
        let still = match reference(run) {
            Some(reference) => constant(&reference, self.block),
            None => self.slow(),
        };
        let least = ((LEAST_STANDSTILL_S / self.block_s).ceil() as usize).max(2);
        let blocks = self.position.len();
        let range = still.into_iter().map(|stretch| stretch.start.min(blocks)..stretch.end.min(blocks));
        range
            .filter_map(|stretch| self.settled(stretch))
            .filter(|stretch| stretch.len() >= least)
            .map(|stretch| stretch.start * self.block..stretch.end * self.block)
            .collect()
    }

    /// Whether the axis does not creep in a standstill, a stretch of samples: its halves have means that scatter explains.
    pub(super) fn is_calm(&self, still: &Range<usize>) -> bool {
        let blocks = &self.position[still.start / self.block..still.end / self.block];
        let (early, late) = blocks.split_at(blocks.len() / 2);
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let squares = |part: &[f64]| part.iter().map(|x| (x - mean(part)).powi(2)).sum::<f64>();
        let deviation = ((squares(early) + squares(late)) / blocks.len() as f64).sqrt();
        let reach = CALM_DEVIATIONS * deviation * (4.0 / blocks.len() as f64).sqrt();
        (mean(late) - mean(early)).abs() <= reach.max(CALM_SHARE * self.travel())
    }

    /// Between the outermost places.
    fn travel(&self) -> f64 {
        let bounds = |(low, high): (f64, f64), x: &f64| (low.min(*x), high.max(*x));
        let (low, high) = self.position.iter().fold((f64::INFINITY, f64::NEG_INFINITY), bounds);
        high - low
    }

    /// Stretches of blocks in which the measured speed alone shows no motion.
    fn slow(&self) -> Vec<Range<usize>> {
        let (count, half) = (self.position.len(), SPEED_BLOCKS / 2);
        let limit = SLOW * self.fastest() * self.block_s;
        let moves = |b: usize| {
            let (from, to) = (b.saturating_sub(half), (b + half).min(count - 1));
            (self.position[to] - self.position[from]).abs() > limit * (to - from) as f64
        };
        let mut stretches: Vec<Range<usize>> = Vec::new();
        for b in (0..count).filter(|b| !moves(*b)) {
            match stretches.last_mut().filter(|last| last.end == b) {
                Some(last) => last.end = b + 1,
                None => stretches.push(b..b + 1),
            }
        }
        stretches
    }

    /// The part of a stretch of blocks from when the axis has settled; none where it drifts.
    fn settled(&self, stretch: Range<usize>) -> Option<Range<usize>> {
        let all = &self.position[stretch.clone()];
        let tail = &all[all.len() / 2..];
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let end = mean(tail);
        let deviation = (tail.iter().map(|x| (x - end).powi(2)).sum::<f64>() / tail.len() as f64).sqrt();
        let reach = (SETTLED_DEVIATIONS * deviation).max(SETTLED_SHARE * self.travel());
        let first = all.iter().rposition(|x| (x - end).abs() > reach).map_or(0, |last| last + 1);
        let settled = &all[first..];
        if settled.len() < 2 {
            return None;
        }
        let (early, late) = settled.split_at(settled.len() / 2);
        let apart_s = self.block_s * settled.len() as f64 / 2.0;
        let drift = (mean(late) - mean(early)).abs() / apart_s;
        (drift <= SLOW * self.fastest()).then_some(stretch.start + first..stretch.end)
    }
}

/// The position reference of a run, or what its velocity reference adds up to.
fn reference(run: &Run) -> Option<std::borrow::Cow<'_, [f64]>> {
    if let Some(position) = run.signal(Signal::PositionReference) {
        return Some(position.into());
    }
    let summed = |sum: &mut f64, v: &f64| {
        *sum += v;
        Some(*sum)
    };
    let velocity = run.signal(Signal::VelocityReference)?;
    Some(velocity.iter().scan(0.0, summed).collect::<Vec<f64>>().into())
}

/// Stretches of blocks over which a signal keeps its value.
fn constant(samples: &[f64], block: usize) -> Vec<Range<usize>> {
    let bounds = |part: &[f64]| {
        part.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)))
    };
    let (least, most) = bounds(samples);
    let tolerance = REFERENCE_STILL * (most - least);
    let mut stretches: Vec<Range<usize>> = Vec::new();
    let mut level = f64::NAN;
    for (b, part) in samples.chunks_exact(block).enumerate() {
        let (low, high) = bounds(part);
        let goes_on = low >= level - tolerance && high <= level + tolerance;
        match stretches.last_mut().filter(|last| goes_on && last.end == b) {
            Some(last) => last.end = b + 1,
            None if high - low <= tolerance => {
                level = 0.5 * (low + high);
                stretches.push(b..b + 1);
            }
            None => level = f64::NAN,
        }
    }
    stretches
}

/// Central differences per second.
fn slope(values: &[f64], step_s: f64) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    (0..values.len())
        .map(|k| {
            let (from, to) = (k.saturating_sub(1), (k + 1).min(last));
            if to > from { (values[to] - values[from]) / ((to - from) as f64 * step_s) } else { 0.0 }
        })
        .collect()
}
