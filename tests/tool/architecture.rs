//! The shape of the crate: modules import in one direction, the library does not print, no machine is
//! named in it, and no file or folder grows where none should.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use super::imports::{Imports, Modules, circles};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Every module of the crate; one may import from itself and from those before it.
const ORDER: [&str; 25] = [
    "error",
    "confine",
    "singular",
    "whole",
    "units",
    "elementary",
    "recording",
    "identify",
    "solid",
    "controller",
    "drive",
    "sensor",
    "base",
    "guide",
    "effect",
    "machine",
    "init",
    "plant",
    "twin",
    "replay",
    "tune",
    "diagnose",
    "trial",
    "report",
    "cli",
];
/// Modules of the order that need not exist: the crate may be built without them.
const OPTIONAL: [&str; 5] = ["tune", "diagnose", "trial", "report", "cli"];
/// Where printing is the purpose.
const MAY_PRINT: [&str; 3] = ["cli", "report", "main"];
const PRINTING: [&str; 7] = ["println!", "eprintln!", "print!", "eprint!", "dbg!", "todo!", "unimplemented!"];
const MACHINES: [&str; 8] = ["grinder", "emps", "fgp", "chevalier", "kollmorgen", "akd", "delta_a3", "servo"];
/// Those that are words of the field: prose may use them, code may not.
const FIELD_WORDS: [&str; 1] = ["servo"];
/// A file beyond this holds more than one law or concern.
const MOST_LINES: usize = 500;
const TOP_LEVEL: [&str; 9] =
    ["Cargo.toml", "Cargo.lock", "src", "models", "assets", "tests", "benches", "README.md", "CHANGELOG.md"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every Rust file below `folder`, sorted.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// File (relative to `src`), its top-level module and its text.
fn sources() -> Vec<(String, String, String)> {
    let folder = root().join("src");
    let files = rust_files(&folder);
    assert!(files.len() > 20, "only {} files below src", files.len());
    let named = |path: PathBuf| {
        let relative = path.strip_prefix(&folder).unwrap().to_str().unwrap().replace('\\', "/");
        let module = relative.split('/').next().unwrap().trim_end_matches(".rs").to_owned();
        (relative, module, std::fs::read_to_string(&path).unwrap())
    };
    files.into_iter().map(named).collect()
}

/// The text with comments and the contents of string literals blanked; lines stay where they are.
fn code_of(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut code = bytes.to_vec();
    let mut at = 0;
    let mut blank = |from: usize, to: usize| {
        for byte in &mut code[from..to.min(bytes.len())] {
            if *byte != b'\n' {
                *byte = b' ';
            }
        }
    };
    while at < bytes.len() {
        let rest = &text.as_bytes()[at..];
        let end = if rest.starts_with(b"//") {
            at + rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len())
        } else if rest.starts_with(b"/*") {
            at + text[at..].find("*/").map_or(rest.len(), |n| n + 2)
        } else if rest.starts_with(b"r\"") || rest.starts_with(b"r#") {
            let hashes = rest[1..].iter().take_while(|b| **b == b'#').count();
            let raw = rest.get(1 + hashes) == Some(&b'"');
            let close = format!("\"{}", "#".repeat(hashes));
            let from = at + 2 + hashes;
            if raw { text[from..].find(&close).map_or(text.len(), |n| from + n + close.len()) } else { at }
        } else if rest[0] == b'"' {
            let mut end = at + 1;
            while end < bytes.len() && bytes[end] != b'"' {
                end += if bytes[end] == b'\\' { 2 } else { 1 };
            }
            end + 1
        } else if rest.starts_with(b"'\"'") || rest.starts_with(b"'\\\"'") {
            at + 3
        } else {
            at
        };
        blank(at, end);
        at = end.max(at + 1);
    }
    String::from_utf8(code).unwrap()
}

/// Line number (from 1) of a byte.
fn line_of(text: &str, at: usize) -> usize {
    text[..at].matches('\n').count() + 1
}

fn identifier(text: &str) -> &str {
    let text = text.trim_start();
    &text[..text.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(text.len())]
}

/// The names that `crate::…` is followed by: one, or each of a brace list.
fn heads(rest: &str) -> Vec<&str> {
    let rest = rest.trim_start();
    let Some(list) = rest.strip_prefix('{') else { return vec![identifier(rest)] };
    let mut names = vec![identifier(list)];
    let mut depth = 1;
    for (at, character) in list.char_indices() {
        match character {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 1 => names.push(identifier(&list[at + 1..])),
            _ => {}
        }
        if depth == 0 {
            break;
        }
    }
    names.retain(|name| !name.is_empty());
    names
}

