//! Pitches that are longer than the travel.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use crate::support::strokes::{Cell, Strokes};
use crate::support::told::{model, names, show, with};
use slideway::diagnose::decide::Verdict;
use slideway::diagnose::parameter::Parameter;
use slideway::diagnose::{Options, diagnose};
use slideway::effect::EffectId;
use slideway::recording::Role;

const CELLS: [Cell; 5] = [
    (0.043, 8.0, Role::Training),
    (0.040, 4.0, Role::Training),
    (0.036, 12.0, Role::Training),
    (0.041, 6.0, Role::HeldOut),
    (0.034, 8.0, Role::HeldOut),
];

/// What an offset and a long wave may be taken for.
const RIVALS_OF_AN_OFFSET: [EffectId; 8] = [
    EffectId::AmplifierOffset,
    EffectId::Cogging,
    EffectId::SecondCogging,
    EffectId::ForceConstant,
    EffectId::AsymmetricFriction,
    EffectId::ConstantForce,
    EffectId::CableSpring,
    EffectId::Payload,
];

/// Cogging of a thousandth of the friction, with a pitch of 51 mm on strokes of 34 to 43 mm, beside an offset of the amplifier: what the replays leave tells
/// both, and neither is taken for friction that differs between the directions.
#[test]
fn ref_a_small_wave_longer_than_the_travel_is_found_beside_friction() {
    let friction = [
        ("effect.coulomb_friction.force_n", 28.0),
        ("effect.presliding.stiffness_n_per_m", 2.2e6),
        ("effect.presliding.damping_n_s_per_m", 2000.0),
    ];
    let stated = with(&model("grinder"), &friction);
    let hidden = [
        ("effect.amplifier_offset.offset_v", 1.8e-3),
        ("effect.cogging.period_m", 0.051),
        ("effect.cogging.sine_n", 0.03),
        ("effect.cogging.cosine_n", -0.002),
        ("effect.cogging.cosine_2_n", -0.007),
    ];
    let real = with(&stated, &hidden);
    let recording = Strokes::both_ways(&stated, &real, 3).recording(&CELLS);
    let options = Options { catalogue: &RIVALS_OF_AN_OFFSET, ..Options::default() };
    let d = diagnose(&stated, &recording, &options).unwrap();
    show(&d);
    assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["amplifier_offset", "cogging"]));
    let cogging = d.causes.iter().find(|cause| cause.effect == "cogging").unwrap();
    let period = &cogging.parameters["period_m"];
    assert!(period.ci95[0] <= 0.051 && 0.051 <= period.ci95[1], "{period:?}");
}

/// Strokes of less than half the longer pitch.
const SHORT: [Cell; 4] = [
    (0.021, 6.0, Role::Training),
    (0.018, 9.0, Role::Training),
    (0.020, 5.0, Role::HeldOut),
    (0.017, 8.0, Role::HeldOut),
];

const RIVALS: [EffectId; 11] = [
    EffectId::SecondCogging,
    EffectId::ThirdCogging,
    EffectId::ForceConstant,
    EffectId::ForceRipple,
    EffectId::SecondForceRipple,
    EffectId::Cogging,
    EffectId::CoulombFriction,
    EffectId::ViscousFriction,
    EffectId::ConstantForce,
    EffectId::CableSpring,
    EffectId::EncoderScale,
];

/// Two ripples of the motor's force, one with a pitch of more than twice the travel, as long as motors have it: both are named, and nothing in the
/// place of the long one.
#[test]
fn ref_a_ripple_of_twice_the_travel_is_named_beside_another_one() {
    let grinder = model("grinder");
    let hidden = [
        ("effect.force_ripple.period_m", 0.008),
        ("effect.force_ripple.sine", -0.001),
        ("effect.force_ripple.cosine", 0.03),
        ("effect.second_force_ripple.period_m", 0.056),
        ("effect.second_force_ripple.sine", -0.06),
        ("effect.second_force_ripple.cosine", 0.05),
    ];
    let real = with(&grinder, &hidden);
    let recording = Strokes::both_ways(&grinder, &real, 5).recording(&SHORT);
    let options = Options { catalogue: &RIVALS, ..Options::default() };
    let d = diagnose(&grinder, &recording, &options).unwrap();
    show(&d);
    assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["force_ripple", "second_force_ripple"]));
    let mut periods: Vec<f64> = d.causes.iter().map(|cause| cause.parameters["period_m"].value).collect();
    periods.sort_by(f64::total_cmp);
    // Of less than half a pitch the length is told badly: beyond one and a half travels.
    assert!(periods[1] > 1.5 * 0.021, "{periods:?}");
}

