//! Tuning: what a map says is what a replay says, the published retuning is found worth it and is beaten, wrong questions
//! are refused.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use proptest::prelude::*;
use slideway::error::ErrorKind;
use slideway::machine::Machine;
use slideway::replay::crosscheck::cells_of;
use slideway::replay::{Cell, Figures, Motion, PlantChoice, simulate};
use slideway::report::{Style, html, tuned, tuning_map};
use slideway::tune::{
    Bench, Criterion, Departure, Kind, Knob, Limits, Objective, Outcome, Robustness, Setting, Tuning,
    Written, WrittenLimit,
};
use slideway::twin::Sensing;
use std::path::Path;
use std::sync::OnceLock;

const REGISTERS: [&str; 2] = ["controller.integral", "controller.proportional"];

fn model(name: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(name)).unwrap()
}

fn registers(machine: &Machine, ranges: [[f64; 2]; 2], steps: [f64; 2]) -> Vec<Knob> {
    let knob = |k: usize| Knob::new(machine, REGISTERS[k], ranges[k], Some(steps[k])).unwrap();
    vec![knob(0), knob(1)]
}

fn tuning(machine: &Machine, knobs: Vec<Knob>, cells: Vec<Cell>) -> Tuning {
    Tuning {
        knobs,
        cells,
        dwell_s: 0.6,
        limits: Limits::usual(machine),
        objective: Objective::SettlingTime,
        marks: vec![vec![22.0, 220.0]],
        friction: 30.0,
    }
}

/// Both registers around the published ones, over all eight published strokes.
fn published() -> &'static (Machine, Tuning, Outcome) {
    static FOUND: OnceLock<(Machine, Tuning, Outcome)> = OnceLock::new();
    FOUND.get_or_init(|| {
        let machine = model("grinder");
        let knobs = registers(&machine, [[13.0, 33.0], [140.0, 300.0]], [2.0, 20.0]);
        let tuning = tuning(&machine, knobs, cells_of(&machine).unwrap());
        let outcome = tuning.run(&machine, |_| ()).unwrap();
        (machine, tuning, outcome)
    })
}

fn of(setting: &Setting, criterion: Criterion) -> f64 {
    setting.worst()[criterion as usize]
}

#[test]
fn exact_map_says_what_a_replay_says() {
    let machine = model("grinder");
    let period_s = machine.description().sample_period_s;
    let cells: Vec<Cell> = vec!["0.02@8".parse().unwrap(), "-0.03@16".parse().unwrap()];
    let knobs = registers(&machine, [[6.0, 65.0], [100.0, 395.0]], [1.0, 5.0]);
    let bench = Bench::new(&machine, &knobs, &cells, 0.6).unwrap();
    let settings = [[19.0, 260.0], [22.0, 220.0], [40.0, 300.0], [10.0, 150.0], [30.0, 110.0]];
    let measured = bench.measure(&settings.map(Vec::from), &|_| ()).unwrap();
    for setting in &measured {
        let pairs = knobs.iter().zip(&setting.values).map(|(k, v)| (k.key.as_str(), k.value(*v)));
        let set = machine.with_settings(pairs).unwrap();
        for (cell, found) in cells.iter().zip(&setting.strokes) {
            let strokes = vec![cell.stroke(machine.motion()).unwrap()];
            let motion = Motion { strokes, lead_s: 0.0, dwell_s: 0.6, ramp_s: 0.02 };
            let reference: Vec<f64> = [0.0].into_iter().chain(motion.reference(period_s)).collect();
            let mut traces = simulate(&set, PlantChoice::Axis, Sensing::Perfect, &reference, |_| ()).unwrap();
            traces.forget(1);
            let figures = Figures::of(&motion, period_s, &traces);
            assert_eq!(found[0], figures.overshoot, "{cell} {:?}", setting.values);
            assert_eq!(found[1], figures.peak_velocity.max(0.0));
            assert_eq!(found[3], figures.settling_s.unwrap_or(f64::INFINITY));
            assert_eq!(found[5], figures.peak_thrust);
            assert_eq!(found[6], figures.peak_effort_v);
        }
    }
}

