//! Reports as pages: self-contained, in the order of the questions, with numbers that need no script.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use slideway::diagnose::check::{Check, Finding, Severity};
use slideway::diagnose::{Diagnosis, Options, diagnose};
use slideway::effect::EffectId;
use slideway::machine::Machine;
use slideway::recording::Recording;
use slideway::report::material::partial::{Partial, Quantity};
use slideway::report::material::{Material, RunTraces};
use slideway::report::{html, sentence};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use tempfile::TempDir;

const SLIDEWAY: &str = env!("CARGO_BIN_EXE_slideway");
/// What the issue of a page on a shop floor's computer allows.
const MOST_BYTES: usize = 5_000_000;
/// Sections of a diagnosis in the order in which a servo engineer asks.
const ORDER: [&str; 11] = [
    "extent",
    "budget",
    "where",
    "machine",
    "traces",
    "force",
    "spectrum",
    "hypotheses",
    "checks",
    "next",
    "provenance",
];
const COMMAND: &str = "slideway diagnose assets/hidden_coulomb --html report.html";

struct Made {
    machine: Machine,
    diagnosis: Diagnosis,
    material: Material,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The shipped recording, diagnosed among a few effects.
fn made() -> &'static Made {
    static MADE: OnceLock<Made> = OnceLock::new();
    MADE.get_or_init(|| {
        let machine = Machine::read(&root().join("models/grinder")).unwrap();
        let recording = Recording::read(root().join("assets/hidden_coulomb")).unwrap();
        let catalogue = [EffectId::CoulombFriction, EffectId::LoadDependentFriction, EffectId::Payload];
        let options = Options { catalogue: &catalogue, ..Options::default() };
        let diagnosis = diagnose(&machine, &recording, &options).unwrap();
        let material = Material::of(&machine, &recording, &diagnosis).unwrap();
        Made { machine, diagnosis, material }
    })
}

fn page() -> &'static str {
    static PAGE: OnceLock<String> = OnceLock::new();
    PAGE.get_or_init(|| {
        let Made { machine, diagnosis, material } = made();
        html::diagnosis(diagnosis, machine, material, COMMAND).html
    })
}

/// What is seen without a script.
fn still(page: &str) -> &str {
    let body = page.split_once("<body>").unwrap().1;
    body.split_once("<script").unwrap().0
}

/// Words as they are read: no markup, lines may break anywhere.
fn words(page: &str) -> String {
    let mut out = String::new();
    let mut is_tag = false;
    for letter in still(page).chars() {
        match letter {
            '<' => is_tag = true,
            '>' => is_tag = false,
            '\u{a0}' => out.push(' '),
            c if !is_tag => out.push(c),
            _ => {}
        }
    }
    out.replace("&gt;", ">").replace("&lt;", "<").replace("&#39;", "'").replace("&amp;", "&")
}

fn run(arguments: &[&str]) -> Output {
    Command::new(SLIDEWAY).args(arguments).current_dir(root()).env_remove("COLUMNS").output().unwrap()
}

fn assert_fetches_nothing(page: &str, what: &str) {
    // What a reader saves is made in the page.
    let lower = page.to_lowercase().replace("createobjecturl(", "").replace("revokeobjecturl(", "");
    for word in [
        "http:",
        "https:",
        "src=",
        "url(",
        "@import",
        "@font-face",
        "<link",
        "<iframe",
        "fetch(",
        "xmlhttp",
        "import(",
    ] {
        assert!(!lower.contains(word), "{what} contains {word}");
    }
    for (at, _) in page.match_indices("href=\"") {
        assert!(page[at + 6..].starts_with('#'), "{what}: {}", &page[at..at + 40]);
    }
}

#[test]
fn exact_a_page_fetches_nothing() {
    assert_fetches_nothing(page(), "the page");
}

#[test]
fn exact_sections_stand_in_the_order_of_the_questions() {
    let places: Vec<usize> = ORDER
        .iter()
        .map(|id| page().find(&format!("<section id=\"{id}\">")).unwrap_or_else(|| panic!("no section {id}")))
        .collect();
    assert!(places.windows(2).all(|w| w[0] < w[1]), "{places:?}");
    let first = page().find("<h1>").unwrap();
    assert!(first < places[0]);
}