/// Strokes of one period of the longest of three pitches, and less.
const ONE_PERIOD: [Cell; 5] = [
    (0.049, 3.7, Role::Training),
    (0.028, 8.8, Role::Training),
    (0.039, 16.6, Role::Training),
    (0.027, 14.2, Role::HeldOut),
    (0.038, 4.5, Role::HeldOut),
];

/// Three pitches of which one lies near the second harmonic of the largest and is taken up by it, so that two explain all. Step by step the first
/// wave stands for all three, and the second one's fit never leaves it.
#[test]
fn ref_pitches_are_found_together_where_the_first_one_misleads() {
    let grinder = model("grinder");
    let wave = |effect: &str, period: f64, [sine, cosine, sine_2, cosine_2]: [f64; 4]| {
        let path = |key: &str| format!("effect.{effect}.{key}");
        let keys = ["period_m", "sine_n", "cosine_n", "sine_2_n", "cosine_2_n"].map(path);
        keys.into_iter().zip([period, sine, cosine, sine_2, cosine_2])
    };
    let numbers: Vec<(String, f64)> = wave("cogging", 0.047, [-29.6, -10.3, -0.1, -10.4])
        .chain(wave("second_cogging", 0.0246, [-0.7, -4.1, -0.1, -0.1]))
        .chain(wave("third_cogging", 0.0187, [-7.1, 12.4, 1.9, -2.2]))
        .collect();
    let hidden: Vec<(&str, f64)> = numbers.iter().map(|(path, value)| (path.as_str(), *value)).collect();
    let real = with(&grinder, &hidden);
    let recording = Strokes::both_ways(&grinder, &real, 7).recording(&ONE_PERIOD);
    let options = Options { catalogue: &RIVALS, ..Options::default() };
    let d = diagnose(&grinder, &recording, &options).unwrap();
    show(&d);
    assert!(d.gap.after < 2.0, "{:?}", d.gap);
    assert!(d.causes.iter().all(|cause| cause.effect.ends_with("cogging")));
    for (effect, period) in [("cogging", 0.047), ("second_cogging", 0.0187)] {
        let cause = d.causes.iter().find(|cause| cause.effect == effect).unwrap();
        let found = cause.parameters["period_m"].value;
        assert!((found / period - 1.0).abs() < 0.01, "{effect} {found}");
    }
}

const RIPPLES: [EffectId; 3] = [EffectId::ForceRipple, EffectId::SecondForceRipple, EffectId::VelocityFilter];

/// Two ripples on strokes about as long as their pitches, of which the smaller one has a third and a fourth harmonic. It comes second in the fit, which has the
/// larger one first: which of them is called the first does not decide whether
/// the runs are described. Its pitch is not told on such strokes: a fit ends in a valley in which pitches and harmonics compensate each other.
#[test]
fn ref_the_smaller_of_two_ripples_may_have_the_higher_harmonics() {
    let cells = [
        (0.044, 4.1, Role::Training),
        (0.053, 8.0, Role::Training),
        (0.052, 14.2, Role::Training),
        (0.026, 17.5, Role::HeldOut),
        (0.032, 14.7, Role::HeldOut),
    ];
    let grinder = model("grinder");
    let hidden = [
        ("effect.force_ripple.period_m", 0.0497),
        ("effect.force_ripple.sine", -0.0171),
        ("effect.force_ripple.cosine", -0.002),
        ("effect.force_ripple.sine_2", -0.0045),
        ("effect.force_ripple.cosine_3", 0.059),
        ("effect.force_ripple.sine_4", 0.021),
        ("effect.second_force_ripple.period_m", 0.0312),
        ("effect.second_force_ripple.sine", -0.0674),
        ("effect.second_force_ripple.cosine", -0.0312),
    ];
    let real = with(&grinder, &hidden);
    let recording = Strokes::both_ways(&grinder, &real, 5).recording(&cells);
    let options = Options { catalogue: &RIPPLES, ..Options::default() };
    let d = diagnose(&grinder, &recording, &options).unwrap();
    show(&d);
    assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["force_ripple", "second_force_ripple"]));
    assert!(d.gap.after < 1.1, "{:?}", d.gap.after);
}

