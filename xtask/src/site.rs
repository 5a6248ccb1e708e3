//! `cargo xtask site` builds the pages as one site: target/site/index.html.
//!
//! The pages of docs/, README.md and the snapshots of tests/evidence/ become a book with search
//! (mdBook). Beside it are the documentation of the core, `api/`, and the studio with its simulated
//! device as static files, `playground/`. Every relative link of the result is followed, and a
//! browser, if one is installed, opens every page.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::process::Command;

use crate::job::{Job, cargo, root, target_dir};
use crate::{playground, studio_page};

/// The program that makes the book. A version of its own, so that all machines make the same site.
const MDBOOK: &str = "0.5.4";

const BOOK: &str = "\
[book]
title = \"stiction\"
language = \"en\"
src = \"src\"

[output.html]
default-theme = \"light\"
preferred-dark-theme = \"navy\"
no-section-label = true
additional-css = [\"wide.css\"]
smart-punctuation = false
";

#[derive(Debug, clap::Args)]
pub struct SiteJobArguments {
    /// Leave the playground out, whose simulator takes minutes to compile for the browser
    #[arg(long)]
    quick: bool,
}

pub fn build(arguments: &SiteJobArguments) -> Result<(), String> {
    let (book, site) = (target_dir().join("site-source"), target_dir().join("site"));
    sources(&book, arguments.quick)?;
    let mdbook = mdbook()?;
    remove(&site)?;
    Job::new("Building the book")
        .run(Command::new(mdbook).arg("build").arg(&book).arg("--dest-dir").arg(&site))?;
    let documentation = target_dir().join("site-api");
    Job::new("Documentation of the core").run(
        cargo(&["doc", "--package", "stiction", "--lib", "--no-deps", "--target-dir"])
            .arg(&documentation),
    )?;
    copy_directory(&documentation.join("doc"), &site.join("api"))?;
    if !arguments.quick {
        copy_directory(&playground::build()?, &site.join("playground"))?;
    }
    let pages = check_links(&site)?;
    match studio_page::browser().filter(|_| studio_page::directory().join("node_modules").exists())
    {
        Some(browser) => Job::new("Every page in a browser")
            .run(studio_page::script("site.mjs", browser).arg(&site))?,
        None => println!("== Every page in a browser: left out, without a browser or npm packages"),
    }
    println!("\n{pages} pages: {}", site.join("index.html").display());
    Ok(())
}

/// Finds mdBook, or installs it into target/tools.
fn mdbook() -> Result<PathBuf, String> {
    let program = target_dir().join("tools/bin/mdbook");
    let version = Command::new(&program).arg("--version").output();
    let is_there = version.is_ok_and(|output| {
        String::from_utf8_lossy(&output.stdout).trim().ends_with(&format!("v{MDBOOK}"))
    });
    if !is_there {
        Job::new("Installing mdBook into target/tools, some minutes").run(
            cargo(&["install", "--locked", "mdbook", "--version", MDBOOK, "--root"])
                .arg(target_dir().join("tools")),
        )?;
    }
    Ok(program)
}

/// Puts the sources of the book together. Links that leave docs/ are bent to where the page is in
/// the book.
fn sources(book: &Path, is_quick: bool) -> Result<(), String> {
    remove(book)?;
    let pages = book.join("src");
    copy_directory(&root().join("docs"), &pages)?;
    copy_directory(&root().join("tests/evidence"), &pages.join("evidence"))?;
    for name in ["README.md", "CHANGELOG.md", "LICENSE-MIT", "LICENSE-APACHE"] {
        write(&pages.join(name), &read(&root().join(name))?)?;
    }
    let bend = |path: PathBuf, from: &str, to: &str| {
        read(&path).and_then(|text| write(&path, &text.replace(from, to)))
    };
    bend(pages.join("README.md"), "](docs/", "](")?;
    bend(pages.join("evidence.md"), "](../tests/evidence/", "](evidence/")?;
    bend(pages.join("evidence.md"), "](../README.md", "](index.md")?;
    let playground = if is_quick {
        "# Try it in your browser\n\n`cargo xtask site` without `--quick` puts the studio with a \
         simulated joint here.\n"
    } else {
        "# Try it in your browser\n\n[The studio](playground/index.html), with a simulated joint. \
         Nothing is sent anywhere, and no motor moves.\n"
    };
    write(&pages.join("try-it.md"), playground)?;
    let api = "# The core's documentation\n\n[The crate `stiction`](api/stiction/index.html): every \
               module with its equation, source, units and limits.\n";
    write(&pages.join("api.md"), api)?;
    // Code blocks of 100 columns fit.
    write(&book.join("wide.css"), ":root { --content-max-width: 940px; }\n")?;
    write(&book.join("book.toml"), BOOK)
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| format!("cannot read {}: {error}", path.display()))
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    fs::write(path, text).map_err(|error| format!("cannot write {}: {error}", path.display()))
}

