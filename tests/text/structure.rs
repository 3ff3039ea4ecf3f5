//! Files of a crate import one another downward, and in no large circles.
//!
//! An arrow runs from a file to each file of its crate that it imports or names in a path: the file of the last module
//! in the path. What a module passes on (`pub use`) is not followed, so names have to be imported from the file that
//! defines them. A circle is a strongly connected component of files; what is only passed on ties none. Upward arrows
//! are counted between rooms, the folders and files right under `src/`, each pair of rooms once: in an order of the
//! rooms that a greedy search makes (Eades, Lin and Smyth, 1993), each arrow to a room further up. A folder with more
//! than two thirds of its crate's lines is no room, but what stands in it is. Code under `#[cfg(test)]` does not count.
//!
//! Limits: names behind `*`, and those that macros write, are not seen.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use petgraph::algo::tarjan_scc;
use petgraph::graph::{DiGraph, NodeIndex};
use syn::visit::{self, Visit};

/// The most files of a circle.
const MAX_CIRCLE: usize = 4;
/// The most upward arrows of all crates together.
const MAX_UPWARD: usize = 30;

type Module = Vec<String>;

/// The paths and the modules that a file names.
#[derive(Default)]
struct File {
    lines: usize,
    /// The paths that it writes out, those of imports among them, and whether each is only passed on.
    paths: Vec<(Module, bool)>,
    /// The modules in files of their own.
    children: Vec<String>,
}

impl File {
    fn read(text: &str) -> Self {
        let mut file = Self { lines: text.lines().count(), ..Self::default() };
        file.visit_file(&syn::parse_file(text).expect("Rust"));
        file
    }

    fn import(&mut self, tree: &syn::UseTree, before: &[String], is_passed_on: bool) {
        let with = |name: &syn::Ident| [before, &[name.to_string()]].concat();
        match tree {
            syn::UseTree::Path(path) => self.import(&path.tree, &with(&path.ident), is_passed_on),
            syn::UseTree::Name(name) if name.ident == "self" => {
                self.paths.push((before.to_vec(), is_passed_on));
            }
            syn::UseTree::Name(name) => self.paths.push((with(&name.ident), is_passed_on)),
            syn::UseTree::Rename(name) => self.paths.push((with(&name.ident), is_passed_on)),
            syn::UseTree::Group(group) => {
                group.items.iter().for_each(|tree| self.import(tree, before, is_passed_on));
            }
            _ => self.paths.push((before.to_vec(), is_passed_on)),
        }
    }
}

fn is_for_tests(attributes: &[syn::Attribute]) -> bool {
    let is_test = |one: &syn::Attribute| matches!(one.parse_args::<syn::Ident>(), Ok(word) if word == "test");
    attributes.iter().any(|one| one.path().is_ident("cfg") && is_test(one))
}

impl Visit<'_> for File {
    fn visit_item_mod(&mut self, module: &syn::ItemMod) {
        if is_for_tests(&module.attrs) {
            return;
        }
        if module.content.is_none() {
            self.children.push(module.ident.to_string());
        }
        visit::visit_item_mod(self, module);
    }

    fn visit_item_fn(&mut self, function: &syn::ItemFn) {
        if !is_for_tests(&function.attrs) {
            visit::visit_item_fn(self, function);
        }
    }

    fn visit_item_use(&mut self, import: &syn::ItemUse) {
        if !is_for_tests(&import.attrs) {
            self.import(&import.tree, &[], !matches!(import.vis, syn::Visibility::Inherited));
        }
    }

    fn visit_path(&mut self, path: &syn::Path) {
        if path.segments.len() > 1 {
            self.paths.push((path.segments.iter().map(|one| one.ident.to_string()).collect(), false));
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &syn::Macro) {
        let text = call.tokens.to_string().replace(" :: ", "::");
        let words = text.split(|one: char| !(one.is_alphanumeric() || one == '_' || one == ':'));
        let paths = words.map(|word| word.trim_matches(':')).filter(|word| word.contains("::"));
        self.paths.extend(paths.map(|path| (path.split("::").map(str::to_owned).collect(), false)));
    }
}

/// The files of a crate by their modules.
#[derive(Default)]
struct Crate(BTreeMap<Module, File>);

impl Crate {
    fn read(&mut self, module: Module, path: &Path) {
        let file = File::read(&std::fs::read_to_string(path).expect("a readable file"));
        let folder = match path.file_stem().and_then(|stem| stem.to_str()) {
            Some("lib" | "main" | "mod") => path.with_file_name(""),
            _ => path.with_extension(""),
        };
        for name in &file.children {
            let paths = [folder.join(format!("{name}.rs")), folder.join(name).join("mod.rs")];
            if let Some(path) = paths.iter().find(|path| path.exists()) {
                self.read([&module[..], std::slice::from_ref(name)].concat(), path);
            }
        }
        self.0.insert(module, file);
    }

    /// The module that a path leads to; nothing for another crate's.
    fn resolve(&self, from: &Module, path: &[String]) -> Option<&Module> {
        let ups = path.iter().take_while(|one| *one == "super").count();
        let (mut module, rest) = match path.first()?.as_str() {
            "crate" => (Module::new(), &path[1..]),
            "self" => (from.clone(), &path[1..]),
            _ => (from[..from.len().checked_sub(ups)?].to_vec(), &path[ups..]),
        };
        let is_outside = rest.len() == path.len() && !self.0.contains_key(&[from, &path[..1]].concat());
        for name in rest {
            module.push(name.clone());
            if !self.0.contains_key(&module) {
                module.pop();
                break;
            }
        }
        self.0.get_key_value(&module).map(|(module, _)| module).filter(|_| !is_outside)
    }

