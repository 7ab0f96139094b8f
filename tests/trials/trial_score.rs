//! The judge of a blind trial: every rule by a case made by hand.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use proptest::prelude::*;
use serde_json::{Value, json};
use slideway::effect::EffectId;
use slideway::trial::engine::Engine;
use slideway::trial::folder::Announcement;
use slideway::trial::laws::Otherwise;
use slideway::trial::nominal::NominalErrors;
use slideway::trial::real::Known;
use slideway::trial::scoring::bars::{Bar, Limit, NULL_CASES, Outcome, bars};
use slideway::trial::scoring::confident_wrong;
use slideway::trial::scoring::confusion::Confusion;
use slideway::trial::scoring::interval::{Level, Rate};
use slideway::trial::scoring::judge::{Alarm, Judged};
use slideway::trial::scoring::naming::Standing;
use slideway::trial::scoring::reliability::Reliability;
use slideway::trial::scoring::size::{Band, Demand};
use slideway::trial::scoring::summary;
use slideway::trial::seal::{Committed, Ledger};
use slideway::trial::truth::{HiddenEffect, TrueCase};
use slideway::trial::verdict::Said;
use slideway::trial::{Sealed, Tier, Trial, Truth};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

const COULOMB: &str = "coulomb_friction";
const PAYLOAD: &str = "payload";
const COGGING: &str = "cogging";
const BRISTLES: &str = "presliding";

/// A planned effect; `parameters` are those of a force of 10 N.
fn planned(effect: EffectId, gap: f64) -> HiddenEffect {
    let parameters = match effect {
        EffectId::CoulombFriction => BTreeMap::from([("force_n".to_owned(), 10.0)]),
        _ => BTreeMap::new(),
    };
    HiddenEffect { effect, parameters, planned: true, gap, equals: Vec::new() }
}

/// An effect that comes along.
fn along(effect: EffectId, gap: f64) -> HiddenEffect {
    HiddenEffect { planned: false, ..planned(effect, gap) }
}

fn equal_to(equal: EffectId, hidden: HiddenEffect) -> HiddenEffect {
    HiddenEffect { equals: vec![equal], ..hidden }
}

fn truth(tier: Tier, effects: &[HiddenEffect]) -> TrueCase {
    TrueCase {
        case: 1,
        tier,
        effects: effects.to_vec(),
        stated: Vec::new(),
        twin: BTreeMap::new(),
        before: Vec::new(),
        nominal: NominalErrors::default(),
        otherwise: Otherwise::bristles(4e-8, 0.7),
        runs: Vec::new(),
        struck: Vec::new(),
        missing: Vec::new(),
        gap: effects.iter().map(|h| h.gap).fold(0.0, f64::max),
        step_s: 0.0,
        integration_error: 0.0,
    }
}

/// A verdict on causes `name` or `name|confusable`, with probabilities. A name in brackets is probable and no cause. Every cause
/// has a force of 11 N (10.5 to 11.5).
fn verdict(came: &str, names: &[(&str, f64)]) -> Value {
    let mut causes = Vec::new();
    let mut effects = Vec::new();
    for (words, probability) in names {
        let mut group = words.trim_matches(['(', ')']).split('|');
        let effect = group.next().unwrap();
        effects.push(json!({"effect": effect, "probability": probability}));
        if !words.starts_with('(') {
            let force = json!({"value": 11.0, "ci95": [10.5, 11.5], "unit": "N", "twin": 0.0});
            causes.push(json!({"effect": effect, "site": "guide", "probability": probability, "closes": 0.9,
                "confusable_with": group.collect::<Vec<_>>(), "parameters": {"force_n": force}}));
        }
    }
    json!({"schema": "slideway-diagnosis/1", "verdict": came, "causes": causes, "effects": effects, "ranking": [],
        "gap": {"before": 20.0, "after": 1.0, "closed": 0.9, "predicted_closed": 0.85},
        "where": {"site": [{"site": "motor", "share": 0.2}, {"site": "guide", "share": 0.8}]}})
}

fn committed(verdict: &Value) -> Committed {
    Committed { case: 1, said: Said::parse(verdict.to_string().as_bytes()).unwrap(), seconds: 2.0 }
}

fn judged(truth: &TrueCase, came: &str, names: &[(&str, f64)]) -> Judged {
    Judged::new(truth, &committed(&verdict(came, names)))
}

fn single(gap: f64) -> TrueCase {
    truth(Tier::Single, &[planned(EffectId::CoulombFriction, gap)])
}

fn standings(case: &Judged) -> Vec<Standing> {
    case.named.iter().map(|name| name.standing).collect()
}

#[test]
fn exact_demands_and_bands_have_their_edges() {
    let of = |gap| (Demand::of(gap), Band::of(gap));
    assert_eq!(of(0.0), (Demand::NeedNot, Band::BelowFloor));
    assert_eq!(of(0.999), (Demand::NeedNot, Band::BelowFloor));
    assert_eq!(of(1.0), (Demand::May, Band::From1To3));
    assert_eq!(of(2.999), (Demand::May, Band::From1To3));
    assert_eq!(of(3.0), (Demand::Must, Band::From3To30));
    assert_eq!(of(30.0), (Demand::Must, Band::Above30));
}