/// The paper: 19/260 overshoots in position and velocity and runs back, 22/220 does none of it.
#[test]
fn ref_published_retuning_keeps_what_the_published_setting_breaks() {
    let (_, tuning, outcome) = published();
    let (own, mark) = (&outcome.own, &outcome.marks[0]);
    assert_eq!(own.values, [19.0, 260.0]);
    for criterion in [Criterion::PositionOvershoot, Criterion::VelocityOvershoot, Criterion::ReverseVelocity]
    {
        assert!(tuning.limits.excess(criterion, of(own, criterion)) > 0.0, "{criterion:?}");
        assert!(tuning.limits.excess(criterion, of(mark, criterion)) == 0.0, "{criterion:?}");
    }
    // 0.02@8 is the seventh cell: physics sheet 1.3.
    assert!((100.0 * own.strokes[6][0] - 4.09).abs() < 0.02, "{:?}", own.strokes[6]);
    assert!((100.0 * own.strokes[6][2] - 3.15).abs() < 0.02, "{:?}", own.strokes[6]);
}

#[test]
fn ref_a_setting_at_least_as_good_as_the_published_retuning_is_found() {
    let (_, tuning, outcome) = published();
    let (chosen, mark) = (&outcome.chosen, &outcome.marks[0]);
    assert_eq!(chosen.excess(&tuning.limits), 0.0, "{chosen:?}");
    assert_eq!(outcome.beats, [true]);
    assert!(chosen.values.iter().all(|value| value.fract() == 0.0));
    for (mine, theirs) in chosen.strokes.iter().zip(&mark.strokes) {
        assert!(mine[3] <= theirs[3] + 4e-4, "settling {mine:?} against {theirs:?}");
        assert!(mine[4] <= theirs[4] * 1.000_001, "following error {mine:?} against {theirs:?}");
    }
    assert!(chosen.mean(Criterion::SettlingTime) <= mark.mean(Criterion::SettlingTime) + 4e-4);
}

#[test]
fn exact_re_check_covers_mass_friction_and_base() {
    let (_, tuning, outcome) = published();
    let rows = &outcome.robustness.rows;
    for kind in Kind::ALL {
        assert_eq!(rows.iter().filter(|(departure, _)| departure.kind() == kind).count(), 4, "{kind:?}");
    }
    // Without friction, mass or base off it does what the choice did.
    let undisturbed = rows.iter().find(|(d, _)| *d == Departure::Friction(0.0)).unwrap();
    assert_eq!(undisturbed.1[0].strokes, outcome.chosen.strokes);
    assert_eq!(undisturbed.1[1].strokes, outcome.marks[0].strokes);
    // More mass asks for more thrust, at the same gains for about as much more as there is mass to accelerate.
    let thrust = |departure| {
        let row = rows.iter().find(|(d, _)| *d == departure).unwrap();
        of(&row.1[0], Criterion::PeakThrust)
    };
    assert!(thrust(Departure::Mass(0.2)) > 1.02 * thrust(Departure::Mass(-0.2)));
    // What gives first is a limit that is kept on the stated machine.
    for kind in Kind::ALL {
        for given in outcome.robustness.gives_first(&tuning.limits, &outcome.chosen, kind) {
            let row = rows.iter().find(|(d, _)| *d == given.departure).unwrap();
            for criterion in given.criteria {
                assert!(tuning.limits.excess(criterion, of(&row.1[0], criterion)) > 0.0);
                assert_eq!(tuning.limits.excess(criterion, of(&outcome.chosen, criterion)), 0.0);
            }
        }
    }
}

