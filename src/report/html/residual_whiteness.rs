//! Whiteness of the residuals: autocorrelation with its 95 % band, and the test.

use super::page::Part;
use crate::diagnose::Diagnosis;
use crate::diagnose::residual_whiteness::ResidualWhiteness;
use crate::report::figure::{Axis, Chart, Figure, Ink, Mark, Panel};
use crate::report::words::name;

/// The section; empty where nothing was compared.
pub(super) fn part(diagnosis: &Diagnosis) -> Part {
    let mut part = Part::default();
    let list = &diagnosis.residual_whiteness;
    let Some(first) = list.first() else { return part };
    part.remark(
        "Autocorrelation of recorded less predicted, twin with the causes, unseen runs, and the Ljung–Box test. Noise of the \
         position sensor that the controller answers is coloured in effort, current and force, and alternates in a velocity \
         formed by differences: these can fail the test without any law missing. Slow decay over many lags is a missing law, a \
         lasting oscillation a missing mode.",
    );
    part.table(
        &["signal", ">Q", ">expected if white", ">p", "white at 5 %", ">largest", ">at lag"],
        &list.iter().map(row).collect::<Vec<_>>(),
    );
    let lags = first.whiteness.degrees_of_freedom;
    let panels = list.iter().enumerate().map(|(k, of)| Panel::Chart(chart(of, k + 1 == list.len())));
    let caption = format!(
        "Autocorrelation of the residuals over {lags} lags; white within the band in 95 % of the lags."
    );
    let figure = Figure::new("whiteness", caption, panels.collect())
        .legend([(Ink::After, "autocorrelation"), (Ink::Noise, "95 % band of white noise")]);
    part.figure(figure);
    part
}

fn row(of: &ResidualWhiteness) -> Vec<String> {
    let test = &of.whiteness;
    let largest = test.autocorrelation.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let (lag, r) = largest.map_or((0, 0.0), |(k, r)| (k + 1, *r));
    vec![
        name(&of.signal),
        if test.statistic < 1000.0 {
            format!("{:.0}", test.statistic)
        } else {
            format!("{:.2e}", test.statistic)
        },
        test.degrees_of_freedom.to_string(),
        if test.p_value < 1e-4 { "< 0.0001".to_owned() } else { format!("{:.4}", test.p_value) },
        if test.is_white() { "yes" } else { "no" }.to_owned(),
        format!("{r:+.2}").replace('-', "−"),
        format!("{:.4} ms", 1e3 * of.lag_s * lag as f64).replace(".0000 ms", " ms"),
    ]
}

fn chart(of: &ResidualWhiteness, is_last: bool) -> Chart {
    let test = &of.whiteness;
    let points: Vec<[f64; 2]> =
        test.autocorrelation.iter().enumerate().map(|(k, r)| [1e3 * of.lag_s * (k + 1) as f64, *r]).collect();
    let end = points.last().map_or(1.0, |point| point[0]);
    let bound = test.bound.min(1.0);
    let heights = points.iter().map(|point| point[1]).chain([0.2, -0.2, bound, -bound]);
    Chart {
        title: format!("{}: {}", name(&of.signal), if test.is_white() { "white" } else { "not white" }),
        x: Axis::linear(if is_last { "lag in ms" } else { "" }, [0.0, end]),
        y: Axis::holding("r", heights),
        marks: vec![
            Mark::Band { ink: Ink::Noise, range: [-bound, bound] },
            Mark::line(Ink::After, points.iter().copied()),
            Mark::Dots { ink: Ink::After, points },
        ],
        height: 80.0,
        has_x_labels: is_last,
    }
}
