//! `cargo xtask ranking` ranks untuned laws on random joints. It writes the table of README.md,
//! where every law makes the same profiled move, and that of tests/evidence/ranking.md, where the
//! set point steps.
//!
//! Each table is between two comments of its page, and is made of the output of `stiction ensemble
//! --markdown`: success on each family at the encoder, that of a real gear at the load as well,
//! then some rows of rest and of tracking. README.md has the instructions of tests/evidence/cost.md
//! as well, and the slowest speed without steps, of `stiction ensemble follow`. So no figure of a
//! table is older than the last run.

use std::fs;
use std::process::Stdio;

use crate::job::{Job, root};
use crate::simulator::Simulator;

const COST: &str = "tests/evidence/cost.md";

/// How the set point goes to the target, and the page with its table: the move of a user first.
const PAGES: [(&str, &str); 2] = [("profiled", "README.md"), ("step", "tests/evidence/ranking.md")];

const BEGIN: &str = "<!-- ranking: written by `cargo xtask ranking` -->\n";
const END: &str = "<!-- end of the ranking -->";

/// A seed on which nothing was tuned, and a number of joints for which the widest interval is 9 %.
/// Joints with a load and with a stiffer gear are within the intervals of others here. Arms have a
/// row in tests/evidence/robust.md.
const RUN: [&str; 9] = [
    "ensemble",
    "--plant",
    "rigid,gravity,overhauling,lugre,flexible-backlash,gear-backlash,flexible-load,\
     two-encoders-backlash,thesis-axis",
    "--cases",
    "500",
    "--seed",
    "2028",
    "--controller",
    "pd,pid,srnf,feedforward+observer,two-reset-pid,impulsive,robust",
];

/// Ramps of the first hundred of these joints under the same laws: nine of ten have to follow.
const RAMPS: [&str; 10] = [
    "ensemble",
    "follow",
    "--plant",
    "rigid,flexible-backlash",
    "--cases",
    "100",
    "--seed",
    "2028",
    "--controller",
    "pd,pid,srnf,feedforward+observer,two-reset-pid,impulsive,robust",
];

/// The side of success without a label: the page names it above the table.
const AT_ENCODER: &str = ", at the encoder";

/// Rows of the load that are left out, to keep the page short.
const AT_LOAD: &str = ", at the load";

/// The family whose row of the load stays.
const GEAR: &str = "| `gear-backlash`";

/// Rows beside those of success: the start of each as the command prints it.
const MORE: [&str; 2] = ["`thesis-axis`: rest", "`thesis-axis`: tracking"];

/// Start of a law's line in tests/evidence/cost.md; `None` for a sum, and for laws that the image
/// does not have.
const COSTED: [&str; 7] = ["pd", "", "srnf", "", "", "", "robust"];

pub fn rank() -> Result<(), String> {
    let job = Job::new("500 joints of each family under seven laws, twice; some minutes");
    job.announce();
    Simulator::Host.build()?;
    for (motion, page) in PAGES {
        let mut table =
            table(&printed(&[&RUN[..], &["--motion", motion, "--markdown"]].concat())?)?;
        if motion == "profiled" {
            table += &slowest(&printed(&[&RAMPS[..], &["--markdown"]].concat())?)?;
            table += &costs(&read(COST)?)?;
        }
        let text = put(page, &read(page)?, &table)?;
        fs::write(root().join(page), text)
            .map_err(|error| format!("cannot write {page}: {error}"))?;
        println!("{page}: the table is that of `stiction {} --motion {motion}`", RUN.join(" "));
    }
    Ok(())
}