#[test]
fn exact_a_large_effect_must_be_named() {
    let named = judged(&single(20.0), "cause", &[(COULOMB, 0.97)]);
    assert_eq!((named.top_1, named.top_2, named.all_named), (Some(true), Some(true), Some(true)));
    assert!(named.is_right() && named.extra == 0 && named.alarm.is_none() && !named.flagged);
    assert_eq!((named.probability, named.site, named.band), (Some(0.97), Some(true), Some(Band::From3To30)));
    // |11 − 10| / 10; 10.5 to 11.5 does not hold 10.
    assert!((named.parameter_error.unwrap() - 0.1).abs() < 1e-12);
    assert_eq!(named.covered, Some(0.0));
    for came in ["no_gap", "refused", "unknown"] {
        assert!(judged(&single(20.0), came, &[]).probability.unwrap().is_sign_positive());
        let none = judged(&single(20.0), came, &[]);
        assert_eq!(
            (none.top_1, none.all_named, none.is_right()),
            (Some(false), Some(false), false),
            "{came}"
        );
        assert_eq!(none.hidden[0].named_as, None);
    }
}

#[test]
fn exact_between_one_and_three_sigma_an_effect_may_be_named() {
    let named = judged(&single(2.0), "cause", &[(COULOMB, 0.97)]);
    let quiet = judged(&single(2.0), "no_gap", &[]);
    assert_eq!((named.top_1, quiet.top_1), (Some(true), Some(false)));
    // Nothing must be named: neither is wrong, and it is no null case.
    assert_eq!((named.all_named, quiet.all_named), (None, None));
    assert!(named.is_right() && quiet.is_right() && named.alarm.is_none() && quiet.alarm.is_none());
    assert!(!judged(&single(2.0), "cause", &[(PAYLOAD, 0.6)]).is_right());
}

#[test]
fn exact_below_the_floor_a_single_case_is_null() {
    let came = |verdict, names: &[(&str, f64)]| judged(&single(0.9), verdict, names);
    let quiet = came("no_gap", &[]);
    assert_eq!((quiet.alarm, quiet.band), (Some(Alarm::Quiet), Some(Band::BelowFloor)));
    assert_eq!((quiet.top_1, quiet.all_named, quiet.probability), (None, None, None));
    // Its right name is not wrong.
    let named = came("cause", &[(COULOMB, 0.99)]);
    assert_eq!((named.alarm, named.extra, named.is_right()), (Some(Alarm::Quiet), 0, true));
    assert_eq!(came("cause", &[(PAYLOAD, 0.6)]).alarm, Some(Alarm::FalseName));
    for other in ["unknown", "undecided", "refused"] {
        let case = came(other, &[]);
        assert_eq!((case.alarm, case.is_right()), (Some(Alarm::OtherVerdict), false), "{other}");
    }
}

#[test]
fn exact_what_comes_along_is_hidden_too() {
    let friction = planned(EffectId::CoulombFriction, 20.0);
    let with = |gap| truth(Tier::Single, &[friction.clone(), along(EffectId::Presliding, gap)]);
    let both = [(BRISTLES, 0.95), (COULOMB, 0.99)];
    // The bristles stand before the friction: they are hidden, and no wrong name.
    for gap in [0.1, 2.0, 5.0] {
        let case = judged(&with(gap), "cause", &both);
        assert_eq!((case.extra, case.top_1, case.all_named), (0, Some(true), Some(true)), "{gap}");
    }
    // From 3 σ on they must be named.
    let alone = |gap| judged(&with(gap), "cause", &[(COULOMB, 0.99)]);
    assert_eq!([2.0, 5.0].map(|gap| alone(gap).all_named), [Some(true), Some(false)]);
    assert_eq!([2.0, 5.0].map(|gap| alone(gap).planned_named), [Some(true); 2]);
    // Without friction there are no bristles.
    let payload = truth(Tier::Single, &[planned(EffectId::Payload, 20.0)]);
    let case = judged(&payload, "cause", &[(PAYLOAD, 0.99), (BRISTLES, 0.95)]);
    assert_eq!((case.extra, case.confident_wrong().count()), (1, 1));
    // What the twin states already is not hidden.
    let mut stated = payload;
    let force_n = BTreeMap::from([("force_n".to_owned(), 10.0)]);
    stated.stated.push(Known { effect: EffectId::CoulombFriction, parameters: force_n });
    assert_eq!(judged(&stated, "cause", &[(PAYLOAD, 0.9), (COULOMB, 0.5)]).extra, 1);
}

/// A nuisance of 2 σ may be named in the null tier, and the case is no null case.
#[test]
fn exact_nuisances_decide_what_is_null() {
    let with = |gap| truth(Tier::Null, &[along(EffectId::Cogging, gap)]);
    assert_eq!(judged(&with(0.9), "no_gap", &[]).alarm, Some(Alarm::Quiet));
    assert_eq!(judged(&with(0.9), "cause", &[(COGGING, 0.99)]).alarm, Some(Alarm::Quiet));
    assert_eq!(judged(&with(0.9), "cause", &[(COGGING, 0.99), (PAYLOAD, 0.5)]).alarm, Some(Alarm::FalseName));
    let shown = judged(&with(2.0), "no_gap", &[]);
    assert_eq!((shown.alarm, shown.band, shown.is_right()), (None, None, true));
    assert!(!judged(&with(2.0), "cause", &[(PAYLOAD, 0.5)]).is_right());
}