    /// From which file to which arrows run, and whether names are only passed on by all of them.
    fn arrows(&self) -> BTreeMap<(&Module, &Module), bool> {
        let mut arrows = BTreeMap::new();
        for (from, file) in &self.0 {
            for (path, is_passed_on) in &file.paths {
                if let Some(to) = self.resolve(from, path).filter(|to| *to != from) {
                    *arrows.entry((from, to)).or_insert(true) &= is_passed_on;
                }
            }
        }
        arrows
    }

    /// The room of a file.
    fn room(&self, module: &Module) -> String {
        let lines = |folder: &str| -> usize {
            let inside = self.0.iter().filter(|(one, _)| one.first().is_some_and(|first| first == folder));
            inside.map(|(_, file)| file.lines).sum()
        };
        let all: usize = self.0.values().map(|file| file.lines).sum();
        match &module[..] {
            [] => "lib".to_owned(),
            [folder, inside, ..] if lines(folder) * 3 > all * 2 => format!("{folder}/{inside}"),
            [folder, ..] => folder.clone(),
        }
    }
}

/// Rooms from the ground to the top, so that few arrows run upward.
fn order(mut rooms: BTreeSet<&str>, arrows: &BTreeSet<(&str, &str)>) -> Vec<String> {
    let (mut ground, mut top) = (Vec::new(), Vec::new());
    while !rooms.is_empty() {
        let inside: Vec<_> =
            arrows.iter().filter(|(from, to)| rooms.contains(from) && rooms.contains(to)).collect();
        let out = |room: &str| inside.iter().filter(|(from, _)| *from == room).count() as i64;
        let into = |room: &str| inside.iter().filter(|(_, to)| *to == room).count() as i64;
        let low = rooms.iter().copied().find(|room| out(room) == 0);
        let high = rooms.iter().copied().find(|room| into(room) == 0);
        let lowest = || rooms.iter().copied().min_by_key(|room| out(room) - into(room));
        let Some(room) = low.or(high).or_else(lowest) else { break };
        if low.is_none() && high.is_some() {
            top.push(room.to_owned());
        } else {
            ground.push(room.to_owned());
        }
        rooms.remove(room);
    }
    ground.extend(top.into_iter().rev());
    ground
}

#[test]
fn files_of_a_crate_import_one_another_downward() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let manifest = std::fs::read_to_string(root.join("Cargo.toml")).unwrap();
    let members = manifest.split_once("members = [").and_then(|(_, rest)| rest.split_once(']')).unwrap().0;
    let (mut upward, mut circles, mut count) = (Vec::new(), Vec::new(), 0);
    for folder in members.split('"').skip(1).step_by(2) {
        let starts = ["src/lib.rs", "src/main.rs"].map(|start| root.join(folder).join(start));
        let Some(start) = starts.iter().find(|start| start.exists()) else { continue };
        let mut files = Crate::default();
        files.read(Module::new(), start);
        let arrows = files.arrows();
        let mut graph: DiGraph<&Module, ()> = DiGraph::new();
        let nodes: BTreeMap<&Module, NodeIndex> =
            files.0.keys().map(|module| (module, graph.add_node(module))).collect();
        for ((from, to), _) in arrows.iter().filter(|(_, is_passed_on)| !**is_passed_on) {
            graph.add_edge(nodes[*from], nodes[*to], ());
        }
        for circle in tarjan_scc(&graph).into_iter().filter(|circle| circle.len() > MAX_CIRCLE) {
            let names: Vec<String> = circle.iter().map(|node| graph[*node].join("::")).collect();
            circles.push(format!("{folder}: a circle of {} files: {}", circle.len(), names.join(", ")));
        }
        let rooms: BTreeMap<&Module, String> =
            files.0.keys().map(|module| (module, files.room(module))).collect();
        let between: BTreeSet<(&str, &str)> = arrows
            .keys()
            .map(|(from, to)| (rooms[from].as_str(), rooms[to].as_str()))
            .filter(|(from, to)| from != to)
            .collect();
        let order = order(rooms.values().map(String::as_str).collect(), &between);
        let floor = |room: &str| order.iter().position(|one| one == room);
        let up = between.iter().filter(|(from, to)| floor(from) < floor(to));
        upward.extend(up.map(|(from, to)| format!("  {folder}: from {from} to {to}")));
        count += between.len();
    }
    assert!(count > 500, "{count} arrows were found in all");
    assert!(circles.is_empty(), "{}", circles.join("\n"));
    assert!(upward.len() <= MAX_UPWARD, "{} arrows run upward:\n{}", upward.len(), upward.join("\n"));
}

#[test]
fn paths_lead_to_the_files_of_their_modules() {
    let mut files = Crate::default();
    for (module, text) in [
        ("", "pub mod a; mod b; pub use b::Named; /* use crate::no::No; */"),
        ("a", "use super::b::{self, two::{Two}}; use std::fmt; fn f() { b::call(\"b::text\"); }"),
        ("b", "pub mod two; #[cfg(test)] mod tests { use crate::a::f; } struct Named;"),
        ("b::two", "pub(crate) struct Three; fn g() { write!(to, \"\", crate::b::call()); }"),
    ] {
        let module = module.split("::").filter(|one| !one.is_empty()).map(str::to_owned).collect();
        files.0.insert(module, File::read(text));
    }
    let arrows = files.arrows();
    let told: Vec<String> = arrows
        .iter()
        .map(|((from, to), is_passed_on)| format!("{} {} {is_passed_on}", from.join("::"), to.join("::")))
        .collect();
    assert_eq!(told, [" b true", "a b false", "a b::two false", "b::two b false"]);
}
