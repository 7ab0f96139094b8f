//! Blind trials: the seal, the forge, the score.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use slideway::effect::EffectId;
use slideway::machine::Machine;
use slideway::plant::axis::Axis;
use slideway::recording::{Recording, Role, Signal};
use slideway::replay::{follow, run as walk};
use slideway::trial::engine::{SKETCH_STEP_S, sketch};
use slideway::trial::equals::{equals, struck};
use slideway::trial::forge::logged;
use slideway::trial::laws::Otherwise;
use slideway::trial::plan::plan;
use slideway::trial::runs::{Movement, TrialRun};
use slideway::trial::seal::is_open;
use slideway::trial::{CommittedVerdicts, Seed, Tier, Trial};
use slideway::twin::{Sensing, Twin};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn grinder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")
}

fn machine() -> Machine {
    Machine::read(&grinder()).unwrap()
}

fn slideway(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_slideway")).arg("trial").args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// What a refusal says on standard error, on one line.
fn refusal(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(2), "{}{}", text(&output.stdout), text(&output.stderr));
    text(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ")
}

fn forge(out: &Path, seed: &str, tier: &str, cases: &str) -> Output {
    let machine = grinder();
    slideway(&[
        "forge",
        "--machine",
        machine.to_str().unwrap(),
        "--seed",
        seed,
        "--tier",
        tier,
        "--cases",
        cases,
        "--engine",
        "axis",
        "--out",
        out.to_str().unwrap(),
    ])
}

fn forged(out: &Path, seed: &str, tier: &str, cases: &str) -> Trial {
    let output = forge(out, seed, tier, cases);
    assert!(output.status.success(), "{}", text(&output.stderr));
    Trial::read(out).unwrap()
}

fn ran(trial: &Trial) -> String {
    let output = slideway(&["run", trial.folder.to_str().unwrap()]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout)
}

fn score(trial: &Trial) -> Output {
    slideway(&["score", trial.folder.to_str().unwrap()])
}

/// Every file below a folder with its content.
fn content(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let (mut files, mut open) = (BTreeMap::new(), vec![folder.to_path_buf()]);
    while let Some(inner) = open.pop() {
        for entry in std::fs::read_dir(inner).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_path_buf();
                files.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    files
}

#[test]
fn exact_seeds_for_developing_and_for_judging_are_apart() {
    assert_eq!(Seed::new(999).unwrap().kind(), "development");
    assert_eq!(Seed::new(1_000_000).unwrap().kind(), "judging");
    for number in [1_000, 999_999, u64::MAX] {
        let error = Seed::new(number).unwrap_err();
        assert!(error.remedy_text().is_some(), "{error}");
    }
}

/// A trial from end to end: the hash that is printed is the file's, the recordings are as any other, nothing sealed is
/// needed to diagnose, and the score adds up.
#[test]
fn exact_trial_from_end_to_end() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("trial");
    let printed = text(&forge(&out, "42", "single", "1").stdout);
    let trial = Trial::read(&out).unwrap();
    let truth = std::fs::read(Trial::truth_file(&out)).unwrap();
    let hash = slideway::trial::folder::sha256(&truth);
    assert_eq!(trial.announcement.truth_sha256, hash);
    assert!(printed.starts_with(&format!("truth sealed, SHA-256 {hash}")), "{printed}");
    assert!(printed.contains("seed 42 (development)"), "{printed}");
    // What a diagnosis is given tells nothing of the truth.
    let public = content(&out.join("cases"));
    let toml = public.iter().filter(|(name, _)| name.extension().is_some_and(|e| e == "toml"));
    for (name, text) in
        toml.chain([(&PathBuf::from("trial.toml"), &std::fs::read(out.join("trial.toml")).unwrap())])
    {
        let text = String::from_utf8_lossy(text);
        // What this machine cannot have is told.
        let skipped = |effect: &EffectId| trial.announcement.skipped.iter().any(|one| one.effect == *effect);
        // So is what the twin knows of the guide's friction.
        let known = |effect: &EffectId| {
            let is_friction = [EffectId::CoulombFriction, EffectId::Presliding].contains(effect);
            is_friction && text.contains(&format!("\"effect.{}.", effect.name()))
        };
        for effect in EffectId::ALL.iter().filter(|effect| !skipped(effect) && !known(effect)) {
            assert!(!text.contains(effect.name()), "{} in {}", effect.name(), name.display());
        }
    }
    assert!(!Recording::read(trial.case_folder(1)).unwrap().runs().is_empty());
    let sealed = out.join("sealed");
    let away = folder.path().join("sealed");
    std::fs::rename(&sealed, &away).unwrap();
    assert!(ran(&trial).contains("1 verdicts committed, 0 before"));
    std::fs::rename(&away, &sealed).unwrap();
    let [json, svg] = ["score.json", "confusion.svg"].map(|name| folder.path().join(name));
    let output = slideway(&[
        "score",
        out.to_str().unwrap(),
        "--json",
        json.to_str().unwrap(),
        "--figure",
        svg.to_str().unwrap(),
    ]);
    let shown = text(&output.stdout);
    println!("{shown}");
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(is_open(&trial));
    assert!(shown.contains("A development seed") && shown.contains("not measured"), "{shown}");
    let score: serde_json::Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    assert_eq!(score["schema"], "slideway-score/2");
    assert_eq!(score["cases"].as_array().unwrap().len(), 1);
    let right = score["cases"].as_array().unwrap().iter().filter(|case| case["top_1"] == true).count();
    assert_eq!(score["tiers"][0]["top_1"]["hits"], right);
    let drawn = std::fs::read_to_string(&svg).unwrap();
    assert!(drawn.starts_with("<svg") && drawn.ends_with("</svg>\n"));
}

/// From one seed the same bytes, also where a kill left a part of them.
#[test]
fn exact_forging_is_reproducible_and_goes_on_after_a_kill() {
    let folder = tempfile::tempdir().unwrap();
    let [one, other] = ["one", "other"].map(|name| folder.path().join(name));
    forged(&one, "4", "null", "3");
    let trial = forged(&other, "4", "null", "3");
    let whole = content(&one);
    assert_eq!(whole, content(&other));
    std::fs::remove_dir_all(trial.case_folder(2)).unwrap();
    std::fs::remove_file(other.join("cases/003.case.toml")).unwrap();
    forged(&other, "4", "null", "3");
    assert_eq!(whole, content(&other));
    // Killed between seal and announcement.
    std::fs::remove_dir_all(other.join("cases")).unwrap();
    std::fs::remove_file(other.join("trial.toml")).unwrap();
    forged(&other, "4", "null", "3");
    assert_eq!(whole, content(&other));
    let refused = refusal(&forge(&other, "5", "null", "3"));
    assert!(refused.contains("trial.toml") && refused.contains("seed 4 where 5 is ordered"), "{refused}");
}

/// The seal opens for committed verdicts only, and for no others afterwards.
#[test]
fn exact_seal_opens_for_committed_verdicts_only() {
    let folder = tempfile::tempdir().unwrap();
    let trial = forged(&folder.path().join("trial"), "6", "null", "2");
    let refused = refusal(&score(&trial));
    assert!(refused.contains("no verdict on 2 of 2 cases") && refused.contains("trial run"), "{refused}");
    assert!(CommittedVerdicts::read(&trial).is_err() && !is_open(&trial));
    ran(&trial);
    // Half of the verdicts lost: the rest stands, the lost ones come out the same.
    let before = content(&trial.verdicts());
    std::fs::remove_file(trial.verdicts().join("002.json")).unwrap();
    assert!(refusal(&score(&trial)).contains("no verdict on 1 of 2 cases"));
    assert!(ran(&trial).contains("1 verdicts committed, 1 before"));
    let after = content(&trial.verdicts());
    for verdict in ["001.json", "002.json"].map(PathBuf::from) {
        assert_eq!(before[&verdict], after[&verdict], "{}", verdict.display());
    }
    // A verdict changed after it was committed, and a truth changed after it was sealed.
    let verdict = trial.verdicts().join("001.json");
    let mut changed = after[Path::new("001.json")].clone();
    changed.push(b'\n');
    std::fs::write(&verdict, &changed).unwrap();
    let refused = refusal(&score(&trial));
    assert!(refused.contains("001.json") && refused.contains("changed after it was committed"), "{refused}");
    assert!(refusal(&slideway(&["run", trial.folder.to_str().unwrap()])).contains("001.json"));
    std::fs::write(&verdict, &after[Path::new("001.json")]).unwrap();
    let truth_file = Trial::truth_file(&trial.folder);
    let truth = std::fs::read(&truth_file).unwrap();
    std::fs::write(&truth_file, [truth.as_slice(), b" "].concat()).unwrap();
    assert!(refusal(&score(&trial)).contains("changed after it was sealed") && !is_open(&trial));
    std::fs::write(&truth_file, &truth).unwrap();
    // Open: the same score again, but no verdict any more.
    let first = score(&trial);
    assert!(first.status.success(), "{}", text(&first.stderr));
    assert_eq!(first.stdout, score(&trial).stdout);
    std::fs::remove_file(&verdict).unwrap();
    let refused = refusal(&slideway(&["run", trial.folder.to_str().unwrap()]));
    assert!(refused.contains("seal is open") && refused.contains("another seed"), "{refused}");
    let forget = trial.verdicts().join("committed.json");
    std::fs::write(&verdict, &after[Path::new("001.json")]).unwrap();
    let ledger = std::fs::read_to_string(&forget).unwrap();
    std::fs::write(&forget, ledger.replacen("\"seconds\": ", "\"seconds\": 1", 1)).unwrap();
    assert!(refusal(&score(&trial)).contains("other than those that the seal was opened against"));
}

#[test]
fn exact_wrong_inputs_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().to_str().unwrap();
    for step in ["run", "score"] {
        let refused = refusal(&slideway(&[step, place]));
        assert!(refused.contains("trial.toml") && refused.contains("trial forge"), "{refused}");
    }
    std::fs::write(folder.path().join("diary.txt"), "mine").unwrap();
    let refused = refusal(&forge(folder.path(), "1", "null", "1"));
    assert!(refused.contains("no trial") && refused.contains("another folder"), "{refused}");
    let refused = refusal(&forge(&folder.path().join("a"), "5000", "null", "1"));
    assert!(refused.contains("1000000"), "{refused}");
    let loose = folder.path().join("loose");
    std::fs::create_dir(&loose).unwrap();
    let text = std::fs::read_to_string(grinder().join("machine.toml")).unwrap();
    let (head, rest) = text.split_once("[controller]").unwrap();
    let (_, tail) = rest.split_once("[motor]").unwrap();
    std::fs::copy(grinder().join("machine.urdf"), loose.join("machine.urdf")).unwrap();
    std::fs::create_dir(loose.join("meshes")).unwrap();
    for mesh in std::fs::read_dir(grinder().join("meshes")).unwrap().flatten() {
        std::fs::copy(mesh.path(), loose.join("meshes").join(mesh.file_name())).unwrap();
    }
    std::fs::write(loose.join("machine.toml"), format!("{head}[motor]{tail}")).unwrap();
    let out = folder.path().join("out");
    let refused = refusal(&slideway(&[
        "forge",
        "--machine",
        loose.to_str().unwrap(),
        "--seed",
        "1",
        "--out",
        out.to_str().unwrap(),
    ]));
    assert!(refused.contains("controller") && refused.contains("state the control law"), "{refused}");
    assert!(!out.exists());
}