/// No setting of the map that settles sooner, and is as good as the mark, keeps more on the other machines.
#[test]
fn exact_choice_is_the_sturdiest_of_those_that_settle_as_soon() {
    let (machine, tuning, outcome) = published();
    let (limits, chosen) = (&tuning.limits, &outcome.chosen);
    let period_s = machine.description().sample_period_s;
    let settling = |setting: &Setting| setting.mean(Criterion::SettlingTime);
    let is_rival = |setting: &&Setting| {
        setting.excess(limits) == 0.0
            && setting.is_at_least_as_good_as(&outcome.marks[0], limits, period_s)
            && settling(setting) <= settling(chosen)
    };
    let rivals: Vec<Vec<f64>> =
        outcome.map.settings.iter().filter(is_rival).map(|setting| setting.values.clone()).collect();
    assert!(!rivals.is_empty());
    let checked = Robustness::of(machine, tuning, &rivals, &|_| ()).unwrap();
    let own = outcome.robustness.excess(0, limits);
    for (k, rival) in rivals.iter().enumerate() {
        assert!(own <= checked.excess(k, limits) + 1e-9, "{:?} against {rival:?}", chosen.values);
    }
}

#[test]
fn exact_report_names_the_choice_and_draws_the_map() {
    let (machine, tuning, outcome) = published();
    let sheet = tuned(machine, tuning, outcome);
    let text = sheet.text(Style { colour: false, width: 130 });
    let [integral, proportional] = [outcome.chosen.values[0], outcome.chosen.values[1]];
    assert!(text.contains(&format!("controller.integral = {integral}")), "{text}");
    assert!(
        text.contains("marked 22/220") && text.contains("On every stroke at least as good as 22/220"),
        "{text}"
    );
    let map = tuning_map(machine, tuning, outcome);
    let lines: Vec<&str> = map.lines().collect();
    assert_eq!(lines.len(), 1 + outcome.map.settings.len());
    assert!(lines[0].starts_with("controller.integral,controller.proportional,position_overshoot_percent,"));
    let row = lines.iter().find(|line| line.starts_with("19,260,")).unwrap();
    let overshoot: f64 = row.split(',').nth(2).unwrap().parse().unwrap();
    assert!(
        (overshoot - 100.0 * outcome.own.worst()[0]).abs() < 1e-9 && row.ends_with("true,false"),
        "{row}"
    );
    let page = html::sheet(&sheet, "slideway tune");
    assert_eq!(page.figures.len(), 1);
    let svg = page.figures[0].file();
    for word in ["stated 19/260", "22/220", &format!("chosen {integral}/{proportional}")] {
        assert!(svg.contains(word), "{word}");
    }
}

#[test]
fn exact_machine_with_friction_is_tuned_with_it() {
    let machine = model("grinder").with_settings([("effect.coulomb_friction.force_n", 15.0.into())]).unwrap();
    let cells = vec!["0.02@8".parse().unwrap()];
    let knobs = registers(&machine, [[19.0, 22.0], [220.0, 260.0]], [3.0, 40.0]);
    let with =
        Bench::new(&machine, &knobs, &cells, 0.6).unwrap().measure(&[vec![19.0, 260.0]], &|_| ()).unwrap();
    let plain = model("grinder");
    let without =
        Bench::new(&plain, &knobs, &cells, 0.6).unwrap().measure(&[vec![19.0, 260.0]], &|_| ()).unwrap();
    assert!(of(&with[0], Criterion::PeakThrust) > of(&without[0], Criterion::PeakThrust) + 5.0);
    // Margins are those of the linear loop.
    assert_eq!(with[0].margins, without[0].margins);
}

