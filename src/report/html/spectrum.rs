//! Spectra of the errors, and the frequency response of machine and twin with coherence.

use super::page::Part;
use super::polar::{decibel_unit, decibels, magnitude_band, unwrapped};
use super::scale::Scale;
use crate::identify::frequency_response::Point;
use crate::report::figure::{Axis, Chart, Figure, Ink, Mark, Panel};
use crate::report::material::{Material, Response};
use crate::units::Motion;

/// Below this coherence a measured response is noise over nothing.
const COHERENT: f64 = 0.5;

/// The section.
pub(super) fn part(material: &Material) -> Part {
    let mut part = Part::default();
    if !material.spectra.is_empty() {
        part.figure(spectra(material));
    }
    match &material.response {
        Some(response) => {
            part.figure(figure(response, material.motion, material.baseline));
        }
        None => {
            part.remark(
                "No frequency response: an effort and a motion would have to be logged, and long enough.",
            );
        }
    }
    part
}

fn spectra(material: &Material) -> Figure {
    let Material { spectra, motion, baseline, .. } = material;
    let panels = spectra.iter().enumerate().map(|(k, spectrum)| {
        let all: Vec<f64> = spectrum.density.iter().flat_map(|[_, b, a]| [*b, *a]).collect();
        let scale = Scale::of(spectrum.unit, &all);
        let curve = |place: usize| -> Vec<[f64; 2]> {
            spectrum.density.iter().map(|point| [point[0], scale.to(point[place])]).collect()
        };
        let is_last = k + 1 == spectra.len();
        Panel::Chart(Chart {
            title: spectrum.signal.word(*motion).to_owned(),
            x: Axis::decades(
                if is_last { "frequency in Hz" } else { "" },
                spectrum.density.iter().map(|p| p[0]),
            ),
            y: Axis::decades(format!("{}/√Hz", scale.unit), all.iter().map(|x| scale.to(*x))),
            marks: vec![Mark::line(Ink::Before, curve(1)), Mark::line(Ink::After, curve(2))],
            height: 105.0,
            has_x_labels: is_last,
        })
    });
    let caption = "Spectral density of what the twin misses on unseen runs.";
    Figure::new("spectrum", caption, panels.collect())
        .legend([(Ink::Before, baseline), (Ink::After, "with the causes")])
}

/// Angles moved by whole turns to where those of another curve are, on average over what both have.
fn beside(mut points: Vec<[f64; 2]>, other: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let both = points.iter().zip(other).map(|(a, b)| a[1] - b[1]).filter(|angle| angle.is_finite());
    let apart: Vec<f64> = both.collect();
    // Without common points, the angles themselves are kept near zero.
    let middle = |list: &[f64]| list.iter().sum::<f64>() / list.len().max(1) as f64;
    let off = if apart.is_empty() {
        let mean = |curve: &[[f64; 2]]| {
            middle(&curve.iter().map(|p| p[1]).filter(|angle| angle.is_finite()).collect::<Vec<f64>>())
        };
        mean(&points) - mean(other)
    } else {
        middle(&apart)
    };
    let turns = 360.0 * (off / 360.0).round();
    points.iter_mut().for_each(|point| point[1] -= turns);
    points
}

/// Bands where points stand together that are coherent; a gap between them is no band.
fn ribbons(points: &[Point], band: &[[f64; 3]]) -> Vec<Mark> {
    let mut marks: Vec<Mark> = Vec::new();
    let mut run: Vec<[f64; 3]> = Vec::new();
    let mut end = |run: &mut Vec<[f64; 3]>| {
        if run.len() > 1 {
            marks.push(Mark::Ribbon { ink: Ink::Measured, points: run.clone() });
        }
        run.clear();
    };
    for (point, edges) in points.iter().zip(band) {
        if point.coherence >= COHERENT {
            run.push(*edges);
        } else {
            end(&mut run);
        }
    }
    end(&mut run);
    marks
}

/// What the figure shows, and how far it can be trusted.
fn caption(response: &Response, words: &str) -> String {
    let Response { before, run, highest_hz, .. } = response;
    let beyond = match before.is_empty() {
        true => "; at high frequency the controller answers the sensor's noise, and that is coherent too"
            .to_owned(),
        false => format!("; beyond {highest_hz:.0} Hz noise outweighs the motion"),
    };
    format!(
        "Frequency response, {words}, run {run}, in closed loop, with its 95 % band, where the coherence is above \
         {COHERENT}{beyond}."
    )
}