/// Two effects of a pair can act beside each other, and tiers are filled evenly.
#[test]
fn exact_plan_is_even_and_pairs_are_possible() {
    let (machine, seed) = (machine(), Seed::new(2).unwrap());
    let logged = logged(&machine);
    let equal = |a, b| equals(a, &machine, &logged).contains(&b);
    let planned = plan(seed, &Tier::ALL, None, EffectId::ALL, &logged, &equal);
    let of = |tier: Tier| planned.iter().filter(move |p| p.tier == tier);
    for &effect in EffectId::ALL {
        assert_eq!(of(Tier::Single).filter(|p| p.effects == [effect]).count(), 5, "{}", effect.name());
        assert_eq!(of(Tier::Outside).filter(|p| p.effects == [effect]).count(), 1, "{}", effect.name());
    }
    assert_eq!((of(Tier::Null).count(), of(Tier::Pair).count(), of(Tier::Triple).count()), (300, 40, 40));
    for pair in of(Tier::Pair) {
        let [a, b] = pair.effects[..] else { panic!("{pair:?}") };
        assert!(
            a != b && !a.modifies().contains(&b) && !b.modifies().contains(&a) && !equal(a, b),
            "{pair:?}"
        );
        assert!(pair.spare.len() == 3, "{pair:?}");
        // What a case falls back on is no other case's turn.
        assert!(of(Tier::Pair).all(|other| !pair.spare.contains(&other.effects)), "{pair:?}");
    }
    for triple in of(Tier::Triple) {
        let [a, b, c] = triple.effects[..] else { panic!("{triple:?}") };
        let is_pair = |a: EffectId, b: EffectId| {
            a != b && !a.modifies().contains(&b) && !b.modifies().contains(&a) && !equal(a, b)
        };
        assert!(is_pair(a, b) && is_pair(a, c) && is_pair(b, c), "{triple:?}");
    }
    assert!(of(Tier::Single).all(|p| p.spare.is_empty()));
    assert!(of(Tier::Missing).all(|p| p.missing.len() == 1));
    let signals: Vec<Signal> = of(Tier::Missing).map(|p| p.missing[0]).collect();
    assert!([Signal::Current, Signal::ControlEffort, Signal::Velocity].iter().all(|s| signals.contains(s)));
}

