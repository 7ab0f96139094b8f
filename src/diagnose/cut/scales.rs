//! The power of a residual over few and over many samples.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// From one scale to the next: a choice of cost. An offset between two scales shows at the longer one.
const FACTOR: usize = 4;
/// The longest scale has at least so many blocks a run: the spread of fewer says little.
const LEAST_BLOCKS: usize = 8;
/// Probability with which noise passes for more than noise at one scale. Of some seven scales of four stretches one in 36 diagnoses then looks at
/// effects that a clean stretch would have ruled out, which costs time only.
const BY_CHANCE: f64 = 1e-3;

/// Power of residuals in blocks of 1, 4, 16, … samples.
///
/// # Model
/// At scale n: Σ (sum of a block)²/n over all blocks of all runs. White noise has the same at every scale, a constant c has n times as much:
/// where it is below the noise of a sample it shows at the longest ones.
#[derive(Debug, Clone, Default)]
pub struct Scales(pub Vec<Scale>);

/// One scale.
#[derive(Debug, Clone, Copy, Default)]
pub struct Scale {
    power: f64,
    blocks: usize,
}

impl Scales {
    /// Adds the residual of a run.
    pub fn add(&mut self, residual: &[f64]) {
        let lengths = std::iter::successors(Some(1), |length| Some(FACTOR * length));
        let long_enough = |length: &usize| *length == 1 || residual.len() / length >= LEAST_BLOCKS;
        for (scale, length) in lengths.take_while(long_enough).enumerate() {
            if self.0.len() == scale {
                self.0.push(Scale::default());
            }
            let own = &mut self.0[scale];
            for block in residual.chunks_exact(length) {
                own.power += block.iter().sum::<f64>().powi(2) / length as f64;
                own.blocks += 1;
            }
        }
    }

    /// The power at a scale; none where no run is long enough.
    pub fn power(&self, scale: usize) -> f64 {
        self.0.get(scale).map_or(0.0, |scale| scale.power)
    }

    /// The ratio of two powers of the same noise at a scale that chance exceeds in one of a thousand.
    pub fn chance(&self, scale: usize) -> f64 {
        let blocks = self.0.get(scale).map_or(1, |scale| scale.blocks).max(1) as f64;
        FisherSnedecor::new(blocks, blocks).map_or(f64::INFINITY, |f| f.inverse_cdf(1.0 - BY_CHANCE))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A constant of a fifth of the noise makes 4 % of a sample's power, and of 256 samples' ten times the noise.
    #[test]
    fn exact_a_constant_below_the_noise_shows_over_many_samples() {
        use rand::{RngExt, SeedableRng};
        let mut random = rand::rngs::StdRng::seed_from_u64(5);
        // Uniform in ±√3: variance 1.
        let mut noise = || (0..4096).map(|_| 3.0_f64.sqrt() * random.random_range(-1.0..1.0)).collect();
        let (one, other): (Vec<f64>, Vec<f64>) = (noise(), noise());
        let of = |residual: &[f64]| {
            let mut scales = Scales::default();
            scales.add(residual);
            scales
        };
        let (noise, again) = (of(&one), of(&other));
        let off = of(&other.iter().map(|x| x + 0.2).collect::<Vec<f64>>());
        assert_eq!(noise.0.len(), 5);
        for scale in 0..5 {
            assert!(again.power(scale) <= noise.chance(scale) * noise.power(scale), "{scale}");
        }
        assert!(off.power(0) < 1.2 * noise.power(0));
        assert!(off.power(4) > noise.chance(4) * noise.power(4));
    }
}