#[test]
fn exact_an_equal_names_an_effect() {
    let constant = equal_to(EffectId::EncoderScale, planned(EffectId::ForceConstant, 20.0));
    let case = truth(Tier::Single, &[constant]);
    let equal = judged(&case, "cause", &[("encoder_scale", 0.5), ("(force_constant)", 0.5)]);
    assert_eq!((standings(&equal), equal.top_1, equal.extra), (vec![Standing::Equal], Some(true), 0));
    assert!(equal.has_equals() && equal.named_itself_or_equal() && equal.probability == Some(1.0));
    // A group with an equal in it names it as well, but is neither.
    let group = judged(&case, "cause", &[("payload|encoder_scale", 0.9)]);
    assert_eq!((standings(&group), group.top_1), (vec![Standing::Group], Some(true)));
    assert!(group.has_equals() && !group.named_itself_or_equal());
    let other = judged(&case, "cause", &[(PAYLOAD, 0.95)]);
    assert_eq!((other.top_1, other.extra, other.confident_wrong().count()), (Some(false), 1, 1));
    // Two of three without equals named first, and one of two with them.
    let named = judged(&single(20.0), "cause", &[(COULOMB, 0.9)]);
    let missed = judged(&single(20.0), "unknown", &[]);
    let tally = summary::tiers(&[named.clone(), named, missed, equal, other]).remove(0).tally;
    let counts = |rate: Rate| (rate.hits, rate.of);
    assert_eq!(counts(tally.top_1), (3, 5));
    assert_eq!(counts(tally.top_1_without_equals), (2, 3));
    assert_eq!(counts(tally.with_equals), (1, 2));
}

#[test]
fn exact_a_reported_group_names_its_members() {
    let case = single(20.0);
    let group = judged(&case, "cause", &[("payload|coulomb_friction", 0.9), ("(coulomb_friction)", 0.1)]);
    assert_eq!((standings(&group), group.top_1), (vec![Standing::Group], Some(true)));
    assert!((group.probability.unwrap() - 1.0).abs() < 1e-12 && group.parameter_error.is_none());
    // An undecided verdict is a group of its explanations, as far as they are a twentieth as probable as the first.
    for (probability, standing) in [(0.05, Standing::Group), (0.03, Standing::Extra)] {
        let mut said = verdict("undecided", &[(PAYLOAD, 0.9)]);
        said["ranking"] = json!([{"effects": [PAYLOAD], "probability": 0.9, "held_out_gap": 1.0},
            {"effects": [COULOMB], "probability": probability, "held_out_gap": 1.0}]);
        let case = Judged::new(&case, &committed(&said));
        assert_eq!((standings(&case), case.flagged), (vec![standing], true));
        // Nobody reads explanations that a verdict `cause` leaves aside.
        said["verdict"] = "cause".into();
        assert_eq!(standings(&Judged::new(&single(20.0), &committed(&said))), [Standing::Extra]);
    }
}

/// One name in a group of two that are both hidden is one of them.
#[test]
fn exact_one_cause_names_one_hidden_effect() {
    let two = [planned(EffectId::CoulombFriction, 20.0), planned(EffectId::Payload, 10.0)];
    let pair = truth(Tier::Pair, &two);
    let one = judged(&pair, "cause", &[("cogging|coulomb_friction|payload", 0.9)]);
    assert_eq!((one.planned_named, one.extra), (Some(false), 0));
    // The one that can only be the other leaves the group to it.
    let both = judged(
        &pair,
        "cause",
        &[("cogging|coulomb_friction|payload", 0.9), ("backlash|coulomb_friction", 0.8)],
    );
    assert_eq!((both.planned_named, both.top_1), (Some(true), Some(true)));
}

#[test]
fn exact_extra_names_push_the_truth_back() {
    let first = judged(&single(20.0), "cause", &[(COULOMB, 0.99), (PAYLOAD, 0.6)]);
    assert_eq!((first.top_1, first.extra, first.is_right()), (Some(true), 1, true));
    let second = judged(&single(20.0), "cause", &[(PAYLOAD, 0.6), (COULOMB, 0.99)]);
    assert_eq!((second.top_1, second.top_2, second.all_named), (Some(false), Some(true), Some(true)));
    let third = judged(&single(20.0), "cause", &[(PAYLOAD, 0.6), (COGGING, 0.6), (COULOMB, 0.99)]);
    assert_eq!((third.top_1, third.top_2, third.extra), (Some(false), Some(false), 2));
    // Probable, behind one wrong name or two.
    let probable = judged(&single(20.0), "cause", &[(PAYLOAD, 0.6), ("(coulomb_friction)", 0.4)]);
    assert_eq!((probable.top_1, probable.top_2, probable.all_named), (Some(false), Some(true), Some(false)));
    let names = [(PAYLOAD, 0.6), ("(cogging)", 0.5), ("(coulomb_friction)", 0.4)];
    assert_eq!(judged(&single(20.0), "cause", &names).top_2, Some(false));
    // What no_gap thinks probable has no place.
    assert_eq!(judged(&single(20.0), "no_gap", &[("(coulomb_friction)", 0.4)]).top_2, Some(false));
}

