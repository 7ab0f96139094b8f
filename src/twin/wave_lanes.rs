//! Forces that repeat along the axis over one step, for several twins at once.

use crate::effect::Wave;
use crate::guide::{GAUSS, travel_until};
use crate::plant::axis::{LANES, Lane, Lanes};
use pulp::{Simd, WithSimd};
use std::array::from_fn;

/// Numbers of a wave: its pitch, those of the first two harmonics, those of the third and fourth.
const NUMBERS: usize = 9;

/// The waves of several twins, number by number; a twin that has fewer has waves of nothing beside them.
///
/// Each comes out to the last bit as [`Wave::at`] by itself.
#[derive(Debug, Clone)]
pub(super) struct WaveLanes {
    waves: Vec<[Lane; NUMBERS]>,
    step_s: f64,
    /// Their sum at the [`GAUSS`] points of the step, N or N·m.
    sums: [Lane; 2],
}

impl WaveLanes {
    /// Those of twins that have these, over steps of this length; none where none has any.
    pub fn of(twins: &[&[Wave]], step_s: f64) -> Option<Self> {
        let count = twins.iter().map(|waves| waves.len()).max().unwrap_or(0);
        let nothing = Wave { period: 1.0, own: [0.0; 4], higher: [0.0; 4] };
        let numbers = |twin: usize, k: usize| {
            let wave = twins.get(twin).and_then(|waves| waves.get(k)).unwrap_or(&nothing);
            let ([s1, c1, s2, c2], [s3, c3, s4, c4]) = (wave.own, wave.higher);
            [wave.period, s1, c1, s2, c2, s3, c3, s4, c4]
        };
        let rows = |k: usize| from_fn(|number| from_fn(|twin| numbers(twin, k)[number]));
        let waves = (0..count).map(rows).collect();
        (count > 0).then_some(Self { waves, step_s, sums: [[0.0; LANES]; 2] })
    }

    /// Finds them over the step that was looked at, in the vector instructions of the processor at hand.
    pub fn look(&mut self, axes: &Lanes) {
        let waves = Sum {
            position: axes.positions(),
            velocity: axes.velocities(),
            free_velocity: axes.free_velocities(),
            free_travel: axes.free_travels(),
            of: self,
        };
        axes.arch().dispatch(waves);
    }

    /// Their sum at the two [`GAUSS`] points of the step of a twin.
    #[inline(always)]
    pub fn at(&self, lane: usize) -> [f64; 2] {
        self.sums.map(|sum| sum[lane])
    }
}

struct Sum<'a> {
    of: &'a mut WaveLanes,
    position: &'a Lane,
    velocity: &'a Lane,
    free_velocity: &'a Lane,
    free_travel: &'a Lane,
}

impl WithSimd for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let WaveLanes { waves, step_s, sums } = self.of;
        // Values of their own, not places: nothing then keeps the loops from being vectors.
        let (position, velocity) = (*self.position, *self.velocity);
        let (free_velocity, free_travel, step_s) = (*self.free_velocity, *self.free_travel, *step_s);
        for (point, share) in GAUSS.into_iter().enumerate() {
            let mut place = [0.0; LANES];
            for k in 0..LANES {
                place[k] = position[k]
                    + travel_until(share, step_s, [velocity[k], free_velocity[k]], free_travel[k]);
            }
            // Zero as a sum of floating-point numbers begins.
            let mut sum = [-0.0; LANES];
            for numbers in waves.iter() {
                let numbers = *numbers;
                for k in 0..LANES {
                    let [period, s1, c1, s2, c2, s3, c3, s4, c4] = from_fn(|i| numbers[i][k]);
                    let wave = Wave { period, own: [s1, c1, s2, c2], higher: [s3, c3, s4, c4] };
                    sum[k] += wave.at_each(place[k]);
                }
            }
            sums[point] = sum;
        }
    }
}