#[test]
fn exact_equals_are_struck() {
    let machine = machine();
    let signals = logged(&machine);
    assert_eq!(equals(EffectId::ForceConstant, &machine, &signals), [EffectId::EncoderScale]);
    let with_force = [signals.clone(), vec![Signal::Thrust]].concat();
    assert!(equals(EffectId::ForceConstant, &machine, &with_force).is_empty());
    assert!(equals(EffectId::AmplifierOffset, &machine, &signals).is_empty());
    let struck = struck(EffectId::CoulombFriction, &machine, &signals);
    // Without friction to modify, no feature of it is looked for.
    assert_eq!(struck, [EffectId::CoulombFriction, EffectId::LoadDependentFriction]);
}

/// f·Kt·i = m·a + c·v is Kt·i = (m/f)·a + (c/f)·v: unless a force is logged, a payload is what a force constant would be.
#[test]
fn exact_payload_is_struck_with_the_force_constant() {
    let machine = machine();
    let signals = logged(&machine);
    let with_force = [signals.clone(), vec![Signal::Thrust]].concat();
    for effect in [EffectId::ForceConstant, EffectId::EncoderScale, EffectId::Payload] {
        let gone = struck(effect, &machine, &signals);
        assert_eq!(gone, [EffectId::ForceConstant, EffectId::Payload, EffectId::EncoderScale], "{gone:?}");
        assert_eq!(struck(effect, &machine, &with_force), [effect]);
    }
}