#[test]
fn exact_confident_wrong_names_are_listed() {
    let mut case = single(20.0);
    let wrong =
        |case: &TrueCase, came, probability| judged(case, came, &[(COULOMB, 0.99), (PAYLOAD, probability)]);
    let count = |judged: &Judged| judged.confident_wrong().count();
    assert_eq!(count(&wrong(&case, "cause", 0.9)), 1);
    assert_eq!(count(&wrong(&case, "cause", 0.899)), 0);
    for doubted in ["undecided", "unknown"] {
        assert_eq!(count(&wrong(&case, doubted, 0.99)), 0, "{doubted}");
    }
    case.case = 7;
    let cases = [wrong(&single(20.0), "cause", 0.92), wrong(&case, "cause", 0.95)];
    let list = confident_wrong(&cases);
    let told: Vec<_> = list.iter().map(|w| (w.case, w.tier, w.effect.as_str(), w.probability)).collect();
    assert_eq!(told, [(7, Tier::Single, PAYLOAD, 0.95), (1, Tier::Single, PAYLOAD, 0.92)]);
    assert!(list[0].story.starts_with("hidden coulomb_friction (20.0 σ: force_n 10.0000); said cause"));
}

#[test]
fn exact_pairs_and_triples_are_judged_by_hand() {
    let pair = |small| {
        truth(Tier::Pair, &[planned(EffectId::CoulombFriction, 20.0), planned(EffectId::Payload, small)])
    };
    let both = judged(&pair(5.0), "cause", &[(PAYLOAD, 0.6), (COULOMB, 1.0)]);
    assert!(both.is_right() && both.top_1 == Some(true) && both.planned_named == Some(true));
    assert!((both.probability.unwrap() - 0.8).abs() < 1e-12);
    let one = |small| judged(&pair(small), "cause", &[(COULOMB, 1.0), ("backlash", 0.6)]);
    let case = one(5.0);
    assert_eq!((case.planned_named, case.extra, case.is_right()), (Some(false), 1, false));
    // The smallest planned gap is the size: what may or need not be named is not asked for.
    assert_eq!([5.0, 2.0, 0.5].map(|gap| one(gap).size.unwrap()), [5.0, 2.0, 0.5]);
    assert_eq!(
        [2.0, 0.5].map(|gap| (one(gap).planned_named, one(gap).is_right())),
        [(Some(false), true), (Some(true), true)]
    );
    assert_eq!([5.0, 2.0].map(|gap| one(gap).all_named), [Some(false), Some(true)]);
    let three = [EffectId::CoulombFriction, EffectId::Payload, EffectId::Cogging].map(|e| planned(e, 9.0));
    let triple = truth(Tier::Triple, &three);
    assert!(judged(&triple, "cause", &[(COULOMB, 1.0), (PAYLOAD, 1.0), (COGGING, 1.0)]).is_right());
    assert!(!judged(&triple, "cause", &[(COULOMB, 1.0), (PAYLOAD, 1.0)]).is_right());
}

#[test]
fn exact_outside_cases_are_flagged() {
    let struck = |gap| truth(Tier::Outside, &[planned(EffectId::CoulombFriction, gap)]);
    for flag in ["unknown", "undecided"] {
        assert!(judged(&struck(20.0), flag, &[(PAYLOAD, 0.99)]).is_right(), "{flag}");
        // Below the floor a flag is the right name, no false alarm.
        assert_eq!(judged(&struck(0.5), flag, &[]).alarm, Some(Alarm::Quiet), "{flag}");
    }
    let sure = judged(&struck(20.0), "cause", &[(PAYLOAD, 0.95)]);
    assert_eq!((sure.is_right(), sure.confident_wrong().count(), sure.top_1), (false, 1, None));
    assert!(
        !judged(&struck(20.0), "no_gap", &[]).is_right() && judged(&struck(0.5), "no_gap", &[]).is_right()
    );
    assert_eq!(judged(&struck(0.5), "cause", &[(PAYLOAD, 0.5)]).alarm, Some(Alarm::FalseName));
    // What no law describes has no effect: its size is the gap of everything.
    let foreign = |gap: f64| TrueCase { gap, ..truth(Tier::Outside, &[along(EffectId::Presliding, 0.2)]) };
    let missed = judged(&foreign(12.0), "no_gap", &[]);
    assert_eq!((missed.size, missed.alarm, missed.is_right()), (Some(12.0), None, false));
    let bristles = judged(&foreign(12.0), "cause", &[(BRISTLES, 0.99)]);
    assert_eq!((bristles.extra, bristles.is_right()), (0, false));
    assert_eq!(judged(&foreign(0.5), "no_gap", &[]).alarm, Some(Alarm::Quiet));
}

