//! Where an axis stands still.

use crate::diagnose::experiment::Experiment;
use std::ops::Range;

/// After the reference has stopped, the axis settles for so long, in s.
const SETTLING_S: f64 = 0.4;

/// Stretches of samples in which the reference does not move and the axis has settled.
pub fn settled(experiment: &Experiment) -> Vec<Range<usize>> {
    let settle = (SETTLING_S / experiment.run().sample_period_s()) as usize;
    let settled = |(from, to): (usize, usize)| if from == 0 { 0..to } else { from + settle..to };
    standstills(experiment).into_iter().map(settled).filter(|still| still.start < still.end).collect()
}

/// Stretches of samples in which the reference does not move.
fn standstills(experiment: &Experiment) -> Vec<(usize, usize)> {
    let commands = experiment.recorded().commands();
    let mut stretches = Vec::new();
    let mut from = 0;
    for k in 1..=commands.len() {
        let moves =
            k == commands.len() || commands[k].position_reference != commands[k - 1].position_reference;
        if moves {
            if k - from > 1 {
                stretches.push((from, k));
            }
            from = k;
        }
    }
    stretches
}
