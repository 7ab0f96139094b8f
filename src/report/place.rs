//! WHERE: the gap along the signal path, by phase, frequency, position and speed.

use super::Style;
use super::layout::{Align, INDENT, Table, bar, labelled};
use super::number::{percent, range};
use super::words::baseline;
use super::wrap::columns;
use crate::diagnose::Verdict;
use crate::diagnose::verdict::{Band, Diagnosis, Share};
use crate::effect::Site;
use crate::units::Motion;

/// Columns of a bar that stands for the whole gap.
const BAR: usize = 10;
/// Columns of one site.
const SITE: usize = 10;
/// Entries of a list.
const ENTRIES: usize = 3;
/// Shares below this are left out of a list.
const LEAST_SHARE: f64 = 0.01;

/// The section.
pub(super) fn section(diagnosis: &Diagnosis, motion: Motion, style: Style) -> String {
    if diagnosis.verdict == Verdict::NoGap {
        return String::new();
    }
    let place = &diagnosis.place;
    let remark = format!("shares of the gap of the {}, on the held-out runs", baseline(diagnosis));
    let mut out = style.heading("WHERE", &remark);
    out += &signal_path(&place.site);
    out += &unseparated(&place.site, style);
    out += &segments(&place.segment, style);
    let [position, speed] = match motion {
        Motion::Prismatic => ["m", "m/s"],
        Motion::Revolute => ["rad", "rad/s"],
    };
    out += &side_by_side(
        ("phase of the motion", &top(named(&place.phase))),
        ("frequency", &top(banded(&place.frequency_hz, "Hz"))),
    );
    out += &side_by_side(
        ("position", &top(banded(&place.position, position))),
        ("commanded speed", &top(banded(&place.speed, speed))),
    );
    out
}

/// The sites in hardware order, a bar and a percentage below each.
fn signal_path(shares: &[Share]) -> String {
    if shares.is_empty() {
        return String::new();
    }
    let share = |site: Site| shares.iter().find(|s| s.name == site.name()).map_or(f64::NAN, |s| s.share);
    let line = |cell: &dyn Fn(Site) -> String, between: &str| {
        let cells: Vec<String> = Site::ALL.iter().map(|&site| format!("{:<SITE$}", cell(site))).collect();
        format!("{}\n", format!("{INDENT}{}", cells.join(between)).trim_end())
    };
    let names = line(&|site| site.name().to_owned(), " → ");
    let bars = line(&|site| bar(share(site), SITE), "   ");
    let shares = line(&|site| percent(share(site)), "   ");
    format!("{names}{bars}{shares}")
}

/// What lies somewhere in a block of sites, as no logged signal separates them; empty where there is no block.
pub(super) fn blocks(shares: &[Share]) -> Vec<String> {
    let is_block = |share: &&Share| share.name.contains('+') && share.share >= LEAST_SHARE;
    let sentence = |block: &Share| format!("{} in {}", percent(block.share), block.name.replace('+', " or "));
    shares.iter().filter(is_block).map(sentence).collect()
}

/// The blocks as a line below the path.
fn unseparated(shares: &[Share], style: Style) -> String {
    let blocks = blocks(shares);
    if blocks.is_empty() {
        return String::new();
    }
    let text = format!("{} (no logged signal separates these)", blocks.join(" · "));
    format!("\n{}", labelled("not separated", 22, &text, style))
}

fn segments(shares: &[Share], style: Style) -> String {
    if shares.is_empty() {
        return String::new();
    }
    let list: Vec<String> =
        shares.iter().map(|s| format!("{} {}", s.name.replace('+', " + "), percent(s.share))).collect();
    let text = format!(
        "{} (what a cause closes where it acts; what stays open by the residual of each, replayed alone)",
        list.join(" · ")
    );
    format!("\n{}", labelled("between logged signals", 22, &text, style))
}

/// Label and share.
type Entry = (String, f64);

pub(super) fn named(shares: &[Share]) -> Vec<Entry> {
    shares.iter().map(|s| (s.name.clone(), s.share)).collect()
}

pub(super) fn banded(bands: &[Band], unit: &str) -> Vec<Entry> {
    bands.iter().map(|b| (range(b.from, b.to, unit), b.share)).collect()
}

/// The largest entries, largest first.
pub(super) fn top(mut entries: Vec<Entry>) -> Vec<Entry> {
    entries.retain(|(_, share)| share.is_finite() && *share >= LEAST_SHARE);
    entries.sort_by(|a, b| b.1.total_cmp(&a.1));
    entries.truncate(ENTRIES);
    entries
}

/// Two lists with their heads.
fn side_by_side(left: (&str, &[Entry]), right: (&str, &[Entry])) -> String {
    let block = |(head, entries): (&str, &[Entry])| -> Vec<String> {
        let mut table = Table::new(&[(head, Align::Left), ("", Align::Left), ("", Align::Right)]);
        for (label, share) in entries {
            table.row(vec![label.clone(), format!("{:<BAR$}", bar(*share, BAR)), percent(*share)]);
        }
        let text = table.text(Style { colour: false, width: usize::MAX });
        text.lines().map(|line| line.strip_prefix(INDENT).unwrap_or(line).to_owned()).collect()
    };
    let (left, right) = (block(left), block(right));
    let width = left.iter().map(|line| columns(line)).max().unwrap_or_default().max(35);
    let rows = left.len().max(right.len());
    if rows < 2 {
        return String::new();
    }
    let cell = |lines: &[String], row: usize| lines.get(row).cloned().unwrap_or_default();
    let lines = (0..rows).map(|row| {
        let line = format!("{INDENT}{:<width$}    {}", cell(&left, row), cell(&right, row));
        format!("{}\n", line.trim_end())
    });
    format!("\n{}", lines.collect::<String>())
}