#[test]
fn exact_changes_leave_aside_what_was_before() {
    let change = |gap, before| TrueCase {
        before: vec![planned(EffectId::Cogging, before)],
        ..truth(Tier::Change, &[planned(EffectId::CoulombFriction, gap)])
    };
    let right = judged(&change(20.0, 9.0), "cause", &[(COGGING, 0.99), (COULOMB, 0.9)]);
    assert_eq!(standings(&right), [Standing::Before, Standing::Itself]);
    assert!(right.is_right() && right.top_1 == Some(true) && right.extra == 0);
    // Only what was before, something else beside, nothing.
    assert!(!judged(&change(20.0, 9.0), "cause", &[(COGGING, 0.99)]).is_right());
    assert!(!judged(&change(20.0, 9.0), "cause", &[(COULOMB, 0.9), (PAYLOAD, 0.5)]).is_right());
    assert!(!judged(&change(20.0, 9.0), "no_gap", &[]).is_right());
    // What was before shows, or does not: a null case or none.
    assert_eq!(judged(&change(0.5, 9.0), "unknown", &[]).alarm, None);
    assert_eq!(judged(&change(0.5, 0.5), "unknown", &[]).alarm, Some(Alarm::OtherVerdict));
}

/// Statements by hand: true ones of 0.95 and 0.4 + 0.4, false ones of 0.6 and 0.06; 0.04 is none.
#[test]
fn exact_reliability_counts_by_hand() {
    let constant = equal_to(EffectId::EncoderScale, planned(EffectId::ForceConstant, 20.0));
    let case = truth(Tier::Pair, &[constant, planned(EffectId::CoulombFriction, 0.2)]);
    let names = [
        ("encoder_scale", 0.4),
        (COULOMB, 0.95),
        (PAYLOAD, 0.6),
        ("(force_constant)", 0.4),
        ("(cogging)", 0.06),
        ("(backlash)", 0.04),
    ];
    let one = judged(&case, "cause", &names);
    let mut told: Vec<_> = one.statements.iter().map(|s| (s.effect.as_str(), s.is_true)).collect();
    told.sort_unstable();
    assert_eq!(told, [(COGGING, false), (COULOMB, true), ("force_constant", true), (PAYLOAD, false)]);
    // A cause counts whatever its probability; 1 is in the last bin; what was before is no statement.
    let change = TrueCase { before: vec![planned(EffectId::Cogging, 9.0)], ..single(20.0) };
    let other = judged(&change, "cause", &[(PAYLOAD, 0.01), (COULOMB, 1.0), (COGGING, 0.9)]);
    let reliability = Reliability::of(&[one, other]);
    assert_eq!(reliability.statements, 6);
    let bins: Vec<_> = reliability.bins.iter().map(|b| (b.share_true.hits, b.share_true.of)).collect();
    assert_eq!(bins, [(0, 2), (0, 0), (0, 0), (0, 1), (1, 1), (1, 1), (1, 1)]);
    assert!(
        (reliability.bins[0].stated.unwrap() - 0.035).abs() < 1e-12 && reliability.bins[1].stated.is_none()
    );
    // Squares of 0.06, 0.01, 0.6, 0.2, 0.05 and 0; distances 2·0.035, 0.6, 0.2, 0.05 and 0.
    let brier = (0.0036 + 0.0001 + 0.36 + 0.04 + 0.0025) / 6.0;
    assert!((reliability.brier_score.unwrap() - brier).abs() < 1e-12);
    assert!((reliability.expected_calibration_error.unwrap() - 0.92 / 6.0).abs() < 1e-12);
    let bin = &reliability.bins[5].share_true;
    assert_eq!(bin.ci95, Rate::new(1, 1).ci95);
    assert!(Reliability::of(&[]).brier_score.is_none());
}

#[test]
fn exact_summaries_count_by_hand() {
    let named = |gap| judged(&single(gap), "cause", &[(COULOMB, 0.9)]);
    let missed = |gap| judged(&single(gap), "unknown", &[]);
    let null = judged(&truth(Tier::Null, &[]), "unknown", &[]);
    let cases =
        [named(0.5), missed(0.5), named(2.0), missed(2.0), missed(2.0), named(10.0), named(50.0), null];
    let tiers = summary::tiers(&cases);
    assert_eq!(
        tiers.iter().map(|t| (t.tier, t.tally.cases)).collect::<Vec<_>>(),
        [(Tier::Null, 1), (Tier::Single, 7)]
    );
    // Below the floor nothing is asked.
    let rates = |t: &summary::Tally| (t.top_1.hits, t.top_1.of, t.right.hits, t.flagged.hits);
    assert_eq!(rates(&tiers[1].tally), (3, 5, 6, 3));
    let bands = summary::bands(&cases);
    let told: Vec<_> =
        bands.iter().map(|b| (b.band, b.tally.cases, b.tally.top_1.hits, b.tally.top_1.of)).collect();
    let expected = [
        (Band::BelowFloor, 2, 0, 0),
        (Band::From1To3, 3, 1, 3),
        (Band::From3To30, 1, 1, 1),
        (Band::Above30, 1, 1, 1),
    ];
    assert_eq!(told, expected);
    let effects = summary::effects(&cases);
    assert_eq!(effects.iter().map(|e| (e.effect, e.tally.cases)).collect::<Vec<_>>(), [(COULOMB, 7)]);
    // Closed 0.9, predicted 0.85: within 0.1.
    let tally = &effects[0].tally;
    assert_eq!((tally.predicted_within.hits, tally.predicted_within.of), (4, 4));
    assert_eq!((tally.closed.value, tally.seconds.value), (Some(0.9), Some(2.0)));
    let nulls: Vec<_> = summary::nulls(&cases)
        .iter()
        .map(|n| (n.tier, n.false_alarms.hits, n.false_names.hits, n.other_verdicts.hits, n.false_alarms.of))
        .collect();
    assert_eq!(nulls, [(Some(Tier::Null), 1, 0, 1, 1), (Some(Tier::Single), 1, 0, 1, 2), (None, 2, 0, 2, 3)]);
    let confusion = Confusion::of(&cases);
    assert_eq!(confusion.rows, ["nothing", COULOMB]);
    assert_eq!(confusion.columns, ["nothing", COULOMB, "(unknown)"]);
    assert_eq!(confusion.counts, [vec![1, 0, 2], vec![0, 3, 2]]);
    assert_eq!(confusion.mistakes(), [("nothing", "(unknown)", 2), (COULOMB, "(unknown)", 2)]);
    let table = slideway::report::confusion::table(&confusion, 100);
    assert!(table.contains("coulomb_friction      5      3  (unknown) 2\n"), "{table}");
}

