//! What blind trials draw: physical sizes, friction on a bristle, what nobody could tell apart, runs that have converged.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use slideway::effect::{EffectId, Prior};
use slideway::machine::Machine;
use slideway::recording::Signal;
use slideway::trial::draw::{Cases, Outcome};
use slideway::trial::engine::STEP_S;
use slideway::trial::forge::logged;
use slideway::trial::hide::{hidden, stated_friction};
use slideway::trial::nominal::NominalErrors;
use slideway::trial::plan::Planned;
use slideway::trial::real::Real;
use slideway::trial::runs;
use slideway::trial::scale::machinery;
use slideway::trial::truth::{HiddenEffect, TrueCase};
use slideway::trial::{Engine, Seed, Tier};
use std::path::Path;

fn model(name: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(name)).unwrap()
}

fn planned(tier: Tier, effects: &[EffectId], purpose: &str) -> Planned {
    Planned {
        tier,
        effects: effects.to_vec(),
        spare: Vec::new(),
        missing: Vec::new(),
        purpose: purpose.to_owned(),
    }
}

fn drawn(machine: &Machine, planned: &Planned) -> Outcome {
    let logged = logged(machine);
    let cases = Cases { seed: Seed::new(11).unwrap(), machine, engine: Engine::Axis, logged: &logged };
    cases.draw(planned).unwrap()
}

fn case(machine: &Machine, planned: &Planned) -> TrueCase {
    match drawn(machine, planned) {
        Outcome::Drawn(case) => *case,
        Outcome::Skipped(effect, reason) => panic!("{}: {reason}", effect.name()),
    }
}

fn asked_for(case: &TrueCase) -> Vec<&HiddenEffect> {
    case.effects.iter().filter(|hidden| hidden.planned).collect()
}

/// Every effect of the catalogue makes a machine that can have it, together with what it stands on.
#[test]
fn exact_every_effect_makes_a_machine() {
    let machine = model("grinder");
    let real = Real::new(&machine, NominalErrors::default(), Vec::new()).unwrap();
    let mut random = Seed::new(11).unwrap().random("every");
    let runs = runs::draw(&machine, &mut random).unwrap().runs;
    let scale = machinery(&machine, &real, &runs).unwrap();
    let mut prior = Prior::new(&mut random);
    let constants = machine.constants();
    for &effect in EffectId::ALL.iter().filter(|effect| effect.applies(&constants)) {
        for _ in 0..20 {
            let acting = hidden(&real, &scale, &[effect], &mut prior).unwrap();
            let planned: Vec<_> = acting.iter().filter(|acting| acting.planned).collect();
            assert_eq!(planned.iter().map(|acting| acting.effect).collect::<Vec<_>>(), [effect]);
            let made = real.with(&acting).unwrap();
            assert!(acting.iter().all(|acting| made.description().effect.contains(acting.effect)));
        }
    }
}

/// What an effect makes is what comes, some hardly show, some are plain to see; and the forged runs have converged in their step.
#[test]
fn exact_effects_are_drawn_as_they_come() {
    let machine = model("grinder");
    let mut gaps = Vec::new();
    for effect in [EffectId::EncoderPeriodicError, EffectId::CoulombFriction] {
        let case = case(&machine, &planned(Tier::Single, &[effect], effect.name()));
        let own = asked_for(&case);
        assert_eq!(own.iter().map(|hidden| hidden.effect).collect::<Vec<_>>(), [effect]);
        assert!(own[0].gap.is_finite() && case.machine(&machine).is_ok(), "{}", effect.name());
        println!("{:24} {:8.2} error {:.2}", effect.name(), own[0].gap, case.integration_error);
        assert!(case.integration_error <= 1.0 && case.step_s <= STEP_S, "{}", effect.name());
        gaps.push(own[0].gap);
    }
    assert!(gaps[0] < 1.0 && gaps[1] > 30.0, "{gaps:?}");
}

/// Half of the twins state friction, and its bristle with it unless that is what is hidden.
#[test]
fn exact_half_of_the_twins_state_friction() {
    let machine = model("grinder");
    let real = Real::new(&machine, NominalErrors::default(), Vec::new()).unwrap();
    let mut random = Seed::new(11).unwrap().random("stated");
    let runs = runs::draw(&machine, &mut random).unwrap().runs;
    let scale = machinery(&machine, &real, &runs).unwrap();
    let mut prior = Prior::new(&mut random);
    const DRAWS: usize = 400;
    for (hidden, known) in [
        (EffectId::LoopDelay, vec![EffectId::CoulombFriction, EffectId::Presliding]),
        (EffectId::Presliding, vec![EffectId::CoulombFriction]),
    ] {
        let stated: Vec<_> =
            (0..DRAWS).map(|_| stated_friction(&machine, &scale, &[hidden], &mut prior)).collect();
        let some = stated.iter().filter(|acting| !acting.is_empty());
        for acting in some.clone() {
            assert_eq!(acting.iter().map(|acting| acting.effect).collect::<Vec<_>>(), known);
        }
        // Binomial, three standard deviations.
        assert!((170..=230).contains(&some.count()));
    }
}

