//! The golden table: the fenced block of `tests/evidence/cost.md`, with which measured costs are
//! compared.

use std::fs;
use std::path::Path;

use files::Error;

const FENCE: &str = "```text\n";
const END: &str = "```\n";
/// Start of the line that is not compared. The flash holds the paths of the sources, so its size
/// depends on the directory of the checkout; a budget limits it instead.
const NOT_COMPARED: &str = "flash ";
const COMPILER: &str = "compiler ";

/// Replaces the table in the page.
pub fn bless(page: &Path, table: &str) -> Result<(), Error> {
    let text = read(page)?;
    let (before, _, after) = split(page, &text)?;
    fs::write(page, format!("{before}{FENCE}{table}{END}{after}"))
        .map_err(|source| Error::File { action: "write", path: page.into(), source })?;
    println!("\nwritten to {}", page.display());
    Ok(())
}

/// Refuses a table that differs from that of the page, if both name the same compiler.
pub fn compare(page: &Path, table: &str) -> Result<(), Error> {
    let text = read(page)?;
    let (_, golden, _) = split(page, &text)?;
    let compiler =
        |table: &str| table.lines().find_map(|line| line.strip_prefix(COMPILER)).map(str::to_owned);
    if compiler(golden) != compiler(table) {
        println!(
            "\nNot compared with {}, whose figures another compiler made ({}); the budgets are \
             kept.",
            page.display(),
            compiler(golden).unwrap_or_else(|| "not recorded".into())
        );
        return Ok(());
    }
    let difference = difference(golden, table);
    if difference.is_empty() {
        println!("\nThe same as in {}.", page.display());
        return Ok(());
    }
    Err(Error::Emulator(format!(
        "the cost differs from {}:\n{difference}if this is intended, `cargo xtask cost --bless` \
         replaces the table; review it with the change",
        page.display()
    )))
}

/// Returns the lines that differ: `-` is only in the page, `+` only in the new table.
fn difference(golden: &str, table: &str) -> String {
    let lines = |text: &str| -> Vec<String> {
        text.lines().filter(|line| !line.starts_with(NOT_COMPARED)).map(str::to_owned).collect()
    };
    let (golden, table) = (lines(golden), lines(table));
    let gone = golden.iter().filter(|line| !table.contains(line)).map(|line| format!("- {line}\n"));
    let new = table.iter().filter(|line| !golden.contains(line)).map(|line| format!("+ {line}\n"));
    gone.chain(new).collect()
}

fn read(page: &Path) -> Result<String, Error> {
    fs::read_to_string(page).map_err(|source| Error::File {
        action: "read",
        path: page.into(),
        source,
    })
}

fn split<'a>(page: &Path, text: &'a str) -> Result<(&'a str, &'a str, &'a str), Error> {
    let parts = text.split_once(FENCE).and_then(|(before, rest)| {
        let (golden, after) = rest.split_once(END)?;
        Some((before, golden, after))
    });
    parts.ok_or_else(|| Error::Input(format!("{}: no block begins with ```text", page.display())))
}
