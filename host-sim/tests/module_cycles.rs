//! The modules of the core and of the host's crates depend on each other one way, as the page of
//! the architecture draws it.
//!
//! A file depends on the files that it names by `crate::`, `super::` or `self::`, whatever features
//! are on. A room is a module that a crate's `lib.rs` declares, with everything inside of it. Cargo
//! keeps the crates without a circle. A file may use the modules around it: those declare what
//! their files share. Comments may point anywhere, and unit tests may use anything of their crate.
//! A method for a type of another room would be called from there without a path, so that it is
//! refused, too. Blind to what a macro or a trait object brings in.
#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The directories of the crates, from that of this package.
const HOST: [&str; 9] = [
    ".",
    "dynamics",
    "emulator",
    "figure",
    "files",
    "simulator",
    "studies",
    "thesis",
    "thesis/friction-lab",
];
/// The crates that have rooms; `emulator` and `figure` are one room each.
const WITH_ROOMS: [&str; 7] =
    [".", "dynamics", "files", "simulator", "studies", "thesis", "thesis/friction-lab"];
const CORE: &str = "..";
const JOBS: &str = "../xtask";

/// The modules on the way to a file, `["solver", "exact"]`; none is `lib.rs` or `main.rs`.
type Module = Vec<String>;

/// Sources by their module: the text without comments and unit tests.
type Sources = BTreeMap<Module, String>;

/// For each node, the nodes that it names.
type Graph<T> = BTreeMap<T, BTreeSet<T>>;

/// The circles of files that are left, with their crate. One that is gone leaves this list.
const LEFT: [(&str, &[&str]); 2] = [
    (".", &["studio::orders", "studio::selftest", "studio::worker"]),
    ("emulator", &["board_under_test", "harness"]),
];

#[test]
fn no_file_depends_on_one_that_depends_on_it() {
    let name = |file: &Module| file.join("::");
    for krate in HOST.into_iter().chain([CORE, JOBS]) {
        let mut graph = files(&sources(krate));
        assert!(graph.len() > 10, "{krate} has {} files", graph.len());
        for (_, left) in LEFT.iter().filter(|(of, _)| *of == krate) {
            let is_left = |file: &Module| left.contains(&name(file).as_str());
            let within: Graph<Module> = graph
                .iter()
                .filter(|(file, _)| is_left(file))
                .map(|(file, uses)| {
                    (file.clone(), uses.iter().filter(|used| is_left(used)).cloned().collect())
                })
                .collect();
            assert!(circle(&within).is_some(), "{left:?} of {krate} are no circle any more");
            for (_, uses) in graph.iter_mut().filter(|(file, _)| is_left(file)) {
                uses.retain(|used| !is_left(used));
            }
        }
        let circle = circle(&graph).map(|circle| circle.iter().map(name).collect::<Vec<_>>());
        assert_eq!(circle, None, "these files of {krate} depend on each other");
    }
}

#[test]
fn no_room_depends_on_one_that_depends_on_it() {
    let core = rooms(&sources(CORE));
    let known = [("control", "units"), ("safety", "control"), ("motion", "identification")];
    let known = known.into_iter().chain([("servo", "parameters"), ("link", "servo")]);
    assert!(known.clone().all(|(of, uses)| core[of].contains(uses)), "{core:?}");
    assert_eq!(circle(&core), None, "these rooms of the core depend on each other in a circle");

    let known = [(".", "cli", "studio"), ("studies", "tuning", "ensemble")];
    let known = [("simulator", "device", "experiment"), ("files", "document", "machine")]
        .into_iter()
        .chain(known);
    for krate in WITH_ROOMS {
        let graph = rooms(&sources(krate));
        for (_, of, uses) in known.clone().filter(|(of, ..)| *of == krate) {
            assert!(graph[of].contains(uses), "{krate}: {graph:?}");
        }
        assert_eq!(circle(&graph), None, "these rooms of {krate} depend on each other in a circle");
    }
}

#[test]
fn no_room_has_methods_for_a_type_of_another() {
    for krate in WITH_ROOMS.into_iter().chain([CORE]) {
        let foreign = foreign_methods(&sources(krate));
        assert_eq!(foreign, [""; 0], "{krate}: these belong into the type's room");
    }
}