/// Returns what the simulator prints.
fn printed(arguments: &[&str]) -> Result<String, String> {
    let output = Simulator::Host
        .command(arguments)
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| format!("cannot start cargo: {error}"))?;
    if !output.status.success() {
        return Err(format!("`stiction {}` failed", arguments.join(" ")));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Returns a row for each family, from the table that has one for each law.
fn slowest(by_law: &str) -> Result<String, String> {
    let cells = |line: &str| -> Vec<String> {
        line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect()
    };
    let mut lines = by_law.lines();
    let families = lines.next().map(cells).ok_or("the ramps have printed no table")?;
    let laws: Vec<Vec<String>> = lines.skip(1).map(cells).collect();
    let row = |(column, family): (usize, &String)| {
        let of_laws: Vec<&str> =
            laws.iter().filter_map(|law| law.get(column)).map(String::as_str).collect();
        format!("| `{family}`: slowest without steps, counts/s | {} |\n", of_laws.join(" | "))
    };
    Ok(families.iter().enumerate().skip(1).map(row).collect())
}

fn read(name: &str) -> Result<String, String> {
    fs::read_to_string(root().join(name)).map_err(|error| format!("cannot read {name}: {error}"))
}

/// Returns success, then the rows of [`MORE`].
fn table(tables: &str) -> Result<String, String> {
    let (success, others) =
        tables.split_once("\n\n").ok_or("`stiction ensemble` has printed no second table")?;
    let is_shown = |row: &&str| !row.contains(AT_LOAD) || row.starts_with(GEAR);
    let mut text = String::new();
    for row in success.lines().filter(is_shown) {
        text += &(row.replacen(AT_ENCODER, "", 1) + "\n");
    }
    for wanted in MORE {
        let begin = format!("| {wanted}");
        let row = others.lines().find(|line| line.starts_with(&begin));
        text += row.ok_or_else(|| {
            format!(
                "`stiction ensemble` has printed no row {wanted}; if the row has another name now, \
                 change MORE in xtask/src/ranking.rs"
            )
        })?;
        text += "\n";
    }
    Ok(text)
}

/// Returns the row of instructions.
fn costs(cost: &str) -> Result<String, String> {
    let of = |law: &str| match law {
        "" => Ok("-".to_owned()),
        law => {
            instructions(cost, law).ok_or_else(|| format!("{COST} has no instructions of {law}"))
        }
    };
    let cells = COSTED.into_iter().map(of).collect::<Result<Vec<_>, String>>()?;
    Ok(format!("| instructions a tick, at most | {} |\n", cells.join(" | ")))
}

/// Returns the most instructions of the core's tick under a law: the fourth word of its line.
fn instructions(cost: &str, law: &str) -> Option<String> {
    let lines = cost.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    let mut of_law = lines.filter(|words| words.first() == Some(&law) && words.len() == 8);
    of_law.next().and_then(|words| words.get(3).map(|word| (*word).to_owned()))
}

/// Puts the table between the two comments of a page's text.
fn put(page: &str, text: &str, table: &str) -> Result<String, String> {
    let gone = || format!("{page} lacks the comments around its table");
    let (before, rest) = text.split_once(BEGIN).ok_or_else(gone)?;
    let (_, after) = rest.split_once(END).ok_or_else(gone)?;
    Ok(format!("{before}{BEGIN}{table}{END}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLES: &str = "| joints | `pd` |\n|---|---|\n| `rigid` | 0.0 (0-1) |\n\n| joints | `pd` \
                          |\n|---|---|\n| `rigid`: rest, counts | 96 |\n| `thesis-axis`: rest, \
                          counts | 59 |\n\n| `rigid`: tracking, mrad | 7 |\n| `thesis-axis`: \
                          tracking, deg | 0.5 |\n";

    const COSTS: &str = "pd 309 349.4 395 892 944.4 1086 0\nsrnf 363 456.2 515 937 1053.1 1200 0\n\
                         robust 582 636.1 974 1155 1234.8 1619 160\n";

    #[test]
    fn the_table_has_success_first_and_instructions_last() {
        let made = table(TABLES).unwrap() + &costs(COSTS).unwrap();
        let lines: Vec<&str> = made.lines().collect();
        assert_eq!(lines[2], "| `rigid` | 0.0 (0-1) |");
        assert_eq!(lines[3], "| `thesis-axis`: rest, counts | 59 |");
        assert_eq!(lines[5], "| instructions a tick, at most | 395 | - | 515 | - | - | - | 974 |");
        assert!(costs("pd 1 2\n").unwrap_err().contains("instructions of pd"));
    }

    #[test]
    fn success_is_the_encoder_s_and_a_real_gear_has_a_row_of_its_load() {
        let row = |family: &str, side: &str| format!("| `{family}`, at the {side} | 1.0 (0-2) |\n");
        let both = |family: &str| row(family, "encoder") + &row(family, "load");
        let rows = both("flexible-backlash") + &both("gear-backlash");
        let tables = TABLES.replacen("| `rigid` | 0.0 (0-1) |\n", &rows, 1);
        let made = table(&tables).unwrap();
        let lines: Vec<&str> = made.lines().skip(2).take(3).collect();
        let expected = [
            "| `flexible-backlash` | 1.0 (0-2) |",
            "| `gear-backlash` | 1.0 (0-2) |",
            "| `gear-backlash`, at the load | 1.0 (0-2) |",
        ];
        assert_eq!(lines, expected);
    }

    #[test]
    fn ramps_have_a_row_for_each_family() {
        let by_law =
            "| law | rigid | lugre |\n|---|---|---|\n| pd | none | none |\n| robust | 1 | 3 |\n";
        let expected = "| `rigid`: slowest without steps, counts/s | none | 1 |\n\
                        | `lugre`: slowest without steps, counts/s | none | 3 |\n";
        assert_eq!(slowest(by_law).unwrap(), expected);
        assert!(slowest("").is_err());
    }

    #[test]
    fn what_stands_around_the_table_stays() {
        let page = format!("a\n{BEGIN}old\n{END}\nb\n");
        let made = put("page", &page, "new\n").unwrap();
        assert_eq!(made, format!("a\n{BEGIN}new\n{END}\nb\n"));
        assert!(put("page", "a\n", "new\n").is_err());
    }
}