/// `hits` right cases and the others wrong.
fn some(of: usize, hits: usize, right: &Judged, wrong: &Judged) -> Vec<Judged> {
    [vec![right.clone(); hits], vec![wrong.clone(); of - hits]].concat()
}

/// The outcome of the bar whose name begins so.
fn outcome(cases: &[Judged], name: &str) -> Outcome {
    bar(cases, name).outcome
}

fn bar(cases: &[Judged], name: &str) -> Bar {
    bars(cases).into_iter().find(|bar| bar.name.starts_with(name)).unwrap()
}

#[test]
fn exact_bars_pass_and_miss_at_their_edges() {
    let effect = |tier, effects: &[EffectId]| {
        let hidden: Vec<_> = effects.iter().map(|e| planned(*e, 3.0)).collect();
        truth(tier, &hidden)
    };
    let three = [EffectId::CoulombFriction, EffectId::Payload, EffectId::Cogging];
    let names = [(COULOMB, 0.8), (PAYLOAD, 0.8), (COGGING, 0.8)];
    // Of 20 cases so many are needed; the wrong verdict names nothing.
    for (tier, count, name, needed) in [
        (Tier::Single, 1, "single from 3 σ: named first", 19),
        (Tier::Single, 1, "single from 3 σ: all named", 17),
        (Tier::Pair, 2, "pair", 16),
        (Tier::Triple, 3, "triple", 12),
        (Tier::Change, 1, "change", 18),
    ] {
        let case = effect(tier, &three[..count]);
        let right = judged(&case, "cause", &names[..count]);
        let wrong = judged(&case, "undecided", &[]);
        let came = [needed, needed - 1].map(|hits| outcome(&some(20, hits, &right, &wrong), name));
        assert_eq!(came, [Outcome::Passed, Outcome::Missed], "{name}");
        // A case just below 3 σ is none of theirs.
        let mut small = case;
        small.effects[0].gap = 2.99;
        let small = judged(&small, "unknown", &[]);
        assert_eq!(bar(&[right, small], name).of, 1, "{name}");
        assert_eq!(outcome(&[], name), Outcome::NotMeasured, "{name}");
    }
    // An extra name is no matter for the first bar, but for the second and for changes.
    let extra = judged(&single(3.0), "cause", &[(COULOMB, 0.8), (PAYLOAD, 0.8)]);
    assert_eq!(outcome(std::slice::from_ref(&extra), "single from 3 σ: named first"), Outcome::Passed);
    assert_eq!(outcome(&[extra], "single from 3 σ: all named"), Outcome::Missed);
    let outside = |gap, came| judged(&truth(Tier::Outside, &[planned(EffectId::Payload, gap)]), came, &[]);
    let came = [18, 17].map(|hits| {
        let cases = some(20, hits, &outside(1.0, "unknown"), &outside(1.0, "no_gap"));
        outcome(&cases, "outside")
    });
    assert_eq!(came, [Outcome::Passed, Outcome::Missed]);
    assert_eq!(outcome(&[outside(0.9, "no_gap")], "outside"), Outcome::NotMeasured);
}

#[test]
fn exact_false_alarms_take_enough_null_cases() {
    let null = |came| judged(&truth(Tier::Null, &[]), came, &[]);
    let came = |of, alarms| {
        let bar = bar(&some(of, of - alarms, &null("no_gap"), &null("unknown")), "null");
        assert_eq!((bar.of, bar.needs), (of, NULL_CASES));
        bar.outcome
    };
    assert_eq!((came(300, 3), came(300, 4)), (Outcome::Passed, Outcome::Missed));
    assert_eq!(
        (came(299, 0), came(299, 2), came(299, 3)),
        (Outcome::NotEnoughCases, Outcome::NotEnoughCases, Outcome::Missed)
    );
    // A single case below the floor is a null case.
    let small = judged(&single(0.5), "no_gap", &[]);
    assert_eq!(outcome(&[vec![small], vec![null("no_gap"); 299]].concat(), "null"), Outcome::Passed);
}

