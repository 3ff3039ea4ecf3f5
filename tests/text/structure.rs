//! Files of a crate import one another downward, and in no large circles.
//!
//! An arrow runs from a file to each file of its crate whose names it imports or writes out as a path; names that a module
//! passes on (`pub use`) lead to the file that defines them. A circle is a strongly connected component of files. Upward
//! arrows are counted between rooms, the folders and files right under `src/`: in an order of the rooms that a greedy
//! search makes (Eades, Lin and Smyth, 1993), each arrow to a room further up. Code under `#[cfg(test)]` does not count.
//!
//! Limits: names behind `*`, and those that macros write, are not seen.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The most files of a circle.
const MAX_CIRCLE: usize = 4;
/// The most upward arrows of all crates together.
const MAX_UPWARD: usize = 30;

type Module = Vec<String>;

/// Words and signs of Rust without comments, texts, and items under `#[cfg(test)]`.
fn tokens(text: &str) -> Vec<String> {
    let bytes = text.as_bytes();
    let (mut tokens, mut at): (Vec<String>, usize) = (Vec::new(), 0);
    while at < bytes.len() {
        let rest = &text[at..];
        let word =
            rest.chars().take_while(|one| one.is_alphanumeric() || *one == '_').map(char::len_utf8).sum();
        let hashes = rest.trim_start_matches('r').bytes().take_while(|one| *one == b'#').count();
        at += if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with('r') && rest[1..][hashes..].starts_with('"') {
            let end = format!("\"{}", "#".repeat(hashes));
            let start = hashes + 2;
            rest[start..].find(&end).map_or(rest.len(), |length| start + length + end.len())
        } else if let Some(inside) = rest.strip_prefix('"') {
            let mut escaped = false;
            let end = inside.bytes().position(|one| {
                let ends = one == b'"' && !escaped;
                escaped = one == b'\\' && !escaped;
                ends
            });
            end.map_or(rest.len(), |end| end + 2)
        } else if let Some(escape) = rest.strip_prefix("'\\") {
            escape.find('\'').map_or(rest.len(), |end| end.max(1) + 3)
        } else if rest.starts_with('\'') && rest.chars().nth(2) == Some('\'') {
            rest.chars().take(3).map(char::len_utf8).sum()
        } else if word > 0 {
            tokens.push(rest[..word].to_owned());
            word
        } else if rest.starts_with("::") {
            tokens.push("::".to_owned());
            2
        } else {
            let one = rest.chars().next().unwrap();
            if !one.is_whitespace() {
                tokens.push(one.to_string());
            }
            one.len_utf8()
        };
    }
    without_tests(tokens)
}

fn without_tests(tokens: Vec<String>) -> Vec<String> {
    const TEST: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];
    let (mut kept, mut at) = (Vec::new(), 0);
    while at < tokens.len() {
        if !tokens[at..].iter().zip(TEST).all(|(token, one)| token == one) || tokens.len() < at + TEST.len() {
            kept.push(tokens[at].clone());
            at += 1;
            continue;
        }
        let mut depth = 0;
        at += TEST.len();
        while at < tokens.len() {
            depth += match tokens[at].as_str() {
                "{" | "(" | "[" => 1,
                "}" | ")" | "]" => -1,
                _ => 0,
            };
            at += 1;
            if depth == 0 && matches!(tokens[at - 1].as_str(), ";" | "}") {
                break;
            }
        }
    }
    kept
}

/// The paths of a tree of imports, each with the name that it binds.
fn imports(tokens: &[String], at: &mut usize, before: &Module, found: &mut Vec<(Module, String)>) {
    while let Some(first) = tokens.get(*at).filter(|token| *token != ";") {
        if first == "}" {
            *at += 1;
            return;
        }
        let (mut path, mut name, mut is_group) = (before.clone(), None, false);
        while let Some(token) = tokens.get(*at).filter(|token| !matches!(token.as_str(), "," | "}" | ";")) {
            *at += 1;
            match token.as_str() {
                "::" => {}
                "self" if !path.is_empty() => {}
                "as" => name = tokens.get(*at).cloned(),
                "{" => {
                    imports(tokens, at, &path, found);
                    is_group = true;
                }
                word if name.is_none() => path.push(word.to_owned()),
                _ => {}
            }
        }
        if let Some(last) = path.last().filter(|_| !is_group).cloned() {
            found.push((path, name.unwrap_or(last)));
        }
        *at += usize::from(tokens.get(*at).is_some_and(|token| token == ","));
    }
}

/// A file of a crate.
struct File {
    tokens: Vec<String>,
    /// The paths behind the names that it imports, and whether it passes them on.
    names: BTreeMap<String, (Module, bool)>,
}