#[test]
fn exact_numbers_stand_without_a_script() {
    let Made { machine, diagnosis, .. } = made();
    let words = words(page());
    assert!(words.contains(&sentence(diagnosis, machine.motion())), "{}", &words[..800]);
    for word in [&diagnosis.data.sha256[..], &diagnosis.data.training[0], COMMAND] {
        assert!(words.contains(word), "{word}");
    }
    for label in [
        "time in s",
        "frequency in Hz",
        "speed in m/min",
        "position in mm",
        "acceleration in m/s²",
        "held out",
        "training",
    ] {
        assert!(words.contains(label), "{label}");
    }
    // Every figure in both widths.
    let count = |class: &str| still(page()).matches(&format!("<svg class=\"fig {class}\"")).count();
    assert!(count("wide") >= 12 && count("wide") == count("narrow"), "{} {}", count("wide"), count("narrow"));
    assert!(!still(page()).contains("NaN") && !still(page()).contains("inf "));
}

/// What is drawn is recomputed; it is the same sum over the same samples.
const SAME: f64 = 1e-9;

/// RMS of recorded less predicted on the held-out runs of a material, before and after.
fn drawn(material: &Material, key: &str) -> [f64; 2] {
    let held_out = material.runs.iter().filter(|run| run.is_held_out);
    let traces = held_out.flat_map(|run| &run.traces).filter(|t| t.signal.key(material.motion) == key);
    let (mut sums, mut count) = ([0.0, 0.0], 0.0);
    for trace in traces {
        for (k, measured) in trace.measured.iter().enumerate() {
            sums[0] += (measured - trace.before[k]).powi(2);
            sums[1] += (measured - trace.after[k]).powi(2);
            count += 1.0;
        }
    }
    sums.map(|sum: f64| (sum / count).sqrt())
}

fn assert_drawn_as_judged(material: &Material, diagnosis: &Diagnosis) {
    for gap in &diagnosis.gap.signals {
        let [before, after] = drawn(material, &gap.signal);
        assert!(
            (before / gap.rms_before - 1.0).abs() < SAME,
            "{}: {before} for {}",
            gap.signal,
            gap.rms_before
        );
        assert!((after / gap.rms_after - 1.0).abs() < SAME, "{}: {after} for {}", gap.signal, gap.rms_after);
    }
}

#[test]
fn exact_what_is_drawn_is_what_was_judged() {
    let Made { diagnosis, material, .. } = made();
    assert_drawn_as_judged(material, diagnosis);
    // Coulomb friction of 15 N: what the twin lacks over speed is a step of that height.
    let force = material.force.as_ref().unwrap();
    let [forward, backward] = force.law_over(&force.velocity);
    for (law, wanted) in [(forward, -15.0), (backward, 15.0)] {
        assert!(law.len() > 10 && law.iter().all(|[_, y]| (y - wanted).abs() < 0.5), "{law:?}");
    }
}