/// A revolute axis and a cascade with real gains are tuned by the same code.
#[test]
fn exact_cascade_of_a_turning_axis_is_tuned() {
    let machine = model("delta_a3");
    let knobs = Knob::usual(&machine).unwrap();
    assert!(knobs.iter().all(|knob| !knob.is_integer) && knobs.len() == 2, "{knobs:?}");
    let knobs = knobs.into_iter().map(|knob| Knob { step: 0.25 * (knob.to - knob.from), ..knob }).collect();
    let mut tuning = tuning(&machine, knobs, vec!["1.0@5".parse().unwrap()]);
    tuning.marks.clear();
    tuning.friction = 0.02;
    let outcome = tuning.run(&machine, |_| ()).unwrap();
    assert!(outcome.map.settings.len() == 25);
    assert!(outcome.chosen.is_stable && outcome.chosen.values.iter().all(|value| value.is_finite()));
}

#[test]
fn exact_unstable_settings_are_never_chosen() {
    let machine = model("grinder");
    let knobs = registers(&machine, [[19.0, 30_000.0], [260.0, 30_000.0]], [29_981.0, 29_740.0]);
    let mut tuning = tuning(&machine, knobs, vec!["0.02@8".parse().unwrap()]);
    tuning.marks.clear();
    let outcome = tuning.run(&machine, |_| ()).unwrap();
    let unstable: Vec<_> = outcome.map.settings.iter().filter(|setting| !setting.is_stable).collect();
    assert!(!unstable.is_empty(), "{:?}", outcome.map.settings);
    assert!(unstable.iter().all(|setting| setting.excess(&tuning.limits).is_infinite()));
    assert!(outcome.chosen.is_stable);
}

/// Margins come before strokes: a loop at the edge of stability is never sold for less overshoot.
#[test]
fn exact_margins_come_before_strokes() {
    let machine = model("delta_a3");
    let knobs = Knob::usual(&machine).unwrap();
    let knobs = knobs.into_iter().map(|knob| Knob { step: 0.1 * (knob.to - knob.from), ..knob }).collect();
    let mut tuning = tuning(&machine, knobs, vec!["1.0@5".parse().unwrap()]);
    tuning.marks.clear();
    tuning.friction = 0.0;
    let outcome = tuning.run(&machine, |_| ()).unwrap();
    let short = |setting: &Setting| setting.excess_of_margins(&tuning.limits);
    let least = outcome.map.settings.iter().map(short).fold(f64::INFINITY, f64::min);
    assert!(short(&outcome.chosen) <= least, "{:?}", outcome.chosen.margins);
}

/// A setting that never arrives keeps no limits.
#[test]
fn exact_stroke_that_does_not_settle_is_an_excess() {
    let machine = model("grinder");
    let cells: Vec<Cell> = vec!["0.02@8".parse().unwrap()];
    let knobs = registers(&machine, [[0.0, 19.0], [220.0, 260.0]], [19.0, 40.0]);
    let bench = Bench::new(&machine, &knobs, &cells, 0.6).unwrap();
    let measured = bench.measure(&[vec![0.0, 260.0], vec![22.0, 220.0]], &|_| ()).unwrap();
    let limits = Limits::usual(&machine);
    assert!(
        measured[0].strokes[0][3].is_infinite() && measured[0].excess(&limits) >= 1.0,
        "{:?}",
        measured[0]
    );
    assert_eq!(measured[1].excess(&limits), 0.0);
}

/// Positive feedback runs away, whatever the margins of its response look like.
#[test]
fn exact_too_much_integral_feedback_is_unstable() {
    let machine = model("grinder");
    let cells: Vec<Cell> = vec!["0.02@8".parse().unwrap()];
    let knobs = registers(&machine, [[19.0, 400.0], [5.0, 260.0]], [1.0, 5.0]);
    let bench = Bench::new(&machine, &knobs, &cells, 0.6).unwrap();
    let measured = bench.measure(&[vec![200.0, 260.0], vec![400.0, 260.0]], &|_| ()).unwrap();
    assert!(measured.iter().all(|setting| !setting.is_stable), "{measured:?}");
}

