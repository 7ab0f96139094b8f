//! A small blind trial through the whole program: what machines have, diagnosed and scored.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stderr)]

use slideway::machine::Machine;
use slideway::trial::forge::Progress;
use slideway::trial::{Engine, Order, Seed, Tier, forge, run, score};
use std::num::NonZeroUsize;
use std::path::Path;
use tempfile::TempDir;

/// Cases of each tier. The variable SLIDEWAY_TRIAL_CASES asks for more of them.
const CASES: usize = 1;
/// A development seed of its own; its two cases take seconds. More of them are what `slideway trial` is for.
const SEED: u64 = 362;

/// No wrong name is given with confidence, and every recording that can be held out from is answered.
#[test]
fn ref_a_sample_of_machines_is_answered_without_a_confident_wrong_name() {
    let asked = std::env::var("SLIDEWAY_TRIAL_CASES").map(|count| count.parse().unwrap());
    let place = TempDir::new().unwrap();
    let machine = Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap();
    let order = Order {
        machine: &machine,
        seed: Seed::new(SEED).unwrap(),
        // What is outside the catalogue is asked of nine effects by the tests of the diagnosis.
        tiers: &[Tier::Null, Tier::Single],
        cases: Some(asked.unwrap_or(CASES)),
        engine: Engine::Axis,
        folder: &place.path().join("sample"),
    };
    let progress = Progress { drawing: &|_| (), sealed: &|_| (), done: &|| () };
    let trial = forge(&order, &progress).unwrap();
    run(&trial, std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN), &|_| ()).unwrap();
    let scores = score(&trial).unwrap();
    for case in &scores.cases {
        eprintln!("{} {}: {}", case.case, case.tier, case.story);
    }
    assert_eq!(scores.cases.len(), order.tiers.len() * order.cases.unwrap());
    let wrong: Vec<String> =
        scores.confident_wrong.iter().map(|wrong| format!("{}: {}", wrong.effect, wrong.story)).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    let runs =
        |case: usize| slideway::recording::Recording::read(trial.case_folder(case)).unwrap().runs().len();
    let refused = scores.cases.iter().filter(|case| case.verdict == "refused" && runs(case.case) > 1);
    assert_eq!(refused.count(), 0);
}