/// The matrix is one of correlations, its parameters are those that the verdict states, and every compared signal is tested.
#[test]
fn exact_the_page_shows_identifiability_whiteness_and_partial_residuals() {
    let Made { diagnosis, material, .. } = made();
    let identifiability = &diagnosis.identifiability;
    let force =
        identifiability.parameters.iter().find(|n| n.path == "effect.coulomb_friction.force_n").unwrap();
    let stated = &diagnosis.causes[0].parameters["force_n"];
    let half = 0.5 * (stated.ci95[1] - stated.ci95[0]) / stated.value;
    assert!((force.relative_half_width.unwrap() / half - 1.0).abs() < 1e-9, "{force:?}");
    for (i, row) in identifiability.correlation.iter().enumerate() {
        assert_eq!((row.len(), row[i]), (identifiability.parameters.len(), 1.0));
        assert!(row.iter().enumerate().all(|(j, r)| (r - identifiability.correlation[j][i]).abs() < 1e-12));
    }
    let compared: Vec<&str> = diagnosis.gap.signals.iter().map(|gap| gap.signal.as_str()).collect();
    let tested: Vec<&str> = diagnosis.residual_whiteness.iter().map(|of| of.signal.as_str()).collect();
    assert!(compared.iter().all(|signal| tested.contains(signal)), "{compared:?} {tested:?}");
    let [Partial::Force(partial)] = &material.partials[..] else { panic!("{:?}", material.partials.len()) };
    let (quantity, over) = partial.over.as_ref().unwrap();
    assert_eq!(*quantity, Quantity::Velocity);
    assert!(over.curves[0].iter().all(|[v, law]| *v > 0.0 && (law + 15.0).abs() < 0.5));
    let after = &material.force.as_ref().unwrap().after;
    let sum = partial.law.iter().zip(after).zip(&partial.lacking);
    assert!(
        partial.law.len() > 1000 && sum.into_iter().all(|((law, left), all)| (law + left - all).abs() < 1e-9)
    );
    let words = words(page());
    for word in ["Identifiability of the parameters", "Residual whiteness", "Ljung", "dB", "95 % band"] {
        assert!(words.contains(word), "{word}");
    }
}

