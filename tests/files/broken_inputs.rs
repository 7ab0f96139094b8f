//! Broken inputs, several hundred, through the program: each is refused with a message that helps; none is accepted, none ends
//! in a panic, none takes long.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr, missing_docs)]

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use super::broken::{Case, Expected};

/// Longest time that a refusal may take.
const LONGEST: Duration = Duration::from_secs(10);
/// Share of the refusals that must be good ones.
const GOOD_SHARE: f64 = 0.95;
/// Longest message, in bytes.
const LONGEST_MESSAGE: usize = 3000;
/// Digits of a number that nobody reads.
const MOST_DIGITS: usize = 40;

/// Where one case ended.
struct Ended {
    name: String,
    fault: Option<String>,
    /// Accepted, panicked or hung: never right.
    is_grave: bool,
}

fn run(case: &Case, folder: &Path) -> Result<(Option<i32>, String), String> {
    let errors = folder.join("stderr.txt");
    let mut child = Command::new(env!("CARGO_BIN_EXE_slideway"))
        .args(&case.arguments)
        .current_dir(folder)
        .env_remove("SLIDEWAY_DATA")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(std::fs::File::create(&errors).unwrap())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while begun.elapsed() < LONGEST {
        if let Some(status) = child.try_wait().unwrap() {
            return Ok((
                status.code(),
                String::from_utf8_lossy(&std::fs::read(errors).unwrap()).into_owned(),
            ));
        }
        std::thread::sleep(Duration::from_millis(4));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    Err("hung".to_owned())
}

/// What is wrong with the way in which a case was refused.
fn fault(case: &Case, message: &str) -> Option<String> {
    let longest = message.split(|c: char| !c.is_ascii_digit()).map(str::len).max().unwrap_or(0);
    let lacks = |words: &[&str]| !words.iter().any(|word| message.contains(word));
    if message.len() > LONGEST_MESSAGE || longest > MOST_DIGITS {
        Some(format!("a message of {} bytes, a number of {longest} digits", message.len()))
    } else if message.chars().any(|c| c.is_control() && c != '\n') {
        Some("control characters".to_owned())
    } else if lacks(&["help:", "try '--help'"]) {
        Some("it does not say what to do".to_owned())
    } else if lacks(&["expected", "possible values", "required", "cannot be used with"]) {
        Some("it does not say what was expected".to_owned())
    } else if !case.at_fault.is_empty() && lacks(&[case.at_fault]) {
        Some(format!("it does not name {}", case.at_fault))
    } else if ["os error", "missing field", "NaN at sample", "custom: "]
        .iter()
        .any(|word| message.contains(word))
    {
        Some("words of a library".to_owned())
    } else {
        None
    }
}

fn judged(case: &Case) -> Ended {
    let folder = tempfile::tempdir().unwrap();
    for (path, bytes) in &case.files {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    let before = names(folder.path());
    let (fault, is_grave) = match run(case, folder.path()) {
        Err(hung) => (Some(hung), true),
        Ok((Some(1..), message)) if case.expected == Expected::Acceptance => {
            (Some(format!("not accepted: {message}")), true)
        }
        Ok((Some(2), message)) => {
            let left =
                names(folder.path()).into_iter().find(|name| !before.contains(name) && name != "stderr.txt");
            let left = left.map(|name| format!("it leaves {name}"));
            (fault(case, &message).or(left).map(|fault| format!("{fault}: {message}")), false)
        }
        Ok((Some(0), _)) if case.expected != Expected::Refusal => (None, false),
        Ok((Some(0), _)) => (Some("accepted".to_owned()), true),
        Ok((code, message)) => (Some(format!("ended with {code:?}: {message}")), true),
    };
    Ended { name: case.name.clone(), fault, is_grave }
}

fn names(folder: &Path) -> Vec<String> {
    std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect()
}

#[test]
fn exact_broken_inputs_are_refused_well() {
    let cases = super::broken::cases();
    let (next, ended) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let workers = std::thread::available_parallelism().map_or(2, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let one = judged(case);
                    ended.lock().unwrap().push(one);
                }
            });
        }
    });
    let mut ended = ended.into_inner().unwrap();
    ended.sort_by(|a, b| a.name.cmp(&b.name));
    let told = |which: &dyn Fn(&Ended) -> bool| {
        let lines =
            ended.iter().filter(|one| which(one)).filter_map(|one| Some((&one.name, one.fault.as_ref()?)));
        lines.map(|(name, fault)| format!("{name}: {fault}")).collect::<Vec<_>>()
    };
    let grave = told(&|one| one.is_grave);
    assert!(grave.is_empty(), "{} of {} cases:\n{}", grave.len(), cases.len(), grave.join("\n"));
    let poor = told(&|_| true);
    eprintln!("{} cases, {} refused poorly\n{}", cases.len(), poor.len(), poor.join("\n"));
    let good = 1.0 - poor.len() as f64 / cases.len() as f64;
    assert!(good >= GOOD_SHARE, "{:.1} % of {} cases:\n{}", 100.0 * good, cases.len(), poor.join("\n"));
}