#[test]
fn a_circle_is_found_whichever_way_it_is_written() {
    let of = |inner: &str| {
        let files = [
            ("lib.rs", "pub mod a;\nmod b;\nmod c;\nmod d;"),
            ("a.rs", "use crate::b::B;"),
            ("b/mod.rs", "mod inner;\nuse crate::{c::inner::C, d};"),
            ("b/inner.rs", "use super::Shared;"),
            ("c/mod.rs", "mod inner;"),
            ("c/inner.rs", inner),
            ("d.rs", ""),
        ];
        files.map(|(path, text)| (module(path), significant(text))).into()
    };
    for inner in ["use crate::a::A;", "fn f() { super::super::a::f() }", "use crate::{d::D, a};"] {
        let circle_of_files = circle(&files(&of(inner))).unwrap_or_default();
        let names: Vec<_> = circle_of_files.iter().map(|file| file.join("::")).collect();
        assert!(
            ["a", "b", "c::inner"].iter().all(|file| names.contains(&(*file).into())),
            "{names:?}"
        );
        let circle_of_rooms = circle(&rooms(&of(inner))).unwrap_or_default();
        assert_eq!(circle_of_rooms.len(), 3, "{circle_of_rooms:?}");
    }
    let tests = "fn f() {}\n#[cfg(test)]\nmod tests {\n    use crate::a::A;\n}";
    for inner in ["// crate::a", "use super::a::A;", "use crate::c::a::A;", tests] {
        assert_eq!(circle(&files(&of(inner))), None, "{inner}");
        assert_eq!(circle(&rooms(&of(inner))), None, "{inner}");
    }
}

#[test]
fn methods_for_a_type_of_another_room_are_found() {
    let of = |text: &str| {
        let text = format!("\n{text}");
        let files = [("lib.rs", "mod a;\nmod b;"), ("a.rs", "pub struct A;"), ("b.rs", &text)];
        foreign_methods(&files.map(|(path, text)| (module(path), text.to_owned())).into())
    };
    assert_eq!(of("impl A {"), ["A in b"]);
    assert_eq!(of("impl<'a, T: Into<u8>> A<'a, T> {"), ["A in b"]);
    assert_eq!(of("impl Own for A {\nstruct B;\nimpl B {"), [""; 0]);
}

fn sources(krate: &str) -> Sources {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join(krate).join("src");
    let mut sources = Sources::new();
    let mut left = vec![src.clone()];
    while let Some(directory) = left.pop() {
        for entry in std::fs::read_dir(directory).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(&src).unwrap().to_str().unwrap().replace('\\', "/");
            if path.is_dir() {
                left.push(path);
            } else if name.ends_with(".rs") && !name.ends_with("tests.rs") {
                let text = significant(&std::fs::read_to_string(path).unwrap());
                // `lib.rs` and `main.rs` are one.
                let before = sources.entry(module(&name)).or_default();
                before.push_str(&text);
                before.push('\n');
            }
        }
    }
    sources
}