#[test]
fn exact_confident_wrong_names_and_coverage_have_bars() {
    let right = judged(&single(20.0), "cause", &[(COULOMB, 0.9)]);
    let wrong = judged(&single(20.0), "cause", &[(PAYLOAD, 0.9), (COGGING, 0.95)]);
    // Two in one case count once.
    let came = [1, 2].map(|wrongs| outcome(&some(100, 100 - wrongs, &right, &wrong), "confident"));
    assert_eq!(came, [Outcome::Passed, Outcome::Missed]);
    // Of 100 intervals: 89, 90, 99 and all hold the truth.
    let held = |held: f64| Judged { covered: Some(held), ..right.clone() };
    let came = [89, 90, 99, 100].map(|hits| outcome(&some(100, hits, &held(1.0), &held(0.0)), "95 %"));
    assert_eq!(came, [Outcome::Missed, Outcome::Passed, Outcome::Passed, Outcome::Missed]);
    assert_eq!(outcome(&[judged(&single(20.0), "unknown", &[])], "95 %"), Outcome::NotMeasured);
    assert_eq!(bars(&[]).len(), 9);
    assert!(Limit::AtMost(0.01).holds(0.01) && !Limit::Between(0.9, 0.99).holds(0.991));
}

/// Which of two pitches is called the first is a matter of names: their numbers are compared by the pitch.
#[test]
fn exact_pitches_are_compared_by_their_pitch() {
    let hidden = |effect, period: f64| {
        let parameters =
            BTreeMap::from([("period_m".to_owned(), period), ("sine_n".to_owned(), 100.0 * period)]);
        HiddenEffect { parameters, ..planned(effect, 20.0) }
    };
    let truth = truth(Tier::Pair, &[hidden(EffectId::Cogging, 0.03), hidden(EffectId::SecondCogging, 0.014)]);
    let held = |first: f64, second: f64| {
        let mut said = verdict("cause", &[(COGGING, 0.97), ("second_cogging", 0.97)]);
        for (cause, period) in [first, second].into_iter().enumerate() {
            let number = |value: f64| json!({"value": value, "ci95": [0.99 * value, 1.01 * value], "unit": "m", "twin": 0.0});
            said["causes"][cause]["parameters"] =
                json!({"period_m": number(period), "sine_n": number(100.0 * period)});
        }
        Judged::new(&truth, &committed(&said)).covered.unwrap()
    };
    assert_eq!(
        [held(0.03, 0.014), held(0.014, 0.03), held(0.03, 0.02), held(0.02, 0.03)],
        [1.0, 1.0, 0.5, 0.5]
    );
}

/// Wilson's interval in closed form.
#[test]
fn exact_wilson_interval() {
    let z2 = 1.959_963_984_540_054_f64.powi(2);
    let all = Rate::new(20, 20);
    assert!((all.ci95.unwrap()[0] - 20.0 / (20.0 + z2)).abs() < 1e-12);
    let half = Rate::new(10, 20);
    let [from, to] = half.ci95.unwrap();
    // p = 1/2: symmetric, half-width z/(2·√(n + z²)).
    assert!((from + to - 1.0).abs() < 1e-12);
    assert!((0.5 * (to - from) - 0.5 * (z2 / (20.0 + z2)).sqrt()).abs() < 1e-12);
    assert!(Rate::new(0, 0).value.is_none() && Level::mean(&[]).value.is_none());
}

proptest! {
    /// An interval holds its value and lies in its range.
    #[test]
    fn exact_intervals_hold_their_values(hits in 0..50usize, more in 1..50usize) {
        let rate = Rate::new(hits, hits + more);
        let [from, to] = rate.ci95.unwrap();
        let value = rate.value.unwrap();
        prop_assert!(0.0 <= from && from <= value + 1e-12 && value <= to + 1e-12 && to <= 1.0);
        let values: Vec<f64> = (0..hits + more).map(|k| k as f64).collect();
        let level = Level::median(&values);
        let [from, to] = level.ci95.unwrap();
        prop_assert!((level.value.unwrap() - 0.5 * (hits + more - 1) as f64).abs() < 1e-9);
        prop_assert!(from <= to && from >= 0.0 && to <= (hits + more - 1) as f64);
    }
}

/// A trial of cases made by hand, with its verdicts committed.
fn made(folder: &Path, cases: Vec<(TrueCase, Value)>) {
    let (truths, verdicts): (Vec<TrueCase>, Vec<Value>) = cases.into_iter().unzip();
    let numbered = |(k, case): (usize, TrueCase)| TrueCase { case: k + 1, ..case };
    let truth = Truth {
        schema: slideway::trial::truth::SCHEMA.to_owned(),
        seed: 1,
        nonce: "none".to_owned(),
        machine: "a table".to_owned(),
        engine: Engine::Axis,
        cases: truths.into_iter().enumerate().map(numbered).collect(),
    };
    let sealed = Sealed::close(&truth, &Trial::truth_file(folder)).unwrap();
    let announcement = Announcement {
        schema: slideway::trial::folder::SCHEMA.to_owned(),
        version: "0".to_owned(),
        seed: 1,
        purpose: "development".to_owned(),
        tiers: Tier::ALL.to_vec(),
        cases: truth.cases.len(),
        machine: truth.machine.clone(),
        machine_sha256: String::new(),
        engine: truth.engine,
        truth_sha256: sealed.sha256().to_owned(),
        skipped: Vec::new(),
    };
    let trial = Trial::announce(folder, announcement).unwrap();
    let mut ledger = Ledger::read(&trial).unwrap();
    for (k, verdict) in verdicts.iter().enumerate() {
        ledger.commit(&trial, k + 1, &verdict.to_string(), 123.4 + k as f64).unwrap();
    }
}

