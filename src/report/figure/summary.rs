//! One picture of a diagnosis, as SVG: the signal path with each site's share, and every signal before and after.

use crate::diagnose::Diagnosis;
use crate::diagnose::verdict::{Share, SignalGap};
use crate::effect::Site;
use crate::recording::Signal;
use crate::report::wrap::wrap;
use crate::units::{Motion, engineering};
use std::fmt::Write as _;

const WIDTH: f64 = 900.0;
const MARGIN: f64 = 24.0;
const INK: &str = "#222222";
const PALE: &str = "#767676";
/// Blue, orange and grey of Okabe and Ito's palette: told apart with any colour vision, and in print.
const BEFORE: &str = "#d55e00";
const AFTER: &str = "#0072b2";
const NOISE: &str = "#999999";

/// The picture of a diagnosis; `sentence` stands on top, the recording's own note below.
///
/// White ground, no scripts, no external address; numbers in it are those of the diagnosis.
pub fn svg(diagnosis: &Diagnosis, sentence: &str) -> String {
    let lines = wrap(sentence, 100);
    let note = wrap(diagnosis.data.note.as_deref().unwrap_or_default(), 130);
    let path_top = 40.0 + 18.0 * lines.len() as f64;
    let bars_top = path_top + 120.0;
    let bars_height = 44.0 * diagnosis.gap.signals.len() as f64;
    let height = bars_top + bars_height + 60.0 + 14.0 * note.len() as f64;
    let mut out = String::new();
    let _ = write!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" \
         font-family=\"Helvetica, Arial, sans-serif\" role=\"img\">\n\
         <rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
    );
    for (k, line) in lines.iter().enumerate() {
        text(&mut out, MARGIN, 32.0 + 18.0 * k as f64, 15.0, INK, "start", line);
    }
    sites(&mut out, &diagnosis.place.site, path_top);
    signals(&mut out, &diagnosis.gap.signals, bars_top);
    for (k, line) in note.iter().enumerate() {
        text(&mut out, MARGIN, bars_top + bars_height + 48.0 + 14.0 * k as f64, 11.0, PALE, "start", line);
    }
    out.push_str("</svg>\n");
    out
}

fn text(out: &mut String, x: f64, y: f64, size: f64, colour: &str, anchor: &str, words: &str) {
    let words = words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let _ = writeln!(
        out,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" fill=\"{colour}\" text-anchor=\"{anchor}\">{words}</text>"
    );
}

/// The signal path as boxes in hardware order, filled by share.
fn sites(out: &mut String, shares: &[Share], top: f64) {
    let count = Site::ALL.len() as f64;
    let gap = 22.0;
    let width = (WIDTH - 2.0 * MARGIN - gap * (count - 1.0)) / count;
    for (k, site) in Site::ALL.into_iter().enumerate() {
        let x = MARGIN + k as f64 * (width + gap);
        let share = shares.iter().find(|s| s.name == site.name()).map(|s| s.share.clamp(0.0, 1.0));
        let filled = 52.0 * share.unwrap_or(0.0);
        let _ = writeln!(
            out,
            "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{width:.1}\" height=\"{filled:.1}\" fill=\"{BEFORE}\" fill-opacity=\"0.35\"/>\
             <rect x=\"{x:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"52\" fill=\"none\" stroke=\"{INK}\"/>",
            top + 52.0 - filled
        );
        text(out, x + 0.5 * width, top + 22.0, 14.0, INK, "middle", site.name());
        text(
            out,
            x + 0.5 * width,
            top + 42.0,
            13.0,
            INK,
            "middle",
            &share.map_or_else(|| "–".to_owned(), |share| format!("{:.0} %", 100.0 * share)),
        );
        if k > 0 {
            let _ = writeln!(
                out,
                "<path d=\"M{:.1} {:.1} h{:.1} m-6 -4 l6 4 l-6 4\" fill=\"none\" stroke=\"{INK}\"/>",
                x - gap + 3.0,
                top + 26.0,
                gap - 6.0
            );
        }
    }
    text(out, MARGIN, top + 74.0, 12.0, PALE, "start", "share of the gap by place on the signal path");
}

/// Residual of every signal before and after, and its noise, as bars on one logarithmic scale of ratios to noise.
fn signals(out: &mut String, signals: &[SignalGap], top: f64) {
    let ratio = |value: f64, noise: f64| (value / noise.max(f64::MIN_POSITIVE)).max(1.0);
    let most = signals.iter().map(|s| ratio(s.rms_before, s.noise)).fold(10.0, f64::max).log10().ceil();
    let (left, right) = (MARGIN + 170.0, WIDTH - MARGIN - 150.0);
    let place = |value: f64| left + (right - left) * value.log10() / most;
    let height = 44.0 * signals.len() as f64;
    for decade in 0..=most as i32 {
        let x = place(10f64.powi(decade));
        let _ = writeln!(out, "<path d=\"M{x:.1} {top:.1} v{height:.1}\" stroke=\"#dddddd\"/>");
        text(out, x, top + height + 14.0, 11.0, PALE, "middle", &format!("{}×", 10f64.powi(decade)));
    }
    for (k, signal) in signals.iter().enumerate() {
        let y = top + 44.0 * k as f64;
        let (word, unit) = named(&signal.signal);
        text(out, MARGIN, y + 24.0, 13.0, INK, "start", &word);
        let bars = [(signal.rms_before, BEFORE, 6.0), (signal.rms_after, AFTER, 22.0)];
        for (value, colour, down) in bars {
            let end = place(ratio(value, signal.noise)).max(left + 2.0);
            let _ = writeln!(
                out,
                "<rect x=\"{left:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"13\" fill=\"{colour}\"/>",
                y + down,
                end - left
            );
            text(out, end + 5.0, y + down + 11.0, 11.0, INK, "start", &engineering(value, unit));
        }
    }
    let _ =
        writeln!(out, "<path d=\"M{left:.1} {top:.1} v{height:.1}\" stroke=\"{NOISE}\" stroke-width=\"2\"/>");
    let legend = "RMS of recorded less predicted on unseen runs, as a multiple of the signal's noise";
    text(out, MARGIN, top - 8.0, 12.0, PALE, "start", legend);
    text(out, WIDTH - MARGIN - 120.0, top - 8.0, 12.0, BEFORE, "start", "before");
    text(out, WIDTH - MARGIN - 60.0, top - 8.0, 12.0, AFTER, "start", "after");
}

/// A signal's word and SI unit from its canonical name.
fn named(key: &str) -> (String, &'static str) {
    match Signal::from_key(key) {
        Some((signal, motion)) => {
            let motion = motion.unwrap_or(Motion::Prismatic);
            (signal.word(motion).to_string(), signal.si_unit(motion))
        }
        None => (key.to_string(), ""),
    }
}
