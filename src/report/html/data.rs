//! The data of the live views: traces thinned to what a page can hold, the machine's surface.

use super::scale::Scale;
use crate::report::material::{MachineShape, RunTraces, Trace};
use crate::units::Motion;
use serde_json::{Value, json};

/// A trace of more samples is thinned, extremes kept.
pub(super) const MOST_SAMPLES: usize = 50_000;
/// Samples of all traces together, at most: eight bytes each.
const MOST_TOGETHER: usize = 300_000;
/// The same where samples are left out: which ones are there takes four bytes more.
const MOST_THINNED: usize = 160_000;

/// What the script of a page reads.
pub(super) fn of(motion: Motion, runs: &[RunTraces], shape: Option<&MachineShape>) -> Value {
    let samples =
        |run: &RunTraces| run.traces.iter().map(|trace| trace.measured.len()).collect::<Vec<usize>>();
    let lengths: Vec<usize> = runs.iter().flat_map(samples).collect();
    let fits = lengths.iter().sum::<usize>() <= MOST_TOGETHER && lengths.iter().all(|n| *n <= MOST_SAMPLES);
    let each = if fits { MOST_SAMPLES } else { (MOST_THINNED / lengths.len().max(1)).min(MOST_SAMPLES) };
    json!({
        "motion": motion,
        "runs": runs.iter().map(|run| run_of(run, motion, each)).collect::<Vec<_>>(),
        "machine": shape.map(machine_of),
    })
}

fn run_of(run: &RunTraces, motion: Motion, most: usize) -> Value {
    let traces: Vec<Value> = run.traces.iter().map(|trace| trace_of(trace, motion, most)).collect();
    let reference = thinned(&[&run.reference], most);
    let every = run.loads.len().div_ceil(2000).max(1);
    let loads: Vec<[f64; 4]> =
        run.loads.iter().step_by(every).map(|l| l.map(|x| (x * 10.0).round() / 10.0)).collect();
    json!({
        "name": run.name,
        "role": run.role,
        "samples": run.samples(),
        "period_s": run.period_s,
        "events": run.events.iter().map(|e| json!([e.time_s, e.word])).collect::<Vec<_>>(),
        "reference": { "at": indices(&reference, run.reference.len()), "values": floats(&picked(&run.reference, &reference)) },
        "traces": traces,
        "loads": { "every": every, "values": loads },
    })
}

fn trace_of(trace: &Trace, motion: Motion, most: usize) -> Value {
    let Trace { signal, measured, before, after } = trace;
    let less =
        |predicted: &[f64]| -> Vec<f64> { measured.iter().zip(predicted).map(|(m, p)| m - p).collect() };
    let (before, after) = (less(before), less(after));
    let chosen = thinned(&[measured, &before], most);
    let scale = Scale::signal(*signal, motion, measured);
    let error = Scale::of(signal.si_unit(motion), before.iter().chain(&after));
    let short =
        |samples: &[f64]| if samples.is_empty() { Value::Null } else { shorts(&picked(samples, &chosen)) };
    json!({
        "key": signal.key(motion),
        "word": signal.word(motion),
        "unit": scale.unit,
        "factor": scale.factor,
        "error_unit": error.unit,
        "error_factor": error.factor,
        "at": indices(&chosen, measured.len()),
        "values": floats(&picked(measured, &chosen)),
        "before": short(&before),
        "after": short(&after),
    })
}

fn picked(samples: &[f64], chosen: &[usize]) -> Vec<f64> {
    chosen.iter().filter_map(|&k| samples.get(k).copied()).collect()
}

