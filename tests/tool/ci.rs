//! What the logs of a test run are counted as: a test that could not run its subject is no test that passed.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::needs;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

/// Set where a test of this suite is to find nothing of what it needs.
const WITHOUT: &str = "SLIDEWAY_TEST_WITHOUT";

fn count(logs: &[&str]) -> Output {
    let folder = TempDir::new().unwrap();
    let files: Vec<_> = (0..logs.len()).map(|k| folder.path().join(format!("{k}.log"))).collect();
    files.iter().zip(logs).for_each(|(file, log)| fs::write(file, log).unwrap());
    Command::new(Path::new(env!("CARGO_MANIFEST_DIR")).join(".ci/count")).args(&files).output().unwrap()
}

fn counted(logs: &[&str]) -> String {
    let output = count(logs);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn exact_a_skipped_test_is_not_counted_as_passed() {
    let log = "
running 3 tests
test ref_a ... ok
test ref_b ... SKIPPED axis::ref_c: no data in /d; set IT

SKIPPED axis::ref_b: no data in /d; set IT
ok
test ref_c ... ok

test result: ok. 3 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.01s

running 0 tests

test result: ok. 0 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.00s
";
    let list =
        "skipped:\n  axis::ref_c: no data in /d; set IT\n  axis::ref_b: no data in /d; set IT\n".to_owned();
    assert_eq!(counted(&[log]), list + "1 passed, 0 failed, 2 skipped\n");
}

#[test]
fn exact_a_suite_that_was_not_built_takes_nothing_off() {
    let suite = "SKIPPED scene::all: no library\n";
    let others = "test result: ok. 10 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out\n";
    let list = "skipped:\n  scene::all: no library\n";
    assert_eq!(counted(&[others, suite]), format!("{list}10 passed, 0 failed, 1 skipped\n"));
}

#[test]
fn exact_logs_are_added() {
    let first = "test result: ok. 10 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out\n";
    let second = "SKIPPED scene::ref_1: no library\nSKIPPED scene::ref_1: no library\n\
                  test result: FAILED. 4 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out\n";
    let list = "skipped:\n  scene::ref_1: no library\n";
    assert_eq!(counted(&[first, second]), format!("{list}13 passed, 2 failed, 1 skipped\n"));
}

#[test]
fn exact_words_about_skipping_are_no_skipped_test() {
    let log = "such tests will say SKIPPED\nSKIPPED: nobody\n\
               test result: ok. 7 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out\n";
    assert_eq!(counted(&[log]), "7 passed, 0 failed, 0 skipped\n");
}

#[test]
fn exact_a_count_of_nothing_is_refused() {
    assert!(!count(&[]).status.success());
    let nowhere = Path::new(env!("CARGO_TARGET_TMPDIR")).join("nowhere.log");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join(".ci/count");
    assert!(!Command::new(script).arg(nowhere).output().unwrap().status.success());
}

/// Runs itself once more, without what it needs, and reads what the harness lets through.
#[test]
fn exact_a_test_without_what_it_needs_says_so_past_the_harness() {
    const NAME: &str = "exact_a_test_without_what_it_needs_says_so_past_the_harness";
    needs!(std::env::var_os(WITHOUT).map_or(Ok(()), |_| Err("nothing is there; unset it".to_owned())));
    let again = || {
        let mut again = Command::new(std::env::current_exe().unwrap());
        again.args(["--exact", &format!("ci::{NAME}")]).env(WITHOUT, "1");
        again
    };
    for threads in ["1", "2"] {
        let output = again().args(["--test-threads", threads]).output().unwrap();
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(told, format!("\nSKIPPED tool::ci::{NAME}: nothing is there; unset it\n"));
        let log = String::from_utf8(output.stdout).unwrap() + &told;
        let list = format!("skipped:\n  tool::ci::{NAME}: nothing is there; unset it\n");
        assert_eq!(counted(&[&log]), list + "0 passed, 0 failed, 1 skipped\n");
    }
}
