//! Which source file imports from which: `use` and every other path, followed to the file that defines the item.

use std::collections::{BTreeMap, BTreeSet};

/// A path, of a module from the root of the crate or of an item as it is written.
type Path = Vec<String>;
/// From each file the files that it takes names from, with those names.
pub type Imports = BTreeMap<String, BTreeMap<String, BTreeSet<String>>>;

/// Words before the name of an item that they define.
const DEFINING: [&str; 9] =
    ["fn", "struct", "enum", "trait", "type", "const", "static", "union", "macro_rules"];
/// What stands before the tests of a file: these may use what stands above it.
const TESTS: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];
/// Imports that hand each other on are followed over so many.
const MOST_STEPS: usize = 16;

/// What one module holds.
#[derive(Default)]
struct Contents {
    /// The file it stands in.
    file: String,
    /// Names that `use` brings, with the paths that they stand for: several where a feature chooses.
    bound: BTreeMap<String, Vec<Path>>,
    /// Names of its items.
    defined: BTreeSet<String>,
    /// What `use` brings for the module itself.
    used: Vec<Path>,
    /// What `pub use` hands on, with its name.
    handed_on: Vec<(String, Path)>,
    /// Paths in its code.
    paths: Vec<Path>,
    /// Names that begin a path in its code, or stand alone.
    said: BTreeSet<String>,
}

impl Contents {
    /// Takes what a `use` brings.
    fn bring(&mut self, found: Vec<(String, Path)>, is_public: bool) {
        for (name, path) in found {
            self.bound.entry(name.clone()).or_default().push(path.clone());
            if is_public {
                self.handed_on.push((name, path));
            } else {
                self.used.push(path);
            }
        }
    }

    /// Takes a path in code.
    fn say(&mut self, path: Path) {
        self.said.insert(path[0].clone());
        if path.len() > 1 {
            self.paths.push(path);
        }
    }
}

/// What a path leads to.
enum Place {
    Module(Path),
    /// The file of an item.
    Item(String),
}

/// The modules of a crate.
pub struct Modules(BTreeMap<Path, Contents>);