impl File {
    fn of(tokens: Vec<String>) -> Self {
        let mut names = BTreeMap::new();
        for at in (0..tokens.len()).filter(|at| tokens[*at] == "use") {
            let mut found = Vec::new();
            imports(&tokens, &mut (at + 1), &Module::new(), &mut found);
            let is_passed_on = at > 0 && matches!(tokens[at - 1].as_str(), "pub" | ")");
            names.extend(found.into_iter().map(|(path, name)| (name, (path, is_passed_on))));
        }
        Self { tokens, names }
    }
}

/// The files of a crate by their modules.
#[derive(Default)]
struct Crate(BTreeMap<Module, File>);

impl Crate {
    fn read(&mut self, module: Module, path: &Path) {
        let tokens = tokens(&std::fs::read_to_string(path).unwrap());
        let stem = path.file_stem().unwrap().to_str().unwrap();
        let folder = path.parent().unwrap();
        let folder = match stem {
            "lib" | "main" | "mod" => folder.to_owned(),
            stem => folder.join(stem),
        };
        for three in tokens.windows(3).filter(|three| three[0] == "mod" && three[2] == ";") {
            let name = &three[1];
            let mut child = module.clone();
            child.push(name.clone());
            let paths = [folder.join(format!("{name}.rs")), folder.join(name).join("mod.rs")];
            if let Some(path) = paths.iter().find(|path| path.exists()) {
                self.read(child, path);
            }
        }
        self.0.insert(module, File::of(tokens));
    }

    /// The file that defines what a path names, and the name there; nothing for another crate's.
    fn resolve(&self, from: &Module, path: &[String], links: usize) -> Option<(&Module, String)> {
        let (mut module, mut rest) = (from.clone(), path);
        match path.first()?.as_str() {
            "crate" => (module, rest) = (Module::new(), &path[1..]),
            "self" => rest = &path[1..],
            "super" => {
                while rest.first().is_some_and(|one| one == "super") {
                    module.pop();
                    rest = &rest[1..];
                }
            }
            _ => {}
        }
        while let Some(next) = rest.first() {
            let child: Module = module.iter().chain([next]).cloned().collect();
            if !self.0.contains_key(&child) {
                break;
            }
            (module, rest) = (child, &rest[1..]);
        }
        let (module, file) = self.0.get_key_value(&module)?;
        let Some(name) = rest.first() else { return Some((module, String::new())) };
        match file.names.get(name).filter(|_| links < 16) {
            Some((path, _)) if path.first() == Some(name) && path.len() == 1 => None,
            Some((path, _)) => self.resolve(module, &[path, &rest[1..]].concat(), links + 1),
            None if module == from && path.len() == rest.len() => None,
            None => Some((module, name.clone())),
        }
    }

    /// The names that each file takes from each other.
    fn arrows(&self) -> BTreeMap<(&Module, &Module), BTreeSet<String>> {
        let mut arrows: BTreeMap<_, BTreeSet<String>> = BTreeMap::new();
        for (module, file) in &self.0 {
            let own =
                file.names.values().filter(|(_, is_passed_on)| !is_passed_on).map(|(path, _)| path.clone());
            let mut paths: Vec<Module> = own.collect();
            let mut at = 0;
            while let Some(token) = file.tokens.get(at) {
                let mut end = at + 1;
                if token == "use" {
                    end += file.tokens[end..].iter().take_while(|token| *token != ";").count();
                }
                let is_word =
                    |at: usize| file.tokens.get(at).is_some_and(|token| token != "{" && token != "<");
                while token != "use"
                    && file.tokens.get(end).is_some_and(|token| token == "::")
                    && is_word(end + 1)
                {
                    end += 2;
                }
                if token != "use" && end > at + 1 {
                    paths.push(file.tokens[at..end].iter().step_by(2).cloned().collect());
                }
                at = end;
            }
            for path in paths {
                // A whole module is no name: what is taken from it is written out as a path.
                if let Some((to, name)) = self.resolve(module, &path, 0).filter(|(_, name)| !name.is_empty())
                    && to != module
                {
                    arrows.entry((module, to)).or_default().insert(name);
                }
            }
        }
        arrows
    }
}

/// The nodes that can be reached from one.
fn reached<'n, N: Ord>(arrows: &BTreeSet<(&'n N, &'n N)>, from: &'n N) -> BTreeSet<&'n N> {
    let (mut reached, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(node) = open.pop() {
        let next = arrows.iter().filter(|(start, _)| *start == node).map(|(_, end)| *end);
        open.extend(next.filter(|end| reached.insert(*end)));
    }
    reached
}