/// Magnitude in dB and phase in degrees with their bands, and coherence.
pub(super) fn figure(response: &Response, motion: Motion, baseline: &str) -> Figure {
    let Response { input, output, measured, before, after, .. } = response;
    // Where its input holds nothing, a response is noise over nothing.
    let sure = |p: &Point, value: f64| if p.coherence >= COHERENT { value } else { f64::NAN };
    let magnitude = |points: &[Point]| -> Vec<[f64; 2]> {
        points.iter().map(|p| [p.frequency_hz, sure(p, decibels(p.response().norm()))]).collect()
    };
    let phase = |points: &[Point]| -> Vec<[f64; 2]> {
        unwrapped(points.iter().map(|p| [p.frequency_hz, sure(p, p.response().arg().to_degrees())]).collect())
    };
    // Each begins at some turn: all are drawn on the one nearest to the machine's.
    let own = phase(measured);
    let phase = |points: &[Point]| beside(phase(points), &own);
    let heights = |of: &dyn Fn(&[Point]) -> Vec<[f64; 2]>| -> Vec<f64> {
        [&measured[..], before, after].into_iter().flat_map(of).map(|p| p[1]).collect()
    };
    let frequencies: Vec<f64> = measured.iter().map(|p| p.frequency_hz).collect();
    let across = |label: &str| Axis::decades(label, frequencies.iter().copied());
    let unit = decibel_unit(&format!("{}/{}", output.si_unit(motion), input.si_unit(motion)));
    let three = |of: &dyn Fn(&[Point]) -> Vec<[f64; 2]>, band: Vec<[f64; 3]>| {
        let mut marks = ribbons(measured, &band);
        marks.push(Mark::line(Ink::Before, of(before)));
        marks.push(Mark::line(Ink::After, of(after)));
        marks.push(Mark::Dots { ink: Ink::Measured, points: of(measured) });
        marks
    };
    let magnitude_bands = measured.iter().map(magnitude_band).collect();
    let around = |([f, angle], p): (&[f64; 2], &Point)| {
        let half = p.phase_half_width_deg();
        [*f, angle - half, angle + half]
    };
    let phase_bands = own.iter().zip(measured).map(around).collect();
    let chart = |title: &str, x: Axis, y: Axis, marks: Vec<Mark>, height: f64| {
        let has_x_labels = !x.label.is_empty();
        Panel::Chart(Chart { title: title.to_owned(), x, y, marks, height, has_x_labels })
    };
    let words = format!("{} from {}", output.word(motion), input.word(motion));
    let coherence = measured.iter().map(|p| [p.frequency_hz, p.coherence]).collect::<Vec<_>>();
    let (levels, angles) = (Axis::holding(unit, heights(&magnitude)), Axis::holding("°", heights(&phase)));
    let panels = vec![
        chart("magnitude", across(""), levels, three(&magnitude, magnitude_bands), 170.0),
        chart("phase", across(""), angles, three(&phase, phase_bands), 120.0),
        chart(
            "coherence of the recording",
            across("frequency in Hz"),
            Axis::linear("γ²", [0.0, 1.05]),
            vec![Mark::line(Ink::Measured, coherence)],
            80.0,
        ),
    ];
    let caption = caption(response, &words);
    let legend = if before.is_empty() {
        vec![(Ink::Measured, "recorded, 95 % band")]
    } else {
        vec![(Ink::Measured, "machine, 95 % band"), (Ink::Before, baseline), (Ink::After, "with the causes")]
    };
    let mut figure = Figure::new("response", caption, panels);
    figure.legend = legend.into_iter().map(|(ink, word)| (ink, word.to_owned())).collect();
    figure
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_gap_in_the_coherence_is_no_band() {
        let point = |coherence: f64| Point {
            frequency_hz: 1.0,
            re: 1.0,
            im: 0.0,
            coherence,
            relative_sd: 0.1,
            quantile: 2.0,
        };
        let points = [0.9, 0.9, 0.1, 0.9, 0.2, 0.8, 0.7].map(point);
        let found = ribbons(&points, &[[1.0, 0.0, 2.0]; 7]);
        let counts: Vec<usize> = found
            .iter()
            .map(|m| if let Mark::Ribbon { points, .. } = m { points.len() } else { 0 })
            .collect();
        assert_eq!(counts, [2, 2]);
        // 1 ± 0.2 in dB.
        let [_, low, high] = magnitude_band(&points[0]);
        assert!(
            (low - 20.0 * 0.8_f64.log10()).abs() < 1e-12 && (high - 20.0 * 1.2_f64.log10()).abs() < 1e-12
        );
    }
}