/// Imports of `text` that point backward: line and import, for a file of `module`.
fn backward_imports(module: &str, text: &str) -> Vec<(usize, String)> {
    let place = |name: &str| ORDER.iter().position(|m| *m == name);
    let own = place(module).unwrap_or_else(|| panic!("module `{module}` is not in the order"));
    let code = code_of(text);
    let mut found = Vec::new();
    for (at, word) in code.match_indices("crate::") {
        if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_') {
            continue;
        }
        for name in heads(&code[at + word.len()..]) {
            if place(name).is_none_or(|imported| imported > own) {
                found.push((line_of(&code, at), format!("crate::{name}")));
            }
        }
    }
    found
}

fn assert_none(what: &str, offences: &[String]) {
    assert!(offences.is_empty(), "{what}:\n{}", offences.join("\n"));
}

#[test]
fn exact_imports_point_one_way() {
    let mut offences = Vec::new();
    for (file, module, text) in sources() {
        if module == "lib" || module == "main" {
            continue;
        }
        for (line, import) in backward_imports(&module, &text) {
            offences.push(format!("src/{file}:{line}: `{module}` imports {import}"));
        }
    }
    assert_none("imports against the order of the modules", &offences);
}

#[test]
fn exact_backward_import_is_caught() {
    let text =
        "//! See [`crate::cli`].\nuse crate::error::Error;\n\nfn f() {\n    crate::replay::run();\n}\n";
    assert_eq!(backward_imports("plant", text), [(5, "crate::replay".to_owned())]);
    let list =
        "use crate::{\n    error::{Error, Result},\n    guide::Guide,\n    twin::{Command, Twin},\n};\n";
    assert_eq!(backward_imports("plant", list), [(1, "crate::twin".to_owned())]);
    assert_eq!(backward_imports("replay", list), []);
    let unknown = "/* crate::cli */ const A: &str = \"crate::cli\"; use crate::helpers::b; // crate::cli\n";
    assert_eq!(backward_imports("cli", unknown), [(1, "crate::helpers".to_owned())]);
}

/// The imports of a circle's files from each other, one a line.
fn ties(imports: &Imports, circle: &[&str]) -> String {
    let of = |file: &&str| {
        let onward = imports[*file].iter().filter(|(other, _)| circle.contains(&other.as_str()));
        let line = |(other, names): (&String, &std::collections::BTreeSet<String>)| {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            format!("\n  src/{file} imports src/{other}: {}", names.join(", "))
        };
        onward.map(line).collect::<String>()
    };
    circle.iter().map(of).collect()
}

#[test]
fn exact_no_two_files_import_each_other_in_a_circle() {
    let sources: Vec<(String, String)> =
        sources().into_iter().map(|(file, _, text)| (file, code_of(&text))).collect();
    let modules = Modules::read(sources.iter().map(|(file, code)| (file.as_str(), code.as_str())));
    let imports = modules.imports();
    let found = circles(&imports);
    let circles = found.iter().map(|circle| format!("{} files:{}", circle.len(), ties(&imports, circle)));
    assert_none("files that import each other in a circle", &circles.collect::<Vec<String>>());
}

/// Circles of a crate of these files.
fn circles_of(files: &[(&str, &str)]) -> Vec<Vec<String>> {
    let code: Vec<(&str, String)> = files.iter().map(|(file, text)| (*file, code_of(text))).collect();
    let modules = Modules::read(code.iter().map(|(file, code)| (*file, code.as_str())));
    let imports = modules.imports();
    circles(&imports).into_iter().map(|circle| circle.into_iter().map(str::to_owned).collect()).collect()
}