const OTHERWISE: Otherwise = Otherwise::bristles(4e-8, 0.7);

fn strokes() -> TrialRun {
    TrialRun {
        name: "run".to_owned(),
        role: Some(Role::Training),
        begins_s: 0.0,
        from: 0.0,
        movement: Movement::Strokes { stroke: 0.03, feed: 0.1333, dwell_s: 0.2 },
    }
}

/// Without laws of its own, the forging plant is the plant inside.
#[test]
fn exact_forging_adds_nothing_where_nothing_is_hidden() {
    let machine = machine();
    let reference = strokes().reference(&machine);
    let forged = sketch(&machine, &OTHERWISE, &reference, 0.0).unwrap();
    let plant = Axis::new(&machine.constants(), SKETCH_STEP_S);
    let mut twin = Twin::new(&machine, plant, Sensing::Perfect);
    let period_s = machine.description().sample_period_s;
    let standing = vec![reference[0]; 4000];
    walk(&mut twin, follow(&standing, period_s), |_| ());
    assert_eq!(forged, walk(&mut twin, follow(&reference, period_s), |_| ()));
}

/// Stiff bristles are Coulomb friction, up to their deflection.
#[test]
fn exact_stiff_bristles_are_coulomb_friction() {
    let machine = machine();
    let real = machine.with_settings([("effect.coulomb_friction.force_n", 15.0.into())]).unwrap();
    let reference = strokes().reference(&machine);
    let forged = sketch(&real, &OTHERWISE, &reference, 0.0).unwrap();
    let plain = sketch(&machine, &OTHERWISE, &reference, 0.0).unwrap();
    let mut twin = Twin::new(&real, Axis::new(&real.constants(), SKETCH_STEP_S), Sensing::Perfect);
    let period_s = machine.description().sample_period_s;
    walk(&mut twin, follow(&vec![0.0; 4000], period_s), |_| ());
    let coulomb = walk(&mut twin, follow(&reference, period_s), |_| ());
    let rms = |a: &[f64], b: &[f64]| {
        (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
    };
    let (left, effect) = (rms(&forged.position, &coulomb.position), rms(&plain.position, &coulomb.position));
    println!("friction moves the table by {effect:.2e} m, bristles differ by {left:.2e} m");
    // Deflection of the bristles and the way in which they come to rest.
    assert!(left < 0.02 * effect, "{left} of {effect}");
}
