//! The modules of the simulator's crates depend on each other one way, as ARCHITECTURE.md draws it.
//!
//! A room is a module that a crate's `lib.rs` declares, with everything inside of it. It depends on
//! the rooms that its sources name by `crate::` or `super::`, whatever features are on, in tests as
//! well: the crates name those of each other so, too. Cargo keeps the crates without a circle.
//! Comments may point anywhere. A method for a type of another room would be called from there
//! without a path, so that it is refused, too. Blind to what a macro or a trait object brings in.
#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Where the simulator's crates stand.
const CRATES: [&str; 6] = [".", "dynamics", "files", "simulator", "emulated", "studies"];

/// A source by its path inside of its crate's `src/`, and its text without comments; the `lib.rs`
/// of all crates are one.
type Sources = BTreeMap<String, String>;

/// For each room, the rooms that it names.
type Graph = BTreeMap<String, BTreeSet<String>>;

#[test]
fn no_room_depends_on_one_that_depends_on_it() {
    let sources = sources();
    let graph = graph(&sources);
    assert!(graph.len() > 20 && graph["run"].contains("experiment"), "{graph:?}");
    let known = [("device", "joint"), ("emulator", "device"), ("tuning", "ensemble")];
    let known = known.into_iter().chain([("document", "machine"), ("cli", "studio")]);
    assert!(known.clone().all(|(of, uses)| graph[of].contains(uses)), "{graph:?}");
    assert_eq!(circle(&graph), None, "these rooms depend on each other in a circle");
}

#[test]
fn no_room_has_methods_for_a_type_of_another() {
    assert_eq!(foreign_methods(&sources()), [""; 0], "these belong into the room of their type");
}

#[test]
fn a_circle_is_found_whichever_way_it_is_written() {
    let lib = "pub mod a;\nmod b;\nmod c;\nmod d;";
    let of = |inner: &str| {
        let files =
            [("a.rs", "use crate::b::B;"), ("b/mod.rs", "use crate::c;"), ("c/inner.rs", inner)];
        let files = files.into_iter().chain([("lib.rs", lib), ("d.rs", "crate::a::A")]);
        graph(&files.map(|(path, text)| (path.to_owned(), without_comments(text))).collect())
    };
    for inner in ["use crate::a::A;", "fn f() { super::super::a::f() }", "crate::d::D"] {
        let found = circle(&of(inner)).unwrap_or_default();
        assert!(
            ["a", "b", "c"].iter().all(|room| found.iter().any(|name| name == room)),
            "{found:?}"
        );
    }
    for inner in ["// crate::a", "use super::a::A;", "use crate::c::a::A;", "crate::another::A"] {
        assert_eq!(circle(&of(inner)), None, "{inner}");
    }
}

#[test]
fn methods_for_a_type_of_another_room_are_found() {
    let of = |text: &str| {
        let files = [("a.rs", "pub struct A;"), ("b.rs", text), ("lib.rs", "mod a;\nmod b;")];
        foreign_methods(&files.map(|(path, text)| (path.to_owned(), text.to_owned())).into())
    };
    assert_eq!(of("impl A {"), ["A in b.rs"]);
    assert_eq!(of("impl<'a, T: Into<u8>> A<'a, T> {"), ["A in b.rs"]);
    assert_eq!(of("impl Own for A {\nstruct B;\nimpl B {"), [""; 0]);
}

fn sources() -> Sources {
    let mut sources = Sources::new();
    for krate in CRATES {
        let src = Path::new(env!("CARGO_MANIFEST_DIR")).join(krate).join("src");
        let mut left = vec![src.clone()];
        while let Some(directory) = left.pop() {
            for entry in std::fs::read_dir(directory).unwrap() {
                let path = entry.unwrap().path();
                let name = path.strip_prefix(&src).unwrap().to_str().unwrap().replace('\\', "/");
                if path.is_dir() {
                    left.push(path);
                } else if name.ends_with(".rs") {
                    let text = without_comments(&std::fs::read_to_string(path).unwrap());
                    let before = sources.entry(name.clone()).or_default();
                    assert!(before.is_empty() || name == "lib.rs", "{name} is in two crates");
                    *before += &text;
                    *before += "\n";
                }
            }
        }
    }
    sources
}

fn without_comments(text: &str) -> String {
    text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// The modules on the way to a source, `["solver", "exact"]`.
fn module(path: &str) -> Vec<&str> {
    path.trim_end_matches(".rs").trim_end_matches("/mod").split('/').collect()
}

/// The name that a text begins with.
fn word(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    &text[..end]
}

fn graph(sources: &Sources) -> Graph {
    let declared = |line: &str| {
        let name = line.trim_start_matches("pub ").strip_prefix("mod ")?.strip_suffix(';')?;
        Some((name.to_owned(), BTreeSet::new()))
    };
    let mut graph: Graph = sources["lib.rs"].lines().filter_map(declared).collect();
    let rooms: BTreeSet<String> = graph.keys().cloned().collect();
    for (path, text) in sources {
        let module = module(path);
        let Some(named) = graph.get_mut(module[0]) else { continue };
        assert!(
            !text.contains("crate::{"),
            "{path}: one `use` for each room, so that this test sees them"
        );
        let absolute = text.split("crate::").skip(1).map(word);
        // Inside of `mod tests` this is one level too many: then the name is one of the room
        // itself.
        let up = "super::".repeat(module.len());
        let relative = text.split(&up).skip(1).map(word);
        let others =
            absolute.chain(relative).filter(|name| rooms.contains(*name) && *name != module[0]);
        named.extend(others.map(str::to_owned));
    }
    graph
}

/// A way through the graph that ends where it began.
fn circle(graph: &Graph) -> Option<Vec<String>> {
    let mut done = BTreeSet::new();
    graph.keys().find_map(|room| circle_from(room, graph, &mut vec![], &mut done))
}

fn circle_from(
    room: &str,
    graph: &Graph,
    way: &mut Vec<String>,
    done: &mut BTreeSet<String>,
) -> Option<Vec<String>> {
    if let Some(begin) = way.iter().position(|before| before == room) {
        return Some(way.split_off(begin));
    }
    if !done.insert(room.to_owned()) {
        return None;
    }
    way.push(room.to_owned());
    let found = graph[room].iter().find_map(|next| circle_from(next, graph, way, done));
    way.pop();
    found
}

/// The types, and the sources, of inherent methods that stand in another room than their type.
fn foreign_methods(sources: &Sources) -> Vec<String> {
    let room = |path: &str| module(path)[0].to_owned();
    let mut types = BTreeSet::new();
    for (path, text) in sources {
        for keyword in ["struct ", "enum ", "trait "] {
            types.extend(
                text.split(keyword).skip(1).map(|rest| (room(path), word(rest).to_owned())),
            );
        }
    }
    let mut foreign = Vec::new();
    for (path, text) in sources {
        for line in text.lines().filter(|line| line.starts_with("impl") && !line.contains(" for "))
        {
            let name = word(after_generics(line.trim_start_matches("impl")).trim_start());
            if !types.contains(&(room(path), name.to_owned())) {
                foreign.push(format!("{name} in {path}"));
            }
        }
    }
    foreign
}

/// What stands behind the bracket that closes the one at the begin, if there is one.
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