#[test]
fn exact_wrong_questions_are_refused() {
    let machine = model("grinder");
    let refused = |key: &str, range: [f64; 2], step| Knob::new(&machine, key, range, step).unwrap_err();
    for (key, range, step) in [
        ("controller.integrl", [1.0, 5.0], None),
        ("motor.resistance_ohm", [1.0, 5.0], None),
        ("controller.law", [1.0, 5.0], None),
        ("controller.integral", [5.0, 5.0], None),
        ("controller.integral", [1.0, 5.0], Some(0.0)),
        ("controller.integral", [1.5, 5.0], None),
        ("controller.integral", [1.0, f64::NAN], None),
    ] {
        let error = refused(key, range, step);
        assert_eq!(error.key_name(), Some(key), "{error}");
        assert!(error.remedy_text().is_some(), "{error}");
    }
    let knobs = registers(&machine, [[19.0, 22.0], [220.0, 260.0]], [3.0, 40.0]);
    let cells: Vec<Cell> = vec!["0.02@8".parse().unwrap()];
    let mut wrong = tuning(&machine, knobs.clone(), cells.clone());
    wrong.marks = vec![vec![22.0]];
    assert_eq!(wrong.run(&machine, |_| ()).unwrap_err().key_name(), Some("--mark"));
    for mark in [[22.5, 220.0], [1e300, 220.0], [22.0, f64::NAN]] {
        wrong.marks = vec![mark.to_vec()];
        assert_eq!(wrong.run(&machine, |_| ()).unwrap_err().kind(), ErrorKind::OutOfRange, "{mark:?}");
    }
    for cell in ["9@8", "1e300@8", "0.02@1e-9"] {
        let run = |cell| tuning(&machine, knobs.clone(), vec![cell]).run(&machine, |_| ()).map(drop);
        assert_eq!(cell.parse().and_then(run).unwrap_err().kind(), ErrorKind::OutOfRange, "{cell}");
    }
    let twice = tuning(&machine, vec![knobs[0].clone(), knobs[0].clone()], cells.clone());
    let twice = Tuning { marks: vec![], ..twice }.run(&machine, |_| ()).unwrap_err();
    assert_eq!(twice.key_name(), Some("controller.integral"));
    let none = tuning(&machine, knobs, Vec::new());
    assert_eq!(none.run(&machine, |_| ()).unwrap_err().key_name(), Some("tune"));
    let mut limits = Limits::usual(&machine);
    assert_eq!(limits.set(machine.motion(), "overshoot", 1.0).unwrap_err().kind(), ErrorKind::UnknownKey);
    assert!(limits.set(machine.motion(), "peak_effort_v", -1.0).is_err());
    for text in ["controller.integral", "a=1", "a=1..x", "a=1..2:y", "=1..2:", "a=1.."] {
        assert!(text.parse::<Written>().is_err(), "{text}");
    }
    assert!("peak_effort_v".parse::<WrittenLimit>().is_err());
}

proptest! {
    /// A bound that a value keeps costs nothing; beyond it, farther costs more.
    #[test]
    fn exact_excess_grows_beyond_the_bound(bound in 1e-3..1e3f64, inside in 0.0..1.0f64, a in 1.0..5.0f64, b in 0.01..5.0f64) {
        let machine = model("emps");
        let mut limits = Limits::usual(&machine);
        limits.set(machine.motion(), "peak_thrust_n", bound).unwrap();
        limits.set(machine.motion(), "gain_margin_db", bound).unwrap();
        let upper = |x: f64| limits.excess(Criterion::PeakThrust, x);
        let lower = |x: f64| limits.excess(Criterion::GainMargin, x);
        prop_assert_eq!(upper(inside * bound), 0.0);
        prop_assert_eq!(lower(bound / inside.max(1e-3)), 0.0);
        prop_assert!(upper((a + b) * bound) > upper(a * bound));
        prop_assert!(lower(bound / (a + b)) >= lower(bound / a));
    }
}