/// Friction that is hidden brings its bristle; a feature of it brings the friction.
#[test]
fn exact_what_stands_on_something_brings_it() {
    let machine = model("grinder");
    let real = Real::new(&machine, NominalErrors::default(), Vec::new()).unwrap();
    let mut random = Seed::new(11).unwrap().random("stands");
    let runs = runs::draw(&machine, &mut random).unwrap().runs;
    let scale = machinery(&machine, &real, &runs).unwrap();
    let mut prior = Prior::new(&mut random);
    let (coulomb, bristle) = (EffectId::CoulombFriction, EffectId::Presliding);
    for (effect, comes) in [
        (coulomb, vec![bristle]),
        (EffectId::StribeckFriction, vec![coulomb, bristle]),
        (bristle, vec![coulomb]),
        (EffectId::SecondCogging, vec![EffectId::Cogging]),
        (EffectId::LoopDelay, vec![]),
    ] {
        let acting = hidden(&real, &scale, &[effect], &mut prior).unwrap();
        let along = acting.iter().filter(|acting| !acting.planned).map(|acting| acting.effect);
        assert_eq!(along.collect::<Vec<_>>(), comes, "{}", effect.name());
    }
}

/// A machine with nothing hidden carries nuisances at most, below three standard deviations; its twin states friction within its
/// tolerance.
#[test]
fn exact_nuisances_are_small() {
    let machine = model("grinder");
    let (mut carrying, mut stating) = (0, 0);
    for k in 0..6 {
        let case = case(&machine, &planned(Tier::Null, &[], &format!("null {k}")));
        carrying += usize::from(!case.effects.is_empty());
        stating += usize::from(!case.stated.is_empty());
        for hidden in &case.effects {
            let is_nuisance = [EffectId::Cogging, EffectId::AmplifierOffset].contains(&hidden.effect);
            // The other nuisance moves it a little.
            assert!(!hidden.planned && is_nuisance && hidden.gap < 3.3, "{hidden:?}");
        }
        let friction = case.machine(&machine).unwrap().constants().friction;
        assert_eq!(friction.at_rest() > 0.0, friction.bristle.is_some());
        for known in &case.stated {
            for (key, value) in &known.parameters {
                let said = case.twin[&format!("effect.{}.{key}", known.effect.name())];
                assert!((said / value - 1.0).abs() < 0.1 / 6.0 + 1e-12 && said != *value, "{key}");
            }
        }
    }
    assert!(carrying > 0 && stating > 0, "{carrying} {stating}");
}

/// A force and an encoder scale do the same to everything that is logged: Kt·i = m·x″ with x = s·reading. With a force logged they
/// do not.
#[test]
fn exact_equals_come_from_the_information_of_the_truth() {
    let machine = model("grinder");
    // The first draw that is plain to see.
    let find = |logged: &[Signal], effect: EffectId| {
        let cases = Cases { seed: Seed::new(11).unwrap(), machine: &machine, engine: Engine::Axis, logged };
        let draw =
            |k: usize| match cases.draw(&planned(Tier::Single, &[effect], &format!("equal {k}"))).unwrap() {
                Outcome::Drawn(case) => asked_for(&case)[0].clone(),
                Outcome::Skipped(_, reason) => panic!("{reason}"),
            };
        (0..12).map(draw).find(|hidden| hidden.gap > 3.0).unwrap()
    };
    let signals = logged(&machine);
    let scale = find(&signals, EffectId::EncoderScale);
    println!("{scale:?}");
    assert!(scale.gap > 1.0 && scale.equals.contains(&EffectId::ForceConstant), "{scale:?}");
    // By itself a lead error is exactly an error of the one sensor; both at once, as their tangents at the truth have it, are not.
    let lead = find(&signals, EffectId::ScrewError);
    println!("{lead:?}");
    assert!(lead.equals.contains(&EffectId::EncoderPeriodicError), "{lead:?}");
    let delay = find(&signals, EffectId::LoopDelay);
    println!("{delay:?}");
    assert!(delay.gap > 1.0 && delay.equals.is_empty(), "{delay:?}");
}

/// A changed machine differs from the one before by what was asked for, and nothing else.
#[test]
fn exact_a_change_is_what_was_asked_for() {
    let machine = model("grinder");
    let case = case(&machine, &planned(Tier::Change, &[EffectId::LoopDelay], "change"));
    let (before, now) = (case.machine_before(&machine).unwrap(), case.machine(&machine).unwrap());
    let delay = |machine: &Machine| machine.number("effect.loop_delay.delay_s");
    assert_eq!((delay(&before), delay(&now)), (None, Some(asked_for(&case)[0].parameters["delay_s"])));
    assert!(!case.struck.contains(&EffectId::LoopDelay));
}

/// Where two effects cannot be forged together, the case hides another pair, so that a tier keeps its number.
#[test]
fn exact_pair_that_cannot_be_forged_gives_way_to_a_spare() {
    let machine = model("emps");
    let (payload, delay) = (EffectId::Payload, EffectId::LoopDelay);
    // A direct motor has no winding.
    let mut pair = planned(Tier::Pair, &[EffectId::WindingResistance, payload], "pair");
    assert!(matches!(drawn(&machine, &pair), Outcome::Skipped(..)));
    pair.spare = vec![vec![payload, delay]];
    let case = case(&machine, &pair);
    assert_eq!(asked_for(&case).iter().map(|hidden| hidden.effect).collect::<Vec<_>>(), [payload, delay]);
}