#[test]
fn exact_circle_of_imports_is_caught() {
    let lib = ("lib.rs", "pub mod a;\npub mod b;\npub mod c;\n");
    let below = ("a/low.rs", "pub struct Low;\npub fn low() {}\n");
    // Straight, in braces, under another name, and by a path in code.
    for back in [
        "use super::high::High;",
        "use crate::{\n    a::high::{self, High as Other},\n};",
        "fn f() { super::high::high(); }",
        "use super::high;\nfn f() -> Option<high::High> { None }",
        "mod inner { use super::super::high::High; }",
    ] {
        let files = [
            lib,
            ("a/mod.rs", "mod high;\nmod low;\n"),
            ("a/high.rs", "use super::low::{Low, low};\npub struct High;\npub fn high() {}\n"),
            ("a/low.rs", &format!("{back}\npub struct Low;\npub fn low() {{}}\n")),
        ];
        assert_eq!(circles_of(&files), [["a/high.rs", "a/low.rs"]], "{back}");
    }
    // Over others, and over what other modules hand on.
    let files = [
        lib,
        ("a/mod.rs", "mod low;\npub use low::Low;\n"),
        ("a/low.rs", "use crate::c::Top;\npub struct Low;\n"),
        ("b.rs", "use crate::a::Low;\npub struct Middle(Low);\n"),
        ("c.rs", "use crate::b::Middle;\npub struct Top(Middle);\n"),
    ];
    assert_eq!(circles_of(&files), [["a/low.rs", "b.rs", "c.rs"]]);
    // One way, words in comments, tests, and what a file takes from the module that it is a part of.
    let files = [
        lib,
        ("a/mod.rs", "mod high;\nmod low;\npub use high::High;\npub struct Own;\nfn f() { low::low() }\n"),
        ("a/high.rs", "use super::{Own, low::Low};\npub struct High(Low, Own);\n"),
        below,
        (
            "b.rs",
            "//! See [`crate::c::Top`].\nuse crate::a::High;\npub struct B;\n#[cfg(test)]\nmod tests {\n    use crate::c::Top;\n}\n",
        ),
        ("c.rs", "use crate::{a::High, b::B};\npub struct Top(High, B);\n"),
    ];
    assert_eq!(circles_of(&files), [[""; 0]; 0]);
}

#[test]
fn exact_comments_and_strings_are_no_code() {
    let text = "let a = r#\"dbg! \"x\" \"#; let b = '\"'; /* todo! */ let c = \"\\\"print!\"; // dbg!\nend";
    let code = code_of(text);
    assert!(PRINTING.iter().all(|word| !code.contains(word)), "{code}");
    assert!(code.contains("let b") && code.contains("let c") && code.ends_with("\nend"), "{code}");
}

#[test]
fn exact_order_lists_every_module() {
    // The command line belongs to the program, all else to the library.
    let [library, program] = ["src/lib.rs", "src/main.rs"]
        .map(|file| code_of(&std::fs::read_to_string(root().join(file)).unwrap()));
    let declared: Vec<&str> = [&library, &program]
        .into_iter()
        .flat_map(|code| code.match_indices("mod ").map(|(at, word)| identifier(&code[at + word.len()..])))
        .collect();
    assert!(declared.len() > 10, "{declared:?}");
    for module in &declared {
        assert!(ORDER.contains(module), "module `{module}` is not in the order");
    }
    for module in ORDER.iter().filter(|m| !OPTIONAL.contains(m)) {
        assert!(declared.contains(module), "module `{module}` of the order is declared nowhere");
    }
    for (file, module, _) in sources() {
        let known = module == "lib" || module == "main" || declared.contains(&module.as_str());
        assert!(known, "src/{file} belongs to no module");
    }
}

#[test]
fn exact_library_does_not_print() {
    let mut offences = Vec::new();
    for (file, module, text) in sources() {
        if MAY_PRINT.contains(&module.as_str()) {
            continue;
        }
        for (number, line) in code_of(&text).lines().enumerate() {
            for word in PRINTING.iter().filter(|word| line.contains(**word)) {
                offences.push(format!("src/{file}:{}: {word}", number + 1));
            }
        }
    }
    assert_none("the library prints or is unfinished", &offences);
}

/// Names of machines in a line; a path below `models/` in a comment (an example to run) is no knowledge.
fn machines_in(line: &str) -> Vec<&'static str> {
    let lower = line.to_lowercase();
    let in_comment = lower.trim_start().starts_with("//");
    let mut names = Vec::new();
    for name in MACHINES {
        for (at, _) in lower.match_indices(name) {
            let alone = !lower[..at].ends_with(char::is_alphanumeric)
                && !lower[at + name.len()..].starts_with(char::is_alphanumeric);
            let in_prose = in_comment && (FIELD_WORDS.contains(&name) || lower[..at].ends_with("models/"));
            if alone && !in_prose {
                names.push(name);
            }
        }
    }
    names
}