#[test]
fn exact_a_comparison_is_drawn_against_the_reference() {
    let folder = TempDir::new().unwrap();
    let recorded = |name: &str, friction: &str| {
        let out = folder.path().join(name);
        let hide = format!("effect.coulomb_friction.force_n={friction}");
        let output = run(&[
            "replay",
            "--machine",
            "models/grinder",
            "--plant",
            "axis",
            "--cell",
            "0.02@8",
            "--held-out",
            "0.03@8",
            "--return",
            "--dwell",
            "0.2",
            "--hide",
            &hide,
            "--out",
            out.to_str().unwrap(),
        ]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        Recording::read(&out).unwrap()
    };
    let (before, after) = (recorded("before", "12"), recorded("after", "18"));
    let machine = Machine::read(&root().join("models/grinder")).unwrap();
    let options = Options { catalogue: &[EffectId::CoulombFriction], ..Options::default() };
    let change = slideway::diagnose::compare(&machine, &before, &after, &options).unwrap();
    let material = Material::of(&machine, &after, &change).unwrap();
    assert_drawn_as_judged(&material, &change);
    let page = html::diagnosis(&change, &machine, &material, COMMAND).html;
    assert!(
        page.contains("<section id=\"changes\">") && words(&page).contains("Changed since the reference")
    );
}

#[test]
fn exact_what_comes_from_files_is_escaped() {
    let Made { machine, diagnosis, material } = made();
    let nasty = "</script><script>alert(1)</script><img src=x onerror='alert(\"2\")'>&";
    let (mut diagnosis, mut material) = (diagnosis.clone(), material.clone());
    diagnosis.data.machine = nasty.to_owned();
    diagnosis.data.note = Some(nasty.to_owned());
    diagnosis.data.training[0] = nasty.to_owned();
    diagnosis.causes[0].effect = nasty.to_owned();
    diagnosis.causes[0].confusable_with = vec![nasty.to_owned()];
    let finding = Finding {
        run: nasty.to_owned(),
        check: Check::Clipping,
        severity: Severity::Warning,
        signal: None,
        message: nasty.to_owned(),
    };
    diagnosis.checks.push(finding);
    for run in &mut material.runs {
        run.name = nasty.to_owned();
    }
    material.shape.surfaces[0].name = nasty.to_owned();
    let page = html::diagnosis(&diagnosis, machine, &material, nasty);
    assert!(!page.html.contains("<img") && !page.html.contains("<script>alert"));
    assert_eq!(page.html.matches("</script>").count(), 2);
    for figure in &page.figures {
        assert!(!figure.file().contains("<img"), "{}", figure.name);
        assert!(figure.name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_'), "{}", figure.name);
    }
}

#[test]
fn exact_units_are_those_of_the_shop_floor() {
    let words = words(page());
    for unit in [" mm", " µm", "m/min", " N", " Hz", " mV"] {
        assert!(words.contains(unit), "{unit}");
    }
    assert!(!words.contains("N·m") && !words.contains("rad"));
}

#[test]
fn exact_a_turning_axis_is_in_rad_and_newton_metres() {
    let folder = TempDir::new().unwrap();
    let (out, file) = (folder.path().join("run"), folder.path().join("page.html"));
    let (out, file) = (out.to_str().unwrap(), file.to_str().unwrap());
    let made = run(&[
        "replay",
        "--machine",
        "models/delta_a3",
        "--plant",
        "axis",
        "--cell",
        "3@20",
        "--out",
        out,
        "--html",
        file,
    ]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let page = std::fs::read_to_string(file).unwrap();
    let words = words(&page);
    assert!(words.contains("N·m") && words.contains("rad/s"), "{words}");
    assert!(!words.contains("m/min") && !words.contains(" mm"), "{words}");
    assert_fetches_nothing(&page, "the replay");
}

/// Eight runs of so many samples, from the ones there are.
fn eight_runs(samples: usize) -> Material {
    let mut material = made().material.clone();
    let stretched = |run: &RunTraces, k: usize| {
        let mut run = run.clone();
        let length = run.samples();
        let repeat = |list: &[f64]| -> Vec<f64> {
            (0..samples).map(|n| list[(n + 17 * k) % length] * (1.0 + 1e-3 * (n as f64).sin())).collect()
        };
        for trace in &mut run.traces {
            trace.measured = repeat(&trace.measured);
            trace.before = repeat(&trace.before);
            trace.after = repeat(&trace.after);
        }
        run.reference = repeat(&run.reference);
        run.name = format!("{}_{k}", run.name);
        run
    };
    let runs: Vec<RunTraces> =
        (0..8).map(|k| stretched(&material.runs[k % material.runs.len()], k)).collect();
    material.runs = runs;
    material
}

#[test]
fn exact_large_recordings_make_no_larger_page() {
    let Made { machine, diagnosis, .. } = made();
    for samples in [5_000, 200_000] {
        let page = html::diagnosis(diagnosis, machine, &eight_runs(samples), COMMAND);
        assert!(page.html.len() < MOST_BYTES, "{} bytes for {samples} samples", page.html.len());
    }
}

#[test]
fn exact_figures_are_files_for_papers() {
    let Made { machine, diagnosis, material } = made();
    let page = html::diagnosis(diagnosis, machine, material, COMMAND);
    let mut names: Vec<&str> = page.figures.iter().map(|figure| figure.name.as_str()).collect();
    for wanted in ["extent", "budget", "path", "where", "force", "spectrum", "response", "machine"] {
        assert!(names.contains(&wanted), "{wanted} of {names:?}");
    }
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), count, "two figures of one name");
    for figure in &page.figures {
        let text = figure.file();
        assert!(text.starts_with("<svg ") && text.trim_end().ends_with("</svg>"), "{}", figure.name);
        assert_eq!(text.matches("http").count(), 1, "{}: the name space and nothing else", figure.name);
        assert_eq!(text.matches("<text").count(), text.matches("</text>").count(), "{}", figure.name);
        assert!(!text.contains("NaN"), "{}", figure.name);
    }
}

fn folder_of(list: &[&str]) -> (TempDir, Vec<PathBuf>) {
    let folder = TempDir::new().unwrap();
    let paths = list.iter().map(|name| folder.path().join(name)).collect();
    (folder, paths)
}

#[test]
fn exact_a_place_that_cannot_be_written_is_refused() {
    let (folder, paths) = folder_of(&["nowhere/page.html"]);
    let path = paths[0].to_str().unwrap();
    for arguments in [
        vec!["diagnose", "assets/hidden_coulomb", "--html", path],
        vec!["inspect", "models/grinder", "--html", path],
        vec!["crosscheck", "models/grinder", "--html", path],
        vec!["identify", "--machine", "models/grinder", "--html", path],
    ] {
        let output = run(&arguments);
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(told.contains("page.html") && told.contains("make the folder first"), "{told}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn exact_an_input_or_another_output_in_the_place_of_the_page_is_refused() {
    let (folder, paths) = folder_of(&["machine.toml", "page.html"]);
    std::fs::write(&paths[0], "name = 1").unwrap();
    let text: Vec<&str> = paths.iter().map(|path| path.to_str().unwrap()).collect();
    let beside = folder.path().join("./page.html");
    for (arguments, word) in [
        (vec!["inspect", "models/grinder", "--html", text[0]], "holds no input"),
        (vec!["identify", "--machine", "models/grinder", "--html", text[0]], "holds no input"),
        (
            vec!["diagnose", "assets/hidden_coulomb", "--html", text[1], "--json", beside.to_str().unwrap()],
            "the place that --html writes",
        ),
    ] {
        let output = run(&arguments);
        let told = String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(output.status.code() == Some(2) && told.contains(word), "{told}");
    }
    assert_eq!(std::fs::read_to_string(&paths[0]).unwrap(), "name = 1");
    assert!(!paths[1].exists());
}

#[test]
fn exact_a_file_in_the_place_of_the_figures_is_refused() {
    let (_folder, paths) = folder_of(&["figures"]);
    std::fs::write(&paths[0], "not a folder").unwrap();
    let output = run(&["inspect", "models/grinder", "--figures", paths[0].to_str().unwrap()]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && told.contains("name another folder"), "{told}");
}

#[test]
fn exact_every_command_makes_its_page() {
    let (_folder, paths) =
        folder_of(&["machine.html", "recording.html", "identified.html", "figures", "crosscheck.html"]);
    let text: Vec<&str> = paths.iter().map(|path| path.to_str().unwrap()).collect();
    for (arguments, file, wanted) in [
        (
            vec!["inspect", "models/grinder", "--html", text[0], "--figures", text[3]],
            0,
            ["Base modes", "moving mass"],
        ),
        (vec!["inspect", "assets/hidden_coulomb", "--html", text[1]], 1, ["Signals", "Frequency response"]),
        (vec!["identify", "--machine", "models/grinder", "--html", text[2]], 2, ["W(z)", "phase"]),
        (
            vec!["crosscheck", "models/grinder", "--cell", "0.02@8", "--html", text[4]],
            4,
            ["Within bounds", "damping ratio 5"],
        ),
    ] {
        let output = run(&arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(!output.stdout.is_empty(), "the terminal's report stays");
        let page = std::fs::read_to_string(&paths[file]).unwrap();
        assert_fetches_nothing(&page, text[file]);
        let words = words(&page);
        for word in wanted {
            assert!(words.contains(word), "{} without {word}", text[file]);
        }
    }
    let figures: Vec<_> = std::fs::read_dir(&paths[3]).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(figures.iter().any(|name| name == "base.svg"), "{figures:?}");
}

#[test]
fn exact_json_on_standard_output_stays_alone() {
    let (_folder, paths) = folder_of(&["page.html"]);
    let mut arguments =
        vec!["diagnose", "assets/hidden_coulomb", "--json", "-", "--html", paths[0].to_str().unwrap()];
    for effect in EffectId::ALL.iter().filter(|effect| **effect != EffectId::CoulombFriction) {
        arguments.extend(["--without", effect.name()]);
    }
    let output = run(&arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let verdict: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(verdict["schema"], "slideway-diagnosis/1");
    assert!(paths[0].is_file());
}

#[test]
fn exact_without_a_gap_there_is_nothing_to_share_out() {
    let Made { machine, diagnosis, material } = made();
    let mut quiet = diagnosis.clone();
    quiet.verdict = slideway::diagnose::Verdict::NoGap;
    quiet.causes.clear();
    quiet.next_experiment = None;
    let page = html::diagnosis(&quiet, machine, material, COMMAND);
    let words = words(&page.html);
    assert!(words.contains("nothing to share out") && !page.html.contains("<section id=\"where\">"));
}