/// Rooms from the ground to the top, so that few arrows run upward.
fn order(mut rooms: BTreeSet<String>, arrows: &BTreeMap<(String, String), usize>) -> Vec<String> {
    let (mut ground, mut top) = (Vec::new(), Vec::new());
    while !rooms.is_empty() {
        let count = |room: &String, out: bool| -> usize {
            let counts = arrows.iter().filter(|((from, to), _)| {
                rooms.contains(from) && rooms.contains(to) && room == if out { from } else { to }
            });
            counts.map(|(_, count)| count).sum()
        };
        let low = rooms.iter().find(|room| count(room, true) == 0);
        let high = rooms.iter().find(|room| count(room, false) == 0);
        let room = low
            .or(high)
            .or_else(|| rooms.iter().min_by_key(|room| count(room, true) as i64 - count(room, false) as i64));
        let (room, is_top) = (room.unwrap().clone(), low.is_none() && high.is_some());
        rooms.remove(&room);
        if is_top { top.push(room) } else { ground.push(room) }
    }
    ground.extend(top.into_iter().rev());
    ground
}

#[test]
fn files_of_a_crate_import_one_another_downward() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let manifest = std::fs::read_to_string(root.join("Cargo.toml")).unwrap();
    let members = manifest.split_once("members = [").and_then(|(_, rest)| rest.split_once(']')).unwrap().0;
    let mut upward: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut circles = Vec::new();
    let mut count = 0;
    for folder in members.split('"').skip(1).step_by(2) {
        let starts = ["src/lib.rs", "src/main.rs"].map(|start| root.join(folder).join(start));
        let Some(start) = starts.iter().find(|start| start.exists()) else { continue };
        let mut files = Crate::default();
        files.read(Module::new(), start);
        let arrows = files.arrows();
        count += arrows.len();
        let name = |module: &Module| if module.is_empty() { "lib".to_owned() } else { module.join("::") };
        let tie = |(from, to): (&Module, &Module), names: &BTreeSet<String>| {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            format!("  {folder}: {} takes {} from {}", name(from), names.join(", "), name(to))
        };
        let pairs: BTreeSet<(&Module, &Module)> = arrows.keys().copied().collect();
        let mut seen = BTreeSet::new();
        for module in files.0.keys() {
            let circle: BTreeSet<&Module> = reached(&pairs, module)
                .into_iter()
                .filter(|other| *other == module || reached(&pairs, other).contains(module))
                .collect();
            if circle.len() > MAX_CIRCLE && seen.insert(circle.clone()) {
                let inside =
                    arrows.iter().filter(|((from, to), _)| circle.contains(from) && circle.contains(to));
                let ties: Vec<String> = inside.map(|(pair, names)| tie(*pair, names)).collect();
                circles.push(format!("a circle of {} files:\n{}", circle.len(), ties.join("\n")));
            }
        }
        let room = |module: &Module| module.first().cloned().unwrap_or_else(|| "lib".to_owned());
        let mut between: BTreeMap<(String, String), usize> = BTreeMap::new();
        for (from, to) in arrows.keys().filter(|(from, to)| room(from) != room(to)) {
            *between.entry((room(from), room(to))).or_default() += 1;
        }
        let rooms = order(files.0.keys().map(room).collect(), &between);
        let floor = |module: &Module| rooms.iter().position(|one| *one == room(module));
        let up = arrows.iter().filter(|((from, to), _)| floor(from) < floor(to));
        upward.entry(folder.to_owned()).or_default().extend(up.map(|(pair, names)| tie(*pair, names)));
    }
    assert!(count > 1_000, "{count} arrows were found in all");
    assert!(circles.is_empty(), "{}", circles.join("\n"));
    let upward: Vec<String> = upward.into_values().flatten().collect();
    assert!(upward.len() <= MAX_UPWARD, "{} arrows run upward:\n{}", upward.len(), upward.join("\n"));
}

#[test]
fn names_lead_to_the_files_that_define_them() {
    let mut files = Crate::default();
    for (module, text) in [
        ("", "pub mod a; mod b; pub use b::Named; /* use crate::no::No; */"),
        (
            "a",
            "use crate::Named as Other; use super::b::{self, two::{Two}}; fn f() { b::call(\"b::text\"); }",
        ),
        (
            "b",
            "pub mod two; pub(crate) use self::two::Three; #[cfg(test)] mod tests { use crate::a::f; } struct Named;",
        ),
        ("b::two", "pub(crate) struct Three; fn g() -> char { ':' }"),
    ] {
        let module = module.split("::").filter(|one| !one.is_empty()).map(str::to_owned).collect();
        files.0.insert(module, File::of(tokens(text)));
    }
    let arrows = files.arrows();
    let told: Vec<String> = arrows
        .iter()
        .map(|((from, to), names)| {
            format!("{} {} {:?}", from.join("::"), to.join("::"), names.iter().collect::<Vec<_>>())
        })
        .collect();
    assert_eq!(told, [r#"a b ["Named", "call"]"#, r#"a b::two ["Two"]"#]);
}
