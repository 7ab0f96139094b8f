//! Which stretches of the runs were used for what.

use crate::diagnose::verdict::Data;
use crate::recording::Cut;

/// Times that are listed before the rest is only counted.
const TIMES: usize = 8;

/// Sentences about a run that was cut, and about samples that were left aside.
pub(super) fn sentences(data: &Data) -> Vec<String> {
    let samples = &data.samples;
    let left_aside = samples.used < samples.recorded;
    let used = left_aside.then(|| {
        format!(
            "{} of {} samples were used, in {} stretches that hold most of the motion; --most-samples N takes more.",
            thousands(samples.used),
            thousands(samples.recorded),
            samples.stretches
        )
    });
    data.cut.as_ref().map(cut).into_iter().chain(used).collect()
}

/// A sentence on how a single run was cut.
pub fn cut(cut: &Cut) -> String {
    let times = listed(cut.at_s.iter().map(|at| seconds(*at)).collect());
    let spans = cut.held_out_s.iter().map(|[from, to]| format!("{} to {} s", seconds(*from), seconds(*to)));
    let spans = listed(spans.collect());
    let run = &cut.run;
    let mut text = match cut.in_motion {
        false => format!("Run `{run}` was cut at standstills, at {times} s; held out: {spans}."),
        true => format!(
            "Run `{run}` stands nowhere for long and was cut in motion, at {times} s; held out: {spans}. Its replay begins in the \
             measured state: what friction and base remember from before is not known."
        ),
    };
    for way in &cut.one_sided {
        text += &format!(" Only one side moves {way}: record that way twice, with a standstill between.");
    }
    text
}

/// Up to a millisecond, without zeros at the end.
pub(super) fn seconds(time_s: f64) -> String {
    let text = format!("{time_s:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn listed(all: Vec<String>) -> String {
    match all.len() {
        some if some <= TIMES => all.join(", "),
        some => format!("{} and {} more", all[..TIMES].join(", "), some - TIMES),
    }
}

/// 1234567 as 1 234 567.
fn thousands(count: usize) -> String {
    let digits = count.to_string();
    let grouped = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy);
    grouped.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_numbers_are_written_to_be_read() {
        assert_eq!([thousands(7), thousands(40_000), thousands(1_234_567)], ["7", "40 000", "1 234 567"]);
        assert_eq!([seconds(3.2), seconds(10.0), seconds(0.1234)], ["3.2", "10", "0.123"]);
    }

    #[test]
    fn exact_a_cut_is_told_with_what_is_held_out() {
        let told = Cut {
            run: "x".to_owned(),
            at_s: vec![3.2, 6.4],
            held_out_s: vec![[3.2, 6.4]],
            in_motion: false,
            one_sided: vec![],
        };
        assert_eq!(cut(&told), "Run `x` was cut at standstills, at 3.2, 6.4 s; held out: 3.2 to 6.4 s.");
        let text = cut(&Cut { in_motion: true, one_sided: vec!["backward".to_owned()], ..told });
        assert!(text.contains("stands nowhere") && text.contains("moves backward"), "{text}");
    }
}