impl Modules {
    /// The modules of files, each given from `src`, with its code without comments and strings.
    pub fn read<'a>(files: impl IntoIterator<Item = (&'a str, &'a str)>) -> Self {
        let mut modules = Self(BTreeMap::new());
        for (file, code) in files {
            modules.read_file(file, &tokens(code));
        }
        modules
    }

    fn contents(&mut self, module: &[String], file: &str) -> &mut Contents {
        let contents = self.0.entry(module.to_vec()).or_default();
        file.clone_into(&mut contents.file);
        contents
    }

    fn read_file(&mut self, file: &str, tokens: &[String]) {
        let mut module = module_of(file);
        self.contents(&module, file);
        // Depths at which modules inside the file begin.
        let mut inline = Vec::new();
        let (mut depth, mut at) = (0, 0);
        while at < tokens.len() {
            let token = |place: usize| tokens.get(place).map_or("", String::as_str);
            let before = |back: usize| at.checked_sub(back).map_or("", token);
            let mut end = at + 1;
            match token(at) {
                "{" => depth += 1,
                "}" => {
                    depth -= 1;
                    if inline.last() == Some(&depth) {
                        inline.pop();
                        module.pop();
                    }
                }
                "mod" if token(at + 2) == "{" && tokens[..at].ends_with(&TESTS.map(str::to_owned)) => {
                    end = end_of_block(tokens, at + 2);
                }
                "mod" if token(at + 2) == "{" => {
                    inline.push(depth);
                    module.push(token(at + 1).to_owned());
                    depth += 1;
                    end = at + 3;
                }
                "mod" if token(at + 2) == ";" => end = at + 3,
                "use" if token(at + 1) != "<" => {
                    let (found, after) = tree(tokens, at + 1, &[]);
                    self.contents(&module, file).bring(found, is_public(tokens, at));
                    end = after;
                }
                name if is_name(name) && before(1) != "::" => {
                    let contents = self.contents(&module, file);
                    let word = if before(1) == "!" { before(2) } else { before(1) };
                    if !DEFINING.contains(&word) {
                        let (path, after) = path(tokens, at);
                        contents.say(path);
                        end = after;
                    } else if depth == inline.last().map_or(0, |depth| depth + 1) {
                        contents.defined.insert(name.to_owned());
                    }
                }
                _ => {}
            }
            at = end;
        }
    }

    /// What a path leads to that is written in `module`, or stands behind the module's own where `is_below`.
    fn resolve(&self, module: &[String], path: &[String], is_below: bool, most: usize) -> Vec<Place> {
        let Some((head, rest)) = path.split_first() else { return vec![Place::Module(module.to_vec())] };
        if most == 0 {
            return Vec::new();
        }
        let heads = match head.as_str() {
            "crate" | "slideway" => vec![Place::Module(Vec::new())],
            "self" => vec![Place::Module(module.to_vec())],
            "super" => vec![Place::Module(module[..module.len().saturating_sub(1)].to_vec())],
            name => self.named(module, name, rest.is_empty(), most),
        };
        if heads.is_empty() && is_below {
            // A macro has made it.
            return self
                .0
                .get(module)
                .map(|contents| Place::Item(contents.file.clone()))
                .into_iter()
                .collect();
        }
        let onward = |place: Place| match place {
            Place::Module(module) => self.resolve(&module, rest, true, most - 1),
            item => vec![item],
        };
        heads.into_iter().flat_map(onward).collect()
    }

    /// What a name means in a module: a module below it, what `use` brings, an item of its own.
    fn named(&self, module: &[String], name: &str, is_last: bool, most: usize) -> Vec<Place> {
        let Some(contents) = self.0.get(module) else { return Vec::new() };
        let child: Path = module.iter().cloned().chain([name.to_owned()]).collect();
        let mut places = Vec::new();
        if self.0.contains_key(&child) {
            places.push(Place::Module(child));
            // A function of the same name has nothing below it.
            if !is_last {
                return places;
            }
        }
        for bound in contents.bound.get(name).into_iter().flatten().filter(|bound| bound[..] != [name]) {
            places.extend(self.resolve(module, bound, false, most - 1));
        }
        if contents.defined.contains(name) {
            places.push(Place::Item(contents.file.clone()));
        }
        places
    }

    /// From each file the files that define what it imports. What a module takes from those above it, whose part it is, and
    /// what it only hands on are none.
    pub fn imports(&self) -> Imports {
        let mut imports = Imports::new();
        for (module, contents) in &self.0 {
            let above = |file: &str| module.starts_with(&module_of(file)) && module_of(file) != [""; 0];
            let own = contents.handed_on.iter().filter(|(name, _)| self.says(&contents.file, name));
            let brought = contents.used.iter().chain(own.map(|(_, path)| path));
            for path in brought.chain(&contents.paths) {
                for place in self.resolve(module, path, false, MOST_STEPS) {
                    let Place::Item(file) = place else { continue };
                    if file != contents.file && !above(&file) {
                        let names =
                            imports.entry(contents.file.clone()).or_default().entry(file).or_default();
                        names.extend(path.last().cloned());
                    }
                }
            }
        }
        imports
    }

    /// Whether the code of a file says a name.
    fn says(&self, file: &str, name: &str) -> bool {
        self.0.values().any(|contents| contents.file == file && contents.said.contains(name))
    }
}

/// The groups of files that import each other in a circle, directly or over others.
pub fn circles(imports: &Imports) -> Vec<Vec<&str>> {
    let reached: BTreeMap<&str, BTreeSet<&str>> =
        imports.keys().map(|file| (file.as_str(), reached_from(imports, file))).collect();
    let mut circles: Vec<Vec<&str>> = Vec::new();
    for (file, onward) in reached.iter().filter(|(file, onward)| onward.contains(*file)) {
        if !circles.iter().any(|circle| circle.contains(file)) {
            let leads_back = |other: &&&str| reached.get(*other).is_some_and(|of_it| of_it.contains(file));
            circles.push(onward.iter().filter(leads_back).copied().collect());
        }
    }
    circles
}