#[test]
fn exact_no_machine_is_named_in_the_library() {
    let mut offences = Vec::new();
    for (file, _, text) in sources() {
        for (number, line) in text.lines().enumerate() {
            for name in machines_in(line) {
                offences.push(format!("src/{file}:{}: {name}", number + 1));
            }
        }
    }
    assert_none("machines belong below models", &offences);
}

#[test]
fn exact_machine_named_in_code_is_caught() {
    assert_eq!(machines_in("if name == \"Grinder\" {"), ["grinder"]);
    assert_eq!(machines_in("const EMPS_GAIN: f64 = 1.0;"), ["emps"]);
    assert_eq!(machines_in("let folder = \"models/grinder\";"), ["grinder"]);
    assert!(machines_in("/// let folder = root.join(\"models/grinder\");").is_empty());
    assert!(machines_in("let temps = attempts;").is_empty());
    assert!(machines_in("//! What a servo axis is.").is_empty());
    assert_eq!(machines_in("if name == \"servo\" {"), ["servo"]);
    assert_eq!(machines_in("// as a Kollmorgen drive"), ["kollmorgen"]);
}

/// Every number that decides a verdict, by its name in `thresholds.rs`.
const MOST_THRESHOLDS: usize = 10;
/// Files of the diagnosis whose predicates give, withhold or change a verdict, and the numbers of their own that say how something is computed.
const DECIDING: [(&str, &[&str]); 28] = [
    ("decide", &[]),
    ("grounds", &[]),
    ("found", &[]),
    ("verdict", &[]),
    ("wald", &[]),
    ("posterior", &[]),
    ("settle", &[]),
    ("borne_out", &[]),
    ("outcome", &[]),
    ("own_gap", &[]),
    ("merged_waves", &[]),
    ("predictive", &["A_NAT"]), // how near to its end an iteration ends
    ("attribute", &[]),
    ("floors", &[]),
    ("folds", &["STUDENT", "1.21", "1.4"]), // a table of a distribution, and its series beyond
    ("evidence", &["LARGEST", "1e-300"]), // what a residual that is no number counts as, and no division by zero
    ("candidate", &["EDGE", "1e3"]),      // rounding at the bound of a range
    ("prove", &["LONGEST_S"]),            // what the rigid-body scene has time for
    ("cut/contradiction", &[]),
    ("cut/at_rest", &["ROUNDING"]),          // rounding of numbers
    ("check/missing_term", &["CONVENTION"]), // how a derivative is taken, in samples
    ("check/mod", &[]),
    ("check/late", &[]),
    ("check/shift", &[]),
    ("check/sign", &[]),
    ("check/unit", &[]),
    ("check/law", &["EXACT", "FITS"]), // rounding, and what follows from a threshold
    ("check/alignment", &["AGREE_SAMPLES", "STAIRCASE"]), // what is told of several runs as one, when a staircase acts
];
/// Numbers that need no name: nothing, all, halves and doubles, per cent, the ends of a 95 % interval.
const PLAIN: [&str; 7] = ["0.0", "0.5", "1.0", "2.0", "100.0", "0.025", "0.975"];
/// Files with tables of units.
const TABLES: [&str; 1] = ["check/unit"];

/// Names of the numbers that a file states before its tests.
fn named_numbers(text: &str) -> Vec<String> {
    let own = text.split("#[cfg(test)]").next().unwrap();
    let name = |line: &str| {
        let rest = line.trim_start().split_once("const ")?.1;
        let (name, kind) = rest.split_once(':')?;
        (kind.trim_start().starts_with("f64") || kind.trim_start().starts_with("[f64"))
            .then(|| name.to_owned())
    };
    own.lines().filter(|line| !line.trim_start().starts_with("//")).filter_map(name).collect()
}

/// Numbers with a point or an exponent in the code of a file before its tests, those of named ones and [`PLAIN`] ones left out.
fn nameless_numbers(text: &str) -> Vec<String> {
    let code = code_of(text.split("#[cfg(test)]").next().unwrap());
    let lines = code.lines().filter(|line| !line.contains("const "));
    lines.flat_map(floats).filter(|number| !PLAIN.contains(&number.as_str())).collect()
}

