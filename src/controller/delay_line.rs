//! A delay of whole samples.

/// The latest values: two more than a delay of whole samples, so that the value of one sample earlier is there as well.
#[derive(Debug, Clone)]
pub(crate) struct DelayLine<T> {
    ring: Vec<T>,
    newest: usize,
}

impl<T: Copy> DelayLine<T> {
    /// A delay of so many samples, through which the same value has gone so far.
    pub fn steady(delay: usize, value: T) -> Self {
        Self::of(vec![value; delay + 2])
    }

    /// A delay of two samples less than there are values of the past, the oldest first.
    pub fn of(past: Vec<T>) -> Self {
        Self { newest: past.len() - 1, ring: past }
    }

    /// The delay in samples.
    pub fn delay(&self) -> usize {
        self.ring.len() - 2
    }

    /// Takes the newest value and gives the one that the delay lets through, and the one before that.
    #[inline]
    pub fn pass(&mut self, value: T) -> [T; 2] {
        self.newest = self.after(self.newest);
        self.ring[self.newest] = value;
        // The ring holds two more than the delay: the oldest is next to be overwritten.
        let oldest = self.after(self.newest);
        [self.ring[self.after(oldest)], self.ring[oldest]]
    }

    /// All values, the newest first.
    pub fn newest_first(&self) -> impl Iterator<Item = T> {
        let count = self.ring.len();
        (0..count).map(move |k| self.ring[(self.newest + count - k) % count])
    }

    fn after(&self, place: usize) -> usize {
        if place + 1 == self.ring.len() { 0 } else { place + 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_delay_line_lets_through_what_went_in_before() {
        for periods in 0..4 {
            let mut line = DelayLine::steady(periods, -1.0);
            assert_eq!(line.delay(), periods);
            for k in 0..10_u32 {
                let at = |back: usize| {
                    let sample = i64::from(k) - back as i64;
                    if sample < 0 { -1.0 } else { sample as f64 }
                };
                assert_eq!(line.pass(f64::from(k)), [at(periods), at(periods + 1)]);
                let all: Vec<f64> = (0..periods + 2).map(at).collect();
                assert_eq!(line.newest_first().collect::<Vec<f64>>(), all);
            }
        }
    }
}