/// Every file that `file` imports, directly or over others.
fn reached_from<'a>(imports: &'a Imports, file: &str) -> BTreeSet<&'a str> {
    let mut reached = BTreeSet::new();
    let mut open = vec![file];
    while let Some(file) = open.pop() {
        for next in imports.get(file).into_iter().flat_map(BTreeMap::keys) {
            if reached.insert(next.as_str()) {
                open.push(next);
            }
        }
    }
    reached
}

/// The path of the module that stands in a file, given from `src`.
fn module_of(file: &str) -> Path {
    let path = file.trim_end_matches(".rs").trim_end_matches("/mod");
    if path == "lib" { Path::new() } else { path.split('/').map(str::to_owned).collect() }
}

/// Names, `::` and single characters of code without comments and strings; letters in quotes and lifetimes are left out.
fn tokens(code: &str) -> Vec<String> {
    let characters: Vec<char> = code.chars().collect();
    let name_length = |rest: &[char]| rest.iter().take_while(|c| c.is_alphanumeric() || **c == '_').count();
    let mut tokens = Vec::new();
    let mut at = 0;
    while at < characters.len() {
        let rest = &characters[at..];
        let length = match rest {
            ['\'', '\\', _, after @ ..] => 4 + after.iter().take_while(|c| **c != '\'').count(),
            ['\'', _, '\'', ..] => 3,
            ['\'', after @ ..] => 1 + name_length(after),
            [':', ':', ..] => 2,
            _ => name_length(rest).max(1),
        };
        let token: String = rest.iter().take(length).collect();
        if !token.starts_with(|c: char| c.is_whitespace() || c == '\'') {
            tokens.push(token);
        }
        at += length;
    }
    tokens
}

fn is_name(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Where the block ends whose brace opens at `at`.
fn end_of_block(tokens: &[String], at: usize) -> usize {
    let mut depth = 0;
    for (place, token) in tokens.iter().enumerate().skip(at) {
        match token.as_str() {
            "{" => depth += 1,
            "}" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return place + 1;
        }
    }
    tokens.len()
}

/// The path that begins at `at`, and where it ends.
fn path(tokens: &[String], mut at: usize) -> (Path, usize) {
    let mut path = vec![tokens[at].clone()];
    at += 1;
    while tokens.get(at).is_some_and(|t| t == "::") && tokens.get(at + 1).is_some_and(|t| is_name(t)) {
        path.push(tokens[at + 1].clone());
        at += 2;
    }
    (path, at)
}

/// The paths of a `use` from `at` on, each with the name that it binds, and where they end.
fn tree(tokens: &[String], mut at: usize, before: &[String]) -> (Vec<(String, Path)>, usize) {
    let mut path = before.to_vec();
    while at < tokens.len() {
        match tokens[at].as_str() {
            "::" => at += 1,
            "{" => {
                let mut found = Vec::new();
                at += 1;
                while at < tokens.len() && tokens[at] != "}" {
                    let (more, end) = tree(tokens, at, &path);
                    found.extend(more);
                    at = end + usize::from(tokens[end] == ",");
                }
                return (found, at + 1);
            }
            "as" => return (vec![(tokens[at + 1].clone(), path)], at + 2),
            name if is_name(name) || name == "*" => {
                path.push(name.to_owned());
                at += 1;
            }
            _ => break,
        }
    }
    // `{self}` brings the module before it.
    if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
        path.pop();
    }
    (path.last().map(|name| (name.clone(), path.clone())).into_iter().collect(), at)
}

/// Whether the token at `at` stands behind `pub` or `pub(…)`.
fn is_public(tokens: &[String], at: usize) -> bool {
    match at.checked_sub(1).map(|i| tokens[i].as_str()) {
        Some("pub") => true,
        Some(")") => {
            tokens[..at].iter().rposition(|t| t == "(").is_some_and(|i| i > 0 && tokens[i - 1] == "pub")
        }
        _ => false,
    }
}
