//! Whole numbers on the command line, refused in plain words.

use std::num::NonZeroUsize;

/// Repeats, or cases of a tier, at most: nobody looks through more.
const MOST: usize = 100_000;
/// Threads at most.
const MOST_JOBS: usize = 1024;

fn at_most(text: &str, most: usize) -> Result<NonZeroUsize, String> {
    let number = text.parse().ok().filter(|number: &NonZeroUsize| number.get() <= most);
    number.ok_or_else(|| format!("expected a whole number from 1 to {most}"))
}

/// How many of something, at least one.
pub(super) fn count(text: &str) -> Result<NonZeroUsize, String> {
    at_most(text, MOST)
}

/// How many threads, at least one.
pub(super) fn jobs(text: &str) -> Result<NonZeroUsize, String> {
    at_most(text, MOST_JOBS)
}

/// The seed of random numbers.
pub(super) fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("expected a whole number from 0 to {}", u64::MAX))
}
