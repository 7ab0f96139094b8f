//! What tests of the diagnosis share: machines with numbers set, and a verdict printed.
#![allow(clippy::print_stdout)]

use slideway::diagnose::Diagnosis;
use slideway::machine::Machine;
use std::path::Path;

/// A machine of the repository.
pub fn model(name: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(name)).unwrap()
}

/// A machine with these numbers, each by its key path.
pub fn with(machine: &Machine, numbers: &[(&str, f64)]) -> Machine {
    machine.with_settings(numbers.iter().map(|&(path, value)| (path, value.into()))).unwrap()
}

/// The effects that are named, in the order of the alphabet.
pub fn names(d: &Diagnosis) -> Vec<&str> {
    let mut names: Vec<&str> = d.causes.iter().map(|cause| cause.effect.as_str()).collect();
    names.sort_unstable();
    names
}

/// Prints verdict, causes and the first of the ranking, for a test that fails.
pub fn show(d: &Diagnosis) {
    println!("{:?} G {:.2} -> {:.2}", d.verdict, d.gap.before, d.gap.after);
    for cause in &d.causes {
        println!(
            "   {} {:.3} {:?} {:?}",
            cause.effect, cause.probability, cause.confusable_with, cause.parameters
        );
    }
    for ranked in d.ranking.iter().take(4) {
        println!("   {ranked:?}");
    }
}