/// Samples that are kept: all, or of each stretch the lowest and highest of every trace.
fn thinned(traces: &[&Vec<f64>], most: usize) -> Vec<usize> {
    let count = traces.first().map_or(0, |trace| trace.len());
    if count <= most {
        return (0..count).collect();
    }
    let traces: Vec<&&Vec<f64>> = traces.iter().filter(|trace| trace.len() == count).collect();
    let length = (count * 2 * traces.len()).div_ceil(most).max(1);
    let mut chosen = Vec::with_capacity(most);
    for start in (0..count).step_by(length) {
        let stretch = start..(start + length).min(count);
        let mut own: Vec<usize> = traces
            .iter()
            .flat_map(|trace| {
                let by = |a: &usize, b: &usize| trace[*a].total_cmp(&trace[*b]);
                [stretch.clone().min_by(by), stretch.clone().max_by(by)]
            })
            .flatten()
            .collect();
        own.sort_unstable();
        own.dedup();
        chosen.extend(own);
    }
    chosen
}

/// Indices where samples were left out; null where they are all there.
fn indices(chosen: &[usize], count: usize) -> Value {
    if chosen.len() == count {
        return Value::Null;
    }
    base64(chosen.iter().flat_map(|&k| (k as u32).to_le_bytes()))
}

/// Single precision: 3 nm of 50 mm.
fn floats(samples: &[f64]) -> Value {
    base64(samples.iter().flat_map(|x| (*x as f32).to_le_bytes()))
}

/// Sixteen bits of the largest: errors are small numbers of their own.
fn shorts(samples: &[f64]) -> Value {
    let largest = samples.iter().filter(|x| x.is_finite()).fold(0.0, |most: f64, x| most.max(x.abs()));
    let step = if largest > 0.0 { largest / f64::from(i16::MAX) } else { 1.0 };
    let codes = samples.iter().flat_map(|x| ((x / step).round() as i16).to_le_bytes());
    json!({ "step": step, "codes": base64(codes) })
}

fn machine_of(shape: &MachineShape) -> Value {
    let surfaces = shape.surfaces.iter().map(|surface| {
        json!({
            "name": surface.name,
            "moves": surface.moves,
            "vertices": base64(surface.vertices.iter().flatten().flat_map(|x| (*x as f32).to_le_bytes())),
            "triangles": base64(surface.triangles.iter().flatten().flat_map(|k| k.to_le_bytes())),
        })
    });
    json!({
        "surfaces": surfaces.collect::<Vec<_>>(),
        "axis": shape.axis,
        "origin": shape.origin,
        "limits": shape.limits,
        "sliders": shape.sliders,
        "modes": shape.modes,
    })
}

const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Bytes as text.
fn base64(bytes: impl Iterator<Item = u8>) -> Value {
    let bytes: Vec<u8> = bytes.collect();
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let all =
            chunk.iter().enumerate().fold(0u32, |all, (k, byte)| all | u32::from(*byte) << (16 - 8 * k));
        for k in 0..4 {
            let letter = LETTERS[(all >> (18 - 6 * k)) as usize & 63];
            text.push(if k <= chunk.len() { char::from(letter) } else { '=' });
        }
    }
    Value::String(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_bytes_as_text() {
        let text = |bytes: &[u8]| base64(bytes.iter().copied()).as_str().unwrap().to_owned();
        assert_eq!([text(b"Man"), text(b"Ma"), text(b"M"), text(b"")], ["TWFu", "TWE=", "TQ==", ""]);
    }

    #[test]
    fn exact_long_traces_keep_their_extremes() {
        let mut samples: Vec<f64> = (0..200_000).map(|k| (1e-3 * f64::from(k)).sin()).collect();
        (samples[123_456], samples[7]) = (5.0, -5.0);
        let other = vec![0.0; 200_000];
        let chosen = thinned(&[&samples, &other], MOST_SAMPLES);
        assert!(chosen.len() <= MOST_SAMPLES + 4, "{}", chosen.len());
        assert!(chosen.contains(&123_456) && chosen.contains(&7));
        assert!(chosen.windows(2).all(|w| w[0] < w[1]));
        assert_eq!(thinned(&[&samples[..100].to_vec()], 100).len(), 100);
    }
}