/// Numbers of a line of code that have a point and a digit after it, or an exponent; fields of tuples and ranges are none.
fn floats(line: &str) -> Vec<String> {
    let (mut floats, mut rest, mut before) = (Vec::new(), line, ' ');
    while let Some(first) = rest.chars().next() {
        let digits = |text: &str| text.find(|c: char| !c.is_ascii_digit() && c != '_').unwrap_or(text.len());
        let begins = first.is_ascii_digit() && !before.is_alphanumeric() && !matches!(before, '_' | '.');
        let mut end = if begins { digits(rest) } else { first.len_utf8() };
        let whole = end;
        if begins && rest[end..].starts_with('.') && rest[end + 1..].starts_with(|c: char| c.is_ascii_digit())
        {
            end += 1 + digits(&rest[end + 1..]);
        }
        if begins && rest[end..].starts_with('e') {
            let sign = usize::from(rest[end + 1..].starts_with('-'));
            end += 1 + sign + digits(&rest[end + 1 + sign..]);
        }
        if end > whole {
            floats.push(rest[..end].trim_end_matches('_').to_owned());
        }
        before = rest[..end].chars().next_back().unwrap();
        rest = &rest[end..];
    }
    floats
}

#[test]
fn exact_at_most_ten_numbers_decide_a_verdict() {
    let read = |file: &str| std::fs::read_to_string(root().join(format!("src/diagnose/{file}.rs"))).unwrap();
    let thresholds = named_numbers(&read("thresholds"));
    assert!((5..=MOST_THRESHOLDS).contains(&thresholds.len()), "{thresholds:?}");
    let strange = |(file, known): &(&str, &[&str])| {
        let text = read(file);
        let nameless = if TABLES.contains(file) { Vec::new() } else { nameless_numbers(&text) };
        let all = named_numbers(&text).into_iter().chain(nameless);
        let others: Vec<String> = all.filter(|name| !known.contains(&name.as_str())).collect();
        others.into_iter().map(|name| format!("src/diagnose/{file}.rs: {name}")).collect::<Vec<_>>()
    };
    let offences: Vec<String> = DECIDING.iter().flat_map(strange).collect();
    assert_none("numbers that decide a verdict outside thresholds.rs", &offences);
}

#[test]
fn exact_named_number_is_caught() {
    let text = "/// const A: f64 = 1.0;\npub(super) const B: f64 = 2.0;\n    const C: [f64; 2] = [0.0; 2];\nconst D: usize = 3;\n\
                #[cfg(test)]\nconst E: f64 = 1.0;";
    assert_eq!(named_numbers(text), ["B", "C"]);
    let text = "// 0.7\nlet a = 0.7 * b[0].max(2.0) + c.0.1 + 3.5.sqrt() + (0..4) + 2e-3;\nconst F: f64 = 0.3;\n#[cfg(test)]\nlet d = 9.5;";
    assert_eq!(nameless_numbers(text), ["0.7", "3.5", "2e-3"]);
}

#[test]
fn exact_no_source_file_is_too_long() {
    let mut offences = Vec::new();
    for (file, _, text) in sources() {
        let lines = text.lines().count();
        if lines > MOST_LINES {
            offences.push(format!("src/{file}: {lines} lines"));
        }
    }
    assert_none("files longer than one concern needs", &offences);
}

/// What stands at the top of the repository: tracked files, or the directory where git does not know it.
fn top_level() -> Vec<String> {
    let listed = Command::new("git").args(["ls-files", "-z"]).current_dir(root()).output();
    let mut names: Vec<String> = match listed {
        Ok(output) if output.status.success() && !output.stdout.is_empty() => {
            String::from_utf8_lossy(&output.stdout)
                .split('\0')
                .filter_map(|path| path.split('/').next())
                .map(str::to_owned)
                .collect()
        }
        _ => {
            let entries = std::fs::read_dir(root()).unwrap();
            let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
            names.filter(|name| name != "target").collect()
        }
    };
    names.retain(|name| !name.is_empty());
    names.sort();
    names.dedup();
    names
}

#[test]
fn exact_top_level_holds_only_what_it_should() {
    let allowed = |name: &str| {
        TOP_LEVEL.contains(&name)
            || name == "build.rs"
            || name.starts_with("LICENSE")
            || name.starts_with('.')
    };
    let names = top_level();
    assert!(names.iter().any(|name| name == "src"), "{names:?}");
    let offences: Vec<String> = names.into_iter().filter(|name| !allowed(name)).collect();
    assert_none("at the top of the repository", &offences);
}