/// Returns a text without comments and unit tests.
fn significant(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// Returns the modules on the way to a file.
fn module(path: &str) -> Module {
    let path = path.trim_end_matches(".rs").trim_end_matches("/mod");
    if ["lib", "main"].contains(&path) {
        vec![]
    } else {
        path.split('/').map(str::to_owned).collect()
    }
}

/// Returns the name at the start of a text.
fn word(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    &text[..end]
}

/// Returns the paths that a text names in its crate, from the crate's root.
fn paths(module: &Module, text: &str) -> Vec<Module> {
    let starts = ["crate::", "super::", "self::"];
    let mut paths = Vec::new();
    for (at, _) in text.match_indices("::").filter(|(at, _)| {
        let before = &text[..*at];
        starts.iter().any(|start| {
            let name = start.trim_end_matches(':');
            before.ends_with(name)
                && !before[..before.len() - name.len()]
                    .ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':')
        })
    }) {
        let first = text[..at].rsplit(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
        let mut base = if first == "crate" { vec![] } else { module.clone() };
        if first == "super" {
            base.pop();
        }
        let mut rest = &text[at + 2..];
        while let Some(above) = rest.strip_prefix("super::") {
            base.pop();
            rest = above;
        }
        branches(&base, rest, &mut paths);
    }
    paths
}

/// Adds the paths of a text such as `a::{b, c::D}`, each behind `base`.
fn branches(base: &[String], text: &str, paths: &mut Vec<Module>) {
    let mut path = base.to_vec();
    let mut rest = text.trim_start();
    loop {
        if let Some(list) = rest.strip_prefix('{') {
            let (mut depth, mut from) = (0, 0);
            for (at, c) in list.char_indices() {
                if depth == 0 && (c == ',' || c == '}') {
                    branches(&path, &list[from..at], paths);
                    from = at + 1;
                    if c == '}' {
                        break;
                    }
                }
                depth += i32::from(c == '{') - i32::from(c == '}');
            }
            return;
        }
        let name = word(rest);
        if name.is_empty() {
            break;
        }
        path.push(name.to_owned());
        match rest[name.len()..].strip_prefix("::") {
            Some(behind) => rest = behind,
            None => break,
        }
    }
    paths.push(path);
}

fn files(sources: &Sources) -> Graph<Module> {
    let of = |module: &Module, text: &String| {
        let named = paths(module, text).into_iter().filter_map(|mut path| {
            while !sources.contains_key(&path) {
                path.pop()?;
            }
            (!module.starts_with(&path)).then_some(path)
        });
        (module.clone(), named.collect())
    };
    sources.iter().map(|(module, text)| of(module, text)).collect()
}

/// Returns the graph of the rooms of a crate.
fn rooms(krate: &Sources) -> Graph<String> {
    let declared = |line: &str| {
        let name = line.trim_start_matches("pub ").strip_prefix("mod ")?.strip_suffix(';')?;
        Some((name.to_owned(), BTreeSet::new()))
    };
    let root = krate.get(&vec![]).cloned().unwrap_or_default();
    let mut graph: Graph<String> = root.lines().filter_map(declared).collect();
    let names: BTreeSet<String> = graph.keys().cloned().collect();
    for (module, text) in krate.iter().filter(|(module, _)| !module.is_empty()) {
        let Some(named) = graph.get_mut(&module[0]) else { continue };
        let others = paths(module, text).into_iter().filter_map(|path| path.into_iter().next());
        named.extend(others.filter(|name| names.contains(name) && *name != module[0]));
    }
    graph
}

/// Returns a way through the graph that ends where it began.
fn circle<T: Clone + Ord>(graph: &Graph<T>) -> Option<Vec<T>> {
    let mut done = BTreeSet::new();
    graph.keys().find_map(|node| circle_from(node, graph, &mut vec![], &mut done))
}

fn circle_from<T: Clone + Ord>(
    node: &T,
    graph: &Graph<T>,
    way: &mut Vec<T>,
    done: &mut BTreeSet<T>,
) -> Option<Vec<T>> {
    if let Some(start) = way.iter().position(|before| before == node) {
        return Some(way.split_off(start));
    }
    if !done.insert(node.clone()) {
        return None;
    }
    way.push(node.clone());
    let found = graph[node].iter().find_map(|next| circle_from(next, graph, way, done));
    way.pop();
    found
}

/// Returns the types, and the modules, of inherent methods that are in another room than their
/// type.
fn foreign_methods(krate: &Sources) -> Vec<String> {
    let room = |module: &Module| module.first().cloned().unwrap_or_default();
    let mut types = BTreeSet::new();
    for (module, text) in krate {
        for keyword in ["struct ", "enum ", "trait "] {
            types.extend(
                text.split(keyword).skip(1).map(|rest| (room(module), word(rest).to_owned())),
            );
        }
    }
    let mut foreign = Vec::new();
    for (module, text) in krate {
        let headers = text.split("\nimpl").skip(1).map(|rest| rest.split('{').next().unwrap_or(""));
        let is_impl = |header: &&str| header.starts_with([' ', '<']);
        for header in headers.filter(is_impl).filter(|header| !header.contains(" for ")) {
            let name = word(after_generics(header).trim_start());
            if !types.contains(&(room(module), name.to_owned())) {
                foreign.push(format!("{name} in {}", module.join("::")));
            }
        }
    }
    foreign
}

/// Returns the text behind the bracket that closes the one at the start, if there is one.
fn after_generics(text: &str) -> &str {
    if !text.starts_with('<') {
        return text;
    }
    let mut depth = 0;
    let end = text.find(|c| {
        depth += i32::from(c == '<') - i32::from(c == '>');
        depth == 0
    });
    end.map_or("", |end| &text[end + 1..])
}