fn scored(folder: &Path, options: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_slideway"));
    command.args(["trial", "score", folder.to_str().unwrap()]).args(options).output().unwrap()
}

/// Every tier, every effect as a single case, and every kind of mistake.
fn all_kinds() -> Vec<(TrueCase, Value)> {
    let mut cases = Vec::new();
    for (k, &effect) in EffectId::ALL.iter().enumerate() {
        let equals = if k % 5 == 0 { vec![EffectId::ALL[(k + 1) % EffectId::ALL.len()]] } else { Vec::new() };
        let hidden = HiddenEffect { equals, ..planned(effect, 0.5 * 1.2_f64.powi(k as i32)) };
        let names = match k % 4 {
            0 => vec![(effect.name(), 0.93), (PAYLOAD, 0.55)],
            1 => vec![("second_force_ripple|load_dependent_friction|friction_drift", 0.97), (BRISTLES, 0.4)],
            _ => vec![(effect.name(), 0.99), ("(cable_spring)", 0.2)],
        };
        cases.push((
            truth(Tier::Single, &[hidden, along(EffectId::Presliding, 1.5)]),
            verdict("cause", &names),
        ));
    }
    let two = [planned(EffectId::CoulombFriction, 20.0), planned(EffectId::Payload, 9.0)];
    for tier in [Tier::Pair, Tier::Triple, Tier::Poor, Tier::Missing, Tier::Change, Tier::Outside] {
        let count = tier.effects().min(2);
        let case = TrueCase { before: Vec::new(), ..truth(tier, &two[..count]) };
        for names in [vec![(COULOMB, 0.96), (PAYLOAD, 0.91)], vec![(COULOMB, 0.7)]] {
            cases.push((case.clone(), verdict("cause", &names)));
        }
        cases.push((case, verdict("undecided", &[("cogging|payload", 0.5)])));
    }
    let null = truth(Tier::Null, &[along(EffectId::Cogging, 0.4)]);
    cases.extend((0..12).map(|_| (null.clone(), verdict("no_gap", &[]))));
    cases.push((null, verdict("cause", &[("force_ripple", 0.4)])));
    cases
}

#[test]
fn exact_score_is_shown_in_a_hundred_columns() {
    let folder = tempfile::tempdir().unwrap();
    let trial = folder.path().join("trial");
    made(&trial, all_kinds());
    let [json, svg] = ["score.json", "confusion.svg"].map(|name| folder.path().join(name));
    let options = ["--json", json.to_str().unwrap(), "--figure", svg.to_str().unwrap(), "--exit-code"];
    let output = scored(&trial, &options);
    let shown = String::from_utf8(output.stdout).unwrap();
    println!("{shown}");
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    for line in shown.lines() {
        assert!(line.chars().count() <= 100, "{} columns: {line}", line.chars().count());
    }
    for words in ["MISS", "Confident wrong names: ", "Reliability of ", "below floor", "has equals, cases"] {
        assert!(shown.contains(words), "{words}");
    }
    let score: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    assert_eq!(score["schema"], "slideway-score/2");
    assert_eq!(score["bars"].as_array().unwrap().len(), 9);
    assert_eq!(score["reliability"]["bins"].as_array().unwrap().len(), 7);
    assert_eq!(score["tiers"].as_array().unwrap().len(), Tier::ALL.len());
    assert_eq!(score["effects"].as_array().unwrap().len(), EffectId::ALL.len());
    let listed = score["confident_wrong"].as_array().unwrap();
    assert!(listed.iter().all(|wrong| wrong["probability"].as_f64().unwrap() >= 0.9) && !listed.is_empty());
    let drawn = std::fs::read_to_string(&svg).unwrap();
    assert!(drawn.starts_with("<svg") && drawn.ends_with("</svg>\n"));
}

/// A bar that is missed is the exit code; one on too few cases, or not measured, is not.
#[test]
fn exact_exit_code_is_of_missed_bars() {
    let folder = tempfile::tempdir().unwrap();
    let null = || truth(Tier::Null, &[]);
    let code = |name: &str, cases, options: &[&str]| {
        let trial = folder.path().join(name);
        made(&trial, cases);
        let output = scored(&trial, options);
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    };
    let (quiet, shown) = code("quiet", vec![(null(), verdict("no_gap", &[]))], &["--exit-code"]);
    assert_eq!(quiet, Some(0), "{shown}");
    assert!(shown.contains("not enough cases") && shown.contains("1 of 300"), "{shown}");
    let alarm = || vec![(null(), verdict("cause", &[(PAYLOAD, 0.5)]))];
    assert_eq!(code("alarm", alarm(), &["--exit-code"]).0, Some(1));
    assert_eq!(code("asked", alarm(), &[]).0, Some(0));
}
