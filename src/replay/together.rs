//! Several twins through a run in one pass.

use crate::plant::axis::{Axis, LANES};
use crate::twin::{Batch, Command, Driven, Sample, Twin};
use pulp::Arch;

/// A pass costs as much as so many twins by themselves, however few it has: 2.5 (`cargo bench --bench twin`).
const LEAST_LANES: usize = 3;

/// Walks twins on the reduced axis through a run, [`LANES`] of them in one pass where they fit into one, else one by one.
///
/// `command(twin, k)` is what reaches a twin at sample k; `restart(k)` the position and velocity with which all of them begin
/// anew before it, if they do; `each` gets position and velocity of a twin's plant at a sample, and the sample.
pub fn run_together(
    mut twins: Vec<Twin<Axis>>,
    driven: Driven,
    samples: usize,
    command: impl Fn(usize, usize) -> Command,
    restart: impl Fn(usize) -> Option<[f64; 2]>,
    mut each: impl FnMut(usize, [f64; 2], Sample),
) {
    let mut first = 0;
    while !twins.is_empty() {
        let rest = twins.split_off(twins.len().min(LANES));
        let count = twins.len();
        let joined = if count < LEAST_LANES { Err(twins) } else { Batch::of(twins, driven) };
        match joined {
            Ok(mut batch) => vectorised(
                samples,
                #[inline(always)]
                |k| {
                    if let Some([position, velocity]) = restart(k) {
                        batch.restart(position, velocity);
                    }
                    let states = batch.states();
                    let command = |lane: usize| command(first + lane, k);
                    batch.step(command, |lane, sample| each(first + lane, states[lane], sample));
                },
            ),
            Err(singles) => {
                for (twin, mut single) in (first..).zip(singles) {
                    vectorised(
                        samples,
                        #[inline(always)]
                        |k| {
                            if let Some([position, velocity]) = restart(k) {
                                single.restart(position, velocity);
                            }
                            let state = single.state();
                            each(twin, state, single.step(command(twin, k)));
                        },
                    );
                }
            }
        }
        first += count;
        twins = rest;
    }
}

/// Loops over so many samples, compiled for the widest vector instructions of the processor at hand, and so is all that is inlined into `period`: scalar laws need fewer
/// instructions there. Results are the same to the last bit, since no product is fused with a sum that is not written so.
fn vectorised(samples: usize, mut period: impl FnMut(usize)) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for k in 0..samples {
                period(k);
            }
        },
    );
}