fn remove(directory: &Path) -> Result<(), String> {
    match fs::remove_dir_all(directory) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(format!("cannot remove {}: {error}", directory.display()))
        }
        _ => Ok(()),
    }
}

/// Returns all files of a directory and of those inside.
fn files(directory: &Path) -> Result<Vec<PathBuf>, String> {
    let cannot = |error: std::io::Error| format!("cannot read {}: {error}", directory.display());
    let mut all = Vec::new();
    for entry in fs::read_dir(directory).map_err(cannot)? {
        let path = entry.map_err(cannot)?.path();
        if path.is_dir() { all.extend(files(&path)?) } else { all.push(path) }
    }
    Ok(all)
}

fn copy_directory(from: &Path, to: &Path) -> Result<(), String> {
    for file in files(from)? {
        let target = to.join(file.strip_prefix(from).unwrap_or(&file));
        let made = target.parent().map_or(Ok(()), fs::create_dir_all);
        made.and_then(|()| fs::copy(&file, &target))
            .map_err(|error| format!("cannot copy {}: {error}", file.display()))?;
    }
    Ok(())
}

/// Follows every relative link of the book, with its anchor, and returns the number of its pages.
/// The documentation of the core is checked by rustdoc, and the playground by its own test.
fn check_links(site: &Path) -> Result<usize, String> {
    let own = |file: &PathBuf| {
        let path = file.strip_prefix(site).unwrap_or(file);
        path.extension().is_some_and(|end| end == "html")
            // A server shows 404.html at any path, so that its links are absolute.
            && !["api", "playground", "404.html"].iter().any(|other| path.starts_with(other))
    };
    let pages: Vec<PathBuf> = files(site)?.into_iter().filter(own).collect();
    let mut names: BTreeMap<PathBuf, BTreeSet<String>> = BTreeMap::new();
    let mut texts = Vec::new();
    for page in &pages {
        let text = read(page)?;
        names.insert(page.clone(), after(&text, " id=\"").map(str::to_owned).collect());
        texts.push(text);
    }
    let mut broken = Vec::new();
    for (page, text) in pages.iter().zip(&texts) {
        for link in after(text, " href=\"").chain(after(text, " src=\"")) {
            if link.contains(':') || link.starts_with("//") || link.starts_with('#') && link == "#"
            {
                continue;
            }
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() {
                page.clone()
            } else {
                normal(&page.parent().unwrap_or(site).join(file))
            };
            let is_there = target.is_file() || target.join("index.html").is_file();
            let is_named =
                anchor.is_empty() || names.get(&target).is_none_or(|names| names.contains(anchor));
            if !is_there || !is_named {
                broken.push(format!("{}: {link}", page.display()));
            }
        }
    }
    broken.sort();
    broken.dedup();
    if broken.is_empty() {
        Ok(pages.len())
    } else {
        Err(format!("{} links lead nowhere:\n{}", broken.len(), broken.join("\n")))
    }
}

/// Returns what stands behind each mark, up to the next quotation mark.
fn after<'a>(text: &'a str, mark: &'a str) -> impl Iterator<Item = &'a str> {
    text.split(mark).skip(1).filter_map(|rest| rest.split('"').next())
}

/// Returns a path without `.` and `..`.
fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                normal.pop();
            }
            Component::CurDir => {}
            other => normal.push(other),
        }
    }
    normal
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_and_paths_are_read_as_a_browser_does() {
        let text = "<a href=\"a/../b.html#c\">x</a> <img src=\"d.png\">";
        assert_eq!(after(text, " href=\"").collect::<Vec<_>>(), ["a/../b.html#c"]);
        assert_eq!(after(text, " src=\"").collect::<Vec<_>>(), ["d.png"]);
        assert_eq!(normal(Path::new("/s/a/../b/./c.html")), Path::new("/s/b/c.html"));
    }
}