/// Two pitches of several hundred times the noise, the smaller one of the length of the strokes, behind stated bristles that fade otherwise than those of
/// the machine. A fit that goes on from the first pitch does not come to both (`unknown`): it begins at sets of pitches that are found together.
#[test]
fn ref_two_large_pitches_are_told_on_strokes_of_their_length() {
    let cells = [
        (0.042, 4.1, Role::Training),
        (0.038, 7.8, Role::Training),
        (0.0455, 16.1, Role::Training),
        (0.0505, 15.8, Role::HeldOut),
        (0.030, 3.8, Role::HeldOut),
    ];
    let friction = [
        ("effect.coulomb_friction.force_n", 8.1),
        ("effect.presliding.stiffness_n_per_m", 4.28e6),
        ("effect.presliding.damping_n_s_per_m", 17900.0),
    ];
    let stated = with(&model("grinder"), &friction);
    let hidden = [
        ("effect.presliding.stiffness_n_per_m", 4.26e6),
        ("effect.presliding.damping_fading", 0.55),
        ("effect.presliding.fading_exponent", 1.7),
        ("effect.cogging.period_m", 0.0464),
        ("effect.cogging.sine_n", -2.4),
        ("effect.cogging.cosine_n", -0.7),
        ("effect.cogging.sine_2_n", 0.18),
        ("effect.cogging.cosine_2_n", -0.36),
        ("effect.cogging.sine_3", 0.037),
        ("effect.cogging.cosine_4", 0.016),
        ("effect.second_cogging.period_m", 0.0228),
        ("effect.second_cogging.sine_n", 5.88),
        ("effect.second_cogging.cosine_n", -4.78),
        ("effect.second_cogging.sine_2_n", 1.0),
        ("effect.second_cogging.cosine_2_n", -1.12),
    ];
    let real = with(&stated, &hidden);
    let recording = Strokes::both_ways(&stated, &real, 5).recording(&cells);
    let catalogue = [EffectId::Cogging, EffectId::SecondCogging, EffectId::VelocityFilter];
    let options = Options { catalogue: &catalogue, ..Options::default() };
    let d = diagnose(&stated, &recording, &options).unwrap();
    show(&d);
    assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["cogging", "second_cogging"]));
    assert!(d.gap.after < 1.25, "{:?}", d.gap.after);
    let mut periods: Vec<&Parameter> = d.causes.iter().map(|cause| &cause.parameters["period_m"]).collect();
    periods.sort_by(|a, b| a.value.total_cmp(&b.value));
    for (found, period) in periods.iter().zip([0.0228, 0.0464]) {
        assert!((found.value / period - 1.0).abs() < 0.03, "{found:?}");
    }
}

/// Cogging of 6 mm seen at two places that are 60 mm apart, at each over less than one pitch: a pitch of 30 mm with its second harmonic leaves noise as well, and begins
/// nearer. The fit goes on to the least minimum, with 2.5 σ of the wave and with 8 σ.
#[test]
fn ref_the_least_minimum_of_a_pitch_is_found() {
    let stated = model("grinder");
    let cells = [
        (0.0, (0.0050, 4.0, Role::Training)),
        (0.060, (0.0052, 5.0, Role::Training)),
        (0.0, (0.0048, 6.0, Role::HeldOut)),
        (0.060, (0.0046, 7.0, Role::HeldOut)),
    ];
    let options =
        Options { catalogue: &[EffectId::Cogging, EffectId::CoulombFriction], ..Options::default() };
    // One pitch more or less between the places is 0.5 mm of pitch; the 95 % intervals are ±10 µm and ±0.5 µm.
    for (sine_n, within) in [(0.03, 2e-6), (0.1, 1e-6)] {
        let hidden = [
            ("effect.cogging.period_m", 0.006),
            ("effect.cogging.sine_n", sine_n),
            ("effect.cogging.cosine_n", -0.5 * sine_n),
        ];
        let real = with(&stated, &hidden);
        let recording = Strokes::both_ways(&stated, &real, 5).recording_from(&cells);
        let d = diagnose(&stated, &recording, &options).unwrap();
        show(&d);
        assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["cogging"]));
        let period = &d.causes[0].parameters["period_m"];
        assert!(period.ci95[0] < 0.006 && 0.006 < period.ci95[1], "{period:?}");
        assert!((period.value - 0.006).abs() < within, "{period:?}");
    }
}
